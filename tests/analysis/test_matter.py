"""The ledger of matter as readers see it: counted by hand, in a report and in why."""

import json

import numpy as np
import pyarrow as pa
import pytest

from ecs_eco.analysis import matter
from ecs_eco.analysis.report import write_report
from ecs_eco.analysis.why import write_why
from ecs_eco.record import run_to_folder

MEADOW = {
    "format": 1,
    "name": "meadow",
    "ticks": 12,
    "space": {"size": [10.0, 10.0]},
    "substances": {"nitrogen": "in proteins and in the soil"},
    "fields": {
        "soil": {"cell": 1.0, "depth": 0.1, "diffusion": 1e-3, "substance": "nitrogen", "initial": 0.004}
    },
    "species": {
        "vole": {
            "count": 20,
            "body": {"radius": 0.08, "opaque": False},
            "substances": {"nitrogen": 0.5},
            "metabolism": {"energy": 0.6, "energy_max": 1.0, "basal": 0.001},
            "exchange": [{"kind": "release", "substance": "nitrogen", "field": "soil", "rate": 0.02}],
            "lethal": [{"property": "age", "max": 500.0}],
        }
    },
}


def ledger(gap=0.0):
    """Two ticks of a vole that leaks into the soil, and rain."""
    rows = {
        "tick": [0, 0, 1, 1],
        "holder": ["vole", "soil"] * 2,
        "substance": ["nitrogen"] * 4,
        "stock_before": [4.0, 6.0, 3.0, 7.0],
        "released": [-1.0, 1.0, -1.0, 1.0],
        "brought_in": [0.0, 0.0, 0.0, 2.0],
        "stock_after": [3.0, 7.0, 2.0, 10.0 + gap],
    }
    return matter.ledger_of(pa.table(rows))


def test_a_ledger_that_closes_says_what_came_and_where_it_is():
    pages = ledger()
    assert pages.holders == ("vole", "soil")
    assert pages.flows == ("released", "brought_in")
    assert pages.stock[:, :, 0].tolist() == [[3, 7], [2, 10]]
    first, last = matter.told(pages)
    assert first == (
        "nitrogen: 10 mol at the start, 12 mol at the end (brought in +2); the largest share, 83%, is in soil."
    )
    assert "The matter ledger closes" in last


def test_a_gap_is_found_where_it_is():
    gap, share, tick = ledger(0.5).gap()
    assert (gap, tick) == (pytest.approx(0.5), 1)
    assert share == pytest.approx(0.5 / 12.5)
    assert "DOES NOT CLOSE" in matter.told(ledger(0.5))[-1]


def test_species_are_in_their_colour_and_others_hatched():
    figure = matter.stocks(ledger(), {"vole": "#123456"})
    vole, soil = figure.axes[0].collections
    assert vole.get_facecolor()[0] == pytest.approx([0x12 / 255, 0x34 / 255, 0x56 / 255, 1])
    assert (vole.get_hatch(), soil.get_hatch()) == (None, "//")
    assert figure.axes[0].get_ylabel() == "stock [mol]"


def test_report_and_why_show_matter_where_there_is_some(tmp_path):
    run_to_folder(MEADOW, seed=1, ticks=12, out=tmp_path / "run", report=False)
    pages = matter.read(tmp_path / "run")
    assert pages.stock[0].sum() == pytest.approx(pages.stock[-1].sum())
    assert np.diff(pages.stock[:, pages.holders.index("soil"), 0]).min() > 0
    page = write_report(tmp_path / "run").read_text()
    assert "<h2>Matter</h2>" in page
    assert (tmp_path / "run" / "figures" / "matter.svg").is_file()
    found = write_why(tmp_path / "run")
    assert found["matter"] == found["sentences"]["Matter"] == matter.told(pages)
    assert json.loads((tmp_path / "run" / "why.json").read_text())["matter"] == found["matter"]
    assert "<h2>Matter</h2>" in (tmp_path / "run" / "why.html").read_text()
