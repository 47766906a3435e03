"""What each species gained by eating each other has columns in the series: part of what it took in."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.analysis.runs import load_series
from ecs_eco.config import load
from ecs_eco.config.models.reporters import EATEN
from ecs_eco.record.ledger import LEDGER

GOATS = {
    "space.size": [30, 30],
    "species.goat.count": 40,
    "species.green.count": 150,
    "species.yellow.count": 80,
    "species.red.count": 10,
}


@pytest.fixture
def goats():
    return World.from_config(load("reflexes", GOATS), seed=3, policies="untrained", learn=False)


def test_what_goats_gained_from_each_grass_adds_up_to_what_they_took_in(goats):
    goats.run(60)
    series = load_series(goats.series())
    foods = {food: series.of("goat", EATEN + food) for food in ("red", "yellow", "green")}
    assert foods["green"].sum() > 0 > foods["yellow"].sum()
    assert not foods["red"].any()
    assert sum(foods.values()) == pytest.approx(series.of("goat", "taken_in"), abs=1e-5)
    assert not series.of("green", "eaten: green").any()
    assert series.reporters == ()


def test_each_meal_of_green_gives_what_the_diet_says_unless_the_goat_is_full(goats):
    goats.run(60)
    series = load_series(goats.series())
    meals = series.of("green", "died: eaten by goat")
    assert meals.sum() > 5
    gained = series.of("goat", "eaten: green")
    assert (gained <= 0.12 * meals + 1e-5).all()
    assert gained.sum() > 0.06 * meals.sum()


def test_sums_are_those_of_the_columns(goats):
    goats.run(30)
    series, intake = load_series(goats.series()), goats.recorder.intake
    goat = goats.recorder.place["goat"]
    assert dict(zip(intake.foods, intake.total[goat], strict=True)) == pytest.approx(
        {food: series.of("goat", EATEN + food).sum() for food in intake.foods}
    )
    assert intake.flows[goat, LEDGER.index("burnt")] == pytest.approx(series.of("goat", "burnt").sum())


def test_a_checkpoint_in_between_changes_no_column(goats, tmp_path):
    goats.run(30)
    goats.save(tmp_path / "half.eco")
    goats.run(30)
    again = World.from_config(load("reflexes", GOATS), seed=3, policies="untrained", learn=False)
    again.load(tmp_path / "half.eco")
    again.run(30)
    for name in (EATEN + "yellow", EATEN + "green", "taken_in"):
        assert np.array_equal(
            load_series(again.series()).of("goat", name), load_series(goats.series()).of("goat", name)
        )


def test_a_record_that_began_without_these_columns_goes_on_with_zeros_before(goats):
    goats.run(10)
    goats.recorder.flush()
    for block in goats.recorder._blocks:
        for name in [name for name in block if name.startswith(EATEN)]:
            del block[name]
    goats.run(10)
    gained = load_series(goats.series()).of("goat", EATEN + "green")
    assert gained.shape == (20,)
    assert gained[10:].any() > gained[:10].any()
