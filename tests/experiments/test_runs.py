"""One run of an arm: begun, gone on with, or found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from ecs_eco.config import load
from ecs_eco.engine.errors import ForeignFile
from ecs_eco.experiments.arm import Arm
from ecs_eco.experiments.runs import has_run, run_arm
from ecs_eco.runs.run import run_to_folder

FEW = ["species.grass.count=60", "species.deer.count=12", "species.wolf.count=2"]


@pytest.mark.slow
def test_a_run_that_was_stopped_goes_on_and_ends_with_the_same_bytes(tmp_path: Path) -> None:
    arm = Arm("world", load("predator-prey", FEW))
    whole = run_arm(arm, 1, 8, tmp_path / "whole")
    run_to_folder(arm.config, seed=1, ticks=5, out=tmp_path / "half", report=False)
    assert not has_run(tmp_path / "half", 8, arm, 1)
    assert run_arm(arm, 1, 8, tmp_path / "half")["digest"] == whole["digest"]
    assert has_run(tmp_path / "half", 8, arm, 1)
    for file in (tmp_path / "half" / "checkpoints").iterdir():
        file.write_bytes(b"no checkpoint")
    (tmp_path / "half" / "manifest.json").write_text("{}")
    assert run_arm(arm, 1, 8, tmp_path / "half")["digest"] == whole["digest"]


def test_a_run_of_another_seed_or_arm_is_refused(tmp_path: Path) -> None:
    arm = Arm("world", load("predator-prey", FEW))
    run_to_folder(arm.config, seed=1, ticks=2, out=tmp_path / "run", report=False)
    assert has_run(tmp_path / "run", 2, arm, 1)
    with pytest.raises(ForeignFile, match="is of another run \\(seed 1\\) than world, seed 2"):
        has_run(tmp_path / "run", 2, arm, 2)
    with pytest.raises(ForeignFile, match="is of another run \\(learn\\) than world, seed 1"):
        has_run(tmp_path / "run", 2, replace(arm, learn=True), 1)
