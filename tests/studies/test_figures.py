"""Each figure of a study can be drawn from its result as it stands."""

import runpy
import sys
from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[2] / "studies"


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.stem for path in STUDIES.glob("draw_*.py")))
def test_a_figure_is_drawn_from_its_result(name, monkeypatch, capsys, tmp_path):
    begun = (
        STUDIES / "results" / f"{name.removeprefix('draw_')}.partial.json"
    )  # of a study that is not complete
    monkeypatch.setattr(
        sys, "argv", [name, "--short", *(["--results", str(begun)] if begun.is_file() else [])]
    )
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.delitem(sys.modules, f"studies.{name}", raising=False)  # a figure may import another one
    runpy.run_module(f"studies.{name}", run_name="__main__")
    drawn = Path(capsys.readouterr().out.strip())
    assert drawn.is_relative_to(tmp_path)
    assert drawn.stat().st_size > 5_000
