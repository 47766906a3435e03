"""The mode of a sweep: that of its folder; new on several machines the portable one."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

CODE = """
import sys
from pathlib import Path
from ecs_eco.cli.sweeping import settle
settle(sys.argv[1] or None, Path(sys.argv[2]))
from ecs_eco.compiled import portable
print(portable.mode(), "numpy" in sys.modules)
"""
BARE = {key: value for key, value in os.environ.items() if key != "ECS_ECO_PORTABLE"}


def mode(on: str, folder: Path, **variables: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", CODE, on, str(folder)],
        env=BARE | variables,
        check=True,
        capture_output=True,
        text=True,
        timeout=120,
    )
    return done.stdout.strip()


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="the mode is for x86-64")
@pytest.mark.parametrize("engine", ["ray", "slurm"])
def test_a_new_sweep_on_several_machines_is_portable_unless_it_is_told_not_to_be(
    tmp_path: Path, engine: str
) -> None:
    assert mode(engine, tmp_path) == "portable False"
    assert mode(engine, tmp_path, ECS_ECO_PORTABLE="0") == "native False"
    assert mode("local", tmp_path) == "native False"


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="the mode is for x86-64")
def test_a_sweep_that_was_begun_goes_on_in_its_mode_wherever(tmp_path: Path) -> None:
    (tmp_path / "sweep.json").write_text('{"mode": "portable"}')
    assert mode("local", tmp_path) == mode("", tmp_path) == "portable False"
    (tmp_path / "sweep.json").write_text('{"mode": "native"}')
    assert mode("slurm", tmp_path) == mode("", tmp_path) == "native False"


def test_a_damaged_sweep_is_left_to_its_reader(tmp_path: Path) -> None:
    (tmp_path / "sweep.json").write_text("{")
    assert mode("local", tmp_path) == "native False"
