"""The meals that eaters of all species want, and which of them take place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Body, Shape
from ecs_eco.engine.jit import njit
from ecs_eco.engine.random import lot, lots

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.index import Index


@dataclass(slots=True)
class Meals:
    """The meals of one table of one kind of food in this tick; numbers are entries of the two indexes."""

    table: Table
    prey: Table
    food: Any
    eaters: Index
    foods: Index
    target: np.ndarray
    """The item that each eater wants, −1 for none: i32[eaters]."""
    distance2: np.ndarray
    """The square of its distance: f32[eaters] [m^2]."""
    effect: tuple[Any, ...]
    """Gain, efficiency, the most energy, ticks of digestion, and the energy that is enough."""
    poison: np.ndarray
    held: np.ndarray
    """The energy of the food before all meals."""
    best: np.ndarray
    """The eater that gets each item, −1 for none, once that is settled: i32[foods]."""


def to_surfaces(meals: Meals) -> None:
    """Let the distances of spheres be those of surfaces, as those of other shapes are."""
    if Shape in meals.table or Shape in meals.prey:
        return
    some = np.flatnonzero(meals.target >= 0)
    radii = (meals.table[Body].radius[meals.eaters.rows[some]]
             + meals.prey[Body].radius[meals.foods.rows[meals.target[some]]])
    meals.distance2[some] = np.maximum(np.sqrt(meals.distance2[some]) - radii, np.float32(0)) ** 2


def award(key: np.uint64, rivals: list[Meals]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give each item of one kind of food to the nearest of all that want it; return the numbers of these
    i32[foods], −1 for none, among all rivals, and distances squared and uids of the rivals."""
    first, start = rivals[0], 0
    best, target, distance2, uid = first.best, first.target, first.distance2, first.eaters.uid
    if len(rivals) > 1:
        target, distance2, uid = map(np.concatenate, zip(*(
            (meals.target, meals.distance2, meals.eaters.uid) for meals in rivals), strict=True))
    win(target, distance2, uid, first.foods.uid, key, best)
    for meals in rivals if len(rivals) > 1 else ():
        end = start + meals.target.size
        meals.best = np.where((best >= start) & (best < end), best - np.int32(start), np.int32(-1))
        start = end
    return best, distance2, uid


def several(mine: list[Meals]) -> bool:
    """Return whether any eater of one table has won items of several kinds."""
    winners = np.concatenate([meals.best[meals.best >= 0] for meals in mine])
    return winners.size > 1 and bool(np.bincount(winners).max() > 1)


def in_order(key: np.uint64, some: list[Meals]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the meals that were won, the nearest first, ties by lot: which of `some`, the eater, and the
    item: i64[k] each."""
    items = [np.flatnonzero(meals.best >= 0) for meals in some]
    eaters = [meals.best[item] for meals, item in zip(some, items, strict=True)]
    kind = np.repeat(np.arange(len(some)), [item.size for item in items])
    distance2 = np.concatenate([meals.distance2[one] for meals, one in zip(some, eaters, strict=True)])
    lot = np.concatenate([lots(key, meals.eaters.uid[one], meals.foods.uid[item])
                          for meals, one, item in zip(some, eaters, items, strict=True)])
    order = np.lexsort((lot, distance2))
    return kind[order], np.concatenate(eaters)[order], np.concatenate(items)[order]


@njit
def win(target, distance2, uid, food_uid, key, best):
    """Write the nearest of those that want an item to `best` i32[foods], −1 for none; ties by lot."""
    best[:] = -1
    for i in range(target.size):
        j = target[i]
        if j < 0:
            continue
        other = best[j]
        if (other < 0 or distance2[i] < distance2[other] or (
                distance2[i] == distance2[other]
                and lot(key, uid[i], food_uid[j]) < lot(key, uid[other], food_uid[j]))):
            best[j] = i


@njit
def void(target, distance2, uid, food_uid, key, hunter, hunter_distance2, hunter_uid, best):
    """Take the meals out of `best` whose eaters are themselves won as food, by `hunter` i32[eaters], in a
    meal that is nearer, or as near and has the lower lot."""
    for i in range(target.size):
        j, h = target[i], hunter[i]
        if j >= 0 and h >= 0 and best[j] == i and (
                hunter_distance2[h] < distance2[i] or (
                hunter_distance2[h] == distance2[i]
                and lot(key, hunter_uid[h], uid[i]) < lot(key, uid[i], food_uid[j]))):
            best[j] = -1
