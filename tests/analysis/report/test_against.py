"""A report shows an outside series beside the run, where it is asked to."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from ecs_eco.analysis.report.against import blocks
from ecs_eco.analysis.runs import Series
from ecs_eco.config.measurements import Outside
from tests.analysis.test_against import HARE_LYNX, waves


def test_without_an_outside_series_there_is_nothing(tmp_path):
    assert blocks(Series(np.arange(2), ("deer",), {"n": np.ones((2, 1))}), None, tmp_path) == []


def test_table_and_figure_show_both(tmp_path):
    series = Series(
        np.arange(300), ("deer", "wolf"), {"n": np.stack([waves(300, 50.0), waves(300, 50.0, 0.2)], 1)}
    )
    t = np.arange(30.0)
    outside = Outside(
        1900 + t,
        {"deer": waves(30, 10.0), "wolf": waves(30, 10.0, 0.1)},
        {"deer": "hare", "wolf": "wolf"},
        "year",
    )
    text = "".join(blocks(series, outside, tmp_path))
    assert "deer (hare)" in text
    assert "year" in text
    assert "wolf behind deer" in text
    assert (tmp_path / "figures" / "against.svg").stat().st_size > 10_000


@pytest.mark.slow
def test_the_command_takes_a_file_and_which_column_is_which_species(tmp_path, monkeypatch):
    from ecs_eco.cli.app import app
    from ecs_eco.record import run_to_folder

    monkeypatch.chdir(tmp_path)
    (tmp_path / "pelts.csv").write_text(HARE_LYNX)
    run_to_folder("reflexes", ticks=20, out="run", report=False, policies="random")
    name = json.loads((tmp_path / "run" / "manifest.json").read_text())["species"][0]
    words = ["report", "run", "--against", "pelts.csv", "--match"]
    done = CliRunner().invoke(app, [*words, f"hare={name}"])
    assert done.exit_code == 0, done.output
    assert "Comparison with the outside series" in (tmp_path / "run" / "report.html").read_text()
    assert CliRunner().invoke(app, [*words, "hare"]).exit_code == 2
    assert CliRunner().invoke(app, ["report", "run", "--match", "hare=deer"]).exit_code == 2
