"""Who died out, when and of what: said first, and counted by hand."""

import numpy as np
import pytest

from ecs_eco.analysis.extinction import decline, declines, lifetime, multiplies, opening, shared, swings
from ecs_eco.analysis.runs import Series, load_series


def run(
    deer: list[int],
    wolf: list[int],
    starved: list[int],
    eaten: list[int],
    births: list[int],
    **manifest: object,
) -> Series:
    """A run of deer and wolves; deaths and births are those of the deer."""
    zero = np.zeros(len(deer))
    died = np.add(starved, eaten)
    columns = {"n": (deer, wolf), "births": (births, zero), "deaths": (died, zero)}
    columns |= {"died: starved": (starved, zero), "died: eaten by wolf": (eaten, zero)}
    return Series(
        np.arange(len(deer)),
        ("deer", "wolf"),
        {k: np.array(v, float).T for k, v in columns.items()},
        dict(manifest),
    )


@pytest.fixture
def lost() -> Series:
    return run([10, 8, 4, 1, 0, 0], [2] * 6, [0, 1, 4, 2, 0, 0], [0, 1, 1, 1, 1, 0], [0, 0, 1, 0, 0, 0])


def test_an_end_is_told_from_the_last_tick_with_half_of_the_greatest_number(lost: Series) -> None:
    end = decline(lost, "deer")
    assert end is not None
    assert (end.tick, end.since, end.n, end.births, end.deaths) == (4, 1, 8, 1, 9)
    assert end.causes == {"starved": 6, "eaten by wolf": 3}
    assert end.shares() == "starved 67%, eaten by wolf 33%"
    assert decline(lost, "wolf") is None
    assert [d.species for d in declines(lost)] == ["deer"]
    assert lifetime(lost) == (4.0, True)


def test_a_report_opens_with_who_persisted(lost: Series) -> None:
    assert opening(lost) == [
        "1 of 2 species died out; wolf persisted to tick 6.",
        "deer died out at tick 4. At tick 1, there were 8; 1 birth and 9 deaths followed: starved 67%, "
        "eaten by wolf 33%.",
    ]
    alive = run([5] * 4, [2] * 4, [0] * 4, [0] * 4, [0] * 4)
    assert opening(alive) == ["All 2 species persisted to tick 4."]
    assert lifetime(alive) == (4.0, False)
    nobody = run([1, 0], [1, 0], [0, 1], [0, 0], [0, 0])
    assert opening(nobody)[0] == "All 2 species died out; no organism is alive at the end (tick 2)."


def test_an_end_that_was_to_be_expected_is_called_so() -> None:
    config = {
        "species": {
            "deer": {"reproduction": None},
            "wolf": {"reproduction": {"kind": "asexual", "place": "anywhere"}},
        }
    }
    barren = run([1, 0], [2, 2], [0, 1], [0, 0], [0, 0], config=config)
    assert opening(barren)[-1] == "deer cannot reproduce in this world, so its extinction was expected."
    assert (multiplies(barren, "deer"), multiplies(barren, "wolf")) == (False, True)
    born = run([2, 0], [2, 2], [0, 2], [0, 0], [1, 0], config=config)  # by a system of the world's own
    assert multiplies(born, "deer")
    assert len(opening(born)) == 2


def test_a_species_that_dies_within_the_first_tick_is_not_hidden() -> None:
    gone = run([0, 0], [2, 2], [7, 0], [0, 0], [0, 0])
    assert not gone.persisted
    assert (
        opening(gone)[1] == "deer died out at tick 0. At tick 0, there were 7; "
        "0 births and 7 deaths followed: starved 100%."
    )


def test_several_runs_open_with_the_share_that_persisted(lost: Series) -> None:
    alive = run([5] * 6, [2] * 6, [0] * 6, [0] * 6, [0] * 6)
    later = run([10, 10, 10, 10, 9, 0], [2] * 6, [0] * 6, [0, 0, 0, 0, 1, 9], [0] * 6)
    assert shared([alive]) == "All species persisted in 1 of 1 run (100%)."
    assert shared([alive, lost, later]) == (
        "All species persisted in 1 of 3 runs (33%). deer died out in 2 of 3, "
        "at ticks 4 to 5 (eaten by wolf 67%, starved 33%)."
    )


def test_the_largest_rise_or_fall_of_each_living_species_is_told():
    hare = [30, 20, 90, 60, 25]  # the rise from 20 is 4.5-fold, the fall from 90 is 3.6-fold
    owl = [100, 40, 50, 20, 30]
    vole = [2, 19, 1, 2, 3]  # few: chance
    series = load_series({"vole": vole, "owl": owl, "hare": hare, "newt": [40, 9, 1, 0, 0]})
    assert swings(series) == [
        "Owl fell from 100 at tick 0 to 20 at tick 3, 20% as many.",
        "Hare rose from 20 at tick 1 to 90 at tick 2, 4.5 times as many.",
    ]
    assert swings(series, most=1) == swings(series)[:1]
    assert swings(load_series({"hare": [30, 40, 50]})) == []
