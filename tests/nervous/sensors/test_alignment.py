"""The heading of neighbors, hand-counted and against a slow twin."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position, Senses
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Sense
from ecs_eco.testing import act, arrange, shuffle

GENE = {"name": "eye", "trait": "sensors.fish_alignment.range", "letters": 1, "values": [1.0, 3.0, 5.0, 9.0]}


def _sea(count=4, target="fish", **changes):
    fish = {
        "count": count,
        "body": {"radius": 0.1},
        "sensors": [{"kind": "alignment", "target": target, "range": 3.0}],
    }
    return {
        "format": 1,
        "name": "sea",
        "space": {"size": [20.0, 20.0], "edges": "torus"},
        "species": {"fish": fish | changes, "shark": {"count": 1, "body": {"radius": 0.5}}},
    }


def _read(world):
    """What each fish reads, in the order of uids: [fish, 2]."""
    act(world, Sense)
    table = world.tables["fish"]
    nerves = table.species.nerves
    assert nerves.channels == ("fish_alignment_forward", "fish_alignment_left")
    return nerves.x[np.argsort(table.uid[nerves.rows])].astype(float)


def test_mean_heading_of_neighbors_relative_to_the_own_heading():
    world = World.from_config(_sea())
    # 1 and 2 m apart across the edge; the last has no neighbor
    arrange(world, "fish", x=[19, 1, 0, 10], y=10, heading=[0, np.pi / 2, np.pi, 0])
    reads = [
        [-0.5, 0.5],  # the others swim to its left and back
        [0.0, 0.0],  # the others swim to its right and to its left, which cancels
        [-0.5, -0.5],  # the others swim back and, of north seen from west, right
        [0.0, 0.0],
    ]
    assert _read(world) == pytest.approx(np.array(reads), abs=1e-6)


def test_neighbors_that_all_swim_the_same_direction_give_a_unit_vector():
    world = World.from_config(_sea())
    arrange(world, "fish", x=[5, 6, 7, 6], y=[5, 5, 5, 6], heading=[0, np.pi / 3, np.pi / 3, np.pi / 3])
    assert _read(world)[0] == pytest.approx([0.5, np.sqrt(0.75)], abs=1e-6)


def test_each_fish_has_its_own_range_and_rows_do_not_matter():
    world = World.from_config(_sea(60, genome={"genes": [GENE]}), seed=2)
    rng = np.random.default_rng(1)
    x, y, heading = rng.random((3, 60)) * [[20], [20], [6.28]]
    table = arrange(world, "fish", x=x, y=y, heading=heading)
    reads, rows = _read(world), table.by_uid()
    p, own = table[Position], table[Senses].radius[rows, 0]
    assert np.unique(own).tolist() == [1.0, 3.0, 5.0, 9.0]
    apart = np.stack([p.x[rows], p.y[rows]], 1).astype(float)
    for i in range(60):
        d = apart - apart[i]
        d -= 20 * np.round(d / 20)
        near = (np.hypot(*d.T) < own[i]) & (np.arange(60) != i)
        turned = p.heading[rows][near].astype(float) - p.heading[rows[i]]
        expected = [np.cos(turned).mean(), np.sin(turned).mean()] if near.any() else [0, 0]
        assert reads[i] == pytest.approx(expected, abs=1e-5)
    shuffle(world, seed=3)
    assert (_read(world) == reads).all()


def test_an_object_or_an_unknown_species_has_no_heading_to_align_with():
    with pytest.raises(ConfigError, match="fsh"):
        load(_sea(target="fsh"))
