"""Families: founders, descendants, and the family tree of one organism."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ecs_eco.engine.uids import matched
from ecs_eco.view.genealogy import Genealogy, Lives, Young
from ecs_eco.view.source import Message, uid_of

SLOTS = 12  # families of a species that get their own color
KIN = "kin:"  # prefix of a uid: color that organism's descendants


def asked(colour: object) -> int | None:
    """Return the uid whose descendants a color shows, or None for any other kind of color."""
    digits = colour[len(KIN) :] if isinstance(colour, str) and colour.startswith(KIN) else ""
    return int(digits) if digits.isascii() and digits.isdigit() and 0 < int(digits) < 2**63 else None


def _shade(slot: int | None) -> int:
    """Return the color value of a family: the middle of its section of the ramp, or 0 for no color."""
    return 0 if slot is None else int(1 + 21 * (slot + 0.5))


class Families:
    """Founders and descendants in a growing set of lives. Families are traced through the first parent."""

    def __init__(self, lives: Callable[[], Lives]) -> None:
        self._lives = lives
        self._uid = self._root = np.zeros(0, np.uint64)
        self._slots: dict[str, dict[int, int]] = {}
        self._found: dict[int, tuple[int, np.ndarray]] = {}  # uid → number of lives scanned, descendants

    def roots(self, uid: np.ndarray) -> np.ndarray:
        """Return the founder of each organism: u64[n]. An organism without known parents is its own founder."""
        self._grow()
        row, known = matched(self._uid, uid)
        return np.where(known, self._root[row], uid) if self._uid.size else uid

    def values(self, name: str, uid: np.ndarray) -> np.ndarray:
        """Return the values u8[n] of a species' organisms for the color "family". Each of the largest
        families keeps its value over time; all other organisms have 0."""
        founders, family, size = np.unique(self.roots(uid), return_inverse=True, return_counts=True)
        there = set(founders.tolist())
        slots = {root: slot for root, slot in self._slots.get(name, {}).items() if root in there}
        free = [slot for slot in range(SLOTS) if slot not in slots.values()]
        for i in np.argsort(-size, kind="stable").tolist():
            if not free or size[i] < 2:
                break
            if int(founders[i]) not in slots:
                slots[int(founders[i])] = free.pop(0)
        self._slots[name] = slots
        return np.array([_shade(slots.get(root)) for root in founders.tolist()], np.uint8)[family]

    def clades(self, colour: object, names: Sequence[str | None], uid: np.ndarray) -> list[int | None]:
        """Return each organism's value for a color by descent, as last set by `values`; None for other colors."""
        of = asked(colour)
        if of is not None:
            return list(self.kin(of, uid).tolist())
        if colour != "family":
            return [None] * uid.size
        slots = (
            self._slots.get(name or "", {}).get(root)
            for name, root in zip(names, self.roots(uid).tolist(), strict=True)
        )
        return [_shade(slot) for slot in slots]

    def descendants(self, of: int) -> np.ndarray:
        """Return the uids of an organism and all its descendants through either parent: u64[n], ascending."""
        uid, first, second = self._lives()
        begin, found = self._found.get(of, (0, np.array([of], np.uint64)))
        begin = begin if begin <= uid.size else 0
        while begin < uid.size:
            rows = np.isin(first[begin:], found) | np.isin(second[begin:], found)
            grown = np.union1d(found, uid[begin:][rows])
            if grown.size == found.size:
                break
            found = grown
        self._found = {of: (uid.size, found)}
        return found

    def kin(self, of: int, uid: np.ndarray) -> np.ndarray:
        """Return 255 for the descendants of an organism and 0 for all other organisms."""
        return np.where(np.isin(uid, self.descendants(of)), 255, 0).astype(np.uint8)

    def _grow(self) -> None:
        """Find the founders of organisms born since the last call."""
        uid, parent, _ = self._lives()
        known = int(np.searchsorted(uid, self._uid[-1], side="right")) if self._uid.size else 0
        if known == uid.size == self._uid.size:
            return
        root = uid.astype(np.uint64)
        if known:
            root[:known] = self._root[np.searchsorted(self._uid, uid[:known])]
        row, hit = matched(uid, parent[known:])
        hit &= parent[known:] > 0
        while True:  # each pass adds one generation
            now = np.where(hit, root[row], root[known:])
            if (now == root[known:]).all():
                break
            root[known:] = now
        self._uid, self._root = uid.copy(), root


ABOVE = 48  # maximum number of ancestors in the list
BESIDE = 12  # maximum number of siblings
BELOW = 24  # maximum number of children
EACH = 4  # maximum number of grandchildren per child


def tree(known: Genealogy, families: Families, request: Message) -> Message:
    """Return the message "tree" for the organism in a request; raise ValueError if it is unknown.

    `lives` contains the focal organism, its nearest `ABOVE` ancestors, its last `BESIDE` siblings, its
    `BELOW` most fertile children and the last `EACH` grandchildren per child. In each life, `young` is the
    total number of children, if known, and `clade` is the value from 0 to 255 for the requested color `by`,
    if that color shows descent. `siblings` counts all siblings and half-siblings of the focal organism."""
    uid = uid_of(request)
    focal = known.life(uid)
    if focal is None:
        raise ValueError(f"tree: no organism {uid} is known here")
    lives = _ancestors(known, uid, focal)
    children = known.young(_uids([uid]))
    theirs = known.young(children.uid)
    order = np.lexsort((children.uid, _counted(children.uid, theirs)))  # ties favor younger children
    chosen = np.sort(children.uid[order[-BELOW:]])
    last = [theirs.uid[(theirs.parents == parent).any(axis=1)][-EACH:] for parent in chosen]
    grand = np.unique(np.concatenate([_uids([]), *last]))
    after = known.young(grand)
    parents = _uids(focal["parents"])
    litter = known.young(parents)
    beside = litter.uid[~np.isin(litter.uid, _uids([*lives, *children.uid.tolist()]))]
    listed = [*chosen.tolist(), *grand.tolist(), *beside[-BESIDE:].tolist()]
    lives |= {one: known.life(one) or _unknown() for one in dict.fromkeys(listed) if one not in lives}
    counts = [(_uids([uid]), children), (chosen, theirs), (grand, after), (parents, litter)]
    young = {
        one: n
        for uids, of in counts
        for one, n in zip(uids.tolist(), _counted(uids, of).tolist(), strict=True)
    }
    clades = families.clades(request.get("by"), [life["species"] for life in lives.values()], _uids([*lives]))
    return {
        "kind": "tree",
        "uid": uid,
        "siblings": int(beside.size),
        "lives": [
            {"uid": one, "young": young.get(one), "clade": clade, **life}
            for (one, life), clade in zip(lives.items(), clades, strict=True)
        ],
    }


def _ancestors(known: Genealogy, uid: int, focal: dict[str, Any]) -> dict[int, dict[str, Any]]:
    """Return the lives of an organism and its ancestors by uid, generation by generation."""
    lives, waiting = {uid: focal}, list(focal["parents"])
    while waiting and len(lives) <= ABOVE:
        one = waiting.pop(0)
        if one not in lives:
            lives[one] = known.life(one) or _unknown()
            waiting += lives[one]["parents"]
    return lives


def _unknown() -> dict[str, Any]:
    return {"species": None, "born": None, "died": None, "age": None, "parents": []}


def _counted(uids: np.ndarray, of: Young) -> np.ndarray:
    """Return the number of children of each organism: i64[n]."""
    every = np.sort(of.parents.ravel())
    return np.searchsorted(every, uids, side="right") - np.searchsorted(every, uids)


def _uids(uids: Sequence[int]) -> np.ndarray:
    return np.array(uids, np.uint64)
