"""Doses of substances from outside: into fields and into bodies, counted by hand and in the ledger."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Chemistry, Matter
from ecs_eco.config.models.interventions import describe
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Intervene
from ecs_eco.testing import arrange, check_world

LITRES = 4000 / 3 * math.pi * 0.5**3  # of a sheep


def meadow(*interventions, size=(8.0, 8.0), moves=True, **options):
    """Soil in cells of 4 m² and 4,000 L, and three sheep that hold salt and may sweat it out."""
    sweat = {"kind": "release", "substance": "salt", "rate": 0.001}
    return World.from_config(
        {
            "format": 1,
            "name": "meadow",
            "ticks": 50,
            "space": {"size": list(size), "edges": "walls"},
            "substances": {"salt": "licked", "nitrogen": "in the soil"},
            "fields": {
                "soil": {"cell": 2.0, "substance": "nitrogen", "initial": 0.01},
                "musk": {"cell": 2.0},
            },
            "species": {
                "sheep": {
                    "count": 3,
                    "body": {"radius": 0.5, "opaque": False},
                    "substances": {"salt": 0.1},
                    "exchange": [sweat] if moves else [],
                }
            },
            "interventions": list(interventions),
        },
        policies="random",
        **options,
    )


def page(world):
    """What was brought in [mol] by (holder, substance), and the largest imbalance of a tick."""
    rows = world.recorder.matter_series().to_pylist()
    flows = [
        name for name in rows[0] if name not in ("tick", "holder", "substance", "stock_before", "stock_after")
    ]
    off = max(abs(r["stock_before"] + sum(r[f] for f in flows) - r["stock_after"]) for r in rows)
    return {(r["holder"], r["substance"]): r["brought_in"] for r in rows if r["tick"] == 0}, off


@pytest.mark.definition("3 chemical rules")
def test_manure_is_spread_over_the_cells_of_a_region_and_counted():
    world = meadow({"kind": "dose", "at": 0, "field": "soil", "amount": 80.0, "region": [0.0, 0.0, 4.0, 4.0]})
    world.run(1)
    soil = world.fields["soil"].value[0]  # 20 mol to each of four cells of 4,000 L
    assert soil[:2, :2] == pytest.approx(0.015)
    assert soil[2:] == pytest.approx(0.01)
    assert soil[:, 2:] == pytest.approx(0.01)
    brought, off = page(world)
    assert brought["soil", "nitrogen"] == pytest.approx(80.0)
    assert off < 1e-9


def test_no_more_is_taken_away_than_there_is():
    world = meadow({"kind": "dose", "at": 0, "field": "soil", "amount": -60.0, "region": [1.0, 1.0, 0.1]})
    world.run(1)
    assert world.fields["soil"].value[0, 0, 0] == 0  # it held 40 mol
    assert page(world)[0]["soil", "nitrogen"] == pytest.approx(-40.0)


def test_a_region_without_the_middle_of_a_cell_is_the_cell_that_it_is_in():
    dose = {"kind": "dose", "at": 0, "field": "musk", "amount": 6.0, "region": [4.5, 2.5, 4.75, 2.75]}
    world = meadow(dose)
    world.run(1)
    assert np.argwhere(world.fields["musk"].value).tolist() == [[0, 1, 2]]
    assert world.fields["musk"].value.sum() == 6


@pytest.mark.parametrize("moves", [True, False])
def test_each_body_in_the_region_gets_the_dose(moves):
    order = {"kind": "dose", "at": 0, "species": "sheep", "substance": "salt", "region": [2.0, 2.0, 1.0]}
    world = meadow(order | {"amount": 26.0}, moves=moves)
    table = arrange(world, "sheep", x=[2.0, 2.5, 6.0], y=[2.0, 2.0, 6.0])
    assert (Matter in table) == moves
    world.run(1)
    salt = table[Chemistry].molarity[table.by_uid(), world.substances.index("salt")]
    kept = math.exp(-0.001) if moves else 1.0
    assert salt == pytest.approx(np.array([0.1 + 26 / LITRES] * 2 + [0.1]) * kept, rel=1e-6)
    brought, off = page(world)
    assert brought["sheep", "salt"] == pytest.approx(52.0, rel=1e-6)
    assert off < 1e-9
    world.intervene({k: v for k, v in order.items() if k not in ("at", "region")} | {"amount": -1e9})
    world.run(1)
    assert (table[Chemistry].molarity[table.rows(), world.substances.index("salt")] == 0).all()


def test_a_dosed_world_keeps_its_promises_with_the_ledger_closed():
    orders = [
        {"kind": "dose", "at": 2, "every": 3, "field": "soil", "amount": 5.0, "region": [4.0, 4.0, 2.0]},
        {"kind": "dose", "at": 3, "every": 4, "species": "sheep", "substance": "salt", "amount": 1.0},
    ]
    check_world(lambda threads: meadow(*orders, threads=threads), ticks=12)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"field": "soil", "species": "sheep"}, "either field or species"),
        ({}, "either field or species"),
        ({"field": "soi"}, 'did you mean "soil"'),
        ({"field": "soil", "substance": "salt"}, "a field defines its own"),
        ({"species": "sheep", "substance": "sal"}, 'did you mean "salt"'),
        ({"species": "shep", "substance": "salt"}, 'did you mean "sheep"'),
        ({"species": "sheep"}, "interventions.0.substance\n  is missing"),
        ({"field": "soil", "amount": 0.0}, "not a dose"),
        ({"field": "soil", "region": [9.0, 9.0, 1.0]}, "its center is outside the world"),
    ],
)
def test_wrong_doses_are_refused(wrong, message):
    with pytest.raises(ConfigError) as error:
        meadow({"kind": "dose", "at": 0, "amount": 1.0} | wrong)
    assert message in str(error.value), str(error.value)


def test_a_dose_has_a_line_of_words():
    dose = {"kind": "dose", "at": 0, "amount": 2.0}
    assert describe(dose | {"field": "soil", "region": [1.0, 2.0, 3.0]}) == "dose 2 into soil in [1, 2, 3]"
    assert describe(dose | {"species": "sheep", "substance": "salt"}) == "dose 2 of salt to each sheep"


def test_worlds_made_by_hand_know_their_fields():
    world = World((4, 4))
    world.add_system(Intervene())
    with pytest.raises(ValueError, match="unknown field 'soil'"):
        world.intervene({"kind": "dose", "field": "soil", "amount": 1.0})
