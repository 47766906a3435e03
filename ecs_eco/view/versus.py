"""A sentence about the current differences between two worlds shown side by side."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

MOST = 4  # maximum number of species in the sentence; the rest are counted


class Side(NamedTuple):
    """One of the two worlds: population sizes by species, and the ticks of extinctions."""

    n: Mapping[str, int]
    extinct: Mapping[str, int]


def side(counts: Mapping[str, int], entries: Sequence[Mapping[str, Any]], tick: int) -> Side:
    """Return a world's side at a tick, from its population sizes and its story."""
    gone = {
        entry["species"]: int(entry["tick"])
        for entry in entries
        if entry["kind"] == "extinct" and entry["tick"] <= tick
    }
    return Side(counts, {name: at for name, at in gone.items() if not counts.get(name)})


def differences(
    species: Sequence[str], one: Side, other: Side, since: int | None, tick: int
) -> dict[str, Any]:
    """Return the sentence and, by species, its clauses: {"text", "clauses"}, the largest difference first.
    `other` branched from `one` at tick `since`; None means that the worlds are unrelated."""
    shared = [name for name in species if name in one.n and name in other.n]
    told = sorted(((_weight(one, other, name), name) for name in shared), key=lambda pair: -pair[0])
    parted = [name for weight, name in told if weight > 0]
    clauses = {name: _clause(name, one, other, since is not None) for name in parted[:MOST]}
    alone = _alone("first", one, other) + _alone("second", other, one)
    same = ["the same numbers in both"] if shared and not parted else []
    rest = [f"other species that differ: {len(parted) - len(clauses)}"] if len(parted) > len(clauses) else []
    words = "; ".join([*clauses.values(), *same, *rest, *alone])
    past = None if since is None else tick - since
    when = f"At tick {tick:,}" if past is None else f"After {past:,} tick{'' if past == 1 else 's'}"
    return {"text": f"{when}: {words}.", "clauses": clauses}


def _alone(which: str, mine: Side, theirs: Side) -> list[str]:
    """Return a clause about the species that exist in only one of the worlds."""
    own = [f"{n:,} {name}" for name, n in mine.n.items() if name not in theirs.n]
    return [f"only the {which} has {', '.join(own)}"] if own else []


def _weight(one: Side, other: Side, name: str) -> float:
    """Return how much a species differs: 0 for equal population sizes, above 1 if it lives in only one world."""
    a, b = one.n[name], other.n[name]
    if a == b:
        return 0.01 if one.extinct.get(name) != other.extinct.get(name) else 0.0
    return 2.0 if not a or not b else abs(b - a) / max(a, b)


def _clause(name: str, one: Side, other: Side, forked: bool) -> str:
    a, b = one.n[name], other.n[name]
    here, there = ("here", "in the original") if forked else ("in the second", "in the first")
    if not a and not b:
        ends = [
            f"at tick {ends.extinct[name]:,} {place}"
            for ends, place in ((other, here), (one, there))
            if name in ends.extinct
        ]
        return f"{name} died out {' and '.join(ends)}"
    if not a or not b:
        (gone, place), (n, other_place) = ((other, here), (a, there)) if not b else ((one, there), (b, here))
        lost = (
            f"died out at tick {gone.extinct[name]:,} {place}" if name in gone.extinct else f"absent {place}"
        )
        return f"{name} {lost}, {n:,} alive {other_place}"
    if forked:
        return f"{name} {b:,} instead of {a:,}"
    return f"{name} {a:,} {there}, {b:,} {here}"
