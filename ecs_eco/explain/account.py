"""A sweep in plain English: what rose, what rose with it, and what taking it out changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypedDict, Unpack, cast

import numpy as np

from ecs_eco.analysis.page import number
from ecs_eco.analysis.survival import Interval, difference_of_intervals
from ecs_eco.engine.arguments import called_with
from ecs_eco.engine.errors import ConfigError, in_words
from ecs_eco.explain.alleles import Allele, Kind
from ecs_eco.explain.edits import AlleleLike, Edit
from ecs_eco.explain.events import Sweep
from ecs_eco.explain.taken_out import CONTRASTS, TakenOut, clear, driver, take_out

MOST = 3  # linked alleles of a sweep that are also named and taken out
LATER = {
    "complete": "",
    "partial": " {end}, it was at {last:.0%}.",
    "balanced": " It then stayed level. {end}, it was at {last:.0%}.",
    "passing": " Later, it fell again. {end}, it was at {last:.0%}.",
}
ENDS = "At the end of the run", "At the last sample before the species died out"
MOMENTS = {"before": "begin", "within": "half", "after": "end"}
"""Words for ticks of forks, and the ticks of a sweep that they mean."""
When = int | str | Sequence[int | str] | None
JOBS = {"taken": "Taking out", "reverse": "Putting in", "together": "Taking out", "learned": "Undoing"}


class Options(TypedDict, total=False):
    """Options of `take_out` that do not choose what is compared."""

    ticks: int | None
    seed: int
    engine: str | Executor
    workers: int | None
    trust: bool


class Which(TypedDict):
    """The choice of what is taken out, when and how often: see `account`."""

    tick: When
    forks: int
    learned: bool
    reverse: bool


class Job(NamedTuple):
    """Alleles that forks at a tick take out or, if the kind is "reverse", put in."""

    kind: str
    alleles: tuple[AlleleLike, ...]
    tick: int

    @property
    def task(self) -> str:
        """Its name in error messages."""
        names = in_words([named(allele) for allele in self.alleles])
        return "Undoing learning" if self.kind == "learned" else f"{JOBS[self.kind]} {names}"


@dataclass(frozen=True)
class Account:
    """A sweep with the forks in which its alleles were taken out.

    Attributes
    ----------
    sweep : Sweep
    taken : tuple of (Allele, TakenOut)
        The lead first, then linked alleles of other genes or loci; then the same at other ticks.
    gap : str
        The reason if an allele could not be taken out, or learning not undone; else "".
    learned : TakenOut or None
        A 2 × 2 comparison: the lead (or the first allele that can be taken out) and learning.
    reverse : TakenOut or None
        The same allele put into organisms without it.
    together : (Allele, TakenOut) or None
        A 2 × 2 comparison: the same allele, and the given allele of another sweep.
    """

    sweep: Sweep
    taken: tuple[tuple[Allele, TakenOut], ...] = ()
    gap: str = ""
    learned: TakenOut | None = None
    reverse: TakenOut | None = None
    together: tuple[Allele, TakenOut] | None = None

    @property
    def at_first_tick(self) -> tuple[tuple[Allele, TakenOut], ...]:
        """The alleles that were taken out at the first of the ticks."""
        return tuple(one for one in self.taken if one[1].tick == self.taken[0][1].tick)

    @property
    def driver(self) -> Allele | None:
        """The allele that raises births most, at the first of the ticks; None if none raises them clearly."""
        found = driver([taken for _, taken in self.at_first_tick])
        return next((allele for allele, taken in self.at_first_tick if taken is found), None)

    def sentences(self) -> list[str]:
        """Return the sweep in plain English."""
        lines = [rose(self.sweep), *rose_together(self.sweep)]
        if self.taken:
            lines += [without(*self.taken[0]), *elsewhere(self.taken)]
        if len(self.at_first_tick) > 1:
            lines.append(drove(self.at_first_tick, self.driver))
        if self.reverse is not None:
            lines.append(put_in(self.reverse))
        if self.together is not None:
            lines.append(of_two_sweeps(*self.together))
        if self.learned is not None:
            lines.append(born_or_learned(self.learned))
        return [*lines, self.gap] if self.gap else lines

    def to_json(self) -> dict[str, Any]:
        """Return all numbers and sentences except the path over time."""
        sweep = {k: v for k, v in asdict(self.sweep).items() if k not in ("ticks", "path")}
        return sweep | {
            "lead": self.sweep.lead.name,
            "linked": [{"allele": allele.name, "r2": r2} for allele, r2 in self.sweep.linked],
            "gene": self.sweep.lead.gene,
            "edit": asdict(self.taken[0][1].edits[0]) if self.taken else None,
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
        """Return a row for each comparison and each measure, with control, effect, low and high.

        `change` names what is changed; `dose` is the number of strings or copies that change (0: any).
        """
        return [
            {"species": self.sweep.species, "change": change, "tick": taken.tick, "dose": dose or 0}
            | {"allele": named(taken.edits[0]), "was": taken.edits[0].was, "reverse": taken.edits[0].reverse}
            | {"forks": len(taken.n), "measure": measure, "control": taken.control(measure, dose).value}
            | dict(zip(("effect", "low", "high"), taken.effect(measure, of, dose), strict=True))
            for names, taken in self.comparisons()
            for of, change in zip(CONTRASTS[taken.n.shape[1]], names, strict=True)
            for dose in (None, *taken.doses)
            for measure in taken.means
        ]

    def comparisons(self) -> list[tuple[tuple[str, ...], TakenOut]]:
        """Return all comparisons, with a name for each of their contrasts."""
        found: list[tuple[tuple[str, ...], TakenOut]] = []
        found += [((f"without {allele.name}",), taken) for allele, taken in self.taken]
        if self.reverse is not None:
            found.append(((f"{named(self.reverse.edits[0])} put in",), self.reverse))
        two = [(self.together[0].name, self.together[1])] if self.together is not None else []
        two += [("what they had learned", self.learned)] if self.learned is not None else []
        for second, taken in two:
            one = named(taken.edits[0])
            names = (
                f"without {one}",
                f"without {second}",
                f"without {one} and {second}",
                "interaction of both",
            )
            found.append((names, taken))
        return found


def account(
    run: Path | str,
    sweep: Sweep,
    *,
    tick: When = None,
    forks: int = 24,
    learned: bool = False,
    reverse: bool = False,
    other: Sweep | None = None,
    progress: Callable[[int, int], None] | None = None,
    **how: Unpack[Options],
) -> Account:
    """Take the alleles of a sweep out in forks of a recorded run, each separately.

    Parameters
    ----------
    run : str or Path
    sweep : Sweep
        From `rises`.
    tick : int or {"before", "within", "after"}, or a sequence of them, optional
        Ticks of the forks: the words mean the ticks at which the rise begins, is half over and ends. Default:
        "within". Only the effects of single alleles are measured at more than the first of several ticks.
    forks : int, default 24
        0: take nothing out.
    learned : bool, default False
        Whether to undo learning, too: in a 2 × 2 comparison, policies get back their weights at birth.
    reverse : bool, default False
        Whether to put the lead into a random half of the organisms without it, too.
    other : Sweep, optional
        Another sweep of the species, whose lead is taken out together with this one's, in a 2 × 2 comparison.
    progress : callable, optional
        Called as `progress(done, forks)`.
    **how
        Other arguments of `take_out`: ticks, seed, engine, workers, trust.

    Returns
    -------
    Account
    """
    called_with("progress", progress, "done", "forks")
    jobs = jobs_of(sweep, tick, learned, reverse, other) if forks else []
    gaps = [f"No allele can be taken out: {sweep.lead.name} is not a letter, value or copy number of a gene."]
    gaps = gaps if forks and not jobs else []
    found: dict[str, list[tuple[Job, TakenOut]]] = {kind: [] for kind in JOBS}
    before: dict[AlleleLike, str] = {}  # what replaces an allele: the same at all ticks
    for i, job in enumerate(jobs):

        def show(done: int, _: int, earlier: int = i * forks) -> None:
            if progress is not None:
                progress(earlier + done, len(jobs) * forks)

        was, back = [before.get(allele, "") for allele in job.alleles], job.kind == "reverse"
        try:
            taken = take_out(
                run, job.alleles, was, tick=job.tick, forks=forks, reverse=back, progress=show, **how
            )
        except ConfigError:  # for example, code that is not trusted: nothing can be taken out
            raise
        except ValueError as error:
            gaps.append(f"{job.task} failed: {str(error).rstrip('.')}.")
        else:
            found[job.kind].append((job, taken))
            before |= zip(job.alleles, (edit.was for edit in taken.edits), strict=True)
        show(forks, forks)  # also if it was refused, or its forks are of an earlier call
    ones = {kind: own[0][1] if own else None for kind, own in found.items()}
    return Account(
        sweep,
        tuple((cast("Allele", job.alleles[0]), taken) for job, taken in found["taken"]),
        " ".join(gaps),
        ones["learned"],
        ones["reverse"],
        None if other is None or ones["together"] is None else (other.lead, ones["together"]),
    )


def jobs_of(sweep: Sweep, tick: When, learned: bool, reverse: bool, other: Sweep | None) -> list[Job]:
    """Return what is compared in forks for a sweep, at the first of the ticks before the others."""
    chosen, first, *rest = candidates(sweep), *ticks_of(sweep, tick)
    if not chosen:
        return []
    jobs = [Job("taken", (allele,), first) for allele in chosen]
    if reverse:
        jobs.append(Job("reverse", (chosen[0],), first))
    if other is not None and (their := candidates(other)):
        both = max(first, ticks_of(other, tick)[0])
        jobs.append(Job("together", (chosen[0], their[0]), both))
    if learned:
        jobs.append(Job("learned", (chosen[0], Edit(sweep.species, "policy")), first))
    return jobs + [Job("taken", (allele,), at) for at in rest for allele in chosen]


def ticks_of(sweep: Sweep, tick: When) -> list[int]:
    """Return the ticks of forks, with the words replaced, without repetitions."""
    return list(
        dict.fromkeys(getattr(sweep, MOMENTS[at]) if isinstance(at, str) else at for at in moments(tick))
    )


def moments(tick: When) -> list[int | str]:
    """Return ticks or words for ticks as a list; raise ValueError for anything else."""
    given: Sequence[int | str] = [tick] if isinstance(tick, int | str) else tick or ["within"]
    several = list(given)
    if wrong := [at for at in several if isinstance(at, str) and at not in MOMENTS]:
        raise ValueError(f"tick = {wrong[0]!r}; expected a whole number, before, within or after")
    return several


def named(allele: AlleleLike) -> str:
    """Return the name of an allele that is taken out; "" for what organisms learned."""
    if isinstance(allele, Allele):
        return allele.name
    kind = cast("Kind", allele.kind)
    return (
        "" if kind == "policy" else Allele(allele.species, kind, allele.gene, allele.locus, allele.value).name
    )


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
    return [f"It rose together with {in_words(names)}."] if names else []


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
        lines.append(
            f"Without it, carriers had {sized(births)} {word} young each; with it, {number(usual, 2)}."
        )
    if clear(lived):
        lines.append(
            f"Without it, they lived {sized(lived)} ticks {'less' if lived.value < 0 else 'longer'}."
        )
    more = {m.removeprefix("died: "): taken.effect(m) for m in taken.means if m.startswith("died: ")}
    cause, x = max(more.items(), key=lambda one: one[1].value, default=("", births))
    if cause and x.low > 0:
        value, low, high = (number(100 * part, 2) for part in x)
        lines.append(
            f"Among causes of death, “{cause}” increased most, by {value} percentage points ({low} to {high})."
        )
    return " ".join(lines)


def elsewhere(taken: Sequence[tuple[Allele, TakenOut]]) -> list[str]:
    """Return sentences on the effect of the first allele on births at other ticks."""
    lines, (allele, here) = [], taken[0]
    for other, there in taken:
        if other != allele or there is here:
            continue
        gap = difference_of_intervals(there.effect(), here.effect())
        clearly = f"clearly different, by {signed(gap)}," if clear(gap) else "not clearly different"
        lines.append(
            f"In forks at tick {there.tick:,}, the difference in the number of young was {signed(there.effect())}, "
            f"{clearly} from that at tick {here.tick:,}."
        )
    return lines


def put_in(taken: TakenOut) -> str:
    """Return the sentence on what changes if an allele is put into organisms without it."""
    births, many = taken.effect("births"), round(float(taken.n.sum(axis=1).mean()))
    differs = "differed clearly" if clear(births) else "did not differ clearly"
    return (
        f"In reverse, {named(taken.edits[0])} was put into a random half of {many:,} organisms without it, in "
        f"forks at tick {taken.tick:,}: their number of young {differs} from that of the others; the "
        f"difference is {signed(births)}."
    )


def drove(taken: Sequence[tuple[Allele, TakenOut]], found: Allele | None) -> str:
    """Return the sentence on which of several alleles, each taken out separately, drove the rise."""
    if found is None:
        names = in_words([allele.name for allele, _ in taken])
        return (
            f"Separate removals of {names} do not clearly lower the number of young, so the forks do not show "
            "which one drove the rise."
        )
    if also := [allele.name for allele, one in taken if allele != found and driver([one])]:
        return (
            f"Removing {found.name} lowers the number of young most, but removing {in_words(also)} also lowers it "
            "clearly: more than one allele may have driven the rise."
        )
    return (
        f"Removing {found.name} clearly lowers the number of young, and no other removal does, so this allele "
        "probably drove the rise."
    )


def born_or_learned(taken: TakenOut) -> str:
    """Return the sentences on a 2 × 2 of an allele and of learning: is the advantage inherited, learned or both?"""
    inherited, learned = (
        clear(x) and x.value < 0 for x in map(partial(taken.effect, "births"), ("first", "second"))
    )
    where = {
        (True, True): "Both the allele and learning raise the number of young",
        (True, False): "The allele raises the number of young; an effect of learning is not clear",
        (False, True): "Learning raises the number of young; an effect of the allele is not clear",
        (False, False): "Neither the allele nor learning clearly raises the number of young",
    }[inherited, learned]
    differed, interaction = two_by_two(taken, "the allele", "what they had learned")
    return f"Compared with carriers that kept both, {differed}. {where}. {interaction}"


def of_two_sweeps(other: Allele, taken: TakenOut) -> str:
    """Return the sentences on a 2 × 2 of the alleles of two sweeps."""
    one, many = named(taken.edits[0]), round(float(taken.n.sum(axis=1).mean()))
    differed, interaction = two_by_two(taken, one, other.name)
    return (
        f"At tick {taken.tick:,}, {many:,} organisms carried both {one} and {other.name}. Compared with carriers "
        f"that kept both, {differed}. {interaction}"
    )


def two_by_two(taken: TakenOut, first: str, second: str) -> tuple[str, str]:
    """Return a clause on the effects of two removals and of both, and a sentence on their interaction."""
    ways = {"first": first, "second": second, "both": "both"}
    young = [f"{signed(taken.effect('births', of))} without {what}" for of, what in ways.items()]
    x = taken.effect("births", "interaction")
    adds = "the two effects do not add up" if clear(x) else "no clear deviation from the sum of both effects"
    return f"the number of young differed by {in_words(young)}", f"The interaction is {signed(x)}: {adds}."


def sized(x: Interval) -> str:
    """Return the size of an effect and its interval, without signs."""
    low, high = sorted((abs(x.low), abs(x.high)))
    return f"{number(abs(x.value), 2)} ({number(low, 2)} to {number(high, 2)})"


def signed(x: Interval) -> str:
    """Return an effect with its interval, if there is one."""
    return number(x.value, 2) + f" ({number(x.low, 2)} to {number(x.high, 2)})" * bool(np.isfinite(x.low))
