"""Folders that results go to: refused in words where they cannot take any, before anything is made."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.lab.treatments import LONGEST_NAME, folder_name
from ecs_eco.record import run_to_folder

WORLD = """\
format = 1
name = "meadow"
ticks = 3
space = { size = [9.0, 9.0] }
[species.grass]
count = 5
body = { radius = 0.1 }
lethal = [{ property = "age", max = 2.0, high = '$\\foo$' }]
"""
NOBODY = 65534


def refused(*arguments: str) -> str:
    done = CliRunner().invoke(app, [*arguments])
    assert done.exit_code == 2, done.output
    assert not done.exception or isinstance(done.exception, SystemExit)
    return done.stderr


@pytest.fixture
def meadow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "meadow.toml"
    file.write_text(WORLD)
    return file


@pytest.fixture
def run(tmp_path: Path, meadow: Path) -> Path:
    run_to_folder(meadow, out=tmp_path / "run", report=False)
    return tmp_path / "run"


@pytest.mark.parametrize(
    ("out", "what"),
    [
        ("", "'' is not valid"),
        (".", "is not empty"),
        ("/", "is not empty"),
        ("..", "is not empty"),
        ("meadow.toml", "is a file"),
        ("loop", "is a broken link"),
        ("\udcff", "is not valid"),
    ],
    ids=["nothing", "here", "root", "above", "file", "loop", "name"],
)
@pytest.mark.parametrize("command", ["run", "compare"])
def test_folders_that_are_none_are_refused(command: str, out: str, what: str, meadow: Path) -> None:
    (meadow.parent / "loop").symlink_to("loop")
    before = sorted(meadow.parent.rglob("*"))
    output = (
        refused(command, str(meadow), "--treatment", "ticks=2", "--out", out)
        if command == "compare"
        else refused(command, str(meadow), "--out", out)
    )
    assert what in output.replace("\n│", "")
    assert sorted(meadow.parent.rglob("*")) == before


def test_an_empty_folder_takes_results_from_within(meadow: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (meadow.parent / "empty").mkdir()
    monkeypatch.chdir(meadow.parent / "empty")
    done = CliRunner().invoke(app, ["run", str(meadow), "--out", ".", "--no-report", "--quiet"])
    assert done.exit_code == 0, done.output
    assert (meadow.parent / "empty" / "manifest.json").is_file()


@pytest.mark.parametrize("command", ["report", "why"])
@pytest.mark.parametrize("out", ["file", "file/below", "/proc/none"])
def test_pages_are_refused_where_they_cannot_be_written(command: str, out: str, run: Path) -> None:
    (run.parent / "file").write_text("")
    output = refused(command, str(run), "--out", out if out.startswith("/") else str(run.parent / out))
    assert output.startswith("1 problem\n--out: ")


@pytest.fixture
def read_only(run: Path) -> Iterator[Path]:
    """A run in a folder that this process may read and not write; root may write to any,
    and is somebody else meanwhile."""
    place = Path(tempfile.mkdtemp())
    for command in ("report", "why"):  # loads what they need from places that somebody else may not read
        assert CliRunner().invoke(app, [command, str(run), "--out", str(place / command)]).exit_code == 0
        shutil.rmtree(place / command)
    shutil.copytree(run, place / "run")
    for path in (place, *place.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)
    root = os.geteuid() == 0
    if root:
        os.seteuid(NOBODY)
    yield place / "run"
    if root:
        os.seteuid(0)
    for path in (place, *place.rglob("*")):
        path.chmod(0o755)
    shutil.rmtree(place)


@pytest.mark.parametrize("command", ["report", "why"])
def test_pages_of_a_run_that_is_read_only_are_refused_with_the_way_out(command: str, read_only: Path) -> None:
    output = refused(command, str(read_only))
    assert f'DIR: "{read_only}"'[:60] in output
    assert (
        "cannot be written: Permission denied; expected: a writable folder; choose one with --out" in output
    )


@pytest.mark.parametrize(
    ("command", "page", "figure"), [("report", "report.html", "deaths.svg"), ("why", "why.html", "why.svg")]
)
def test_pages_go_elsewhere_and_the_run_stays_as_it_is(
    command: str, page: str, figure: str, run: Path, tmp_path: Path
) -> None:
    before = {p: p.stat().st_mtime_ns for p in run.rglob("*")}
    done = CliRunner().invoke(app, [command, str(run), "--out", str(tmp_path / "elsewhere")])
    assert done.exit_code == 0, done.output
    assert r"$\foo$" in (tmp_path / "elsewhere" / page).read_text()
    assert (tmp_path / "elsewhere" / "figures" / figure).is_file()
    assert {p: p.stat().st_mtime_ns for p in run.rglob("*")} == before


def test_long_controls_have_short_folders_of_their_own() -> None:
    long, other = "species.deer.count=" + "1" * 4000, "species.deer.count=" + "1" * 4001
    assert len(folder_name(long).encode()) <= LONGEST_NAME
    assert folder_name(long) != folder_name(other)
    assert len(folder_name("title=" + "ü" * 300).encode()) <= LONGEST_NAME
    assert folder_name("species.deer.count=5") == "species.deer.count-5"


@pytest.mark.parametrize(
    "control", ["../../x=1", "a\0b=1", "a/b=1", "a\nb=1", "..=1", "\u202eb=1", "\udcff=1"]
)
def test_names_of_controls_are_no_paths(control: str) -> None:
    name = folder_name(control)
    assert name == Path(name).name
    assert name not in ("", ".", "..")
    assert name.isprintable()


@pytest.mark.parametrize("command", ["resume", "repeat", "tracks", "report", "why", "picture", "lineage"])
def test_a_missing_run_is_refused_alike_by_all_commands(command: str) -> None:
    said = refused(command, "nowhere", *(["tracks.csv"] if command == "tracks" else []))
    assert (
        said == '1 problem\nDIR: "nowhere"\n  no such folder; expected: a folder written by `ecs-eco run`\n'
    )
