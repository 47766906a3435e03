"""Distances and rays of capsules and boxes: counted by hand, and against brute force."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from ecs_eco.space.shapes import bounds, contact, ray, surface, volume

PLANE, SPACE = False, True


def form(x=0.0, y=0.0, z=0.0, half=(0.0, 0.0, 0.0), rounding=0.0, heading=0.0):
    return np.array([[x, y, z, *half, rounding, math.cos(heading), math.sin(heading)]], np.float32)


def sphere(radius, **at):
    return form(rounding=radius, **at)


def capsule(length, radius, heading=0.0, **at):
    return form(half=(length / 2 - radius, 0, 0), rounding=radius, heading=heading, **at)


def box(length, width, height=1.0, heading=0.0, **at):
    return form(half=(length / 2, width / 2, height / 2), heading=heading, **at)


def gap(one, other, space=PLANE, tie=1.0):
    d = (one[0, :3] - other[0, :3]).astype(float)
    return contact(one, 0, other, 0, *d, space, tie)


@pytest.mark.definition("1 conformation")
@pytest.mark.parametrize(
    ("one", "other", "distance", "way"),
    [
        (sphere(1, x=5), sphere(1), 3.0, (1, 0, 0)),
        (sphere(1, x=3, y=4), sphere(1), 3.0, (0.6, 0.8, 0)),
        (sphere(1, x=2, y=4), box(6, 2), 2.0, (0, 1, 0)),  # over its long side
        (sphere(1, x=6, y=5), box(6, 2), 4.0, (0.6, 0.8, 0)),  # off its corner at (3, 1)
        (sphere(1, y=0.5), box(6, 2), -1.5, (0, 1, 0)),  # its centre in the box: out by 0.5 + 1
        (sphere(1, x=1, y=3), capsule(6, 1), 1.0, (0, 1, 0)),  # beside its axis
        (sphere(1, x=5, y=4), capsule(6, 1), 3.0, (0.6, 0.8, 0)),  # off its end at (2, 0)
        (
            capsule(4, 0.5, heading=math.pi / 2, x=3),
            capsule(4, 0.5),
            0.5,
            (1, 0, 0),
        ),  # before the other's end
        (capsule(4, 0.5, heading=math.pi / 2, x=1, y=0.8), capsule(4, 0.5), -1.5, (1, 0, 0)),  # crossed
        (box(2, 2, heading=math.pi / 4, x=4), box(2, 2), 3 - math.sqrt(2), (1, 0, 0)),  # a corner ahead
        (box(2, 2, x=1.5), box(2, 2), -0.5, (1, 0, 0)),
    ],
)
def test_distances_of_all_pairs_of_shapes_are_those_counted_by_hand(one, other, distance, way):
    found = gap(one, other)
    assert found[0] == pytest.approx(distance, abs=1e-6)
    assert found[1:] == pytest.approx(way, abs=1e-6)
    back = gap(other, one)
    assert back[0] == pytest.approx(distance, abs=1e-6)
    assert back[1:] == pytest.approx([-w for w in way], abs=1e-6)


@pytest.mark.definition("1 conformation")
def test_in_a_volume_what_is_above_is_parted_upwards():
    assert gap(sphere(1, x=1, z=4), box(6, 2, 2), SPACE) == pytest.approx((2, 0, 0, 1))
    # off the edge x = 3, z = 1 by 3 and 4
    assert gap(sphere(1, x=6, z=5), box(6, 2, 2), SPACE) == pytest.approx((4, 0.6, 0, 0.8))
    assert gap(sphere(1, z=0.9), box(6, 2, 2), SPACE) == pytest.approx((-1.1, 0, 0, 1))


def test_concentric_bodies_part_each_to_its_own_side():
    assert gap(capsule(4, 0.5), capsule(4, 0.5), tie=1.0)[1:] == pytest.approx(
        [-w for w in gap(capsule(4, 0.5), capsule(4, 0.5), tie=-1.0)[1:]]
    )


bodies = st.builds(
    form,
    x=st.floats(-3, 3),
    y=st.floats(-3, 3),
    z=st.floats(-2, 2),
    half=st.tuples(st.floats(0, 2), st.sampled_from([0.0, 0.3, 1.0]), st.floats(0, 1)),
    rounding=st.floats(0.0, 0.5),
    heading=st.floats(0, 6.28),
)


def slow_depth(one, other, space):
    """The greatest distance between parallel planes that keep the boxes apart, over very many directions: it
    is their distance, or, less than 0, the shortest push that parts them."""
    sides = [math.atan2(f[0, 8], f[0, 7]) + k * np.pi / 2 for f in (one, other) for k in range(4)]
    angle = np.concatenate([np.linspace(0, 2 * np.pi, 720), sides])
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 61) if space else np.zeros(1)
    t, a = np.meshgrid(tilt, angle)
    n = np.stack([np.cos(t) * np.cos(a), np.cos(t) * np.sin(a), np.sin(t)], -1).reshape(-1, 3)

    def spread(f):
        ahead = n[:, 0] * f[0, 7] + n[:, 1] * f[0, 8]
        aside = n[:, 1] * f[0, 7] - n[:, 0] * f[0, 8]
        return abs(ahead) * f[0, 3] + abs(aside) * f[0, 4] + abs(n[:, 2]) * f[0, 5]

    return (n @ (one[0, :3] - other[0, :3]) - spread(one) - spread(other)).max() - one[0, 6] - other[0, 6]


@pytest.mark.definition("1 conformation")
@settings(deadline=None)
@given(bodies, bodies, st.booleans())
@example(form(half=(1, 0, 0), rounding=0.5, heading=1.0), form(y=3e-19, half=(1, 0, 0), heading=1.0), False)
def test_distances_are_those_of_brute_force_over_directions(one, other, space):
    if not space:
        one[0, 2] = other[0, 2] = 0
    found, *way = gap(one, other, space)
    slow = slow_depth(one, other, space)
    assert slow - 1e-4 <= found <= slow + (0.01 if space else 1e-3)
    assert np.linalg.norm(way) == pytest.approx(1, abs=1e-6)
    if found < 0:  # pushed by so much, they touch and no more
        one[0, :3] -= np.float32(found) * np.array(way, np.float32)
        assert gap(one, other, space)[0] == pytest.approx(0, abs=1e-4)


def inside(f, at):
    """Whether places f64[n, 3] lie within a body."""
    d = at - f[0, :3]
    c, s = f[0, 7:]
    local = np.stack([d[:, 0] * c + d[:, 1] * s, d[:, 1] * c - d[:, 0] * s, d[:, 2]], 1)
    beyond = np.maximum(abs(local) - f[0, 3:6], 0)
    return np.linalg.norm(beyond, axis=1) <= f[0, 6]


@pytest.mark.definition("1 conformation")
@settings(deadline=None)
@given(
    st.floats(0.5, 4),
    st.floats(0.1, 1),
    st.booleans(),
    st.floats(0, 6.28),
    st.floats(0, 6.28),
    st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-2, 2)),
    st.floats(-0.5, 0.5),
)
def test_rays_meet_bodies_where_brute_force_does(length, width, boxed, heading, angle, start, tilt):
    body = box(length, width, 1.5, heading) if boxed else capsule(length + width, width / 2, heading)
    u = np.array([math.cos(angle), math.sin(angle), tilt])
    found = ray(body, 0, *start, *u)
    t = np.linspace(0, 15, 6001)
    met = inside(body, np.array(start) + t[:, None] * u)
    if not met.any():
        # it may graze the body between two places
        assert math.isinf(found) or not inside(body, np.array([np.array(start) + (found - 1e-4) * u]))[0]
    else:
        assert found == pytest.approx(t[met.argmax()], abs=0.0026)


def test_rays_counted_by_hand():
    assert ray(box(2, 4), 0, -5, 0, 0, 1, 0, 0) == pytest.approx(4)
    assert ray(box(2, 4, heading=math.pi / 2), 0, -5, 0, 0, 1, 0, 0) == pytest.approx(3)
    assert ray(capsule(4, 0.5), 0, -5, 0, 0, 1, 0, 0) == pytest.approx(3)
    assert ray(capsule(4, 0.5), 0, 1, -5, 0, 0, 1, 0) == pytest.approx(4.5)
    assert ray(sphere(1), 0, -5, 0, 0, 1, 0, 0) == pytest.approx(4)
    assert ray(box(2, 4), 0, 0, 0, 0, 1, 0, 0) == 0  # from within
    assert math.isinf(ray(box(2, 4), 0, 5, 0, 0, 1, 0, 0))  # it is behind
    assert math.isinf(ray(capsule(4, 0.5), 0, -5, 0.6, 0, 1, 0, 0))


@pytest.mark.definition("1 conformation")
def test_volume_and_surface_follow_from_the_shape():
    assert volume(2, 3, 4, 0) == 24
    assert surface(2, 3, 4, 0) == 52
    assert volume(0, 0, 0, 2) == pytest.approx(32 / 3 * math.pi)
    assert surface(0, 0, 0, 2) == pytest.approx(16 * math.pi)
    assert volume(3, 0, 0, 1) == pytest.approx((3 + 4 / 3) * math.pi)  # a capsule 5 m long
    assert surface(3, 0, 0, 1) == pytest.approx(10 * math.pi)


@settings(deadline=None)
@given(bodies)
def test_bounds_hold_all_corners_of_a_body(body):
    found = bounds(body, 0)
    a, b, h, r, c, s = body[0, 3:].astype(float)
    corners = np.array([[a * i * c - b * j * s, a * i * s + b * j * c] for i in (1, -1) for j in (1, -1)])
    assert found[:2] == pytest.approx(corners.max(axis=0) + r, abs=1e-5)
    assert found[2] == pytest.approx(h + r)
