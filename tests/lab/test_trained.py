"""Policies of a training: trained once, found afterwards, and never those of another training."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from ecs_eco.config import load
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.lab import pretraining
from ecs_eco.lab.design import design_of
from ecs_eco.lab.folder import begin
from ecs_eco.lab.jobs import is_trained, train, train_or_find
from ecs_eco.lab.plan import read_plan

FEW = {
    "species.grass.count": 60,
    "species.deer.count": 12,
    "species.wolf.count": 2,
    "training.ticks": 3,
    "training.set": {},
}


@pytest.fixture
def config():
    return load("predator-prey", FEW)


def test_a_training_is_done_once_and_found_afterwards(config, tmp_path: Path) -> None:
    folder = tmp_path / "policies" / "seed-1"
    assert not is_trained(folder, config, 1)
    assert train_or_find(folder, config, 1) == folder
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert {path.name for path in before} == {"deer.safetensors", "wolf.safetensors", "training.json"}
    assert train_or_find(folder, config, 1) == folder
    assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == before
    assert [path.name for path in folder.parent.iterdir()] == ["seed-1"]


def test_another_training_is_refused(config, tmp_path: Path) -> None:
    folder = train_or_find(tmp_path / "seed-1", config, 1)
    with pytest.raises(ForeignFile, match="belongs to another training run: seed 1, not seed 2"):
        train_or_find(folder, config, 2)
    with pytest.raises(ForeignFile, match="belongs to another training run: ticks 3, not ticks 4"):
        train_or_find(folder, config, 1, ticks=4)
    assert is_trained(folder, config, 2, verify=False)
    (folder / "deer.safetensors").write_bytes(b"another policy")
    with pytest.raises(
        ForeignFile, match=r"deer\.safetensors: is not the policy written by this training run"
    ):
        is_trained(folder, config, 1)


def test_what_a_killed_training_left_is_replaced(config, tmp_path: Path) -> None:
    folder = tmp_path / "seed-1"
    folder.mkdir()
    (folder / "deer.safetensors").write_bytes(b"half")
    assert is_trained(train_or_find(folder, config, 1), config, 1)


def test_nothing_but_the_rest_of_a_training_is_removed(config, tmp_path: Path) -> None:
    folder = tmp_path / "seed-1"
    folder.mkdir()
    (folder / "thesis.txt").write_text("mine")
    with pytest.raises(
        RecordingError, match=r"seed-1: has no training\.json, but contains files that no training run writes"
    ):
        train_or_find(folder, config, 1)
    assert (folder / "thesis.txt").read_text() == "mine"


def test_links_beside_a_training_lead_nowhere(config, tmp_path: Path) -> None:
    (mine := tmp_path / "mine").mkdir()
    for name in (".lock", "training.json"):
        (mine / name).write_text("mine")
    plan = {"world": "predator-prey", "ticks": 2, "set": FEW, "training_seeds": 1}
    sweep = begin(tmp_path / "out", design_of(read_plan(plan)))
    (name,) = sweep.trainings
    folder = sweep.policies_folder(name)
    folder.parent.mkdir(parents=True)
    part = folder.with_name(f"{folder.name}.{os.getpid()}.part")
    part.symlink_to(mine)
    with pytest.raises(RecordingError, match=r"part: is a link, or contains files"):
        train_or_find(folder, config, 1)
    for link in (part, folder.with_name(f"{folder.name}.training")):
        part.unlink(missing_ok=True)
        link.symlink_to(mine)
        with pytest.raises(ForeignFile, match=f"{link.name}: is a link that leads out"):
            train(sweep.folder, name)
    assert {path.name: path.read_text() for path in mine.iterdir()} == {
        ".lock": "mine",
        "training.json": "mine",
    }


def test_a_finished_training_that_is_damaged_is_refused_and_kept(config, tmp_path: Path) -> None:
    folder = train_or_find(tmp_path / "seed-1", config, 1)
    whole = (folder / "training.json").read_text()
    changed = whole.replace('"seed": 1', '"seed": 3')
    for text, said in ((changed, "its seal does not match"), ("[", "is damaged")):
        (folder / "training.json").write_text(text)
        with pytest.raises(RecordingError, match=said):
            train_or_find(folder, config, 1)
        assert (folder / "training.json").read_text() == text
    (folder / "training.json").write_text(whole)
    (folder / "deer.safetensors").unlink()
    with pytest.raises(RecordingError, match=r"deer\.safetensors: is missing"):
        train_or_find(folder, config, 1)


def test_of_two_processes_that_train_the_same_the_first_keeps_its_place(
    config, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, pretrain = tmp_path / "seed-1", pretraining.pretrain

    def second(*arguments: Any, out: Path, **options: Any) -> None:
        pretrain(*arguments, out=folder, **options)
        pretrain(*arguments, out=out, **options)

    monkeypatch.setattr(pretraining, "pretrain", second)
    train_or_find(folder, config, 1)
    assert [path.name for path in tmp_path.iterdir()] == ["seed-1"]


def test_a_training_that_fails_leaves_nothing(
    config, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, out: Path, **__: Any) -> None:
        out.mkdir()
        raise OSError("no space")

    monkeypatch.setattr(pretraining, "pretrain", fail)
    with pytest.raises(OSError, match="no space"):
        train_or_find(tmp_path / "seed-1", config, 1)
    assert list(tmp_path.iterdir()) == []
