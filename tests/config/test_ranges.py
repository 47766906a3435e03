"""Ranges beside numbers: a run passes over them, and wrong ones are refused with place,
value and what is right."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ecs_eco.config import load
from ecs_eco.config.edit import as_toml, edited, literal
from ecs_eco.config.lines import value_spans
from ecs_eco.config.shipped import shipped
from ecs_eco.engine.errors import ConfigError

WORLD = """\
format = 1
name = "fell"
ticks = 100
[space]
size = [20.0, 20.0]
[species.mite]
count = { value = 4, search = [2, 9] }      # mites
body = { radius = 0.1, mass = { value = 0.5, search = [0.1, 2.0], scale = "log" } }
metabolism = { energy = 0.5, energy_max = 1.0, basal = 0.01 }
[[interventions]]
kind = "cull"
at = 3
species = "mite"
share = { value = 0.2, search = [0.0, 0.5] }
[search]
ticks = 60
[search.ranges]
"species.mite.metabolism.basal" = [0.001, 0.02]
"""
PLAIN = re.sub(r"\{ value = ([\d.]+), search.*?\] ?(, scale = \"log\" )?\}", r"\1", WORLD).partition(
    "[search]"
)[0]


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "fell.toml"
    path.write_text(text, encoding="utf-8")
    return path


def problem(tmp_path: Path, old: str, new: str) -> str:
    """What is said of the world with `new` in the place of `old`."""
    assert old in WORLD
    with pytest.raises(ConfigError) as caught:
        load(written(tmp_path, WORLD.replace(old, new)))
    return str(caught.value)


def test_a_world_with_ranges_is_the_world_without(tmp_path: Path) -> None:
    config = load(written(tmp_path, WORLD))
    assert (config.species["mite"].count, config.species["mite"].body.mass) == (4, 0.5)
    assert config.config_hash == load(written(tmp_path, PLAIN)).config_hash
    assert "search" not in config.resolved()


def test_ranges_beside_numbers_and_in_one_place_are_found_by_their_dotted_keys(tmp_path: Path) -> None:
    ranges = load(written(tmp_path, WORLD)).search.ranges
    assert {name: tuple(r.search) for name, r in ranges.items()} == {
        "species.mite.metabolism.basal": (0.001, 0.02),
        "species.mite.count": (2, 9),
        "species.mite.body.mass": (0.1, 2.0),
        "interventions.0.share": (0.0, 0.5),
    }
    assert ranges["species.mite.body.mass"].scale == "log"


def test_a_value_that_is_set_is_varied_no_more_unless_its_range_is_set_too(tmp_path: Path) -> None:
    path = written(tmp_path, WORLD)
    assert "species.mite.count" not in load(path, ["species.mite.count=40"]).search.ranges
    both = load(path, {"species.mite.count": 40, 'search.ranges."species.mite.count"': [30, 50]})
    assert both.search.ranges["species.mite.count"].search == [30, 50]


def test_ranges_survive_loading_a_loaded_world(tmp_path: Path) -> None:
    config = load(written(tmp_path, WORLD))
    assert load(config, {"ticks": 5}).search == config.search


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "search = [2, 9]",
            "search = [5, 9]",
            ["line 7", "species.mite.count.search = [5, 9]", "does not contain the world's value, 4"],
        ),
        ("search = [2, 9]", "search = [9, 2]", ["line 7", "not a range", "low < high"]),
        ("search = [2, 9]", "search = [4, 4]", ["line 7", "not a range"]),
        ("search = [2, 9]", f"search = [2, {'9' * 400}]", ["line 7", "not a range"]),
        ("search = [2, 9]", "search = [2]", ["at least 2 entries"]),
        ("search = [2, 9]", 'search = ["a", 9]', ["wrong type"]),
        ("value = 4, search", "search", ["line 7", "is missing next to the range"]),
        (
            "search = [2, 9] }",
            "search = [2, 9], scal = 1 }",
            ["line 7", "unknown key", 'did you mean "scale"'],
        ),
        ('"log"', '"logg"', ["line 8", "no such choice", 'did you mean "log"']),
        ("search = [0.1, 2.0]", "search = [0.0, 2.0]", ["line 8", "not possible on a log scale"]),
        (
            "metabolism.basal",
            "metabolism.basel",
            ["line 18", "no 'basel' in species.mite.metabolism", 'did you mean "basal"'],
        ),
        (
            "species.mite.metabolism.basal",
            "species.mite",
            ["line 18", "is a range, but its key is not a number"],
        ),
        ("species.mite.metabolism.basal", "name", ["is a range, but its key is not a number", "'fell'"]),
        ("species.mite.metabolism.basal", "space.cell", ["has no value yet"]),
        ("species.mite.metabolism.basal", "species.mite.count", ["has a range here and in [search.ranges]"]),
        ("[0.001, 0.02]", "[0.02, 0.04]", ["line 18", "does not contain the world's value, 0.01"]),
        ("ticks = 60", "tick = 60", ["line 16", "unknown key", 'did you mean "ticks"']),
        (
            "ticks = 60",
            'objective = "persistance"',
            ["line 16", "no such objective", 'did you mean "persistence"'],
        ),
        ("ticks = 60", 'objective = "population"', ["search.wanted", "the objective is population"]),
        ("ticks = 60", "wanted = { mits = 4 }", ["no such species", 'did you mean "mite"']),
        ("ticks = 60", 'persist = ["mits"]', ["no such species", 'did you mean "mite"']),
    ],
)
def test_a_wrong_range_is_refused_with_its_place(
    tmp_path: Path, old: str, new: str, words: list[str]
) -> None:
    text = problem(tmp_path, old, new)
    assert [word for word in words if word not in text] == [], text


# the text of a world with other values


def test_values_change_and_everything_else_of_the_text_stays() -> None:
    text = edited(WORLD, {("species", "mite", "count"): 7, ("species", "mite", "metabolism", "basal"): 0.003})
    assert text == WORLD.replace("value = 4", "value = 7").replace("basal = 0.01", "basal = 0.003")


def test_a_value_that_is_not_in_the_text_finds_a_place_in_it() -> None:
    text = edited(
        WORLD,
        {("species", "mite", "metabolism", "photosynthesis"): 0.5, ("space", "edges"): "walls", ("seed",): 3},
    )
    assert text is not None
    assert "basal = 0.01, photosynthesis = 0.5 }" in text
    assert '[space]\nedges = "walls"\n' in text
    assert text.startswith("seed = 3\n")


def test_a_text_that_does_not_yield_is_given_up() -> None:
    assert edited(WORLD, {("interventions", 5, "share"): 0.1}) is None


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_world_written_anew_is_the_same(name: str, tmp_path: Path) -> None:
    config = load(name)
    data = config.resolved()
    for species in data["species"].values():
        species["policy"]["file"] = None
    path = tmp_path / "world.toml"
    path.write_text(as_toml(data), encoding="utf-8")
    assert load(path).resolved() == data


def test_the_characters_of_each_value_are_found() -> None:
    text = 'a = 1 # one\n[b]\nc = [ [1, 2], { d = "x" } ]\n[[e]]\nf = 0.5\n'
    spans = {key: text[begin:end] for key, (begin, end) in value_spans(text).items()}
    assert spans == {
        ("a",): "1",
        ("b",): "[b]",
        ("b", "c"): '[ [1, 2], { d = "x" } ]',
        ("b", "c", 0): "[1, 2]",
        ("b", "c", 0, 0): "1",
        ("b", "c", 0, 1): "2",
        ("b", "c", 1): '{ d = "x" }',
        ("b", "c", 1, "d"): '"x"',
        ("e", 0): "[[e]]",
        ("e", 0, "f"): "0.5",
    }


def test_literals_are_toml() -> None:
    assert (
        literal({"a": [1, 0.5, True], "b c": 'say "x"', "d": None})
        == '{ a = [1, 0.5, true], "b c" = "say \\"x\\"" }'
    )


def test_a_range_without_a_key_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="not a number of the world"):
        load(written(tmp_path, WORLD), {"search.ranges": {"": {"search": [1, 2]}}})
