"""compare with training seeds, and comparisons that are gone on with."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.config import load
from ecs_eco.engine.errors import FolderInUse
from ecs_eco.experiments import seed_grid as crossing
from ecs_eco.experiments.comparison import Arm, arms_of, run_one
from ecs_eco.record import run_to_folder

FEW = ["species.grass.count=60", "species.deer.count=12", "species.wolf.count=2", "training.ticks=3", "training.set={}"]
SET = [word for change in FEW for word in ("--set", change)]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def invoke(*arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, ["compare", "predator-prey", *arguments])
    assert done.exit_code == code, done.output + repr(done.exception)
    return done.output


def in_this_process(jobs: dict, workers: int, quiet: bool, work: Any = None, *_: object, **__: object) -> dict:
    return {name: (work or run_one)(*job) for name, job in jobs.items()}


def written(folder: Path) -> dict[Path, int]:
    """When each training and each run in a folder ended."""
    return {p: p.stat().st_mtime_ns for p in folder.rglob("*.json") if p.name in ("training.json", "manifest.json")}


def test_each_policy_is_trained_once_and_lives_in_every_world_and_nothing_is_done_twice(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ecs_eco.experiments.comparison.run_all", in_this_process)
    words = [*SET, "--training-seeds", "2", "--ticks", "4", "--control", "random-policy", "--control", "dt=0.5", "--retrain"]
    invoke(*words, "--seeds", "1", "--out", "out")
    before = written(here / "out")
    said = invoke(*words, "--seeds", "2", "--out", "out")
    after = written(here / "out")
    assert before.items() <= after.items()
    assert "5 of 10 runs are there already." in said
    policies = {(p.parent.parent.name, json.loads(p.read_text())["seed"]) for p in (here / "out").rglob("training.json")}
    assert policies == {("world", 1), ("world", 2), ("dt-0.5", 1), ("dt-0.5", 2)}
    ran = {str(p.parent.relative_to(here / "out")): json.loads(p.read_text()) for p in after if p.name == "manifest.json"}
    assert set(ran) == {f"{arm}/training-{k}/seed-{w}" for arm in ("world", "dt-0.5") for k in (1, 2) for w in (1, 2)} | {
        "random-policy/seed-1", "random-policy/seed-2"
    }  # fmt: skip
    assert ran["dt-0.5/training-2/seed-1"]["policies"] == "out/policies/dt-0.5/seed-2"
    found = json.loads((here / "out" / "compare.json").read_text())["arms"]
    assert found["world"]["crossed"]["training_seeds"] == found["world"]["crossed"]["world_seeds"] == [1, 2]
    assert "crossed" not in found["random-policy"]
    assert "dt-0.5 runs with policies trained anew under its own values, from 2 training seeds" in said
    assert "world: All species persisted in " in said


@pytest.mark.slow
def test_a_run_that_was_stopped_goes_on_and_ends_with_the_same_bytes(here: Path) -> None:
    arm = Arm("world", load("predator-prey", FEW))
    whole = run_one(arm, 1, 8, here / "whole")
    run_to_folder(arm.config, seed=1, ticks=5, out=here / "half", report=False)
    assert not crossing.ran_already(here / "half", 8)
    assert run_one(arm, 1, 8, here / "half")["digest"] == whole["digest"]
    assert crossing.ran_already(here / "half", 8)
    for file in (here / "half" / "checkpoints").iterdir():
        file.write_bytes(b"no checkpoint")
    (here / "half" / "manifest.json").write_text("{}")
    assert run_one(arm, 1, 8, here / "half")["digest"] == whole["digest"]


def test_which_policies_an_arm_runs_with() -> None:
    arms = arms_of("predator-prey", [], ["random-policy", "random-policy:deer", "species.deer.count=50"])
    assert [crossing.learnt(arm) for arm in arms] == [["deer", "wolf"], [], ["wolf"], ["deer", "wolf"]]
    there = Path("p")
    assert [crossing.with_policies(arm, there).policies for arm in arms[2:]] == [{"deer": "random", "wolf": "p"}, "p"]
    folders = [crossing.policies_folder(Path("o"), arm, arms, retrain).name for arm in arms[2:] for retrain in (False, True)]
    assert folders == ["world", "world", "world", "species.deer.count-50"]
    told = [crossing.told(arm, arms, 2, False) for arm in arms]
    assert told[0] == "policies trained in the world as it is, from 2 training seeds"
    assert told[1] == "policies that are not trained: it has no training seed"
    assert told[2] == "policies of wolf trained in the world as it is, the same as the first arm, from 2 training seeds"


def test_a_folder_is_gone_on_with_by_the_same_comparison_alone(here: Path) -> None:
    arms = arms_of("predator-prey", [], ["random-policy"])
    plan = crossing.plan_of(arms, 10, True, False)
    with crossing.folder_of(here / "out", "x", plan) as claim:
        out = claim.path
        crossing.write_plan(out, plan)
        with pytest.raises(FolderInUse, match=f"out: is being written by process {os.getpid()} "):
            crossing.folder_of(out, "x", plan)
    with crossing.folder_of(out, "x", plan) as claim:
        assert claim.path == out
    more = crossing.plan_of(arms_of("predator-prey", [], ["learning"]), 10, True, False)
    with crossing.folder_of(out, "x", more) as claim:
        assert claim.path == out  # another control may be added
    crossing.write_plan(out, more)
    assert set(json.loads((out / "plan.json").read_text())["arms"]) == {"world", "random-policy", "learning"}
    said = invoke("--training-seeds", "2", "--ticks", "11", "--set", "species.deer.count=9", "--out", "out", code=2)
    assert "holds another comparison: ticks, the arm world" in said
    (out / "plan.json").write_text("[")
    assert "holds another comparison: plan.json differs" in invoke("--ticks", "11", "--out", "out", code=2)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--retrain"], "nothing is trained"),
        (["--training-seeds", "2", "--retrain"], "no control changes a value"),
        (["--training-seeds", "2", "--control", "training.average=0.5"], "changes the training alone"),
        (["--training-seeds", "0"], "a whole number from 1"),
    ],
)
def test_what_cannot_be_meant_is_refused(words: list[str], said: str) -> None:
    assert said in " ".join(invoke(*words, code=2).split())
