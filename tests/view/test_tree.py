"""Family trees: who is in them, of the living and of a recorded run."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.view.families import ABOVE, BELOW, BESIDE, EACH, Families, tree
from ecs_eco.view.genealogy import Genealogy
from ecs_eco.view.journal import Journal
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from tests.view.test_pair_panel import forked, uids

DEER = {
    "species.grass.count": 800,
    "species.deer.count": 40,
    "species.wolf.count": 3,
    "species.deer.metabolism.basal": 0.0,
    "species.deer.locomotion.cost.walk": 0.0,
    "species.deer.locomotion.cost.run": 0.0,
    "species.deer.lethal.1.max": 30.0,
}
ONE = {
    "species.deer.reproduction.rate": 0.1,
    "species.deer.reproduction.energy_min": 0.02,
    "species.deer.reproduction.energy_given": 0.01,
}
TWO = {
    "species.deer.reproduction": {
        "kind": "sexual",
        "energy_min": 0.02,
        "energy_given": 0.01,
        "rest": 8.0,
        "age_min": 3.0,
        "reach": 90.0,
        "consent": "none",
        "place": "anywhere",
    }
}


def family():
    world = World([10, 10], name="family")
    deer = world.add_table("deer", Position)
    world.add_table("wolf", Position)
    world.spawn("deer", n=2)
    world.flush()
    return world, deer, Genealogy(Journal(world))


def born(world, deer, *parents):
    """A child of one or two parents; returns its uid."""
    uid = world.next_uid
    first, second = [*parents, 0][:2]
    deer.request(np.array([first], np.uint64), {}, np.array([second], np.uint64))
    world.flush()
    return uid


def asked(known, uid, by=None):
    message = tree(known, Families(known.lives), {"kind": "tree", "uid": uid, "by": by})
    return message, {life["uid"]: life for life in message["lives"]}


def test_two_parents_siblings_children_and_grandchildren_are_in_it():
    world, deer, log = family()
    focal = born(world, deer, 1, 2)
    sister, half = born(world, deer, 1, 2), born(world, deer, 2)
    world.step()
    child = born(world, deer, focal, half)
    grandchild = born(world, deer, child)
    great = born(world, deer, grandchild)
    message, lives = asked(log, focal)
    assert set(lives) == {1, 2, focal, sister, half, child, grandchild}
    assert message["siblings"] == 2
    assert [lives[uid]["young"] for uid in (1, 2, focal, child, grandchild)] == [2, 3, 1, 1, 1]
    assert lives[child]["parents"] == [focal, half]
    assert (lives[focal]["born"], lives[child]["born"]) == (0, 1)
    assert lives[focal]["species"] == "deer"
    assert set(asked(log, great)[1]) == {great, grandchild, child, focal, half, 1, 2}


def test_the_dead_have_a_cause_and_an_age():
    world, _, log = family()
    world.spawn("wolf")
    world.flush()
    world.step()
    world.step()
    world.kill(1, "eaten by wolf", killer=3)
    world.step()
    _, lives = asked(log, 1)
    assert lives[1]["died"] == {"tick": 2, "cause": "eaten by wolf", "killer": 3}
    assert lives[1]["age"] == pytest.approx(2 * world.dt)
    assert asked(log, 2)[1][2]["died"] is None


def test_numbers_are_bounded_and_those_with_most_young_are_listed():
    world, deer, log = family()
    parent = 1
    for _ in range(ABOVE + 10):
        parent = born(world, deer, parent)
    brood = [born(world, deer, parent) for _ in range(BELOW + 30)]
    for _ in range(EACH + 5):
        born(world, deer, brood[0])
    message, lives = asked(log, parent)
    children = [uid for uid, life in lives.items() if life["parents"] == [parent]]
    assert children == [brood[0], *brood[-BELOW + 1 :]]
    assert sum(life["parents"] == [brood[0]] for life in lives.values()) == EACH
    assert (lives[parent]["young"], lives[brood[0]]["young"]) == (BELOW + 30, EACH + 5)
    assert len(lives) == 1 + ABOVE + BELOW + EACH
    message, lives = asked(log, brood[3])
    assert message["siblings"] == BELOW + 29
    assert sum(life["parents"] == [parent] for life in lives.values()) == 1 + BESIDE


def test_a_parent_that_is_an_ancestor_twice_is_there_once():
    world, deer, log = family()
    son = born(world, deer, 1, 2)
    inbred = born(world, deer, 1, son)
    message, lives = asked(log, inbred)
    assert sorted(lives) == [1, 2, son, inbred]
    assert message["siblings"] == 0
    _, lives = asked(log, 1)
    assert sorted(lives) == [1, son, inbred]


def test_each_has_the_value_of_its_clade_where_the_colour_is_one_by_descent():
    world, deer, log = family()
    focal = born(world, deer, 1, 2)
    child = born(world, deer, focal, 2)
    families = Families(log.lives)
    shown = families.values("deer", np.array([1, 2, focal, child], np.uint64))

    def clades(by):
        message = tree(log, families, {"uid": focal, "by": by})
        return {life["uid"]: life["clade"] for life in message["lives"]}

    assert shown[0] > 0 == shown[1]  # a family has two at least
    assert clades("family") == dict(zip([1, 2, focal, child], shown.tolist(), strict=True))
    assert clades(f"kin:{focal}") == {1: 0, 2: 0, focal: 255, child: 255}
    assert clades(None) == clades("species") == clades(["kin:1"]) == dict.fromkeys([1, 2, focal, child])


@pytest.mark.parametrize(
    ("uid", "why"),
    [
        (None, "expected the uid"),
        (True, "expected"),
        (-1, "expected"),
        ("3", "expected"),
        (77, "no organism 77 is known"),
    ],
)
def test_a_request_about_nobody_is_refused(uid, why):
    _, _, log = family()
    with pytest.raises(ValueError, match=why):
        tree(log, Families(log.lives), {"kind": "tree", "uid": uid})


def test_forgotten_parents_are_unknown():
    world, deer, log = family()
    child = born(world, deer, 55)  # who was never noted
    _, lives = asked(log, child)
    assert (lives[55]["species"], lives[55]["parents"]) == (None, [])


@pytest.fixture(scope="module", params=[ONE, TWO], ids=["one parent", "two parents"])
def both(request, tmp_path_factory):
    """The same world, alive and recorded, and how many parents a deer has."""
    config = load("predator-prey", DEER | request.param)
    path = tmp_path_factory.mktemp("tree") / "run"
    run_to_folder(config, ticks=34, out=path, seed=4, policies="random", learn=False, report=False)
    live = Live(World.from_config(config, seed=4, policies="random", learn=False, record=False))
    live.world.run(34)
    return live, Replay(path), 1 if request.param is ONE else 2


def test_a_replay_has_the_same_trees_as_the_living_world(both):
    live, replay, parents = both
    deer = [
        uid
        for uid in range(1, live.world.next_uid)
        if (live.genealogy.life(uid) or {}).get("species") == "deer"
    ]
    young = [uid for uid in deer if live.genealogy.parents(uid)]
    assert len(young) > 10
    assert {len(live.genealogy.parents(uid)) for uid in young} == {parents}
    for uid in deer[::9] + young[::9]:
        (message,) = live.handle({"kind": "tree", "uid": uid})
        (again,) = replay.handle({"kind": "tree", "uid": uid})
        assert message == again
    assert any(live.genealogy.died(uid) for uid in deer)


def test_looking_at_trees_changes_nothing(both):
    live, _, _ = both
    before = live.world.digest()
    for uid in range(1, int(live.world.next_uid), 40):
        tree(live.genealogy, live.families, {"uid": uid})
    assert live.world.digest() == before


def test_of_two_worlds_the_tree_is_of_the_one_that_is_asked_about():
    pair, page = forked()
    uid = min(set(uids(pair.first, "deer")) & set(uids(pair.second.source, "deer")))
    pair.second.source.world.kill(uid, "starved")
    pair.second.source.world.flush()
    for second in (False, True):
        page.asks("tree", uid=uid, second=second)
        (told,) = page.sees("tree")
        assert (told["uid"], told.get("second", False)) == (uid, second)
        assert (told["lives"][0]["died"] is not None) == second


def test_who_was_never_born_is_in_no_recording(both):
    _, replay, _ = both
    assert replay.genealogy.life(10**9) is None
