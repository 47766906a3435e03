"""Parents feed their young: hand-counted transfers, the ledger of energy, the action, refusals."""

import numpy as np
import pytest

from ecs_eco.components import Metabolism, Traits
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record.ledger import LEDGER, imbalance
from ecs_eco.systems import Nurse
from ecs_eco.testing import act, arrange, check_system

CARE = {"rate": 0.125, "reach": 1.0, "age_max": 10.0, "reserve": 0.25}


def family(meadow, n=4, mother=(0, 1, 1, 1), father=(0, 0, 0, 0), **more):
    """Deer in one place; whose parents are given by their places, from 1."""
    world = meadow(**{"count": n, "care": CARE, "metabolism": {"basal": 0.0}} | more)
    deer = world.tables["deer"]
    uid = np.concatenate([[0], deer.uid[deer.by_uid()]])
    arrange(
        world,
        "deer",
        x=5.0,
        y=5.0,
        energy=0.5,
        age=[20.0] + [1.0] * (n - 1),
        mother=uid[list(mother)],
        father=uid[list(father)],
    )
    return world


def books(world):
    """Energy, taken, given and burnt in the order of uids."""
    deer = world.tables["deer"]
    rows = deer.by_uid()
    m = deer[Metabolism]
    return [column[rows].tolist() for column in (m.energy, m.taken, m.given, m.burnt)]


@pytest.mark.definition("3 parental care")
def test_a_mother_feeds_her_young_at_the_rate(meadow):
    world = family(meadow, 3, (0, 1, 0), (0, 0, 0))
    act(world, Nurse)
    assert books(world) == [[0.375, 0.625, 0.5], [0, 0.125, 0], [0.125, 0, 0], [0, 0, 0]]


def test_what_she_holds_beyond_her_reserve_is_shared_alike(meadow):
    world = family(meadow)  # three want 0.375, 0.25 is there
    act(world, Nurse)
    energy, taken, given, _ = books(world)
    assert energy == pytest.approx([0.25] + [0.5 + 0.25 / 3] * 3)
    assert sum(taken) == pytest.approx(0.25)
    assert given == pytest.approx([0.25, 0, 0, 0])
    act(world, Nurse)
    assert books(world)[0] == pytest.approx(energy)


def test_each_takes_what_it_has_room_for(meadow):
    world = family(meadow)
    arrange(world, "deer", energy=[1.0, 1.0, 0.9375, 0.5])
    act(world, Nurse)
    assert books(world)[0] == [1.0 - 0.0625 - 0.125, 1.0, 1.0, 0.625]


def test_neither_the_grown_nor_the_far_nor_the_dying_are_fed(meadow):
    world = family(meadow)
    deer = arrange(world, "deer", age=[20, 10, 9.9, 1], x=[5, 5, 7.01, 7.0])
    act(world, Nurse)
    assert books(world)[0] == [0.375, 0.5, 0.5, 0.625]
    deer.cause[deer.by_uid()[3]] = 1
    act(world, Nurse)
    assert books(world)[0] == [0.375, 0.5, 0.5, 0.625]
    deer.cause[deer.by_uid()[[0, 3]]] = 1, 0
    act(world, Nurse)
    assert books(world)[0] == [0.375, 0.5, 0.5, 0.625]


def test_what_does_not_arrive_is_burnt(meadow):
    world = family(meadow, 2, (0, 1), (0, 0), care=CARE | {"efficiency": 0.5})
    act(world, Nurse)
    assert books(world) == [[0.375, 0.5625], [0, 0.0625], [0.0625, 0], [0.0625, 0]]


@pytest.mark.parametrize(
    ("by", "energy"),
    [("mother", [0.375, 0.5, 0.625]), ("father", [0.5, 0.375, 0.625]), ("both", [0.375, 0.375, 0.75])],
)
def test_mother_father_or_both_feed(meadow, by, energy):
    world = family(meadow, 3, (0, 0, 1), (0, 0, 2), care=CARE | {"by": by})
    arrange(world, "deer", age=[20, 20, 1])
    act(world, Nurse)
    assert books(world)[0] == energy


def test_a_young_mother_does_not_give_what_she_gets(meadow):
    world = family(meadow, 3, (0, 1, 2), (0, 0, 0))
    arrange(world, "deer", energy=[0.5, 0.25, 0.5])
    act(world, Nurse)
    assert books(world)[0] == [0.375, 0.375, 0.5]


def test_with_an_action_she_feeds_when_she_decides_to(meadow):
    world = family(meadow, 2, (0, 1), (0, 0), actions={"nurse": ["nurse"]})
    column = world.tables["deer"].species.nerves.column("nurse")
    for does, energy in (0, 0.5), (1, 0.625):
        decision = np.zeros((2, 8), int)
        decision[0, column] = does
        arrange(world, "deer", decision=decision)
        act(world, Nurse)
        assert books(world)[0][1] == energy


def test_the_ledger_of_energy_closes(meadow):
    way = {"kind": "asexual", "rate": 0.1, "energy_min": 0.4, "energy_given": 0.05, "dispersal": 3.0}
    world = meadow(
        count=8,
        body={"opaque": False},
        reproduction=way,
        care=CARE | {"rate": 0.02, "efficiency": 0.8, "reserve": 0.1, "reach": 4.0},
    ).run(30)
    page = {name: np.array(world.series()[name].to_pylist()) for name in LEDGER}
    assert page["taken_in"].sum() > 0.2
    assert np.abs(imbalance(page)).max() < 1e-6


def test_the_system_keeps_the_rules(meadow):
    check_system(
        Nurse,
        lambda threads: family(
            meadow, 30, (0, *[1, 2, 3] * 9, 1, 2), (0,) * 30, options={"threads": threads}
        ),
    )


def test_who_does_not_care_has_no_action_for_it_and_no_system(meadow):
    with pytest.raises(ConfigError, match="it has no care"):
        meadow(actions={"nurse": ["nurse"]})
    assert not any(isinstance(s, Nurse) for s in meadow().systems)
    with pytest.raises(ConfigError, match=r"care\.efficiency"):
        meadow(care=CARE | {"efficiency": 0.0})


@pytest.mark.definition("3 genome encodes")
def test_each_parent_cares_as_its_own_genes_say(meadow):
    genes = [
        {"name": name, "letters": 1, "trait": f"care.{name}", "values": values}
        for name, values in (("rate", [0.125, 0.25]), ("until", [2.0, 10.0]), ("efficiency", [1.0, 0.5]))
    ]
    world = family(meadow, 4, (0, 0, 1, 2), genome={"alphabet": "01", "genes": genes})
    deer = world.tables["deer"]
    own = deer[Traits].value
    own[deer.by_uid()] = [[0.125, 2.0, 1.0], [0.25, 10.0, 0.5], [0.0625, 1.0, 1.0], [0.0625, 1.0, 1.0]]
    arrange(world, "deer", energy=0.5, age=[20, 20, 1, 1])
    act(world, Nurse)  # the first gives 0.125; the second 0.25, of which half arrives
    assert books(world) == [
        [0.375, 0.25, 0.625, 0.625],
        [0, 0, 0.125, 0.125],
        [0.125, 0.125, 0, 0],
        [0, 0.125, 0, 0],
    ]
    arrange(world, "deer", energy=0.5, age=[20, 20, 3, 3])
    act(world, Nurse)  # the first feeds until 2 s, the second until 10 s
    assert books(world)[0] == [0.5, 0.25, 0.5, 0.625]
