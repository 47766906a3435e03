"""A run that was recorded when keys had other names is read, resumed and repeated."""

import shutil
import tomllib
from pathlib import Path

import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.record.seal import read_manifest
from ecs_eco.runs.repeat import repeat
from ecs_eco.runs.run import resume

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
