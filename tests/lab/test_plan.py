"""Plans as they are written: dotted keys however TOML nests them, seeds, and refusals at their lines."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab.design import design_of
from ecs_eco.lab.plan import read_plan
from tests.lab.moss import WORLD


def refusal(tmp_path: Path, text: str) -> str:
    path = tmp_path / "plan.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as error:
        read_plan(path)
    return str(error.value)


def test_keys_are_dotted_whether_they_are_tables_or_in_quotes(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(
        'world = "x"\n[set]\nspecies.deer.count = 5\n[grid]\n"species.wolf.count" = [1, 2]\n'
        "[grid.space]\nsize = [[10.0, 10.0]]\n[sample]\npoints = 3\n"
        "[sample.ranges]\nspecies.fox.count = [1, 9]\n"
        '[[list]]\nspecies.ant.count = 2\n"species.bee.count" = 3\n'
    )
    file = read_plan(path)
    assert file.plan.set == {"species.deer.count": 5}
    assert file.plan.grid == {"species.wolf.count": [1, 2], "space.size": [[10.0, 10.0]]}
    assert file.plan.sample is not None
    assert file.plan.sample.ranges["species.fox.count"].search == [1, 9]
    assert file.plan.list == [{"species.ant.count": 2, "species.bee.count": 3}]


def test_seeds_are_a_number_of_them_or_a_list() -> None:
    plan = read_plan({"world": "x", "world_seeds": 3, "training_seeds": [7, 9]}).plan
    assert plan.seeds("world") == (1, 2, 3)
    assert plan.seeds("training") == (7, 9)
    assert read_plan({"world": "x"}).plan.seeds("training") == ()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('world = "x"\nwrld_seeds = 3\n', ["plan.toml, line 2", "unknown key", 'did you mean "world_seeds"']),
        ('world = "x"\nworld_seeds = 0\n', ["line 2", "at least 1"]),
        ('world = "x"\nworld_seeds = [1, 2, 1]\n', ["line 2", "has 1 twice"]),
        ("ticks = 3\n", ["world", "is missing"]),
        ('world = "x"\n[grid]\n', ["line 2", "is empty"]),
        ('world = "x"\n[grid]\nspecies.deer.count = []\n', ["line 3", "has no values"]),
        ('world = "x"\n[grid]\nspecies.deer.count = 5\n', ["line 3", "a list"]),
        ('world = "x"\n[grid]\nspecies.deer.count = [\n5,\n5]\n', ["line 5", "occurs twice"]),
        (
            'world = "x"\n[set]\nspecies.deer.count = 3\n[grid]\n"species.deer.count" = [5]\n',
            ["line 5", "is in [set] too"],
        ),
        ('world = "x"\n[grid]\nseed = [1, 2]\n', ["line 3", "world_seeds"]),
        ('world = "x"\n[[list]]\ndt = 1.0\n[[list]]\nticks = 2\n', ["line 4", "has different keys"]),
        (
            'world = "x"\n[sample]\npoints = 3\n[sample.ranges]\ndt = [1.0]\n',
            ["line 5", "at least 2 entries"],
        ),
        (
            'world = "x"\n[latin_hypercube]\npoints = 3\n[latin_hypercube.ranges]\ndt = [1.0]\n',
            ["line 5", "latin_hypercube.ranges.dt", "at least 2 entries"],
        ),
        ('world = "x"\n[latin_hypercube]\npoints = 0\n', ["line 3", "at least 1"]),
        ('world = "x"\n[sample]\n[latin_hypercube]\n', ["is given twice"]),
        ('world = "x"\n[sampel]\n', ['did you mean "sample"']),
        ('world = "x"\ntreatments = ["a",\n"a"]\n', ["line 3", "is named twice"]),
        ('world = "x\n', ["line 1", "not TOML"]),
    ],
)
def test_a_bad_plan_is_refused_at_its_line(tmp_path: Path, text: str, words: list[str]) -> None:
    message = refusal(tmp_path, text)
    for word in words:
        assert word in message, message


def test_a_section_by_its_former_name_is_read_and_noted(tmp_path: Path) -> None:
    drawn = {"points": 3, "ranges": {"species.moss.count": [1, 9]}}
    present, former = (
        read_plan({"world": tomllib.loads(WORLD), name: drawn}) for name in ("sample", "latin_hypercube")
    )
    assert former.plan == present.plan
    assert (present.notes, former.notes) == ([], ["sample is the present name of latin_hypercube"])
    settings = design_of(present).planned["plan"]
    assert settings == design_of(former).planned["plan"]
    assert settings["latin_hypercube"]["points"] == 3  # as in the folders of earlier versions


def test_a_plan_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"PLAN.*no-plan.toml"):
        read_plan(tmp_path / "no-plan.toml")
