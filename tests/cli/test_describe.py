"""`ecs-eco describe`: what it prints and writes, and what it refuses."""

from __future__ import annotations

from pathlib import Path

from typer.testing import CliRunner

from ecs_eco.cli import app


def run(*arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, ["describe", *arguments])
    assert done.exit_code == code, done.output + repr(done.exception)
    return done.output


def test_markdown_is_printed_with_values_set_on_the_command_line() -> None:
    text = run("predator-prey", "--set", "species.wolf.count=123")
    assert text.startswith("# Grass, deer and wolves: ODD description\n")
    assert "| `count` | 700 | 4,300 | 123 | organisms at the start |" in text


def test_a_page_of_html_is_written_to_a_file_in_a_new_folder(tmp_path: Path) -> None:
    file = tmp_path / "pages" / "wolves.html"
    assert run("predator-prey", "--html", "--out", str(file)) == f"Wrote {file}.\n"
    page = file.read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>")
    assert "<h2>7. Submodels</h2>" in page


def test_an_unknown_world_is_refused_with_the_names_of_worlds() -> None:
    assert "predator-prey" in run("predator-pray", code=2)


def test_a_file_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    assert "--out" in run("predator-prey", "--out", str(tmp_path), code=2)
