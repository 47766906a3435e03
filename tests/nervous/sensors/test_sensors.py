"""Senses of the own body, smell, touch and the surroundings, against slow twins;
sight is tested with ecs_eco.space."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Body, Chemistry, Metabolism, Physical, Position
from ecs_eco.nervous.sensors.own import own
from ecs_eco.nervous.sensors.smell import smell
from ecs_eco.nervous.sensors.surroundings import ambient
from ecs_eco.nervous.sensors.touch import touch, within
from ecs_eco.space import Field, Seekers
from ecs_eco.space.bodies import merged

F = np.float32


def _crowd(size=(12.0, 9.0), edges="torus", n=60, seed=1, cell=2.0):
    """Two kinds of bodies at random places with random headings and radii."""
    rng = np.random.default_rng(seed)
    world = World(size, edges=edges, cell=cell)
    for name in ("a", "b"):
        table = world.add_table(name, Position, Body)
        values = {
            (Position, axis): (rng.random(n) * s).astype(F) for axis, s in zip("xyz", size, strict=False)
        }
        table.request(
            np.zeros(n, np.uint64),
            values
            | {
                (Position, "heading"): (rng.random(n) * 6.28).astype(F),
                (Body, "radius"): rng.uniform(0.1, 0.5, n).astype(F),
            },
        )
    world.flush()
    return world


def _sensed(world, name, sense, width=1):
    table = world.tables[name]
    seekers, out = Seekers(world, table), np.full((world.tables[name].n, width), np.nan, F)
    sense(world, table, seekers, out, 0)
    by_uid = np.argsort(table.uid[seekers.rows])
    return out[by_uid]


def _columns(world, name):
    table = world.tables[name]
    rows = table.by_uid()
    p, b = table[Position], table[Body]
    return (
        np.stack([p.x, p.y, p.z], 1)[rows].astype(float),
        p.heading[rows].astype(float),
        b.radius[rows].astype(float),
    )


@pytest.mark.definition("3 sensor property")
def test_every_own_property_and_substance_can_be_felt():
    world = World()
    table = world.add_table("ram", Position, Metabolism, Biology, Physical, Chemistry, dims={"substances": 2})
    world.spawn(
        "ram",
        Metabolism(energy=0.5),
        Biology(age=30, fertility=0.25),
        Physical(temperature=310, luminous_intensity=2),
        Chemistry(molarity=[0.1, 0.4]),
    )
    world.flush()
    for name, scale, reads in [
        ("energy", 2, 0.25),
        ("age", 10, 3),
        ("fertility", 1, 0.25),
        ("temperature", 100, 3.1),
        ("luminous_intensity", 1, 2),
        ("salt", 1, 0.4),
        ("water", 0.2, 0.5),
        ("pressure", 101_325, 1),
    ]:
        assert _sensed(world, "ram", own(name, scale, ["water", "salt"]))[0, 0] == pytest.approx(
            reads, rel=1e-6
        )
    assert table.n == 1


@pytest.mark.parametrize(
    ("size", "edges"),
    [
        ((12.0, 9.0), "torus"),
        ((12.0, 9.0), "walls"),
        ((12.0, 9.0, 6.0), "torus"),
        ((12.0, 9.0, 6.0), "walls"),
    ],
)
@pytest.mark.definition("3 sensor place")
def test_a_nose_reads_the_field_at_its_place_on_the_body(size, edges):
    world = _crowd(size, edges)
    field = world.fields["musk"] = Field(world.space, 1.5)
    field.value[...] = np.random.default_rng(2).random(field.value.shape)
    at = [1.0, -0.5] if len(size) == 2 else [1.0, -0.5, 2.0]
    read = _sensed(world, "a", smell("musk", at, 0.3))[:, 0]
    place, heading, radius = _columns(world, "a")
    forward, left, up = [*at, 0.0][:3]
    place[:, 0] += radius * (forward * np.cos(heading) - left * np.sin(heading))
    place[:, 1] += radius * (forward * np.sin(heading) + left * np.cos(heading))
    place[:, 2] += radius * up
    for axis, length in enumerate(size):
        place[:, axis] = (
            place[:, axis] % length
            if edges == "torus" and axis < 2
            else place[:, axis].clip(0, length * (1 - 1e-7))
        )
    c = np.empty(len(place), F)
    field.sample(*place.astype(F).T, c)
    assert np.allclose(read, c / (c + 0.3), atol=1e-4)
    assert read.std() > 0.05


def test_a_smell_at_its_scale_reads_one_half():
    world = World((4, 4))
    world.add_table("a", Position, Body)
    world.spawn("a", Position(x=2.5, y=2.5))
    world.flush()
    world.fields["musk"] = Field(world.space, 1.0)
    world.fields["musk"].value[...] = 3.0
    assert _sensed(world, "a", smell("musk", [0.0, 0.0], 3.0))[0, 0] == F(0.5)


SECTORS = [[-np.pi, np.pi], [-0.8, 0.8], [0.0, np.pi], [2.5, -2.5]]  # all around, ahead, left, behind


@pytest.mark.parametrize("sector", SECTORS)
@pytest.mark.parametrize(
    ("size", "edges"),
    [((12.0, 9.0), "torus"), ((12.0, 9.0), "walls"), ((8.0, 6.0, 3.0), "walls"), ((8.0, 6.0, 3.0), "torus")],
)
def test_touch_is_that_of_all_pairs_and_walls(size, edges, sector):
    world = _crowd(size, edges)
    (here, heading, radius), (there, _, other) = _columns(world, "a"), _columns(world, "b")

    def ahead(angle, i):
        width = (sector[1] - sector[0]) % (2 * np.pi) or 2 * np.pi
        return (angle - heading[i] - sector[0]) % (2 * np.pi) <= width

    def touches(i, places, radii, me):
        d = places - here[i]
        if edges == "torus":
            d[:, :2] -= np.array(size[:2]) * np.round(d[:, :2] / np.array(size[:2]))
        near = np.linalg.norm(d, axis=1) <= radii + radius[i]
        return any(near[j] and ahead(np.arctan2(d[j, 1], d[j, 0]), i) for j in range(len(places)) if j != me)

    def walled(i):
        hits = (
            [(2, None)]
            if len(size) == 3 and (here[i, 2] <= radius[i] or here[i, 2] >= size[2] - radius[i])
            else []
        )
        if edges == "walls":
            sides = (
                (0, size[0] - here[i, 0]),
                (np.pi, here[i, 0]),
                (np.pi / 2, size[1] - here[i, 1]),
                (-np.pi / 2, here[i, 1]),
            )
            hits += [a for a, gap in sides if gap <= radius[i] and ahead(a, i)]
        return bool(hits)

    n = len(here)
    by_b = [touches(i, there, other, -1) for i in range(n)]
    by_any = [b or touches(i, here, radius, i) or walled(i) for i, b in enumerate(by_b)]
    assert _sensed(world, "a", touch(["b"], False, sector))[:, 0].astype(bool).tolist() == by_b
    assert _sensed(world, "a", touch([], True, sector))[:, 0].astype(bool).tolist() == [
        walled(i) for i in range(n)
    ]
    assert _sensed(world, "a", touch(None, True, sector))[:, 0].astype(bool).tolist() == by_any
    assert 0 < sum(by_any) < n


def test_within_a_sector_counter_clockwise():
    for angle, sector, inside in [
        (0, (-1, 1), True),
        (1.1, (-1, 1), False),
        (np.pi, (3, -3), True),
        (-3.1, (3, -3), True),
        (0, (3, -3), False),
        (7, (-1, 1), True),
        (2, (-np.pi, np.pi), True),
    ]:
        assert within(F(angle), F(sector[0]), F(sector[1])) == inside


@pytest.mark.definition("3 sensor place")
def test_the_surroundings_are_read_at_the_sensors_place_on_the_body():
    world = World((10, 10, 20), edges="walls")
    world.add_table("a", Position, Body)
    world.spawn("a", Position(x=5, y=5, z=8, heading=np.pi / 2), Body(radius=2))
    world.flush()
    world.environment["light"] = lambda w, x, y, z: x + 100 * y + 10_000 * z
    assert _sensed(world, "a", ambient("light", 0, 1))[0, 0] == 5 + 500 + 80_000
    # ahead is +y, left is −x
    assert _sensed(world, "a", ambient("light", 0, 1, [1.0, 0.5, -1.0]))[0, 0] == pytest.approx(
        4 + 700 + 60_000
    )
    assert _sensed(world, "a", ambient("light", 0, 1, [0.0, 0.0, 9.0]))[0, 0] == pytest.approx(
        5 + 500 + 200_000, rel=1e-5
    )  # not beyond the wall
    world.ambient["temperature"] = 293.0
    assert _sensed(world, "a", ambient("temperature", 273.0, 40.0))[0, 0] == F(0.5)


def test_merged_bodies_are_rebuilt_when_one_of_the_tables_changed():
    world = _crowd(n=5)
    bodies = merged(world, ["a", "b"])
    assert merged(world, ["a", "b"]) is bodies
    assert bodies.x.size == 10
    assert np.isclose(bodies.largest, max(world.tables[n][Body].radius[:5].max() for n in "ab"))
    for i in range(10):
        table = world.tables["ab"[bodies.kind[i]]]
        row = np.flatnonzero(table.uid == bodies.uid[i])[0]
        assert (table[Position].x[row], table[Body].radius[row]) == (bodies.x[i], bodies.radius[i])
    world.kill(3)
    world.flush()
    assert merged(world, ["a", "b"]).x.size == 9
