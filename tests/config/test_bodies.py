import math

import pytest

from ecs_eco import World
from ecs_eco.cli.summary import summary
from ecs_eco.components import Body, Position, Shape
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.life.reconfigure import reconfigure


def _world(deer=None, space=None, **thing):
    deer = {"count": 2, "body": deer or {"radius": 0.5}}
    things = {"thing": {"body": {"radius": 0.5}, **thing}} if thing else {}
    space = {"size": [20.0, 10.0], **(space or {})}
    return {"format": 1, "name": "shapes", "space": space, "objects": things, "species": {"deer": deer}}


BOX = {"shape": "box", "size": [4.0, 3.0]}


@pytest.mark.definition("1 conformation")
def test_a_body_is_a_sphere_a_capsule_or_a_box():
    sphere = load(_world({"radius": 0.5})).species["deer"].body
    assert (sphere.extents, sphere.bound) == ((1, 1, 1), 0.5)
    assert sphere.volume == pytest.approx(math.pi / 6)
    capsule = load(_world({"shape": "capsule", "radius": 0.5, "length": 3.0})).species["deer"].body
    assert (capsule.extents, capsule.bound) == ((3, 1, 1), 1.5)
    assert capsule.volume == pytest.approx(math.pi * (0.25 * 2 + 0.5**3 * 4 / 3))
    assert capsule.form == {"half_length": 2, "half_width": 0, "half_height": 0, "rounding": 1}
    box = load(_world({"shape": "box", "size": [4.0, 3.0, 12.0]})).species["deer"].body
    assert (box.radius, box.volume) == (6.5, 144)
    assert [v * 6.5 for v in box.form.values()] == pytest.approx([2, 1.5, 6, 0])
    # without the third number it is as high as wide
    assert load(_world(BOX)).species["deer"].body.extents == (4, 3, 3)


def test_mass_follows_from_a_density():
    assert load(_world(BOX | {"density": 2.0})).species["deer"].body.mass == 72


@pytest.mark.parametrize(
    "body", [{"radius": 0.5}, BOX, BOX | {"density": 2.0}, {"shape": "capsule", "radius": 0.5, "length": 3.0}]
)
def test_what_is_written_loads_as_the_same_world(body):
    config = load(_world(body))
    assert load(config.resolved()).config_hash == config.config_hash
    assert load(config).species["deer"].body == config.species["deer"].body


def test_what_is_written_of_a_sphere_is_what_it_always_was():
    assert list(load(_world()).resolved()["species"]["deer"]["body"]) == [
        "radius",
        "mass",
        "opaque",
        "solid",
        "sinking",
    ]
    assert list(load(_world(at=[[1.0, 1.0]])).resolved()["objects"]["thing"]) == [
        "count",
        "at",
        "color",
        "body",
        "properties",
        "substances",
        "emits",
    ]


@pytest.mark.definition("1 conformation")
def test_objects_stand_where_and_as_the_file_says():
    world = World.from_config(
        _world(
            at=[[1.0, 2.0], [3.0, 4.0]],
            heading=[0.5, 1.5],
            body=BOX,
            between=[[1.0, 1.0, 4.0, 5.0], [0.0, 9.0, 20.0, 9.0]],
            space={"edges": "walls"},
        )
    )
    table = world.tables["thing"]
    p, rows = table[Position], table.by_uid()
    assert p.x[rows].tolist() == [1, 3, 2.5, 10]
    assert p.y[rows].tolist() == [2, 4, 3, 9]
    assert p.heading[rows] == pytest.approx([0.5, 1.5, math.atan2(4, 3), 0])
    radius = table[Body].radius[rows]
    assert 2 * table[Shape].half_length[rows] * radius == pytest.approx([4, 4, 5, 20])
    assert 2 * table[Shape].half_width[rows] * radius == pytest.approx([3, 3, 3, 3])
    one = World.from_config(_world(at=[[1.0, 2.0], [3.0, 4.0]], heading=[0.5], body=BOX)).tables["thing"]
    assert one[Position].heading[one.rows()].tolist() == [0.5, 0.5]


def test_a_longer_body_of_the_same_density_is_heavier():
    world = World.from_config(
        _world(
            between=[[1.0, 1.0, 3.0, 1.0], [1.0, 3.0, 9.0, 3.0]],
            body={"shape": "box", "size": [1.0, 1.0], "density": 5.0},
        )
    )
    table = world.tables["thing"]
    assert table[Body].mass[table.by_uid()].tolist() == [10, 40]


def test_objects_between_two_places_are_counted():
    config = load(_world(between=[[1.0, 1.0, 3.0, 1.0], [1.0, 3.0, 9.0, 3.0]], body=BOX))
    assert "  thing: 2" in summary(config).splitlines()


def test_in_a_volume_what_is_between_two_places_stands_on_the_floor():
    world = World.from_config(
        _world(
            between=[[1.0, 1.0, 3.0, 1.0]],
            space={"size": [20.0, 10.0, 8.0]},
            body={"shape": "box", "size": [1.0, 1.0, 3.0]},
        )
    )
    table = world.tables["thing"]
    assert table[Position].z[table.rows()].tolist() == [1.5]


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (BOX | {"radius": 1.0}, "a box takes no radius"),
        ({"shape": "box", "radius": 1.0}, "a box takes no radius"),
        ({"shape": "box"}, "a box needs a size"),
        ({"shape": "capsule", "radius": 1.0}, "a capsule needs a length"),
        ({"shape": "capsule", "radius": 1.0, "length": 1.5}, "at least twice the radius, 2 m"),
        ({"radius": 1.0, "length": 3.0}, 'length requires a capsule: set shape = "capsule"'),
        ({"radius": 1.0, "size": [1.0, 1.0]}, "size requires a box"),
        ({"shape": "bx", "size": [1.0, 1.0]}, 'did you mean "box"'),
        ({"radius": 1.0, "mass": 1.0, "density": 1.0}, "either mass or density"),
        ({"shape": "box", "size": [1.0, 1.0, 1.0, 1.0]}, "at most 3 entries"),
        ({"shape": "box", "size": [11.0, 1.0]}, "does not fit into the world"),
        ({"shape": "capsule", "radius": 1.0, "length": 11.0}, "at most 10 m"),
        ({"shape": "capsule"}, "radius"),
    ],
)
def test_wrong_bodies_are_refused_with_what_is_allowed(body, words):
    with pytest.raises(ConfigError, match=words):
        load(_world(body))


@pytest.mark.parametrize(
    ("thing", "words"),
    [
        ({"between": [[1.0, 1.0, 3.0, 1.0]]}, "a sphere cannot extend"),
        ({"between": [[1.0, 1.0, 21.0, 1.0]], "body": BOX}, "outside the world"),
        ({"between": [[1.0, 1.0, 1.0, 1.0]], "body": BOX}, "more than 0 m"),
        ({"between": [[1.0, 1.0, 19.0, 1.0]], "body": BOX}, "at most 10 m"),
        (
            {"between": [[1.0, 1.0, 1.5, 1.0]], "body": {"shape": "capsule", "radius": 1.0, "length": 3.0}},
            "more than 2 m",
        ),
        ({"at": [[1.0, 1.0]], "heading": [1.0, 2.0]}, "2 headings for 1 positions"),
        ({"count": 2, "heading": [1.0]}, "heading"),
        ({"count": 2, "between": [[1.0, 1.0, 3.0, 1.0]], "body": BOX}, "given together with `between`"),
    ],
)
def test_wrong_objects_are_refused_with_what_is_allowed(thing, words):
    with pytest.raises(ConfigError, match=words):
        load(_world(**thing))


def test_the_shape_of_a_world_that_lives_does_not_change():
    world = World.from_config(_world(BOX))
    with pytest.raises(ConfigError, match="build a world with it"):
        reconfigure(world, load(_world(BOX | {"size": [4.0, 2.0]})))
