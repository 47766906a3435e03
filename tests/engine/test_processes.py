"""Processes that are started import nothing from the folder that they run in, whatever lies there."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ecs_eco.engine.processes import python


@pytest.fixture
def hidden(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The mark that modules leave which would hide all of Python's own, in the folder where this runs."""
    mark = tmp_path / "mark"
    for name in (*sys.stdlib_module_names, "numpy", "numba", "torch", "pydantic", "typer"):
        (tmp_path / f"{name}.py").write_text(f"open({str(mark)!r}, 'a').write('{name} ')\n")
    monkeypatch.chdir(tmp_path)
    return mark


def run(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_process_and_those_that_it_starts_take_no_modules_of_the_folder(hidden: Path) -> None:
    again = "import json, subprocess, sys; print(json.dumps(sys.argv[1:]), flush=True); subprocess.run"
    inner = "import shlex; import ecs_eco; print(ecs_eco.__name__)"
    assert run(*python(f"{again}([sys.executable, '-c', {inner!r}], check=True)", "a", "b")).split() == [
        '["a",',
        '"b"]',
        "ecs_eco",
    ]
    assert not hidden.exists()


def test_the_command_as_a_module_takes_none_either(hidden: Path) -> None:
    assert run(sys.executable, "-m", "ecs_eco", "--version").startswith("ecs-eco")
    assert run(sys.executable, "-mecs_eco", "list", "--help")
    assert not hidden.exists()


def test_a_checkout_that_is_not_installed_is_still_found_by_its_processes(tmp_path: Path) -> None:
    (tmp_path / "ecs_eco").symlink_to(Path(__file__).parents[2] / "ecs_eco")
    script = "sys.argv[:] = ['-m']; sys.orig_argv[:] = ['python', '-m', 'ecs_eco']; import ecs_eco"
    output = run(
        sys.executable,
        "-c",
        f"import os; os.chdir({str(tmp_path)!r}); import sys; "
        f"sys.path[0] = {str(tmp_path)!r}; {script}; print(sys.path[0]); print(sys.path[-1])",
    )
    first, last = output.split()
    assert first != str(tmp_path)
    assert last == str(tmp_path) or os.path.samefile(last, tmp_path)
