"""Allowing code: on the command line, and for checkpoints, manifests and recordings that name it."""

import copy
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from ecs_eco import World
from ecs_eco.cli import app
from ecs_eco.config import load
from ecs_eco.engine.errors import CheckpointError, ConfigError
from ecs_eco.inputs import trust
from ecs_eco.inputs.code import CodeError
from ecs_eco.record import resume, run_to_folder
from ecs_eco.runs.repeat import repeat
from studies.common.malicious.templates import world_of
from tests.security.worlds import written

# --- the command line ---------------------------------------------------------------------------------------


def cli(*arguments: Any) -> Any:
    return CliRunner().invoke(app, [str(a) for a in arguments])


def test_check_looks_at_no_code_and_says_so_until_it_is_trusted(mark: Path) -> None:
    path = written(mark.parent, world_of("systems.*", code=["evil.py"]))
    done = cli("check", path)
    assert done.exit_code == 0
    assert "NOT loaded" in done.output
    assert not mark.exists()
    done = cli("check", path, "--trust")
    assert done.exit_code == 0, done.output
    assert "Allowed to run" in done.output
    assert "evil.py" in done.output
    assert mark.exists()


def test_run_refuses_lists_and_remembers_until_the_file_changes(mark: Path) -> None:
    path, out = written(mark.parent, world_of("systems.*", code=["evil.py"])), mark.parent / "out"
    refused = cli("run", path, "--ticks", "2", "--out", out, "-q", "--no-report")
    assert refused.exit_code == 2
    assert [
        word for word in (str(mark.parent / "evil.py"), "SHA-256", "--trust") if word not in refused.output
    ] == []
    assert not mark.exists()
    assert not out.exists()
    assert cli("run", path, "--ticks", "2", "--out", out, "-q", "--no-report", "--trust").exit_code == 0
    assert (out / "code" / "evil.py").read_bytes() == (mark.parent / "evil.py").read_bytes()
    trust._here.clear()  # a new process
    assert (
        cli("run", path, "--ticks", "2", "--out", mark.parent / "second", "-q", "--no-report").exit_code == 0
    )
    with open(mark.parent / "evil.py", "a", encoding="utf-8") as file:
        file.write("\n# another\n")
    assert (
        cli("run", path, "--ticks", "2", "--out", mark.parent / "third", "-q", "--no-report").exit_code == 2
    )
    assert trust.file().stat().st_mode & 0o777 == 0o600
    assert trust.file().parent.stat().st_mode & 0o777 == 0o700


def test_what_others_may_write_allows_nothing(mark: Path) -> None:
    trust.remember({"0" * 64: "/somewhere"})
    trust._here.clear()
    assert trust.allowed("0" * 64)
    trust.file().chmod(0o666)
    assert not trust.allowed("0" * 64)


def test_check_imports_nothing_but_this_package(mark: Path) -> None:
    path = written(mark.parent, world_of("systems.*", code=["evil.py"]))
    script = (
        "import sys; from ecs_eco.cli import app; from ecs_eco.config import load\n"
        f"load({str(path)!r})\nprint(sorted(m for m in sys.modules if 'evil' in m or 'ecs_eco_code' "
        "in m))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(mark.parent)},
    )
    assert done.stdout.strip() == "[]"
    assert not mark.exists()


# --- checkpoints, manifests, recordings ---------------------------------------------------------------------


@pytest.fixture
def run(mark: Path) -> Path:
    """A recorded run of a world with code, moved to another folder; nobody here allowed it."""
    path = written(mark.parent, world_of("species.*.happiness.function", code=["evil.py"]))
    run_to_folder(path, ticks=6, out=mark.parent / "run", report=False, checkpoint_every=2, trust=True)
    moved = mark.parent / "elsewhere"
    (mark.parent / "run").rename(moved)
    (mark.parent / "evil.py").unlink()
    path.unlink()
    trust._here.clear()
    from ecs_eco.inputs import code

    code._loaded.clear()
    mark.unlink()
    return moved


def test_a_run_is_resumed_and_repeated_once_its_code_is_allowed(run: Path, mark: Path) -> None:
    checkpoint = sorted((run / "checkpoints").iterdir())[0]
    for attempt in (lambda: resume(run, 8), lambda: repeat(run), lambda: World.restore(checkpoint)):
        with pytest.raises(CodeError, match="is not allowed to run"):
            attempt()
    assert not mark.exists()
    assert repeat(run, trust=True)["same"]
    assert resume(run, 8, report=False, trust=True)["done"] == 8
    assert mark.exists()


def test_code_that_was_changed_since_is_refused_by_name(run: Path, mark: Path) -> None:
    with open(run / "code" / "evil.py", "a", encoding="utf-8") as file:
        file.write("\n# another\n")
    checkpoint = sorted((run / "checkpoints").iterdir())[0]
    with pytest.raises(CheckpointError, match=r"evil\.py has changed"):
        World.restore(checkpoint)
    with pytest.raises(ValueError, match=r"evil\.py has changed"):
        repeat(run)
    assert not mark.exists()
    assert World.restore(checkpoint, trust=True).run(1)


def test_a_manifest_that_names_other_code_is_refused(run: Path, mark: Path) -> None:
    from ecs_eco.record import seal

    manifest = {k: v for k, v in seal.read_manifest(run).items() if k != seal.WORD}
    manifest["config"]["species"]["snail"]["genome"]["mutate"] = {
        "operator": "pydoc:pipepager",
        "cmd": f"touch {mark}-too",
    }
    seal.write_manifest(run, manifest)
    for attempt in (lambda: repeat(run), lambda: repeat(run, trust=True)):
        with pytest.raises(ConfigError, match="does not list"):
            attempt()
    assert not mark.with_name("mark-too").exists()


def test_a_sealed_checkpoint_that_names_other_code_is_refused_with_its_name(run: Path, mark: Path) -> None:
    from ecs_eco.record import checkpoint as file

    path = sorted((run / "checkpoints").iterdir())[-1]
    meta, arrays = file.read(path)
    for change in (
        {"plain": [[1, "os:system"]]},
        {"config": meta["config"] | {"systems": ["os:system"]}},
        {"options": {}},
        {"folder": 3},
    ):
        file.write(path, {**copy.deepcopy(meta), **change}, arrays)
        with pytest.raises((CodeError, CheckpointError), match=path.name):
            World.restore(path)
    assert not mark.exists()


def test_workers_get_the_permission_with_the_world(mark: Path) -> None:
    config = load(
        written(mark.parent, world_of("species.*.happiness.function", code=["evil.py"])), trust=True
    )
    carried = copy.copy(config._code)  # by the way that a pool of processes takes
    read_again = load(written(mark.parent, world_of("species.*.happiness.function", code=["evil.py"])))._code
    trust._here.clear()
    assert carried.allowed
    assert not read_again.allowed
    carried.pass_on()
    assert read_again.allowed
