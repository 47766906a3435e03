"""Parents, children, births and deaths of organisms in live and recorded worlds."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.view.journal import Journal
from ecs_eco.view.parts import Columns
from ecs_eco.view.recording import Recording

Lives = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Uids, ascending, and the uids of both parents (0: none): u64[n] each."""
LARGEST = 500_000  # with more births, `lives` is empty
CHILDREN = 200  # maximum number of children in a list
ANCESTORS = 5000  # maximum number of ancestors followed to find a generation
PARENTS = ("uid", "parent", "parent2")


class Young(NamedTuple):
    """Children of some organisms: uids u64[n], ascending, and the uids of both parents u64[n, 2]."""

    uid: np.ndarray
    parents: np.ndarray


class Genealogy:
    """All organisms with a known birth: in a live world, since watching began; in a recorded run, ever."""

    def __init__(self, noted: Recording | Journal) -> None:
        self.noted = noted
        self._generations: dict[int, int] = {}
        self._lives: tuple[tuple[int, ...], Lives] | None = None

    def birth(self, uid: int, names: Sequence[str] = ()) -> dict[str, Any] | None:
        """Return the tick, species, parents and further columns of an organism's birth, or None if unknown."""
        return self.noted.births.find(uid, ("tick", "species", *PARENTS, *names))

    def died(self, uid: int, since: int = 0) -> dict[str, Any] | None:
        """Return the tick, cause and killer of an organism's death, or None if no death is known."""
        row = self.noted.deaths.find(uid, ("tick", "cause", "killer"), since)
        if row is None:
            return None
        cause = int(row["cause"])
        return {
            "tick": int(row["tick"]),
            "cause": self.noted.causes[cause] if cause >= 0 else "unknown",
            "killer": int(row["killer"]) or None,
        }

    def parents(self, uid: int) -> list[int]:
        """Return the uids of an organism's known parents: none, one or two."""
        return _parents(self.noted.births.find(uid, PARENTS))

    def children(self, uid: int) -> list[int]:
        """Return the uids of an organism's most recent children, at most CHILDREN."""
        return self.young(np.array([uid], np.uint64)).uid[-CHILDREN:].tolist()

    def generation(self, uid: int) -> int | None:
        """Return the length of an organism's longest known ancestral line; None if there are too many ancestors."""
        known, followed, waiting = self._generations, 0, [uid]
        while waiting:
            one = waiting[-1]
            parents = self.parents(one)
            if missing := [p for p in parents if p not in known]:
                waiting += missing
                followed += 1
                if followed > ANCESTORS:
                    return None
            else:
                known[one] = 1 + max((known[p] for p in parents), default=-1)
                waiting.pop()
        return known[uid]

    def life(self, uid: int) -> dict[str, Any] | None:
        """Return an organism's species, birth tick, death, age at death [s] and parents, or None if unknown."""
        birth = self.birth(uid)
        if birth is None:
            return None
        born = int(birth["tick"])
        died = self.died(uid, born)
        age = None if died is None else round((died["tick"] - born) * self.noted.dt, 6)
        species = self.noted.species[birth["species"]]
        return {"species": species, "born": born, "died": died, "age": age, "parents": _parents(birth)}

    def facts(self, uid: int) -> dict[str, Any]:
        """Return the known facts: species, birth, death, parents, children and generation."""
        life = self.life(uid)
        if life is None:
            return dict.fromkeys(("species", "born", "died", "generation")) | {"parents": [], "children": []}
        del life["age"]
        return life | {"children": self.children(uid), "generation": self.generation(uid)}

    def young(self, uids: np.ndarray) -> Young:
        """Return the known children of these organisms u64[k]."""
        uid, parents = [np.zeros(0, np.uint64)], [np.zeros((0, 2), np.uint64)]
        births = self.noted.births
        for group in births.groups if uids.size else ():
            if group.uids is None or group.uids[1] > uids.min():  # children have higher uids
                born, *both = (column.astype(np.uint64) for column in births.read(group, PARENTS).values())
                rows = np.flatnonzero(np.isin(both[0], uids) | np.isin(both[1], uids))
                uid.append(born[rows])
                parents.append(np.stack([parent[rows] for parent in both], axis=1))
        every = np.concatenate(uid)
        order = np.argsort(every, kind="stable")
        return Young(every[order], np.concatenate(parents)[order])

    def lives(self) -> Lives:
        """Return all organisms with a known birth and their parents, or empty arrays if there are too many."""
        births = self.noted.births
        state = births.rows, *(births.groups[-1].uids or () if births.groups else ())
        if self._lives is None or self._lives[0] != state:
            read = [] if births.rows > LARGEST else list(births.each(PARENTS))
            uid, parent, parent2 = (_joined(read, name) for name in PARENTS)
            order = np.argsort(uid, kind="stable")
            self._lives = state, (uid[order], parent[order], parent2[order])
        return self._lives[1]

    def go_back(self) -> None:
        """Discard cached results, because births have been undone."""
        self._generations, self._lives = {}, None


def _joined(parts: list[Columns], name: str) -> np.ndarray:
    return np.concatenate([np.zeros(0, np.uint64), *(part[name].astype(np.uint64) for part in parts)])


def _parents(birth: dict[str, Any] | None) -> list[int]:
    return [] if birth is None else [int(p) for p in (birth["parent"], birth["parent2"]) if p]
