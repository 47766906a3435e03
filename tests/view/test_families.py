"""Families: founders, the colours of the largest, and who descends from whom."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.view.families import SLOTS, Families, asked
from ecs_eco.view.live import Live


def lives(*rows):
    """Lives of (uid, parent, second parent)."""
    columns = np.array(rows, np.uint64).reshape(-1, 3).T
    return lambda: (columns[0], columns[1], columns[2])


def u64(*uids):
    return np.array(uids, np.uint64)


TREE = [(1, 0, 0), (2, 0, 0), (3, 1, 0), (4, 3, 2), (5, 2, 3), (6, 4, 0), (9, 8, 0)]


def test_founders_are_found_along_the_first_parent():
    families = Families(lives(*TREE))
    assert families.roots(u64(1, 2, 3, 4, 5, 6, 9)).tolist() == [1, 2, 1, 1, 2, 1, 9]  # nobody knows 8
    assert families.roots(u64(77)).tolist() == [77]


def test_founders_are_found_as_lives_are_added_and_old_ones_forgotten():
    rows = TREE[:3]
    families = Families(lambda: lives(*rows)())
    assert families.roots(u64(3)).tolist() == [1]
    rows = TREE
    assert families.roots(u64(6)).tolist() == [1]
    rows = [row for row in TREE if row[0] > 2]  # 1 and 2 are forgotten
    assert families.roots(u64(3, 5, 6)).tolist() == [1, 2, 1]
    rows = [*rows, (10, 5, 0)]
    assert families.roots(u64(10)).tolist() == [2]


def test_descendants_are_those_of_either_parent_also_of_later_births():
    rows = TREE
    families = Families(lambda: lives(*rows)())
    assert families.descendants(2).tolist() == [2, 4, 5, 6]
    assert families.kin(2, u64(1, 2, 3, 5, 6)).tolist() == [0, 255, 0, 255, 255]
    rows = [*TREE, (10, 9, 6)]
    assert families.descendants(2).tolist() == [2, 4, 5, 6, 10]
    assert families.descendants(9).tolist() == [9, 10]


def test_the_largest_families_have_colours_and_keep_them():
    rows = [(i, 0, 0) for i in range(1, 21)]
    rows += [(100 + i, 1 + i % 15, 0) for i in range(60)]
    families = Families(lambda: lives(*rows)())
    uid = np.array([row[0] for row in rows], np.uint64)
    value = families.values("deer", uid)
    assert len(set(value.tolist()) - {0}) == SLOTS
    assert value[uid == 20].tolist() == [0]  # a family of one has none
    roots = families.roots(uid)
    assert all(len(set(value[roots == root].tolist())) == 1 for root in roots)
    there = np.isin(uid, u64(1)) | (roots > 1)  # most of the first family die
    again = families.values("deer", uid[there])
    assert (again == value[there]).all()


@pytest.mark.parametrize(
    ("colour", "uid"),
    [
        ("kin:12", 12),
        ("kin:", None),
        ("kin:-1", None),
        ("kin:0", None),
        ("age", None),
        (None, None),
        ("kin:1e3", None),
        ("kin:²", None),
    ],
)
def test_a_colour_may_name_somebody(colour, uid):
    assert asked(colour) == uid


def test_a_living_world_has_families():
    config = load(
        "predator-prey",
        {
            "species.grass.count": 100,
            "species.deer.count": 40,
            "species.wolf.count": 0,
            "species.deer.reproduction.rate": 0.5,
            "species.deer.metabolism.energy": 1.0,
        },
    )
    world = World.from_config(config, seed=3, policies="random", record=False)
    live = Live(world)
    founders = set(world.tables["deer"].uid[world.tables["deer"].rows()].tolist())
    world.run(10)
    live.frame(1, "family")
    uid = world.tables["deer"].uid[world.tables["deer"].by_uid()]
    assert uid.max() > max(founders)  # there are young
    assert set(live.families.roots(uid).tolist()) <= founders
    young = int(uid[-1])
    (mother,) = live.genealogy.parents(young)
    assert young in live.families.descendants(mother)
    assert live.genealogy.lives()[0].size == live.journal.births.rows
