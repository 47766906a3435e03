"""A branch: the world from a tick on, with a change or without, beside the original that stays as it is."""

import gc
import weakref

import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.config import load
from ecs_eco.engine.errors import CheckpointError, ConfigError
from ecs_eco.record import run_to_folder
from ecs_eco.systems.schedule import schedule
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from ecs_eco.view.second import fork
from tests.view.parks import ACTS, SMALL, small

WITHOUT = {"kind": "cull", "species": "wolf", "share": 1.0}


def lived(ticks, acts=None):
    """A living world that has been watched for so long, and acted on by pages."""
    live = Live(small())
    live.ring.used = True
    for tick in range(ticks):
        live.ring.look()
        if acts and tick in acts:
            assert live.handle({"kind": "act", "what": acts[tick]})[0]["level"] == "info"
        live.world.run(1)
        live.passed()
    return live


@pytest.mark.parametrize("tick", [9, 14, 25])
def test_a_branch_without_a_change_is_the_original_to_the_bit(tick):
    live = lived(25, ACTS)
    branch = fork(live, tick, None)
    assert branch.run_to(25, 60)
    assert branch.source.world.digest() == live.world.digest()
    branch.run_to(40, 60)
    assert branch.source.world.digest() == live.world.run(15).digest()


def test_what_is_asked_of_the_original_and_waits_is_done_to_the_branch_once():
    live = lived(10)
    live.handle({"kind": "act", "what": ACTS[5]})
    branch = fork(live, 10, None)
    live.world.run(3)
    branch.run_to(13, 60)
    assert len(branch.source.world.intervened) == 1
    assert branch.source.world.digest() == live.world.digest()


def test_what_is_done_to_the_original_later_is_done_to_the_branch_too():
    live = lived(10)
    branch = fork(live, 6, None)
    live.handle({"kind": "act", "what": ACTS[3]})
    live.world.run(5)
    branch.run_to(15, 60)
    assert branch.source.world.digest() == live.world.digest()


def test_a_change_makes_the_world_that_a_world_file_with_it_makes():
    live = lived(20)
    before = live.world.digest()
    branch = fork(live, 12, WITHOUT)
    branch.run_to(30, 60)
    file = load("predator-prey", SMALL | {"interventions": [{"at": 12, **WITHOUT}]})
    made = World.from_config(file, seed=5, policies="random", record=False)
    assert branch.source.world.digest() == made.run(30).digest()
    assert branch.source.counts()["wolf"] == 0
    assert live.world.digest() == before
    assert live.world.run(10).digest() == small().run(30).digest() != branch.source.world.digest()


def test_a_branch_goes_back_as_far_as_its_start_and_comes_to_the_same():
    live = lived(20)
    branch = fork(live, 12, WITHOUT)
    branch.run_to(30, 60)
    then = branch.source.world.digest()
    for tick in (20, 3):  # before its start it stays there
        branch.back_to(tick)
        assert branch.tick == max(tick, 12)
        branch.run_to(30, 60)
        assert branch.source.world.digest() == then
        assert [tick for tick, _ in branch.source.world.intervened] == [12]


def test_what_cannot_be_is_refused_with_what_is_allowed():
    live = lived(10)
    with pytest.raises(ValueError, match="tick = 11; expected at most 10, the current tick"):
        fork(live, 11, None)
    with pytest.raises(ConfigError, match='did you mean "wolf"'):
        fork(live, 5, WITHOUT | {"species": "wulf"})
    with pytest.raises(ValueError, match="is not an intervention"):
        fork(live, 5, "cull")
    live.ring.points.popleft()
    first = live.earliest
    with pytest.raises(ValueError, match=f"tick = 0; expected {first} to 10, the stored ticks"):
        fork(live, 0, None)
    live.ring.why = "this run is being recorded, and its records cannot be undone"
    assert live.earliest == 10
    assert fork(live, 10, None).source.world.digest() == live.world.digest()


def test_a_world_that_was_made_by_hand_is_refused():
    world = World((10, 10))
    world.add_table("stone", Position)
    for system in schedule():
        world.add_system(system)
    with pytest.raises(CheckpointError, match="built in Python"):
        fork(Live(world), 0, None)


def test_a_branch_that_nobody_holds_is_gone():
    live = lived(6)
    branch = fork(live, 6, None)
    branch.run_to(9, 60)
    world = weakref.ref(branch.source.world)
    del branch
    gc.collect()
    assert world() is None


def test_a_recorded_run_goes_on_as_it_did_where_nothing_is_changed(tmp_path):
    acts = dict(ACTS)

    def prepare(world):
        world.before_tick.append(lambda: world.intervene(acts[world.tick]) if world.tick in acts else None)

    manifest = run_to_folder(
        load("predator-prey", SMALL),
        5,
        24,
        tmp_path,
        "random",
        checkpoint_every=10,
        prepare=prepare,
        report=False,
    )
    replay = Replay(tmp_path)
    replay.handle({"kind": "seek", "tick": 7})
    same, other = fork(replay, None, None), fork(replay, None, WITHOUT)
    assert same.begins == 8
    for branch in (same, other):
        branch.run_to(23, 60)
    assert same.source.world.digest() == manifest["digest"]
    assert {n: same.source.counts()[n] for n in ("deer", "wolf")} == {
        n: int(replay.recording.numbers(23)[n]) for n in ("deer", "wolf")
    }
    assert other.source.world.digest() != manifest["digest"]
    replay.handle({"kind": "seek", "tick": 23})
    with pytest.raises(ValueError, match="cannot be branched at its last tick"):
        fork(replay, None, None)
