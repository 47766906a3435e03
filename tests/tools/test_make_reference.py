"""The reference of the world file: a page for each section, each with an example that is valid."""

import json
import tomllib
from typing import Any

import numpy as np
import pytest

from ecs_eco.config import load
from ecs_eco.config.edit import as_toml
from tools import make_reference as tool

EXAMPLES = sorted(path.stem for path in tool.EXAMPLES.glob("[!_]*.toml"))
PARTS = tool.parts()


def read(name: str) -> dict[str, Any]:
    return tomllib.loads((tool.EXAMPLES / f"{name}.toml").read_text(encoding="utf-8"))


def overlaid(base: dict[str, Any], top: dict[str, Any]) -> dict[str, Any]:
    """The base with the values of another table; tables of one kind are merged, all else is replaced."""
    both = [key for key in base.keys() & top if isinstance(base[key], dict) and isinstance(top[key], dict)]
    same = [key for key in both if base[key].get("kind") == top[key].get("kind", base[key].get("kind"))]
    return base | top | {key: overlaid(base[key], top[key]) for key in same}


def at(data: Any, keys: list[str]) -> list[Any]:
    """All values at a path, in which NAME is any key and [] any entry."""
    if not keys:
        return [data]
    name, inner = keys[0].removesuffix("[]"), keys[1:]
    found = list(data.values()) if name == "NAME" else [data[name]] if name in data else []
    if keys[0].endswith("[]"):
        found = [entry for entries in found if isinstance(entries, list) for entry in entries]
    return [value for one in found if isinstance(one, dict) for value in at(one, inner)]


def files(folder):
    """The files beside the world that examples name."""
    counts = [f"{year},{20 + year},{5 + year % 3}" for year in range(16)]
    (folder / "counts.csv").write_text("\n".join(["year,deer,wolf", *counts]))
    rows = np.add.outer(np.arange(100), np.arange(100)) / 50
    head = "ncols 100\nnrows 100\nxllcorner 0\nyllcorner 0\ncellsize 1\n"
    (folder / "dem.asc").write_text(head + "\n".join(" ".join(f"{x:.2f}" for x in row) for row in rows))
    (folder / "flock.py").write_text("")  # neither run nor checked before it is allowed
    shape = {"type": "LineString", "coordinates": [[0, 80], [100, 80]]}
    feature = {"type": "Feature", "properties": {}, "geometry": shape}
    streams = {"type": "FeatureCollection", "features": [feature]}
    (folder / "streams.geojson").write_text(json.dumps(streams))


def test_pages_are_up_to_date():
    written = {path.name: path.read_text(encoding="utf-8") for path in tool.PAGES.glob("*.md")}
    assert written == tool.pages()


def test_every_section_of_a_world_file_has_a_page_that_shows_all_its_keys():
    pages = tool.pages()
    for part in PARTS:
        text = pages[f"{part.page}.md"]
        keys = [key for key in part.model.model_fields if key != "kind" or not tool.kind_of(part.model)]
        assert keys
        assert [key for key in keys if f"\n| `{key}` | " not in text] == [], part.title
    assert "| `basal` | number | ≥ 0 | energy/s | `0` | basal metabolic rate |" in pages["metabolism.md"]
    assert "| `fertility` | number | 0 to 1 | | `1` | " in pages["species.md"]


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_of_a_page_is_valid(name, tmp_path):
    files(tmp_path)
    world = overlaid(read("_base"), read(name))
    (tmp_path / "meadow.toml").write_text(as_toml(world), encoding="utf-8")
    assert load(tmp_path / "meadow.toml").name == "meadow"


@pytest.mark.parametrize("part", PARTS, ids=lambda part: f"{part.page}-{part.model.__name__}")
def test_the_example_of_a_page_shows_each_of_its_sections(part):
    paths = [place.path.split(".") if place.path else [] for place in part.places]
    examples = [read(path.stem) for path in tool.examples_of(part.page)]
    shown = [value for path in paths for example in examples for value in at(example, path)]
    kind = tool.kind_of(part.model)
    if kind:
        shown = [value for value in shown if value.get("kind") == kind]
    assert any(isinstance(value, dict) for value in shown)


def test_an_example_with_an_unknown_key_is_refused(tmp_path):
    world = overlaid(read("_base"), {"species": {"deer": {"metabolism": {"basel": 1.0}}}})
    (tmp_path / "meadow.toml").write_text(as_toml(world), encoding="utf-8")
    with pytest.raises(ValueError, match="basel"):
        load(tmp_path / "meadow.toml")
