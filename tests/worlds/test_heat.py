"""Worlds in which bodies freeze and overheat, keep warm at a cost, inherit their coats and feel the cold."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Coat, HeatExchange, Nervous, Physical, Position
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record.ledger import LEDGER, imbalance
from ecs_eco.testing import all_threads, arrange, check_world
from tests.worlds.herd import HERD, gene_for, goats, herd

AREA = 4 * math.pi * 0.25**2
HOT = [
    {
        "property": "temperature",
        "min": 280.0,
        "max": 310.0,
        "cause_below": "frozen",
        "cause_above": "overheated",
    }
]
NEWT = {
    "count": 5,
    "body": {"radius": 0.25, "mass": 2.0, "opaque": False},
    "properties": {"temperature": 290.0},
    "lethal": HOT,
    "metabolism": {"energy": 1.0, "energy_max": 1.0},
}
KEEPS_WARM = {"set_point": 290.0, "warming": 500.0, "cost": 1e-5}


def pond(ambient=400.0, dt=1.0, seed=1, options=None, world=None, **newt):
    config = {
        "format": 1,
        "name": "pond",
        "dt": dt,
        "space": {"size": [20.0, 20.0]},
        "ambient": {"temperature": ambient},
        "species": {"newt": NEWT | newt},
    }
    return World.from_config(config | (world or {}), seed=seed, **(options or {}))


def deaths(world, ticks):
    """(tick, cause) of everyone who dies within so many ticks."""
    out = []
    world.on_death.append(
        lambda table, rows: out.extend((world.tick, world.causes[c - 1]) for c in table.cause[rows])
    )
    world.run(ticks)
    return out


@pytest.mark.definition("3 staying alive")
@pytest.mark.parametrize(
    ("ambient", "cause", "far", "near"), [(400.0, "overheated", 110.0, 90.0), (200.0, "frozen", 90.0, 80.0)]
)
@pytest.mark.parametrize("dt", [1.0, 7.0])
def test_all_die_of_heat_or_cold_in_the_tick_that_the_closed_form_says(ambient, cause, far, near, dt):
    """400 K and a limit of 310 K: 400 − 110 exp(−rate t) = 310 after ln(110/90) / rate seconds."""
    rate = 10.0 * AREA / (2.0 * 3500.0)
    tick = math.ceil(math.log(far / near) / rate / dt) - 1  # the first tick is 0
    assert 10 < tick < 200
    assert deaths(pond(ambient, dt, heat={}), 200) == [(tick, cause)] * 5


def test_the_record_counts_deaths_by_their_cause():
    world = pond(heat={}).run(200)
    assert sum(world.series()["died: overheated"].to_pylist()) == 5


def test_without_heat_bodies_keep_their_temperature():
    world = pond().run(200)
    assert world.tables["newt"].n == 5
    assert (world.tables["newt"][Physical].temperature[:5] == 290).all()


def test_what_regulation_costs_is_in_the_ledger_of_energy():
    world = pond(270.0, heat={"regulate": KEEPS_WARM}).run(50)
    page = {name: np.array(world.series()[name].to_pylist()) for name in LEDGER}
    # 10 W/(m^2 K) × 20 K for 50 s, of each of five
    assert page["burnt"].sum() == pytest.approx(5 * 50 * 200 * AREA * 1e-5, rel=1e-3)
    assert np.abs(imbalance(page)).max() < 1e-6
    assert (world.tables["newt"][Physical].temperature[:5] == 290).all()


def test_who_keeps_warm_until_its_energy_is_spent_freezes_then():
    world = pond(200.0, heat={"regulate": KEEPS_WARM | {"warming": 2000.0, "cost": 2e-4}})
    spent = 1.0 / (900 * AREA * 2e-4)  # [s] for which its unit of energy lasts, at 90 K above the water
    rate = 10.0 * AREA / 7000.0
    assert deaths(world, 200) == [(math.ceil(spent + math.log(90 / 80) / rate) - 1, "frozen")] * 5


def test_an_intervention_on_the_ambient_temperature_reaches_bodies():
    snap = [{"kind": "set", "at": 10, "set": {"ambient.temperature": 200.0}}]
    world = pond(290.0, heat={}, world={"interventions": snap})
    rate = 10.0 * AREA / 7000.0
    assert deaths(world, 200) == [(10 + math.ceil(math.log(90 / 80) / rate) - 1, "frozen")] * 5


def test_conductance_may_change_while_they_live_but_heat_may_not_come_or_go():
    world = pond(400.0, heat={}, lethal=[])
    world.intervene({"kind": "set", "set": {"species.newt.heat.conductance": 0.0}})
    world.run(20)
    assert (world.tables["newt"][Physical].temperature[:5] == 290).all()
    with pytest.raises(ConfigError, match=r"newt\.heat.*\n.*cannot change during a run"):
        pond(lethal=[]).intervene({"kind": "set", "set": {"species.newt.heat": {"conductance": 5.0}}})


def test_the_dead_leave_remains_that_go_on_cooling():
    egg = {"body": {"radius": 0.25}, "properties": {"temperature": 290.0}, "heat": {"conductance": 20.0}}
    world = pond(200.0, heat={}, remains="egg", world={"objects": {"egg": egg}}).run(200)
    egg = world.tables["egg"]
    assert (egg.n, world.tables["newt"].n) == (5, 0)
    assert egg[Physical].temperature[egg.rows()].max() < 270


def test_depth_cools_where_the_water_is_stratified():
    sea = {
        "space": {"size": [20.0, 20.0, 50.0], "edges": "walls"},
        "water": {"deep_temperature": 275.0, "thermocline": 25.0, "thermocline_width": 1.0},
    }
    world = pond(295.0, heat={"specific_heat": 35.0}, lethal=[], world=sea)
    arrange(world, "newt", z=[49, 49, 1, 1, 1])
    world.run(100)
    newt = world.tables["newt"]
    assert newt[Physical].temperature[newt.by_uid()] == pytest.approx([295, 295, 275, 275, 275], abs=0.01)


# --- coats --------------------------------------------------------------------------------------------------


def bred(**more):
    """Newts whose coat is a gene of one letter: 0 or 0.1 K m^2/W, twice the bare surface's."""
    genome = {
        "alphabet": "01",
        "loci": 4,
        "genes": [{"name": "coat", "trait": "heat.insulation", "letters": 1, "values": [0.0, 0.1]}],
    }
    return {"count": 40, "heat": {}, "genome": genome} | more


@pytest.mark.definition("3 genome encodes")
def test_a_coat_delays_freezing_by_what_it_insulates():
    world, died = pond(200.0, **bred()), []
    world.on_death.append(
        lambda table, rows: died.extend(
            (world.tick, round(float(c), 6)) for c in table[Coat].insulation[rows]
        )
    )
    world.run(220)
    bare = math.log(90 / 80) / (10.0 * AREA / 7000.0)
    assert set(died) == {(math.ceil(bare) - 1, 0.0), (math.ceil(2 * bare) - 1, 0.1)}
    assert len(died) == 40


def test_a_coat_is_inherited_and_spreads_where_it_is_cold():
    division = {"kind": "asexual", "rate": 0.05, "energy_min": 0.2, "energy_given": 0.1, "dispersal": 5.0}
    snap = [
        {"kind": "set", "at": t, "set": {"ambient.temperature": v}} for t, v in ((40, 230.0), (56, 290.0))
    ]  # bare ones pass 280 K, the others come to 281 K
    share = {}
    for name, plan in (("cold", snap), ("mild", [])):
        world = pond(
            290.0,
            **bred(
                max_count=100,
                reproduction=division,
                heat={"specific_heat": 200.0},
                metabolism={"photosynthesis": 0.05},
            ),
            world={"interventions": plan},
        ).run(120)
        newt = world.tables["newt"]
        coat = newt[Coat].insulation[newt.rows()]
        assert newt.n == 100
        share[name] = (coat > 0).mean()
    assert share["cold"] > 0.95  # all but mutants
    assert 0.2 < share["mild"] < 0.8


def test_a_herd_inherits_coats_beside_all_else():
    world = World.from_config(HERD).run(60)
    table, rows = goats(world)
    born = rows[table.born[rows] > 0]
    assert born.size > 5
    assert table[Coat].insulation[born].std() > 0.05
    plain = herd(genome={"genes": [gene_for("size", "body.radius", low=0.2, high=0.6)]})
    assert Coat not in World.from_config(plain).tables["goat"]


# --- promises -----------------------------------------------------------------------------------------------


LIVELY = bred(
    max_count=80,
    reproduction={"kind": "asexual", "rate": 0.05, "energy_min": 0.2, "energy_given": 0.1, "dispersal": 5.0},
    metabolism={"photosynthesis": 0.05, "basal": 0.01},
    heat={"metabolic_heat": 2000.0, "regulate": KEEPS_WARM | {"cooling": 20.0, "warming": 20.0}},
)


def test_a_world_with_heat_keeps_its_promises():
    check_world(lambda threads: pond(262.0, dt=5.0, options={"threads": threads}, **LIVELY), ticks=80)


def test_it_goes_on_from_a_checkpoint_and_on_two_threads_to_the_same_bytes(tmp_path):
    whole = pond(262.0, dt=5.0, **LIVELY).run(60)
    path = pond(262.0, dt=5.0, **LIVELY).run(23).save(tmp_path / "newts")
    residues = whole.tables["newt"][HeatExchange].residue
    assert residues.any()
    assert World.restore(path).run(37).digest() == whole.digest()
    with all_threads():
        assert pond(262.0, dt=5.0, options={"threads": 2}, **LIVELY).run(60).digest() == whole.digest()


# --- feeling cold -------------------------------------------------------------------------------------------


def goat(**more):
    """A goat that feels its own temperature, in a valley whose east is warmer: 280 K + 1 K per metre."""
    animal = {
        "count": 2,
        "body": {"radius": 0.25, "mass": 2.0, "opaque": False},
        "properties": {"temperature": 290.0},
        "heat": {"specific_heat": 50.0},
        "locomotion": {"speed": {"still": 0.0, "walk": 1.0}},
        "sensors": [{"kind": "own", "property": "temperature", "scale": 300.0}],
        "actions": {"speed": ["still", "walk"]},
        "default_action": {"speed": "still"},
    } | more
    world = {
        "format": 1,
        "name": "valley",
        "space": {"size": [60.0, 20.0], "edges": "walls"},
        "species": {"goat": animal},
    }
    world = World.from_config(world)
    arrange(world, "goat", x=[1.0, 35.0], heading=0.0)
    world.environment["temperature"] = lambda w, x, y, z: 280 + x
    return world


@pytest.mark.definition("3 sensor property")
def test_who_feels_cold_walks_until_it_is_warm():
    cold = {"connections": [{"sensor": "temperature", "action": "walk", "weight": 1, "below": 1.0}]}
    world = goat(reflex=cold).run(200)
    p, warmth = world.tables["goat"][Position], world.tables["goat"][Physical].temperature
    # until its body has warmed to 300 K, which lags behind its place
    assert 20 < p.x[0] < 35
    assert p.x[1] < 45
    assert warmth[:2] == pytest.approx(280 + p.x[:2], abs=0.1)
    assert (warmth[:2] >= 300).all()


def test_warming_up_is_a_joy_to_who_likes_it_warm():
    world = goat(happiness={"weights": {"temperature": 1.0}, "minimum": -1.0})
    felt = [world.run(1).tables["goat"][Nervous].happiness[:2].copy() for _ in range(3)]
    assert felt[0] == pytest.approx([290 / 300] * 2)
    assert felt[0][0] > felt[1][0] > felt[2][0]  # at 281 K
    assert felt[0][1] < felt[1][1] < felt[2][1]  # at 315 K


# --- bad values ---------------------------------------------------------------------------------------------


WRONG = {
    "no temperature": (
        {"properties": {}},
        "newt.properties.temperature",
        "is missing, but heat changes it; expected: the initial temperature",
    ),
    "below 0 K": (
        {"properties": {"temperature": -5.0}},
        "newt.properties.temperature = -5.0",
        "below absolute zero; expected: at least 0 K",
    ),
    "negative": ({"heat": {"insulation": -1.0}}, "newt.heat.insulation = -1.0", "0"),
    "misspelt": ({"heat": {"conductence": 1.0}}, "newt.heat.conductence", 'did you mean "conductance"'),
    "powerless": (
        {"heat": {"regulate": {"set_point": 300.0, "cost": 0.1}}},
        "newt.heat.regulate.warming = 0.0",
        "warming and cooling are both 0; expected: a power [W]",
    ),
    "no set point": (
        {"heat": {"regulate": {"cost": 0.1, "warming": 1.0}}},
        "newt.heat.regulate.set_point",
        "missing",
    ),
    "no cost": (
        {"heat": {"regulate": {"set_point": 300.0, "warming": 1.0}}},
        "newt.heat.regulate.cost",
        "missing",
    ),
    "too cheap": (
        {"heat": {"regulate": {"set_point": 300.0, "warming": 10.0, "cost": 1e-9}}},
        "newt.heat.regulate.cost = 1e-09",
        "such small steps round to 0",
    ),
    "gene of nothing": ({"heat": None} | bred(heat=None), 'genome.genes.0.trait = "heat.insulation"', ""),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_values_are_refused_by_name(name):
    changes, place, what = WRONG[name]
    newt = NEWT | {"lethal": []} | {k: v for k, v in ({"heat": {}} | changes).items() if v is not None}
    config = {"format": 1, "name": "pond", "space": {"size": [20.0, 20.0]}, "species": {"newt": newt}}
    with pytest.raises(ConfigError) as error:
        load(config)
    assert place in str(error.value)
    assert what in str(error.value)


def test_objects_with_heat_need_a_temperature():
    stone = {"count": 1, "body": {"radius": 0.5}, "heat": {}}
    with pytest.raises(ConfigError, match=r"objects\.stone\.properties\.temperature\n  is missing"):
        pond(world={"objects": {"stone": stone}})
    stone["heat"] = {"metabolic_heat": 1.0}
    with pytest.raises(ConfigError, match=r"stone\.heat\.metabolic_heat"):
        pond(world={"objects": {"stone": stone | {"properties": {"temperature": 300.0}}}})


def test_what_a_world_without_heat_is_written_as_has_no_word_of_it():
    values = load("predator-prey").resolved()
    assert all("heat" not in species for species in values["species"].values())
    warm = pond(heat={"conductance": 5.0}).config
    assert warm.resolved()["species"]["newt"]["heat"]["conductance"] == 5.0
    assert load(warm.resolved()).config_hash == warm.config_hash
