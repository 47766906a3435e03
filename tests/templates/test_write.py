"""What `ecs-eco new` writes lives, keeps its own tests, and is as plain as it says."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

import ecs_eco
from ecs_eco import World
from ecs_eco.cli import app
from ecs_eco.config import load
from ecs_eco.config.notes import notes
from ecs_eco.engine.errors import ConfigError
from ecs_eco.templates import ORIGINS, new_package, new_world

ROOT = Path(ecs_eco.__path__[0]).parent


def passes(folder: Path) -> str:
    """The last line of pytest in a folder, where it must pass."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error"]
    done = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.strip().splitlines()[-1]


@pytest.fixture
def meadow(tmp_path):
    new_world(tmp_path / "my-world")
    return tmp_path / "my-world"


def test_a_new_world_has_a_file_a_system_its_test_and_a_readme(meadow):
    assert sorted(path.name for path in meadow.iterdir()) == [
        "README.md",
        "lightning.py",
        "my-world.toml",
        "test_lightning.py",
    ]
    assert load(meadow / "my-world.toml").name == "my-world"


@pytest.mark.parametrize("origin", ORIGINS)
def test_every_world_to_begin_with_is_right_and_runs(origin, tmp_path):
    new_world(tmp_path / "Isle_2", origin)
    config = load(tmp_path / "Isle_2" / "Isle_2.toml", trust=True)
    assert config.name == "Isle_2"
    assert notes(config) == []
    world = World.from_config(config).run(5)
    assert [type(s).__name__ for s in world.systems].count("Lightning") == 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_the_meadow_lives_and_swings(meadow, seed):
    world = World.from_config(meadow / "my-world.toml", seed=seed, trust=True)
    rabbits = [world.run(100).table("rabbit").n for _ in range(30)]
    assert min(rabbits) > 50
    assert max(rabbits) < 500


def test_what_a_blank_world_shows_as_a_comment_can_be_switched_on(tmp_path):
    new_world(tmp_path / "isle", "blank")
    text = (tmp_path / "isle" / "isle.toml").read_text(encoding="utf-8")
    head, _, snail = text.partition("# [species.snail]")
    lines = [line.removeprefix("# ") for line in f"[species.snail]{snail}".splitlines()]
    (tmp_path / "isle" / "isle.toml").write_text(head + "\n".join(lines), encoding="utf-8")
    config = load(tmp_path / "isle" / "isle.toml", trust=True)
    assert list(config.species) == ["moss", "snail"]
    assert notes(config) == []
    assert World.from_config(config).run(100).table("snail").n > 20


def test_what_the_meadow_says_of_learning_works(meadow):
    text = (meadow / "my-world.toml").read_text(encoding="utf-8")
    document = tomllib.loads(text)
    rabbit = document["species"]["rabbit"]
    del rabbit["reflex"], rabbit["default_action"], document["code"], document["systems"]
    for line in text.splitlines():
        if line.startswith("#   "):
            rabbit |= tomllib.loads(line.removeprefix("#   "))
    assert rabbit["policy"] == {"kind": "shared", "learn": True}
    assert World.from_config(document).run(3).table("rabbit").n == 120


@pytest.mark.slow
def test_the_test_of_a_new_world_passes(meadow):
    assert passes(meadow).startswith("2 passed")


@pytest.mark.slow
def test_a_new_package_has_components_systems_a_world_and_tests_that_pass(tmp_path):
    files = {path.relative_to(tmp_path).as_posix() for path in new_package(tmp_path / "wool-lab")}
    assert files == {
        f"wool-lab/{name}"
        for name in (
            "README.md",
            "pyproject.toml",
            "src/wool_lab/__init__.py",
            "src/wool_lab/components.py",
            "src/wool_lab/meadow.toml",
            "src/wool_lab/py.typed",
            "src/wool_lab/systems.py",
            "tests/test_components.py",
            "tests/test_meadow.py",
            "tests/test_systems.py",
        )
    }
    for name in files:
        assert "my_ecology" not in (tmp_path / name).read_text(encoding="utf-8"), name
        assert "my-" not in (tmp_path / name).read_text(encoding="utf-8").replace("my-run", ""), name
    assert passes(tmp_path / "wool-lab").startswith("5 passed")


@pytest.mark.parametrize("how", [[], ["--package"]])
def test_what_is_written_has_no_slips_and_lines_of_at_most_110_columns(how, tmp_path):
    assert CliRunner().invoke(app, ["new", str(tmp_path / "isle"), *how]).exit_code == 0
    rules = ["--isolated", "--no-cache", "--select", "E,W,F,B,UP,NPY,PT,RUF", "--line-length", "110"]
    done = subprocess.run(
        [sys.executable, "-m", "ruff", "check", *rules, "isle"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("name", "how", "message"),
    [
        ("9lives", [], "not a valid name"),
        ("isle", ["--from", "medow"], "unknown starter world"),
        ("isle", ["--from", "blank", "--package"], "cannot be used with --package"),
        ("json", ["--package"], "is the name of an existing module or a keyword"),
        ("class", ["--package"], "is the name of an existing module or a keyword"),
        ("full", [], "the folder is not empty"),
    ],
)
def test_what_cannot_be_written_is_refused(name, how, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    done = CliRunner().invoke(app, ["new", name, *how])
    assert done.exit_code == 2
    assert message in done.output
    assert [path.name for path in tmp_path.iterdir()] == ["full"]


def test_an_empty_folder_is_taken_and_the_command_says_how_to_go_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "isle").mkdir()
    done = CliRunner().invoke(app, ["new", "isle"])
    assert done.exit_code == 0
    assert "ecs-eco run isle/isle.toml --trust --out my-run" in done.output
    with pytest.raises(ConfigError, match="the folder is not empty"):
        new_world("isle")
