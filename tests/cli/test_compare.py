"""compare: its arms, with training seeds, when a run fails or is stopped, and gone on with."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.cli.compare import claim_folder
from ecs_eco.engine.errors import FolderInUse
from ecs_eco.lab.comparison import Comparison
from ecs_eco.lab.treatments import Arm, arms_of

FEW = [
    "species.grass.count=60",
    "species.deer.count=12",
    "species.wolf.count=2",
    "training.ticks=3",
    "training.set={}",
]
SET = [word for change in FEW for word in ("--set", change)]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def invoke(*arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, ["compare", "predator-prey", *arguments])
    assert done.exit_code == code, done.output + repr(done.exception)
    return done.output


def written(folder: Path) -> dict[Path, int]:
    """When each training and each run in a folder ended."""
    return {
        p: p.stat().st_mtime_ns
        for p in folder.rglob("*.json")
        if p.name in ("training.json", "manifest.json")
    }


@pytest.mark.slow
def test_arms_run_with_the_same_seeds_and_are_compared(here: Path) -> None:
    output = invoke(*SET, "--seeds", "2", "--ticks", "4", "--treatment", "dt=0.5", "--out", "out")
    manifests = {p.parent: json.loads(p.read_text()) for p in (here / "out").glob("*/*/manifest.json")}
    assert {(p.parent.name, m["seed"], m["dt"], m["done"]) for p, m in manifests.items()} == {
        ("world", 1, 1.0, 4),
        ("world", 2, 1.0, 4),
        ("dt-0.5", 1, 0.5, 4),
        ("dt-0.5", 2, 0.5, 4),
    }
    content = json.loads((here / "out" / "compare.json").read_text())
    assert {arm: row["seeds"] for arm, row in content["arms"].items()} == {"world": [1, 2], "dt-0.5": [1, 2]}
    assert content["reference"] == "world"
    assert "dt-0.5" in output
    assert "wolf" in output


@pytest.mark.slow
def test_each_policy_is_trained_once_and_lives_in_every_world_and_nothing_is_done_twice(here: Path) -> None:
    treatments = ["--treatment", "random-policy", "--treatment", "dt=0.5"]
    words = [*SET, "--workers", "1", "--training-seeds", "2", "--ticks", "4", *treatments, "--retrain"]
    invoke(*words, "--seeds", "1", "--out", "out")
    before = written(here / "out")
    output = invoke(*words, "--seeds", "2", "--out", "out")
    after = written(here / "out")
    assert before.items() <= after.items()
    assert "5 of 10 runs are already done." in output
    policies = {
        (p.parent.parent.name, json.loads(p.read_text())["seed"])
        for p in (here / "out").rglob("training.json")
    }
    assert policies == {("world", 1), ("world", 2), ("dt-0.5", 1), ("dt-0.5", 2)}
    ran = {
        str(p.parent.relative_to(here / "out")): json.loads(p.read_text())
        for p in after
        if p.name == "manifest.json"
    }
    trained = {f"{arm}/training-{k}/seed-{w}" for arm in ("world", "dt-0.5") for k in (1, 2) for w in (1, 2)}
    assert set(ran) == trained | {"random-policy/seed-1", "random-policy/seed-2"}
    assert ran["dt-0.5/training-2/seed-1"]["policies"] == "out/policies/dt-0.5/seed-2"
    content = json.loads((here / "out" / "compare.json").read_text())["arms"]
    assert (
        content["world"]["crossed"]["training_seeds"] == content["world"]["crossed"]["world_seeds"] == [1, 2]
    )
    assert "crossed" not in content["random-policy"]
    assert "dt-0.5 runs with policies trained again with its own values, from 2 training seeds" in output
    assert "world: All species persisted in " in output


def test_a_folder_is_gone_on_with_by_the_same_comparison_alone(here: Path) -> None:
    arms = arms_of("predator-prey", [], ["random-policy"])
    comparison = Comparison(here / "out", arms, 10, [1], [1])
    with claim_folder(here / "out", comparison) as claim:
        out = claim.path
        comparison.begin()
        with pytest.raises(FolderInUse, match=f"out: is in use by process {os.getpid()} "):
            claim_folder(out, comparison)
    with claim_folder(out, comparison) as claim:
        assert claim.path == out
    more = Comparison(out, arms_of("predator-prey", [], ["learning"]), 10, [1], [1])
    with claim_folder(out, more) as claim:
        assert claim.path == out  # another control may be added
    more.begin()
    assert set(json.loads((out / "plan.json").read_text())["arms"]) == {"world", "random-policy", "learning"}
    output = invoke(
        "--training-seeds", "2", "--ticks", "11", "--set", "species.deer.count=9", "--out", "out", code=2
    )
    assert "contains another comparison: ticks, the arm world" in output
    (out / "plan.json").write_text("[")
    assert "plan.json: is damaged" in invoke("--ticks", "11", "--out", "out", code=2)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--retrain"], "nothing is trained"),
        (["--training-seeds", "2", "--retrain"], "no treatment changes a value"),
        (["--training-seeds", "2", "--treatment", "training.average=0.5"], "changes only training"),
        (["--training-seeds", "2", "--control", "training.average=0.5"], "changes only training"),
        (["--training-seeds", "0"], "an integer from 1"),
        (["--training-seeds", "2", "--policies", "random"], "only one of these options"),
        (["--policies", "nowhere"], "no such folder"),
    ],
)
def test_options_that_contradict_each_other_are_refused(words: list[str], expected: str) -> None:
    assert expected in " ".join(invoke(*words, code=2).split())


def test_policies_of_a_folder_are_those_of_all_arms_but_the_random_one(here: Path) -> None:
    from ecs_eco import World
    from ecs_eco.learning.weights import save

    (here / "mine").mkdir()
    world = World.from_config("predator-prey", policies="untrained", record=False)
    for name in ("deer", "wolf"):
        save(here / "mine" / f"{name}.safetensors", world.tables[name].species.nerves.brain.state())
    arms = [
        arm.with_policies(Path("mine")) for arm in arms_of("predator-prey", FEW, ["random-policy", "dt=0.5"])
    ]
    assert [arm.policies for arm in arms] == ["mine", "random", "mine"]
    told = Comparison(here / "out", arms, 4, [1]).policies_in_words()
    assert told["world"] == told["dt-0.5"] == "the policies in mine"
    assert told["random-policy"] == "untrained policies"
    output = invoke(
        *SET, "--seeds", "1", "--ticks", "2", "--workers", "1", "--policies", "mine", "--out", "out"
    )
    assert "world runs with the policies in mine" in output
    manifests = {p.parts[-3]: json.loads(p.read_text()) for p in (here / "out").glob("*/*/manifest.json")}
    assert set(manifests["world"]["weights"]) == {"deer", "wolf"}
    assert manifests["random-policy"]["policies"] == "random"


def fail(arm: Arm, seed: int, ticks: int, folder: Path) -> None:
    """Stand for a run that fails with seed 1."""
    if seed == 1:
        raise FileExistsError("old")


def be_killed(arm: Arm, seed: int, ticks: int, folder: Path) -> None:
    """Stand for a run in a worker that is killed."""
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_run_that_fails_is_named_and_the_others_go_on(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ecs_eco.lab.comparison.run_arm", fail)
    output = invoke(*SET, "--workers", "1", "--seeds", "2", "--out", "out", code=1)
    assert "world, seed 1: FileExistsError: old" in output
    assert "random-policy, seed 1: FileExistsError: old" in output
    assert "2 of 4 runs failed; recordings of all others are in out." in output


@pytest.mark.slow
def test_a_killed_worker_is_one_message_and_no_traceback(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ecs_eco.lab.comparison.run_arm", be_killed)
    monkeypatch.setattr("ecs_eco.lab.work.RETRIES", 1)
    output = invoke(*SET, "--seeds", "2", "--out", "out", code=1)
    assert output.count("A worker process was killed") == 1
    assert "4 of 4 runs failed" in output
    assert "Traceback" not in output
