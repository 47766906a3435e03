"""The order of the sections of a world file has no effect."""

from pathlib import Path

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.analysis.runs import load_series
from ecs_eco.config import load
from ecs_eco.config.shipped import shipped

EXAMPLES = [
    path
    for path in sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))
    if "[space]" in path.read_text()
]

LISTS = "diet", "exchange"


def permuted(config, rng):
    """Return a configuration with its sections, and the entries of its diets, exchanges and emissions, in
    another order."""
    species = {}
    for name, kind in config.species.items():
        ways = {
            key: [getattr(kind, key)[i] for i in rng.permutation(len(getattr(kind, key)))] for key in LISTS
        }
        species[name] = kind.model_copy(update=ways | {"emits": dict(reversed(kind.emits.items()))})
    sections = {name: dict(getattr(config, name)) for name in ("objects", "fields", "substances")}
    for name, section in (sections | {"species": species}).items():
        kinds = list(section.items())
        other = [kinds[i] for i in rng.permutation(len(kinds))]
        sections[name] = dict(other[::-1] if other == kinds else other)
    return config.model_copy(update=sections)


def digest(config, ticks, given=None):
    """Return the digest after some ticks, with the configuration `given` for the order of exchanges in it."""
    world = World.from_config(config, seed=1, policies="untrained", record=False)
    world.run(ticks)
    world.config = given or world.config
    return world.digest(), world.next_uid


@pytest.mark.parametrize("name", [*shipped(), *map(str, EXAMPLES)], ids=lambda name: Path(name).stem)
def test_a_world_is_the_same_whatever_comes_first_in_its_file(name):
    config = load(name, trust=True)
    if config.archipelago is not None:
        pytest.skip("several worlds")
    rng = np.random.default_rng(0)
    assert digest(permuted(config, rng), 3, config) == digest(config, 3)


def drawn(rng):
    """Return a world of three to five species that may eat each other, smell, exchange and carry."""
    names = rng.choice(["ash", "bee", "cow", "doe", "elk", "fox"], rng.integers(3, 6), replace=False).tolist()
    species = {}
    for name in names:
        eaten = [str(food) for food in rng.permutation(names)[: rng.integers(0, 4)]]
        species[name] = {
            "count": int(rng.integers(10, 40)),
            "body": {"radius": float(rng.choice([0.25, 0.5]))},
            "metabolism": {"energy": 0.5, "energy_max": 1.0, "handling_time": float(rng.choice([0.0, 2.0]))},
            "locomotion": {"speed": {"go": 1.0}, "turn": 0.5},
            "actions": {"speed": ["go"], "turn": ["left", "none", "right"]},
            "sensors": [
                {"kind": "property", "property": "salt", "range": 4.0},
                {"kind": "touch", "target": "any"},
            ],
            "emits": {
                "smell": 1.0,
                "musk": {"substance": "salt", "rate": 0.25, "consume": True},
                "dust": {"substance": "salt", "rate": float(rng.choice([0.125, 0.25])), "consume": True},
            },
            "substances": {"salt": 0.1, "air": 0.01},
            "exchange": [
                {"kind": "uptake", "field": "pool", "rate": 0.5},
                {"kind": "uptake", "field": "pool", "rate": 0.25, "at": [2.0, 0.0]},
                {"kind": "equilibrate", "field": "sky", "rate": 0.25, "partition": 2.0},
                {"kind": "equilibrate", "field": "sky", "rate": 0.5, "partition": 1.0},
            ],
            "carries": [{"object": "stone", "reach": 1.0}],
            "diet": [
                {
                    "eats": food,
                    "reach": float(rng.choice([0.25, 1.0])),
                    "chance": 0.9,
                    "gain": 0.25,
                    "efficiency": 0.5,
                }
                for food in eaten
            ],
            "reproduction": {"kind": "asexual", "rate": 0.2, "energy_min": 0.4, "energy_given": 0.2},
            "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
        }
    return {
        "format": 1,
        "name": "drawn",
        "space": {"size": [20.0, 20.0]},
        "substances": {"salt": "", "air": ""},
        "fields": {
            "smell": {"cell": 2.0, "diffusion": 0.1, "decay": 0.1},
            "musk": {"cell": 2.0, "diffusion": 0.1, "decay": 0.1},
            "dust": {"cell": 2.0, "diffusion": 0.1, "decay": 0.1},
            "pool": {"cell": 5.0, "substance": "salt", "initial": 0.001},
            "sky": {"cell": 5.0, "substance": "air", "initial": 0.001},
        },
        "objects": {
            "stone": {"count": 20, "body": {"radius": 0.25, "opaque": False}},
            "pebble": {"count": 5, "body": {"radius": 0.25, "opaque": False}},
        },
        "species": species,
    }


@pytest.mark.parametrize("seed", range(20))
def test_a_world_drawn_at_random_is_the_same_whatever_comes_first_in_it(seed):
    rng = np.random.default_rng(seed)
    config = load(drawn(rng))
    assert digest(permuted(config, rng), 4, config) == digest(config, 4)


def test_two_grazers_of_one_kind_share_a_meadow_equally():
    grazer = {
        "count": 30,
        "body": {"radius": 0.25, "opaque": False},
        "metabolism": {"energy": 0.5, "energy_max": 1.0, "basal": 0.02},
        "locomotion": {"speed": {"go": 1.0}, "turn": 0.5},
        "actions": {"speed": ["go"], "turn": ["left", "none", "right"]},
        "diet": [{"eats": "grass", "reach": 0.5, "gain": 0.25}],
        "reproduction": {"kind": "asexual", "rate": 0.2, "energy_min": 0.6, "energy_given": 0.3},
        "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
    }
    way = {"kind": "spread", "rate": 0.0, "seed_rain": 0.03, "spacing": 1.0}
    grass = {"count": 100, "body": {"radius": 0.1, "opaque": False}, "reproduction": way}
    config = {"format": 1, "name": "meadow", "space": {"size": [16.0, 16.0]}}
    config["species"] = {"ant": grazer, "grass": grass, "bee": grazer}
    taken = []
    for seed in range(8):
        series = World.from_config(config, seed=seed, policies="random").run(60).series().to_pydict()
        whose = np.array(series["species"])
        taken.append([np.sum(series["taken_in"], where=whose == name) for name in ("ant", "bee")])
    ant, bee = np.sum(taken, axis=0)
    assert ant / (ant + bee) == pytest.approx(0.5, abs=0.06)  # three standard errors


def test_what_people_read_is_in_the_order_of_the_file_whatever_the_order_of_tables(menagerie):
    data = menagerie()
    for names in (["moss", "ram", "lynx"], ["lynx", "moss", "ram"]):
        data["species"] = {name: data["species"][name] for name in names}
        world = World.from_config(data, policies="untrained").run(2)
        assert world.series().to_pydict()["species"] == names * 2
        assert load_series(world.series()).species == tuple(names)
