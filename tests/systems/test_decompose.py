"""Carcasses give back what they hold: to the soil, to what is lost, and at last all of it."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Chemistry, Position
from ecs_eco.engine.errors import ConfigError
from ecs_eco.life.matter import Bodies, litres, stocks
from ecs_eco.record.matter import LEDGER, imbalance
from ecs_eco.systems.decompose import give_back

CARCASS = {
    "at": [[5.0, 5.0]],
    "body": {"radius": 0.25, "opaque": False},
    "substances": {"nitrogen": 2.0, "carbon": 4.0},
    "decomposition": {"rate": 0.5, "left": 0.05},
}
HELD = 2.0 * float(litres(0.25))  # [mol] of nitrogen


def forest(carcass=None, dt=1.0, fields=None):
    soil = {"soil": {"cell": 2.0, "substance": "nitrogen", "depth": 0.5}}
    return World.from_config(
        {
            "format": 1,
            "name": "forest",
            "dt": dt,
            "space": {"size": [20.0, 20.0]},
            "substances": {"nitrogen": "", "carbon": ""},
            "fields": soil if fields is None else fields,
            "objects": {"carcass": CARCASS | (carcass or {})},
            "species": {"oak": {"count": 1, "body": {"radius": 0.5}}},
        }
    )


def ledger(world):
    table = world.recorder.matter_series().to_pydict()
    return {name: np.reshape(table[name], (-1, *world.matter.stock.shape)) for name in LEDGER}


@pytest.mark.definition("3 chemical rules", "2 properties")
@pytest.mark.parametrize("dt", [1.0, 0.25])
def test_a_carcass_gives_back_by_olsons_law_and_vanishes_with_the_rest(dt):
    """5 % are left after ln(20)/0.5 = 5.99 s: it gives all that is left in the first tick after."""
    world = forest(dt=dt)
    ticks = math.ceil(math.log(20) / 0.5 / dt)
    world.run(3)
    assert world.fields["soil"].value[0, 2, 2] == pytest.approx(HELD * -math.expm1(-1.5 * dt) / 2000)
    world.run(ticks - 3)
    assert world.tables["carcass"].n == 1
    world.run(1)
    assert world.tables["carcass"].n == 0
    assert world.fields["soil"].held() == pytest.approx(HELD, rel=1e-12)
    page = ledger(world)
    assert page["released"][:, 0, 0].sum() == pytest.approx(-HELD)
    assert page["released"][:, 1, 0].sum() == pytest.approx(HELD)
    assert page["lost"][:, 0, 1].sum() == pytest.approx(-2 * HELD)  # no field holds carbon
    assert np.abs(imbalance(page)).max() < 1e-9


def test_the_dead_return_to_the_soil():
    """Life and death of an organism change no amount: a body of one mole is a mole of soil in the end."""
    radius = (3 / 4000 / math.pi) ** (1 / 3)
    world = World.from_config(
        {
            "format": 1,
            "name": "grave",
            "space": {"size": [10.0, 10.0]},
            "substances": {"nitrogen": ""},
            "fields": {"soil": {"cell": 1.0, "substance": "nitrogen"}},
            "objects": {"carcass": {"body": {"radius": 0.01}, "decomposition": {"rate": 1.0}}},
            "species": {
                "fly": {
                    "count": 1,
                    "body": {"radius": radius},
                    "substances": {"nitrogen": 1.0},
                    "lethal": [{"property": "age", "max": 3.0}],
                    "remains": "carcass",
                }
            },
        }
    )
    for _ in range(20):
        world.run(1)
        assert stocks(world, world.matter).sum() == pytest.approx(1.0, rel=1e-6)  # the radius is float32
    assert world.fields["soil"].held() == pytest.approx(1.0, rel=1e-6)
    assert world.tables["carcass"].n == world.tables["fly"].n == 0


def test_what_rots_away_for_want_of_energy_gives_all_that_it_still_holds():
    world = forest(carcass={"decomposition": {"rate": 0.01}, "energy": {"initial": 1.0, "decay": 1.0}})
    world.run(20)
    assert world.tables["carcass"].n == 0
    assert world.causes.count("decayed") == 1
    assert world.fields["soil"].held() == pytest.approx(HELD, rel=1e-12)


def test_what_holds_nothing_cannot_decay():
    with pytest.raises(ConfigError, match="decomposition changes them"):
        forest(carcass={"substances": {}})


def test_the_kernel_is_its_slow_twin():
    rng = np.random.default_rng(1)
    molarity, residue = rng.random((6, 2)).astype(np.float32), np.zeros((6, 2), np.float32)
    volume, rows, old = rng.uniform(1, 2, 6), np.array([4, 0, 3]), np.array([False, True, False])
    share = np.where(old, 1.0, 0.3)[:, None]
    before, amount = molarity.astype(float), np.zeros((3, 2))
    give_back(rows, old, 0.3, Bodies(volume, molarity, residue), amount)
    assert amount == pytest.approx(before[rows] * share * volume[rows, None], rel=1e-12)
    before[rows] *= 1 - share
    assert molarity + residue.astype(float) == pytest.approx(before, abs=1e-12)


def test_a_carcass_decays_where_it_lies():
    world = forest(carcass={"at": [[5.0, 5.0], [15.0, 7.0]]}).run(2)
    assert (world.fields["soil"].value[0] > 0).sum() == 2
    assert world.fields["soil"].value[0, 3, 7] > 0
    assert world.tables["carcass"][Chemistry].molarity[:2, 0] == pytest.approx(2 * math.exp(-1.0))
    assert world.tables["carcass"][Position].x[:2].tolist() == [5.0, 15.0]
