"""Sweeps: alleles that rose by more than drift allows, grouped with the alleles that are linked to them."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.stats import false_discovery_control

from ecs_eco.analysis.pedigree import Pedigree
from ecs_eco.explain.alleles import Allele, Carried, Paths, follow
from ecs_eco.explain.drift import rise_test

LINKED = 0.5  # r² of alleles that belong to one event
WINDOW = 16  # minimum steps of a window within the run
LEVELS = 4  # the smallest windows are a 16th of the run
LEAST = 0.1  # smallest rise that counts as a sweep
Course = Literal["complete", "partial", "balanced", "passing"]


@dataclass(frozen=True)
class Assessment:
    """Tests of alleles, one entry each, on the window of the run in which the allele rose most clearly.

    Attributes
    ----------
    paths : Paths
    window : array of int64, shape (alleles, 2)
        First and last sample of the window.
    s, error : array of float64
        Selection coefficient per generation and its standard error in the window.
    ratio : array of float64
        Likelihood ratio, twice the logarithm.
    p : array of float64
        p-value of a rise, corrected for the number of windows.
    """

    paths: Paths
    window: np.ndarray
    s: np.ndarray
    error: np.ndarray
    ratio: np.ndarray
    p: np.ndarray


@dataclass(frozen=True)
class Sweep:
    """A rise of an allele beyond drift, with the alleles linked to it.

    Attributes
    ----------
    species : str
    lead : Allele
        The allele with the highest likelihood ratio, among letters and values of genes if there are any.
    linked : tuple of (Allele, float)
        Other alleles that rose with it, and their r² with it. They have an r² of at least 0.5, or did not rise
        by more than drift allows among organisms with the same number of copies of the lead.
    ticks : array of int64, shape (samples,)
    path : array of float64, shape (samples,)
        Frequency of the lead.
    begin, half, end : int
        Last tick at which at most a quarter of the rise was over, and ticks at which half and 95% of it are
        reached.
    first, last : float
        Lowest frequency before the rise, and frequency at the end of the run or before the species died out.
    s : float
        Selection coefficient per generation and copy: the slope of the log odds that is due to unequal births and
        deaths, without mutation, in the window of the run in which the rise is clearest.
    interval : tuple of float
        95% interval of s, not corrected for the choice of the window and of the allele.
    generation : float
        Generation time [ticks].
    p, q : float
        p-value, and the same adjusted for the number of alleles tested (Benjamini and Hochberg 1995).
    kind : str
        "complete": at 95% or more at the end of the run; "passing": fell again to a quarter of its rise or
        less; "balanced": level during the last third of the run, which does not prove balancing selection;
        else "partial".
    """

    species: str
    lead: Allele
    linked: tuple[tuple[Allele, float], ...]
    ticks: np.ndarray
    path: np.ndarray
    begin: int
    half: int
    end: int
    first: float
    last: float
    s: float
    interval: tuple[float, float]
    generation: float
    p: float
    q: float
    kind: Course


def assess(paths: Paths) -> Assessment:
    """Test whether alleles rose by more than drift allows, over the whole run and within windows of it.

    Parameters
    ----------
    paths : Paths
        From `follow`.

    Returns
    -------
    Assessment

    Notes
    -----
    Windows are the run and its halves, quarters, eighths and sixteenths, if these have at least 16 steps. Half
    of the error is spent on the run and half on the windows within it (Bonferroni). A step's expected gain is
    s × generations × value × p (1 − p); its variance under drift is the variance of shares among organisms times
    the sum of squared excesses. The gain does not contain mutation or segregation, so they need no model.

    Examples
    --------
    Rats with the letter A have two children each, rats with C none:

    >>> import numpy as np
    >>> from ecs_eco.analysis.lineage import Lineage
    >>> from ecs_eco.explain import assess, follow
    >>> uid, zero = np.arange(1, 41, dtype=np.uint64), np.zeros(20, np.uint64)
    >>> parent, text = np.concatenate([zero, np.repeat(uid[:10], 2)]), np.repeat(["A", "C", "A"], [10, 10, 20])
    >>> born, died, genomes = np.repeat([0, 1], 20), np.repeat([1, -1], 20), {"rat": {"genes": []}}
    >>> species, cause = np.full(40, "rat"), np.full(40, "", object)
    >>> rats = Lineage(uid, parent, 0 * uid, species, born, died, cause, text.astype(object), 1, 1.0, genomes)
    >>> tests = assess(follow(rats, "rat"))
    >>> tests.paths.alleles[0].name, bool(tests.p[0] < 1e-4)
    ('letter A at locus 0', True)
    """
    steps, many = paths.steps, len(paths.alleles)
    maternal = np.array([allele.kind == "clade" for allele in paths.alleles], bool)
    p, variance = paths.p[:-1], paths.variance[:-1]
    odds = paths.p * (1 - paths.p)
    factor = steps.living[:-1] / np.maximum(steps.living[:-1] - 1, 1)
    generations = np.diff(steps.ticks) / steps.generation

    def of(name: str) -> np.ndarray:
        each = np.stack([getattr(steps.both, name), getattr(steps.maternal, name)], 1)
        return np.asarray(each[:, maternal.astype(int)])

    with np.errstate(divide="ignore", invalid="ignore"):
        third = variance**2 / odds[:-1] * (1 - 2 * p)  # p q (1 − 2 p) / k² for k copies
    terms = (
        paths.gain,
        of("square") * variance * factor[:, None],
        of("cube") * third,
        of("value") * generations[:, None] * (odds[1:] + odds[:-1]) / 2,
    )
    sums = [_cumulated(np.where(paths.used, term, 0.0)) for term in terms]
    windows = _windows(len(steps.ticks) - 1)
    found = [rise_test(*(of[b] - of[a] for of in sums)) for a, b in windows]
    s, error, ratio, chance = (np.array([one[i] for one in found]) for i in range(4))
    within = len(windows) - 1
    if within:
        chance = np.minimum(chance * np.array([2, *[2 * within] * within])[:, None], 1)
    best, column = chance.argmin(axis=0), np.arange(many)
    return Assessment(paths, np.array(windows)[best], *(of[best, column] for of in (s, error, ratio, chance)))


def _cumulated(steps: np.ndarray) -> np.ndarray:
    return np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(np.nan_to_num(steps), axis=0)])


def _windows(steps: int) -> list[tuple[int, int]]:
    """Return the limits of the run and of its equal parts."""
    parts = [1, *(2**k for k in range(1, LEVELS + 1) if steps // 2**k >= WINDOW)]
    cuts = [np.linspace(0, steps, n + 1).astype(int).tolist() for n in parts]
    return [pair for cut in cuts for pair in zip(cut[:-1], cut[1:], strict=True)]


def rises(
    lineage: Pedigree, species: str | None = None, *, fdr: float = 0.01, every: int | None = None
) -> list[Sweep]:
    """Return the sweeps of a run: alleles that rose by more than drift allows.

    Parameters
    ----------
    lineage : Lineage
    species : str, optional
        Default: every species of which organisms were born to recorded parents.
    fdr : float, default 0.01
        Largest expected proportion of false positives among the alleles that pass the test, before they are
        combined into sweeps.
    every : int, optional
        Ticks between samples; default: half a generation.

    Returns
    -------
    list of Sweep
        Ordered by `begin`. If a species has no recorded genomes, the alleles are clades.

    Raises
    ------
    KeyError
        If the species is unknown.
    ValueError
        If no organism of the species, or of any, was born to recorded parents, or the run is too short.

    Notes
    -----
    Sweeps are rises by at least 10 percentage points. A rise is caused by selection on the allele or on anything
    linked to it; forks in which it is taken out show which. The test treats organisms with and without the
    allele as exchangeable. If relatives share a patch of habitat or a policy, and therefore their fate, drift is
    stronger than measured.

    Examples
    --------
    Of 200 voles, 40 have the letter T, with which they have 1.3 times as many young:

    >>> import numpy as np
    >>> from ecs_eco.analysis.lineage import Lineage
    >>> from ecs_eco.explain import rises
    >>> rng, has, mothers = np.random.default_rng(2), [np.arange(200) < 40], [np.full(200, -1)]
    >>> for year in range(24):
    ...     weight = np.where(has[-1], 1.3, 1.0)
    ...     chosen = rng.choice(200, 200, p=weight / weight.sum())
    ...     has.append(has[-1][chosen])
    ...     mothers.append(200 * year + chosen)
    >>> uid, parent = np.arange(1, 5001, dtype=np.uint64), (np.concatenate(mothers) + 1).astype(np.uint64)
    >>> born = np.repeat(np.arange(25), 200)
    >>> text, cause = np.where(np.concatenate(has), "T", "A").astype(object), np.full(5000, "", object)
    >>> genomes, species = {"vole": {"alphabet": "AT", "ploidy": 1, "genes": []}}, np.full(5000, "vole")
    >>> voles = Lineage(uid, parent, 0 * uid, species, born, born + 1, cause, text, 24, 1.0, genomes)
    >>> sweep = rises(voles)[0]
    >>> sweep.lead.name, sweep.kind, bool(sweep.interval[0] < np.log(1.3) < sweep.interval[1])
    ('letter T at locus 0', 'complete', True)
    """
    return sweeps_and_tests(lineage, species, fdr, every)[0]


def sweeps_and_tests(
    lineage: Pedigree, species: str | None, fdr: float, every: int | None = None
) -> tuple[list[Sweep], dict[str, Assessment]]:
    """Return the sweeps of a run, and the tests of all alleles by species; see `rises`."""
    if not 0 < fdr < 1:
        raise ValueError(f"rises: fdr is {fdr}; expected a number between 0 and 1, such as 0.01")
    names = [species] if species is not None else _reproducing(lineage)
    if not names:
        raise ValueError(
            "lineage: no organism was born to recorded parents, so no allele can rise; "
            "record a world in which a species reproduces"
        )
    tests = [assess(follow(lineage, name, every)) for name in names]
    chances = np.concatenate([of.p for of in tests])
    q = false_discovery_control(chances) if len(chances) else chances
    parts = np.split(q, np.cumsum([len(of.p) for of in tests])[:-1])
    sweeps = [
        sweep for of, part in zip(tests, parts, strict=True) for sweep in _events(lineage, of, part, fdr)
    ]
    return sorted(sweeps, key=lambda sweep: (sweep.begin, -sweep.s)), dict(zip(names, tests, strict=True))


def _reproducing(lineage: Pedigree) -> list[str]:
    """Return species whose alleles can be tested: those with births to older parents of the same species."""
    has = (lineage.mother >= 0) | (lineage.father >= 0)
    parent = np.where(lineage.mother >= 0, lineage.mother, lineage.father)
    if not len(lineage):
        return []
    own = has & (lineage.species == lineage.species[parent]) & (lineage.born > lineage.born[parent])
    return np.unique(lineage.species[own]).tolist()


def _events(lineage: Pedigree, of: Assessment, q: np.ndarray, fdr: float) -> list[Sweep]:
    """Return the sweeps of a species, the clearest first."""
    paths = of.paths
    rose = {int(j): _limits(paths.p[:, j], *of.window[j].tolist()) for j in np.flatnonzero(q <= fdr)}
    left = {j: at for j, at in rose.items() if paths.p[at[1], j] - paths.p[at[0], j] >= LEAST}
    if not left:
        return []
    species, sweeps = paths.alleles[0].species, []
    carried = Carried(lineage.of_species(species), species)
    while left:
        strongest = max(left, key=lambda j: _rank(of, j))
        event = [strongest, *_passengers(carried, of, strongest, [j for j in left if j != strongest], fdr)]
        lead = max(event, key=lambda j: (paths.alleles[j].kind in ("letter", "value"), *_rank(of, j)))
        others = [j for j in sorted(event, key=lambda j: _rank(of, j), reverse=True) if j != lead]
        named = tuple((paths.alleles[j], _r2(carried, paths, lead, j)) for j in others)
        sweeps.append(_sweep(of, lead, *left[lead], named, float(q[lead])))
        for j in event:
            del left[j]
    return sweeps


def _rank(of: Assessment, j: int) -> tuple[float, bool]:
    return round(float(of.ratio[j]), 6), of.paths.alleles[j].kind == "letter"


def _limits(path: np.ndarray, begin: int, end: int) -> tuple[int, int]:
    """Return the samples with an allele's lowest frequency before its highest in a window, and the highest."""
    path = np.nan_to_num(path[begin : end + 1])
    top = int(path.argmax())
    low = top - int(path[top::-1].argmin())
    return begin + low, begin + top


def _passengers(carried: Carried, of: Assessment, lead: int, others: list[int], fdr: float) -> list[int]:
    """Return the alleles that are linked to the lead: by r², or because they did not rise by more than drift
    allows among organisms with the same number of copies of the lead."""
    paths, steps, n = of.paths, of.paths.steps, len(of.paths.ticks) - 1
    copies = np.rint(2 * carried.share(paths.alleles[lead])).astype(int)  # none, some, or most
    group = 3 * steps.step + copies[steps.organism]
    number = np.maximum(np.bincount(group, minlength=3 * n), 1)
    total = number.reshape(n, 3).sum(axis=1)
    found = []
    for j in others:
        if _r2(carried, paths, lead, j) >= LINKED:
            found.append(j)
            continue
        with_j, line = carried.share(paths.alleles[j])[steps.organism], steps.both
        if paths.alleles[j].kind == "clade":
            line = steps.maternal
        mean = np.bincount(group, with_j, 3 * n) / number
        rest = with_j - mean[group]  # the part of its share that the lead does not predict
        gain = np.bincount(steps.step, line.excess * rest, n)
        variance = line.square * np.bincount(steps.step, rest**2, n) / total
        used = paths.used[:, j] & (np.arange(n) >= of.window[j, 0]) & (np.arange(n) < of.window[j, 1])
        sums = (np.array([terms[used].sum()]) for terms in (gain, variance, 0 * gain, 1 + 0 * gain))
        if rise_test(*sums)[3][0] > fdr / len(others):
            found.append(j)
    return found


def _r2(carried: Carried, paths: Paths, a: int, b: int) -> float:
    """Return the squared correlation of two alleles among the living at the sample at which both vary most;
    0 if they exclude each other more often than not."""
    both = np.nan_to_num(paths.variance[:, a] * paths.variance[:, b])
    at = int(both.argmax())
    if both[at] <= 0:
        return 0.0
    rows = np.flatnonzero(carried.own.alive(int(paths.ticks[at])))
    x, y = (carried.share(paths.alleles[j], rows) for j in (a, b))
    return max(float(np.corrcoef(x, y)[0, 1]), 0.0) ** 2


def _sweep(
    of: Assessment, j: int, low: int, top: int, linked: tuple[tuple[Allele, float], ...], q: float
) -> Sweep:
    paths, path = of.paths, of.paths.p[:, j]
    seen = np.flatnonzero(np.isfinite(path))
    first, last, rise = path[low], path[seen[-1]], path[top] - path[low]
    before = np.flatnonzero(path[low : top + 1] <= first + 0.25 * rise)
    begin = low + int(before[-1])
    half, end = (
        begin + int(np.flatnonzero(path[begin : top + 1] >= first + share * rise)[0]) for share in (0.5, 0.95)
    )
    s, error, allele = float(of.s[j]), float(of.error[j]), paths.alleles[j]
    return Sweep(
        species=allele.species,
        lead=allele,
        linked=linked,
        ticks=paths.ticks,
        path=path,
        begin=int(paths.ticks[begin]),
        half=int(paths.ticks[half]),
        end=int(paths.ticks[end]),
        first=float(first),
        last=float(last),
        s=s,
        interval=(s - 1.96 * error, s + 1.96 * error),
        generation=paths.steps.generation,
        p=float(of.p[j]),
        q=q,
        kind=_kind(path[seen], float(first), float(rise), int(np.searchsorted(seen, end))),
    )


def _kind(path: np.ndarray, first: float, rise: float, end: int) -> Course:
    """Return the kind of a rise that ended at a sample."""
    third = 2 * len(path) // 3
    late = path[third:]
    if path[-1] >= 0.95:
        return "complete"
    if path[-1] <= first + 0.25 * rise:
        return "passing"
    halves = late[: len(late) // 2], late[len(late) // 2 :]
    level = len(late) > 3 and abs(halves[1].mean() - halves[0].mean()) <= 0.1 * rise
    return "balanced" if level and end <= third else "partial"
