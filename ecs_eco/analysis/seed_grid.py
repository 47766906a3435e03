"""Training seed × world seed: how much of an outcome's variance each explains, and how precise estimates over both
are. A table (training seeds, world seeds) has one outcome per cell (0 or 1 for no or yes), NaN if missing. The
model is y = mean + training seed + world seed + rest (with their interaction): two crossed random effects."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any, Self

import numpy as np

from ecs_eco.analysis import quantiles
from ecs_eco.analysis.cycles import CycleStatistics, living_stretch
from ecs_eco.analysis.extinction import declines, lifetime
from ecs_eco.analysis.palette import AXIS, ON_CELL
from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.style import PALETTE, Figure, panels, styled
from ecs_eco.analysis.survival import (
    Interval,
    difference_of_intervals,
    kaplan_meier,
    survival_function,
    wilson,
)

EFFECTS = ("training seed", "world seed", "rest")


@dataclass(frozen=True)
class VarianceShares:
    """Variance components of a table and their shares, each in the order of EFFECTS."""

    n: int  # number of cells with an outcome
    mean: float
    variance: tuple[float, float, float]  # unbiased estimates; a negative value means no detectable effect
    share: tuple[Interval, Interval, Interval]  # negative components count as 0; NaN if nothing varies


def components(table: np.ndarray) -> np.ndarray:
    """Return the variance components of tables by the method of moments.

    Parameters
    ----------
    table : array of float, shape (…, training seeds, world seeds)
        NaN for missing runs.

    Returns
    -------
    array of float64, shape (3, …)
        Training seed, world seed and rest; NaN if a table has fewer than two rows or columns.

    Notes
    -----
    The sums of squares within rows, within columns and in total are equated to their expectations
    (Henderson's method I in the form of Gao and Owen 2017); for a table without gaps, this gives the
    estimates of a two-way analysis of variance. The estimates are unbiased, so a component near 0 is
    sometimes negative.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.seed_grid import components
    >>> components(np.array([[1.0, 1.0], [3.0, 3.0]]))[0].item()
    2.0
    """
    y = np.asarray(table, float)
    here = ~np.isnan(y)
    n = here.sum((-2, -1))
    row, column = here.sum(-1), here.sum(-2)
    v = np.where(here, y, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = v.sum((-2, -1)) / n
        # centering keeps the sums of squares accurate
        v = np.where(here, y - mean[..., None, None], 0.0)
        squares = (v**2).sum((-2, -1))
        within_rows = squares - (v.sum(-1) ** 2 / np.maximum(row, 1)).sum(-1)
        within_columns = squares - (v.sum(-2) ** 2 / np.maximum(column, 1)).sum(-1)
        b = within_rows / (n - (row > 0).sum(-1))  # world seed + rest
        a = within_columns / (n - (column > 0).sum(-1))  # training seed + rest
        a_times, b_times = n - (row**2).sum(-1) / n, n - (column**2).sum(-1) / n
        rest = (squares - a_times * a - b_times * b) / (n - 1 - a_times - b_times)
        return np.where(np.isfinite(rest), np.stack([a - rest, b - rest, rest]), np.nan)


def pigeonhole(table: np.ndarray, n_boot: int = 999, seed: int = 0) -> np.ndarray:
    """Return resampled tables whose rows and columns are drawn independently with replacement, (n_boot, rows,
    columns): the pigeonhole bootstrap (Owen 2007). No bootstrap of a crossed design is exact (McCullagh 2000);
    this one slightly overestimates the variance."""
    y = np.asarray(table, float)
    rng = np.random.default_rng(seed)
    rows, columns = (rng.integers(0, size, (n_boot, size)) for size in y.shape)
    return np.asarray(y[rows[:, :, None], columns[:, None, :]])


def variance_shares(
    table: np.ndarray, *, n_boot: int = 999, level: float = 0.95, seed: int = 0
) -> VarianceShares:
    """Return the shares of the variance due to training seeds, world seeds and the rest.

    Parameters
    ----------
    table : array of float, shape (training seeds, world seeds)
        The outcome of each run.
    n_boot : int, default 999
        Number of bootstrap samples.
    level : float, default 0.95
    seed : int, default 0
        Random seed for the bootstrap.

    Returns
    -------
    VarianceShares
        The shares, with percentile intervals from the pigeonhole bootstrap.

    Raises
    ------
    ValueError
        If the table has fewer than 2 training seeds or world seeds.

    Notes
    -----
    Rows and columns that are drawn twice shift variance from the rest to the seeds; the bootstrapped
    components are corrected for this. On simulated designs of 6 × 5 seeds, the intervals cover 96 to 100%;
    they are wide, because six seeds contain little information about a variance.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.seed_grid import variance_shares
    >>> table = np.array([[1.0, 1.1, 0.9], [5.0, 5.1, 4.9]])
    >>> variance_shares(table, n_boot=99).share[0].value > 0.9
    True
    """
    y = np.asarray(table, float)
    if y.ndim != 2 or min(y.shape) < 2:
        raise ValueError(
            "variance shares need at least 2 training seeds and 2 world seeds, "
            f"got a table of shape {y.shape}"
        )
    parts = components(y)
    drawn = _shares(_corrected(components(pigeonhole(y, n_boot, seed)), *y.shape))
    drawn = drawn[:, np.isfinite(drawn).all(0)]
    ends = np.full((2, 3), np.nan)
    if drawn.size:
        ends = np.quantile(drawn, [0.5 - level / 2, 0.5 + level / 2], axis=1)
    share = [Interval(*map(float, ends)) for ends in zip(_shares(parts), *ends, strict=True)]
    n = int((~np.isnan(y)).sum())
    return VarianceShares(n, float(np.nanmean(y)) if n else np.nan, tuple(map(float, parts)), tuple(share))  # type: ignore[arg-type]


def _corrected(drawn: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """Return components from the pigeonhole bootstrap, corrected so that their means equal the original ones."""
    rest = drawn[2] * rows * columns / ((rows - 1) * (columns - 1))
    training = drawn[0] * rows / (rows - 1) - rest / columns
    return np.stack([training, drawn[1] * columns / (columns - 1) - rest / rows, rest])


def _shares(variance: np.ndarray) -> np.ndarray:
    kept = np.maximum(variance, 0.0)
    total = kept.sum(0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(total > 1e-12, kept / total, np.nan)


def spread_of_mean(table: np.ndarray) -> tuple[float, float]:
    """Return the standard error of the mean of a table without gaps, and its degrees of freedom. With mean squares
    A for training seeds, B for world seeds and E for the rest, the variance of the mean is (A + B − E) / n, but
    never less than A / n or B / n; the degrees of freedom are Satterthwaite's for A + B. In a table with a
    single row or column, only the other factor counts."""
    y = np.asarray(table, float)
    rows, columns = y.shape
    mean, row, column = y.mean(), y.mean(1), y.mean(0)
    a = columns * ((row - mean) ** 2).sum() / (rows - 1) if rows > 1 else 0.0
    b = rows * ((column - mean) ** 2).sum() / (columns - 1) if columns > 1 else 0.0
    both = rows > 1 and columns > 1
    e = ((y - row[:, None] - column + mean) ** 2).sum() / ((rows - 1) * (columns - 1)) if both else 0.0
    parts = [m**2 / (k - 1) for m, k in ((a, rows), (b, columns)) if k > 1]
    df = (a + b) ** 2 / sum(parts) if a + b > 0 else float(max(rows, columns) - 1)
    return float(np.sqrt(max(a, b, a + b - e) / y.size)), float(df)


def mean_interval(table: np.ndarray, level: float = 0.95) -> Interval:
    """Return the mean of a table of outcomes, with an interval that accounts for shared seeds.

    Parameters
    ----------
    table : array of float, shape (training seeds, world seeds)
        Without gaps.
    level : float, default 0.95

    Returns
    -------
    Interval
        From Student's t; on simulated designs of 6 × 5 seeds, it covers 90 to 99%.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.seed_grid import mean_interval
    >>> mean_interval(np.array([[1.0, 2.0], [3.0, 4.0]])).value
    2.5
    """
    y = np.asarray(table, float)
    error, df = spread_of_mean(y)
    if df <= 0:
        return Interval(float(y.mean()), np.nan, np.nan)
    half = quantiles.student(df, level) * error
    return Interval(float(y.mean()), float(y.mean()) - half, float(y.mean()) + half)


def mean_of_known(table: np.ndarray) -> Interval:
    """Return `mean_interval`; known values of a table with gaps form one row, and without values, it is NaN."""
    known = table[np.isfinite(table)]
    rows = table if known.size == table.size else known[None]
    return mean_interval(rows) if known.size else Interval(np.nan, np.nan, np.nan)


def mean_of_seeds(values: np.ndarray) -> Interval | None:
    """Return `mean_interval` or, for a table with gaps, the interval over means of training (or world) seeds."""
    if np.isfinite(values).all():
        return mean_interval(values)
    rows = values if len(values) > 1 else values.T
    means = [float(np.nanmean(row)) for row in rows if np.isfinite(row).any()]
    return mean_interval(np.array([means])) if means else None


def effective_runs(table: np.ndarray, level: float = 0.95) -> float:
    """Return the number of independent runs as informative about a share as this table (Korn and Graubard 1998).

    Parameters
    ----------
    table : array, shape (training seeds, world seeds)
        Zeros and ones.
    level : float, default 0.95

    Returns
    -------
    float
        If all cells agree, there is no variance to estimate, and the number of training seeds is returned.

    Notes
    -----
    The variance of the share uses training seeds and world seeds as replicates; few degrees of freedom reduce
    the number by (z / t)².

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.seed_grid import effective_runs
    >>> effective_runs(np.ones((3, 4)))
    3.0
    """
    y = np.asarray(table, float)
    error, df = spread_of_mean(y)
    share = float(y.mean())
    if share in (0.0, 1.0) or df <= 0:
        return float(y.shape[0])
    n = min(share * (1 - share) / error**2, float(y.size)) if error > 0 else float(y.size)
    return float(n * (quantiles.normal(level) / quantiles.student(df, level)) ** 2)


def share_interval(table: np.ndarray, level: float = 0.95) -> Interval:
    """Return the share of ones in a table of zeros and ones, with an interval that accounts for shared seeds.

    Parameters
    ----------
    table : array, shape (training seeds, world seeds)
    level : float, default 0.95

    Returns
    -------
    Interval
        The share, with Wilson's interval for the effective number of runs (Korn and Graubard 1998).

    Notes
    -----
    On simulated designs of 6 × 5 seeds, the interval covers 96 to 99%, whichever seed matters; Wilson's
    interval for 30 supposedly independent runs covers as little as 66%.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.seed_grid import share_interval
    >>> share_interval(np.array([[1, 1, 0], [1, 0, 0]])).value
    0.5
    """
    y = np.asarray(table, float)
    n = effective_runs(y, level)
    return wilson(float(y.mean()) * n, n, level)


def share_difference(one: np.ndarray, other: np.ndarray, level: float = 0.95) -> Interval:
    """Return the difference between the shares of ones in two tables, with Newcombe's interval from both
    `share_interval` results.

    Parameters
    ----------
    one, other : array, shape (training seeds, world seeds)
        Zeros and ones.
    level : float, default 0.95

    Returns
    -------
    Interval
        Unlike Student's t over seeds, it never reaches beyond −1 or 1 (Newcombe 1998, method 10).

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.seed_grid import share_difference
    >>> share_difference(np.array([[1, 1], [1, 0]]), np.array([[0, 0], [1, 0]])).value
    0.5
    """
    return difference_of_intervals(share_interval(one, level), share_interval(other, level))


@dataclass(frozen=True)
class Grid:
    """Runs arranged by seed: `runs[i][j]` has the seeds `training[i]` and `worlds[j]`."""

    training: tuple[int, ...]
    worlds: tuple[int, ...]
    runs: tuple[tuple[Series, ...], ...]

    @classmethod
    def of(cls, runs: Sequence[Series], training: Sequence[int], worlds: Sequence[int]) -> Self:
        """Arrange runs by seed.

        Parameters
        ----------
        runs : sequence of Series
        training : sequence of int
            Training seed of each run.
        worlds : sequence of int
            World seed of each run.

        Returns
        -------
        Grid

        Raises
        ------
        ValueError
            If a combination of seeds has no run or more than one.
        """
        cells: dict[tuple[int, int], Series] = {}
        for run, a, b in zip(runs, training, worlds, strict=True):
            if (a, b) in cells:
                raise ValueError(f"training seed {a}, world seed {b} occurs twice: expected one run per cell")
            cells[a, b] = run
        rows, columns = sorted(set(training)), sorted(set(worlds))
        if gap := next((cell for cell in product(rows, columns) if cell not in cells), None):
            fault = f"training seed {gap[0]}, world seed {gap[1]} has no run"
            raise ValueError(f"{fault}: the design must be complete")
        return cls(tuple(rows), tuple(columns), tuple(tuple(cells[a, b] for b in columns) for a in rows))

    @property
    def length(self) -> float:
        """Length of the longest run [ticks]."""
        return float(max(run.length for row in self.runs for run in row))

    def lifetimes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the ticks to each run's first extinction, or the run's length, and whether there was one."""
        died = self.table(lambda run: lifetime(run)[1])
        return self.table(lambda run: lifetime(run)[0]), died.astype(bool)

    def table(self, value: Callable[[Series], float]) -> np.ndarray:
        """Return a value for each run.

        Parameters
        ----------
        value : callable
            Function that returns a number for a `Series`.

        Returns
        -------
        array of float64, shape (training seeds, world seeds)
        """
        return np.array([[value(run) for run in row] for row in self.runs], float)


def outcomes(grid: Grid, cycles: Mapping[int, CycleStatistics] | None = None) -> dict[str, np.ndarray]:
    """Return tables of outcomes: whether all species persisted, log time to the first extinction (or the end of the
    run), log period, and mean log number of each species, after the first tenth of the run and before the first
    extinction. `cycles` contains the statistics of each run, by `id(run)`."""
    names = grid.runs[0][0].species
    tables = {
        "persisted": grid.table(lambda run: run.persisted),
        "log time to first extinction": grid.table(lambda run: np.log(max(lifetime(run)[0], 1.0))),
    }
    if cycles is not None:
        periods = {run: of.period if of.cycling() else None for run, of in cycles.items()}
        tables["log period"] = grid.table(lambda run: np.log(periods[id(run)] or np.nan))
    return tables | {f"mean log number of {s}": grid.table(partial(_mean_log, species=s)) for s in names}


def _mean_log(run: Series, species: str) -> float:
    if not run.present[run.index(species)]:
        return np.nan
    n = living_stretch(run)[:, run.there.index(species)]
    return float(np.log1p(n).mean()) if len(n) else np.nan


def survival_band(
    grid: Grid, level: float = 0.95, n_boot: int = 499, seed: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a pigeonhole-bootstrap band for the Kaplan–Meier curve of first extinctions: times, low, high."""
    lived, died = grid.lifetimes()
    time = kaplan_meier(lived.ravel(), died.ravel()).time
    cells = pigeonhole(np.arange(lived.size).reshape(lived.shape), n_boot, seed).astype(int)
    drawn = [
        survival_function(lived.ravel()[some], died.ravel()[some]).evaluate(time)
        for some in cells.reshape(n_boot, -1)
    ]
    low, high = np.quantile(drawn, [0.5 - level / 2, 0.5 + level / 2], axis=0)
    return time, low, high


def crossed(
    grid: Grid, cycles: Mapping[int, CycleStatistics] | None = None, *, n_boot: int = 999, seed: int = 0
) -> dict[str, Any]:
    """Summarize a grid: the share that persisted, in total and by training seed, and all variance shares."""
    tables = outcomes(grid, cycles)
    kept = tables["persisted"]
    shares = {}
    if min(kept.shape) > 1:
        for name, table in tables.items():
            if np.isfinite(table).sum() > max(table.shape):
                parts = variance_shares(table, n_boot=n_boot, seed=seed)
                shares[name] = {
                    "n": parts.n,
                    "mean": parts.mean,
                    "variance": dict(zip(EFFECTS, parts.variance, strict=True)),
                    "share": dict(zip(EFFECTS, parts.share, strict=True)),
                }
    return {
        "training_seeds": list(grid.training),
        "world_seeds": list(grid.worlds),
        "persistence": share_interval(kept),
        "effective_runs": effective_runs(kept),
        "persisted_by_training_seed": dict(zip(grid.training, kept.sum(1).astype(int).tolist(), strict=True)),
        "lifetimes": grid.lifetimes()[0],
        "persisted": kept.astype(int),
        "variance_shares": shares,
    }


@styled
def persistence(grid: Grid, title: str = "") -> Figure:
    """Plot the fraction of runs with all species (Kaplan–Meier): all runs (thick), each training seed (thin)."""
    figure, ((ax,),) = panels(1, 1, 7, 3.4)
    lived, died = grid.lifetimes()
    until = grid.length
    time, low, high = survival_band(grid)
    time, low, high = np.append(time, until), np.append(low, low[-1]), np.append(high, high[-1])
    ax.fill_between(time, low, high, step="post", color=PALETTE[2], alpha=0.15, lw=0)
    for k, (t, d) in enumerate(zip([*lived, lived.ravel()], [*died, died.ravel()], strict=True)):
        curve, whole = kaplan_meier(t, d), k == len(lived)
        shift = 0.0 if whole else 0.006 * (k - (len(lived) - 1) / 2)  # separates identical curves
        share = np.append(curve.survival, curve.survival[-1]) + shift
        label = f"all {lived.size} runs" if whole else "one training seed" if k == 0 else None
        style = {"color": PALETTE[2] if whole else AXIS, "lw": 2.4 if whole else 0.8, "label": label}
        ax.step(np.append(curve.time, until), share, where="post", **style)
    ax.set(
        xlim=(0, until), ylim=(-0.04, 1.06), xlabel="tick", ylabel="fraction with all species", title=title
    )
    ax.legend(loc="lower left" if curve.survival[-1] > 0.4 else "upper right")
    return figure


@styled
def lifetimes(grid: Grid, title: str = "") -> Figure:
    """Plot the time to the first extinction, if any, by training seed (rows) and world seed (columns)."""
    rows, columns = len(grid.training), len(grid.worlds)
    figure, ((ax,),) = panels(1, 1, 2.4 + 1.05 * columns, 1.5 + 0.52 * rows)
    lived, _ = grid.lifetimes()
    top = max(grid.length, 1.0)
    image = ax.imshow(lived, cmap="cividis", vmin=0, vmax=top, aspect="auto")
    for i in range(rows):
        for j in range(columns):
            first = declines(grid.runs[i][j])[:1]
            text = f"{first[0].tick:,}\n{first[0].species}" if first else "all persist"
            color = ON_CELL[bool(lived[i, j] > 0.55 * top)]
            ax.text(j, i, text, ha="center", va="center", fontsize=9, color=color)
    for edge in range(1, rows):
        ax.axhline(edge - 0.5, color="white", lw=1.2)
    for edge in range(1, columns):
        ax.axvline(edge - 0.5, color="white", lw=1.2)
    ax.set(xlabel="world seed", ylabel="training seed", title=title)
    ax.set_xticks(range(columns), [str(s) for s in grid.worlds])
    ax.set_yticks(range(rows), [str(s) for s in grid.training])
    ax.grid(visible=False)
    figure.colorbar(image, ax=ax, label="tick of the first extinction", pad=0.02, format="{x:,.0f}")
    return figure
