"""Animals feed."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Body, Defence, Matter, Metabolism, Nervous, Position, Shape, Velocity
from ecs_eco.engine import random
from ecs_eco.engine.random import draw
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import highest, own_value, own_values
from ecs_eco.life.births import ticks
from ecs_eco.life.causes import register_eaters
from ecs_eco.life.ingestion import swallow
from ecs_eco.life.meals import (
    Appetite,
    Eaten,
    Eaters,
    Effect,
    Foods,
    Meals,
    award,
    hungry,
    in_order,
    postponed,
    to_surfaces,
)
from ecs_eco.life.sizes import of_size
from ecs_eco.life.torpor import LEAST_ENERGY
from ecs_eco.nervous.sensors.nearest import number_in_view
from ecs_eco.space.index import Entries
from ecs_eco.space.land import at_places
from ecs_eco.space.nearest import Found, nearest
from ecs_eco.space.surfaces import nearest_surface

if TYPE_CHECKING:
    from ecs_eco.config.features.feeding import Diet
    from ecs_eco.engine.table import Table
    from ecs_eco.space.terrain import Terrain
    from ecs_eco.space.world import SpatialWorld

NO_DECISION = np.zeros((1, 1), np.uint8)
UNDEFENDED = np.zeros(0, np.float32)
NOTHING = np.zeros(0, np.float32)
NO_RADIUS = np.float32(0)  # for distances between surfaces
NOBODY = np.zeros(0, np.int64)
LONGEST = np.iinfo(np.int32).max  # ticks of handling


class Feed(System):
    """An animal that eats and is not handling a meal takes the nearest food within reach, with the diet's
    probability of success.

    Each animal claims one item of each kind of food in its diet; each item goes to the nearest eater of any
    species that claims it, with ties broken at random. Meals take place in the order of distance, unless the
    eater has been eaten or can no longer eat; the item is then left. Eaten organisms die. The order of species
    and diets has no effect. Ties between items are described in `nearest` and `nearest_surface`.

    An animal with an `eat` action eats when it decides to; an animal without it eats whenever it can. Tough
    food and prey sheltered by the land resist some bites; prey in view can confuse the eater; poison costs it
    energy, and deadly food kills it. If the eater's body contains substances, it takes up the substances of
    its food.
    """

    needs = (Position, Body, Metabolism)
    phase = "interact"
    divisible = True
    submodel = Submodel(
        "Feeding",
        where=("diet",),
        reads=("diet",),
        rules={
            "": "An animal proposes the nearest item of each kind in its diet if the surfaces of both "
            "bodies are at most `reach` apart; the attempt succeeds in a tick with probability `1 − (1 − "
            "chance (1 − toughness))^dt`, in which shelter multiplies `1 − toughness` by `1 − shelter`. An item "
            "goes to the nearest animal that wants it. Meals take place in the order of distance, unless the "
            "eater has been eaten. Eaten organisms die. An animal eats only while its energy is below "
            "`satiation`, by default `energy_max`, and, if it has an `eat` action, only in that action.",
            "diet.gain": "A meal changes the energy by `gain`, up to `energy_max`.",
            "diet.efficiency": "A meal adds `efficiency` times the item's energy, up to `energy_max`.",
            "diet.deadly": "Deadly food kills its eater.",
            "diet.confusion": "`chance` is divided by the number of items in the range and field of view of the "
            "sensor `confusion`, and is 0 if there are none.",
            "diet.assimilation": "A fraction `assimilation` of the item's substances enters the eater; the "
            "rest enters the first field of each substance.",
        },
        changes=("Metabolism.energy", "Metabolism.taken", "Metabolism.digesting", "Chemistry", "Matter"),
        draws="whether an attempt to feed succeeds, and which of two equally near animals gets an item",
    )
    world: SpatialWorld
    _wanted: list[Meals]  # claimed in this tick
    _shaped: bool  # whether some distances are between surfaces

    @cached_property
    def _meals(self) -> dict[tuple[str, int], tuple[tuple[Any, ...], tuple[Any, ...]]]:
        """The inputs and the results of `meal`, by eater and food."""
        return {}

    def start(self, world: SpatialWorld) -> None:
        """Register the causes of death, species by species."""
        for table in world.tables.values():
            register_eaters(world, table)

    def process(self, *_: object) -> None:
        """Collect the claims of all eaters, decide which ones win, and feed the winners."""
        self._wanted, self._shaped = [], False
        super().process()
        wanted = self._wanted
        if not wanted:
            return
        key = self.world.key
        rivals: dict[str, list[Meals]] = {}
        for meals in wanted:
            rivals.setdefault(meals.prey.name, []).append(meals)
        for meals in wanted if self._shaped else ():
            to_surfaces(meals)
        won, eaten = dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]](), list[Meals]()
        for name, some in rivals.items():
            won[name] = award(key, some)
        while wanted:
            later = postponed(key, wanted, won)
            for meals in wanted:
                self.eat(meals)
                if Matter in meals.table:
                    eaten.append(meals)
            wanted = []
            for meals in later:
                m = meals.table[Metabolism]
                if hungry(meals.best, meals.eaters.rows, m.digesting, m.energy, meals.effect[-1]):
                    wanted.append(meals)
        if eaten:
            self.swallow(eaten)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Claim items of each kind of food for one species."""
        for number, food in enumerate(table.species.foods):
            table.species.eaten[food.eats] = 0.0
            prey = world.tables[food.eats]
            if table.n and prey.n:
                self.want(table, prey, food, number, world)

    def want(self, table: Table, prey: Table, food: Diet, number: int, world: SpatialWorld) -> None:
        """Claim items of `prey` for all members of `table` that want to eat."""
        eaters, foods = world.index(table), world.index(prey)
        b, m, nerves = table[Body], table[Metabolism], table.species.nerves
        reach, chance, effect = self.meal(table, food, number, world.dt)
        if food.confusion is not None:
            chance = confused(world, table, food)
        furthest = np.float32(highest(reach, table.alive) if isinstance(reach, np.ndarray) else food.reach)
        target, distance2 = np.empty(eaters.n, np.int32), np.empty(eaters.n, np.float32)
        column = -1 if nerves is None else nerves.eats
        decision = NO_DECISION if nerves is None else table[Nervous].decision
        toughness, poison = defences(world, prey)
        wanting = Appetite(
            b.radius, reach, chance, effect[-1], decision, column, table.cause, m.energy, m.digesting
        )
        wanted = Foods(prey[Body].radius, toughness, prey.cause, world.dt)
        draws = world.key, random.FEED + (number << 8)
        if Shape in table or Shape in prey:
            self._shaped = True
            target, distance2 = nearest_surface(world, table, prey, np.nextafter(furthest, np.float32(1e30)))
            wanting, wanted = wanting._replace(radius=NO_RADIUS), wanted._replace(radius=NO_RADIUS)
            wish = eaters.entries, foods.entries, wanting, wanted, *draws
            world.split(propose, eaters.n, Found(target, distance2), *wish)
        else:
            beyond = widest(furthest, b.radius, table.alive, prey[Body].radius, prey.alive)
            wish = eaters.entries, foods.entries, wanting, wanted, *draws
            with world.bands.over(eaters, target, distance2):
                nearest(eaters, foods, beyond, target, distance2, world.split)
                world.split(propose, eaters.n, Found(target, distance2), *wish)
        held = prey[Metabolism].energy if Metabolism in prey else NOTHING
        self._wanted.append(
            Meals(
                table,
                prey,
                food,
                eaters,
                foods,
                target,
                distance2,
                effect,
                poison,
                held.copy() if prey.species.diet else held,
                np.empty(foods.n, np.int32),
            )
        )

    def eat(self, meals: Meals) -> None:
        """Feed eaters the items they have won, and record their gain [energy]."""
        world, table, prey, food = self.world, meals.table, meals.prey, meals.food
        eaters, foods, m = meals.eaters, meals.foods, table[Metabolism]
        own = before = NOBODY
        if world.bands.divided:  # the gains of ghosts are counted in their own process
            own = eaters.rows[world.bands.entries(eaters)]
            before = m.energy[own].astype(np.float64)
        gained: float = ingest(
            meals.best,
            eaters.entries,
            foods.entries,
            meals.effect,
            Eaters(table.cause, table.killer, m.energy, m.digesting, m.taken),
            Eaten(prey.cause, prey.killer, prey.uid, meals.held, meals.poison),
            world.codes[f"eaten by {table.name}"],
            world.codes[f"poisoned by {food.eats}"] if food.deadly else 0,
            LEAST_ENERGY[table.species.metabolism.torpor],
        )
        table.species.eaten[food.eats] += (
            float((m.energy[own] - before).sum()) if world.bands.divided else gained
        )

    def swallow(self, eaten: list[Meals]) -> None:
        """Move the substances of eaten organisms into their eaters, in order of distance if an animal both
        eats and is eaten."""
        for meals, eater, item in in_order(self.world.key, eaten):
            table, food = meals.table, meals.food
            share = own_value(
                table,
                f"diet.{food.eats}.assimilation",
                1.0 if food.assimilation is None else food.assimilation,
            )
            swallow(self.world, table, meals.eaters.rows[eater], meals.prey, meals.foods.rows[item], share)

    def meal(self, table: Table, food: Diet, number: int, dt: float) -> tuple[Any, Any, Effect]:
        """Return the result of `meal`, recomputed only if its inputs have changed or differ between
        individuals."""
        way = table.species.metabolism
        if table.species.traits or table.species.growth is not None:
            return meal(table, food, dt)
        given = food, way, dt  # sections of a world file are replaced, never changed
        known = self._meals.get((table.name, number))
        if known is None or known[0] != given:
            known = self._meals[table.name, number] = given, meal(table, food, dt)
        return known[1]


def meal(table: Table, food: Diet, dt: float) -> tuple[Any, Any, Effect]:
    """Return the reach and the probability of success per second for one kind of food, followed by
    `Meals.effect`: numbers, or arrays [high] if a gene codes for any of them."""
    metabolism, kind = table.species.metabolism, f"diet.{food.eats}."
    keys: dict[str, Any] = {
        kind + field: np.float32(getattr(food, field)) for field in ("reach", "gain", "efficiency", "chance")
    }
    keys |= {
        "metabolism.energy_max": np.float32(metabolism.energy_max),
        "metabolism.handling_time": metabolism.handling_time,
    }
    if food.satiation is not None:
        keys[kind + "satiation"] = np.float32(food.satiation)
    reach, gain, efficiency, chance, store, digestion, *until = own_values(table, keys)
    store = of_size(table, store)
    digestion = np.asarray(ticks(np.minimum(digestion, LONGEST * dt), dt)).astype(np.int32)[()]
    return reach, chance, Effect(gain, efficiency, store, digestion, until[0] if until else store)


def confused(world: SpatialWorld, table: Table, food: Diet) -> np.ndarray:
    """Return each row's probability of success per second, which falls with the number of items in view:
    f32[high] (Olson et al. 2013)."""
    aims = [sensor.name for sensor in table.species.sensors].index(food.confusion)
    rows, seen = number_in_view(world, table, aims)
    seen = seen * of_row(own_value(table, f"sensors.{food.confusion}.present", 1.0), rows)
    chance = np.zeros(table.high, np.float32)
    own = own_value(table, f"diet.{food.eats}.chance", food.chance)
    chance[rows] = np.where(seen, of_row(own, rows) / np.maximum(seen, 1), 0)
    return chance


def defences(world: SpatialWorld, prey: Table) -> tuple[np.ndarray, np.ndarray]:
    """Return each row's share of bites that fail and its poison, or arrays of length 1 if all rows are equal;
    empty if undefended."""
    toughness, poison = of_body(prey)
    if world.terrain is not None:
        toughness = sheltered(world.terrain, prey, toughness)
    return toughness, poison


def of_body(prey: Table) -> tuple[np.ndarray, np.ndarray]:
    """Return each row's toughness and poison, f32[capacity], or arrays of length 1 if all rows are equal;
    empty if undefended."""
    defence = prey.species.defence
    if Defence in prey:
        return prey[Defence].toughness, prey[Defence].poison
    if defence.toughness == 0 and defence.poison == 0:
        return UNDEFENDED, UNDEFENDED
    return np.full(1, defence.toughness, np.float32), np.full(1, defence.poison, np.float32)


def sheltered(terrain: Terrain, prey: Table, toughness: np.ndarray) -> np.ndarray:
    """Return the share of bites that fail, f32[high], including the effect of shelter that the land gives
    mobile prey."""
    high = prey.high
    if terrain.land is None or terrain.land.shelter is None or Velocity not in prey:
        return toughness
    p = prey[Position]
    left = np.float32(1) - at_places(terrain.land.shelter, terrain, p.x[:high], p.y[:high])
    if toughness.size:
        left *= np.float32(1) - (toughness if toughness.size == 1 else toughness[:high])
    return np.float32(1) - left


@lone_njit
def propose(
    first: int,
    last: int,
    found: Found,
    mine: Entries,
    targets: Entries,
    eaters: Appetite,
    foods: Foods,
    key: np.uint64,
    purpose: int,
) -> None:
    """Reject food that eaters first … last − 1 cannot eat by setting its entry to −1."""
    rows, uid, food_rows, (target, distance2) = mine.rows, mine.uid, targets.rows, found
    radius, reach, chance, until, decision, column, eater_cause, energy, digesting = eaters
    food_radius, toughness, food_cause, dt = foods
    for k in range(last - first):
        i = np.uint64(first + k)
        j, row = target[i], rows[i]
        if j < 0:
            continue
        if (
            eater_cause[row]
            or food_cause[food_rows[j]]
            or digesting[row] > 0
            or energy[row] >= of_row(until, row)
            or (column >= 0 and not decision[row, column])
        ):
            target[i] = -1
            continue
        s = of_row(radius, row) + of_row(food_radius, food_rows[j]) + of_row(reach, row)
        succeeds = of_row(chance, row)
        if toughness.size:
            succeeds *= np.float32(1) - toughness[food_rows[j] % toughness.size]
        if dt != 1:
            succeeds = np.float32(1 - (1 - np.float64(succeeds)) ** dt)
        if distance2[i] > s * s or draw(key, uid[i], purpose) >= succeeds:
            target[i] = -1


@lone_njit
def widest(reach, radius, alive, other, alive_other):
    """Return the smallest number [m] above the sum of `reach` and the largest living radius in each of two
    tables; at least 1e-6."""
    both = np.empty(2, np.float32)
    bits = both.view(np.int32)
    bits[0], bits[1] = top(radius.view(np.int32), alive), top(other.view(np.int32), alive_other)
    both[0] = reach + (both[0] + both[1])
    bits[0] += 1
    return max(np.float64(both[0]), 1e-6)


@njit
def top(bits, alive):
    """Return the highest value among living rows. Radii are not negative, so their bit patterns sort in the
    same order, and comparing bits vectorizes."""
    most = np.int32(0)
    for k in range(bits.size):
        row = np.uint64(k)
        most = max(most, bits[row] if alive[row] else np.int32(0))
    return most


@njit
def ingest(
    best: np.ndarray,
    mine: Entries,
    targets: Entries,
    effect: Effect,
    eaters: Eaters,
    foods: Eaten,
    cause: int,
    deadly: int,
    least: float,
) -> float:
    """Feed eaters the items they have won, `best` i32[foods] (−1: none); return the total gain."""
    rows, uid, food_rows = mine.rows, mine.uid, targets.rows
    gain, efficiency, ceiling, digestion, _ = effect
    eater_cause, eater_killer, energy, digesting, taken = eaters
    food_cause, food_killer, food_uids, held, poison = foods
    gained, n, eaten = 0.0, 0, np.empty(best.size, np.int32)
    for j in range(best.size):  # branch-free, so that the memory accesses of meals overlap
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
        after = min(before + worth, max(before, of_row(ceiling, row)))  # harmful food has a negative gain
        energy[row] = max(after, min(before, least))
        taken[row] += energy[row] - before
        gained += np.float64(energy[row]) - np.float64(before)
        digesting[row] = LONGEST if deadly else of_row(digestion, row)  # the poisoned eat no more
        food_cause[food] = cause
        food_killer[food] = uid[eater]
        if deadly and not eater_cause[row]:  # otherwise the eater itself was eaten
            eater_cause[row] = deadly
            eater_killer[row] = food_uids[food]
    return gained
