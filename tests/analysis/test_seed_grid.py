"""Crossed designs: variance components counted by hand, known shares recovered, and intervals that cover."""

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from ecs_eco.analysis.compare import compare
from ecs_eco.analysis.runs import Series, load_series
from ecs_eco.analysis.seed_grid import (
    Grid,
    components,
    crossed,
    effective_runs,
    mean_interval,
    pigeonhole,
    share_interval,
    spread_of_mean,
    survival_band,
    variance_shares,
)
from ecs_eco.analysis.survival import wilson

chains = SimpleNamespace(**runpy.run_path(str(Path(__file__).with_name("chains.py"))))


def simulated(
    rng: np.random.Generator, n: int, rows: int, columns: int, by_row: float, by_column: float
) -> np.ndarray:
    """Tables (n, rows, columns) of variance 1 with known shares of rows and columns."""
    row, column = rng.standard_normal((n, rows, 1)), rng.standard_normal((n, 1, columns))
    rest = rng.standard_normal((n, rows, columns))
    return np.sqrt(by_row) * row + np.sqrt(by_column) * column + np.sqrt(1 - by_row - by_column) * rest


def test_the_components_of_a_small_table_are_those_counted_by_hand() -> None:
    # [[1, 2], [3, 6]]: mean squares 9 of rows, 4 of columns, 1 of the rest; (9 − 1) / 2, (4 − 1) / 2, 1
    assert components(np.array([[1.0, 2.0], [3.0, 6.0]])) == pytest.approx([4.0, 1.5, 1.0])
    # rows that differ, columns that do not: mean squares 3 × 2, 0 and 0
    assert components(np.array([[0.0, 0.0, 0.0], [2.0, 2.0, 2.0]])) == pytest.approx([2.0, 0.0, 0.0])


def test_a_gap_leaves_what_the_sums_of_squares_say() -> None:
    # 1 2 / 3 ·: within rows .5 of one degree (world + rest .5), within columns 2 of one (training + rest 2),
    # in all 2. In all expects 4/3 a + 4/3 b + 2 e; with a = 2 − e, b = .5 − e: 10/3 − 2/3 e = 2, e = 2.
    assert components(np.array([[1.0, 2.0], [3.0, np.nan]])) == pytest.approx([0.0, -1.5, 2.0])


def test_known_shares_are_recovered() -> None:
    tables = simulated(np.random.default_rng(0), 4000, 6, 5, 0.5, 0.2)
    assert components(tables).mean(1) == pytest.approx([0.5, 0.2, 0.3], abs=0.02)
    tables[:, 2, 3] = tables[:, 0, 1] = np.nan
    assert components(tables).mean(1) == pytest.approx([0.5, 0.2, 0.3], abs=0.02)
    large = variance_shares(simulated(np.random.default_rng(1), 1, 60, 50, 0.5, 0.2)[0], n_boot=99)
    assert [s.value for s in large.share] == pytest.approx([0.5, 0.2, 0.3], abs=0.1)


def test_shares_add_up_and_negative_components_count_as_none() -> None:
    table = np.array([[0.0, 1.0], [1.0, 0.0]])  # all interaction: components −.5, −.5, 1
    shares = variance_shares(table, n_boot=99)
    assert shares.variance == pytest.approx((-0.5, -0.5, 1.0))
    assert [s.value for s in shares.share] == [0.0, 0.0, 1.0]
    assert np.isnan([s.value for s in variance_shares(np.ones((3, 2)), n_boot=9).share]).all()


def test_a_pigeonhole_draw_keeps_rows_and_columns_together() -> None:
    table = np.add.outer(10 * np.arange(4), np.arange(3)).astype(float)
    drawn = pigeonhole(table, 50)
    assert drawn.shape == (50, 4, 3)
    assert (drawn // 10 == drawn[:, :, :1] // 10).all()
    assert (drawn % 10 == drawn[:, :1] % 10).all()
    assert len(np.unique(drawn[:, :, 0])) > 4


def test_intervals_of_variance_shares_cover_the_truth() -> None:
    rng = np.random.default_rng(3)
    for by_row, by_column in ((0.5, 0.1), (0.1, 0.5)):
        tables = simulated(rng, 150, 6, 5, by_row, by_column)
        estimates = [variance_shares(table, n_boot=199, seed=k).share for k, table in enumerate(tables)]
        ends = np.array([[(s.low, s.high) for s in shares] for shares in estimates])
        truth = np.array([by_row, by_column, 1 - by_row - by_column])
        covered = ((ends[..., 0] <= truth) & (truth <= ends[..., 1])).mean(0)
        assert (covered >= 0.9).all(), covered
        assert (np.diff(ends, axis=-1)[..., 0].mean(0) < 0.9).all()


def test_the_interval_of_a_share_covers_where_wilson_does_not() -> None:
    """Four of five training seeds are good: 30 runs are not 30 independent ones."""
    kept = simulated(np.random.default_rng(4), 1500, 6, 5, 0.95, 0.0) < norm.ppf(0.8)
    ends = np.array([share_interval(table)[1:] for table in kept])
    naive = np.array([wilson(int(table.sum()), 30)[1:] for table in kept])
    covered = [((x[:, 0] <= 0.8) & (x[:, 1] >= 0.8)).mean() for x in (ends, naive)]
    assert covered[0] >= 0.94
    assert covered[1] < 0.75


def test_the_interval_of_a_mean_covers() -> None:
    tables = simulated(np.random.default_rng(5), 1000, 6, 5, 0.4, 0.2)
    ends = np.array([mean_interval(table)[1:] for table in tables])
    assert 0.9 <= ((ends[:, 0] <= 0) & (ends[:, 1] >= 0)).mean() <= 0.99


def test_the_spread_of_a_mean_is_that_counted_by_hand() -> None:
    # mean squares 9, 4, 1 of [[1, 2], [3, 6]]: variance (9 + 4 − 1) / 4, degrees of freedom 13² / (81 + 16)
    assert spread_of_mean(np.array([[1.0, 2.0], [3.0, 6.0]])) == pytest.approx((np.sqrt(3), 169 / 97))
    # one row: the columns alone, variance 2 of the mean 2 over three
    assert spread_of_mean(np.array([[0.0, 2.0, 4.0]])) == pytest.approx((np.sqrt(4 / 3), 2))


def test_effective_runs_fall_to_the_training_seeds_where_all_hangs_on_them() -> None:
    assert effective_runs(np.ones((6, 5))) == 6
    assert share_interval(np.ones((6, 5))) == pytest.approx(wilson(6, 6))
    by_row = np.repeat([[1.0], [1.0], [1.0], [0.0]], 50, axis=1)
    alone = np.random.default_rng(0).permuted(by_row.ravel()).reshape(4, 50)
    assert effective_runs(by_row) < 4 < 20 < effective_runs(alone) < 200


def runs(lost: dict[tuple[int, int], int], ticks: int = 400) -> tuple[list[Series], list[int], list[int]]:
    """Runs of 3 training seeds × 2 world seeds; wolves end at the tick told."""
    collected: list[Series] = []
    seeds = [(a, b) for a in (7, 8, 9) for b in (1, 2)]
    for a, b in seeds:
        n = chains.chain(ticks, 10 * a + b)
        n[lost.get((a, b), ticks + 1) - 1 :, 2] = 0
        series = load_series(chains.series_table(n, b))
        collected.append(Series(series.ticks, series.species, series.columns, {"seed": b}))
    return collected, [a for a, _ in seeds], [b for _, b in seeds]


def test_a_grid_holds_every_run_in_its_place() -> None:
    members, training, worlds = runs({(8, 1): 101, (8, 2): 201})
    grid = Grid.of(members[::-1], training[::-1], worlds[::-1])
    assert (grid.training, grid.worlds) == ((7, 8, 9), (1, 2))
    summary = crossed(grid, n_boot=49)
    assert summary["persisted"].tolist() == [[1, 1], [0, 0], [1, 1]]
    assert summary["lifetimes"].tolist() == [[400, 400], [100, 200], [400, 400]]
    assert summary["persisted_by_training_seed"] == {7: 2, 8: 0, 9: 2}
    assert summary["variance_shares"]["persisted"]["share"]["training seed"].value == pytest.approx(1.0)
    time, low, high = survival_band(grid, n_boot=99)
    assert time.tolist() == [0, 100, 200]
    assert (low[0], high[0], low[2], high[2]) == (1.0, 1.0, 0.0, 1.0)


def test_a_grid_with_a_gap_or_a_run_twice_is_refused() -> None:
    members, training, worlds = runs({})
    with pytest.raises(ValueError, match="training seed 9, world seed 2 has no run"):
        Grid.of(members[:-1], training[:-1], worlds[:-1])
    with pytest.raises(ValueError, match="training seed 7, world seed 1 occurs twice"):
        Grid.of([*members, members[0]], [*training, 7], [*worlds, 1])
    with pytest.raises(ValueError, match="at least 2 training seeds"):
        variance_shares(np.ones((1, 5)))


@pytest.mark.slow
def test_a_crossed_comparison_opens_with_who_persisted_and_tells_the_variance(tmp_path: Path) -> None:
    members, training, _ = runs({(8, 1): 101, (8, 2): 201})
    alone = runs({(7, 1): 51, (7, 2): 61})[0][:2]
    words = {"world": "policies trained"}
    comparison = compare(
        {"world": members, "random": alone}, tmp_path, n_boot=99, training={"world": training}, policies=words
    )
    arm = comparison["arms"]["world"]
    sentence = comparison["opening"]["world"]
    assert sentence.startswith(
        "All species persisted in 4 of 6 runs (67%). wolf died out in 2 of 6, at ticks 100 to 200 ("
    )
    assert arm["persistence"] == pytest.approx(list(share_interval(np.array([[1, 1], [0, 0], [1, 1]]))))
    assert arm["crossed"]["world_seeds"] == [1, 2]
    assert comparison["effects"]["random"]["persistence"][0] == pytest.approx(-2 / 3)
    page = (tmp_path / "compare.html").read_text()
    assert page.index("All species persisted in 4 of 6 runs (67%)") < page.index("<h2>")
    assert "world: 3 training seeds × 2 world seeds" in page
    assert "world runs with policies trained." in page
    assert {"persistence_world.svg", "first_extinction_world.svg"} <= {
        p.name for p in (tmp_path / "figures").iterdir()
    }
