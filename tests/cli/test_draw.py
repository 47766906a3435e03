"""`ecs-eco draw`: the files it leaves, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def draw(*arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, ["draw", *arguments])
    assert done.exit_code == code, done.output + repr(done.exception)
    return done.output


@pytest.mark.parametrize(
    ("name", "begins"), [("deer.png", b"\x89PNG"), ("a/deer.svg", b"<svg"), ("deer.PDF", b"%PDF")]
)
def test_a_species_is_drawn_in_the_format_that_the_ending_says(here: Path, name: str, begins: bytes) -> None:
    assert draw("predator-prey", "--species", "deer", "--out", name) == f"Drawn in {name}\n"
    assert (here / name).read_bytes().startswith(begins)


def test_without_names_all_nervous_systems_go_into_one_file(here: Path) -> None:
    assert draw("predator-prey") == "Drawn in predator-prey-nerves.png\n"
    assert [p.name for p in here.iterdir()] == ["predator-prey-nerves.png"]


def test_values_set_on_the_command_line_are_drawn(here: Path) -> None:
    draw("predator-prey", "--species", "wolf", "--out", "a.svg")
    draw(
        "predator-prey",
        "--species",
        "wolf",
        "--out",
        "b.svg",
        "--set",
        "species.wolf.happiness.formula='energy - deer_smell'",
    )
    assert (here / "a.svg").read_bytes() != (here / "b.svg").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--species", "grass"],
            "neither sensors nor actions; allowed: a species with a nervous system: deer, wolf",
        ),
        (["--species", "wulf"], 'did you mean "wolf"?'),
        (["--out", "nerves.jpg"], 'allowed: a file ending in .png, .svg, .pdf; did you mean "nerves.png"?'),
        (["--out", "folder.png"], "is a folder"),
        (["--out", "file/nerves.png"], "cannot be written"),
    ],
)
def test_what_cannot_be_drawn_is_refused_and_leaves_nothing(
    here: Path, arguments: list[str], message: str
) -> None:
    (here / "folder.png").mkdir()
    (here / "file").touch()
    assert message in draw("predator-prey", *arguments, code=2)
    assert sorted(p.name for p in here.iterdir()) == ["file", "folder.png"]
