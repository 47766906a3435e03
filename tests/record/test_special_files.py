"""A pipe, a device or a folder in the place of a file of a run or a search: refused by its name,
and never waited for."""

import os
import re
import shutil

import pytest

from ecs_eco.analysis.relief import Relief
from ecs_eco.cli.sweeping import mode_of
from ecs_eco.config import load
from ecs_eco.config.land.land import kept_land
from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError
from ecs_eco.engine.files import read_json, read_note
from ecs_eco.lab.searching.journal import Journal, read as read_journal
from ecs_eco.learning.weights import hash_of
from ecs_eco.record import run_to_folder
from ecs_eco.record.belonging import mark_of
from ecs_eco.record.checkpoint import describe, latest, read
from ecs_eco.record.claim import LOCK, claimed, owner_of
from ecs_eco.record.parquet import read_metadata, read_part
from ecs_eco.record.seal import read_manifest

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
KINDS = {
    "a pipe": os.mkfifo,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    "a folder": lambda path: path.mkdir(),
}

WORLD = """\
format = 1
name = "w"
space = { size = [9.0, 9.0] }
data = { file = "data.csv" }
[species.a]
count = 1
body = { radius = 0.1 }
"""


@pytest.fixture(params=KINDS)
def put(request):
    """A function that puts something else in the place of a file."""

    def replace(path):
        path.unlink(missing_ok=True)
        KINDS[request.param](path)
        return path

    return replace


@pytest.fixture(scope="module")
def recorded(meadow, tmp_path_factory):
    run = tmp_path_factory.mktemp("special") / "run"
    run_to_folder(meadow().config, 3, 4, run, report=False, checkpoint_every=2)
    return run


@pytest.fixture
def run(recorded, tmp_path):
    shutil.copytree(recorded, tmp_path / "run")
    return tmp_path / "run"


def test_in_the_place_of_a_checkpoint(run, put):
    path = put(sorted((run / "checkpoints").iterdir())[-1])
    for reader in (read, describe):
        with pytest.raises(CheckpointError, match=path.name):
            reader(path)
    complaints = []
    assert (
        latest(run / "checkpoints", complain=complaints.append) == sorted((run / "checkpoints").iterdir())[-2]
    )
    assert path.name in complaints[0]


def test_in_the_place_of_a_part(run, put):
    path = put(run / "series" / "part-00000.parquet")
    for reader in (read_part, read_metadata, mark_of):
        with pytest.raises(
            RecordingError, match=r"part-00000\.parquet: cannot be read.*(is a folder|is not a regular file)"
        ):
            reader(path)


def test_in_the_place_of_a_manifest(run, put):
    put(run / "manifest.json")
    with pytest.raises(FileNotFoundError, match=r"is not a run folder: has no manifest\.json"):
        read_manifest(run)


def test_in_the_place_of_a_note(tmp_path, put):
    path = put(tmp_path / "progress.json")
    assert read_note(path) == {}
    with pytest.raises(RecordingError, match=r"progress\.json: is damaged: is (a folder|not a regular file)"):
        read_json(path)
    put(tmp_path / ".lock")
    assert owner_of(tmp_path) is None
    put(tmp_path / "sweep.json")
    assert mode_of(tmp_path) is None


def test_json_that_is_nested_too_deeply_is_damaged(tmp_path):
    (tmp_path / "sweep.json").write_text("[" * 100_000)
    assert mode_of(tmp_path) is None
    with pytest.raises(RecordingError, match=r"sweep\.json: is damaged"):
        read_manifest(tmp_path, "sweep.json")


def test_in_the_place_of_land(run, put):
    put(run / "terrain.npz")
    config = {"terrain": None, "space": {"size": [9.0, 9.0], "edges": "walls"}}
    assert Relief.kept(run, config) is None
    with pytest.raises(ConfigError, match="cannot read the land of this run"):
        kept_land(run)


def test_in_the_place_of_measurements_and_weights(tmp_path, put):
    (tmp_path / "w.toml").write_text(WORLD)
    put(tmp_path / "data.csv")
    with pytest.raises(ConfigError, match=r"cannot be read: is (a folder|not a regular file)"):
        load(tmp_path / "w.toml")
    with pytest.raises(OSError, match=r"is a folder|is not a regular file"):
        hash_of(put(tmp_path / "a.safetensors"))


def test_a_new_journal_is_not_written_to_it(tmp_path, put):
    put(tmp_path / "journal.jsonl")
    with pytest.raises(OSError, match=r"is a folder|is not a regular file"):
        Journal(tmp_path, {})


def test_in_the_place_of_a_journal(tmp_path, put):
    with pytest.raises(OSError, match=r"is a folder|is not a regular file"):
        read_journal(put(tmp_path / "journal.jsonl"))


def test_the_lock_of_a_folder(put, tmp_path):
    place = put(tmp_path / LOCK)
    with pytest.raises(OSError, match=re.escape(str(place))), claimed(tmp_path):
        pass
