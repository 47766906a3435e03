"""The page goes into the wheel, and its pictures into the docs."""

import re
import struct
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

import ecs_eco
from ecs_eco.view.server import STATIC

ROOT = Path(ecs_eco.__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def test_every_file_of_the_page_is_one_that_the_wheel_takes():
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    patterns = setup["package-data"]["*"]
    # static is a package too, one without Python in it
    assert setup["packages"]["find"]["include"] == ["ecs_eco*"]
    files = [path for path in STATIC.rglob("*") if path.is_file()]
    assert {"index.html", "main.js", "style.css", "vendor.js", "vendor.css"} <= {path.name for path in files}
    assert [
        path.name
        for path in files
        if not any(fnmatch(path.name, p) for p in patterns) and not path.name.endswith(".d.ts")
    ] == []


def test_all_that_the_page_loads_is_there():
    for path in STATIC.glob("*.js"):
        if path.name != "vendor.js":
            for name in re.findall(r'from "\./([\w.]+)"', path.read_text()):
                assert (STATIC / name).is_file(), f"{path.name} imports {name}"
    for page in STATIC.glob("*.html"):
        for name in re.findall(r'(?:src|href)="([\w.]+)"', page.read_text()):
            assert (STATIC / name).is_file(), name


@pytest.mark.parametrize(
    "name",
    [
        "page_predator_prey",
        "page_reflexes",
        "page_lamb",
        "page_diel_migration",
        "page_replay",
        "page_islands",
    ],
)
def test_the_pictures_of_the_page_are_small_and_shown(name):
    png = (ROOT / "docs" / "img" / f"{name}.png").read_bytes()
    assert struct.unpack(">II", png[16:24]) == (1280, 800)
    assert len(png) <= 300_000
    assert f'"{name}"' in (ROOT / "tools" / "screenshots.py").read_text()
    assert any(f"img/{name}.png" in page.read_text() for page in PAGES)
