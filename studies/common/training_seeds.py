"""Statistics over training seeds: means over world seeds, intervals, contrasts, shares of runs, and their
formatting as text."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ecs_eco.analysis.rhythm import Cosinor
from ecs_eco.analysis.seed_grid import share_difference, share_interval
from studies.common.study import verdict


def interval(values: list[float]) -> list[float]:
    """Return the mean over training seeds with its 95% Student's t interval: [mean, low, high]; a single
    value has no interval."""
    from scipy.stats import t

    mean, n = float(np.mean(values)), len(values)
    half = float(t.ppf(0.975, n - 1) * np.std(values, ddof=1) / np.sqrt(n)) if n > 1 else float("nan")
    return [round(mean, 3), round(mean - half, 3), round(mean + half, 3)]


def contrast(a: list[float], b: list[float]) -> tuple[list[float], float]:
    """Return the difference between the means of two sets of training seeds, with its 95% interval and
    one-sided p from Welch's t-test."""
    from scipy.stats import ttest_ind

    gap = round(float(np.mean(a) - np.mean(b)), 3)
    if min(len(a), len(b)) < 2:
        return [gap, float("nan"), float("nan")], float("nan")
    test = ttest_ind(a, b, equal_var=False)
    low, high = test.confidence_interval(0.95)
    p = float(test.pvalue) / 2 if test.statistic > 0 else 1 - float(test.pvalue) / 2
    return [gap, round(float(low), 3), round(float(high), 3)], p


def seed_table(lives: Sequence[Mapping[str, Any]], outcome: str) -> np.ndarray:
    """Return an outcome by training seed and world seed; NaN for missing runs."""
    rows, columns = (sorted({life[key] for life in lives}) for key in ("training", "seed"))
    table = np.full((len(rows), len(columns)), np.nan)
    for life in lives:
        table[rows.index(life["training"]), columns.index(life["seed"])] = life[outcome]
    return table


def share_of_lives(lives: Sequence[Mapping[str, Any]], outcome: str) -> list[float]:
    """Return the share of runs with an outcome and its 95% interval (Wilson, with the effective number of
    runs); training and world seeds are both replicates. Values are rounded, so that 15 of 16 is 0.9375."""
    return [round(v, 12) for v in share_interval(seed_table(lives, outcome))]


def share_gap(
    one: Sequence[Mapping[str, Any]], other: Sequence[Mapping[str, Any]], outcome: str
) -> list[float]:
    """Return the difference between two shares of runs and its 95% interval (Newcombe, with the effective
    numbers of runs)."""
    return list(share_difference(seed_table(one, outcome), seed_table(other, outcome)))


def in_words(interval_: list[float], n: int, p: float | None = None) -> str:
    """Return an interval, the number of training seeds, and p as text."""
    words = (
        f"{interval_[0]:.3g}"
        + (f" ({interval_[1]:.3g} … {interval_[2]:.3g})" if np.isfinite(interval_[1]) else "")
        + f", {n} training seeds"
    )
    return words if p is None else f"{words}, p = {p:.2g}"


def none(arm: str) -> dict[str, Any]:
    """Return the verdict on an arm without measurable runs."""
    return verdict(f"`{arm}`: runs with a measurable outcome", 0, "some", False)


def by_training(cases: list[dict[str, Any]], arm: str, value: Any) -> list[float]:
    """Return a value's mean over world seeds, by training seed; missing values are omitted."""
    values: dict[int, list[float]] = {}
    for c in cases:
        if c["case"]["arm"] == arm and (v := value(c["result"])) is not None and np.isfinite(v):
            values.setdefault(c["case"]["training"], []).append(float(v))
    return [float(np.mean(v)) for _, v in sorted(values.items())]


def swing(result: dict[str, Any]) -> float | None:
    """Return the daily amplitude as a share of the water's depth, positive if the animals are deepest around
    noon."""
    return None if result["cycle"] is None else result["cycle"]["vector"][0]


def p_common_phase(fits: Sequence[Cosinor], n: int = 9999, seed: int = 1) -> float:
    """Return the probability that runs with random phases have a mean vector of at least this length; runs
    are the replicates, and the result is at least 1/(n + 1)."""
    vectors = np.array([f.vector for f in fits])
    angle = np.random.default_rng(seed).uniform(0, 2 * np.pi, (n, len(fits)))
    length, turn = np.hypot(*vectors.T), np.arctan2(vectors[:, 1], vectors[:, 0])
    chance = np.hypot((length * np.cos(turn + angle)).mean(1), (length * np.sin(turn + angle)).mean(1))
    return float((1 + (chance >= np.hypot(*vectors.mean(0)) - 1e-12).sum()) / (n + 1))
