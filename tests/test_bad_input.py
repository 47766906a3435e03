"""Wrong worlds and arguments are refused before anything is made: place, value, what is allowed,
the right name."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import ecs_eco
from ecs_eco.cli import app
from tests.wrong_worlds import CASES, FOLLOWED, WORLD


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "goat.safetensors").write_bytes(b"")
    return tmp_path


def refused(folder: Path, *arguments: str) -> str:
    """What the command says on stderr when it refuses; and that it leaves nothing."""
    before = sorted(folder.rglob("*"))
    done = CliRunner().invoke(app, [*arguments])
    assert done.exit_code == 2, done.output
    assert sorted(folder.rglob("*")) == before
    assert "Traceback" not in done.output
    return done.stderr


def run(folder: Path, text: str, *more: str) -> str:
    (folder / "meadow.toml").write_text(text)
    return refused(folder, "run", str(folder / "meadow.toml"), "--out", str(folder / "out"), *more)


def test_the_world_itself_is_not_refused(folder: Path) -> None:
    (folder / "meadow.toml").write_text(WORLD)
    assert CliRunner().invoke(app, ["check", str(folder / "meadow.toml")]).exit_code == 0


@pytest.mark.parametrize("case", CASES)
def test_a_wrong_file_is_refused(case: str, folder: Path) -> None:
    old, new, key, value, allowed, near = CASES[case]
    assert WORLD.count(old) == 1, f"{old} is not once in the world"
    output = run(folder, WORLD.replace(old, new))
    block = next((b for b in output.replace("\nmeadow", "\0meadow").split("\0") if f": {key}" in b), "")
    assert block.startswith("meadow.toml, line "), output
    head, _, tail = block.partition("\n")
    assert value in head.partition(key)[2]
    assert allowed in tail
    assert (f'did you mean "{near}"?' in tail) if near else ("did you mean" not in tail)


@pytest.mark.parametrize("case", ["food", "rate", "kind", "formula name", "key", "policy file"])
def test_the_line_is_that_of_the_key(case: str, folder: Path) -> None:
    old, new, key, *_ = CASES[case]
    output = run(folder, WORLD.replace(old, new))
    line = WORLD[: WORLD.index(old)].count("\n") + 1
    assert f"meadow.toml, line {line}: {key}" in output


@pytest.mark.parametrize("case", CASES)
def test_a_wrong_world_has_one_problem(case: str, folder: Path) -> None:
    """One mistake gives one message, but for mistakes that break what others name."""
    old, new, *_ = CASES[case]
    output = run(folder, WORLD.replace(old, new))
    assert output.startswith("meadow.toml: 1 problem\n") or case in FOLLOWED, output


def test_all_problems_are_told_at_once(folder: Path) -> None:
    text = WORLD
    for case in ("food", "rate", "key", "range", "formula name", "cell", "fewer than no goats"):
        text = text.replace(*CASES[case][:2])
    output = run(folder, text)
    assert "meadow.toml: " in output
    # those of the goat's own section wait until its count is right
    for case in ("rate", "key", "cell", "fewer than no goats"):
        assert CASES[case][2] in output


def test_many_problems_stay_on_one_screen(folder: Path) -> None:
    eaten = ", ".join(f'{{ eats = "g{i}", gain = 0.1 }}' for i in range(40))
    output = run(folder, WORLD.replace('{ eats = "grass", gain = 0.1, chance = 0.5 }', eaten))
    assert "40 problems" in output
    assert "… and 25 more" in output
    assert output.count("species.goat.diet") == 15


@pytest.mark.parametrize(
    ("text", "line", "column", "what"),
    [("a = = 1", 1, 5, "Invalid value"), ("\nx = 1\nx = 2", 3, 6, "overwrite"), ("[a", 1, 3, "Expected")],
)
def test_what_is_not_toml_is_refused_with_line_and_column(
    text: str, line: int, column: int, what: str, folder: Path
) -> None:
    output = run(folder, text)
    assert f"meadow.toml, line {line}, column {column}" in output
    assert what in output


def test_a_file_that_is_no_text_is_refused(folder: Path) -> None:
    (folder / "meadow.toml").write_bytes(b"\xff\xfe\x00")
    assert "UTF-8" in refused(folder, "run", str(folder / "meadow.toml"), "--out", str(folder / "out"))


@pytest.mark.parametrize(
    ("change", "key", "value", "allowed", "near"),
    [
        ("species.deer.reproduction.rate=-1", "species.deer.reproduction.rate", "-1", "at least 0", ""),
        ("species.deer.birth_rate=-1", "species.deer.birth_rate", "-1", "at least 0", ""),
        ("species.dear.count=5", "species.dear.count", "5", "grass, deer, wolf", "deer"),
        ("specis.deer.count=5", "specis", "count", "species", "species"),
        ("species.wolf.diet.1.chance=0.5", "species.wolf.diet.1.chance", "0.5", "expected: 0", ""),
        ("species.wolf.count.x=0.5", "species.wolf.count.x", "0.5", "table or list", ""),
        ("species.wolf.policy.learn=True", "species.wolf.policy.learn", '"True"', "true or false", "true"),
        ("species.wolf.count=[1", "species.wolf.count", "[1", "such as", ""),
        ("species.wolf.count=1\nx=2", "species.wolf.count", "1", "such as", ""),
        ("species.wolf.count", "", "species.wolf.count", "such as", ""),
        ("=3", "", "=3", "such as", ""),
        ("fields.grass_smel.cell=3", "fields.grass_smel.cell", "3", "grass_smell", "grass_smell"),
    ],
)
def test_a_wrong_value_from_outside_is_refused(
    change: str, key: str, value: str, allowed: str, near: str, tmp_path: Path
) -> None:
    output = refused(tmp_path, "run", "predator-prey", "--set", change, "--out", str(tmp_path / "out"))
    head = next(line for line in output.splitlines() if line.startswith("--set: "))
    assert key in head
    assert value in head
    assert allowed in output
    assert (f'did you mean "{near}"?' in output) if near else ("did you mean" not in output)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["run", "predator-pray"], ["WORLD", '"predator-pray"', 'did you mean "predator-prey"?']),
        (["run", "nowhere/world.toml"], ["WORLD", '"nowhere/world.toml"', "no such file"]),
        (["check", "predator-pray"], ["WORLD", "predator-prey"]),
        (["train", "predator-pray"], ["WORLD", "predator-prey"]),
        (["compare", "predator-pray"], ["WORLD", "predator-prey"]),
        (
            ["run", "predator-prey", "--policies", "trainde"],
            ["--policies", '"trainde"', 'did you mean "trained"?'],
        ),
        (["run", "predator-prey", "--policies", "."], ["--policies", "deer.safetensors is missing"]),
        (["run", "predator-prey", "--ticks", "0"], ["--ticks", "0"]),
        (["run", "predator-prey", "--ticks", "many"], ["--ticks", "many"]),
        (["run", "predator-prey", "--seed", "-1"], ["--seed", "-1"]),
        (["run", "predator-prey", "--threads", "0"], ["--threads", "0"]),
        (["run", "predator-prey", "--tick", "3"], ["--tick"]),
        (
            ["compare", "predator-prey", "--treatment", "random-polcy"],
            ["--treatment", 'did you mean "random-policy"?'],
        ),
        (
            ["compare", "predator-prey", "--treatment", "species.dear.count=3"],
            ["species.dear.count", 'mean "deer"?'],
        ),
        (
            ["compare", "predator-prey", "--treatment", "dt=2", "--treatment", "dt=2"],
            ["--treatment", "named twice"],
        ),
        (["report", "nowhere"], ["DIR", '"nowhere"', "ecs-eco run"]),
        (["report", "."], ["DIR", "manifest.json"]),
    ],
)
def test_wrong_arguments_are_refused(
    arguments: list[str], parts: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    output = refused(tmp_path, *arguments)
    for part in parts:
        assert part in output


@pytest.mark.parametrize("command", ["run", "train", "compare"])
@pytest.mark.parametrize(
    ("out", "what"),
    [
        ("full", "not empty"),
        ("file", "is a file"),
        ("file/out", "cannot be written"),
        ("x" * 300, "cannot be written"),
    ],
)
def test_a_folder_that_cannot_take_results_is_refused(
    command: str, out: str, what: str, tmp_path: Path
) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "old").write_text("")
    (tmp_path / "file").write_text("")
    output = refused(tmp_path, command, "predator-prey", "--out", f"{tmp_path}/{out}")
    assert output.startswith("1 problem\n--out: ")
    assert what in output


def process(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from ecs_eco.cli import main; main()", *arguments]
    environment = os.environ | {"PYTHONPATH": str(Path(ecs_eco.__path__[0]).parent)}
    return subprocess.run(
        command, cwd=cwd, env=environment, capture_output=True, text=True, timeout=60, check=False
    )


def test_a_wrong_world_ends_the_process_with_2(folder: Path) -> None:
    (folder / "meadow.toml").write_text(WORLD.replace(*CASES["food"][:2]))
    done = process("run", "meadow.toml", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert 'did you mean "grass"?' in done.stderr
    assert not (folder / "runs").exists()


@pytest.mark.slow
def test_a_folder_without_permission_ends_the_process_with_2(folder: Path) -> None:
    done = process("run", "predator-prey", "--out", "/proc/none/out", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("1 problem\n--out: ")
