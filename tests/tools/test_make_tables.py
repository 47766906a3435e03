"""The page of speed: costs are fitted as by hand, the chart shows every peer, and each attempt stands once."""

import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import cost
import make_tables
import peers_chart
import speed_goals

SPEEDS = {"bare loop": 1000.0, "ecs-eco": 2000.0, "mesa-frames": 100.0, "Mesa": 2.0, "AgentPy": None}
PEERS = [
    {
        "peer": peer,
        "task": "common",
        "animals": 10,
        "k organism-steps/s": speed,
        "note": "given up" * (not speed),
    }
    for peer, speed in SPEEDS.items()
]


def test_a_cost_is_the_line_through_totals():
    assert cost.fit([10, 100, 1000], [2 + 0.3 * n for n in (10, 100, 1000)]) == pytest.approx((2, 0.3, 0))
    assert cost.Cost(2.0, 0.3, 0.0).at(20) == 8


def test_errors_of_a_cost_are_relative():
    # by hand: totals 1 and 3 at the same n are fitted by (1 + 1/3) / (1 + 1/9) = 1.2: 20% over, 60% under
    fitted = cost.fit([1, 1], [1, 3])
    assert fitted.at(1) == pytest.approx(1.2)
    assert fitted.error == pytest.approx(0.6)


def test_the_rule_of_thumb_is_within_its_error_of_what_was_measured():
    for name, (result, organisms, wanted, _) in cost.FITS.items():
        fitted = cost.of_ticks(name)
        for row in cost.rows_of(result):
            if wanted.items() <= row.items():
                ns = row[f"ns per {organisms[:-1]} per tick"]
                measured = row[organisms] * ns * 1e-6
                assert abs(fitted.at(row[organisms]) / measured - 1) <= fitted.error + 1e-9


def test_a_goal_for_a_note_is_in_percent():
    goal, result = {"note": "median overhead"}, {"notes": {"median overhead": 0.0446}, "rows": []}
    assert speed_goals.goal_number(goal, result, "row", "now") == pytest.approx(4.46)
    assert speed_goals.goal_number(goal, result, "row_before", "now") is None


def test_bars_are_as_long_as_the_logarithm_of_speeds_and_the_slowest_is_last():
    root = ET.fromstring(peers_chart.chart(PEERS, 10))
    words = [e.text for e in root.iter("{http://www.w3.org/2000/svg}text")]
    assert [w for w in words if w in peers_chart.NAMES.values()] == [
        "ecs-eco",
        "compiled loop",
        "mesa-frames",
        "Mesa",
        "AgentPy",
    ]
    assert words[-1] == "given up"
    assert "2,000,000" in words
    widths = [float(e.get("width")) for e in root.iter("{http://www.w3.org/2000/svg}rect")][1:]
    assert widths[0] - widths[3] == pytest.approx(3 * (peers_chart.at(1e4) - peers_chart.at(1e3)), abs=0.1)


def test_the_ratio_of_peers_has_two_digits():
    assert make_tables.times(PEERS, "ecs-eco", "Mesa", 10) == "1,000"
    assert make_tables.times(PEERS, "bare loop", "ecs-eco", 10) == "0.5"


def test_the_notes_have_every_result_and_each_attempt_once():
    notes = make_tables.NOTES.read_text(encoding="utf-8")
    results = make_tables.read()
    for name, result in results.items():
        assert f"## {make_tables.heading(name, result)}\n" in notes
        assert f"({name})" in notes
    assert len({make_tables.heading(*of) for of in results.items()}) == len(results)
    tried = [what for attempts in make_tables.ADDED["attempts"].values() for what in attempts]
    assert len(tried) > 40
    assert all(notes.count(f"- {what}: ") == 1 for what in tried)
    assert not re.search(r"^- tried", notes, re.MULTILINE)


def test_the_page_is_short_and_its_chart_small():
    assert len(make_tables.PAGE.read_text(encoding="utf-8").split()) < 800
    assert make_tables.CHART.stat().st_size < 100_000
