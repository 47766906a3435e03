"""Candidates proposed by Optuna's samplers through an ask-and-tell interface."""

import logging
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import rankdata

from ecs_eco.lab.searching.plan import Parameter

OPTIMISERS = (
    "gp",
    "tpe",
    "random",
)  # samplers whose proposals depend only on the journal; CMA-ES has additional state
FIRST = 10  # number of random candidates before the first model


def merit(entry: dict[str, Any]) -> float:
    """Return the merit of a candidate: the stage that it reached, plus its score there mapped to [0, 1]."""
    score = float(entry["score"])
    return float(entry["stage"]) + 0.5 * (1 + score / (1 + abs(score)))


def _optuna() -> Any:
    """Return Optuna without its log; only searches need it, and it takes a second to import."""
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    logging.getLogger("optuna").propagate = False
    return optuna


def space_of(parameters: Sequence[Parameter]) -> dict[str, Any]:
    """Return the ranges as Optuna distributions, by name."""
    kinds = _optuna().distributions
    return {
        p.name: kinds.IntDistribution(int(p.low), int(p.high), log=p.log)
        if p.whole
        else kinds.FloatDistribution(p.low, p.high, log=p.log)
        for p in parameters
    }


class Optimiser:
    """Proposes parameter values within the ranges; proposals depend only on the seed and the history."""

    def __init__(self, parameters: Sequence[Parameter], kind: str, seed: int) -> None:
        self.parameters, self.kind, self.seed = parameters, kind, seed
        self.study = _optuna().create_study(direction="maximize", sampler=self._sampler(0))
        self.waiting: dict[int, Any] = {}
        self.space = space_of(parameters)

    def ask(self, candidate: int) -> dict[str, float]:
        if self.kind in OPTIMISERS:
            self.study.sampler = self._sampler(candidate)
        with warnings.catch_warnings(action="ignore"):
            trial = self.study.ask(self.space)
        self.waiting[candidate] = trial
        return {p.name: p.tidy(trial.params[p.name]) for p in self.parameters}

    def tell(self, candidate: int, values: dict[str, float], worth: float) -> None:
        """Report the merit of a candidate, whether or not it was proposed here."""
        with warnings.catch_warnings(action="ignore"):
            if candidate in self.waiting:  # replaced by a trial with rounded values, as in the journal
                self.study.tell(self.waiting.pop(candidate), state=_optuna().trial.TrialState.FAIL)
            inside = {p.name: p.tidy(values[p.name]) for p in self.parameters}
            self.study.add_trial(
                _optuna().trial.create_trial(params=inside, distributions=self.space, value=worth)
            )

    def _sampler(self, candidate: int) -> Any:
        samplers = _optuna().samplers
        first = {"n_startup_trials": FIRST}
        kind, options = {
            "gp": (samplers.GPSampler, first | {"deterministic_objective": False}),
            "tpe": (samplers.TPESampler, first | {"multivariate": True, "constant_liar": True}),
            "cmaes": (samplers.CmaEsSampler, first),
        }.get(self.kind, (samplers.RandomSampler, {}))
        with warnings.catch_warnings(action="ignore"):  # Optuna warns that some options are experimental
            return kind(seed=(self.seed * 1_000_003 + candidate) % 2**32, **options)


BEST_SHARE, LEAST_BEST = 0.1, 5  # the best tenth, but at least five candidates
SHUFFLES = 40


def importances(
    space: Mapping[str, Any], values: Sequence[Mapping[str, float]], merits: Sequence[float], seed: int = 0
) -> dict[str, dict[str, float]]:
    """Return each parameter's "share" of total importance, from the candidates' values and merits, and the share
    exceeded "by_chance" in 1 of 20 cases."""
    y, rng = np.asarray(merits, float), np.random.default_rng(seed)
    own = _divergences(space, values, y)
    shuffled = np.array([_divergences(space, values, rng.permutation(y)) for _ in range(SHUFFLES)])
    total = own.sum() or 1.0
    limits = np.quantile(shuffled, 0.95, axis=0)
    both = (np.array([own, limits]) / total).T.tolist()
    return {name: {"share": a, "by_chance": b} for name, (a, b) in zip(space, both, strict=True)}


def _divergences(
    space: Mapping[str, Any], values: Sequence[Mapping[str, float]], merits: np.ndarray
) -> np.ndarray:
    optuna = _optuna()
    best = min(max(BEST_SHARE, LEAST_BEST / len(merits)), 0.5)
    with warnings.catch_warnings(action="ignore"):  # Optuna warns that it is experimental
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
    """Return, for each candidate, the share of candidates that are worse, in (0, 1)."""
    return (rankdata(merits) - 0.5) / len(merits)
