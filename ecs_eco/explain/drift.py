"""Drift measured from the pedigree: how unequal the contributions of organisms to the next generation are."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import pearson3

from ecs_eco.analysis.genes import generation_time
from ecs_eco.analysis.pedigree import ALIVE, Pedigree
from ecs_eco.engine.uids import island_of

SAMPLES = 1000  # maximum number of steps
AGES = 64  # maximum number of age classes of a life table


@dataclass(frozen=True)
class Contributions:
    """Excess contributions of organisms to the population in each step of their lives: `excess` f64[rows], in
    newborns.

    `value` f64[steps] is the mean reproductive value of the population during a step, in newborns. `square`
    f64[steps] and `cube` f64[steps] are sums over organisms of the second and third powers of their excess in
    the whole life, divided among steps in proportion to the excess in each.
    """

    excess: np.ndarray
    value: np.ndarray
    square: np.ndarray
    cube: np.ndarray


@dataclass(frozen=True)
class Steps:
    """A species' time divided into steps, and each organism's contribution in each step of its life.

    Attributes
    ----------
    ticks : array of int64, shape (steps + 1,)
        Limits of the steps.
    generation : float
        Mean age of parents at the birth of their offspring [ticks].
    living : array of int64, shape (steps + 1,)
        Living organisms at the limits.
    first, last : array of int64, shape (organisms,)
        Positions in `ticks` of the samples at which an organism lives: first ≤ k < last.
    organism, step : array of int64, shape (rows,)
        Row and step of each contribution.
    pairs : array of int64, shape (steps,)
        Newborns of two parents.
    both, maternal : Contributions
        Contributions by genes, which two parents pass on equally, and by the first parent's line.
    """

    ticks: np.ndarray
    generation: float
    living: np.ndarray
    first: np.ndarray
    last: np.ndarray
    organism: np.ndarray
    step: np.ndarray
    pairs: np.ndarray
    both: Contributions
    maternal: Contributions

    def effective_size(self, ploidy: int = 1) -> np.ndarray:
        """Return the effective number of gene copies with respect to unequal contributions.

        Parameters
        ----------
        ploidy : int, default 1

        Returns
        -------
        array of float64, shape (steps,)
            Unequal contributions in a step change the frequency p of a neutral allele with variance p (1 − p)
            divided by this number. NaN in steps without a positive estimate, for example if all contributions
            are equal.

        Notes
        -----
        The random segregation of two parents' alleles adds p (1 − p) / (2 ploidy value²) for each of their
        newborns if mating is random.

        Examples
        --------
        Of four parents, one has two children, two have one each, and one has none:

        >>> import numpy as np
        >>> from ecs_eco.analysis.lineage import Lineage
        >>> from ecs_eco.explain import steps_of
        >>> uid, parent = np.arange(1, 9, dtype=np.uint64), np.array([0, 0, 0, 0, 1, 1, 2, 3], np.uint64)
        >>> born, died, text = np.repeat([0, 1], 4), np.repeat([1, -1], 4), np.full(8, "", object)
        >>> rats = Lineage(uid, parent, 0 * uid, np.full(8, "rat"), born, died, text, text, end=1)
        >>> steps_of(rats, every=1).effective_size().tolist()
        [8.0]
        """
        of = self.both
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(of.square > 0, ploidy * of.value**2 / of.square, np.nan))


def steps_of(lineage: Pedigree, every: int | None = None) -> Steps:
    """Divide a species' time into steps and measure how much each organism contributes in each.

    Parameters
    ----------
    lineage : Lineage
        The lineage of a single species.
    every : int, optional
        Length of a step [ticks]; default: half a generation, or longer to have at most 1,000 steps.

    Returns
    -------
    Steps

    Raises
    ------
    ValueError
        If no organism was born to recorded parents, or the run has fewer than two samples.

    Notes
    -----
    An organism's contribution in a step is the number of its newborns, each counting 1/2 for each of two
    parents, plus its reproductive value at the end of the step (0 if it died). Its excess is this contribution
    minus its value at the beginning of the step times the growth of the population's (or island's) total.
    Reproductive value is the expected number of births still to come at an age, relative to a newborn's (Fisher
    1930, without discounting for growth), from the life table of the whole run. It makes contributions in
    successive steps uncorrelated although generations overlap (Engen, Lande and Sæther 2005, Genetics 170,
    941–954). The sum of an allele's shares times excesses is the first term of the Price equation (1970, Nature
    227, 520–521): its change in frequency without mutation and without the random segregation of two parents'
    alleles.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.lineage import Lineage
    >>> from ecs_eco.explain import steps_of
    >>> uid, parent = np.arange(1, 7, dtype=np.uint64), np.array([0, 0, 1, 1, 3, 4], np.uint64)
    >>> born, died = np.array([0, 0, 2, 2, 4, 4]), np.array([3, 3, 5, 5, -1, -1])
    >>> text = np.full(6, "", object)
    >>> rats = Lineage(uid, parent, 0 * uid, np.full(6, "rat"), born, died, text, text, end=5)
    >>> steps_of(rats, every=2).living.tolist()
    [2, 4, 4]
    """
    name = str(lineage.species[0]) if len(lineage) else "the species"
    generation = generation_time(lineage, name)
    if not generation > 0:
        raise ValueError(
            f"lineage: no {name} was born to parents whose births are recorded, so nothing can be inherited; "
            "choose a species that reproduces, or record a longer run"
        )
    every = every or max(1, round(generation / 2), -(-lineage.end // SAMPLES))
    ticks = lineage.samples(every)
    if len(ticks) < 2:
        raise ValueError(
            f"lineage: {lineage.end + 1} ticks are fewer than a step of {every}; record a longer run"
        )
    died = np.where(lineage.died == ALIVE, lineage.end + 1, lineage.died)
    first, last = np.searchsorted(ticks, lineage.born), np.searchsorted(ticks, died)
    begins = np.maximum(first - 1, 0)  # the step in which it is born, or the run's first
    rows = np.maximum(np.minimum(last, len(ticks) - 1) - begins, 0)
    offset = np.cumsum(rows) - rows
    organism = np.repeat(np.arange(len(lineage)), rows)
    step = np.arange(len(organism)) - np.repeat(offset - begins, rows)
    _, group = np.unique(island_of(lineage.uid), return_inverse=True)  # islands have their own growth
    measured = []
    for father_share in (0.5, 0.0):
        parent, child, share = _births(lineage, father_share)
        values = _reproductive_values(lineage.born, died, parent, child, share)
        at = np.minimum(np.maximum(first[child] - 1, 0) - begins[parent], rows[parent] - 1)
        there = at >= 0
        births = np.bincount((offset[parent] + at)[there], share[there], len(organism))
        measured.append(_contributions(lineage.born, died, ticks, organism, step, group, values, births))
    two = (lineage.mother >= 0) & (lineage.father >= 0)
    pairs = np.bincount(np.maximum(first[two] - 1, 0), minlength=len(ticks))[: len(ticks) - 1]
    living = lineage.living_sums(ticks)
    return Steps(ticks, generation, living, first, last, organism, step, pairs, *measured)


def _births(lineage: Pedigree, father_share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return parent and child of each birth and the share of the child that counts for this parent; of the
    two parents, the second one counts `father_share`."""
    mother, father = lineage.mother, lineage.father
    two = (mother >= 0) & (father >= 0)
    parts = [(mother, np.where(two, 1 - father_share, 1.0)), (father, np.where(two, father_share, 1.0))]
    chosen = [(line[has], np.flatnonzero(has), share[has]) for line, share in parts for has in [line >= 0]]
    parent, child, shares = (np.concatenate(arrays) for arrays in zip(*chosen, strict=True))
    return parent, child, shares


def _reproductive_values(
    born: np.ndarray, died: np.ndarray, parent: np.ndarray, child: np.ndarray, share: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return ages [ticks] and the reproductive values at them, relative to a newborn's."""
    ended = died < died.max()  # the others may still be alive
    passed = died - born - ~ended  # ticks that an organism began to live, the last of which may be its death
    width = max(1, -(-int(passed.max()) // AGES))
    classes = max(1, -(-int(passed.max()) // width))
    exposure = np.array([np.clip(passed - j * width, 0, width).sum() for j in range(classes)], float)
    deaths = np.bincount((passed[ended & (passed > 0)] - 1) // width, minlength=classes)
    at = np.minimum(born[child] - born[parent], passed[parent]) - 1
    births = np.bincount(np.maximum(at, 0) // width, share, classes)
    exposure = np.maximum(exposure, 1)
    survival, fecundity = np.clip(1 - deaths / exposure, 0, 1), births / exposure
    values = np.zeros(classes + 1)
    for j in range(classes - 1, -1, -1):
        alive = survival[j] ** np.arange(width)
        values[j] = fecundity[j] * alive.sum() + survival[j] ** width * values[j + 1]
    return np.arange(classes + 1) * width, values / values[0]


def _contributions(
    born: np.ndarray,
    died: np.ndarray,
    ticks: np.ndarray,
    organism: np.ndarray,
    step: np.ndarray,
    group: np.ndarray,
    values: tuple[np.ndarray, np.ndarray],
    births: np.ndarray,
) -> Contributions:
    n, begin, finish, of = len(ticks) - 1, ticks[step], ticks[step + 1], born[organism]
    before = np.interp(np.maximum(begin - of, 0), *values)
    after = np.where(died[organism] > finish, np.interp(finish - of, *values), 0.0)
    old = of <= begin
    value = (np.bincount(step, before * old, n) + np.bincount(step, after, n)) / 2
    after += births
    place = group[organism] * n + step
    total, reached = np.bincount(place, before), np.bincount(place, after)
    growth = reached / np.where(total > 0, total, 1.0)
    excess = after - growth[place] * before
    whole = np.bincount(organism, excess, len(born))[organism]  # of the whole life
    return Contributions(
        excess, value, np.bincount(step, excess * whole, n), np.bincount(step, excess * whole**2, n)
    )


def rise_test(
    gain: np.ndarray, variance: np.ndarray, cube: np.ndarray, information: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Test whether alleles gained more than drift allows.

    Parameters
    ----------
    gain : array of float64
        Sum over steps of an allele's gain in copies, Σ share × excess.
    variance, cube : array of float64
        Sums of the gain's variance and third central moment under drift.
    information : array of float64
        Sum of value × generations × p (1 − p), the gain that s = 1 gives.

    Returns
    -------
    s : array of float64
        Selection coefficient per generation: the slope of the log odds.
    error : array of float64
        Its standard error.
    ratio : array of float64
        Likelihood ratio, twice the logarithm.
    p : array of float64
        p-value of a rise.

    Notes
    -----
    The gain is normal with mean s × information under a Gaussian approximation of Wright–Fisher paths
    (Lacerda and Seoighe 2014, Genetics 198, 1237–1250; Feder et al. 2014, Genetics 196, 509–522). Births are
    counts, so the gain of a rare allele is skewed. p is from a Pearson type III distribution with the same
    skewness, or with 0 if it is negative, as for common alleles, because such a distribution has an upper limit.
    p is doubled, because an allele that reaches fixation early has a more extreme ratio of gain to variance: by
    a given time, a random walk has passed a limit twice as often as it is beyond it at that time (reflection
    principle). A chi-squared test has too many false positives (Feder et al. 2014).

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.explain.drift import rise_test
    >>> s, error, ratio, p = rise_test(*np.array([[10.0], [25.0], [0.0], [50.0]]))
    >>> float(s[0]), float(error[0]), float(ratio[0]), round(float(p[0]), 4)
    (0.2, 0.1, 4.0, 0.0455)
    """
    known = (variance > 0) & (information > 0)
    variance, information = np.where(known, variance, 1.0), np.where(known, information, 1.0)
    z = np.where(known, gain / np.sqrt(variance), 0.0)
    skew = np.clip(np.where(known, cube / variance**1.5, 0.0), 0, 1.9)
    p = np.where(known, np.minimum(2 * pearson3.sf(z, skew), 1), 1.0)
    missing = np.where(known, 1.0, np.nan)
    return gain / information * missing, np.sqrt(variance) / information * missing, z**2, p
