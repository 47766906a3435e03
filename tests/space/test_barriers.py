"""Ways end before solid boxes, as a search in small steps finds, whatever their length."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.space.barriers import barriers, hold_back

SIZE = (20.0, 12.0)
BOXES = [[4.0, 2.0, 4.0, 9.0], [9.0, 10.0, 16.0, 7.5], [18.5, 11.0, 22.5, 13.0]]  # the last across both seams


def field(edges, size=SIZE):
    body = {"shape": "box", "size": [1.0, 0.4, 2.0], "solid": True}
    gate = {"at": [[0.5, 0.0]], "heading": [math.atan2(2, 4)], "body": body | {"size": [20**0.5, 0.4, 2.0]}}
    objects = {"hedge": {"between": BOXES[:2], "body": body}} | ({"gate": gate} if edges == "torus" else {})
    config = {
        "format": 1,
        "name": "field",
        "space": {"size": list(size), "edges": edges},
        "objects": objects,
        "species": {"deer": {"count": 0, "body": {"radius": 0.5}}},
    }
    return World.from_config(config, seed=1)


def within(x, y, boxes, torus):
    """Return whether places f64[n] lie in some box."""
    inside = np.zeros(x.size, bool)
    for ax, ay, bx, by in boxes:
        dx, dy = x - (ax + bx) / 2, y - (ay + by) / 2
        if torus:
            dx, dy = dx - SIZE[0] * np.round(dx / SIZE[0]), dy - SIZE[1] * np.round(dy / SIZE[1])
        length = np.hypot(bx - ax, by - ay)
        c, s = (bx - ax) / length, (by - ay) / length
        inside |= (abs(dx * c + dy * s) <= length / 2) & (abs(dy * c - dx * s) <= 0.2)
    return inside


@pytest.mark.parametrize("edges", ["torus", "walls"])
def test_a_way_of_any_length_ends_where_small_steps_first_meet_a_box(edges):
    world, rng, n, torus = field(edges), np.random.default_rng(4), 300, edges == "torus"
    walls = barriers(world)
    x, y = rng.uniform(0, SIZE[0], n).astype(np.float32), rng.uniform(0, SIZE[1], n).astype(np.float32)
    free = ~within(x, y, BOXES if torus else BOXES[:2], torus)
    angle, far = rng.uniform(0, 2 * np.pi, n), rng.choice([1.0, 6.0, 10.0, 14.0, 29.0, 31.0, 500.0], n)
    asked = np.stack([far * np.cos(angle), far * np.sin(angle), 0 * far], 1).astype(np.float32)
    way = asked.copy()
    share = hold_back(world, walls, x, y, np.zeros(n, np.float32), way)
    for i in np.flatnonzero(free):
        wx, wy = asked[i, :2].astype(np.float64)
        if torus:
            cut = min(1.0, sum(SIZE) / max(abs(wx), abs(wy)))
            wx, wy = wx * cut, wy * cut
        else:  # the edge of the space ends it first
            wx, wy = np.clip(wx, -x[i], SIZE[0] - x[i]), np.clip(wy, -y[i], SIZE[1] - y[i])
            cut = 1.0
        steps = np.linspace(0, 1, 20_001)
        hit = within(x[i] + steps * wx, y[i] + steps * wy, BOXES if torus else BOXES[:2], torus)
        first = steps[hit.argmax()] if hit.any() else 1.0
        long = np.hypot(wx, wy)
        gone = np.hypot(*way[i, :2].astype(np.float64))
        assert gone == pytest.approx(first * long, abs=long * 4e-4 + 2e-3), (i, x[i], y[i], wx, wy)
        if torus:
            assert share[i] * np.hypot(*asked[i, :2]) == pytest.approx(gone, abs=1e-2)


def test_a_way_through_the_edge_ends_there_even_around_the_end_of_a_box():
    world = field("walls")
    way = np.array([[3.0, -40.0, 0.0], [-3.0, 40.0, 0.0]], np.float32)
    hold_back(world, barriers(world), np.float32([3, 5]), np.float32([1, 11]), np.zeros(2, np.float32), way)
    assert way[0] == pytest.approx([3, -1, 0])  # below the box, which begins at y = 2
    assert way[1] == pytest.approx([-3, 1, 0], abs=1e-5)
