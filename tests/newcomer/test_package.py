"""A newcomer's package, by nothing but what the pages say: how-to/running.md (a starter world) and
how-to/extending.md (a component, a system, a test for it). 5 commands; 33 lines in an editor. Before there
was `ecs-eco new` the package itself, 144 lines in nine files, was to be written too, and no page said how.
"""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import ecs_eco
from ecs_eco.templates import new_package

HERE, ROOT = Path(__file__).parent, Path(ecs_eco.__path__[0]).parent
ECS_ECO = [sys.executable, "-c", "from ecs_eco.cli import main; main()"]
COMMANDS = (HERE / "package.sh").read_text(encoding="utf-8").splitlines()


def lines(*files: Path) -> int:
    """Lines of text in files: without comments and empty ones."""
    return sum(
        bool(line.strip()) and not line.lstrip().startswith("#")
        for file in files
        for line in file.read_text(encoding="utf-8").splitlines()
    )


@pytest.mark.slow
def test_the_tests_of_a_new_package_pass_and_those_of_what_is_added_to_it(tmp_path):
    said = {}
    for line in COMMANDS:
        program, *arguments = shlex.split(line)
        if program == "pip":  # the index is not asked here: the path stands for what is installed
            shutil.copy(HERE / "lice.py", tmp_path / "wool-lab" / "src" / "wool_lab" / "lice.py")
            shutil.copy(HERE / "checks_of_lice.py", tmp_path / "wool-lab" / "tests" / "test_lice.py")
            continue
        where = {
            "PYTHONPATH": os.pathsep.join([str(ROOT), str(tmp_path / "wool-lab" / "src")]),
            "XDG_CONFIG_HOME": str(tmp_path / "mine"),
        }
        words = [*(ECS_ECO if program == "ecs-eco" else [sys.executable]), *arguments]
        done = subprocess.run(
            words,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=400,
            check=False,
            env=os.environ | where,
        )
        assert done.returncode == 0, line + done.stdout + done.stderr
        said[line] = done.stdout
    assert "7 passed" in said["python -m pytest wool-lab"]
    assert "no problems" in said[COMMANDS[3]]
    assert (tmp_path / "my-run" / "report.html").is_file()


def test_lines_and_commands_are_counted_as_they_are(tmp_path):
    assert f"{len(COMMANDS)} commands; {lines(HERE / 'lice.py', HERE / 'checks_of_lice.py')} lines" in __doc__
    files = new_package(tmp_path / "wool-lab")
    assert f"{lines(*files)} lines in nine files" in __doc__
    assert len([file for file in files if file.stat().st_size]) == 9
