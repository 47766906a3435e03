"""`ecs-eco why`: sentences, JSON, files; what is no run is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.config import load
from ecs_eco.record import run_to_folder

FEW = {"species.grass.count": 100, "species.deer.count": 20, "species.wolf.count": 2}


def invoke(*arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, ["why", *arguments])
    assert done.exit_code == code, done.output + repr(done.exception)
    return done.output


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("cli") / "run"
    run_to_folder(load("predator-prey", FEW), 1, 12, out, "random", report=False)
    return out


def test_it_says_what_happened_and_writes_the_page(run: Path) -> None:
    output = invoke(str(run))
    assert "No species died out in 12 ticks." in output
    assert "What limited each species" in output
    assert f"written: {run / 'why.html'}" in output
    assert all((run / name).is_file() for name in ("why.html", "why.json", "figures/why.svg"))


def test_json_is_for_machines(run: Path, tmp_path: Path) -> None:
    output = json.loads(invoke(str(run), "--json", "--out", str(tmp_path / "new")))
    assert output["verdict"] == "healthy"
    assert {"species", "confidence", "runner_up", "parameters", "phases", "energy"} <= set(output)
    assert (tmp_path / "new" / "why.html").is_file()


@pytest.mark.parametrize("folder", ["nowhere", "."])
def test_what_is_no_run_is_refused(folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    output = invoke(folder, code=2)
    assert "Traceback" not in output
    assert "ecs-eco run" in output


def test_a_file_is_no_folder_to_write_to(run: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert "is not a folder" in invoke(str(run), "--out", str(tmp_path / "file"), code=2)
