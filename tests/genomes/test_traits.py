"""Which values of a species can be heritable, and where they are kept."""

import subprocess
import sys
from itertools import pairwise

import pytest

from ecs_eco import component, components as shipped, f32, u8
from ecs_eco.config import load
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.shapes import policy_shapes
from ecs_eco.config.traits import traits_of
from ecs_eco.genomes import Trait

BEAST = {
    "count": 3,
    "body": {"radius": 0.4, "mass": 7.0},
    "metabolism": {"energy": 0.5, "photosynthesis": 0.1},
    "sex": "random",
    "locomotion": {"speed": {"sit": 0.0, "hop": 1.0}, "turn": 0.8},
    "defence": {"toughness": 0.25, "poison": 2.0},
    "heat": {"insulation": 0.125},
    "sensors": [
        {"kind": "own", "property": "energy"},
        {"kind": "nearest", "name": "eye", "target": "beast", "range": 5.0},
        {"kind": "smell", "name": "nose", "field": "musk", "at": [1.0, -0.5]},
        {"kind": "light", "name": "pit", "at": [0.5, 0.0]},
        {"kind": "touch", "name": "skin", "at": [-1.0, 1.0]},
    ],
    "actions": {"speed": ["sit", "hop"], "turn": ["left", "none", "right"]},
    "reflex": {
        "connections": [
            {"name": "flee", "sensor": "nose", "action": "hop", "weight": 1, "above": 0.5},
            {"sensor": "energy", "action": "sit", "weight": -1, "below": 0.2},
        ]
    },
    "happiness": {"weights": {"energy": 1.0, "nose": -0.3}, "minimum": -1.0},
    "policy": {"kind": "individual", "hidden": [8, 6]},
    "ppo": {"discount": 0.9},
    "reproduction": {
        "kind": "sexual",
        "energy_min": 0.6,
        "energy_given": 0.2,
        "age_min": 30.0,
        "litter": 2,
        "choice": "oldest",
    },
    "lethal": [{"property": "energy", "min": 0.0}, {"property": "age", "max": 900.0}],
}


def species(**changes):
    world = {"format": 1, "name": "w", "space": {"size": [50.0, 50.0]}, "fields": {"musk": {"cell": 2.0}}}
    world["species"] = {"beast": BEAST | changes}
    return WorldConfig.model_validate(world).species["beast"]


@pytest.mark.definition("3 genome encodes")
def test_every_heritable_value_of_a_species_is_listed_with_its_column_and_own_value() -> None:
    listed = traits_of(species(), 2).values()
    organs = {"policy.hidden.0", "policy.hidden.1"} | {
        f"{part}.present"
        for part in (
            "sensors.energy",
            "sensors.eye",
            "sensors.nose",
            "sensors.pit",
            "sensors.skin",
            "actions.speed.sit",
            "actions.speed.hop",
            "actions.turn.left",
            "actions.turn.none",
            "actions.turn.right",
        )
    }
    numbers = {t.name for t in listed if t.component == "Traits"} - organs
    assert len(organs) == 12
    assert {name for name in numbers if name.startswith("sensors.")} == {
        "sensors.energy.scale",
        "sensors.eye.blind",
        "sensors.eye.fov",
        "sensors.nose.half_saturation",
        "sensors.pit.scale",
        "sensors.pit.zero",
    }
    assert {"ppo.clip", "ppo.epochs", "ppo.gae_lambda"} <= numbers
    assert {name for name in numbers if not name.startswith(("ppo.", "sensors."))} == {
        "body.sinking",
        "heat.specific_heat",
        "heat.conductance",
        "heat.metabolic_heat",
        "metabolism.energy_max",
        "metabolism.basal",
        "metabolism.handling_time",
        "locomotion.speed.sit",
        "locomotion.speed.hop",
        "locomotion.turn",
        "locomotion.climb",
        "locomotion.pitch",
        "locomotion.drag",
        "defence.cost",
        "happiness.minimum",
        "reproduction.spacing",
        "reproduction.father_share",
        "reproduction.reach",
        "reproduction.chance",
        "reproduction.gestation",
        "reproduction.rest",
        "reproduction.father_rest",
        "lethal.energy.min",
    }
    traits = {t.name: (t.component, t.field, t.index, t.default) for t in listed if t.component != "Traits"}
    assert traits == {
        "body.radius": ("Body", "radius", None, 0.4),
        "body.mass": ("Body", "mass", None, 7.0),
        "locomotion.pace": ("SpeedScale", "pace", None, 1.0),
        "metabolism.photosynthesis": ("Growth", "growth", None, 0.1),
        "heat.insulation": ("Coat", "insulation", None, 0.125),
        "defence.toughness": ("Defence", "toughness", None, 0.25),
        "defence.poison": ("Defence", "poison", None, 2.0),
        "sensors.eye.range": ("Senses", "radius", 1, 5.0),
        "sensors.eye.forward": ("Senses", "forward", 1, 0.0),
        "sensors.eye.left": ("Senses", "left", 1, 0.0),
        "sensors.nose.forward": ("Senses", "forward", 2, 1.0),
        "sensors.nose.left": ("Senses", "left", 2, -0.5),
        "sensors.pit.forward": ("Senses", "forward", 3, 0.5),
        "sensors.pit.left": ("Senses", "left", 3, 0.0),
        "reflex.flee.weight": ("Reflexes", "weight", 0, 1),
        "reflex.flee.threshold": ("Reflexes", "threshold", 0, 0.5),
        "reflex.energy_sit.weight": ("Reflexes", "weight", 1, -1),
        "reflex.energy_sit.threshold": ("Reflexes", "threshold", 1, 0.2),
        "happiness.energy": ("HappinessWeights", "weight", 0, 1.0),
        "happiness.nose": ("HappinessWeights", "weight", 1, -0.3),
        "policy.weights": ("Policy", "weights", None, 0.0),
        "ppo.learning_rate": ("LearningRates", "learning_rate", None, 3e-4),
        "ppo.discount": ("LearningRates", "discount", None, 0.9),
        "ppo.entropy_coef": ("LearningRates", "entropy", None, 0.01),
        "fertility": ("Biology", "fertility", None, 1.0),
        "life.age_max": ("LifeHistory", "age_max", None, 900.0),
        "reproduction.age_min": ("LifeHistory", "age_min", None, 30.0),
        "reproduction.energy_min": ("LifeHistory", "energy_min", None, 0.6),
        "reproduction.energy_given": ("LifeHistory", "energy_given", None, 0.2),
        "reproduction.litter": ("LifeHistory", "litter", None, 2.0),
        "reproduction.choice": ("LifeHistory", "choice", None, 3.0),
    }


def test_a_plant_has_no_more_than_its_own() -> None:
    grass = load("predator-prey").species["grass"]
    own = [
        "body.mass",
        "body.radius",
        "body.sinking",
        "defence.cost",
        "defence.poison",
        "defence.toughness",
        "emits.grass_smell",
        "metabolism.basal",
        "metabolism.energy_max",
        "metabolism.handling_time",
        "metabolism.photosynthesis",
        "reproduction.rate",
        "reproduction.spread",
    ]
    assert sorted(traits_of(grass, 2)) == own


def test_a_shared_brain_is_nobodys_own() -> None:
    assert not [
        t for t in traits_of(species(policy={"kind": "shared"}), 2) if t.startswith(("policy", "ppo"))
    ]


def test_every_trait_is_a_field_of_a_shipped_component_with_an_own_value_in_bounds() -> None:
    for trait in traits_of(species(), 2).values():
        assert trait.field in getattr(shipped, trait.component).fields, trait.name
        assert trait.low <= trait.default <= trait.high, trait.name
        assert trait.text
        assert trait.unit
        column = getattr(shipped, trait.component).fields[trait.field][0]
        assert trait.component == "Traits" or (trait.index is None) == (
            not column.shape or trait.kind == "weights"
        )


@component
class Wool:
    """The coat of one animal."""

    length: f32 = 0.01  # [m]
    color: u8 = 3
    pattern: f32[2] = 0.0


def test_numbers_of_a_component_of_ones_own_are_traits() -> None:
    traits = traits_of(species(), 2, [Wool])
    text = "The coat of one animal."
    assert traits["Wool.length"] == Trait(
        "Wool.length", "Wool", "length", None, 0.01, -1e30, 1e30, "number", "own", text
    )
    assert (traits["Wool.color"].kind, traits["Wool.color"].low, traits["Wool.color"].high) == (
        "whole",
        0.0,
        255.0,
    )
    assert "Wool.pattern" not in traits


def test_the_shapes_of_a_brain_are_known_before_there_is_one() -> None:
    widths = [1 + 3 + 1 + 1 + 1, 8, 6, 2 + 3 + 1]
    expected = [s for a, b in pairwise(widths) for s in ((a, b), (b,))]
    assert policy_shapes(species(), 2) == expected
    individual = pytest.importorskip("ecs_eco.learning.individual")
    from ecs_eco.learning import PPO

    minds = individual.Individuals(widths[0], (2, 3), (8, 6), PPO(), seed=1)
    assert minds.shapes == expected


def test_looking_at_genomes_for_the_configuration_loads_nothing_heavy() -> None:
    code = (
        "import sys, ecs_eco.genomes.models, ecs_eco.config.checks.genome, ecs_eco.genomes.layout, "
        "ecs_eco.genomes.traits\n"
        "from ecs_eco.genomes import Layout, Gene; Layout([Gene(name='a', letters=2, low=0, high=1)])\n"
        "print([m for m in ('numba', 'torch', 'deap') if m in sys.modules])"
    )
    assert (
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout.strip()
        == "[]"
    )
