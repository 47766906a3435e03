"""Worlds that tests are made of; what puts organisms in place is ecs_eco.testing's."""

import copy
import gc
import os
import signal

import esper
import pytest
from hypothesis import settings

settings.register_profile("ecs-eco", deadline=None)  # how long an example takes says how busy the machine is
settings.load_profile("ecs-eco")

# begun in the background: else commands that tests stop would never hear of it
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Give all tests of a file to one worker, so that what its tests share is made once."""
    from xdist.scheduler import LoadFileScheduling

    if config.getvalue("dist") == "load":  # what `-n` alone means
        config.option.loadscopereorder = False  # the order of files stays random, too
        return LoadFileScheduling(config, log)
    return None


def pytest_collection_finish():
    """What collection made stays until the end, so the garbage collector need not look at it again."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="module", autouse=True)
def _leaves_no_worlds():
    """Worlds refer to themselves, so without this their columns stay until the collector happens to run."""
    yield
    gc.collect()


PHYSICAL = {"temperature": 311.0, "pressure": 13_000.0, "electric_current": 1e-6, "luminous_intensity": 0.02}

MENAGERIE = {  # everything that a world file can say, in little
    "format": 1,
    "name": "menagerie",
    "dt": 0.5,
    "seed": 3,
    "space": {"size": [40.0, 30.0], "edges": "walls"},
    "terrain": {
        "cell": 1.0,
        "hills": {"seed": 1, "amplitude": 2.0, "scale": 15.0},
        "rocks": [{"at": [10.0, 8.0], "radius": 3.0}],
        "lakes": [{"at": [30.0, 20.0], "radius": 4.0}],
        "slope_cost": 2.0,
        "roads": [{"line": [[2.0, 2.0], [2.0, 28.0], [25.0, 28.0]], "width": 3.0, "pace": 1.5, "cost": 0.5}],
    },
    "land_use": [
        {
            "kind": "harvest",
            "species": "moss",
            "rate": 0.05,
            "quota": 4,
            "period": 10.0,
            "season": [0.2, 0.9],
            "region": [20.0, 15.0, 8.0],
            "cause": "cut",
        },
        {"kind": "plant", "species": "moss", "rate": 0.5, "region": [0.0, 0.0, 10.0, 10.0], "up_to": 40},
    ],
    "ambient": {"temperature": 280.0, "light": 0.8},
    "substances": {"glucose": "blood sugar", "oxygen": "dissolved", "hydron": "acid"},
    "fields": {
        "musk": {"cell": 2.0, "diffusion": 0.5, "decay": 0.1},
        "air": {
            "cell": 5.0,
            "diffusion": 1.0,
            "decay": 0.001,
            "substance": "oxygen",
            "initial": 0.009,
            "renewal": 0.01,
        },
        "pond": {"cell": 2.0, "substance": "hydron", "initial": 1e-7, "depth": 0.5, "only": "lakes"},
    },
    "objects": {
        "boulder": {
            "at": [[20.0, 15.0], [33.0, 6.0]],
            "body": {"radius": 1.5, "mass": 9000.0, "solid": True},
            "properties": {"temperature": 275.0},
            "heat": {"specific_heat": 800.0},
            "substances": {"hydron": 1e-7},
        },
        "carcass": {
            "body": {"radius": 0.2, "mass": 1.0, "opaque": False},
            "energy": {"decay": 0.05},
            "decomposition": {"rate": 0.02},
        },
        "cone": {
            "count": 12,
            "body": {"radius": 0.1, "mass": 0.05, "opaque": False},
            "renewal": 0.1,
            "motion": {"velocity": [0.25, 0.125]},
        },
        "cairn": {"body": {"radius": 0.4, "solid": True}, "pushed": True},
    },
    "species": {
        "moss": {
            "count": 150,
            "body": {"radius": 0.3, "mass": 0.1, "opaque": False},
            "metabolism": {"energy": 0.1, "energy_max": 0.3, "photosynthesis": 0.02},
            "reproduction": {
                "kind": "spread",
                "rate": 0.1,
                "seed_rain": 0.01,
                "spacing": 2.0,
                "place": "near",
                "dispersal": 4.0,
            },
        },
        "ram": {
            "count": 40,
            "body": {"radius": 0.5, "mass": 80.0, "solid": True},
            "sex": "random",
            "fertility": 0.8,
            "properties": PHYSICAL,
            "substances": {"glucose": 0.005, "oxygen": 0.008, "hydron": 4e-8},
            "metabolism": {"energy": 0.6, "energy_max": 1.0, "basal": 0.01},
            "locomotion": {
                "speed": {"still": 0.0, "walk": 0.5, "run": 2.0},
                "cost": {"walk": 0.01, "run": 0.05},
                "turn": 0.8,
            },
            "reactions": [
                {
                    "from": {"glucose": 1.0, "oxygen": 6.0},
                    "to": {"hydron": 1e-6},
                    "energy": 0.01,
                    "rate": 1e-5,
                    "half": {"oxygen": 0.001},
                },
                {"from": {"hydron": 1.0}, "to": {}, "rate": 1e-9, "light": True},
            ],
            "exchange": [
                {
                    "kind": "uptake",
                    "field": "air",
                    "rate": 0.001,
                    "concentration_max": 0.008,
                    "at": [1.0, 0.0],
                },
                {"kind": "equilibrate", "field": "pond", "rate": 0.001},
                {"kind": "release", "substance": "hydron", "rate": 0.01, "above": 3e-8},
            ],
            "born_with": "mother",
            "emits": {"musk": 1.0, "air": {"substance": "oxygen", "rate": 1e-4, "consume": True}},
            "diet": [{"eats": "moss", "reach": 0.3, "gain": 0.3}],
            "sensors": [
                {"kind": "own", "property": "energy"},
                {"kind": "own", "property": "age", "scale": 100.0},
                {"kind": "own", "property": "glucose", "scale": 0.01},
                {"kind": "own", "property": "temperature", "scale": 300.0},
                {"kind": "nearest", "target": "moss", "range": 6.0},
                {"kind": "nearest", "target": "lynx", "range": 8.0, "fov": 4.0, "occlusion": True},
                {
                    "kind": "rays",
                    "name": "eye",
                    "count": 5,
                    "fov": 2.0,
                    "range": 8.0,
                    "targets": ["lynx", "wall"],
                    "at": [1.0, 0.0],
                    "angle": 0.25,
                },
                {
                    "kind": "property",
                    "property": "luminous_intensity",
                    "range": 7.0,
                    "decay": "inverse_square",
                },
                {
                    "kind": "property",
                    "property": "mass",
                    "of": ["moss", "lynx"],
                    "range": 5.0,
                    "at": [1.0, -0.5],
                    "decay": "linear",
                    "scale": 20.0,
                },
                {
                    "kind": "property",
                    "property": "glucose",
                    "of": "ram",
                    "range": 9.0,
                    "report": "mean",
                    "zero": 0.004,
                    "scale": 0.001,
                },
                {"kind": "smell", "field": "musk", "at": [1.0, 0.5]},
                {"kind": "smell", "field": "musk", "at": [1.0, -0.5]},
                {"kind": "touch", "target": "any", "at": [-0.8, 0.8]},
                {"kind": "light", "at": [1.0, 0.0]},
                {"kind": "temperature", "zero": 273.0, "scale": 40.0},
                {"kind": "pressure", "scale": 101_325.0},
            ],
            "actions": {"speed": ["still", "walk", "run"], "turn": ["left", "none", "right"], "eat": ["eat"]},
            "default_action": {"speed": "still", "turn": "none"},
            "reflex": {"connections": [{"sensor": "energy", "action": "eat", "weight": -1, "above": 0.95}]},
            "happiness": {"formula": "energy - 0.2 * musk", "minimum": -1.0},
            "policy": {"kind": "shared", "hidden": [8]},
            "ppo": {"horizon": 12, "minibatch_size": 256, "epochs": 2},
            "reproduction": {
                "kind": "asexual",
                "rate": 0.05,
                "energy_min": 0.5,
                "energy_given": 0.25,
                "dispersal": 3.0,
            },
            "lethal": [
                {"property": "energy", "min": 0.0, "cause_below": "starved"},
                {"property": "age", "max": 60.0, "cause_above": "too old"},
                {
                    "property": "temperature",
                    "min": 300.0,
                    "max": 316.0,
                    "cause_below": "too cold",
                    "cause_above": "too hot",
                },
                {"property": "hydron", "max": 1.6e-7, "cause_above": "too acid"},
                {"property": "glucose", "min": 0.001},
            ],
            "remains": "carcass",
        },
        "lynx": {
            "count": 8,
            "body": {"radius": 0.6, "mass": 25.0, "solid": True, "compressible": True},
            "properties": {"temperature": 311.0, "pressure": 101_325.0},
            "heat": {
                "insulation": 0.2,
                "metabolic_heat": 1e4,
                "regulate": {"set_point": 311.0, "warming": 400.0, "cooling": 50.0, "cost": 1e-6},
            },
            "metabolism": {"energy": 0.5, "basal": 0.01, "handling_time": 3.0},
            "locomotion": {
                "speed": {"still": 0.0, "walk": 1.0, "run": 2.5},
                "cost": {"run": 0.02},
                "turn": 1.0,
            },
            "diet": [{"eats": "ram", "reach": 0.2, "chance": 0.6, "gain": 0.5}],
            "carries": [{"object": "cone", "reach": 0.5, "cost": 0.001}],
            "builds": [{"object": "cairn", "cost": 0.01, "spacing": 4.0, "most": 9}],
            "sensors": [{"kind": "nearest", "target": "ram", "range": 9.0}],
            "actions": {"speed": ["still", "walk", "run"], "turn": ["left", "none", "right"], "eat": ["eat"]},
            "default_action": {"speed": "walk", "turn": "none"},
            "always_on": ["eat"],
            "reflex": {
                "formulas": {"run": "ram_near - 0.3", "left": "ram_left - 0.1", "right": "-ram_left - 0.1"}
            },
            "reproduction": {
                "kind": "asexual",
                "place": "anywhere",
                "rate": 0.02,
                "energy_min": 0.6,
                "energy_given": 0.3,
                "spacing": 2.0,
            },
            "lethal": [
                {"property": "energy", "min": 0.0, "cause_below": "starved"},
                {"property": "temperature", "min": 305.0, "cause_below": "frozen"},
                {"property": "pressure", "max": 200_000.0, "cause_above": "crushed"},
            ],
        },
    },
}

MEADOW = {  # what a test of one thing starts from: grazers that walk and eat, and grass, on a plane
    "format": 1,
    "name": "meadow",
    "space": {"size": [20.0, 20.0]},
    "species": {
        "grass": {"count": 2, "body": {"radius": 0.25, "opaque": False}, "metabolism": {"energy": 0.5}},
        "deer": {
            "count": 2,
            "body": {"radius": 0.5},
            "metabolism": {"energy": 0.5, "basal": 0.01},
            "locomotion": {
                "speed": {"still": 0.0, "walk": 1.0, "run": 3.0},
                "cost": {"walk": 0.02, "run": 0.1},
                "turn": 0.5,
            },
            "diet": [{"eats": "grass", "reach": 0.25, "gain": 0.25}],
            "sensors": [{"kind": "own", "property": "energy"}],
            "actions": {"speed": ["still", "walk", "run"], "turn": ["left", "none", "right"], "eat": ["eat"]},
            "default_action": {"speed": "still", "turn": "none"},
            "always_on": ["eat"],
            "happiness": {"formula": "energy", "minimum": -1.0},
            "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
        },
    },
}


def merge(base, changes):
    """Put nested changes into a copy of a configuration; None takes a key away."""
    out = copy.deepcopy(base)
    for key, value in changes.items():
        if value is None:
            out.pop(key, None)
        else:
            out[key] = (
                merge(out[key], value)
                if isinstance(value, dict) and isinstance(out.get(key), dict)
                else value
            )
    return out


@pytest.fixture(scope="session")
def menagerie():
    """A function of changes that returns the configuration of a small world with everything in it."""
    return lambda **changes: merge(MENAGERIE, changes)


@pytest.fixture(scope="session")
def meadow():
    """A function of changes to its species deer (and `world=` to the world) that returns a new world
    of two deer and two grasses."""
    from ecs_eco import World

    def build(*, world=None, options=None, grass=None, **deer):
        config = merge(MEADOW, {"species": {"deer": deer, "grass": grass or {}}})
        return World.from_config(merge(config, world or {}), **(options or {}))

    return build


@pytest.fixture(autouse=True)
def _leaves_the_environment_as_it_was():
    """What a study sets as it is imported is not for the processes that later tests start."""
    before = dict(os.environ)
    yield
    for name in os.environ.keys() - before.keys() - {"PYTEST_CURRENT_TEST"}:
        del os.environ[name]
    os.environ.update({name: value for name, value in before.items() if name != "PYTEST_CURRENT_TEST"})


@pytest.fixture(autouse=True)
def _leaves_esper_as_it_was():
    from ecs_eco.esper_bridge import turns

    # a viewer's second world lives in a thread of its own, and esper is in it whenever a tick passes
    with turns.turn:
        before = esper.current_world
    yield
    assert not turns.turn.held(), "the test left a world entered"
    with turns.turn:
        assert esper.current_world == before, "the test left esper in another world"
