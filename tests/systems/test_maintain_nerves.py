import numpy as np
import pytest

from ecs_eco.components import LearningRates, Metabolism, Nervous, NeuralCost, Traits
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record.ledger import imbalance
from ecs_eco.systems import MaintainNerves
from ecs_eco.testing import act, arrange

STILL = {  # it only turns, and burns nothing except for its nervous system
    "metabolism": {"energy": 8.0, "energy_max": 8.0, "basal": 0.0},
    "diet": [],
    "sensors": [
        {"kind": "own", "property": "energy"},
        {"kind": "nearest", "name": "eye", "target": "grass", "range": 4.0},  # three channels
    ],
    "actions": {"speed": None, "turn": ["left", "right"], "eat": None},
    "default_action": {"speed": None, "turn": None},
    "always_on": [],
    "policy": {"kind": "individual", "hidden": [4, 2], "learn": True},
    "ppo": {"horizon": 4, "learning_rate": 0.015625},
}
COSTS = {"hidden_unit": 0.0625, "receptor": 0.03125, "transition": 0.125}
PER_TICK = {"brain": 6 * 0.0625 * 0.5, "learning": 0.125, "senses": 4 * 0.03125 * 0.5}  # a tick lasts 0.5 s


def build(meadow, costs=COSTS, **changes):
    return meadow(world={"dt": 0.5}, neural_costs=costs, **STILL | changes)


def paid(world):
    cost = world.table("deer")[NeuralCost]
    return {name: getattr(cost, name)[: world.table("deer").n].tolist() for name in PER_TICK}


def coded(trait, values):
    return {"alphabet": "01", "genes": [{"name": "g", "trait": trait, "letters": 1, "values": values}]}


@pytest.mark.parametrize("kind", ["individual", "shared"])
def test_ten_ticks_cost_what_a_hand_counts_and_the_ledger_names_it(meadow, kind):
    reporters = {name: f"sum(NeuralCost.{name})" for name in PER_TICK}
    costs = STILL | {"policy": STILL["policy"] | {"kind": kind}, "neural_costs": COSTS}
    world = meadow(world={"dt": 0.5, "reporters": reporters}, **costs).run(10)
    assert world.table("deer")[Metabolism].energy[:2].tolist() == [8 - 10 * (0.1875 + 0.125 + 0.0625)] * 2
    assert paid(world) == {name: [cost] * 2 for name, cost in PER_TICK.items()}
    series = {name: np.array(world.series()[name]) for name in world.series().column_names}
    series = {name: column[series["species"] == "deer"] for name, column in series.items()}
    assert {name: series[name].tolist() for name in PER_TICK} == {
        name: [2 * cost] * 10 for name, cost in PER_TICK.items()
    }
    assert series["burnt"].tolist() == [2 * 0.375] * 10
    assert imbalance(series).tolist() == [0] * 10


def test_each_pays_for_its_own_hidden_units(meadow):
    world = build(meadow, count=20, genome=coded("policy.hidden.0", [1.0, 4.0]))
    act(world, MaintainNerves)
    units = world.table("deer")[Traits].value[:20, 0] + 2
    assert set(units) == {3, 6}
    assert paid(world)["brain"] == (units * 0.0625 * 0.5).tolist()


def test_each_pays_in_proportion_to_its_own_learning_rate(meadow):
    world = build(meadow, count=20, genome=coded("ppo.learning_rate", [0.0, 0.03125]))
    act(world, MaintainNerves)
    rate = world.table("deer")[LearningRates].learning_rate[:20]
    assert set(rate) == {0, 0.03125}
    assert paid(world)["learning"] == np.where(rate == 0, 0, 0.25).tolist()


def test_an_absent_sensor_has_no_receptors(meadow):
    world = build(meadow, count=20, genome=coded("sensors.eye.present", [0.0, 1.0]))
    act(world, MaintainNerves)
    has = world.table("deer")[Traits].value[:20, 0]
    assert set(has) == {0, 1}
    assert paid(world)["senses"] == ((1 + 3 * has) * 0.03125 * 0.5).tolist()


def test_who_does_not_learn_pays_for_no_transition(meadow):
    world = build(meadow, policy=STILL["policy"] | {"learn": False})
    act(world, MaintainNerves)
    assert paid(world) == {"brain": [0.1875] * 2, "learning": [0, 0], "senses": [0.0625] * 2}


def test_a_species_without_a_network_pays_for_its_receptors(meadow):
    world = build(meadow, {"receptor": 0.25}, policy=None, ppo=None)
    act(world, MaintainNerves)
    assert paid(world) == {"brain": [0, 0], "learning": [0, 0], "senses": [4 * 0.25 * 0.5] * 2}
    assert Nervous in world.table("deer")


def test_a_torpid_animal_pays_what_it_has_and_a_debtor_owes_the_rest(meadow):
    for torpor, left in ((True, [0, 0]), (False, [-0.1875, -0.375])):
        world = build(meadow, metabolism=STILL["metabolism"] | {"torpor": torpor})
        deer = arrange(world, "deer", energy=[0.1875, 0.0])
        act(world, MaintainNerves)
        assert deer[Metabolism].energy[:2].tolist() == left
        first, second = (0.5, 0) if torpor else (1, 1)  # shares of the costs
        learns = 0 if torpor else 0.125  # who has nothing does not decide
        expected = {name: [cost * first, cost * second] for name, cost in PER_TICK.items()}
        assert paid(world) == expected | {"learning": [0.125 * first, learns]}
        assert deer[Metabolism].burnt[:2].tolist() == [0.375 * first, 0.375 * second]


def test_the_dead_pay_nothing(meadow):
    world = build(meadow)
    deer = world.table("deer")
    deer.alive[1] = False
    act(world, MaintainNerves)
    assert deer[Metabolism].energy[:2].tolist() == [8 - 0.375, 8]


@pytest.mark.parametrize(
    ("costs", "changes", "message"),
    [
        ({"hidden_unit": 0.5}, {"policy": None, "ppo": None}, r"hidden_unit = 0.5\n.*no built-in policy"),
        ({"transition": 0.5}, {"policy": None, "ppo": None}, r"transition = 0.5\n.*no policy network"),
        ({"hidden_unit": 1e-9}, {}, r"hidden_unit = 1e-09\n.*too little"),
        ({"receptor": -1.0}, {}, "receptor"),
    ],
)
def test_costs_of_what_it_lacks_are_refused(meadow, costs, changes, message):
    with pytest.raises(ConfigError, match=message):
        build(meadow, costs, **changes)


def test_worlds_without_costs_have_neither_the_key_nor_the_system(meadow):
    world = meadow()
    assert "neural_costs" not in load("predator-prey").model_dump()["species"]["deer"]
    assert NeuralCost not in world.table("deer")
    assert not any(isinstance(system, MaintainNerves) for system in world.systems)
