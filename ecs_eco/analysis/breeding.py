"""The breeder's view of evolution: selection differentials, responses, heritabilities and selection gradients
of heritable values, with 95% intervals."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from ecs_eco.analysis import quantiles
from ecs_eco.analysis.carriers import values_of
from ecs_eco.analysis.genes import generation_time
from ecs_eco.analysis.palette import GREY, INK
from ecs_eco.analysis.pedigree import ALIVE, Pedigree
from ecs_eco.analysis.style import PALETTE, Figure, panels, styled
from ecs_eco.analysis.survival import Interval
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.record.frame import SeriesTable

LEVEL = 0.95
UNKNOWN = Interval(np.nan, np.nan, np.nan)
ESTIMATES = ("opportunity", "differential", "intensity", "response", "midparent", "one_parent")


class Cohort(NamedTuple):
    """Organisms with a value that were born from tick `start` to `stop`, exclusive.

    `n` counts them; `mean` and `sd` describe their values; `alive` is the fraction still alive at the end.
    `births` is the number of their offspring; a birth counts as one half for each of two parents. The other
    numbers, with their intervals, are explained in `breeding`.
    """

    start: int
    stop: int
    n: int
    alive: float
    births: float
    mean: float
    sd: float
    opportunity: Interval = UNKNOWN
    differential: Interval = UNKNOWN
    intensity: Interval = UNKNOWN
    response: Interval = UNKNOWN
    midparent: Interval = UNKNOWN
    one_parent: Interval = UNKNOWN


@dataclass(frozen=True)
class Breeding:
    """Selection on a heritable value and the response to it.

    `cohorts` are in order of birth; `whole` combines them, weighted by births, and leaves out incomplete
    cohorts. `realised` is the realised heritability, and `generation` the mean generation time [ticks].
    """

    species: str
    value: str
    generation: float
    cohorts: tuple[Cohort, ...]
    whole: Cohort
    realised: Interval

    def cumulated(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the cumulated selection differential and response of complete cohorts, f64[cohorts] each."""
        pairs = np.array([[c.differential.value, c.response.value] for c in self.cohorts]).reshape(-1, 2)
        pairs = pairs[np.isfinite(pairs).all(axis=1)]
        return np.cumsum(pairs[:, 0]), np.cumsum(pairs[:, 1])

    def to_pandas(self) -> Any:
        """Return a pandas.DataFrame with a row for each cohort; the columns of intervals are named like
        response, response_low and response_high."""
        rows = [
            {name: x for name, x in c._asdict().items() if name not in ESTIMATES}
            | {end: x for name in ESTIMATES for end, x in _columns(name, getattr(c, name))}
            for c in self.cohorts
        ]
        return SeriesTable(pa.Table.from_pylist(rows)).to_pandas()


class Gradient(NamedTuple):
    """Selection gradients in the `n` organisms born from tick `start` to `stop`, exclusive: `beta` by value,
    `gamma` by pair of values."""

    start: int
    stop: int
    n: int
    beta: tuple[Interval, ...]
    gamma: tuple[tuple[Interval, ...], ...]


@dataclass(frozen=True)
class Gradients:
    """Selection gradients of several values by cohort and, weighted by births, in the `whole` run.

    `unit` f64[values] is the unit of each value: its standard deviation within cohorts, or 1.
    """

    species: str
    values: tuple[str, ...]
    unit: np.ndarray
    cohorts: tuple[Gradient, ...]
    whole: Gradient

    def terms(self, of: Gradient) -> list[tuple[str, Interval]]:
        """Return the name and estimate of each gradient: β of each value, γ of each pair."""
        t = range(len(self.values))
        linear = [(f"β {name}", b) for name, b in zip(self.values, of.beta, strict=True)]
        return linear + [
            (f"γ {self.values[i]} × {self.values[j]}", of.gamma[i][j]) for i in t for j in t if i <= j
        ]

    def to_pandas(self) -> Any:
        """Return a pandas.DataFrame with a row for each gradient (`term`) of each cohort."""
        rows = [
            {"start": c.start, "stop": c.stop, "n": c.n, "term": term, **dict(_columns("gradient", x))}
            for c in self.cohorts
            for term, x in self.terms(c)
        ]
        return SeriesTable(pa.Table.from_pylist(rows)).to_pandas()


def _columns(name: str, x: Interval) -> Iterable[tuple[str, float]]:
    return zip((name, f"{name}_low", f"{name}_high"), x, strict=True)


def breeding(
    lineage: Pedigree,
    species: str,
    value: str,
    every: int | None = None,
    since: int = 0,
    until: int | None = None,
    alive_max: float = 0.05,
) -> Breeding:
    """Return selection on a heritable value, the response to it, and its heritability.

    Parameters
    ----------
    lineage : Lineage
    species : str
    value : str
        A gene (name or trait) or a recorded field such as "birth: Body.radius".
    every : int, optional
        Ticks of birth in one cohort; default: the mean generation time.
    since : int, default 0
        First tick of birth.
    until : int, optional
        Last tick of birth; default: the end of the run.
    alive_max : float, default 0.05
        Largest fraction of a complete cohort that is alive (or has emigrated) at the end. Selection and
        response in other cohorts are NaN, because part of their lifetime births is still to come. In
        complete cohorts, organisms alive at the end count with their births so far.

    Returns
    -------
    Breeding
        With 95% intervals for each cohort:

        - opportunity for selection: the variance of lifetime births divided by their squared mean;
        - selection differential S: the mean value of parents, weighted by their births, minus the mean of
          their cohort;
        - selection intensity: S in standard deviations of the cohort;
        - response R: the mean value of the cohort's offspring minus the mean of the cohorts in which the
          parents were born, which is also the cohort of mates;
        - midparent: the slope of the offspring's values on the mean of their parents, within cohorts (with
          one parent, on that parent), which estimates the heritability;
        - one_parent: the slope on each parent alone, which is half as large with two unrelated parents.

    Raises
    ------
    KeyError
        If the species, gene or field is unknown.
    ValueError
        If no organism of the species has the value, or a window is empty.

    Notes
    -----
    Realised heritability is the slope through the origin of cumulated R on cumulated S (Falconer and Mackay
    1996, Introduction to quantitative genetics, chapter 11). Its standard error is computed from the scatter
    of cohorts around R = h² S, and so includes drift, which accumulates (Hill 1972, Biometrics 28, 747–765).
    Other standard errors are those of linearized estimates, summed over organisms that share a parent
    (Aronow, Samii and Assenova 2015, Political Analysis 23, 564–577); intervals use Student's t.

    Opportunity is explained by Crow (1958, Human Biology 30, 1–13), and S with lifetime births by Lande and
    Arnold (1983). Founders and immigrants belong to the cohort of the tick at which they appear. Organisms
    without the value are left out, but count as offspring. In recorded fields, R includes changes in the
    environment.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.breeding import breeding
    >>> from ecs_eco.analysis.lineage import Lineage
    >>> uid, parent = np.arange(1, 7, dtype=np.uint64), np.array([0, 0, 2, 2, 3, 4], np.uint64)
    >>> born, died, none = np.array([0, 0, 5, 5, 10, 10]), np.full(6, 11), np.zeros(6, np.uint64)
    >>> words, size = np.full(6, "finch"), np.array([1.0, 3.0, 2.5, 2.5, 2.0, 3.0])
    >>> more = {"end": 12, "recorded": {"birth: Body.radius": size}}
    >>> finches = Lineage(uid, parent, none, words, born, died, words, words, **more)
    >>> first = breeding(finches, "finch", "birth: Body.radius").cohorts[0]
    >>> first.differential.value, first.response.value, first.opportunity.value
    (1.0, 0.5, 1.0)
    """
    b = _Born(lineage, species, (value,), every, since, until, alive_max)
    d, own = b.away[:, 0], b.own
    sd = np.sqrt(b.per_cohort(d**2))
    s = b.per_cohort(b.v * d)
    chance = b.per_cohort(b.v**2) - 1
    k = b.cohort
    psi_s, psi_i = b.v * (d - s[k]) - d, b.v**2 - 1 - chance[k] - 2 * (1 + chance[k]) * (b.v - 1)

    links = _Links(b)

    def described(cohorts: np.ndarray, at: np.ndarray, of: np.ndarray, start: int, stop: int) -> Cohort:
        """Return the cohorts with these organisms and links as one."""
        n = b.n[cohorts]
        mean, alive = (
            float(np.average(x[cohorts], weights=n)) if n.sum() else np.nan for x in (b.mean[:, 0], b.alive)
        )
        births = b.births[cohorts]
        spread = float(np.sqrt(np.average(sd[cohorts] ** 2, weights=n))) if n.sum() else np.nan
        known = start, stop, int(n.sum()), alive, float(births.sum()), mean, spread
        usable = b.usable[cohorts]
        slopes = [links.slope(of, x) for x in (links.x, links.own)]
        if not usable.any():
            return Cohort(*known, midparent=slopes[0], one_parent=slopes[1])
        at, of = at[b.usable[k[at]]], of[b.usable[links.cohort[of]]]
        h = b.weight(at)
        families = own.mother[at], b.father[at]
        variance = float(h @ d[at] ** 2)
        differential, u = float(h @ (b.v * d)[at]), h * psi_s[at]
        scale = np.sqrt(variance) if variance > 0 else np.nan
        score = (u - differential * h * (d[at] ** 2 - sd[k[at]] ** 2) / (2 * scale**2)) / scale
        return Cohort(
            *known,
            _interval(float(h @ b.v[at] ** 2) - 1, h * psi_i[at], *families),
            _interval(differential, u, *families),
            _interval(differential / scale, score, *families),
            links.response(of),
            *slopes,
        )

    each = np.arange(len(b.n))
    groups = zip(each, _groups(k, len(each)), _groups(links.cohort, len(each)), strict=True)
    cohorts = tuple(
        described(each[j : j + 1], at, of, int(b.edges[j]), int(b.edges[j + 1])) for j, at, of in groups
    )
    everyone, every_link = np.flatnonzero(k >= 0), np.arange(len(links.cohort))
    whole = described(each, everyone, every_link, int(b.edges[0]), int(b.edges[-1]))
    found = Breeding(species, value, b.generation, cohorts, whole, UNKNOWN)
    return Breeding(species, value, b.generation, cohorts, whole, _realised(*found.cumulated()))


def _realised(s: np.ndarray, r: np.ndarray) -> Interval:
    """Return the slope through the origin of cumulated responses r on cumulated differentials s."""
    if len(s) < 1 or not (s @ s) > 0:
        return UNKNOWN
    slope = float(s @ r / (s @ s))
    off = np.diff(r - slope * s, prepend=0.0)  # of each cohort
    pull = np.cumsum(s[::-1])[::-1] / (s @ s)
    return _with_error(slope, float(((pull * off) ** 2).sum()), len(s))


def gradients(
    lineage: Pedigree,
    species: str,
    values: Sequence[str],
    every: int | None = None,
    since: int = 0,
    until: int | None = None,
    alive_max: float = 0.05,
    standardized: bool = True,
) -> Gradients:
    """Return linear and quadratic selection gradients of one or several heritable values.

    Parameters
    ----------
    lineage : Lineage
    species : str
    values : sequence of str
        Genes or recorded fields, as for `breeding`.
    every, since, until, alive_max
        As for `breeding`.
    standardized : bool, default True
        Measure each value in its standard deviation within cohorts.

    Returns
    -------
    Gradients
        β: the change in relative fitness per unit of a value, with the other values held constant. γ: its
        curvature; negative if intermediate values leave the most offspring, and for two values the selection
        on their product. All have 95% intervals. NaN if a cohort is incomplete or the values are collinear.

    Raises
    ------
    KeyError
        If the species, a gene or a field is unknown.
    ValueError
        If no organism of the species has the values, or a window is empty.

    Notes
    -----
    Lande and Arnold (1983, Evolution 37, 1210–1226): relative fitness (lifetime births divided by their mean in
    the cohort) is regressed on the values for β, and on the values, half their squares and their products
    for γ. The half makes quadratic coefficients equal γ (Stinchcombe et al. 2008, Evolution 62, 2435–2440).
    Intervals are computed as in `breeding`.
    """
    b = _Born(lineage, species, tuple(values), every, since, until, alive_max)
    count = len(values)
    k, everyone = b.cohort, np.flatnonzero(b.cohort >= 0)
    unit = np.std(b.away[everyone], axis=0) if standardized else np.ones(count)
    z = b.away / np.where(unit > 0, unit, np.nan)
    pairs = [(i, j) for i in range(count) for j in range(i, count)]
    products = np.stack([z[:, i] * z[:, j] * (0.5 if i == j else 1.0) for i, j in pairs], 1)
    products -= np.stack([b.per_cohort(column) for column in products.T], 1)[k]

    def described(at: np.ndarray, start: int, stop: int) -> Gradient:
        at = at[b.usable[k[at]]]
        beta = _regression(b, at, z[at])
        curved = dict(zip(pairs, _regression(b, at, np.hstack([z, products])[at])[count:], strict=True))
        gamma = [tuple(curved[min(i, j), max(i, j)] for j in range(count)) for i in range(count)]
        return Gradient(start, stop, len(at), tuple(beta), tuple(gamma))

    groups = enumerate(_groups(k, len(b.n)))
    cohorts = tuple(described(at, int(b.edges[j]), int(b.edges[j + 1])) for j, at in groups)
    whole = described(everyone, int(b.edges[0]), int(b.edges[-1]))
    return Gradients(species, tuple(values), unit, cohorts, whole)


def _regression(b: "_Born", at: np.ndarray, x: np.ndarray) -> list[Interval]:
    """Return the coefficients of relative fitness on deviations x f64[organisms, terms] from cohort means."""
    h = b.weight(at)
    square = (x * h[:, None]).T @ x
    # unknown if collinear; whether it is must not depend on the units of values
    scale = np.sqrt(np.diag(square))
    if len(at) <= x.shape[1] or not (scale > 0).all():
        return [UNKNOWN] * x.shape[1]
    if np.linalg.matrix_rank(square / np.outer(scale, scale), tol=1e-9, hermitian=True) < len(scale):
        return [UNKNOWN] * x.shape[1]
    v = b.v[at] - 1
    found = np.linalg.solve(square, x.T @ (h * v))
    # the last term: relative fitness is divided by the mean of a sample
    scores = np.linalg.solve(square, (x * (h * (v - x @ found))[:, None]).T) - np.outer(found, h * v)
    families = b.own.mother[at], b.father[at]
    return [_interval(float(value), u, *families) for value, u in zip(found, scores, strict=True)]


class _Born:
    """Organisms of a species with values: their cohorts, deviations from cohort means, and relative fitness."""

    def __init__(
        self,
        lineage: Pedigree,
        species: str,
        values: tuple[str, ...],
        every: int | None,
        since: int,
        until: int | None,
        alive_max: float,
    ) -> None:
        self.own = own = lineage.of_species(species)
        self.generation = generation_time(own, species)
        until = own.end if until is None else until
        if every is None:
            every = max(1, round(self.generation)) if self.generation > 0 else until - since + 1
        if every < 1 or until < since:
            raise ValueError(
                f"lineage: every is {every}, and births are from tick {since} to {until}; expected at least 1 tick"
            )
        z = np.stack([_values(own, species, value) for value in values], 1)
        if not (known := np.isfinite(z).all(axis=1)).any():
            raise ValueError(
                f"lineage: no organism of {species!r} has {' and '.join(map(repr, values))}; "
                "genes need `genome` and fields need `record` in the world file"
            )
        self.edges = np.append(np.arange(since, until + 1, every), until + 1)
        count = len(self.edges) - 1
        self.cohort = np.searchsorted(self.edges, own.born, "right") - 1
        self.cohort[(self.cohort == count) | ~known] = -1
        self.father = np.where(own.father == own.mother, -1, own.father)
        self.parents = np.stack([own.mother, self.father])
        self.credit = 1 / np.maximum((self.parents >= 0).sum(axis=0), 1)
        births = np.zeros(len(own))
        for line in self.parents:
            births += np.bincount(line[line >= 0], self.credit[line >= 0], len(own))
        inside = self.cohort >= 0
        self.n = np.bincount(self.cohort[inside], minlength=count)
        self.births = np.bincount(self.cohort[inside], births[inside], count)
        self.alive = self.per_cohort(((own.died == ALIVE) | (own.cause == "emigrated")).astype(float))
        self.usable = (self.births > 0) & (self.alive <= alive_max)
        self.mean = np.stack([self.per_cohort(column) for column in z.T], 1)
        self.away = np.where(inside[:, None], z - self.mean[self.cohort], np.nan)
        fitness = self.per_cohort(births)
        self.v = births / np.where(fitness > 0, fitness, np.nan)[self.cohort]

    def per_cohort(self, x: np.ndarray) -> np.ndarray:
        """Return the mean of each cohort, NaN if it is empty: f64[cohorts]."""
        inside = self.cohort >= 0
        sums = np.bincount(self.cohort[inside], x[inside], len(self.n))
        return sums / np.where(self.n, self.n, np.nan)

    def weight(self, at: np.ndarray) -> np.ndarray:
        """Return the weights of organisms, which sum to 1; cohorts count by their births."""
        share = (self.births / np.maximum(self.n, 1))[self.cohort[at]]
        return np.asarray(share / share.sum())


def _values(own: Pedigree, species: str, value: str) -> np.ndarray:
    if value.startswith(("birth: ", "death: ")):
        if value not in own.recorded:
            raise UnknownName(unknown_name("lineage", "recorded field", value, own.recorded))
        return own.recorded[value]
    return values_of(own, value, species)


class _Links:
    """Pairs of parent and child, both with values, by the parent's cohort. Deviations are from the means of the
    cohorts in which the parents were born."""

    def __init__(self, b: _Born) -> None:
        d, mean = b.away[:, 0], b.mean[:, 0]
        there = (b.parents >= 0) & (b.cohort[b.parents] >= 0)
        number = np.maximum(there.sum(axis=0), 1)
        of_parents = np.where(there, d[b.parents], 0.0).sum(axis=0) / number
        reference = np.where(there, mean[b.cohort[b.parents]], 0.0).sum(axis=0) / number
        # a child born after `until` has no cohort, but a value
        line, child = np.nonzero(there & np.isfinite(b.z))
        parent = b.parents[line, child]
        self.cohort, self.credit = b.cohort[parent], b.credit[child]
        self.x, self.own, self.y = of_parents[child], d[parent], (b.z - reference)[child]
        self.families = b.own.mother[child], b.father[child]
        self.count = len(b.n)

    def centred(self, of: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Return deviations from the mean of each cohort's links, weighted by births."""
        k, c = self.cohort[of], self.credit[of]
        total = np.bincount(k, c, self.count)
        return np.asarray(x[of] - (np.bincount(k, c * x[of], self.count) / np.maximum(total, 1e-300))[k])

    def response(self, of: np.ndarray) -> Interval:
        """Return the mean of the offspring with its interval."""
        if not of.size:
            return UNKNOWN
        c = self.credit[of] / self.credit[of].sum()
        u = c * self.centred(of, self.y)
        return _interval(float(c @ self.y[of]), u, self.families[0][of], self.families[1][of])

    def slope(self, of: np.ndarray, x: np.ndarray) -> Interval:
        """Return the slope of offspring on x, within cohorts."""
        c, x, y = self.credit[of], self.centred(of, x), self.centred(of, self.y)
        square = float(c @ x**2)
        if not square > 1e-18 * float(c.sum()):
            return UNKNOWN
        value = float((c * x) @ y / square)
        u = c * x * (y - value * x) / square
        return _interval(value, u, self.families[0][of], self.families[1][of])


def _groups(cohort: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the indices in each cohort, without −1."""
    order = np.argsort(cohort, kind="stable")
    return np.split(order, np.searchsorted(cohort[order], np.arange(count + 1)))[1:-1]


def _interval(value: float, scores: np.ndarray, mother: np.ndarray, father: np.ndarray) -> Interval:
    """Return an estimate whose error is the sum of `scores`, which depend on each other in organisms that share a
    parent (−1 if there is none)."""
    one, two = (mother >= 0) | (father >= 0), (mother >= 0) & (father >= 0)
    alone = float((scores[~one] ** 2).sum())
    place = 1 + int(max(mother.max(initial=-1), father.max(initial=-1)))
    pair = np.minimum(mother, father) * place + np.maximum(mother, father)  # unique where there are two
    both, families = _squares(scores[two], pair[two])
    line = np.concatenate([mother[mother >= 0], father[father >= 0]])
    shared, _ = _squares(np.concatenate([scores[mother >= 0], scores[father >= 0]]), line)
    single, more = _squares(scores[one & ~two], np.maximum(mother, father)[one & ~two])
    families += more + int((~one).sum())
    # full sibs share two parents and are counted twice; the difference can be too small by chance
    return _with_error(value, alone + max(shared - both, single + both), families)


def _squares(scores: np.ndarray, group: np.ndarray) -> tuple[float, int]:
    """Return the sum of squares of each group's summed scores, and the number of groups."""
    names, which = np.unique(group, return_inverse=True)
    return float((np.bincount(which, scores, len(names)) ** 2).sum()), len(names)


def _with_error(value: float, variance: float, groups: int) -> Interval:
    """Return a 95% interval from the variance of a sum over independent groups."""
    if groups < 2 or not np.isfinite(value):
        return Interval(value, np.nan, np.nan)
    half = quantiles.student(groups - 1, LEVEL) * float(np.sqrt(variance * groups / (groups - 1)))
    return Interval(value, value - half, value + half)


@styled
def responses(found: Breeding, title: str = "") -> Figure:
    """Plot the mean of newborns, selection and response by cohort, and cumulated response against selection.

    Parameters
    ----------
    found : Breeding
    title : str, default ""

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, ((left, middle, right),) = panels(1, 3, 11, 3.4)
    ticks = np.array([(c.start + c.stop) / 2 for c in found.cohorts])
    mean, sd = np.array([[c.mean, c.sd] for c in found.cohorts]).T
    left.plot(ticks, mean, color=INK, lw=1.6, label="mean")
    for sign in (-1, 1):
        label = "± 1 standard deviation" if sign > 0 else None
        left.plot(ticks, mean + sign * sd, color=INK, lw=0.9, ls=(0, (4, 2)), label=label)
    left.set(xlabel="tick of birth", ylabel=found.value, title=title or found.species)
    width = np.diff(ticks).min(initial=1.0) / 8
    for k, (name, label) in enumerate((("differential", "S"), ("response", "R"))):
        value, low, high = np.array([getattr(c, name) for c in found.cohorts]).T
        error = np.array([value - low, high - value])
        at = ticks + (2 * k - 1) * width
        middle.errorbar(at, value, error, color=PALETTE[k], fmt="os"[k], ms=4, lw=1.2, label=label)
    middle.axhline(0, color=GREY, lw=0.8)
    middle.set(xlabel="tick of birth", ylabel="per generation", title="Selection and response")
    middle.legend(loc="best")
    s, r = (np.append(0.0, x) for x in found.cumulated())
    right.plot(s, r, "o-", color=INK, ms=4, lw=0.8)
    h = found.realised
    if np.isfinite(h.value):
        ends = np.array([s.min(), s.max()])
        right.plot(ends, h.value * ends, color=PALETTE[1], label=f"slope {h.value:.2g}")
        right.legend(loc="best")
    right.set(xlabel="cumulated S", ylabel="cumulated R", title="Realised heritability")
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper left", ncols=2)
    return figure


@styled
def forest(found: Gradients, title: str = "") -> Figure:
    """Plot selection gradients of the whole run with 95% intervals, and estimates of cohorts as small dots.

    Parameters
    ----------
    found : Gradients
    title : str, default ""

    Returns
    -------
    matplotlib.figure.Figure
    """
    whole = found.terms(found.whole)
    figure, ((ax,),) = panels(1, 1, 7, 0.45 * len(whole) + 1.3)
    for c in found.cohorts:
        ax.plot([x.value for _, x in found.terms(c)], range(len(whole)), ".", color=GREY, ms=4, zorder=1)
    for k, (_, x) in enumerate(whole):
        ax.errorbar(x.value, k, xerr=[[x.value - x.low], [x.high - x.value]], fmt="o", color=INK, lw=1.6)
    ax.axvline(0, color=GREY, lw=0.8)
    ax.set_yticks(range(len(whole)), [term for term, _ in whole])
    ax.invert_yaxis()
    ax.set(xlabel="selection gradient", title=title or found.species)
    return figure
