import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position, Velocity
from ecs_eco.systems import Sense
from ecs_eco.testing import act, arrange

ANIMAL = {
    "count": 1,
    "body": {"radius": 0.1},
    "locomotion": {"speed": {"go": 1.0}, "turn": 1.0, "climb": 1.0},
    "actions": {"speed": ["go"], "turn": ["left", "none", "right"], "climb": ["up", "none", "down"]},
}


def _sea(sensors, size=(20.0, 20.0, 10.0), **top):
    prey = ANIMAL | {"sensors": sensors}
    if len(size) == 2:
        prey = prey | {"actions": {"speed": ["go"]}}
    predator = {**prey, "sensors": [{"kind": "own", "property": "energy"}]}
    config = {
        "format": 1,
        "name": "sea",
        "space": {"size": list(size)},
        "fields": {"smell": {"cell": 1.0}},
        "species": {"prey": prey, "predator": predator},
    } | top
    return World.from_config(config)


def _read(world):
    act(world, Sense)
    nerves = world.tables["prey"].species.nerves
    return dict(zip(nerves.channels, nerves.x[0].tolist(), strict=True))


def test_who_swims_nearer_is_felt_with_its_direction_and_speed():
    world = _sea([{"kind": "approach", "target": "predator", "range": 6.0, "scale": 2.0}])
    arrange(world, "prey", x=10, y=10, z=5, heading=np.pi / 2)
    # 5 m off: 3 ahead of x, 4 above
    arrange(world, "predator", x=13, y=10, z=9, heading=np.pi, speed=1.5, climb=-0.5)
    x = _read(world)
    assert list(x) == [f"predator_approach_{w}" for w in ("forward", "left", "up", "closing")]
    assert list(x.values()) == pytest.approx([0.0, -0.6, 0.8, (1.5 * 0.6 + 0.5 * 0.8) / 2], abs=1e-6)


@pytest.mark.parametrize(
    "state", [{"speed": 0.0}, {"speed": 1.0, "heading": 0.0}, {"speed": 1.0, "heading": np.pi, "x": 18.0}]
)
def test_who_rests_or_leaves_or_is_far_is_not_felt(state):
    world = _sea([{"kind": "approach", "target": "predator", "range": 6.0}])
    arrange(world, "prey", x=10, y=10, z=5)
    arrange(world, "predator", **({"x": 13, "y": 10, "z": 5, "climb": 0} | state))
    assert list(_read(world).values()) == [0.0] * 4


def test_own_motion_is_not_felt_as_approach():
    world = _sea([{"kind": "approach", "target": "predator", "range": 6.0}])
    arrange(world, "prey", x=10, y=10, z=5, heading=0.0, speed=2.0)
    arrange(world, "predator", x=13, y=10, z=5, speed=0.0)
    assert list(_read(world).values()) == [0.0] * 4


def test_on_a_plane_approach_and_gradient_have_no_up():
    sensors = [
        {"kind": "approach", "target": "predator", "range": 6.0},
        {"kind": "gradient", "field": "smell"},
    ]
    world = _sea(sensors, (20.0, 20.0))
    arrange(world, "prey", x=1, y=10, heading=0)
    arrange(world, "predator", x=19, y=10, heading=0.0, speed=0.5)  # 2 m off, across the edge
    assert _read(world) == pytest.approx(
        {
            "predator_approach_forward": -1.0,
            "predator_approach_left": 0.0,
            "predator_approach_closing": 0.5,
            "smell_gradient_forward": 0.0,
            "smell_gradient_left": 0.0,
        }
    )


def test_a_gradient_compares_two_sides_of_the_body():
    world = _sea([{"kind": "gradient", "field": "smell", "span": 2.0, "scale": 0.5}])
    nz, ny, nx = world.fields["smell"].value.shape
    k, _j, i = np.meshgrid(np.arange(nz), np.arange(ny), np.arange(nx), indexing="ij")
    world.fields["smell"].value[...] = 0.1 * (i + 0.5) + 0.2 * (k + 0.5)  # 0.1 x + 0.2 z
    arrange(world, "prey", x=10, y=10, z=5, heading=np.pi / 2)
    assert list(_read(world).values()) == pytest.approx([0.0, -0.2 / 4.5, 0.4 / 4.5], abs=1e-6)


def test_sight_by_light_ends_where_it_is_dark():
    sensors = [{"kind": "nearest", "target": "predator", "range": 5.0, "sight": 8.0, "blind": 0.5}]
    for light, near in ((0.0, 0.0), (0.1875, 0.0), (0.25, 1 - 2 / 2.5), (0.5, 1 - 2 / 4.5), (1.0, 1 - 2 / 5)):
        world = _sea(sensors, ambient={"light": light})
        arrange(world, "prey", x=10, y=10, z=5)
        arrange(world, "predator", x=10, y=12, z=5)
        assert _read(world)["predator_near"] == pytest.approx(near, abs=1e-6), light
    arrange(world, "predator", x=10, y=10.25, z=5)
    world.ambient["light"] = 0.0
    assert _read(world)["predator_near"] == pytest.approx(0.5)


def test_the_logarithm_of_light():
    world = _sea([{"kind": "light", "dark": 0.001, "scale": 3.0}])
    for light, reading in ((0.0, 0.0), (0.009, 1 / 3), (0.999, 1.0)):
        world.ambient["light"] = light
        assert _read(world)["light"] == pytest.approx(reading, abs=1e-6)


@pytest.mark.slow
def test_stationary_emitters_feed_a_smell_in_three_dimensions():
    world = _sea(
        [{"kind": "smell", "field": "smell"}],
        objects={"wick": {"at": [[10.0, 10.0, 5.0]], "body": {"radius": 0.1}, "emits": {"smell": 2.0}}},
        fields={"smell": {"cell": 1.0, "diffusion": 0.2, "decay": 0.1}},
    )
    world.run(200)
    field = world.fields["smell"]
    # dc/dt = source − decay c
    assert field.value.sum(dtype=float) == pytest.approx(2.0 / 0.1, rel=1e-4)
    assert field.value[5, 10, 10] == field.value.max()
    assert field.value[7, 10, 10] == pytest.approx(field.value[5, 12, 10], rel=0.25)
    assert world.tables["predator"][Velocity].speed.size
    assert world.tables["prey"][Position].z.size
