"""Worlds of capsules and boxes: resumed, and on two threads."""

import pytest

from ecs_eco import World
from ecs_eco.testing import all_threads

YARD = {
    "format": 1,
    "name": "yard",
    "space": {"size": [20.0, 20.0]},
    "objects": {
        "fence": {
            "between": [[4.0, 4.0, 16.0, 4.0], [4.0, 6.0, 8.0, 18.0]],
            "body": {"shape": "box", "size": [1.0, 0.3], "solid": True},
        }
    },
    "species": {
        "eel": {
            "count": 40,
            "body": {"shape": "capsule", "radius": 0.2, "length": 1.2, "solid": True},
            "locomotion": {"speed": {"rest": 0.0, "swim": 1.5}, "turn": 0.7},
            "sensors": [
                {"kind": "rays", "count": 5, "range": 4.0, "targets": ["fence", "eel"]},
                {"kind": "nearest", "target": "eel", "range": 5.0, "occlusion": True},
            ],
            "actions": {"speed": ["rest", "swim"], "turn": ["left", "none", "right"]},
            "reproduction": {
                "kind": "asexual",
                "rate": 0.05,
                "energy_min": 0.1,
                "energy_given": 0.1,
                "dispersal": 4.0,
            },
        }
    },
}


@pytest.mark.slow
@pytest.mark.definition("1 conformation")
def test_worlds_of_shapes_go_on_from_a_checkpoint_and_on_two_threads_as_they_were(tmp_path):
    world = World.from_config(YARD, seed=2, policies="untrained").run(10)
    world.save(tmp_path / "yard.safetensors")
    world.run(10)
    assert World.restore(tmp_path / "yard.safetensors").run(10).digest() == world.digest()
    with all_threads():
        two = World.from_config(YARD, seed=2, policies="untrained", threads=2).run(20)
    assert two.digest() == world.digest()
