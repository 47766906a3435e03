"""A result is of one run: what belongs to another one is refused by its name,
and nothing but a run's own files is removed."""

import json
import shutil

import pytest

from ecs_eco.config import load
from ecs_eco.config.shipped import shipped
from ecs_eco.engine import files
from ecs_eco.engine.errors import FolderInUse, RecordingError
from ecs_eco.record import fork, resume, run_to_folder
from ecs_eco.record.belonging import mark_of
from ecs_eco.record.claim import LOCK, Claim
from ecs_eco.record.parquet import read_parts
from ecs_eco.runs.repeat import repeat
from studies.common.foreign.ground import LIVES, make
from studies.common.foreign.kinds import KINDS
from studies.common.foreign.refusal import refused


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    place = tmp_path_factory.mktemp("whole") / "all"
    make(place)
    return place


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_foreign_file_is_refused_by_its_name(whole, tmp_path, kind):
    assert refused(kind, whole, tmp_path / "copy") == ""


@pytest.fixture
def plain(meadow, tmp_path):
    """A small run, of two deer and two grasses."""
    config = meadow().config
    manifest = run_to_folder(
        config, 3, 6, tmp_path / "run", report=False, checkpoint_every=2, snapshot_every=2
    )
    return tmp_path / "run", manifest, config


def test_equal_runs_have_one_id_and_others_another(plain, tmp_path):
    run, manifest, config = plain
    ids = {
        name: run_to_folder(config, seed, 6, tmp_path / name, report=False, snapshot_every=every)["id"]
        for name, seed, every in (("same", 3, 2), ("seed", 4, 2), ("snapshots", 3, 3))
    }
    ids["fork"] = fork(run, tmp_path / "fork", from_tick=3, report=False)["id"]
    assert ids["same"] == manifest["id"]
    assert len({*ids.values()}) == 4


def test_each_part_names_its_run_and_the_part_before_it(plain):
    run, manifest, _ = plain
    before = ""
    for number in range(manifest["parts"]["series"]):
        mark, own = mark_of(run / "series" / f"part-{number:05d}.parquet")
        assert mark == (manifest["id"], "meadow", 3, "series", number, before)
        before = own
    assert number == 2
    assert manifest["heads"]["series"] == before


def test_a_second_process_is_refused_where_one_goes_on(plain):
    run, _, config = plain
    with Claim(run):
        with pytest.raises(FolderInUse, match="run: is in use by process"):
            resume(run, 8, report=False)
        assert read_parts(run / "series").num_rows == 12  # reading is free
    with pytest.raises(FileExistsError):
        run_to_folder(config, 3, 6, run, report=False)
    assert resume(run, 8, report=False)["done"] == 8
    assert not (run / LOCK).exists()


def test_resume_removes_nothing_that_the_run_did_not_write(plain):
    run, _, _ = plain
    mine = ["notes.tmp", "series/notes.tmp", "own/draft.tmp", "own/.a.ecs-eco-7-0123abcd.tmp", ".notes.txt"]
    half = ["series/.part-00009.parquet.ecs-eco-7-0123abcd.tmp", ".manifest.json.ecs-eco-7-0123abcd.tmp"]
    for name in [*mine, *half]:
        (run / name).parent.mkdir(exist_ok=True)
        (run / name).write_text("x")
    resume(run, 8, report=False)
    assert [name for name in mine if not (run / name).is_file()] == []
    assert [name for name in half if (run / name).exists()] == []


class _PowerCut(BaseException):
    """Something from outside."""


def test_a_run_that_was_killed_in_the_first_write_of_its_manifest_can_be_run_again(
    plain, tmp_path, monkeypatch
):
    _, manifest, config = plain
    replace = files.os.replace

    def cut(beside, path):
        if path.name == "manifest.json":
            shutil.copytree(tmp_path / "new", tmp_path / "killed")  # as the disk is then
            raise _PowerCut
        replace(beside, path)

    with monkeypatch.context() as m:
        m.setattr(files.os, "replace", cut)
        with pytest.raises(_PowerCut):
            run_to_folder(config, 3, 6, tmp_path / "new", report=False, checkpoint_every=2, snapshot_every=2)
    assert not (tmp_path / "new").exists()
    assert (tmp_path / "killed" / LOCK).is_file()
    with pytest.raises(RecordingError, match="was killed there before it started: run it again with --out"):
        resume(tmp_path / "killed")
    again = run_to_folder(
        config, 3, 6, tmp_path / "killed", report=False, checkpoint_every=2, snapshot_every=2
    )
    assert again["digest"] == manifest["digest"]
    assert {p.name for p in (tmp_path / "killed").iterdir()} == {p.name for p in (tmp_path / "run").iterdir()}


def test_a_folder_that_is_replaced_while_it_is_written_gets_no_more_parts(plain, tmp_path):
    _, _, config = plain

    def replaced(done, ticks):
        if done >= 2 and not (tmp_path / "moved").exists():
            (tmp_path / "new").rename(tmp_path / "moved")
            (tmp_path / "new").mkdir()

    with pytest.raises(FolderInUse, match="new: was removed or replaced"):
        run_to_folder(config, 3, 6, tmp_path / "new", report=False, checkpoint_every=2, progress=replaced)
    assert list((tmp_path / "new").iterdir()) == []


def test_a_world_with_its_own_weights_repeats_from_any_folder(tmp_path):
    world = tmp_path / "mine"
    shutil.copytree(shipped()["predator-prey"].parent, world)
    for one, other in (("deer", "deer"), ("wolf", "wolf")):
        _other_weights(world / f"{one}.safetensors", world / f"{other}.safetensors")
    config = load(world, LIVES)
    manifest = run_to_folder(config, 1, 5, tmp_path / "run", report=False)
    named = run_to_folder(load("predator-prey", LIVES), 1, 5, tmp_path / "shipped", report=False)
    assert manifest["digest"] != named["digest"]
    assert manifest["id"] != named["id"]
    shutil.rmtree(world)
    (tmp_path / "run").rename(tmp_path / "elsewhere")
    assert repeat(tmp_path / "elsewhere")["same"]
    for checkpoint in (tmp_path / "elsewhere" / "checkpoints").iterdir():
        checkpoint.unlink()
    forked = fork(
        tmp_path / "elsewhere", tmp_path / "fork", 5, until=6, report=False
    )  # repeated from its start
    assert forked["forked"]["digest"] == manifest["digest"]


def _other_weights(path, into):
    from ecs_eco.learning import weights

    weights.save(into, {name: array[..., ::-1] for name, array in weights.load(path).items()})


def test_a_run_of_an_older_format_is_read_and_not_gone_on_with(plain):
    from ecs_eco.analysis.runs import load_series
    from ecs_eco.record.parquet import read_part, write_part
    from ecs_eco.record.seal import write_manifest

    run, manifest, _ = plain
    old = {key: value for key, value in manifest.items() if key not in ("id", "heads", "weights")} | {
        "format": 1
    }
    for path in run.rglob("*.parquet"):
        write_part(read_part(path).replace_schema_metadata(None), path)
    write_manifest(run, old)
    assert load_series(run).n.shape == (6, 2)
    with pytest.raises(RecordingError, match="has format 1 of an older version"):
        resume(run, 8)
    assert json.loads((run / "manifest.json").read_text())["done"] == 6
