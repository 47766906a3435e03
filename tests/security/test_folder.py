"""What lies in the folder that a command runs in: settings of matplotlib and numba that came
with somebody's world."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SETTINGS = "text.usetex: True\nbackend: module://evil\nsavefig.format: pgf\n"
DRAWING = """
import sys
from pathlib import Path
import matplotlib
assert matplotlib.rcParams["text.usetex"], "the settings of this folder are not read, and nothing is tried"
from ecs_eco.analysis.nervous_figure import draw_nervous_systems, save as save_diagram
from ecs_eco.analysis.style import panels, save, styled
from ecs_eco.config import load

@styled
def draw():
    figure, axes = panels(1, 1, 3, 2)
    axes[0][0].plot([0, 1e4], [0, 1])
    axes[0][0].set_title("numbers")
    return figure

save(draw(), "plain.png")
save_diagram(draw_nervous_systems(load("predator-prey"), ["deer"]), "deer.svg")
assert matplotlib.rcParams["text.usetex"], "the reader's own settings are as they were"
assert "evil" not in sys.modules
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with settings, and programs for typesetting that leave a mark."""
    (tmp_path / "matplotlibrc").write_text(SETTINGS, encoding="utf-8")
    (tmp_path / "evil.py").write_text(f"open({str(tmp_path / 'mark')!r}, 'w')\n", encoding="utf-8")
    (tmp_path / "tools").mkdir()
    for name in ("latex", "dvipng", "kpsewhich", "gs"):
        tool = tmp_path / "tools" / name
        tool.write_text(f"#!/bin/sh\ntouch {tmp_path}/mark\nexit 1\n", encoding="utf-8")
        tool.chmod(0o755)
    return tmp_path


def python(folder: Path, script: str, **more: str) -> str:
    environment = {**os.environ, "PATH": f"{folder / 'tools'}:{os.environ['PATH']}", **more}
    done = subprocess.run(
        [sys.executable, "-P", "-c", script], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_figures_take_no_settings_from_the_folder_that_a_command_runs_in(folder: Path) -> None:
    python(folder, DRAWING)
    assert (folder / "plain.png").read_bytes().startswith(b"\x89PNG")
    assert not (folder / "mark").exists()


def test_settings_of_numba_in_that_folder_are_not_in_force(folder: Path) -> None:
    pytest.importorskip("yaml")
    (folder / ".numba_config.yaml").write_text(
        f"disable_jit: 1\ncache_dir: {folder}/kernels\n", encoding="utf-8"
    )
    asked = "print(numba.config.DISABLE_JIT, numba.config.CACHE_DIR)"
    script = f"import numba\nprint(numba.config.DISABLE_JIT)\nimport ecs_eco.compiled.jit\n{asked}"
    output = python(folder, script, NUMBA_CACHE_DIR="").split()
    assert output == ["1", "0"], "first by numba alone, then as this package has it"
    assert not (folder / "kernels").exists()
