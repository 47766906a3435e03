"""Each figure of a study can be drawn from its result as it stands."""

import runpy
import sys
from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[2] / "studies"


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.stem for path in STUDIES.glob("draw_*.py")))
def test_a_figure_is_drawn_from_its_result(name, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(sys, "argv", [name, "--short"])
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    runpy.run_module(f"studies.{name}", run_name="__main__")
    said = capsys.readouterr().out.strip()
    if said.endswith("no result; run the study first"):
        pytest.skip(said)
    drawn = Path(said)
    assert drawn.is_relative_to(tmp_path)
    assert drawn.stat().st_size > 5_000
