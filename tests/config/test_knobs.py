"""Knobs that a world names for its page: what they may be, and that nothing but the page knows of them."""

import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.config.knobs import coded, offered
from ecs_eco.config.loading import changed, read_document
from ecs_eco.config.mutable_keys import changes, refused
from ecs_eco.config.numbers import values_in, with_value
from ecs_eco.config.shipped import shipped
from ecs_eco.engine.errors import ConfigError

BASAL = "species.deer.metabolism.basal"


def world(*knobs):
    data = read_document("predator-prey").data
    return data | {"viewer": {"knobs": list(knobs)}}


def knob(key=BASAL, low=0.0, high=0.02, **more):
    return {"key": key, "min": low, "max": high} | more


def refusal(*knobs):
    with pytest.raises(ConfigError) as caught:
        load(world(*knobs))
    return str(caught.value)


def test_a_knob_has_label_ends_and_the_unit_of_its_key():
    config = load(
        world(
            knob(label="upkeep"),
            knob("species.wolf.metabolism.handling_time", 0, 60),
            knob("species.deer.diet.0.chance", 0, 1, unit="chance"),
        )
    )
    assert offered(config)["knobs"] == [
        {"key": BASAL, "label": "upkeep", "low": 0.0, "high": 0.02, "unit": "energy/s"},
        {
            "key": "species.wolf.metabolism.handling_time",
            "label": "species.wolf.metabolism.handling_time",
            "low": 0.0,
            "high": 60.0,
            "unit": "s",
        },
        {
            "key": "species.deer.diet.0.chance",
            "label": "species.deer.diet.0.chance",
            "low": 0.0,
            "high": 1.0,
            "unit": "chance",
        },
    ]
    whole = {row["key"]: row["whole"] for row in offered(config)["list"]}
    assert whole["species.deer.reproduction.litter"]
    assert not whole[BASAL]
    assert offered(None) == {"list": [], "knobs": []}


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (knob("species.dear.metabolism.basal"), ["viewer.knobs.0.key", "no 'dear'", 'did you mean "deer"?']),
        (knob("species.deer.metabolism.bassal"), ['did you mean "basal"?']),
        (knob("species.deer.count", 0, 1000), ["cannot change during a run", '"add" or "cull"']),
        (knob("species.deer.happiness.formula"), ["is not a number", "energy - 0.3"]),
        (knob("species.deer.max_count"), ["has no value"]),
        (knob("seed", 0, 10), ["has no effect during a run"]),
        (knob(low=0.02, high=0.02), ["viewer.knobs.0.max", "is not above min", "more than min, 0.02"]),
        (knob(low=0.01), ["viewer.knobs.0.min", "the range does not contain the world's value, 0.004"]),
        (knob(high=0.003), ["viewer.knobs.0.max", "the range does not contain the world's value, 0.004"]),
        (knob(name="upkeep"), ["viewer.knobs.0.name", "unknown key", "label"]),
    ],
)
def test_a_wrong_knob_is_refused_with_its_place_and_what_is_allowed(wrong, words):
    message = refusal(wrong)
    assert [word for word in words if word not in message] == [], message


def test_each_key_is_a_knob_once():
    assert "is already a knob" in refusal(knob(), knob(high=0.03))


def test_what_a_gene_codes_for_is_no_knob():
    data = read_document("happiness").data
    data["viewer"] = {"knobs": [knob("species.berry.defence.toughness", 0, 1)]}
    with pytest.raises(ConfigError, match="the gene tough codes for it"):
        load(data)


def test_knobs_are_in_no_hash_and_decide_nothing():
    with_knobs, without = load(world(knob())), load(world())
    assert with_knobs.config_hash == without.config_hash
    assert with_knobs.resolved() == without.resolved()
    assert "viewer" not in with_knobs.resolved()


def test_values_from_outside_may_lie_beyond_the_ends():
    config = load("predator-prey", {BASAL: 0.5})
    assert offered(config)["knobs"]
    no_hunters = load(
        "predator-prey",
        [
            "species.wolf.diet=[]",
            'species.wolf.actions={"turn" = ["left"]}',
            "species.wolf.default_action={}",
            "species.wolf.always_on=[]",
            "training.set={}",
        ],
    )
    left = {knob["key"] for knob in offered(no_hunters)["knobs"]}
    assert "species.wolf.diet.0.chance" in {knob.key for knob in no_hunters.viewer.knobs} - left
    assert BASAL in left
    again = changed(load("predator-prey"), {BASAL: 0.7})
    assert again.viewer == load("predator-prey").viewer
    assert again.species["deer"].metabolism.basal == 0.7


def test_a_world_keeps_its_knobs_through_a_change_a_copy_and_a_checkpoint(tmp_path):
    small = {
        "space.size": [30, 30],
        "species.grass.count": 20,
        "species.deer.count": 5,
        "species.wolf.count": 2,
    }
    original = World.from_config(load("predator-prey", small), seed=1, policies="random", record=False)
    knobs = original.config.viewer
    assert knobs.knobs
    original.intervene({"kind": "set", "set": {BASAL: 0.01}})
    original.run(2)
    assert original.config.viewer == original.copy().config.viewer == knobs
    original.save(tmp_path / "world.ckpt")
    assert World.restore(tmp_path / "world.ckpt", record=False).config.viewer == knobs


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_world_has_knobs_with_words(name):
    knobs = offered(load(name))["knobs"]
    assert len(knobs) == len(load(name).viewer.knobs) >= 3
    assert not [knob["label"] for knob in knobs if knob["label"].startswith("species.")]


GENES = {  # trait: where the file has its value; None where it is no value of the file
    "reflex.wolf_near_run.weight": "reflex.connections.0.weight",
    "reflex.wolf_near_run.threshold": "reflex.connections.0.above",
    "reflex.rest.threshold": "reflex.connections.1.below",
    "happiness.energy": "happiness.weights.energy",
    "diet.grass.chance": "diet.0.chance",
    "lethal.energy.min": "lethal.0.min",
    "life.age_max": "lethal.1.max",
    "metabolism.basal": "metabolism.basal",
    "locomotion.speed.walk": "locomotion.speed.walk",
    "reproduction.litter": "reproduction.litter",
    "locomotion.pace": None,
    "reproduction.energy_min": "reproduction.energy_min",
}
REFLEX = {
    "connections": [
        {"sensor": "wolf_near", "action": "run", "above": 0.5, "weight": 0},
        {"sensor": "energy", "action": "still", "below": 0.2, "weight": 0, "name": "rest"},
    ]
}


def coded_world():
    ends = {
        "reflex.wolf_near_run.weight": (-1, 1),
        "reproduction.litter": (1, 4),
        "lethal.energy.min": (0, 0.25),
        "life.age_max": (100, 900),
    }
    genes = [
        {
            "name": f"g{i}",
            "trait": trait,
            "letters": 2,
            **dict(zip(("low", "high"), ends.get(trait, (0.5, 0.9)), strict=True)),
        }
        for i, trait in enumerate(GENES)
    ]
    config = load("predator-prey")
    deer = config.model_dump(mode="json", exclude_unset=True)["species"]["deer"]
    deer |= {
        "genome": {"genes": genes},
        "reflex": REFLEX,
        "happiness": {"weights": {"energy": 1.0}, "minimum": -1.0},
    }
    data = read_document("predator-prey").data
    return load(data | {"species": data["species"] | {"deer": deer}, "viewer": {}})


def test_what_a_gene_codes_for_is_not_offered_and_all_that_is_can_be_set():
    config = coded_world()
    listed = {row["key"] for row in offered(config)["list"]}
    plain = {row["key"] for row in offered(load("predator-prey"))["list"]}
    for key in filter(None, GENES.values()):
        assert f"species.deer.{key}" not in listed, key
    assert {
        f"species.deer.{key}"
        for key in GENES.values()
        if key and "connections" not in key and "weights" not in key
    } <= plain
    assert {
        "species.deer.reflex.connections.1.weight",
        "species.deer.locomotion.speed.run",
        "species.wolf.metabolism.basal",
    } <= listed
    assert "species.deer.reflex.connections.0.above" not in listed


def with_places(old, new):
    """The key of the one value that differs, with places in lists."""
    ((key, _, _),) = changes(old, new)
    return map(str, key)


@pytest.mark.parametrize("name", ["made", "reflexes", "happiness"])
def test_coded_is_just_what_no_intervention_may_change_since_a_gene_codes_for_it(name):
    config = coded_world() if name == "made" else load(name)
    for kind, species in config.species.items():
        found = set()
        for number, key, value in values_in(species):
            changed_one = with_value(species, key, int(value) + 1 if number.whole else value + 1.0)
            problems = refused(
                config, config.model_copy(update={"species": config.species | {kind: changed_one}})
            )
            if any("codes for it" in str(problem) for problem in problems):
                found.add(".".join(with_places(species.model_dump(), changed_one.model_dump())))
        genes = {
            key.removeprefix(f"species.{kind}.")
            for key in coded(config)
            if key.startswith(f"species.{kind}.")
        }
        assert genes == found, kind
