"""One run of an arm: begun, gone on with, or found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from ecs_eco.config import load
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.lab.jobs import has_run, run_arm
from ecs_eco.lab.treatments import Arm
from ecs_eco.record import seal
from ecs_eco.runs.run import run_to_folder

FEW = ["species.grass.count=60", "species.deer.count=12", "species.wolf.count=2"]


@pytest.mark.slow
def test_a_run_that_was_stopped_goes_on_and_ends_with_the_same_bytes(tmp_path: Path) -> None:
    arm = Arm("world", load("predator-prey", FEW))
    whole = run_arm(arm, 1, 8, tmp_path / "whole")
    run_to_folder(arm.config, seed=1, ticks=5, out=tmp_path / "half", report=False)
    assert not has_run(arm, 1, 8, tmp_path / "half")
    assert run_arm(arm, 1, 8, tmp_path / "half")["digest"] == whole["digest"]
    assert has_run(arm, 1, 8, tmp_path / "half")
    half = tmp_path / "half"
    before = content(half)
    (half / "manifest.json").write_text("{")
    for call in (lambda: run_arm(arm, 1, 8, half), lambda: has_run(arm, 1, 8, half)):
        with pytest.raises(RecordingError, match=r"manifest\.json: is damaged"):
            call()
    assert content(half) == before | {"manifest.json": b"{"}  # nothing finished is removed


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_a_run_of_the_other_mode_is_refused_and_left_as_it_is(tmp_path: Path) -> None:
    arm = Arm("world", load("predator-prey", FEW))
    run_to_folder(arm.config, seed=1, ticks=2, out=tmp_path, report=False)
    manifest = seal.read_manifest(tmp_path)
    seal.write_manifest(tmp_path, manifest | {"target": {"mode": "portable"}})
    before = content(tmp_path)
    for call in (lambda: run_arm(arm, 1, 2, tmp_path), lambda: has_run(arm, 1, 2, tmp_path)):
        with pytest.raises(ForeignFile, match="computed in the portable mode"):
            call()
    assert content(tmp_path) == before


def test_a_run_of_another_seed_or_arm_is_refused(tmp_path: Path) -> None:
    arm = Arm("world", load("predator-prey", FEW))
    run_to_folder(arm.config, seed=1, ticks=2, out=tmp_path / "run", report=False)
    assert has_run(arm, 1, 2, tmp_path / "run")
    with pytest.raises(ForeignFile, match="belongs to another run \\(seed 1\\), not to world, seed 2"):
        has_run(arm, 2, 2, tmp_path / "run")
    with pytest.raises(ForeignFile, match="belongs to another run \\(learn\\), not to world, seed 1"):
        has_run(replace(arm, learn=True), 1, 2, tmp_path / "run")
