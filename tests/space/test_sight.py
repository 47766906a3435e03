"""Lines of sight and rays against brute force over all bodies."""

import itertools

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Position
from ecs_eco.config.models.body import Body as Form
from ecs_eco.nervous.sensors.nearest import see_nearest
from ecs_eco.nervous.sensors.rays import cast_rays
from ecs_eco.space import Seekers, Terrain
from ecs_eco.space.sight import gather

OPAQUE, CLEAR = Form(radius=1.0), Form(radius=1.0, opaque=False)
KINDS = (("a", 40, 1.3, True), ("b", 35, 1.0, True), ("mist", 15, 1.5, False))


def _world(size, edges, cell, seed):
    rng = np.random.default_rng(seed)
    world = World(size, edges=edges, cell=cell)
    for name, n, radius, opaque in KINDS:
        table = world.add_table(name, Position, Body)
        table.species.body = OPAQUE if opaque else CLEAR
        values = {
            (Position, axis): (rng.random(n) * s).astype("f4") for axis, s in zip("xyz", size, strict=False)
        }
        values |= {
            (Position, "heading"): (rng.random(n) * 6.28).astype("f4"),
            (Body, "radius"): rng.uniform(0.5, 1, n).astype("f4") * radius,
        }
        table.request(np.zeros(n, np.uint64), values)
    world.flush()
    return world


def _places(world, name):
    p, rows = world.tables[name][Position], world.tables[name].rows()
    return np.stack([p.x[rows], p.y[rows], p.z[rows]], 1).astype(float)


def _ways(world, start, ends):
    v = ends - start
    if world.space.torus:
        for axis in range(2):
            v[:, axis] -= world.space.size[axis] * np.round(v[:, axis] / world.space.size[axis])
    return v


def _bodies(world, names):
    places = np.concatenate([_places(world, n) for n in names])
    radii = np.concatenate([world.tables[n][Body].radius[world.tables[n].rows()] for n in names]).astype(
        float
    )
    uids = np.concatenate([world.tables[n].uid[world.tables[n].rows()] for n in names])
    return places, radii, uids


def _visible(world, me, target, fov, radius):
    """The distance of the nearest b that uid `me` of a sees, how clear the case is,
    and whether the nearest is hidden."""
    a, heading = world.get(me, Position), world.get(me, Position).heading
    start = np.array([a.x, a.y, a.z], float)
    places, radii, uids = _bodies(world, ["a", "b"])
    ways, targets = _ways(world, start, places), _ways(world, start, _places(world, target))
    target_uids = world.tables[target].uid[world.tables[target].rows()]
    best, nearest, margin = np.inf, np.inf, np.inf
    for v, uid in zip(targets, target_uids, strict=True):
        distance = np.linalg.norm(v)
        margin = min(margin, abs(distance - radius))
        if distance >= radius or uid == me:
            continue
        if fov < 6:
            ahead = (v[0] * np.cos(heading) + v[1] * np.sin(heading)) / distance - np.cos(fov / 2)
            margin = min(margin, abs(ahead))
            if ahead < 0:
                continue
        hidden = False
        for w, r, other in zip(ways, radii, uids, strict=True):
            along = w @ v / distance
            if other not in (me, uid) and 0 < along < distance:
                gap = np.sqrt(max(w @ w - along**2, 0)) - r
                margin = min(margin, abs(gap))
                hidden |= gap < 0
        nearest = min(nearest, distance)
        if not hidden:
            best = min(best, distance)
    return best, margin, nearest < best


@pytest.mark.parametrize(
    ("size", "edges", "cell"),
    list(itertools.product([(40, 30), (24, 19, 12)], ["torus", "walls"], [1.5, 5.0, 19.0])),
)
@pytest.mark.parametrize("fov", [2 * np.pi, 2.0])
def test_the_nearest_visible_is_that_of_all_pairs_with_all_bodies_between(size, edges, cell, fov):
    radius, clear, seen, behind = 9.0, 0, 0, 0
    for seed in range(3):
        world = _world(size, edges, cell, seed)
        table = world.tables["a"]
        seekers = Seekers(world, table)
        width = 3 if len(size) == 2 else 4
        out = np.full((seekers.n, width), np.nan, np.float32)
        see_nearest("b", radius, fov, True)(world, table, seekers, out, 0)
        for i, row in enumerate(seekers.rows):
            best, margin, hidden = _visible(world, int(table.uid[row]), "b", fov, radius)
            if margin < 1e-3:  # rounding decides
                continue
            clear += 1
            seen += best < radius
            behind += hidden
            assert out[i, -1] == pytest.approx(max(0, 1 - best / radius), abs=1e-4)
            assert np.linalg.norm(out[i, :-1]) == pytest.approx(float(best < radius), abs=1e-4)
    assert clear > 80
    assert seen > 20
    assert behind > 5  # something nearer was hidden


@pytest.mark.parametrize(
    ("me", "at", "blind"), [(1.0, 5.0, False), (1.0, 11.0, True), (13.0, 15.0, False), (17.0, 3.0, False)]
)
def test_rock_hides_what_is_behind_it(me, at, blind):
    world = World((20, 20))
    world.terrain = Terrain(world.space, 0.5, rocks=[{"at": [8.0, 10.0], "radius": 1.5}])
    for x in (me, at):
        world.add_table(f"at {x}", Position, Body)
        world.spawn(f"at {x}", Position(x=x, y=10))
    world.flush()
    table = world.tables[f"at {me}"]
    out = np.zeros((1, 3), np.float32)
    see_nearest(f"at {at}", 10.0, 2 * np.pi, True)(world, table, Seekers(world, table), out, 0)
    assert (out[0, 2] == 0) == blind


def test_direction_and_distance_are_in_the_bodys_frame():
    world = World((20, 20))
    for name, x, y in (("me", 19, 10), ("it", 1, 12)):  # across the seam: (2, 2) away
        world.add_table(name, Position, Body)
        world.spawn(name, Position(x=x, y=y, heading=np.pi / 2))
    world.flush()
    table = world.tables["me"]
    out = np.zeros((1, 3), np.float32)
    see_nearest("it", 8.0, 2 * np.pi, False)(world, table, Seekers(world, table), out, 0)
    assert out[0] == pytest.approx([np.sqrt(0.5), -np.sqrt(0.5), 1 - np.sqrt(8) / 8], abs=1e-6)


def _ray(world, me, angle, radius, targets):
    """What the ray from uid `me` at `angle` hits first, and how far:
    all bodies that are opaque or looked for, then walls."""
    a = world.get(me, Position)
    start, u = np.array([a.x, a.y, a.z], float), np.array([np.cos(angle), np.sin(angle), 0])
    best, what = radius, None
    for name in world.tables:
        if name not in targets and not world.tables[name].species.body.opaque:
            continue
        places, radii, uids = _bodies(world, [name])
        for w, r, uid in zip(_ways(world, start, places), radii, uids, strict=True):
            along, gap2 = w @ u, w @ w - (w @ u) ** 2
            if uid != me and (w @ w <= r * r or (along > 0 and gap2 < r * r)):
                t = 0 if w @ w <= r * r else along - np.sqrt(r * r - gap2)
                if t < best:
                    best, what = t, name
    if not world.space.torus:
        for axis in range(2):
            wall = ((world.space.size[axis] if u[axis] > 0 else 0) - start[axis]) / u[axis]
            if wall < best:
                best, what = wall, "wall"
    return what, best


def test_rays_around_a_torus_meet_every_image_of_a_sphere_and_the_one_around_the_eye():
    size, radius, count, rng = (10.0, 8.0), 4.0, 16, np.random.default_rng(3)
    world = World(size, cell=1.0)
    world.add_table("eye", Position, Body).species.body = CLEAR
    world.add_table("ball", Position, Body)
    for _ in range(40):
        world.spawn("eye", Position(x=rng.uniform(0, 10), y=rng.uniform(0, 8), heading=0))
    for r in (0.3, 2.0, 3.0):
        world.spawn("ball", Position(x=rng.uniform(0, 10), y=rng.uniform(0, 8)), Body(radius=r))
    world.flush()
    eyes, balls = world.tables["eye"], world.tables["ball"]
    seekers = Seekers(world, eyes)
    out = np.zeros((seekers.n, count), np.float32)
    cast_rays(["ball"], count, 2 * np.pi, radius, "per_ray")(world, eyes, seekers, out, 0)
    beyond_half = 0
    for i, row in enumerate(seekers.rows):
        start = np.array([eyes[Position].x[row], eyes[Position].y[row]], float)
        for k in range(count):
            angle, best = (k - (count - 1) / 2) * 2 * np.pi / count, radius
            steps = np.linspace(0, radius, 4001)
            at = start + steps[:, None] * np.array([np.cos(angle), np.sin(angle)])
            for b in balls.rows():
                d = at - [balls[Position].x[b], balls[Position].y[b]]
                shift = np.round(d / size)
                d -= np.array(size) * shift
                inside = (d**2).sum(1) <= float(balls[Body].radius[b]) ** 2
                if inside.any() and steps[inside.argmax()] < best:
                    best = steps[inside.argmax()]
                    beyond_half += (shift[0] != shift[inside.argmax()]).any()
            assert out[i, k] == pytest.approx(1 - best / radius, abs=0.03), (i, k)
    assert beyond_half > 20
    assert (out == 1).all(axis=1).sum() > 5  # eyes within a ball


@pytest.mark.parametrize(
    ("size", "edges", "cell"),
    list(itertools.product([(40, 30), (24, 22, 6)], ["torus", "walls"], [1.5, 5.0])),
)
def test_rays_stop_at_the_first_body_or_wall_of_all(size, edges, cell):
    radius, count, fov = 7.0, 5, 2.4
    world = _world(size, edges, cell, 7)
    table = world.tables["a"]
    seekers = Seekers(world, table)
    targets = ["b", "a", "wall"]
    each, closest = (
        np.zeros((seekers.n, 3 * count), np.float32),
        np.zeros((seekers.n, 3 * (len(size) + 1)), np.float32),
    )
    cast_rays(targets, count, fov, radius, "per_ray")(world, table, seekers, each, 0)
    cast_rays(targets, count, fov, radius, "closest")(world, table, seekers, closest, 0)
    spread = (np.arange(count) - 2) * fov / 4  # the outermost rays enclose fov
    wrong, hits = 0, dict.fromkeys(targets, 0)
    for i, row in enumerate(seekers.rows):
        expected = np.zeros((3, count))
        for r in range(count):
            what, distance = _ray(
                world, int(table.uid[row]), table[Position].heading[row] + spread[r], radius, targets
            )
            if what in targets:
                expected[targets.index(what), r] = 1 - distance / radius
                hits[what] += 1
        wrong += not np.allclose(each[i], expected.ravel(), atol=2e-3)
        if np.allclose(each[i], expected.ravel(), atol=2e-3):
            for t in range(3):
                best = expected[t].argmax()
                value = expected[t, best]
                direction = [np.cos(spread[best]), np.sin(spread[best])] if value > 0 else [0, 0]
                up = [0] if len(size) == 3 else []
                assert closest[i].reshape(3, -1)[t] == pytest.approx([*direction, *up, value], abs=2e-3)
    assert wrong <= 1  # rays that graze a body
    assert hits["a"] > 2
    assert hits["b"] > 2
    assert (hits["wall"] > 5) == (edges == "walls")


def test_rays_of_a_full_circle_are_evenly_spaced_and_one_ray_looks_ahead():
    world = World((20, 20))
    world.add_table("me", Position, Body).species.body = OPAQUE
    world.add_table("it", Position, Body).species.body = OPAQUE
    world.spawn("me", Position(x=10, y=10, heading=np.pi / 4))
    for k in range(4):
        world.spawn("it", Position(x=10 + 3 * np.cos(k * np.pi / 2), y=10 + 3 * np.sin(k * np.pi / 2)))
    world.flush()
    table = world.tables["me"]
    seekers, out = Seekers(world, table), np.zeros((1, 4), np.float32)
    cast_rays(["it"], 4, 2 * np.pi, 5.0, "per_ray")(world, table, seekers, out, 0)
    # at ±45° and ±135° of the heading; 2.5 m to each surface
    assert out[0] == pytest.approx([0.5] * 4, abs=1e-3)
    one = np.zeros((1, 1), np.float32)
    cast_rays(["it"], 1, 1.0, 5.0, "per_ray")(world, table, seekers, one, 0)
    assert one[0, 0] == 0  # between two of them


def test_rock_stops_a_ray():
    world = World((20, 20))
    world.terrain = Terrain(world.space, 0.25, rocks=[{"at": [14.0, 10.0], "radius": 1.0}])
    world.add_table("me", Position, Body).species.body = OPAQUE
    world.spawn("me", Position(x=10, y=10))
    world.flush()
    table, out = world.tables["me"], np.zeros((1, 1), np.float32)
    cast_rays(["wall"], 1, 1.0, 8.0, "per_ray")(world, table, Seekers(world, table), out, 0)
    assert out[0, 0] == pytest.approx(1 - 3 / 8, abs=0.04)


def test_gather_takes_every_entry_in_reach_once():
    world = _world((12, 9), "torus", 3.0, 1)
    space, index = world.space, world.index(world.tables["a"])
    for reach in (0, 1, 2, 5):
        out = np.empty(index.n, np.int64)
        n = gather(1.0, 1.0, 0.0, reach, index.entries, space.extent, out)
        columns = {i % 4 for i in range(-reach, reach + 1)}
        rows = {j % 3 for j in range(-reach, reach + 1)}
        inside = [e for e in range(index.n) if int(index.x[e] / 3) in columns and int(index.y[e] / 3) in rows]
        assert sorted(out[:n].tolist()) == inside
