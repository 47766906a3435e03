"""The breeder's view of evolution: selection on heritable values, responses, heritabilities and gradients."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa

from ecs_eco.analysis import quantiles
from ecs_eco.analysis.carriers import values_of
from ecs_eco.analysis.genes import generation_time
from ecs_eco.analysis.palette import GREY, INK
from ecs_eco.analysis.pedigree import ALIVE, Pedigree
from ecs_eco.analysis.style import PALETTE, Figure, mean_and_sd, panels, styled
from ecs_eco.analysis.survival import Interval
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.record.frame import SeriesTable

UNKNOWN = Interval(np.nan, np.nan, np.nan)
ALIVE_MAX = 0.05  # largest fraction of a complete cohort that is alive at the end
SELECTION = ("mean", "sd", "opportunity", "differential", "intensity", "response", "midparent", "one_parent")
ENDS = ("", "_low", "_high")  # of the columns of an interval
Estimates = dict[str, Interval]


@dataclass(frozen=True)
class Cohort:
    """The `n` organisms with a value that were born from tick `start` to `stop`, exclusive."""

    start: int
    stop: int
    n: int
    alive: float  # fraction still alive at the end
    births: float  # number of offspring; with two parents, a birth counts as one half for each
    estimates: Estimates  # with 95% intervals, by name


@dataclass(frozen=True)
class Breeding:
    """Selection on heritable `values` of a species, by cohort in order of birth and for the `whole` run."""

    species: str
    values: tuple[str, ...]
    generation: float  # mean generation time [ticks]
    cohorts: tuple[Cohort, ...]
    whole: Cohort  # its estimates combine cohorts, weighted by births

    def to_pandas(self) -> Any:
        """Return a row for each cohort; an estimate has columns such as response, response_low and response_high.

        Returns
        -------
        pandas.DataFrame

        Examples
        --------
        >>> from ecs_eco.analysis.breeding import Breeding, Cohort
        >>> from ecs_eco.analysis.survival import Interval
        >>> cohort = Cohort(0, 9, 5, 0.0, 5.0, {"mean": Interval(0.5, 0.4, 0.6)})
        >>> Breeding("finch", ("size",), 9.0, (cohort,), cohort).to_pandas().columns[-3:].tolist()
        ['mean', 'mean_low', 'mean_high']
        """
        rows = [
            {name: getattr(c, name) for name in ("start", "stop", "n", "alive", "births")}
            | {name + end: x for name, e in c.estimates.items() for end, x in zip(ENDS, e, strict=True)}
            for c in self.cohorts
        ]
        return SeriesTable(pa.Table.from_pylist(rows)).to_pandas()


def breeding(
    lineage: Pedigree,
    species: str,
    value: str,
    every: int | None = None,
    since: int = 0,
    until: int | None = None,
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

    Returns
    -------
    Breeding
        With these estimates for each cohort and the whole run:

        - mean and sd (within cohorts) of newborns;
        - opportunity: the variance of lifetime births divided by their squared mean;
        - differential S: the mean value of parents, weighted by births, minus the mean of their cohort;
        - intensity: S in standard deviations;
        - response R: the mean value of the offspring minus the means of the cohorts in which their parents
          were born;
        - midparent: the slope of offspring on the mean of their parents (or on the only parent), within
          cohorts, which estimates the heritability (with only one parent, in the broad sense);
        - one_parent: the slope on each parent separately, half as large with two unrelated parents;
        - realized (whole run only): the slope through the origin of cumulative R on cumulative S.

        Opportunity, S, intensity and R are NaN for cohorts of which more than 5% are alive at the end (or
        have emigrated), because part of their births is still to come. The whole run leaves these cohorts
        out. In other cohorts, living organisms count with their births so far.

    Raises
    ------
    KeyError
        If the species, gene or field is unknown.
    ValueError
        If no organism of the species has the value, or there is no tick of birth.

    Notes
    -----
    Opportunity: Crow (1958, Human Biology 30, 1–13). Realized heritability: Falconer and Mackay (1996,
    Introduction to quantitative genetics, chapter 11). Standard errors are from linearized estimates,
    clustered by shared parents (Aronow, Samii and Assenova 2015, Political Analysis 23, 564–577). For realized
    heritability, they sum the deviations of offspring from R = h² S, so they include drift, which accumulates
    over cohorts (Hill 1972, Biometrics 28, 767–780). Intervals use Student's t. They describe the organisms of
    one run; to generalize, compare runs.

    Founders and immigrants belong to the cohort of the tick at which they appear. Organisms without the value
    count only as offspring. R includes changes in the environment if these change the value.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.lineage import Lineage
    >>> uid, parent = np.arange(1, 7, dtype=np.uint64), np.array([0, 0, 2, 2, 3, 4], np.uint64)
    >>> born, died, none = np.array([0, 0, 5, 5, 10, 10]), np.full(6, 11), np.zeros(6, np.uint64)
    >>> words, size = np.full(6, "finch"), np.array([1.0, 3.0, 2.5, 2.5, 2.0, 3.0])
    >>> recorded = {"birth: Body.radius": size}
    >>> finches = Lineage(uid, parent, none, words, born, died, words, words, 12, recorded=recorded)
    >>> found = finches.breeding("finch", "birth: Body.radius")
    >>> first = found.cohorts[0].estimates
    >>> first["differential"].value, first["response"].value, first["opportunity"].value
    (1.0, 0.5, 1.0)
    >>> found.to_pandas()["response"].tolist()
    [0.5, 0.0, nan]
    """
    b = _Born(lineage, species, (value,), every, since, until)
    k, z, d, v = b.cohort, b.z[:, 0], b.away[:, 0], b.fitness
    variance, s, square = (b.per_cohort(x)[k] for x in (d**2, v * d, v**2))
    scores = {"differential": v * (d - s) - d, "opportunity": v**2 - square - 2 * square * (v - 1)}

    # pairs of parent and child, with deviations from the means of the cohorts of parents
    parent, child, c = b.parent, b.child, b.credit[b.child]
    y = z[child] - b.of_parents(b.mean[k, 0])[child]
    xs = {"midparent": b.of_parents(d)[child], "one_parent": d[parent]}
    within, offspring = k[parent], y
    total = np.bincount(within, c, len(b.n))[within]

    def centred(x: np.ndarray) -> np.ndarray:
        return _deviation(x, np.bincount(within, c * x, len(b.n))[within] / total)

    y, xs = centred(y), {name: centred(x) for name, x in xs.items()}

    def estimates(at: np.ndarray, of: np.ndarray) -> Estimates:
        mean, sd = float(z[at].mean()), float(np.sqrt((d[at] ** 2).mean()))
        interval, of_children = b.intervals(at), b.intervals(child[of])
        out = {"mean": interval(mean, (z[at] - mean) / len(at))}
        out["sd"] = interval(sd, (d[at] ** 2 - variance[at]) / (2 * (sd or 1.0) * len(at)))
        for name, x in xs.items():
            cx = c[of] * x[of]
            if (squares := float(cx @ x[of])) > 0:
                slope = float(cx @ y[of]) / squares
                out[name] = of_children(slope, cx * (y[of] - slope * x[of]) / squares)
        at, of = at[b.complete[k[at]]], of[b.complete[within[of]]]
        if not at.size:
            return out
        h, interval = b.weight(at), b.intervals(at)
        out["opportunity"] = interval(float(h @ v[at] ** 2) - 1, h * scores["opportunity"][at])
        differential, u = float(h @ (v[at] * d[at])), h * scores["differential"][at]
        out["differential"] = interval(differential, u)
        if (sd := float(np.sqrt(h @ d[at] ** 2))) > 0:
            u = u / sd - differential * h * (d[at] ** 2 - variance[at]) / (2 * sd**3)
            out["intensity"] = interval(differential / sd, u)
        if of.size:
            weight = c[of] / c[of].sum()
            out["response"] = b.intervals(child[of])(float(weight @ offspring[of]), weight * y[of])
        return out

    found = b.result(species, (value,), SELECTION, estimates)
    steps = _steps(found)
    done = np.isfinite(steps).all(axis=0)
    selected, changed = np.cumsum(steps[:, done], axis=1)
    pull, found.whole.estimates["realized"] = np.zeros(len(b.n)), UNKNOWN
    if (squares := float(selected @ selected)) > 0:
        pull[done] = np.cumsum(selected[::-1])[::-1] / squares  # of each cohort's R on the slope
        slope = float(selected @ changed) / squares
        u = pull[within] * c / total * (y - slope * xs["midparent"])
        found.whole.estimates["realized"] = b.intervals(child)(slope, u)
    return found


def _steps(found: Breeding) -> np.ndarray:
    """Return the selection differential and the response of each cohort, f64[2, cohorts]."""
    return np.array(
        [[c.estimates[name].value for c in found.cohorts] for name in ("differential", "response")]
    )


def gradients(
    lineage: Pedigree,
    species: str,
    values: Sequence[str],
    every: int | None = None,
    since: int = 0,
    until: int | None = None,
    standardized: bool = True,
) -> Breeding:
    """Return linear and quadratic selection gradients of one or several heritable values.

    Parameters
    ----------
    lineage : Lineage
    species : str
    values : sequence of str
        Genes or recorded fields, as for `breeding`.
    every, since, until
        As for `breeding`.
    standardized : bool, default True
        Measure each value in standard deviations (within cohorts, over the whole run).

    Returns
    -------
    Breeding
        With the estimates "β size", the change in relative fitness per unit of a value when the other values
        are constant; "γ size × size", its curvature, negative if intermediate values leave the most
        offspring; and "γ size × pace", selection on the product of two values. NaN for the same cohorts as in
        `breeding`, for constant values, and if values are collinear; a value with two levels has no γ.

    Raises
    ------
    KeyError
        If the species, a gene or a field is unknown.
    ValueError
        If no organism of the species has all the values, or there is no tick of birth.

    Notes
    -----
    Lande and Arnold (1983, Evolution 37, 1210–1226): β is from the regression of relative fitness (lifetime
    births divided by the mean of the cohort) on the values, and γ from the regression on the values, their
    products and half their squares (Stinchcombe et al. 2008, Evolution 62, 2435–2440).

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.lineage import Lineage
    >>> uid, parent = np.arange(1, 9, dtype=np.uint64), np.array([0, 0, 0, 0, 2, 3, 3, 4], np.uint64)
    >>> born, died, none = np.repeat([0, 5], 4), np.full(8, 6), np.zeros(8, np.uint64)
    >>> words, size = np.full(8, "finch"), np.array([1.0, 2, 3, 4, 2, 3, 3, 4])
    >>> recorded = {"birth: Body.radius": size}
    >>> finches = Lineage(uid, parent, none, words, born, died, words, words, 7, recorded=recorded)
    >>> found = finches.gradients("finch", ["birth: Body.radius"], standardized=False)
    >>> [(name, round(x.value, 6)) for name, x in found.whole.estimates.items()]
    [('β birth: Body.radius', 0.4), ('γ birth: Body.radius × birth: Body.radius', -1.0)]
    """
    b = _Born(lineage, species, tuple(values), every, since, until)
    t = range(len(values))
    pairs = [(i, j) for i in t for j in t if i <= j]
    linear = [f"β {name}" for name in values]
    curved = [f"γ {values[i]} × {values[j]}" for i, j in pairs]
    unit = np.std(b.away[b.cohort >= 0], axis=0) if standardized else np.ones(len(values))
    z = b.away / np.where(unit > 0, unit, 1)
    # two levels have no curvature
    bend = [len(np.unique(column[np.isfinite(column)])) > 2 for column in b.z.T]
    products = np.stack([z[:, i] * z[:, j] * (0.5 * bend[i] if i == j else 1.0) for i, j in pairs], 1)
    means = np.stack([b.per_cohort(column) for column in products.T], 1)
    both = np.hstack([z, _deviation(products, means[b.cohort])])

    def estimates(at: np.ndarray, _: np.ndarray) -> Estimates:
        at = at[b.complete[b.cohort[at]]]
        beta = _regression(b, at, z[at])
        gamma = _regression(b, at, both[at])[len(values) :]
        return dict(zip([*linear, *curved], [*beta, *gamma], strict=True))

    return b.result(species, tuple(values), (*linear, *curved), estimates)


def _regression(b: "_Born", at: np.ndarray, x: np.ndarray) -> list[Interval]:
    """Return the slopes of relative fitness on deviations x f64[organisms, terms]; unknown if collinear."""
    out = [UNKNOWN] * x.shape[1]
    scale = np.sqrt((x**2).sum(axis=0))
    kept = np.flatnonzero(scale > 0)
    x, scale = x[:, kept], scale[kept]
    if len(at) <= len(kept) or np.linalg.matrix_rank(x / scale, tol=1e-6) < len(kept):
        return out
    h, v = b.weight(at), b.fitness[at] - 1
    square = (x.T * h) @ x
    found = np.linalg.solve(square, x.T @ (h * v))
    # fitness is relative to the mean of a sample: hence the last term
    scores = np.linalg.solve(square, x.T * (h * (v - x @ found))) - np.outer(found, h * v)
    interval = b.intervals(at)
    for k, value, u in zip(kept, found, scores, strict=True):
        out[k] = interval(float(value), u)
    return out


class _Born:
    """The organisms of a species: cohorts, deviations from cohort means, and relative fitness."""

    def __init__(
        self,
        lineage: Pedigree,
        species: str,
        values: tuple[str, ...],
        every: int | None,
        since: int,
        until: int | None,
    ) -> None:
        own = lineage.of_species(species)
        if not values:
            raise ValueError(f"lineage: no values of {species!r}; expected the name of at least one")
        self.generation = generation_time(own, species)
        until = own.end if until is None else until
        if every is None:
            every = max(1, round(self.generation)) if self.generation > 0 else max(1, until - since + 1)
        if every < 1 or until < since:
            span = f"every is {every}, since is {since} and until is {until}"
            raise ValueError(f"lineage: {span}; expected every of at least 1, and since up to until")
        self.z = np.stack([_values(own, species, value) for value in values], 1)
        known = np.isfinite(self.z).all(axis=1)
        if not known.any():
            raise ValueError(f"lineage: no organism of {species!r} has {' and '.join(map(repr, values))}")
        self.edges = np.append(np.arange(since, until + 1, every), until + 1)
        inside = known & (own.born >= since) & (own.born <= until)
        self.cohort = np.where(inside, np.searchsorted(self.edges, own.born, "right") - 1, -1)
        self.n = np.bincount(self.cohort[inside], minlength=len(self.edges) - 1)
        self.mean = np.stack([self.per_cohort(column) for column in self.z.T], 1)
        self.away = _deviation(self.z, self.mean[self.cohort])

        self.parents = np.stack([own.mother, np.where(own.father == own.mother, -1, own.father)])
        has = self.parents >= 0
        self.credit = 1 / np.maximum(has.sum(axis=0), 1)
        line, child = np.nonzero(has)
        self.births = np.bincount(self.parents[line, child], self.credit[child], len(own))
        births = self.per_cohort(self.births)
        self.fitness = self.births / np.where(births > 0, births, np.nan)[self.cohort]
        self.alive = ((own.died == ALIVE) | (own.cause == "emigrated")).astype(float)
        self.complete = (births > 0) & (self.per_cohort(self.alive) <= ALIVE_MAX)

        self.known = has & inside[self.parents]  # parents with a cohort
        line, self.child = np.nonzero(self.known & np.isfinite(self.z[:, 0]))
        self.parent = self.parents[line, self.child]

    def per_cohort(self, x: np.ndarray) -> np.ndarray:
        """Return the mean of each cohort, NaN if it is empty: f64[cohorts]."""
        inside = self.cohort >= 0
        sums = np.bincount(self.cohort[inside], x[inside], len(self.n))
        return sums / np.where(self.n, self.n, np.nan)

    def of_parents(self, x: np.ndarray) -> np.ndarray:
        """Return the mean over the parents of each organism that have a cohort."""
        total = np.where(self.known, x[self.parents], 0.0).sum(axis=0)
        return np.asarray(total / np.maximum(self.known.sum(axis=0), 1))

    def weight(self, at: np.ndarray) -> np.ndarray:
        """Return the weights of organisms, which sum to 1; each cohort counts by its births."""
        k = self.cohort[at]
        share = np.bincount(k, self.births[at], len(self.n))[k] / self.n[k]
        return np.asarray(share / share.sum())

    def result(
        self,
        species: str,
        values: tuple[str, ...],
        names: Sequence[str],
        estimates: Callable[[np.ndarray, np.ndarray], Estimates],
    ) -> Breeding:
        """Return the named estimates from the organisms of each cohort and from the pairs with their children."""

        def one(at: np.ndarray, of: np.ndarray, start: int, stop: int) -> Cohort:
            found = estimates(at, of) if at.size else {}
            alive = float(self.alive[at].mean()) if at.size else np.nan
            births = float(self.births[at].sum())
            return Cohort(start, stop, len(at), alive, births, dict.fromkeys(names, UNKNOWN) | found)

        at, of = (_groups(k, len(self.n)) for k in (self.cohort, self.cohort[self.parent]))
        edges = self.edges.tolist()
        cohorts = tuple(one(*each) for each in zip(at, of, edges[:-1], edges[1:], strict=True))
        whole = one(np.concatenate(at), np.concatenate(of), edges[0], edges[-1])
        return Breeding(species, values, self.generation, cohorts, whole)

    def intervals(self, at: np.ndarray) -> Callable[[float, np.ndarray], Interval]:
        """Return a function of an estimate and of scores whose sum is its error; sibs share a parent's error."""
        n = len(self.births)
        a, b = np.sort(self.parents[:, at], axis=0)  # a < 0 ≤ b: one parent; b < 0: none
        pair = np.where(b < 0, -1 - np.arange(len(at)), (a + 1) * n + b)
        pairs, of_pair = np.unique(pair, return_inverse=True)
        parents = np.concatenate([a, b])
        _, of_parent = np.unique(parents[parents >= 0], return_inverse=True)

        def interval(value: float, scores: np.ndarray) -> Interval:
            squares = np.bincount(of_pair, scores) ** 2
            shared = (np.bincount(of_parent, np.tile(scores, 2)[parents >= 0]) ** 2).sum()
            # full sibs share both parents; organisms without parents share none
            shared += squares[pairs < 0].sum() - squares[pairs >= n].sum()
            if (k := len(pairs)) < 2:
                return Interval(value, np.nan, np.nan)
            variance = float(max(shared, squares.sum())) * k / (k - 1)
            half = quantiles.student(k - 1, 0.95) * float(np.sqrt(variance))
            return Interval(value, value - half, value + half)

        return interval


def _values(own: Pedigree, species: str, value: str) -> np.ndarray:
    if value.startswith(("birth: ", "death: ")):
        if value not in own.recorded:
            raise UnknownName(unknown_name("lineage", "recorded field", value, own.recorded))
        return own.recorded[value]
    return values_of(own, value, species)


def _deviation(x: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Return x − mean, or 0 if the difference is only a rounding error or unknown."""
    return np.where(np.abs(x - mean) > 1e-12 * np.abs(mean), x - mean, 0.0)


def _groups(cohort: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the indices in each cohort, without −1."""
    order = np.argsort(cohort, kind="stable")
    return np.split(order, np.searchsorted(cohort[order], np.arange(count + 1)))[1:-1]


@styled
def responses(found: Breeding, title: str = "") -> Figure:
    """Plot newborns, selection and response by cohort, and cumulative response against cumulative selection.

    Parameters
    ----------
    found : Breeding
        From `breeding`.
    title : str, default ""

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from ecs_eco.analysis.breeding import Breeding, Cohort, responses
    >>> from ecs_eco.analysis.survival import Interval
    >>> names = ("mean", "sd", "differential", "response", "realized")
    >>> all_zero = dict.fromkeys(names, Interval(0.0, -1.0, 1.0))
    >>> cohort = Cohort(0, 9, 5, 0.0, 5.0, all_zero)
    >>> [ax.get_xlabel() for ax in responses(Breeding("finch", ("size",), 9.0, (cohort,), cohort)).axes]
    ['tick of birth', 'tick of birth', 'cumulative S']
    """
    figure, ((left, middle, right),) = panels(1, 3, 11, 3.4)
    ticks = np.array([(c.start + c.stop - 1) / 2 for c in found.cohorts])
    of = {
        name: np.array([c.estimates[name] for c in found.cohorts]).T
        for name in ("mean", "sd", "differential", "response")
    }
    mean_and_sd(left, ticks, of["mean"][0], of["sd"][0])
    left.set(xlabel="tick of birth", ylabel=found.values[0], title=title or found.species)
    apart = np.diff(ticks).min(initial=found.cohorts[0].stop - found.cohorts[0].start) / 10
    for k, (name, label) in enumerate((("differential", "S"), ("response", "R"))):
        value, low, high = of[name]
        at = ticks + (2 * k - 1) * apart
        middle.errorbar(
            at, value, (value - low, high - value), color=PALETTE[k], fmt="os"[k], ms=4, label=label
        )
    middle.axhline(0, color=GREY, lw=0.8)
    middle.set(xlabel="tick of birth", ylabel=found.values[0], title="Selection and response")
    steps = _steps(found)
    s, r = np.cumsum(np.hstack([[[0.0], [0.0]], steps[:, np.isfinite(steps).all(axis=0)]]), axis=1)
    slope = found.whole.estimates["realized"].value
    title_of_slope = "Realized heritability" + (f": {slope:.2f}" if np.isfinite(slope) else "")
    right.plot(s, r, "o", color=INK, ms=4)
    right.plot(s[[s.argmin(), s.argmax()]], slope * s[[s.argmin(), s.argmax()]], color=PALETTE[1])
    right.set(xlabel="cumulative S", ylabel="cumulative R", title=title_of_slope)
    right.locator_params(axis="x", nbins=4)
    labels = [left.get_legend_handles_labels(), middle.get_legend_handles_labels()]
    figure.legend(*(a + b for a, b in zip(*labels, strict=True)), loc="outside upper left", ncols=4)
    return figure


@styled
def forest(found: Breeding, title: str = "") -> Figure:
    """Plot each estimate of the whole run with its interval, and the estimates of cohorts as small dots.

    Parameters
    ----------
    found : Breeding
        From `gradients`.
    title : str, default ""

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from ecs_eco.analysis.breeding import Breeding, Cohort, forest
    >>> from ecs_eco.analysis.survival import Interval
    >>> cohort = Cohort(0, 9, 5, 0.0, 5.0, {"β size": Interval(0.1, 0.0, 0.2)})
    >>> forest(Breeding("finch", ("size",), 9.0, (cohort,), cohort)).axes[0].get_xlabel()
    'selection gradient'
    """
    terms = list(found.whole.estimates)
    figure, ((ax,),) = panels(1, 1, 7, 0.45 * len(terms) + 1.3)
    rows = np.arange(len(terms))
    for c in found.cohorts:
        ax.plot([c.estimates[term].value for term in terms], rows, ".", color=GREY, ms=4, zorder=1)
    value, low, high = np.array([found.whole.estimates[term] for term in terms]).T
    ax.errorbar(value, rows, xerr=(value - low, high - value), fmt="o", color=INK, lw=1.6)
    ax.axvline(0, color=GREY, lw=0.8)
    ax.set_yticks(rows, terms)
    ax.invert_yaxis()
    ax.set(xlabel="selection gradient", title=title or found.species)
    return figure
