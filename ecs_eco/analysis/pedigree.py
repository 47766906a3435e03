"""A pedigree: the descent of all organisms as arrays that can be queried."""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.engine.uids import island_of, matched

ALIVE = -1


def among(parents: np.ndarray, uids: np.ndarray) -> np.ndarray:
    """Return the parents, with 0 for each parent that is not among the uids."""
    return np.where(np.isin(parents, uids), parents, parents.dtype.type(0))


@dataclass(frozen=True)
class Pedigree:
    """The arrays of a `Lineage`, which documents them, and queries on them."""

    uid: np.ndarray
    parent: np.ndarray
    parent2: np.ndarray
    species: np.ndarray
    born: np.ndarray
    died: np.ndarray
    cause: np.ndarray
    genome: np.ndarray
    end: int = 0
    dt: float = 1.0
    genomes: dict[str, Any] = field(default_factory=dict)
    recorded: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        several = len(np.unique(island_of(self.uid))) > 1
        uid = np.sort(self.uid) if several else self.uid
        behind = np.flatnonzero(np.diff(uid.astype(np.int64)) <= 0)
        if behind.size:
            raise ValueError(f"lineage: the uid {uid[1:][behind[0]]} is a duplicate or out of order")
        for parent, place in ((self.parent, self.mother), (self.parent2, self.father)):
            same = island_of(parent) == island_of(self.uid)
            late = np.flatnonzero((place >= np.arange(len(self))) | (same & (parent >= self.uid)))
            if late.size:
                fault = f"the organism {self.uid[late[0]]} has the parent {parent[late[0]]}"
                raise ValueError(f"lineage: {fault}; expected 0 or the uid of an earlier organism")
            unknown = np.flatnonzero((parent > 0) & ~np.isin(parent, self.uid))
            if unknown.size:
                fault = f"the organism {self.uid[unknown[0]]} has the parent {parent[unknown[0]]}"
                allowed = "expected 0 or a recorded uid"
                raise ValueError(f"lineage: {fault}, whose birth is not recorded; {allowed}")

    def __len__(self) -> int:
        return len(self.uid)

    def of_species(self, name: str) -> Self:
        """Return the pedigree of one species.

        Parameters
        ----------
        name : str

        Returns
        -------
        Pedigree

        Raises
        ------
        KeyError
            If the species is unknown.
        """
        known = list(dict.fromkeys(self.species.tolist()))
        if name not in known:
            raise UnknownName(unknown_name("lineage", "species", name, known))
        return self._chosen(self.species == name)

    def living(self) -> Self:
        """Return the pedigree of living organisms and their ancestors.

        Returns
        -------
        Pedigree
        """
        return self._chosen(self._forebears(self.died == ALIVE))

    def _chosen(self, mask: np.ndarray) -> Self:
        whole = {f.name: getattr(self, f.name) for f in fields(self)}
        arrays = {name: values[mask] for name, values in whole.items() if isinstance(values, np.ndarray)}
        for name in ("parent", "parent2"):  # a parent of another species is not in this lineage
            arrays[name] = among(arrays[name], arrays["uid"])
        recorded = {name: values[mask] for name, values in self.recorded.items()}
        return replace(self, recorded=recorded, **arrays)

    @cached_property
    def mother(self) -> np.ndarray:
        """Index of the first parent in the arrays, or −1 if there is none: i64."""
        return self._places(self.parent)

    @cached_property
    def father(self) -> np.ndarray:
        """Index of the second parent in the arrays, or −1 if there is none: i64."""
        return self._places(self.parent2)

    @cached_property
    def _by_uid(self) -> np.ndarray:
        return np.argsort(self.uid, kind="stable")

    def _places(self, uids: np.ndarray) -> np.ndarray:
        """Return the indices of organisms in the arrays, with −1 for uid 0 and for missing organisms: i64."""
        at, there = matched(self.uid[self._by_uid], uids)
        out = np.full(len(uids), -1)
        out[there] = self._by_uid[at[there]]
        return out

    @property
    def founders(self) -> np.ndarray:
        """True for organisms without parents: bool."""
        return (self.parent == 0) & (self.parent2 == 0)

    def place(self, uid: int) -> int:
        """Return the index of an organism in the arrays.

        Parameters
        ----------
        uid : int

        Returns
        -------
        int

        Raises
        ------
        KeyError
            If the organism is not in the pedigree.
        """
        at = int(self._places(np.array([max(uid, 0)], np.uint64))[0])
        if at < 0:
            raise KeyError(f"no organism of this lineage has the uid {uid}")
        return at

    def alive(self, tick: int) -> np.ndarray:
        """Return which organisms are alive at the end of a tick.

        Parameters
        ----------
        tick : int

        Returns
        -------
        array of bool, shape (organisms,)
        """
        return (self.born <= tick) & ((self.died == ALIVE) | (self.died > tick))

    def ancestors(self, uid: int, generations: int | None = None) -> np.ndarray:
        """Return the uids of an organism's parents, grandparents and so on, through both parents.

        Parameters
        ----------
        uid : int
        generations : int, optional
            Number of generations to go back; default: to the founders.

        Returns
        -------
        array of uint64
            Sorted uids.
        """
        before: set[int] = set()
        front, left = {self.place(uid)}, len(self) if generations is None else generations
        while front and left > 0:
            parents = {int(line[i]) for i in front for line in (self.mother, self.father)}
            front = parents - {-1} - before
            before |= front
            left -= 1
        return self.uid[sorted(before)]

    def descendants(self, uid: int) -> np.ndarray:
        """Return the uids of an organism's children, grandchildren and so on, through both parents.

        Parameters
        ----------
        uid : int

        Returns
        -------
        array of uint64
            Sorted uids.
        """
        first = self.place(uid)
        below = [False] * (len(self) + 1)  # the last is for missing parents, whose index is −1
        below[first] = True
        mother, father = self.mother.tolist(), self.father.tolist()
        for i in range(first + 1, len(self)):  # parents come before their children
            below[i] = below[mother[i]] or below[father[i]]
        below[first] = False
        return self.uid[np.array(below[:-1], bool)]

    def generation(self) -> np.ndarray:
        """Return each organism's generation: 0 for founders, otherwise 1 plus the mean of its parents'.

        Returns
        -------
        array of float64, shape (organisms,)
        """
        depth: list[float] = []
        for m, f in zip(self.mother.tolist(), self.father.tolist(), strict=True):
            parents = [depth[i] for i in (m, f) if i >= 0]
            depth.append(sum(parents) / len(parents) + 1 if parents else 0.0)
        return np.array(depth, float)

    def _forebears(self, mask: np.ndarray, fathers: bool = True) -> np.ndarray:
        """Add the ancestors of the organisms in `mask`; if `fathers` is false, only along first parents."""
        marked = [*mask.tolist(), False]  # the last is for missing parents, whose index is −1
        mother, father = self.mother.tolist(), (self.father if fathers else self.mother).tolist()
        for i in range(len(self) - 1, -1, -1):
            if marked[i]:
                marked[mother[i]] = marked[father[i]] = True
        return np.array(marked[:-1], bool)

    def founders_left(self, tick: int | None = None) -> np.ndarray:
        """Return the founders that are alive at a tick or have living descendants then.

        Parameters
        ----------
        tick : int, optional
            Tick; default: the last.

        Returns
        -------
        array of uint64
        """
        return self.uid[self._forebears(self.alive(self.end if tick is None else tick)) & self.founders]

    def most_recent_common_ancestor(self, uids: Iterable[int]) -> int:
        """Return the youngest organism from which all `uids` descend along first parents.

        Parameters
        ----------
        uids : iterable of int

        Returns
        -------
        int
            Its uid, which may itself be in `uids`; 0 if there is no such organism.
        """
        lines = {self.place(uid) for uid in uids}
        if not lines:
            raise ValueError("lineage: no uids to find a common ancestor of; pass at least one")
        while len(lines) > 1:
            lines.add(int(self.mother[youngest := max(lines)]))
            lines.remove(youngest)
            if -1 in lines:
                return 0
        return int(self.uid[lines.pop()])

    def samples(self, every: int) -> np.ndarray:
        """Return the ticks at which a whole run is sampled: 0, every, 2 every, …"""
        if every < 1:
            raise ValueError(f"lineage: every is {every}; it must be at least 1 tick")
        return np.arange(0, self.end + 1, every)

    def living_sums(
        self, ticks: np.ndarray, weights: np.ndarray | None = None, mask: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the sum of weights (default: 1) over organisms in `mask` alive at these ascending ticks."""
        mask = np.ones(len(self), bool) if mask is None else mask
        change = np.zeros(len(ticks) + 1, np.int64 if weights is None else float)
        for sign, when, selected in ((1, self.born, mask), (-1, self.died, mask & (self.died != ALIVE))):
            chosen = None if weights is None else weights[selected]
            sums = np.bincount(np.searchsorted(ticks, when[selected]), chosen, len(ticks) + 1)
            change += (sign * sums).astype(change.dtype)
        return np.cumsum(change[:-1])
