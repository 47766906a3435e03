"""Going back in a living world: what was is again, to the bit, and what came after is forgotten."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.view import rewind as module
from ecs_eco.view.live import Live

DONE = [
    {"kind": "cull", "species": "deer", "share": 0.3},
    {"kind": "add", "species": "deer", "count": 7},
    {"kind": "set", "set": {"species.deer.metabolism.basal": 0.02}},
    {"kind": "switch", "reproduction": False, "species": "deer"},
    {"kind": "switch", "learning": False},
    {"kind": "fence", "line": [[5.0, 5.0], [20.0, 5.0]]},
]
SMALL = {
    "space.size": [40, 40],
    "species.grass.count": 150,
    "species.deer.count": 40,
    "species.wolf.count": 5,
}


@pytest.fixture
def live(monkeypatch):
    """A small predator-prey that is watched, with a checkpoint every ten ticks."""
    monkeypatch.setattr(module, "SHARE", 1.0)
    live = Live(World.from_config(load("predator-prey", SMALL), seed=4, policies="random"))
    live.ring.look = _every_ten(live.ring)
    return live


def _every_ten(ring):
    def look():
        if ring.world.tick % 10 == 0 and not (ring.points and ring.points[-1].tick >= ring.world.tick):
            ring._keep()

    return look


def lived(live, until, acts=()):
    """Let it live up to a tick, with what is done at some."""
    acts = dict(acts)

    def turn():
        if live.tick >= until:
            return False
        live.passed()
        if live.tick in acts:
            said = live.handle({"kind": "act", "what": acts.pop(live.tick)})
            assert said[0]["level"] == "info", said
        live.sample()
        return True

    live.run(turn)
    assert live.tick == until


def state(live):
    journal, kin = live.journal, live.genealogy
    lives = [(kin.parents(uid), kin.died(uid), kin.generation(uid)) for uid in range(live.world.next_uid)]
    series = live.world.recorder.series().to_pydict()
    return (
        live.world.digest(),
        journal.born.tolist(),
        journal.died.tolist(),
        list(live.story.entries),
        lives,
        live.curves.after(-1),
        series,
        list(live.world.intervened),
    )


@pytest.mark.parametrize("act", DONE, ids=lambda act: next(iter(set(act) & {"learning"}), act["kind"]))
def test_what_was_is_again_and_its_future_too(live, act):
    lived(live, 33)
    then = state(live)
    lived(live, 47, {37: act})
    later = live.world.digest()
    live.handle({"kind": "seek", "tick": 42})  # what was done at tick 37 is done again on the way
    assert live.tick == 42
    lived(live, 47)
    assert live.world.digest() == later
    live.handle({"kind": "seek", "tick": 33})
    assert state(live) == then


def test_who_is_born_again_is_one_child(live):
    lived(live, 60)
    then = state(live)
    told = live.fates(-1)
    live.handle({"kind": "seek", "tick": 52})  # from the checkpoint of tick 50
    assert all(fate[0] < 52 for fate in live.fates(-1))
    live.handle({"kind": "seek", "tick": 51})
    lived(live, 60)
    assert live.fates(-1) == told
    live.handle({"kind": "seek", "tick": 59})
    lived(live, 60)
    assert state(live)[4] == then[4]
    assert (np.diff(live.genealogy.lives()[0].astype(np.int64)) > 0).all()


def test_a_world_that_is_changed_goes_another_way(live):
    lived(live, 30)
    first = live.world.digest()
    live.handle({"kind": "seek", "tick": 15})
    lived(live, 30, {20: DONE[0]})
    assert live.world.digest() != first


def test_where_it_cannot_go_it_says_so(live):
    lived(live, 12)
    with pytest.raises(ValueError, match="expected at most 12"):
        live.handle({"kind": "seek", "tick": 13})
    with pytest.raises(ValueError, match="a tick up to 12"):
        live.handle({"kind": "seek", "tick": None})
    live.ring.points.popleft()
    live.handle({"kind": "seek", "tick": 3})
    assert live.tick == 10  # the first that is kept


def test_the_oldest_checkpoint_goes_when_memory_is_full(live, monkeypatch):
    lived(live, 25)
    assert [point.tick for point in live.ring.points] == [0, 10, 20]
    monkeypatch.setattr(module, "MEMORY", 2.5 * live.ring.points[0].size)
    lived(live, 45)
    assert live.ring.first > 0
    assert all(np.isfinite(point.size) for point in live.ring.points)
