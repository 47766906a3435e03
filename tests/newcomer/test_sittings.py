"""What a newcomer does in one sitting with the pages of docs alone: each folder here is one, as typed.

`commands.sh` is what goes into the terminal, the other files are what goes into the editor.
README.md counts both.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ecs_eco.analysis.runs import load_series

HERE = Path(__file__).parent
ECS_ECO = [sys.executable, "-c", "from ecs_eco.cli import main; main()"]


def commands(name: str) -> list[list[str]]:
    text = (HERE / name / "commands.sh").read_text(encoding="utf-8")
    return [shlex.split(line) for line in text.splitlines()]


def done(name: str, tmp_path: Path) -> tuple[Path, str]:
    """Type all commands of a sitting in a copy of its folder; return that and what they said."""
    folder = tmp_path / name
    shutil.copytree(HERE / name, folder)
    said = ""
    for program, *arguments in commands(name):
        words = [*(ECS_ECO if program == "ecs-eco" else [sys.executable]), *arguments]
        out = subprocess.run(
            words,
            cwd=folder,
            env=os.environ | {"XDG_CONFIG_HOME": str(tmp_path)},
            capture_output=True,
            text=True,
            check=False,
        )
        assert out.returncode == 0, f"{program} {arguments}: {out.stdout}{out.stderr}"
        said += out.stdout
    return folder, said


@pytest.mark.slow
def test_a_coral_reef_lives_and_its_cover_is_measured_and_compared(tmp_path: Path) -> None:
    folder, said = done("reef", tmp_path)
    series = load_series(folder / "run")
    assert series.persisted
    assert series.reporters == ("algal cover", "fish energy", "algae per fish")
    assert "measures algal cover, fish energy, algae per fish" in said
    assert "algal cover, mean over runs: world" in said
    assert "algal cover" in (folder / "run" / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_disease_has_its_prevalence_in_series_report_and_comparison(tmp_path: Path) -> None:
    folder, said = done("disease", tmp_path)
    most = load_series(folder / "run").of("people", "prevalence").max()
    assert 0.1 < most < 1
    assert f"at most {most:.0%} ill" in said
    for page in (folder / "run" / "report.html", folder / "compared" / "compare.html"):
        assert "<h2>Measured</h2>" in (text := page.read_text(encoding="utf-8"))
        assert "prevalence" in text
    world, mild = map(float, re.findall(r"prevalence, mean over runs: world (\S+), \S+ (\S+)", said)[0])
    assert mild < world


@pytest.mark.slow
def test_a_reflex_experiment_shows_which_gene_spreads(tmp_path: Path) -> None:
    folder, said = done("reflex", tmp_path)
    s = {gene: float(x) for gene, x in re.findall(r"(\w+): .*s = (\S+) per generation", said)}
    assert s["freeze"] < -0.1  # who freezes before a fox is eaten
    drawn = {p.name for p in (folder / "run" / "figures").iterdir()}
    assert {"alleles-1.svg", "genes-1.svg", "actions-1.svg"} <= drawn
    assert {"alleles-0.svg", "genes-0.svg"} <= {p.name for p in (folder / "compared" / "figures").iterdir()}
    genes = json.loads((folder / "compared" / "compare.json").read_text())["genes"]["vole"]
    freeze = genes["freeze = 1"]
    assert freeze["arms"]["world"]["s"][0] < freeze["arms"]["neutral-drift"]["s"][0]
    assert "<h2>Genes</h2>" in (folder / "compared" / "compare.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [p.parent.name for p in sorted(HERE.glob("*/commands.sh"))])
def test_the_lines_and_commands_of_a_sitting_are_those_in_the_table(name: str) -> None:
    files = [p for p in (HERE / name).iterdir() if p.is_file() and p.name != "commands.sh"]
    lines = [line for p in files for line in p.read_text(encoding="utf-8").splitlines()]
    typed = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    row = f"| {name} | {len(typed)} | {len(commands(name))} |"
    assert row in (HERE / "README.md").read_text(encoding="utf-8")
