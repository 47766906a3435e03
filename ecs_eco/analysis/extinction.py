"""Extinctions: which species died out, when and why. Every report on runs opens with these facts."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ecs_eco.analysis.runs import DIED, Series


@dataclass(frozen=True)
class Decline:
    """The decline of a species, from the last tick with at least half of its peak number to its extinction."""

    species: str
    tick: int  # tick of extinction
    since: int
    n: int  # number at `since`
    births: int | None  # births after `since`; None if the run does not count them
    causes: dict[str, int] = field(default_factory=dict)  # deaths after `since`, most frequent first

    @property
    def deaths(self) -> int:
        """Number of deaths in the decline, from all causes."""
        return sum(self.causes.values())

    def shares(self) -> str:
        """Return the causes with their shares: "starved 80%, eaten by wolf 20%"; "" if none are known."""
        return ", ".join(f"{cause} {k / self.deaths:.0%}" for cause, k in self.causes.items())


def decline(series: Series, species: str) -> Decline | None:
    """Return the decline of a species to its extinction.

    Parameters
    ----------
    series : Series
    species : str

    Returns
    -------
    Decline or None
        None if the species is alive at the end or was never present.

    Raises
    ------
    KeyError
        If the species is unknown.

    Examples
    --------
    >>> from ecs_eco.analysis.extinction import decline
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series({"hare": [10, 12, 9], "lynx": [4, 3, 0]})
    >>> decline(series, "lynx").tick, decline(series, "hare")
    (2, None)
    """
    i, n = series.index(species), series.of(species)
    if np.isnan(series.extinct[i]) or not series.present[i]:
        return None
    end = int(np.searchsorted(series.ticks, series.extinct[i]))
    high = np.flatnonzero(n[: end + 1] >= max(0.5 * n[: end + 1].max(), 1))
    since = int(high[-1]) if len(high) else -1  # −1: extinct within the first tick
    after = slice(since + 1, end + 1)
    counts = {c: int(series.of(species, DIED + c)[after].sum()) for c in series.causes}
    counts = {c: k for c, k in sorted(counts.items(), key=lambda x: -x[1]) if k}
    births = int(series.of(species, "births")[after].sum()) if "births" in series.columns else None
    number = n[since] if since >= 0 else series.of(species, "deaths")[0]
    first = int(series.ticks[max(since, 0)])
    return Decline(species, int(series.extinct[i]), first, int(number), births, counts)


def declines(series: Series) -> list[Decline]:
    """Return the declines of a run's extinct species in chronological order.

    Parameters
    ----------
    series : Series

    Returns
    -------
    list of Decline

    Examples
    --------
    >>> from ecs_eco.analysis.extinction import declines
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series({"hare": [10, 12, 9], "lynx": [4, 3, 0]})
    >>> [end.species for end in declines(series)]
    ['lynx']
    """
    all_declines = [d for s in series.species if (d := decline(series, s)) is not None]
    return sorted(all_declines, key=lambda d: d.tick)


def lifetime(series: Series) -> tuple[float, bool]:
    """Return the time to a run's first extinction.

    Parameters
    ----------
    series : Series

    Returns
    -------
    ticks : float
        Time to the first extinction, or the length of the run.
    died : bool
        Whether a species died out.

    Examples
    --------
    >>> from ecs_eco.analysis.extinction import lifetime
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series({"hare": [10, 12, 9], "lynx": [4, 3, 0]})
    >>> lifetime(series)
    (2.0, True)
    """
    gone = series.extinct[series.present]
    if np.isnan(gone).all():
        return float(series.length), False
    return float(np.nanmin(gone) - series.ticks[0]), True


def opening(series: Series) -> list[str]:
    """Return the opening of a run's report: whether all species persisted or which died out, when and why.

    Parameters
    ----------
    series : Series

    Returns
    -------
    list of str
        One sentence per item.

    Examples
    --------
    >>> from ecs_eco.analysis.extinction import opening
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series({"hare": [10, 12, 9], "lynx": [4, 3, 0]})
    >>> opening(series)[0]
    '1 of 2 species died out; hare persisted to tick 3.'
    """
    lived = series.there
    if not lived:
        return ["No species had a living member at the end of any tick."]
    lost, end = declines(series), f"tick {series.ticks[-1] + 1:,.0f}"
    kept = [s for s in lived if s not in {d.species for d in lost}]
    whole = f"All {len(lived)} species" if len(lived) > 1 else f"The only species, {lived[0]},"
    if not lost:
        first = f"{whole} persisted to {end}."
    elif not kept:
        first = f"{whole} died out; no organism is alive at the end ({end})."
    else:
        first = f"{len(lost)} of {len(lived)} species died out; {', '.join(kept)} persisted to {end}."
    absent = [s for s in series.species if s not in lived]
    barren = [d.species for d in lost if not multiplies(series, d.species)]
    expected = [f"{s} cannot reproduce in this world, so its extinction was expected." for s in barren]
    never = [f"Never present: {', '.join(absent)}."] * bool(absent)
    return [first, *map(sentence, lost), *expected, *never]


def swings(series: Series, most: int = 3) -> list[str]:
    """Return the largest rise or fall of each species that at least doubled or halved and did not die out.

    Parameters
    ----------
    series : Series
    most : int, default 3
        Maximum number of species, largest changes first.

    Returns
    -------
    list of str
        One sentence per species. Numbers below 20 at the high are ignored, because they often double by chance.

    Examples
    --------
    >>> from ecs_eco.analysis.extinction import swings
    >>> from ecs_eco.analysis.runs import load_series
    >>> swings(load_series({"hare": [10, 50, 40], "lynx": [4, 3, 3]}))
    ['Hare rose from 10 at tick 0 to 50 at tick 1, 5.0 times as many.']
    """
    found = []
    for i, species in enumerate(series.species):
        n = series.n[:, i].astype(float)
        if not n.size or not n[-1]:
            continue
        rises = n / np.maximum(np.minimum.accumulate(n), 1)
        falls = np.maximum.accumulate(n) / np.maximum(n, 1)
        up = rises.max() >= falls.max()
        end = int((rises if up else falls).argmax())
        start = int((n[: end + 1] if up else -n[: end + 1]).argmin())
        fold = float(max(rises.max(), falls.max()))
        if fold >= 2 and max(n[start], n[end]) >= 20:
            ends = (f"{n[k]:,.0f} at tick {series.ticks[k]:,.0f}" for k in (start, end))
            how = f"{'rose' if up else 'fell'} from {' to '.join(ends)}"
            last = f"{fold:,.1f} times" if up else f"{1 / fold:.0%}"
            found.append((-fold, f"{species[0].upper()}{species[1:]} {how}, {last} as many."))
    return [text for _, text in sorted(found)[:most]]


def multiplies(series: Series, species: str) -> bool:
    """Return whether a species had offspring or can reproduce (assumed if there is no configuration)."""
    known = series.manifest.get("config", {}).get("species", {}).get(species, {"reproduction": "unknown"})
    born = "births" in series.columns and series.of(species, "births").any()
    return bool(known.get("reproduction") or born)


def sentence(end: Decline) -> str:
    """Return a sentence on when a species died out, and on the deaths during its decline."""
    born = "" if end.births is None else f"{end.births:,} birth{'s' * (end.births != 1)} and "
    how = f"; {born}{end.deaths:,} death{'s' * (end.deaths != 1)} followed: {end.shares()}" * bool(end.causes)
    return f"{end.species} died out at tick {end.tick:,}. At tick {end.since:,}, there were {end.n:,}{how}."


def shared(runs: Sequence[Series]) -> str:
    """Return the opening of a report on several runs: how often all species persisted, and why species died out."""
    n, kept = len(runs), sum(run.persisted for run in runs)
    first = f"All species persisted in {kept} of {n} run{'s' * (n != 1)} ({kept / n:.0%})."
    all_declines = [d for run in runs for d in declines(run)]
    sentences = []
    for species in dict.fromkeys(d.species for d in all_declines):
        of = [d for d in all_declines if d.species == species]
        causes = sum((Counter(d.causes) for d in of), Counter[str]())
        pooled = Decline(species, 0, 0, 0, None, dict(causes.most_common()))
        ticks = sorted(d.tick for d in of)
        when = f"at tick {ticks[0]:,}" if len(of) == 1 else f"at ticks {ticks[0]:,} to {ticks[-1]:,}"
        why = f" ({pooled.shares()})" if causes else ""
        sentences.append(f"{species} died out in {len(of)} of {n}, {when}{why}.")
    return " ".join([first, *sentences])
