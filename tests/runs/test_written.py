"""A world recorded in memory and written to a folder, against the same run recorded in a folder."""

import json
import shutil
from types import MappingProxyType

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.engine.errors import CheckpointError, RecordingError
from ecs_eco.record import Recorder, fork, resume, run_to_folder
from ecs_eco.record.folder import Folder
from ecs_eco.record.parquet import read_parts
from ecs_eco.runs.repeat import repeat
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from ecs_eco.view.rerun import compute

SMALL = {
    "space.size": [64.0, 64.0],
    "species.grass.count": 200,
    "species.deer.count": 30,
    "species.wolf.count": 4,
}
TICKS, EVERY, HOW = 40, 5, {"seed": 7, "policies": "untrained", "learn": True}


def _living(config, block=1000, every=EVERY):
    world = World.from_config(config, record=False, **HOW)
    Recorder(world, keep_events=True, snapshot_every=every, block=block)
    return world


def _content(folder):
    kinds = sorted(kind.name for kind in folder.iterdir() if any(kind.glob("part-*.parquet")))
    return {kind: read_parts(folder / kind).to_pydict() for kind in kinds}


@pytest.fixture(scope="module")
def config(menagerie):
    return menagerie()


@pytest.fixture(scope="module")
def recorded(config, tmp_path_factory):
    out = tmp_path_factory.mktemp("recorded") / "run"
    manifest = run_to_folder(config, ticks=TICKS, out=out, report=False, snapshot_every=EVERY, **HOW)
    return manifest, _content(out), out


@pytest.mark.parametrize("block", [1000, 7])
def test_its_folder_is_that_of_the_same_run_and_the_world_continues(config, recorded, tmp_path, block):
    world, out = _living(config, block).run(TICKS), tmp_path / "living"
    series, births = world.series(), world.recorder.events("births")
    manifest = world.to_folder(out)
    assert manifest["digest"] == recorded[0]["digest"] == world.digest()
    assert _content(out) == recorded[1]
    assert {"matter", "learning", "actions"} <= recorded[1].keys()
    assert json.loads((out / "manifest.json").read_text())["finished"]
    assert world.series().equals(series)
    assert all(map(np.array_equal, world.recorder.events("births").values(), births.values()))
    shutil.copytree(recorded[2], tmp_path / "run")
    ends = [resume(folder, until=TICKS + 15, report=False)["digest"] for folder in (out, tmp_path / "run")]
    assert ends[0] == ends[1] == world.run(15).digest()
    assert _content(out) == _content(tmp_path / "run")
    assert repeat(out)["same"]


def test_without_snapshots_the_last_tick_is_exact_and_no_organism_is_missing_before(
    config, recorded, tmp_path
):
    _living(config, every=0).run(TICKS).to_folder(tmp_path / "living")
    sparse, dense = Replay(tmp_path / "living").recording, Replay(recorded[2]).recording
    for name in dense.species:
        for tick in (0, 17, TICKS - 1):
            mine, other = (r.organisms(tick, name) for r in (sparse, dense))
            assert sorted(mine.uid) == sorted(other.uid)
    last = dense.snapshots.ticks()[1]  # the last snapshot of a run is from an earlier tick
    assert last < TICKS - 1 == sparse.snapshots.ticks()[1]


def test_requests_by_hand_and_changed_values_are_repeated(tmp_path):
    world = {
        "format": 1,
        "name": "meadow",
        "space": {"size": [20.0, 20.0]},
        "species": {"moss": {"count": 60, "body": {"radius": 0.1}, "metabolism": {"basal": 0.01}}},
        "interventions": [
            {"kind": "cull", "species": "moss", "count": 5, "at": 3},
            {"kind": "set", "set": {"species.moss.metabolism.basal": 0.02}, "at": 4},
        ],
    }
    world = _living(world)
    for _ in range(2):
        world.run(3)
        world.intervene({"kind": "cull", "species": "moss", "count": 4})
    world.run(3)
    out = tmp_path / "meadow"
    manifest = world.to_folder(out)
    assert manifest["config"]["species"]["moss"]["metabolism"]["basal"] == 0.01
    assert [tick for tick, _ in manifest["asked"]] == [3, 6]
    assert repeat(out)["same"]
    r = Replay(out).recording
    assert r.last == 8
    assert compute(out, r.manifest, 8, 8, r.recorded).wrong is None


@pytest.mark.parametrize(
    "learn", [{"deer": np.True_, "wolf": False}, MappingProxyType({"deer": True}), np.True_, None]
)
def test_its_start_is_that_of_the_world_and_earlier_ticks_can_be_forked(tmp_path, learn):
    config = load("predator-prey", SMALL)
    world = World.from_config(config, seed=3, policies="untrained", learn=learn, record=False)
    Recorder(world, keep_events=True)
    manifest = world.run(8).to_folder(tmp_path / "small")
    assert manifest["policies"] == "untrained"
    assert json.loads((tmp_path / "small" / "manifest.json").read_text())["learn"] == (
        {name: bool(on) for name, on in learn.items()} if hasattr(learn, "items") else learn
    )
    assert repeat(tmp_path / "small")["same"]
    assert fork(tmp_path / "small", tmp_path / "fork", 4, until=6, report=False)["forked"]["tick"] == 4
    world.save(tmp_path / "world.ckpt")
    for folder, tick in (("small", None), ("fork", 3)):
        for file in (tmp_path / folder / "checkpoints").iterdir():
            file.unlink()
        with pytest.raises(CheckpointError, match="has no intact checkpoint"):
            fork(tmp_path / folder, tmp_path / "again", tick, report=False)
    assert not (tmp_path / "again").exists()


def test_watching_a_world_forgets_nothing_that_it_keeps(tmp_path):
    world = _living(load("predator-prey", SMALL), block=2)
    Live(world)
    assert world.run(2000).to_folder(tmp_path / "watched")["parts"]["series"] >= 1000
    assert Replay(tmp_path / "watched").recording.first == 0


def test_a_write_that_fails_leaves_no_folder_and_keeps_the_records(config, tmp_path, monkeypatch):
    world = _living(config).run(12)
    series, sink, calls = world.series(), Folder.sink, []

    def full(self, kind, columns):
        calls.append(kind)
        if len(calls) == 4:
            raise OSError(28, "No space left on device")
        sink(self, kind, columns)

    with monkeypatch.context() as m:
        m.setattr(Folder, "sink", full)
        with pytest.raises(OSError, match="No space left"):
            world.to_folder(tmp_path / "run")
    assert not (tmp_path / "run").exists()
    assert world.series().equals(series)
    assert repeat(tmp_path / "run")["same"] if world.to_folder(tmp_path / "run") else False


def test_a_world_that_cannot_be_written_reports_why(config, tmp_path):
    out = tmp_path / "run"
    with pytest.raises(
        RecordingError, match=r"has no recorder that keeps events in memory, .*keep_events=True"
    ):
        World.from_config(config, **HOW).to_folder(out)
    with pytest.raises(RecordingError, match="was built by hand"):
        World().to_folder(out)
    late = World.from_config(config, record=False, **HOW).run(3)
    Recorder(late, keep_events=True)
    with pytest.raises(RecordingError, match="not recorded from its first tick on"):
        late.run(2).to_folder(out)
    twice = World.from_config(config, **HOW)
    Recorder(twice, keep_events=True)
    with pytest.raises(RecordingError, match=r"has more than one recorder, .*record=False"):
        twice.run(1).to_folder(out)
    world = _living(config)
    path = world.save(tmp_path / "start.ckpt")
    again = World.restore(path, record=False, prepare=lambda world: Recorder(world, keep_events=True)).run(2)
    with pytest.raises(RecordingError, match="restored or copied"):
        again.to_folder(out)
    asked = _living(load("predator-prey", SMALL)).run(2)
    asked.intervene({"kind": "cull", "species": "deer", "share": 0.1})
    with pytest.raises(RecordingError, match="waiting for its next tick"):
        asked.to_folder(out)
    assert asked.run(1).to_folder(tmp_path / "asked")["asked"][0][0] == 2
    assert not out.exists()
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    with pytest.raises(FileExistsError):
        world.run(1).to_folder(out)
    assert [file.name for file in out.iterdir()] == ["mine.txt"]
