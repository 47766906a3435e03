"""Runs and checkpoints say in which mode they were computed; nobody goes on in the other without a word."""

import json

import pytest

from ecs_eco import World
from ecs_eco.compiled import portable
from ecs_eco.engine.errors import RecordingError
from ecs_eco.record import resume, run_to_folder

WORLD = {
    "format": 1,
    "name": "plants",
    "space": {"size": [10.0, 10.0]},
    "species": {"grass": {"count": 5, "body": {"radius": 0.1}}},
}


@pytest.fixture
def folder(tmp_path):
    run_to_folder(WORLD, ticks=2, out=tmp_path / "run", report=False)
    return tmp_path / "run"


def test_a_manifest_names_mode_and_processor(folder):
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["target"] == portable.target()
    assert manifest["target"]["mode"] == "native"


def test_a_run_is_not_resumed_in_the_other_mode(folder, monkeypatch):
    monkeypatch.setattr(portable, "_on", True)
    with pytest.raises(RecordingError, match="native mode, but this process is in the portable mode"):
        resume(folder, until=4, report=False)
    monkeypatch.setattr(portable, "_on", False)
    assert resume(folder, until=4, report=False)["done"] == 4


def test_a_checkpoint_of_the_other_mode_is_restored_with_a_warning(folder, monkeypatch):
    newest = max((folder / "checkpoints").iterdir())
    monkeypatch.setattr(portable, "_on", True)
    with pytest.warns(RuntimeWarning, match="native mode"):
        world = World.restore(newest, record=False)
    assert world.tick == 2
