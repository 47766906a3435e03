"""[data]: names that are not there are refused, worlds without it are as they were, reports show it."""

from __future__ import annotations

import json
import shutil

import pytest

from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from tests.analysis.test_against import HARE_LYNX

WORLD = """\
format = 1
name = "fell"
ticks = 30
[space]
size = [20.0, 20.0]
[species.hare]
count = 4
body = { radius = 0.1 }
[species.mite]
count = 4
body = { radius = 0.1 }
[data]
file = "pelts.csv"
columns = { lynx = "mite" }
"""


@pytest.fixture
def world(tmp_path):
    path = tmp_path / "fell.toml"
    path.write_text(WORLD, encoding="utf-8")
    (tmp_path / "pelts.csv").write_text(HARE_LYNX)
    return path


@pytest.mark.parametrize(
    ("columns", "fault"),
    [
        ('{ lynx = "mites" }', 'did you mean "mite"?'),
        ('{ lynx = "mite", other = "mite" }', "another column is also compared with it"),
    ],
)
def test_what_columns_are_compared_with_must_be_there(world, columns, fault):
    world.write_text(WORLD.replace('{ lynx = "mite" }', columns))
    with pytest.raises(ConfigError) as error:
        load(world)
    assert fault in str(error.value)
    assert "data.columns." in str(error.value)


def test_worlds_without_it_have_the_hash_that_they_had(world):
    assert "data" not in load("predator-prey").resolved()
    assert load(world).resolved()["data"]["columns"] == {"lynx": "mite"}


@pytest.mark.slow
def test_a_run_keeps_the_series_and_its_report_shows_it_wherever_it_is(world, tmp_path):
    from ecs_eco.analysis.report import write_report
    from ecs_eco.runs.repeat import repeat
    from ecs_eco.runs.run import run_to_folder

    run_to_folder(str(world), out=tmp_path / "run", report=False)
    world.unlink()
    (tmp_path / "pelts.csv").unlink()
    moved = shutil.move(tmp_path / "run", tmp_path / "elsewhere")
    assert "Comparison with the outside series" in write_report(moved).read_text()
    assert json.loads((tmp_path / "elsewhere" / "manifest.json").read_text())["config"]["data"]
    assert repeat(moved)["same"]


ROWS = [f"{1900 + k},{10 + k % 5}" for k in range(16)]


@pytest.mark.parametrize(
    ("lines", "fault"),
    [
        (
            ["year;lynx", *(row.replace(",", ";") + ",5" for row in ROWS)],
            "has no header with at least two columns",
        ),
        (
            ["year\tlynx", *(row.replace(",", "\t") for row in ROWS)],
            "has no header with at least two columns",
        ),
        (["year,lynx", *(f'{k},"1,{k:03d}"' for k in range(16))], "has 0 rows of numbers"),
        (["year,lynx", *(row.replace(",", "-01-01,") for row in ROWS)], "has 0 rows of numbers"),
        (["year,lynx", *ROWS[:5], "1905,NA", *ROWS[6:]], "has 15 rows of numbers, or gaps between them"),
        (["year,lynx", *ROWS[:5], *ROWS[6:]], "not evenly spaced"),
        (["year,lynx", *ROWS[::-1]], "not evenly spaced"),
        (["year,lynx", *ROWS, ROWS[-1]], "not evenly spaced"),
        (["year,lynx", *(row.replace(",", ",-") for row in ROWS)], "has numbers below 0"),
        (["year,lynx", *(row.partition(",")[0] + ",0" for row in ROWS)], "has a column with only zeros"),
        (["year,puma", *ROWS], "no column with this name"),
        (["year,lynx", *ROWS, "1916"], "row 18 does not have as many columns as the header"),
        (["j\xe4hr,lynx", *ROWS], "cannot be read"),
        ([], "has no header with at least two columns"),
    ],
)
def test_check_and_run_refuse_the_same_measurements(world, tmp_path, lines, fault):
    (tmp_path / "pelts.csv").write_text("\n".join(lines), encoding="latin-1")
    with pytest.raises(ConfigError, match=fault) as error:
        load(world)
    assert [p.path.startswith("data.") and p.line is not None for p in error.value.problems] == [True]


def test_a_run_is_read_whatever_became_of_its_measurements(world, tmp_path, monkeypatch):
    from ecs_eco.record.code import recorded
    from ecs_eco.runs.run import read_manifest, run_to_folder

    run_to_folder(str(world), ticks=1, out=tmp_path / "run", report=False)
    (tmp_path / "pelts.csv").write_text("nothing")
    monkeypatch.chdir(tmp_path)
    assert recorded(tmp_path / "run", read_manifest(tmp_path / "run")).data.file == "pelts.csv"


def test_a_file_that_cannot_be_used_is_refused_before_the_first_tick(world, tmp_path):
    from ecs_eco.runs.run import run_to_folder

    (tmp_path / "pelts.csv").write_text("year,lynx\n1900,3\n")
    with pytest.raises(ConfigError, match="has 1 rows of numbers") as error:
        run_to_folder(str(world), out=tmp_path / "run", report=False)
    assert "data.file" in str(error.value)
    (tmp_path / "pelts.csv").unlink()
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        run_to_folder(str(world), out=tmp_path / "other", report=False)
