"""The page of the architecture matches the import contract and docstrings, and names only what exists."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = sorted((ROOT / "ecs_eco").rglob("__init__.py"))


@pytest.fixture
def tool(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    return import_module("make_architecture")


@pytest.mark.slow
def test_the_page_and_its_picture_are_up_to_date_and_name_what_is_there():
    done = subprocess.run(
        [sys.executable, "tools/make_architecture.py", "--check"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("path", PACKAGES, ids=lambda path: str(path.parent.relative_to(ROOT)))
def test_a_folder_says_what_belongs_there_and_what_does_not(path):
    words = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    first, _, rest = words.partition("\n\n")
    assert first, "no docstring"
    assert rest, "it says what belongs there, and not what does not"
    assert len(words.splitlines()) <= 7


def test_every_package_of_the_contract_is_in_the_table_and_in_the_picture(tool):
    stack = tool.layers()
    table, picture = tool.table(stack), tool.picture(stack)
    for package in (package for packages in stack for package in packages):
        assert f"[{package}](" in table
        assert f">{package}</text>" in picture


@pytest.mark.slow
@pytest.mark.parametrize(
    ("was", "becomes", "message"),
    [
        ("| 1 | [_lazy]", "| 2 | [_lazy]", "page.md is out of date: run python tools/make_architecture.py"),
        ("`ingest`", "`gobble`", "feed.py defines no gobble"),
        ("systems/feed.py)", "systems/fed.py)", "no file ../../ecs_eco/systems/fed.py"),
    ],
)
def test_what_is_stale_or_gone_is_named(was, becomes, message, tool, tmp_path, monkeypatch, capsys):
    text = tool.PAGE.read_text(encoding="utf-8")
    assert was in text
    room = tool.PAGE.parent
    (tmp_path / room.relative_to(ROOT)).mkdir(parents=True)
    others = [path for path in (ROOT / "docs").iterdir() if path != room]
    for path in [ROOT / "ecs_eco", ROOT / "tools", ROOT / "pyproject.toml", *others, *room.iterdir()]:
        (tmp_path / path.relative_to(ROOT)).symlink_to(path)
    page = tmp_path / room.relative_to(ROOT) / "page.md"
    page.write_text(text.replace(was, becomes), encoding="utf-8")
    monkeypatch.setattr(tool, "PAGE", page)
    monkeypatch.setattr(sys, "argv", ["make_architecture.py", "--check"])
    assert tool.main() == 1
    assert message in capsys.readouterr().err
