"""Herds that mate and give birth for many generations: the books close, and worlds keep their promises."""

import numpy as np
import pytest

from ecs_eco.components import Gestation, Position
from ecs_eco.systems import GiveBirth
from ecs_eco.testing import arrange, check_system, check_world, watch
from tests.systems.couples import WAY, mate_and_give_birth

HERD = {
    "actions": {"mate": ["mate"]},
    "always_on": ["eat"],
    "policy": {"kind": "shared", "hidden": [4]},
    "metabolism": {"energy": 0.7, "basal": 0.004},
    "lethal": [
        {"property": "energy", "min": 0.0, "cause_below": "starved"},
        {"property": "age", "max": 90.0, "cause_above": "too old"},
    ],
}
WAYS = [
    {
        "consent": "one",
        "father_share": 0.3,
        "gestation": 4.0,
        "litter": 3,
        "energy_given": 0.2,
        "rest": 3.0,
        "spacing": 0.5,
        "age_min": 5.0,
    },
    {
        "consent": "both",
        "chance": 0.5,
        "choice": "random",
        "place": "anywhere",
        "father_share": 1.0,
        "litter": 2,
    },
    {"consent": "none", "choice": "richest", "gestation": 2.5, "father_rest": 2.0, "dispersal": 4.0},
]


def _herd(meadow, threads=1, way=0, **changes):
    plenty = {"count": 150, "reproduction": {"kind": "spread", "rate": 0.1, "seed_rain": 0.2, "spacing": 1.0}}
    changes = (
        {"count": 40, "max_count": 90, "sex": "random", "reproduction": WAY | WAYS[way], "grass": plenty}
        | HERD
        | changes
    )
    changes["world"] = {"space": {"size": [30.0, 30.0]}} | changes.get("world", {})
    return meadow(options={"policies": "random", "threads": threads}, **changes)


@pytest.mark.parametrize("way", range(len(WAYS)))
@pytest.mark.parametrize("sex", ["random", "none"])
def test_the_books_close_over_many_generations(meadow, way, sex):
    """Parents give what the newborn have, what broods cost that died with their mothers,
    and what is paid for those to come."""
    world = _herd(
        meadow,
        way=way,
        sex=sex,
        metabolism=HERD["metabolism"] | {"energy_max": 50.0},
        # so that nothing overfills a mother
        diet=[{"eats": "grass", "reach": 0.25, "gain": 0.25, "satiation": 1.0}],
    )
    gone = []
    world.on_death.append(
        lambda table, rows: gone.extend(
            table[Gestation].energy[rows].tolist() if table.name == "deer" else ()
        )
    )
    watch(world, 200)  # checks the ledger of every tick
    series = world.series().to_pydict()
    births, endowed, given = (
        np.array([v for v, s in zip(series[k], series["species"], strict=True) if s == "deer"])
        for k in ("births", "endowed", "given")
    )
    deer = world.tables["deer"]
    pending = deer[Gestation].energy[deer.rows()].sum()
    assert births[1:].sum() > 40
    assert endowed[1:].sum() == pytest.approx(births[1:].sum() * (WAY | WAYS[way])["energy_given"], rel=1e-5)
    assert given.sum() == pytest.approx(endowed.sum() + sum(gone) + pending, rel=1e-5)
    # the father pays when mating, and she may die before birth, be it in the same tick
    assert (sum(gone) > 0) == (way < 2)


@pytest.mark.parametrize("way", range(len(WAYS)))
def test_a_world_of_mates_keeps_its_promises(meadow, way):
    check_world(lambda threads: _herd(meadow, threads, way), ticks=40)


def test_the_system_keeps_the_rules(meadow):
    born = []
    check_system(
        GiveBirth,
        lambda threads: _herd(meadow, threads, reproduction=WAY | WAYS[0] | {"age_min": 0.0}),
        ticks=12,
    )
    world = _herd(meadow, reproduction=WAY | WAYS[0] | {"age_min": 0.0})
    world.on_birth.append(lambda table, rows, *_: born.append(rows.size if table.name == "deer" else 0))
    world.run(12)
    assert sum(born) >= 5


def test_a_volume_and_rocks_are_no_hindrance(meadow):
    space = {"size": [20.0, 20.0, 20.0], "edges": "walls"}
    terrain = {"cell": 1.0, "rocks": [{"at": [10.0, 10.0], "radius": 3.0}]}
    world = meadow(
        count=200,
        sex="none",
        world={"space": space, "terrain": terrain},
        reproduction=WAY | {"dispersal": 4.0},
    )
    arrange(world, "deer", energy=0.9)
    mate_and_give_birth(world)
    deer = world.tables["deer"]
    new = deer.by_uid()[200:]
    p = deer[Position]
    assert new.size > 10
    assert world.terrain.free(p.x[new], p.y[new]).all()
    assert np.ptp(p.z[new]) > 5
