"""Breathing, drinking, excreting, leaking: what passes between bodies and the fields around them."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Chemistry, Matter
from ecs_eco.engine.errors import ConfigError
from ecs_eco.life.matter import NUMBER, litres, stocks
from ecs_eco.systems import ExchangeMatter
from ecs_eco.systems.exchange_matter import equilibrate, release, take_up
from ecs_eco.testing import act, arrange

# the field has cells of 10 m × 10 m × 1 m: 100,000 L; a deer of 0.5 m has 523.6 L
AIR = {"air": {"cell": 10.0, "substance": "oxygen", "initial": 0.01}}
CELL, DEER = 100_000.0, float(litres(0.5))


@pytest.fixture
def pasture(meadow):
    """A function of exchanges that returns a world of two deer, each alone in a cell of the air."""

    def build(*exchange, fields=None, world=None, **deer):
        around = {"substances": {"oxygen": "", "salt": ""}, "fields": AIR | (fields or {})}
        new = meadow(
            world=around | (world or {}),
            **({"substances": {"oxygen": 0.002, "salt": 0.5}, "exchange": list(exchange)} | deer),
        )
        arrange(new, "deer", x=[5.0, 15.0], y=5.0, heading=0.0)
        return new

    return build


def held(world, s=0):
    table = world.tables["deer"]
    rows = table.by_uid()
    return table[Chemistry].molarity[rows, s].astype(float) + table[Matter].residue[rows, s]


def flow(world, name):
    return {
        holder: world.matter.flows[i, :, NUMBER[name]].sum()
        for (_, holder), i in world.matter.holders.items()
    }


@pytest.mark.definition("3 chemical rules")
def test_breathing_takes_oxygen_from_the_air_until_the_blood_is_saturated(pasture):
    world = pasture({"kind": "uptake", "field": "air", "rate": 0.0007, "concentration_max": 0.003})
    before = stocks(world, world.matter).sum(0)
    act(world, ExchangeMatter)
    assert held(world) == pytest.approx([0.0027, 0.0027], abs=1e-9)
    assert world.fields["air"].value[0, 0] == pytest.approx([0.01 - 0.0007 * DEER / CELL] * 2, abs=1e-12)
    assert flow(world, "taken_up") == {
        "deer": pytest.approx(0.0014 * DEER),
        "air": pytest.approx(-0.0014 * DEER),
    }
    act(world, ExchangeMatter)
    assert held(world) == pytest.approx([0.003, 0.003], abs=1e-9)
    assert stocks(world, world.matter).sum(0) == pytest.approx(before, rel=1e-12)


def test_thin_air_gives_half_as_much_at_the_half_concentration(pasture):
    world = pasture({"kind": "uptake", "field": "air", "rate": 0.001, "half": 0.01})
    act(world, ExchangeMatter)
    assert held(world) == pytest.approx([0.0025, 0.0025], abs=1e-9)


def test_who_wants_more_than_there_is_gets_a_share_by_what_each_wants(pasture):
    world = pasture({"kind": "uptake", "field": "air", "rate": 5.0})
    arrange(world, "deer", x=[4.0, 6.0], y=5.0, radius=[0.5, 0.25])
    world.tables["deer"][Matter].volume[:2] = litres([0.5, 0.25])
    act(world, ExchangeMatter)
    shares = 0.01 * CELL * np.array([8, 1]) / 9  # all of the cell's
    assert held(world) == pytest.approx(0.002 + shares / litres([0.5, 0.25]), rel=1e-9)
    assert world.fields["air"].value[0, 0, 0] == pytest.approx(0, abs=1e-15)
    assert world.fields["air"].value.min() >= 0


@pytest.mark.parametrize(
    "way",
    [
        {"kind": "uptake", "field": "air", "rate": 5.0},
        {"kind": "equilibrate", "field": "air", "rate": 50.0, "partition": 300.0},
    ],
)
def test_bodies_of_all_species_in_a_cell_get_the_same_share_of_what_is_scarce(pasture, way):
    kind = {"count": 2, "body": {"radius": 0.5}, "substances": {"oxygen": 0.002}, "exchange": [way]}
    world = pasture(way, world={"species": {"ant": kind, "yak": kind}})
    for name in ("ant", "deer", "yak"):
        arrange(world, name, x=[5.0, 15.0], y=5.0)
    act(world, ExchangeMatter)
    held = [world.tables[name][Chemistry].molarity[:2, 0].astype(float) for name in ("ant", "deer", "yak")]
    assert held[0] == pytest.approx(held[1], rel=1e-6)
    assert held[0] == pytest.approx(held[2], rel=1e-6)
    if way["kind"] == "uptake":  # all of the cell's
        assert held[0] == pytest.approx(0.002 + 0.01 * CELL / DEER / 3, rel=1e-6)


def _rivals(pasture, *exchange):
    """Return what a deer that takes up oxygen in these ways has gained, relative to a rival whose rate is 1
    mol/L, if the cell contains half of the demand of both."""
    rival = {"count": 1, "body": {"radius": 0.5}, "substances": {"oxygen": 0.0}}
    rival["exchange"] = [{"kind": "uptake", "field": "air", "rate": 1.0}]
    world = pasture(*exchange, world={"species": {"yak": rival}}, substances={"oxygen": 0.0})
    for name in ("deer", "yak"):
        arrange(world, name, x=[5.0, 15.0][: world.tables[name].n], y=5.0)
    world.fields["air"].value[...] = DEER / CELL
    act(world, ExchangeMatter)
    assert world.fields["air"].value[0, 0, 0] == pytest.approx(0, abs=1e-12)
    return world.tables["deer"][Chemistry].molarity[0, 0], world.tables["yak"][Chemistry].molarity[0, 0]


def test_uptakes_of_one_body_count_together_in_any_order(pasture):
    for rates in ((1.0,), (0.9, 0.1), (0.5, 0.5), (0.1, 0.9), (0.25, 0.5, 0.25)):
        ways = [{"kind": "uptake", "field": "air", "rate": rate} for rate in rates]
        assert _rivals(pasture, *ways) == pytest.approx((0.5, 0.5))


def test_uptakes_of_one_body_do_not_fill_it_above_its_limit(pasture):
    ways = [
        {"kind": "uptake", "field": "air", "rate": rate, "concentration_max": 0.003}
        for rate in (0.003, 0.001)
    ]
    for mouth in (ways, ways[::-1]):  # the first one takes 3/4, from the cell on the right
        mouth = [way | ({"at": [2.0, 0.0]} if way["rate"] == 0.003 else {}) for way in mouth]
        world = pasture(*mouth)
        arrange(world, "deer", x=[9.5, 5.0], y=[5.0, 15.0], heading=0.0)
        act(world, ExchangeMatter)
        assert held(world) == pytest.approx([0.003, 0.003], abs=1e-9)
        lost = (0.01 - world.fields["air"].value[0]) * CELL / DEER
        assert lost[0] == pytest.approx([0.00025, 0.00075], abs=1e-9)
        assert lost[1] == pytest.approx([0.001, 0.0], abs=1e-9)


def test_it_drinks_from_where_its_mouth_is(pasture):
    mouth = {"kind": "uptake", "field": "air", "rate": 0.001, "at": [2.0, 0.0]}
    world = pasture(mouth)
    arrange(world, "deer", x=[9.5, 5.0], y=[5.0, 9.5], heading=[0.0, math.pi / 2])
    act(world, ExchangeMatter)
    lost = 0.01 - world.fields["air"].value[0] > 1e-9
    assert lost.tolist() == [[False, True], [True, False]]


def test_only_who_does_the_action_drinks(pasture):
    drink = {"kind": "uptake", "field": "air", "rate": 0.001, "action": "drink"}
    dry = {"formulas": {"drink": "0.5 - oxygen"}}
    world = pasture(
        drink,
        reflex=dry,
        sensors=[
            {"kind": "own", "property": "oxygen", "scale": 0.001},
            {"kind": "own", "property": "energy"},
        ],
        actions={"speed": ["still", "walk", "run"], "turn": ["left", "none", "right"], "swallow": ["drink"]},
        always_on=[],
    )
    arrange(world, "deer")
    world.tables["deer"][Chemistry].molarity[:2, 0] = [0.0001, 0.002]
    world.run(1)
    assert held(world) == pytest.approx([0.0011, 0.002], abs=1e-9)


@pytest.mark.parametrize("dt", [1.0, 7.0])
def test_what_passes_the_skin_comes_to_balance_and_no_amount_changes(pasture, dt):
    world = pasture(
        {"kind": "equilibrate", "field": "air", "rate": 0.1, "partition": 2.0},
        world={"dt": dt},
        locomotion={"speed": {"still": 0.0, "walk": 0.1, "run": 0.2}, "turn": 0.1},
    )
    before = stocks(world, world.matter)[:, 0].sum()
    act(world, ExchangeMatter)
    crowd = 1 + 2 * DEER / CELL
    assert held(world) == pytest.approx(
        [0.002 + 0.018 / crowd * (1 - math.exp(-0.1 * crowd * dt))] * 2, rel=1e-6
    )
    for _ in range(400):
        act(world, ExchangeMatter)
    assert held(world) == pytest.approx(2 * world.fields["air"].value[0, 0], rel=1e-9)
    assert stocks(world, world.matter)[:, 0].sum() == pytest.approx(before, rel=1e-12)


def test_sweat_and_urine_go_to_the_field_of_the_substance_or_are_lost(pasture):
    soil = {"soil": {"cell": 5.0, "substance": "salt", "depth": 0.2}}
    sweat = {"kind": "release", "substance": "salt", "rate": 0.1, "above": 0.25}
    for field, flow_name in (("soil", "released"), (None, "lost")):
        world = pasture(sweat | ({"field": field} if field else {}), fields=soil)
        act(world, ExchangeMatter)
        gone = 0.25 * (1 - math.exp(-0.1))
        assert held(world, 1) == pytest.approx([0.5 - gone] * 2, abs=1e-9)
        assert flow(world, flow_name)["deer"] == pytest.approx(-2 * gone * DEER)
        assert world.fields["soil"].held() == pytest.approx(2 * gone * DEER if field else 0)


@pytest.mark.definition("3 staying alive")
def test_who_breathes_no_oxygen_and_burns_it_suffocates(pasture):
    """0.002 mol/L, 0.0003 a second: it lasts for 6.67 s, and at 0.0002 it is too late after the 6th."""
    burns = [{"from": {"oxygen": 1.0}, "to": {}, "rate": 0.0003}]
    limit = [{"property": "oxygen", "min": 0.0003, "cause_below": "suffocated"}]
    breath = {"kind": "uptake", "field": "air", "rate": 0.0004, "concentration_max": 0.002}
    for exchange, living in ((), 0), ((breath,), 2):
        world = pasture(*exchange, reactions=burns, lethal=limit)
        world.run(5)
        assert world.tables["deer"].n == 2
        world.run(1)
        assert world.tables["deer"].n == living
    assert "suffocated" in world.causes


def test_fields_are_renewed_from_outside(pasture):
    world = pasture(fields={"air": AIR["air"] | {"renewal": 0.5}})
    world.fields["air"].value[...] = 0.004
    world.run(1)
    assert world.fields["air"].value[0, 0, 0] == pytest.approx(0.01 - 0.006 * math.exp(-0.5), abs=1e-9)
    page = world.recorder.matter_series().to_pydict()
    assert sum(page["brought_in"]) == pytest.approx(0.006 * (1 - math.exp(-0.5)) * 4 * CELL)
    assert sum(page["set"]) == pytest.approx(0)


def test_water_is_where_the_lakes_are(pasture):
    lake = {"lake": {"cell": 2.0, "substance": "salt", "initial": 55.0, "only": "lakes"}}
    world = pasture(fields=lake, world={"terrain": {"lakes": [{"at": [5.0, 5.0], "radius": 3.0}]}})
    wet = world.fields["lake"].value[0] > 0
    assert [wet[2, 2], wet[0, 0], wet[7, 7]] == [True, False, False]
    assert 7 <= wet.sum() <= 9  # of cells of 4 m^2, in 28 m^2


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"kind": "uptake", "field": "ait", "rate": 1.0}, 'did you mean "air"'),
        ({"kind": "release", "substance": "salt", "field": "air", "rate": 1.0}, "it contains oxygen"),
        ({"kind": "uptake", "field": "air", "rate": 1.0, "action": "eet"}, 'did you mean "eat"'),
    ],
)
def test_what_cannot_be_exchanged_is_refused_by_name(pasture, wrong, says):
    with pytest.raises(ConfigError, match=says):
        pasture(wrong)


def test_a_smell_without_amount_cannot_go_into_a_field_of_a_substance(pasture):
    with pytest.raises(ConfigError, match="cannot come from nothing"):
        pasture(emits={"air": 1.0})


def _two_fields(kind, one, other, **how):
    """Return a world with a deer that exchanges in the same way with two fields, and their amounts before."""
    ways = [{"kind": kind, "field": name, "rate": 1.0, **how} for name in (one, other)]
    if kind == "release":
        ways = [way | {"substance": "oxygen"} for way in ways]
    fields = {name: {"cell": 10.0, "substance": "oxygen", "initial": 0.01} for name in (one, other)}
    deer = {"count": 1, "body": {"radius": 0.5}, "substances": {"oxygen": 0.002}, "exchange": ways}
    world = {"format": 1, "name": "two", "space": {"size": [20.0, 20.0]}, "dt": 2.0, "fields": fields}
    world |= {"substances": {"oxygen": ""}, "species": {"deer": deer}}
    return World.from_config(world, seed=1)


@pytest.mark.parametrize("names", [("air", "soil"), ("zair", "soil")])
def test_two_fields_of_one_substance_share_in_what_a_body_exchanges(names):
    """Neither its name nor its place in the list gives a field more."""
    world = _two_fields("release", *names)
    world.run(1)
    gone = 0.002 * (1 - math.exp(-2 * 2.0)) * DEER
    for name in names:
        assert world.fields[name].held() - 0.01 * 4 * CELL == pytest.approx(gone / 2, rel=1e-6)
    world = _two_fields("uptake", *names, concentration_max=0.004)
    world.run(1)
    for name in names:
        assert 0.01 * 4 * CELL - world.fields[name].held() == pytest.approx(0.001 * DEER, rel=1e-6)
    world = _two_fields("equilibrate", *names)
    world.fields[names[0]].value[...] = 0.0
    world.run(1)
    c = 0.005 + (0.002 - 0.005) * math.exp(-2 * 2.0)  # the body is small: both fields stay as they are
    assert held(world)[0] == pytest.approx(c, rel=2e-3)


def test_two_equilibrations_with_one_cell_are_one_of_the_sum_of_their_rates(pasture):
    ways = [{"kind": "equilibrate", "field": "air", "rate": rate, "partition": 300.0} for rate in (3.0, 7.0)]
    apart, together = pasture(*ways), pasture(ways[0] | {"rate": 10.0})
    for world in (apart, together):
        act(world, ExchangeMatter)
    assert held(apart) == pytest.approx(held(together), rel=1e-6)


def test_dying_animals_exchange_nothing(pasture):
    world = pasture(
        {"kind": "uptake", "field": "air", "rate": 0.001},
        {"kind": "equilibrate", "field": "air", "rate": 0.1},
        {"kind": "release", "substance": "salt", "rate": 0.1},
    )
    world.tables["deer"].cause[0] = world.cause("eaten")
    act(world, ExchangeMatter)
    assert held(world)[0] == pytest.approx(0.002, abs=1e-9)
    assert held(world)[1] > 0.0025
    assert held(world, 1) == pytest.approx([0.5, 0.5 * math.exp(-0.1)])
    assert world.fields["air"].value[0, 0] == pytest.approx([0.01, 0.01], abs=1e-5)
    assert world.fields["air"].value[0, 0, 0] == 0.01


def test_an_eaten_plant_takes_nothing_more_from_the_soil():
    soil = {"cell": 5.0, "substance": "N", "depth": 1.0, "initial": 1.0}
    grass = {"count": 1, "body": {"radius": 0.1}, "substances": {"N": 1.0}}
    grass["exchange"] = [{"kind": "uptake", "field": "soil", "rate": 2.0}]
    cow = {"count": 1, "body": {"radius": 0.5}, "substances": {"N": 0.0}, "metabolism": {"energy": 0.1}}
    cow["diet"] = [{"eats": "grass", "reach": 14.0, "gain": 0.5}]
    world = {"format": 1, "name": "t", "space": {"size": [10, 10], "edges": "walls"}}
    world |= {"fields": {"soil": soil}, "substances": {"N": ""}, "species": {"grass": grass, "cow": cow}}
    world = World.from_config(world, seed=1)
    before = stocks(world, world.matter).sum()
    world.run(1)
    assert world.tables["grass"].n == 0
    assert stocks(world, world.matter).sum() == pytest.approx(before, rel=1e-9)
    assert world.fields["soil"].held() == pytest.approx(100_000.0)


class Entry:
    """An exchange with one field of 50 L cells, for `take_up`, `equilibrate` and `release`."""

    def __init__(self, name, rng, field, **values):
        table, volume = SimpleNamespace(name=name), rng.uniform(0.5, 3, 9)
        self.some, self.way = (
            SimpleNamespace(table=table, volume=volume),
            SimpleNamespace(field="air", **values),
        )
        self.field, self.acting = SimpleNamespace(value=field), True
        self.cell, self.litres = rng.integers(0, field.size, 9), 50.0
        self.held, self.around = rng.uniform(0, 0.1, 9), field[self.cell]

    def own(self, **values):
        return [*values.values()]


@pytest.mark.parametrize("seed", range(3))
def test_the_changes_are_those_of_slow_twins(seed):
    rng = np.random.default_rng(seed)
    field = rng.uniform(0, 0.2, 4)
    every = [Entry(name, rng, field, rate=2.0, half=0.1, concentration_max=1.5) for name in "ab"]
    take_up(every, 1.0)
    demand = np.zeros(4)
    for e in every:
        for i, k in enumerate(e.cell):
            demand[k] += min(2.0 * field[k] / (0.1 + field[k]), 1.5 - e.held[i]) * e.some.volume[i]
    for e in every:
        for i, k in enumerate(e.cell):
            mine = min(2.0 * field[k] / (0.1 + field[k]), 1.5 - e.held[i]) * min(
                1.0, field[k] * 50 / demand[k]
            )
            assert e.change[i] == pytest.approx(mine)

    every = [Entry(name, rng, field, rate=0.3, partition=1.5, above=0.05) for name in "ab"]
    equilibrate(every, 1.0)
    volume = np.zeros(4)
    for e in every:
        for i, k in enumerate(e.cell):
            volume[k] += e.some.volume[i]
    for e in every:
        for i, k in enumerate(e.cell):
            crowd = 1 + 1.5 * volume[k] / 50
            change = (1.5 * field[k] - e.held[i]) * (1 - math.exp(-0.3 * crowd)) / crowd
            assert e.change[i] == pytest.approx(change)
    release(every, 1.0)
    for e in every:
        gone = [max(c - 0.05, 0.0) * (1 - math.exp(-0.3)) for c in e.held]
        assert -e.change == pytest.approx(gone)


def test_a_half_of_zero_and_an_empty_cell_give_no_uptake():
    field = np.array([0.0, 0.5])
    entry = Entry("a", np.random.default_rng(1), field, rate=0.001, half=0.01, concentration_max=None)
    entry.own = lambda **values: [np.zeros(9) if name == "half" else v for name, v in values.items()]
    take_up([entry], 1.0)
    assert entry.change == pytest.approx(np.where(entry.around > 0, 0.001, 0.0))
