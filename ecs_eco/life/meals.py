"""The food that eaters of all species claim, and the selection of the meals that take place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Body, Shape
from ecs_eco.engine.random import lot, lots

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.index import Index


class Appetite(NamedTuple):
    """Animals that may eat, for kernels: f32[rows], or numbers shared by all."""

    radius: Number  # [m]
    reach: Number  # [m]
    chance: Number  # probability of success per second
    until: Number  # energy of satiation
    decision: np.ndarray  # u8[rows, actions]
    column: int  # column of the `eat` action; −1: none
    cause: np.ndarray  # i32[rows], cause of death
    energy: np.ndarray
    digesting: np.ndarray  # i32[rows], remaining ticks


class Foods(NamedTuple):
    """Possible food, for kernels: f32[rows]."""

    radius: Number  # [m]
    toughness: np.ndarray  # share of bites that fail, or an array of length 1; empty: none
    cause: np.ndarray  # i32[rows], cause of death
    dt: float  # [s]


class Eaters(NamedTuple):
    """The columns of eaters that a meal changes, for kernels: [rows]."""

    cause: np.ndarray
    killer: np.ndarray
    energy: np.ndarray
    digesting: np.ndarray
    taken: np.ndarray


class Eaten(NamedTuple):
    """The columns of food that a meal reads or changes, for kernels: [rows]."""

    cause: np.ndarray
    killer: np.ndarray
    uid: np.ndarray
    held: np.ndarray  # energy before all meals; empty: none
    poison: np.ndarray  # or an array of length 1; empty: none


class Effect(NamedTuple):
    """The effect of a meal, for kernels: numbers, or arrays [rows] with one value per eater."""

    gain: Number  # energy per meal, regardless of what the food contains
    efficiency: Number  # share of the food's energy
    ceiling: Number  # maximum energy
    digestion: Number  # ticks
    until: Number  # energy of satiation


@dataclass(slots=True)
class Meals:
    """The meals of one table on one kind of food in this tick; eaters and items are index entries."""

    table: Table
    prey: Table
    food: Any
    eaters: Index
    foods: Index
    target: np.ndarray
    """The item that each eater proposes: i32[eaters] (−1: none)."""
    distance2: np.ndarray
    """The squared distance to that item: f32[eaters] [m^2]."""
    effect: Effect
    poison: np.ndarray
    held: np.ndarray
    """The energy of the food before all meals."""
    best: np.ndarray
    """The eater that gets each item, once decided: i32[foods] (−1: none)."""


def to_surfaces(meals: Meals) -> None:
    """Reduce distances between spheres to distances between surfaces, as for other shapes."""
    if Shape in meals.table or Shape in meals.prey:
        return
    some = np.flatnonzero(meals.target >= 0)
    radii = (
        meals.table[Body].radius[meals.eaters.rows[some]]
        + meals.prey[Body].radius[meals.foods.rows[meals.target[some]]]
    )
    meals.distance2[some] = np.maximum(np.sqrt(meals.distance2[some]) - radii, np.float32(0)) ** 2


def award(key: np.uint64, rivals: list[Meals]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give each item of one kind of food to the nearest eater that claims it; return that eater's index
    among all rivals, i32[foods] (−1: none), and the rivals' squared distances and uids."""
    first, start = rivals[0], 0
    best, target, distance2, uid = first.best, first.target, first.distance2, first.eaters.uid
    if len(rivals) > 1:
        target, distance2, uid = map(
            np.concatenate,
            zip(*((meals.target, meals.distance2, meals.eaters.uid) for meals in rivals), strict=True),
        )
    win(target, distance2, uid, first.foods.uid, key, best)
    for meals in rivals if len(rivals) > 1 else ():
        end = start + meals.target.size
        meals.best = np.where((best >= start) & (best < end), best - np.int32(start), np.int32(-1))
        start = end
    return best.copy(), distance2, uid  # a copy, because meals that wait leave `Meals.best`


def postponed(
    key: np.uint64, wanted: list[Meals], won: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]
) -> list[Meals]:
    """Keep each eater's nearest meal, unless it may still be eaten in a nearer one; return the meals that wait,
    without those of eaters that have been eaten in a nearer one."""
    later, of_table = list[Meals](), dict[str, list[Meals]]()
    for meals in wanted:
        of_table.setdefault(meals.table.name, []).append(meals)
    for name, mine in of_table.items():
        alone = len(mine) == 1
        if alone and name not in won:
            continue
        n = mine[0].eaters.n
        hunted, first = np.zeros(n, np.bool_), np.zeros(n, np.int32)
        for meals in (*wanted, *later):
            if meals.prey.name == name:
                hunted |= meals.best >= 0
        if not alone:
            least, item = np.empty(n, np.float32), np.empty(n, np.uint64)
            first -= 1
            for k, meals in enumerate(mine):
                ways = meals.distance2, meals.eaters.uid, meals.foods.uid, key, k
                prefer(meals.best, *ways, first, least, item)
        one = mine[0]
        hunters = won[name] if name in won else (np.full(n, -1, np.int32), one.distance2, one.eaters.uid)
        for k, meals in enumerate(mine):
            ways = meals.distance2, meals.eaters.uid, meals.foods.uid, key, k
            rest = np.empty(meals.foods.n, np.int32)
            if wait(meals.best, *ways, first, *hunters, meals.eaters.rows, hunted, meals.table.cause, rest):
                later.append(replace(meals, best=rest))
    return later


def in_order(key: np.uint64, eaten: list[Meals]) -> Iterator[tuple[Meals, np.ndarray, np.ndarray]]:
    """Yield meals with the entries of eaters and items i64[k], in an order in which animals eat before they
    are eaten. If any eater dies, the nearest meals come first, with ties broken at random; otherwise, the
    given order is kept."""
    items = [np.flatnonzero(meals.best >= 0) for meals in eaten]
    eaters = [meals.best[item] for meals, item in zip(eaten, items, strict=True)]
    if not any(
        meals.table.cause[meals.eaters.rows[some]].any() for meals, some in zip(eaten, eaters, strict=True)
    ):
        yield from zip(eaten, eaters, items, strict=True)
        return
    kind = np.repeat(np.arange(len(eaten)), [item.size for item in items])
    distance2 = np.concatenate([meals.distance2[some] for meals, some in zip(eaten, eaters, strict=True)])
    lot = np.concatenate(
        [
            lots(key, meals.eaters.uid[some], meals.foods.uid[item])
            for meals, some, item in zip(eaten, eaters, items, strict=True)
        ]
    )
    order = np.lexsort((lot, distance2))
    kind, eater, item = kind[order], np.concatenate(eaters)[order], np.concatenate(items)[order]
    for part in np.split(np.arange(kind.size), np.flatnonzero(np.diff(kind)) + 1):
        yield eaten[kind[part[0]]], eater[part], item[part]


@njit
def win(target, distance2, uid, food_uid, key, best):
    """Write the nearest eater that claims each item to `best` i32[foods] (−1: none); ties are broken at
    random."""
    best[:] = -1
    for i in range(target.size):
        j = target[i]
        if j < 0:
            continue
        other = best[j]
        if (
            other < 0
            or distance2[i] < distance2[other]
            or (
                distance2[i] == distance2[other]
                and lot(key, uid[i], food_uid[j]) < lot(key, uid[other], food_uid[j])
            )
        ):
            best[j] = i


@njit
def prefer(best, distance2, uid, food_uid, key, kind, first, least, item):
    """Update each eater's nearest item: its kind in `first` i32[eaters] (−1: none), its squared distance, and
    its uid; ties are broken at random."""
    for j in range(best.size):
        i = best[j]
        if i >= 0 and (
            first[i] < 0
            or distance2[i] < least[i]
            or (distance2[i] == least[i] and lot(key, uid[i], food_uid[j]) < lot(key, uid[i], item[i]))
        ):
            first[i], least[i], item[i] = kind, distance2[i], food_uid[j]


@njit
def wait(
    best, distance2, uid, food_uid, key, kind, first, hunter, near, hunter_uid, rows, hunted, cause, later
):
    """Move meals to `later` i32[foods] if their eater has a nearer one, or if `hunter` i32[eaters] may still eat
    it (`hunted`) in a nearer one, at the squared distance `near`; remove them if it has. Return how many were
    moved."""
    n = 0
    for j in range(best.size):
        later[j], i = -1, best[j]
        if i < 0 or (first[i] == kind and (hunter[i] < 0 or not (hunted[i] or cause[rows[i]]))):
            continue
        h, waits = hunter[i], first[i] != kind
        if not waits and (
            near[h] < distance2[i]
            or (near[h] == distance2[i] and lot(key, hunter_uid[h], uid[i]) < lot(key, uid[i], food_uid[j]))
        ):
            best[j], waits = -1, hunted[i]
        if waits:
            best[j], later[j] = -1, i
            n += 1
    return n


@njit
def hungry(best, rows, digesting, energy, until):
    """Remove from `best` the eaters that can no longer eat; return how many remain."""
    n = 0
    for j in range(best.size):
        i = best[j]
        if i >= 0 and (digesting[rows[i]] > 0 or energy[rows[i]] >= of_row(until, rows[i])):
            best[j] = -1
        n += best[j] >= 0
    return n
