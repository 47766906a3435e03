"""A sweep in plain English: what rose, what rose with it, and what taking it out changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, TypedDict, Unpack

import numpy as np

from ecs_eco.analysis.page import number
from ecs_eco.analysis.survival import Interval
from ecs_eco.engine.errors import ConfigError
from ecs_eco.explain.alleles import Allele
from ecs_eco.explain.edits import AlleleLike, Edit
from ecs_eco.explain.events import Sweep
from ecs_eco.explain.taken_out import TakenOut, clear, driver, take_out

MOST = 3  # linked alleles of a sweep that are also named and taken out
LATER = {
    "complete": "",
    "partial": " {end}, it was at {last:.0%}.",
    "balanced": " It then stayed level. {end}, it was at {last:.0%}.",
    "passing": " Later, it fell again. {end}, it was at {last:.0%}.",
}
ENDS = "At the end of the run", "At the last sample before the species died out"


class Options(TypedDict, total=False):
    """Options of `take_out` that do not choose what is compared."""

    ticks: int | None
    seed: int
    engine: str | Executor
    workers: int | None
    trust: bool


class Which(TypedDict):
    """The choice of what is taken out, and how often: see `account`."""

    tick: int | None
    forks: int
    learned: bool


@dataclass(frozen=True)
class Account:
    """A sweep with the forks in which its alleles were taken out.

    Attributes
    ----------
    sweep : Sweep
    taken : tuple of (Allele, TakenOut)
        The lead first, then linked alleles of other genes or loci.
    gap : str
        The reason if an allele could not be taken out, or learning not undone; else "".
    learned : TakenOut or None
        A 2 × 2 comparison: the lead (or the first allele that can be taken out) and learning.
    """

    sweep: Sweep
    taken: tuple[tuple[Allele, TakenOut], ...] = ()
    gap: str = ""
    learned: TakenOut | None = None

    @property
    def driver(self) -> Allele | None:
        """The allele that raises births most; None if none raises them clearly."""
        found = driver([taken for _, taken in self.taken])
        return next((allele for allele, taken in self.taken if taken is found), None)

    def sentences(self) -> list[str]:
        """Return the sweep in plain English."""
        lines = [rose(self.sweep), *rose_together(self.sweep)]
        if self.taken:
            lines.append(without(*self.taken[0]))
        if len(self.taken) > 1:
            lines.append(drove(self.taken, self.driver))
        if self.learned is not None:
            lines.append(born_or_learned(self.learned))
        return [*lines, self.gap] if self.gap else lines

    def to_json(self) -> dict[str, Any]:
        """Return all numbers and sentences except the path over time."""
        sweep = {k: v for k, v in asdict(self.sweep).items() if k not in ("ticks", "path")}
        return sweep | {
            "lead": self.sweep.lead.name,
            "linked": [{"allele": allele.name, "r2": r2} for allele, r2 in self.sweep.linked],
            "driver": self.driver.name if self.driver else None,
            "effects": self.effects(),
            "learned": None
            if self.learned is None
            else {
                of: self.learned.effect("births", of)._asdict()
                for of in ("first", "second", "both", "interaction")
            },
            "sentences": self.sentences(),
        }

    def effects(self) -> list[dict[str, Any]]:
        """Return a row for each allele that was taken out and each measure, with control, effect, low and high."""
        return [
            {
                "species": self.sweep.species,
                "allele": allele.name,
                "was": taken.edits[0].was,
                "tick": taken.tick,
            }
            | {"forks": len(taken.n), "measure": measure, "control": taken.control(measure).value}
            | dict(zip(("effect", "low", "high"), taken.effect(measure), strict=True))
            for allele, taken in self.taken
            for measure in taken.means
        ]


def account(
    run: Path | str,
    sweep: Sweep,
    *,
    tick: int | None = None,
    forks: int = 24,
    learned: bool = False,
    progress: Callable[[int, int], None] | None = None,
    **how: Unpack[Options],
) -> Account:
    """Take the alleles of a sweep out in forks of a recorded run, each separately.

    Parameters
    ----------
    run : str or Path
    sweep : Sweep
        From `rises`.
    tick : int, optional
        Tick of the forks; default: when half of the rise is reached.
    forks : int, default 24
        0: take nothing out.
    learned : bool, default False
        Whether to undo learning, too: in a 2 × 2 comparison, policies get back their weights at birth.
    progress : callable, optional
        Called as `progress(done, forks)`.
    **how
        Other arguments of `take_out`: ticks, seed, engine, workers, trust.

    Returns
    -------
    Account
    """
    chosen = candidates(sweep) if forks else []
    gaps = [f"No allele can be taken out: {sweep.lead.name} is not a letter, value or copy number of a gene."]
    gaps = gaps if forks and not chosen else []
    jobs: list[tuple[AlleleLike, ...]] = [(allele,) for allele in chosen]
    if learned and chosen:
        jobs.append((chosen[0], Edit(sweep.species, "policy")))
    taken: list[tuple[Allele, TakenOut]] = []
    two: TakenOut | None = None
    for i, job in enumerate(jobs):

        def show(done: int, _: int, before: int = i * forks) -> None:
            if progress is not None:
                progress(before + done, len(jobs) * forks)

        try:
            at = sweep.half if tick is None else tick
            found = take_out(run, job, tick=at, forks=forks, progress=show, **how)
        except ConfigError:  # for example, code that is not trusted: nothing can be taken out
            raise
        except ValueError as error:
            what = "Undoing learning" if i == len(chosen) else f"Taking out {chosen[i].name}"
            gaps.append(f"{what} failed: {str(error).rstrip('.')}.")
            continue
        if i == len(chosen):
            two = found
        else:
            taken.append((chosen[i], found))
    return Account(sweep, tuple(taken), " ".join(gaps), two)


def candidates(sweep: Sweep) -> list[Allele]:
    """Return the lead and up to 3 linked alleles that can be taken out. Of a gene's value and the letters that
    code for it, only the first to appear is included."""
    chosen: list[Allele] = []
    for allele in (sweep.lead, *(allele for allele, _ in sweep.linked)):
        same = {one.kind for one in chosen if one.gene and one.gene == allele.gene}
        if allele.kind in ("letter", "value", "copies") and (not same or same == {allele.kind} == {"letter"}):
            chosen.append(allele)
    return chosen[: 1 + MOST]


# --- sentences ----------------------------------------------------------------------------------------------


def rose(sweep: Sweep) -> str:
    """Return the sentence on a rise."""
    (low, high), gone = sweep.interval, bool(np.isnan(sweep.path[-1]))
    end = ENDS[gone]
    top = float(sweep.path[sweep.ticks <= sweep.end][-1])
    return (
        f"In the species {sweep.species}, {sweep.lead.name} rose from {sweep.first:.0%} to {top:.0%}, mostly "
        f"between ticks {sweep.begin:,} and {sweep.end:,}. Its selection coefficient is {number(sweep.s, 2)} (95% "
        f"interval: {number(low, 2)} to {number(high, 2)}) per generation of {number(sweep.generation)} ticks."
        f"{LATER[sweep.kind].format(last=sweep.last, end=end) if gone or abs(sweep.last - top) >= 0.02 else ''}"
    )


def rose_together(sweep: Sweep) -> list[str]:
    """Return the sentence on linked alleles, if there are any."""
    names = [f"{allele.name} (r² = {r2:.2f})" for allele, r2 in sweep.linked[:MOST]]
    if (more := len(sweep.linked) - MOST) > 0:
        names.append(f"{more} more")
    return [f"It rose together with {listed(names)}."] if names else []


def without(allele: Allele, taken: TakenOut) -> str:
    """Return the sentences on what changes if an allele is taken out."""
    instead = replace(allele, value=taken.edits[0].was).name.partition(" at locus")[0]
    births, lived, usual = taken.effect("births"), taken.effect("survival"), taken.control("births").value
    many = round(float(taken.n.sum(axis=1).mean()))
    lines = [
        f"In {len(taken.n)} fork{'s' * (len(taken.n) != 1)} at tick {taken.tick:,}, {instead} replaced "
        f"{allele.name} in a random half of {many:,} carriers."
    ]
    if np.isnan(births.low):
        lines.append(
            f"Without the allele, the number of young differs by {number(births.value, 2)}; one fork gives no "
            "interval."
        )
    elif not clear(births):
        lines.append(
            "Without the allele, the number of young does not differ clearly; the difference is "
            f"{signed(births)}."
        )
    else:
        word = "fewer" if births.value < 0 else "more"
        lines.append(f"Then they had {sized(births)} {word} young each; the others had {number(usual, 2)}.")
    if clear(lived):
        lines.append(f"They lived {sized(lived)} ticks {'less' if lived.value < 0 else 'longer'}.")
    more = {m.removeprefix("died: "): taken.effect(m) for m in taken.means if m.startswith("died: ")}
    cause, x = max(more.items(), key=lambda one: one[1].value, default=("", births))
    if cause and x.low > 0:
        value, low, high = (number(100 * part, 2) for part in x)
        lines.append(
            f"Among causes of death, “{cause}” increased most, by {value} percentage points ({low} to {high})."
        )
    return " ".join(lines)


def drove(taken: Sequence[tuple[Allele, TakenOut]], found: Allele | None) -> str:
    """Return the sentence on which of several alleles, each taken out separately, drove the rise."""
    if found is None:
        names = listed([allele.name for allele, _ in taken])
        return (
            f"Separate removals of {names} do not clearly lower the number of young, so the forks do not show "
            "which one drove the rise."
        )
    if also := [allele.name for allele, one in taken if allele != found and driver([one])]:
        return (
            f"Removing {found.name} lowers the number of young most, but removing {listed(also)} also lowers it "
            "clearly: more than one allele may have driven the rise."
        )
    return (
        f"Removing {found.name} clearly lowers the number of young, and no other removal does, so this allele "
        "probably drove the rise."
    )


def born_or_learned(taken: TakenOut) -> str:
    """Return the sentences on a 2 × 2 of an allele and of learning: is the advantage inherited, learned or both?"""
    ways = {"first": "the allele", "second": "what they had learned", "both": "both"}
    effects = {of: taken.effect("births", of) for of in (*ways, "interaction")}
    young = [f"{signed(effects[of])} without {what}" for of, what in ways.items()]
    inherited, learned = (clear(effects[of]) and effects[of].value < 0 for of in ("first", "second"))
    where = {
        (True, True): "Both the allele and learning raise the number of young",
        (True, False): "The allele raises the number of young; an effect of learning is not clear",
        (False, True): "Learning raises the number of young; an effect of the allele is not clear",
        (False, False): "Neither the allele nor learning clearly raises the number of young",
    }[inherited, learned]
    x = effects["interaction"]
    adds = "the two effects do not add up" if clear(x) else "no clear deviation from the sum of both effects"
    return (
        f"Compared with carriers that kept both, the number of young differed by {listed(young)}. {where}. The "
        f"interaction is {signed(x)}: {adds}."
    )


def listed(names: Sequence[str]) -> str:
    """Return names as "a, b and c"."""
    *before, last = names
    return f"{', '.join(before)} and {last}" if before else last


def sized(x: Interval) -> str:
    """Return the size of an effect and its interval, without signs."""
    low, high = sorted((abs(x.low), abs(x.high)))
    return f"{number(abs(x.value), 2)} ({number(low, 2)} to {number(high, 2)})"


def signed(x: Interval) -> str:
    """Return an effect with its interval, if there is one."""
    return number(x.value, 2) + f" ({number(x.low, 2)} to {number(x.high, 2)})" * bool(np.isfinite(x.low))
