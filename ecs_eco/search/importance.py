"""Which numbers decide whether a candidate is among the best: PED-ANOVA (Watanabe, Bansal and Hutter 2023),
from Optuna. A number is important if the best are distributed over its range differently from all; shuffled
merits tell how large that difference is by chance."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import rankdata

if TYPE_CHECKING:
    from optuna.distributions import BaseDistribution

BEST_SHARE, LEAST_BEST = 0.1, 5  # the best tenth, but at least five candidates
SHUFFLES = 40


@dataclass(frozen=True)
class Importance:
    """A number's share of all importance, and the share that it stays below by luck in 19 of 20 cases."""

    name: str
    share: float
    by_chance: float


def importances(
    space: Mapping[str, BaseDistribution],
    values: Sequence[Mapping[str, float]],
    merits: Sequence[float],
    seed: int = 0,
) -> list[Importance]:
    """The importance of each number of a space, from the candidates' values and merits (more is better)."""
    y, rng = np.asarray(merits, float), np.random.default_rng(seed)
    own = _divergences(space, values, y)
    shuffled = np.array([_divergences(space, values, rng.permutation(y)) for _ in range(SHUFFLES)])
    total = own.sum() or 1.0
    limit = np.quantile(shuffled, 0.95, axis=0) / total
    return [
        Importance(name, *map(float, pair))
        for name, pair in zip(space, zip(own / total, limit, strict=True), strict=True)
    ]


def _divergences(
    space: Mapping[str, BaseDistribution], values: Sequence[Mapping[str, float]], merits: np.ndarray
) -> np.ndarray:
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    best = min(max(BEST_SHARE, LEAST_BEST / len(merits)), 0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Optuna warns that it is experimental
        study = optuna.create_study(direction="maximize")
        study.add_trials(
            [
                optuna.trial.create_trial(params=dict(v), distributions=dict(space), value=m)
                for v, m in zip(values, merits.tolist(), strict=True)
            ]
        )
        shares = optuna.importance.PedAnovaImportanceEvaluator(target_quantile=best).evaluate(study)
    return np.array([shares[name] for name in space])


def ranks(merits: Sequence[float]) -> np.ndarray:
    """The share of candidates that are worse, in (0, 1), whatever the scale of the objective."""
    return (rankdata(merits) - 0.5) / len(merits)
