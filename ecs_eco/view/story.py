"""The story of a world: extinctions, returns, booms, crashes and first births, with their causes."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

FACTOR = 2.0  # growth since the last low for a boom, or decline since the last high for a crash
LEAST = 20  # minimum high population in a boom or crash; smaller populations often double at random
NAMED = 0.15  # minimum share of deaths for a cause to be named
SOON = 5  # initial ticks in which first births, mostly of plants, are not reported
KEPT = 500  # maximum number of entries
EVERY = 5  # ticks between checks of population sizes; appearances and extinctions are noticed at once


class Turn(NamedTuple):
    """A high or low of a species, or another tick of its course, with the totals at that tick."""

    tick: int
    n: int
    births: int
    deaths: np.ndarray  # by cause
    others: np.ndarray  # population sizes of all species


def half_of_peak(n: np.ndarray) -> int | None:
    """Return the last index at which numbers i64[ticks] were at least half of their maximum; None if all are 0."""
    high = np.flatnonzero(n >= max(0.5 * n.max(initial=0), 1))
    return int(high[-1]) if high.size else None


@dataclass
class Course:
    """The course of a species: its last low and high, whether it is extinct, and whether it has reproduced."""

    low: Turn
    high: Turn
    gone: bool
    bred: bool
    peak: Turn | None = None  # the high before the last crash
    way: int = 0  # +1 after a boom, −1 after a crash

    def turn(self, n: int) -> int:
        """Return +1 if population n is a boom since the last low, −1 for a crash since the last high, else 0."""
        if n >= max(LEAST, FACTOR * self.low.n) and self.way <= 0:
            return 1
        return -1 if self.high.n >= LEAST and n * FACTOR <= self.high.n and self.way >= 0 else 0


class Story:
    """Entries {tick, kind, species, text, cause}, oldest first; kinds: birth, boom, crash, extinct, return.
    `foods` lists what each species eats; `cause(column)` names the cause of death in a column. `half(s, now)`
    returns the last turn at which an extinct species had at least half of its peak number, as in
    `ecs_eco.analysis.extinction`; if it is None, extinctions are explained since the last high."""

    def __init__(
        self,
        species: Sequence[str],
        foods: Mapping[str, Sequence[str]],
        cause: Callable[[int], str],
        half: Callable[[int, Turn], Turn | None] = lambda s, now: None,
    ) -> None:
        self.species, self.foods, self.cause, self.half = list(species), foods, cause, half
        self.entries: list[dict[str, Any]] = []
        self._courses: list[Course] = []
        self._began = -1

    def mark(self) -> tuple[Any, ...]:
        """Return the entries so far and the state needed to continue them."""
        return [*self.entries], [*map(copy, self._courses)], self._began

    def go_back(self, mark: tuple[Any, ...]) -> None:
        """Return to a mark."""
        entries, courses, self._began = mark
        self.entries, self._courses = [*entries], [*map(copy, courses)]

    def changes(self, n: Sequence[int]) -> bool:
        """Return whether a species has appeared or died out since the last `note`; True before the first."""
        return [not k for k in n] != [course.gone for course in self._courses]

    def note(
        self, tick: int, n: np.ndarray, births: np.ndarray, deaths: np.ndarray, bred: np.ndarray
    ) -> None:
        """Note the state after `tick` ticks: population sizes n i64[s]; births i64[s] and deaths
        i64[s, causes] since the beginning; `bred` bool[s], true once a parent of the species has reproduced."""

        def turn(s: int) -> Turn:
            return Turn(tick, int(n[s]), int(births[s]), deaths[s].copy(), n.copy())

        if self._began < 0:
            self._began, first = tick, [turn(s) for s in range(len(self.species))]
            self._courses = [Course(now, now, not now.n, bool(bred[s])) for s, now in enumerate(first)]
            return
        for s, (course, count) in enumerate(zip(self._courses, n.tolist(), strict=True)):
            between = course.low.n < count < course.high.n and not bred[s] > course.bred
            if not between or course.turn(count):
                self._follow(s, turn(s), bool(bred[s]))

    def _follow(self, s: int, now: Turn, bred: bool) -> None:
        course, name = self._courses[s], self.species[s]
        if bred and not course.bred:
            course.bred = True
            if now.tick - self._began > SOON:
                self._tell(now, s, "birth", f"First {name} born to parents", "")
        if now.n == 0:
            if not course.gone:
                course.gone, peak, half = True, course.peak or course.high, self.half(s, now)
                fall = self._fall(
                    s, half or peak, now, "the last with at least half of the peak" if half else "last high"
                )
                self._tell(now, s, "extinct", f"{name} died out", fall, peak.n)
            course.low = course.high = now
        elif course.gone:
            course.gone, course.way, course.low, course.high = False, 0, now, now
            self._tell(now, s, "return", f"{name} returned: {now.n:,} alive", "")
        else:
            self._swing(s, now)

    def _swing(self, s: int, now: Turn) -> None:
        """Add a boom or a crash, and store a new high or low."""
        course, name = self._courses[s], self.species[s]
        low, high, way = course.low, course.high, course.turn(now.n)
        if way > 0:
            text = f"{name} boom: {now.n / max(low.n, 1):,.1f} times as many as at tick {low.tick:,}"
            self._tell(now, s, "boom", text, self._rise(s, low, now), low.n)
            course.way, course.high, course.peak = 1, now, None
        elif way < 0:
            text = f"{name} crash: {now.n / high.n:.0%} as many as at tick {high.tick:,}"
            self._tell(now, s, "crash", text, self._fall(s, high, now), high.n)
            course.way, course.low, course.peak = -1, now, high
        if now.n >= course.high.n:
            course.high = now
            course.low = now if course.way > 0 else course.low
        if now.n <= course.low.n:
            course.low = now
            course.high = now if course.way < 0 else course.high

    def _tell(self, now: Turn, s: int, kind: str, text: str, cause: str, before: int | None = None) -> None:
        was = {} if before is None else {"before": before}
        self.entries.append(
            {
                "tick": now.tick,
                "kind": kind,
                "species": self.species[s],
                "n": now.n,
                "text": text[0].upper() + text[1:],
                "cause": cause,
                **was,
            }
        )
        del self.entries[:-KEPT]

    def _fall(self, s: int, high: Turn, now: Turn, which: str = "last high") -> str:
        """Return a text about causes of death since a turn, which is named, and about food and enemies."""
        died = now.deaths - high.deaths
        total, born = int(died.sum()), now.births - high.births
        if not total:
            return f"There were {high.n:,} at tick {high.tick:,}."
        order = [int(c) for c in np.argsort(-died, kind="stable")[:4] if died[c] >= NAMED * total]
        shares = ", ".join(f"{died[c] / total:.0%} {self.cause(c)}" for c in order)
        text = f"Deaths since tick {high.tick:,} ({which}): {total:,} ({shares}). Births: {born:,}."
        eaters = [
            c.removeprefix("eaten by ") for c in (self.cause(i) for i in order) if c.startswith("eaten by ")
        ]
        starved = any(not self.cause(i).startswith("eaten by ") for i in order)
        meals = [food for food in self.foods.get(self.species[s], ()) if starved]
        return " ".join([text, *self._meanwhile(meals, eaters, high, now, fell=True)])

    def _meanwhile(
        self, foods: Sequence[str], enemies: Sequence[str], then: Turn, now: Turn, fell: bool
    ) -> Iterator[str]:
        for name, word, rises in [
            *((food, "its food", not fell) for food in foods),
            *((enemy, "its enemy", fell) for enemy in enemies),
        ]:
            if name not in self.species:
                continue
            a, b = (int(turn.others[self.species.index(name)]) for turn in (then, now))
            if a == b == 0:
                yield from () if rises else (f"There was no {name}.",)
            elif b >= 1.25 * a if rises else b <= 0.8 * a:
                yield f"Meanwhile, {word} ({name}) went from {a:,} to {b:,}."

    def _rise(self, s: int, low: Turn, now: Turn) -> str:
        died, born = int((now.deaths - low.deaths).sum()), now.births - low.births
        enemies = [e for e, eaten in self.foods.items() if self.species[s] in eaten]
        text = f"Since tick {low.tick:,}: births {born:,}, deaths {died:,}."
        meals = self.foods.get(self.species[s], ())
        return " ".join([text, *self._meanwhile(meals, enemies, low, now, fell=False)])


def foods_of(config: Mapping[str, Any] | None, harmful: bool = False) -> dict[str, list[str]]:
    """Return what each species eats according to a configuration, without harmful food unless `harmful`."""
    species = (config or {}).get("species") or {}
    return {
        name: list(
            dict.fromkeys(
                line["eats"]
                for line in values.get("diet") or ()
                if harmful or (line.get("gain", 0) >= 0 and not line.get("deadly"))
            )
        )
        for name, values in species.items()
    }
