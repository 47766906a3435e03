"""Responses to values, hand-counted."""

from __future__ import annotations

import numpy as np
import pytest

from ecs_eco.analysis.seed_grid import mean_interval
from ecs_eco.analysis.survival import wilson
from ecs_eco.lab.response import Outcome, answers, interval, outcomes_of, responses, values_of
from ecs_eco.lab.table import _opening

N, KEPT = Outcome("moss.mean", "mean number of moss", "moss"), Outcome("persisted", "share", share=True)


def row(
    point: int,
    count: int,
    rate: float,
    seed: int,
    mean: float | None,
    kept: bool = True,
    training: int | None = None,
) -> dict[str, object]:
    return {
        "point": point,
        "count": count,
        "rate": rate,
        "treatment": "world",
        "world_seed": seed,
        "training_seed": training,
        "persisted": kept,
        "moss.mean": mean,
        "moss.period": None,
    }


ROWS = [
    row(0, 5, 0.1, 1, 10.0),
    row(0, 5, 0.1, 2, 14.0, kept=False),
    row(1, 5, 0.2, 1, 20.0),
    row(1, 5, 0.2, 2, 24.0),
    row(2, 9, 0.1, 1, 30.0),
    row(2, 9, 0.1, 2, None),
]


def test_an_answer_is_the_mean_over_seeds_of_the_means_over_all_else() -> None:
    five, nine = answers(ROWS, "count", N)
    assert (five.value, nine.value) == (5, 9)
    assert five.mean == mean_interval(np.array([[15.0, 19.0]]))  # (10 + 20) / 2, (14 + 24) / 2
    assert nine.mean.value == 30.0
    assert np.isnan(nine.mean.low)  # of one run
    assert five.runs == (10.0, 14.0, 20.0, 24.0)


def test_the_largest_clear_difference_opens_the_page_of_a_sweep() -> None:
    of_five, of_nine = (10.0, 12.0, 14.0), (30.0, 32.0, 34.0)
    rows = [row(0, 5, 0.1, seed, n) for seed, n in enumerate(of_five)]
    rows += [row(1, 9, 0.1, seed, n) for seed, n in enumerate(of_nine)]
    (said,) = _opening(rows, ["count"], [N, KEPT])
    assert said.startswith("count = 9 instead of 5: mean number of moss +20 (")
    assert said.endswith("), the largest of 2 differences relative to the mean.")
    same = [row(n, count, 0.1, seed, 7.0) for n, count in enumerate((5, 9)) for seed in range(3)]
    assert _opening(same, ["count"], [N, KEPT]) == [
        "No outcome differs clearly between the lowest and the highest value of a key."
    ]
    assert _opening(rows[1:], ["count"], [N]) == []  # two seeds are too few
    assert _opening(rows, ["rate"], [N]) == []  # it has one value
    frozen = [
        row(n, 5 + n, 0.1, seed, x - seed / 9) for n, x in ((0, -30.0), (1, 1 / 9)) for seed in range(3)
    ]
    (said,) = _opening(frozen, ["count"], [N])  # of below zero and of zero, as of a temperature in °C
    assert "mean number of moss +30.1 (" in said


def test_shares_have_wilsons_interval_and_stay_between_0_and_1() -> None:
    assert interval(ROWS[2:4], KEPT) == wilson(2, 2)
    mixed = interval(ROWS[:4], KEPT)  # seed 1: 1, seed 2: 1/2
    assert mixed.value == 0.75
    assert (mixed.low, mixed.high) == (0.0, 1.0)


def test_both_kinds_of_seeds_are_replicates() -> None:
    rows = [row(0, 5, 0.1, w, 10.0 * k + w, training=k) for k in (1, 2) for w in (1, 2)]
    assert interval(rows, N) == mean_interval(np.array([[11.0, 12.0], [21.0, 22.0]]))


def test_points_come_in_the_order_of_the_key() -> None:
    found = [(answer.value, answer.mean.value) for answer in answers(ROWS, "rate", N, "point")]
    assert found == [(0.1, 12.0), (0.1, 30.0), (0.2, 22.0)]
    assert values_of(ROWS, "rate") == [0.1, 0.2]
    assert values_of([{"x": "b"}, {"x": "a"}, {"x": [1]}], "x") == ["b", "a", [1]]


@pytest.mark.parametrize(
    ("column", "label"), [("energy.moss.mean", "mean energy of moss"), ("heat.mean", "mean heat")]
)
def test_what_reporters_measured_is_an_outcome(column: str, label: str) -> None:
    found = outcomes_of([ROWS[0] | {column: 1.0}], ["moss"])
    assert [o.column for o in found] == ["persisted", "moss.mean", column]
    assert found[-1].label == label


def test_axes_contain_all_intervals_of_all_columns() -> None:
    """An interval reaches below 0, and means in the second column are far above the means in the first."""
    rows = [
        row(0, 5, 0.1, 1, 0.0),
        row(0, 5, 0.1, 2, 14.0),
        row(1, 9, 0.2, 1, 90.0),
        row(1, 9, 0.2, 2, 500.0),
    ]
    figure = responses(rows, ["count", "rate"], [N], {})
    low, high = figure.axes[0].get_ylim()
    for ax in figure.axes:
        assert ax.get_ylim() == (low, high)
        assert low <= ax.dataLim.y0 < 0
        assert ax.dataLim.y1 <= high
    above = responses([row(0, 5, 0.1, s, 50.0 + s) for s in (1, 2)], ["count"], [N], {})
    assert above.axes[0].get_ylim()[0] == 0
