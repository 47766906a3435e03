"""Files of weights name what they sense and choose."""

from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.config.notes import notes
from ecs_eco.config.shipped import WORLDS
from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab.pretraining import pretrain
from ecs_eco.learning import weights
from ecs_eco.worlds.policies import load_weights, name_weights

SENSORS = [{"kind": "own", "property": "energy"}, {"kind": "own", "property": "age", "scale": 50.0}]


def herd(sensors=SENSORS, speed=("sit", "go"), turn=("left", "none", "right"), gaits=None, **policy):
    goat = {
        "count": 5,
        "body": {"radius": 0.1},
        "sensors": list(sensors),
        "metabolism": {"basal": 0.0},
        "actions": {"speed": list(speed), "turn": list(turn)},
        "locomotion": {"speed": gaits or {"sit": 0.0, "go": 0.5}, "turn": 0.5},
        "happiness": {"formula": "age", "minimum": 0.0},
        "policy": {"kind": "shared", "hidden": [4], **policy},
    }
    return load(
        {
            "format": 1,
            "name": "herd",
            "space": {"size": [20.0, 20.0]},
            "training": {"ticks": 2},
            "species": {"goat": goat},
        }
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("policies")
    pretrain(herd(), seed=1, ticks=2, out=out, points=1)
    return out


def test_a_policy_is_taken_where_channels_options_and_gaits_are_its_own(folder):
    learned = World.from_config(herd(), policies=str(folder)).table("goat").species.nerves.brain.state()
    kept, names = weights.read((folder / "goat.safetensors").read_bytes())
    assert all((learned[name] == array).all() for name, array in kept.items())
    assert names["channels"] == ["energy", "age"]
    assert names["options"] == {"speed": ["sit", "go"], "turn": ["left", "none", "right"]}
    assert names["gaits"] == {"sit": 0.0, "go": 0.5}
    World.from_config(herd(gaits={"go": 0.9, "sit": 0.1}), policies=str(folder))  # go is the faster one still


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        (
            {"sensors": SENSORS[::-1]},
            "other channels: in the file energy, age, here the same in another order, age, energy",
        ),
        (
            {"sensors": [{"kind": "own", "property": "mass"}, SENSORS[1]]},
            "other channels: energy only in the file; mass only here",
        ),
        ({"sensors": [*SENSORS, {"kind": "own", "property": "mass"}]}, "other channels: mass only here"),
        ({"speed": ("go", "sit")}, "other options: in the file speed.sit, speed.go"),
        ({"turn": ("right", "none", "left")}, "other options: in the file speed.sit, speed.go, turn.left"),
        (
            {"gaits": {"sit": 0.5, "go": 0.0}},
            "other gaits: in the file sit, go, here the same in another order",
        ),
    ],
)
def test_other_channels_options_and_gaits_are_refused_by_name(folder, changed, fault):
    with pytest.raises(ConfigError, match=f"was trained with {fault}") as error:
        World.from_config(herd(**changed), policies=str(folder))
    assert "goat.safetensors" in str(error.value)


def test_a_file_without_names_is_taken_by_its_shapes_and_check_says_so(folder, tmp_path):
    path = weights.save(tmp_path / "goat.safetensors", weights.load(folder / "goat.safetensors"))
    turned = herd(sensors=SENSORS[::-1], file=str(path))
    World.from_config(turned)
    assert "names neither channels nor actions" in notes(turned)[-1]
    name_weights(path, turned, "goat")
    World.from_config(turned)
    assert notes(turned) == []
    with pytest.raises(ConfigError, match="other channels"):
        World.from_config(herd(file=str(path)))


@pytest.mark.parametrize(
    "file", sorted(WORLDS.glob("*/*.safetensors")), ids=lambda file: f"{file.parent.name}/{file.stem}"
)
def test_shipped_weights_are_refused_for_sensors_in_another_order(file):
    config = load(file.parent.name)
    other = config.model_copy(deep=True)
    other.species[file.stem].sensors.reverse()
    brain = SimpleNamespace(load=lambda _: None)
    load_weights(brain, file, config, file.stem)
    with pytest.raises(
        ConfigError, match=r"was trained with other channels: in the file .* in another order"
    ):
        load_weights(brain, file, other, file.stem)


@pytest.mark.parametrize("names", [{}, {"channels": 1}, [], {"channels": [], "options": [], "gaits": {}}])
def test_names_of_another_form_are_refused(tmp_path, names):
    path = weights.save(tmp_path / "goat.safetensors", {"a": np.ones(2, np.float32)}, names)
    with pytest.raises(ValueError, match="is not a weights file"):
        weights.load(path)
