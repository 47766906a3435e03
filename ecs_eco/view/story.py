"""The story of a world: extinctions, returns, booms, crashes and first births, with their causes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import Any, NamedTuple

import numpy as np

FACTOR = 2.0  # growth from the last low that counts as a boom, or decline from the last high that counts as a crash
LEAST = 20  # organisms at the high end of a boom or crash; smaller numbers often double at random
NAMED = 0.15  # smallest share of deaths for which a cause is named
SOON = 5  # ticks from the beginning in which first births, mostly of plants, are not reported
KEPT = 500  # entries
EVERY = 5  # ticks between two checks of the numbers; appearances and extinctions are noticed at once
STATE = ("entries", "_low", "_high", "_began", "_peak", "_way", "_gone", "_bred")


class Turn(NamedTuple):
    """A high or low of a species, with the sums at that tick."""

    tick: int
    n: int
    births: int
    deaths: np.ndarray  # by cause
    others: np.ndarray  # the numbers of all species


class Story:
    """Entries {tick, kind, species, text, cause}, oldest first; kinds: birth, boom, crash, extinct, return.

    `foods` gives what each species eats; `cause(column)` names the cause of death of a column.
    """

    def __init__(
        self, species: Sequence[str], foods: Mapping[str, Sequence[str]], cause: Callable[[int], str]
    ) -> None:
        self.species, self.foods, self.cause = list(species), foods, cause
        self.entries: list[dict[str, Any]] = []
        self._low: list[Turn | None] = [None] * len(self.species)
        self._high: list[Turn | None] = [None] * len(self.species)
        self._began = -1
        self._peak: list[Turn | None] = [None] * len(self.species)  # the high before the last crash
        self._way = [0] * len(self.species)  # of the last entry: +1 a boom, −1 a crash
        self._gone, self._bred = [False] * len(self.species), [False] * len(self.species)

    def mark(self) -> dict[str, Any]:
        """Return the entries so far, and the state from which the next ones follow."""
        return {name: copy(getattr(self, name)) for name in STATE}

    def go_back(self, mark: dict[str, Any]) -> None:
        """Return to a mark."""
        for name in STATE:
            setattr(self, name, copy(mark[name]))

    def changes(self, n: np.ndarray) -> bool:
        """Return whether a species has appeared or died out since the last `note`, or none was made."""
        return None in self._low or (n == 0).tolist() != self._gone

    def note(
        self, tick: int, n: np.ndarray, births: np.ndarray, deaths: Callable[[], np.ndarray], bred: np.ndarray
    ) -> None:
        """Note the state after `tick` ticks: numbers i64[s]; births i64[s] since the beginning; `deaths()`
        i64[s, causes], called if needed; `bred` bool[s], true once a species has had young of parents."""
        for s, count in enumerate(n.tolist()):
            low, high = self._low[s], self._high[s]
            if low is not None and low.n < count < (high or low).n and not bred[s] > self._bred[s]:
                if self._ordinary(s, count, low, high or low):
                    continue
            self._follow(s, Turn(tick, count, int(births[s]), deaths()[s].copy(), n.copy()), bool(bred[s]))

    def _ordinary(self, s: int, n: int, low: Turn, high: Turn) -> bool:
        """Return whether a number is neither a boom nor a crash since its last low and high."""
        rises = n >= LEAST and n >= FACTOR * low.n and self._way[s] <= 0
        falls = high.n >= LEAST and n * FACTOR <= high.n and self._way[s] >= 0
        return not rises and not falls

    def _follow(self, s: int, now: Turn, bred: bool) -> None:
        self._began = now.tick if self._began < 0 else self._began
        if bred and not self._bred[s]:
            self._bred[s] = True
            if now.tick - self._began > SOON:
                self._tell(now, s, "birth", f"First {self.species[s]} born of parents", "")
        low, high = self._low[s], self._high[s]
        if low is None or high is None:
            self._low[s] = self._high[s] = now
            self._gone[s] = now.n == 0
            return
        if now.n == 0:
            if not self._gone[s]:
                self._gone[s] = True
                peak = self._peak[s] or high
                self._tell(now, s, "extinct", f"{self.species[s]} died out", self._fall(s, peak, now), peak.n)
            self._low[s] = self._high[s] = now
            return
        if self._gone[s]:
            self._gone[s], self._way[s], self._low[s], self._high[s] = False, 0, now, now
            self._tell(now, s, "return", f"{self.species[s]} have returned: {now.n:,}", "")
            return
        self._swing(s, now, low, high)

    def _swing(self, s: int, now: Turn, low: Turn, high: Turn) -> None:
        """Add a boom or a crash; remember a new high or low."""
        if now.n >= max(LEAST, FACTOR * low.n) and self._way[s] <= 0:
            times = now.n / max(low.n, 1)
            self._tell(
                now,
                s,
                "boom",
                f"{self.species[s]} boom: {times:.2g} × tick {low.tick:,}",
                self._rise(s, low, now),
                low.n,
            )
            self._way[s], self._high[s], self._peak[s] = 1, now, None
        elif high.n >= LEAST and now.n * FACTOR <= high.n and self._way[s] >= 0:
            share = now.n / high.n
            self._tell(
                now,
                s,
                "crash",
                f"{self.species[s]} crash: {share:.0%} of tick {high.tick:,} left",
                self._fall(s, high, now),
                high.n,
            )
            self._way[s], self._low[s], self._peak[s] = -1, now, high
        if now.n >= self._high[s].n:  # type: ignore[union-attr]
            self._high[s] = now
            self._low[s] = now if self._way[s] > 0 else self._low[s]
        if now.n <= self._low[s].n:  # type: ignore[union-attr]
            self._low[s] = now
            self._high[s] = now if self._way[s] < 0 else self._high[s]

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

    def _fall(self, s: int, high: Turn, now: Turn) -> str:
        """Return a text on the causes of death since a high, and on changes in foods and enemies."""
        died = now.deaths - high.deaths
        total, born = int(died.sum()), now.births - high.births
        if not total:
            return f"There were {high.n:,} at tick {high.tick:,}."
        order = [int(c) for c in np.argsort(-died, kind="stable")[:4] if died[c] >= NAMED * total]
        shares = ", ".join(f"{died[c] / total:.0%} {self.cause(c)}" for c in order)
        text = f"Of {total:,} deaths since tick {high.tick:,}: {shares}; {born:,} were born."
        eaters = [
            c.removeprefix("eaten by ") for c in (self.cause(i) for i in order) if c.startswith("eaten by ")
        ]
        starved = any(not self.cause(i).startswith("eaten by ") for i in order)
        meals = [food for food in self.foods.get(self.species[s], ()) if starved]
        return " ".join([text, *self._meanwhile(meals, eaters, high, now, fell=True)])

    def _meanwhile(
        self, foods: Sequence[str], enemies: Sequence[str], then: Turn, now: Turn, fell: bool
    ) -> list[str]:
        lines = []
        for name, word, rises in [
            *((food, "Its food", not fell) for food in foods),
            *((enemy, "Its enemy", fell) for enemy in enemies),
        ]:
            if name not in self.species:
                continue
            a, b = (int(turn.others[self.species.index(name)]) for turn in (then, now))
            if b >= 1.25 * a if rises else b <= 0.8 * a:
                lines.append(f"{word}, {name}, went from {a:,} to {b:,} meanwhile.")
        return lines

    def _rise(self, s: int, low: Turn, now: Turn) -> str:
        died, born = int((now.deaths - low.deaths).sum()), now.births - low.births
        enemies = [e for e, eaten in self.foods.items() if self.species[s] in eaten]
        text = f"{born:,} were born and {died:,} died since tick {low.tick:,}."
        meals = self.foods.get(self.species[s], ())
        return " ".join([text, *self._meanwhile(meals, enemies, low, now, fell=False)])


def foods_of(config: Mapping[str, Any] | None) -> dict[str, list[str]]:
    """Return the species that each species eats without loss, according to a configuration, a mapping."""
    species = (config or {}).get("species") or {}
    return {
        name: list(
            dict.fromkeys(
                line["eats"]
                for line in values.get("diet") or ()
                if line.get("gain", 0) >= 0 and not line.get("deadly")
            )
        )
        for name, values in species.items()
    }
