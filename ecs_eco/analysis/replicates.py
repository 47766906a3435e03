"""Intervals of effects after their first seeds, and the number of seeds that a narrower interval needs."""

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.analysis import quantiles
from ecs_eco.analysis.page import number, table
from ecs_eco.analysis.seed_grid import mean_interval
from ecs_eco.analysis.survival import Interval, bootstrap_difference, difference_of_intervals, wilson

COUNTS = (2, 3, 5, 8, 13, 21, 34, 55, 89, 144, 233)
WISHED = 0.1  # half the width of an interval, as a fraction of the mean, or the difference between two shares
MOST_SEEDS = 1_000_000
MOST_ROWS = 30
_WORDS = (
    "<p>95% intervals of each effect after its first 2, 3, 5, … {unit}. The last two columns estimate, from the "
    "variation between runs, how many {unit} in each arm an interval of ±10% of the mean (for differences, of "
    "the reference's mean; for fractions, ±0.1) needs: for one effect, and for all {m} effects together "
    "(Bonferroni). Of {m} intervals, about {misses} miss the true value by chance. With few {unit}, the "
    "estimates are rough; if you add {unit} until an interval excludes 0, you find differences that are not "
    "there.</p>"
)


class Effect(NamedTuple):
    """The mean of an outcome or, given a reference, its difference from the reference's mean.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.replicates import Effect
    >>> Effect("mean number of deer", np.array([9.0, 11.0, 10.0, 10.0])).needs(half=0.5)
    13
    """

    name: str
    runs: np.ndarray  # f64[seeds], in the order of seeds
    reference: np.ndarray | None = None
    share: bool = False  # whether the outcome is a fraction of runs

    @property
    def samples(self) -> list[np.ndarray]:
        """The runs and, if there is one, the reference."""
        return [self.runs] if self.reference is None else [self.runs, self.reference]

    def after(self, n: int) -> Interval:
        """Return the effect with its 95% interval after the first n seeds."""
        parts = [own[:n] for own in self.samples]
        if self.share and all(np.isin(part, (0.0, 1.0)).all() for part in parts):
            each = [wilson(part.sum(), len(part)) for part in parts]
            return each[0] if len(each) == 1 else difference_of_intervals(*each)
        return mean_interval(parts[0][None]) if len(parts) == 1 else bootstrap_difference(*map(list, parts))

    def needs(self, half: float | None = None, level: float = 0.95) -> int | None:
        """Return the number of seeds in each arm for an interval of ± `half` (default: 10% of the last mean, or 0.1
        for shares), given the variance between runs; None if this is unknown, or more than a million."""
        samples = self.samples
        if half is None:
            half = WISHED if self.share else WISHED * abs(float(samples[-1].mean()))
        variance = sum(map(self._variance, samples))

        def width(n: int) -> float:
            return quantiles.student(len(samples) * (n - 1), level) * float(np.sqrt(variance / n))

        n = 2 + bisect_left(range(2, MOST_SEEDS), -half, key=lambda n: -width(n))
        return n if half > 0 and n < MOST_SEEDS else None

    def _variance(self, runs: np.ndarray) -> float:
        """Return the variance between runs; that of shares is never 0 (Agresti and Coull 1998)."""
        if self.share and np.isin(runs, (0.0, 1.0)).all():
            share = (runs.sum() + 2) / (len(runs) + 4)
            return float(share * (1 - share))
        return float(runs.var(ddof=1))


def seeds_section(effects: Sequence[Effect], unit: str = "seeds") -> list[str]:
    """Return the section on the number of seeds as HTML; effects that need the most seeds come first."""
    effects = [effect for effect in effects if min(map(len, effect.samples)) > 1]
    if not effects:
        return []
    m, most = len(effects), max(len(own) for effect in effects for own in effect.samples)
    counts = sorted({*(n for n in COUNTS if n < most), most})
    needed = [(effect.needs(), effect) for effect in effects]
    found = sorted(needed, key=lambda pair: -(pair[0] or MOST_SEEDS))
    rows = [
        [
            effect.name,
            *(_cell(effect, n) for n in counts),
            number(seeds),
            number(effect.needs(level=1 - 0.05 / m)),
        ]
        for seeds, effect in found[:MOST_ROWS]
    ]
    head = ["effect", *(f"{n} {unit}" for n in counts), f"{unit} for ±10%", "for all effects"]
    left = [f"<p>Effects not shown, which need fewer {unit}: {m - MOST_ROWS}.</p>"] * (m > MOST_ROWS)
    words = _WORDS.format(unit=unit, m=m, misses=number(0.05 * m))
    return ["<h2>How many seeds</h2>", words, table(head, rows), *left]


def _cell(effect: Effect, n: int) -> str:
    """Return the interval after n seeds; empty if there are fewer."""
    if n > max(map(len, effect.samples)):
        return ""
    x = effect.after(n)
    return f"{number(x.low)} to {number(x.high)}"


def differing(effects: Mapping[str, Any], reference: str) -> str:
    """Return a sentence on the species whose mean numbers differ clearly from those of the reference arm."""
    means = {species: of["mean_number"] for species, of in effects["per_species"].items()}
    told = [
        f"{species} {'+' if x[0] > 0 else ''}{number(x[0])} ({number(x[1])} to {number(x[2])})"
        for species, x in means.items()
        if None not in x and (x[1] > 0 or x[2] < 0)
    ]
    if not told:
        return "no mean number differs clearly."
    return f"mean numbers differ from {reference}: {', '.join(told)}."
