"""What came of a sweep: a tidy table, figures, a page that needs no other file."""

from __future__ import annotations

from pathlib import Path

import pyarrow.parquet as pq
import pytest

from ecs_eco.engine.errors import RecordingError
from ecs_eco.lab.folder import read_sweep
from ecs_eco.lab.sweep import do_jobs, run_sweep
from ecs_eco.lab.table import collect, rows_of, write_page
from tests.lab.test_sweep import Here, begun

PLAN = """
world = "moss.toml"
title = "Moss <in> rows"
ticks = 6
world_seeds = 2
treatments = ["species.moss.reproduction.rate=0.9"]
[reporters]
stock = "sum(moss.Metabolism.energy)"
[grid]
species.moss.count = [10, 30]
"space.edges" = ["torus", "walls"]
"""


@pytest.mark.slow
def test_a_sweep_is_collected_into_a_row_for_each_run_and_a_page(tmp_path: Path) -> None:
    sweep = begun(tmp_path, PLAN)
    with pytest.raises(RecordingError, match="no job is done yet"):
        collect(sweep)
    do_jobs(sweep, Here(), range(15))
    result = collect(sweep)
    assert result.missing == 1
    rows = pq.read_table(result.table).to_pylist()
    assert [row["job"] for row in rows] == list(range(15))
    assert list(rows[0])[:3] == ["job", "point", "species.moss.count"]
    assert list(rows[0])[-4:] == ["host", "git_commit", "config_hash", "digest"]
    assert rows[0]["species.moss.count"] == 10
    assert rows[0]["space.edges"] == "torus"
    assert [row["treatment"] for row in rows[1:4]] == ["world", *["species.moss.reproduction.rate=0.9"] * 2]
    assert rows[0]["persisted"] is True
    assert rows[2]["moss.mean"] > rows[0]["moss.mean"]  # the same seed, more seedlings
    assert rows[0]["moss.final"] == 10 + rows[0]["moss.births"]
    assert rows[0]["stock.final"] > 0
    assert len({row["digest"] for row in rows}) == 15
    page = result.page.read_text()
    assert "Moss &lt;in&gt; rows" in page
    assert page.count('class="plot') == 3  # the response, the heat map, and births
    assert "1 of 16 jobs are not done" in page
    assert result.lines[0] == "world: all species persist in 8 of 8 runs of 6 ticks, at 4 points"


def test_runs_that_a_condition_ends_are_counted(tmp_path: Path) -> None:
    plant = {
        "count": 10,
        "body": {"radius": 0.1},
        "reproduction": {"kind": "spread", "rate": 0.5, "spacing": 0.5},
    }
    world = {"format": 1, "name": "bank", "space": {"size": [10.0, 10.0]}, "species": {"moss": plant}}
    plan = {"world": world, "ticks": 6, "until": "moss > 0", "world_seeds": 2}
    run_sweep(plan, tmp_path / "out", executor=Here())
    (line,) = collect(read_sweep(tmp_path / "out")).lines
    assert line == "world: all species persist in 2 of 2 runs of 6 ticks; 2 ended earlier by a condition"


def test_births_and_deaths_are_drawn_though_some_runs_lack_a_species(tmp_path: Path) -> None:
    plant = {"body": {"radius": 0.1}, "reproduction": {"kind": "spread", "rate": 0.5, "spacing": 0.5}}
    species = {"moss": plant | {"count": 10}, "fern": plant | {"count": 20}}
    world = {"format": 1, "name": "bank", "space": {"size": [10.0, 10.0]}, "species": species}
    plan = {"world": world, "ticks": 6, "treatments": ["no-fern"], "grid": {"species.moss.count": [10, 30]}}
    run_sweep(plan, tmp_path / "out", executor=Here())
    result = collect(read_sweep(tmp_path / "out"))
    rows = pq.read_table(result.table).to_pylist()
    assert [row["fern.births"] == 0 for row in rows] == [row["treatment"] == "no-fern" for row in rows]
    page = result.page.read_text()
    assert "fern" in page.partition("Births and deaths")[2]
    sweep = read_sweep(tmp_path / "out")
    older = [row | {"fern.births": None} for row in rows_of(sweep)[:1]] + rows_of(sweep)[1:]
    assert "Births and deaths" in write_page(sweep, older, {}).read_text()
