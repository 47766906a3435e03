"""Animals ingest what they touch."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Body, Defence, Matter, Metabolism, Nervous, Position, Shape, Velocity
from ecs_eco.engine import random
from ecs_eco.engine.elementary import power
from ecs_eco.engine.jit import lone_njit, njit
from ecs_eco.engine.per_row import of_row
from ecs_eco.engine.random import draw
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import highest, own_value, own_values
from ecs_eco.lifecycle.births import ticks
from ecs_eco.lifecycle.causes import register_eaters
from ecs_eco.lifecycle.ingestion import swallow
from ecs_eco.lifecycle.sizes import of_size
from ecs_eco.lifecycle.torpor import LEAST_ENERGY
from ecs_eco.space.land import at_places
from ecs_eco.space.nearest import nearest, seek
from ecs_eco.space.surfaces import nearest_surface

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.terrain import Terrain
    from ecs_eco.space.world import SpatialWorld

NO_DECISION = np.zeros((1, 1), np.uint8)
UNDEFENDED = np.zeros(0, np.float32)
NOTHING = np.zeros(0, np.float32)
NO_RADIUS = np.float32(0)  # to the surface
NOBODY = np.zeros(0, np.int64)
LONGEST = np.iinfo(np.int32).max  # ticks of digestion


class Feed(System):
    """An animal that eats, and digests nothing, takes the nearest food within reach,
    with the diet's chance of success.

    Each proposes one item; an item goes to the nearest of those that want it, ties to the lower uid; the
    eaten die. An animal with an action `eat` eats when it decides to; one without eats whenever it can. Tough
    food resists some bites, as does prey that land shelters; poison costs the eater energy, and deadly food
    kills it. Where the eater's body holds substances, those of the eaten go into it.
    """

    needs = (Position, Body, Metabolism)
    phase = "interact"

    @cached_property
    def _meals(self) -> dict[tuple[str, int], tuple[tuple[Any, ...], tuple[Any, ...]]]:
        """By eater and food: what its meals are made of, and what they then are."""
        return {}

    def start(self, world: SpatialWorld) -> None:
        """Register the causes of death in the order of species."""
        for table in world.tables.values():
            register_eaters(world, table)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Let one species eat, one kind of food after the other."""
        for number, food in enumerate(table.species.diet):
            table.species.eaten[food.eats] = self.eat(table, world.tables[food.eats], food, number, world)

    def eat(self, table: Table, prey: Any, food: Any, number: int, world: SpatialWorld) -> float:
        """Let all of `table` that want to eat take from `prey`; return what they gained by it [energy]."""
        if not table.n or not prey.n:
            return 0.0
        eaters, foods = world.index(table), world.index(prey)
        b, m, nerves = table[Body], table[Metabolism], table.species.nerves
        reach, chance, ceiling, gain, efficiency, store, digestion = self.meal(table, food, number, world.dt)
        furthest = highest(reach, table.alive) if isinstance(reach, np.ndarray) else food.reach
        target, distance2 = np.empty(eaters.n, np.int32), np.empty(eaters.n, np.float32)
        column = -1 if nerves is None else nerves.eats
        decision = NO_DECISION if nerves is None else table[Nervous].decision
        toughness, poison = defences(world, prey)
        if world.dt != 1 and toughness.size and food.chance > 0:  # a bite lasts a second
            bites = in_ticks(food.chance * (1 - np.clip(toughness, 0, 1)), world.dt)
            toughness = np.float32(1) - (bites / in_ticks(food.chance, world.dt)).astype(np.float32)
        wish = (eaters.rows, eaters.uid, foods.rows, b.radius, prey[Body].radius, reach, decision, column,
                chance, ceiling, world.key, random.FEED + (number << 8), toughness, table.cause, m.energy,
                m.digesting, prey.cause)
        if Shape in table or Shape in prey:
            target, distance2 = nearest_surface(world, table, prey, furthest)
            world.split(propose, eaters.n, target, distance2, *wish[:3], NO_RADIUS, NO_RADIUS, *wish[5:])
        else:
            mine, theirs = b.radius[: table.high], prey[Body].radius[: prey.high]
            # of few numbers, argmax takes a third of the time of a maximum
            widest = float(mine[mine.argmax()] + theirs[theirs.argmax()]) + furthest
            seeking = eaters, foods, widest, target, distance2, world.split, seek_food, wish
            if world.bands.size == 1:
                nearest(*seeking)
            else:
                with world.bands.over(eaters, target, distance2):
                    nearest(*seeking)
        held = prey[Metabolism].energy if Metabolism in prey else NOTHING
        best = np.empty(foods.n, np.int32)
        own = before = NOBODY
        if world.bands.divided:  # what ghosts gain is theirs
            own = eaters.rows[world.bands.entries(eaters)]
            before = m.energy[own].astype(np.float64)
        gained: float = ingest(
            target, distance2, eaters.rows, eaters.uid, foods.rows, gain, efficiency, held, store, digestion,
            poison, world.codes[f"eaten by {table.name}"],
            world.codes[f"poisoned by {food.eats}"] if food.deadly else 0, LEAST_ENERGY[table.species.torpor],
            table.cause, table.killer, best, m.energy, m.digesting, m.taken, prey.cause,
            prey.killer, prey.uid)
        if Matter in table:
            eaten = np.flatnonzero(best >= 0)
            share = own_value(table, f"diet.{food.eats}.assimilation",
                              1.0 if food.assimilation is None else food.assimilation)
            swallow(world, table, eaters.rows[best[eaten]], prey, foods.rows[eaten], share)
        return float((m.energy[own] - before).sum()) if world.bands.divided else gained

    def meal(self, table: Table, food: Any, number: int, dt: float) -> tuple[Any, ...]:
        """Return what `meal` does, found anew only where it is another, or where it is each one's own."""
        way = table.species.config.metabolism
        if table.species.traits or table.species.growth is not None:
            return meal(table, food, dt)
        given = food, way, dt  # sections of a world file do not change: others take their place
        known = self._meals.get((table.name, number))
        if known is None or known[0] != given:
            known = self._meals[table.name, number] = given, meal(table, food, dt)
        return known[1]


def meal(table: Table, food: Any, dt: float) -> tuple[Any, ...]:
    """Return reach, chance in a tick, ceiling, gain and efficiency of one kind of food, the most energy, and
    the ticks of digestion: numbers, or arrays [high] where a gene codes for any of them."""
    metabolism, kind = table.species.config.metabolism, f"diet.{food.eats}."
    keys = {kind + field: np.float32(getattr(food, field)) for field in ("reach", "gain", "efficiency")}
    keys |= {"metabolism.energy_max": np.float32(metabolism.energy_max),
             "metabolism.digestion": metabolism.digestion, kind + "chance": food.chance}
    if food.until is not None:
        keys[kind + "until"] = np.float32(food.until)
    reach, gain, efficiency, store, digestion, chance, *until = own_values(table, keys)
    chance, store = in_ticks(chance, dt), of_size(table, store)
    digestion = np.asarray(ticks(np.minimum(digestion, LONGEST * dt), dt)).astype(np.int32)[()]
    return (reach, chance.astype(np.float32) if isinstance(chance, np.ndarray) else np.float32(chance),
            until[0] if until else store, gain, efficiency, store, digestion)


def in_ticks(chance: Any, dt: float) -> Any:
    """Return the chance in a tick of dt [s] of what has a chance in a second, or of each."""
    return 1 - power(1 - chance, dt)


def defences(world: SpatialWorld, prey: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the share of bites that fail and the poison of each row, or arrays of one for all; empty if it
    has no defence."""
    toughness, poison = of_body(prey)
    if world.terrain is not None:
        toughness = sheltered(world.terrain, prey, toughness)
    return toughness, poison


def of_body(prey: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return toughness and poison of each row, f32[capacity], or arrays of one for all;
    empty if it has no defence."""
    defence = getattr(prey.species.config, "defence", None)
    if Defence in prey:
        return prey[Defence].toughness, prey[Defence].poison
    if defence is None or (defence.toughness == 0 and defence.poison == 0):
        return UNDEFENDED, UNDEFENDED
    return np.full(1, defence.toughness, np.float32), np.full(1, defence.poison, np.float32)


def sheltered(terrain: Terrain, prey: Any, toughness: np.ndarray) -> np.ndarray:
    """Return the share of the bites that fail, f32[high], on prey that moves where the land shelters it; as
    it is where it does not."""
    high = prey.high
    if terrain.land is None or terrain.land.shelter is None or Velocity not in prey:
        return toughness
    p = prey[Position]
    left = np.float32(1) - at_places(terrain.land.shelter, terrain, p.x[:high], p.y[:high])
    if toughness.size:
        left *= np.float32(1) - (toughness if toughness.size == 1 else toughness[:high])
    return np.float32(1) - left


@lone_njit
def seek_food(first, last, ox, oy, oz, ostart, tx, ty, tz, tstart, same, k, nx, ny, nz, lengths, torus, flat,
              radius2, target, distance2, rows, uid, food_rows, radius, food_radius, reach, decision, column,
              chance, until, key, purpose, toughness, eater_cause, energy, digesting, food_cause):
    """`seek` for the eaters in the rows of cells first … last − 1, then `propose`."""
    seek(first, last, ox, oy, oz, ostart, tx, ty, tz, tstart, same, k, nx, ny, nz, lengths, torus, flat,
         radius2, target, distance2)
    propose(ostart[first * nx], ostart[last * nx], target, distance2, rows, uid, food_rows, radius,
            food_radius, reach, decision, column, chance, until, key, purpose, toughness, eater_cause, energy,
            digesting, food_cause)


@lone_njit
def propose(first, last, target, distance2, rows, uid, food_rows, radius, food_radius, reach, decision,
            column, chance, until, key, purpose, toughness, eater_cause, energy, digesting, food_cause):
    """Let eaters first … last − 1 leave the nearest food where they cannot have it: `target` is −1 then."""
    for k in range(last - first):
        i = np.uint64(first + k)
        j, row = target[i], rows[i]
        if j < 0:
            continue
        if (eater_cause[row] or food_cause[food_rows[j]] or digesting[row] > 0
                or energy[row] >= of_row(until, row) or (column >= 0 and not decision[row, column])):
            target[i] = -1
            continue
        s = of_row(radius, row) + of_row(food_radius, food_rows[j]) + of_row(reach, row)
        succeeds = of_row(chance, row)
        if toughness.size:
            succeeds *= np.float32(1) - toughness[food_rows[j] % toughness.size]
        if distance2[i] > s * s or draw(key, uid[i], purpose) >= succeeds:
            target[i] = -1


@njit
def ingest(target, distance2, rows, uid, food_rows, gain, efficiency, held, ceiling, digestion, poison, cause,
           deadly, least, eater_cause, eater_killer, best, energy, digesting, taken, food_cause,
           food_killer, food_uids):
    """Resolve the proposals of all eaters, in canonical order, and apply them; return what all gained. `best`
    i32[foods] becomes the eater of each food, −1 for none."""
    best[:] = -1
    for i in range(target.size):
        j = target[i]
        if j < 0:
            continue
        other = best[j]
        if (other < 0 or distance2[i] < distance2[other]
            or (distance2[i] == distance2[other] and uid[i] < uid[other])):
            best[j] = i
    gained, n, eaten = 0.0, 0, np.empty(best.size, np.int32)
    for j in range(best.size):  # without branches: a meal's memory is fetched while others wait for theirs
        eaten[np.uint64(n)] = j
        n += best[j] >= 0
    for k in range(n):
        item = np.uint64(eaten[k])
        eater = np.uint64(best[item])
        row, food = np.uint64(rows[eater]), np.uint64(food_rows[item])
        before, worth, share = energy[row], of_row(gain, row), of_row(efficiency, row)
        if share > 0 and held.size:
            worth += share * max(held[food], np.float32(0.0))
        if poison.size:
            worth -= poison[food % np.uint64(poison.size)]
        after = min(before + worth, max(before, of_row(ceiling, row)))  # bad food has a negative gain
        energy[row] = max(after, min(before, least))
        taken[row] += energy[row] - before
        gained += np.float64(energy[row]) - np.float64(before)
        digesting[row] = of_row(digestion, row)
        food_cause[food] = cause
        food_killer[food] = uid[eater]
        if deadly:
            eater_cause[row] = deadly
            eater_killer[row] = food_uids[food]
    return gained
