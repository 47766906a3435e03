"""Runs that were recorded when keys had other names, or manifests had format 1, are read and repeated."""

import shutil
import tomllib
from pathlib import Path

import pytest

from ecs_eco import World
from ecs_eco.analysis.report.write import write_report
from ecs_eco.analysis.runs import load_series
from ecs_eco.config import load
from ecs_eco.engine.errors import RecordingError
from ecs_eco.record.seal import read_manifest
from ecs_eco.runs.repeat import repeat
from ecs_eco.runs.run import resume
from ecs_eco.view.replay import Replay

FORMER = (
    Path(__file__).parent / "former"
)  # of version 0.2: ecs-eco run fell.toml --seed 3 --policies untrained


@pytest.fixture
def run(tmp_path):
    return Path(shutil.copytree(FORMER / "run", tmp_path / "run"))


def test_its_configuration_has_the_present_names_and_its_own_hash(run):
    manifest = read_manifest(run)
    assert manifest["config"]["species"]["vole"]["metabolism"]["handling_time"] == 1.0
    assert load(manifest["config"]).config_hash == manifest["config_hash"]
    assert load(FORMER / "fell.toml").config_hash == manifest["config_hash"]


def test_its_checkpoint_is_restored(run):
    world = World.restore(run / "checkpoints" / "tick-000000000012.safetensors")
    assert world.digest() == read_manifest(run)["digest"]
    assert world.config.species["vole"].metabolism.handling_time == 1.0


@pytest.mark.slow
def test_it_is_resumed(run):
    manifest = resume(run, 14, report=False)
    assert (manifest["done"], manifest["finished"]) == (14, True)
    assert read_manifest(run)["config_hash"] == read_manifest(FORMER / "run")["config_hash"]


@pytest.mark.slow
def test_it_is_repeated_with_the_end_that_its_world_file_has_on_this_processor(run):
    again = repeat(run)
    change = {"at": 8, "kind": "set", "set": {"species.worm.metabolism.growth": 0.03}}
    fell = tomllib.loads((FORMER / "fell.toml").read_text()) | {"interventions": [change]}
    assert again["digest"] == World.from_config(fell, seed=3, policies="untrained").run(12).digest()
    assert again["same"] or "another processor" in again["why"]  # native bits differ between processors


@pytest.fixture
def heath(tmp_path):
    """Return a run whose manifest has format 1, made by version 0.1: voles on moss, seed 3, random policies."""
    return Path(shutil.copytree(FORMER / "manifest_1", tmp_path / "heath"))


def test_a_run_in_format_1_is_read_and_not_resumed(heath):
    assert load_series(heath).n[[0, -1]].tolist() == [[9, 8], [4, 10]]
    assert load(read_manifest(heath)["config"]).species["vole"].default_action["turn"] == "none"
    assert Replay(heath).species == ["moss", "vole"]
    world = World.restore(heath / "checkpoints" / "tick-000000000012.safetensors")
    assert [table.n for table in world.tables.values()] == [4, 10]
    with pytest.raises(RecordingError, match=r"format 1 .* can be read and repeated, but not resumed"):
        resume(heath, 14, report=False)


@pytest.mark.slow
def test_a_run_in_format_1_is_reported_and_repeated(heath, tmp_path):
    assert "vole" in write_report(heath).read_text()
    again = repeat(heath, tmp_path / "again")
    assert (again["ticks"], again["recorded"]) == (12, read_manifest(heath)["digest"])
    assert load_series(tmp_path / "again").n.tolist() == load_series(heath).n.tolist()
    assert "recorded with versions other than" in again["why"]
    assert "None" not in again["why"]  # such a manifest does not name its processor
