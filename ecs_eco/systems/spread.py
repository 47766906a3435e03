"""Plants spread over free sites."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.elementary import scalars
from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.components import Growth, Metabolism, Position
from ecs_eco.engine import random
from ecs_eco.engine.random import draw
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value
from ecs_eco.life import sizes
from ecs_eco.life.births import room
from ecs_eco.life.defence import left_by_defence
from ecs_eco.life.provision import Seedlings, root
from ecs_eco.space.bodies import ground_of
from ecs_eco.space.geometry import BLOCK, Extent, cell_of, cells_at
from ecs_eco.space.terrain import ROCK, WATER, Ground, ground_at

if TYPE_CHECKING:
    from ecs_eco.compiled.per_row import Number
    from ecs_eco.config.models.reproduction import Spread as Way
    from ecs_eco.engine.table import Table
    from ecs_eco.space.geometry import Space
    from ecs_eco.space.world import SpatialWorld

EVEN = np.zeros(0, np.float32)
SITES = 256  # sites examined together
EVERYWHERE = np.ones((1, 1), np.float32)
SPROUT = np.int64, np.int64, np.uint64, np.float32, np.float32  # types of the lists of `sprout`
AS_IT_STANDS = np.zeros(0, np.uint64)  # empty, because sites hold uids


class Seeds(NamedTuple):
    """Seed rates per tick, for kernels."""

    everywhere: np.float32  # seeds of other plants per site
    rain: np.float32  # seed rain per site
    reach: int  # range around the plant, in sites; 0: anywhere
    vigour: np.ndarray  # f32[rows], share that sprouts; empty: all
    key: np.uint64
    salt: int  # for the random draws
    uid: np.ndarray  # u64[rows]; empty if sites hold uids


class Sprouts(NamedTuple):
    """Output of `sprout`: site, parent's row and uid, and position of each seed that sprouts."""

    site: np.ndarray  # i64
    parent: np.ndarray  # i64, −1: seed rain
    parents: np.ndarray  # u64, 0: seed rain
    x: np.ndarray  # f32 [m]
    y: np.ndarray
    found: np.ndarray  # i64[blocks], number per block


class Spread(System):
    """Seeds take free sites. The ground is divided into square sites of side `spacing` with at most one plant
    each, so growth is logistic.

    In each tick, a free site draws a site at random, anywhere or within `dispersal`, with probability
    rate·dt, and receives a seed if a plant grows there; with probability seed_rain·dt, a seed falls on it
    from the seed rain. If seeds fall anywhere on uniform ground and newborns bear seeds like other plants, dt
    is replaced by the time that makes the share of taken sites follow exactly the logistic curve for the
    plants' mean rate. The share of a plant's seeds that sprout depends on its genes and is smaller the more
    it spends on defense. A site is closed if rock or water covers its center; if they cover a plant's
    position within an open site, the plant grows at the center instead. Land-cover classes multiply both
    rates. Seeds need neither light nor substances to sprout, unless plants are born with substances from the
    soil: then a seed sprouts only if the soil holds enough. If substances are scarce, the seeds of all
    species sprout in random order; if `max_count` is reached, random draws decide which seeds sprout.
    """

    needs = (Position, Metabolism)
    world: SpatialWorld
    phase = "reproduce"
    divisible = True
    submodel = Submodel(
        "Spread of plants",
        where=("reproduction.kind=spread",),
        reads=("reproduction",),
        rules={
            "": "The ground has sites of side `spacing`, with at most one plant each, also at the start.",
            "reproduction.place=anywhere": "A free site is taken in a tick with probability `(rate p + seed_rain) "
            "dt`, where p is the share of all sites that are taken. On even ground, dt is corrected so that on "
            "average `dp/dt = (rate p + seed_rain)(1 − p)`, a logistic curve, is solved exactly.",
            "reproduction.place=near": "A free site is taken in a tick with probability `(rate p + seed_rain) "
            "dt`, where p is the share of taken sites among those at most `dispersal` away along each axis.",
            "Growth": "A seed of a plant sprouts with probability `spread`, a value of the plant's genes, so rate "
            "is replaced by `rate × spread`; dt is not corrected.",
            "terrain.lakes": "No plant grows on a site whose center is in a lake.",
            "terrain.rocks": "No plant grows on a site whose center is in a rock.",
            "born_with=soil": "A seed sprouts only where the soil holds the substances that the plant is "
            "made of; the seeds of all species take them in random order.",
        },
        draws="which free sites are taken, and the place of a plant within its site",
    )

    @cached_property
    def _grounds(self) -> dict[str, tuple[Any, ...]]:
        """By table: size of the space and mode of spreading, and the sites derived from them."""
        return {}

    def process(self, *_: object) -> None:
        """Spread all species; seeds that need substances from the soil compete for them across species."""
        self._seedlings: list[Seedlings] = []
        super().process()
        if self._seedlings:
            root(self.world, self._seedlings)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Spread one species of plants."""
        way = table.species.reproduction
        if way is None or way.kind != "spread":
            return
        taken, inverse, reach, room_for = self.ground(table, world.space, way)
        if world.bands.divided:
            taken = world.bands.sites(table, taken)
        else:
            p = table[Position]
            stands(table.alive[: table.high], p.x, p.y, inverse, taken)
        own: Any = np.float32(way.rate)
        if table.species.traits:
            own = own_value(table, "reproduction.rate", own)
        rate, vigour = seeds(table, own, way.rate)
        land = None if world.terrain is None else world.terrain.land
        fertile = EVERYWHERE if land is None or land.growth is None else land.growth
        time = world.dt
        if reach == 0 and Growth not in table and fertile is EVERYWHERE and rate + way.seed_rain > 0:
            n = world.bands.count(table) if world.bands.divided else table.n
            time = as_logistic(table, rate, way.seed_rain, vigour, min(n / taken.size, 1.0), time)
        how = Seeds(
            np.float32(rate * time),
            np.float32(way.seed_rain * time),
            reach,
            vigour,
            world.key,
            table.place << 20,
            AS_IT_STANDS if world.bands.divided else table.uid,
        )
        found, space, ground = room_for.found, world.space.extent, ground_of(world)
        work = taken.size // 3
        world.split(sprout, found.size, taken, how, fertile, inverse, ground, space, room_for, work=work)
        sprouts: Any = room_for
        n, parts = int(found[0]), found.nonzero()[0]
        if parts.size > 1 or (parts.size and parts[0] > 0):  # several threads have listed seeds
            sprouts = listed(room_for, found, parts)
            n = sprouts[0].size
        wanted, n = n, room(table, world, n)
        if n == 0:
            return
        lot = (
            slice(n)
            if n == wanted
            else np.sort(
                random.by_lot(
                    world.key, sprouts[0][:wanted].astype(np.uint64), random.LOT + (table.place << 20)
                )[:n]
            )
        )
        # copies, because the next tick overwrites the lists
        site, parent, parents, x, y = (
            sprouts[0][lot].copy(),
            sprouts[1][lot].copy(),
            sprouts[2][lot].copy(),
            sprouts[3][lot].copy(),
            sprouts[4][lot].copy(),
        )
        nx, z = taken.shape[1], np.zeros(n, np.float32)
        if world.terrain is not None:
            x, y = world.terrain.within_sites(
                x,
                y,
                *(
                    ((cells + 0.5) / inverse[axis]).astype(np.float32)
                    for axis, cells in enumerate((site % nx, site // nx))
                ),
            )
        values: dict[tuple[type, str], Any] = {(Position, "x"): x, (Position, "y"): y, (Position, "z"): z}
        if table.species.heredity is not None:
            values |= genomes(table, world, parent, site.astype(np.uint64))
        if table.species.standard_mass is not None:
            values |= sizes.of_newborn(table, values, n)
        if table.species.born_with == "soil":
            self._seedlings.append((table, parents, values, site.astype(np.uint64)))
        else:
            table.request(parents, values)

    def ground(self, table: Table, space: Space, way: Way) -> tuple[Any, ...]:
        """Return the sites, their scales [1/m], the range of a seed in sites (0: anywhere), and the lists of
        `sprout`."""
        given = space.size, way.spacing, way.dispersal, way.place
        known = self._grounds.get(table.name)
        if known is None or known[0] != given or known[1] is not table.species.sites:
            nx, ny = (max(1, round(length / way.spacing)) for length in space.size[:2])
            inverse = np.array([nx / space.size[0], ny / space.size[1]], np.float32)
            reach = max(1, round((way.dispersal or way.spacing) / way.spacing))
            taken = table.species.sites = np.empty((ny, nx), np.int64)
            room_for = [np.empty(taken.size, kind) for kind in SPROUT]
            known = self._grounds[table.name] = (
                given,
                taken,
                inverse,
                0 if way.place == "anywhere" else reach,
                Sprouts._make((*room_for, np.empty(-(-taken.size // SITES), np.int64))),
            )
        return known[1:]


def genomes(
    table: Table, world: SpatialWorld, parent: np.ndarray, identity: np.ndarray
) -> dict[tuple[type, str], np.ndarray]:
    """Return the values that newborns inherit from parents in rows i64[n] (−1: seed rain)."""
    own, grown, values = parent < 0, np.flatnonzero(parent >= 0), {}
    fresh = table.species.heredity.founders(world, table, identity[own])
    inherited = table.species.heredity.offspring(world, table, parent[grown], None, identity[grown])
    for name, some in fresh.items():
        values[name] = np.empty((parent.size, *some.shape[1:]), some.dtype)
        values[name][own], values[name][grown] = some, inherited[name]
    return values


def listed(columns: Sprouts, found: np.ndarray, parts: np.ndarray) -> list[np.ndarray]:
    """Return the lists of `sprout`, joined over all parts that contain sprouting seeds."""
    return [
        np.concatenate([column[b * SITES : b * SITES + found[b]] for b in parts]) for column in columns[:-1]
    ]


def seeds(table: Table, own: Number, rate: float) -> tuple[float, np.ndarray]:
    """Return the highest rate [1/s] at which any plant takes free sites, and each plant's share of it
    f32[high]; empty if all are equal."""
    left = left_by_defence(table, table.high)
    if Growth not in table and not (isinstance(left, np.ndarray) or isinstance(own, np.ndarray)):
        return rate * float(left), EVEN
    each = np.asarray(own * (table[Growth].spread[: table.high] if Growth in table else np.float32(1)) * left)
    highest = float(each[table.alive[: table.high]].max(initial=0.0))
    return highest, np.broadcast_to(each / np.float32(highest or 1.0), table.high).astype(np.float32)


def as_logistic(table: Table, rate: float, rain: float, vigour: np.ndarray, p: float, time: float) -> float:
    """Return how long seeds must fall at the current rate to take as many free sites as the exact solution of
    dp/dt = (mean p + rain)(1 − p) does in `time` [s]; at most until there is a seed on every site."""
    mean = rate if vigour is EVEN or table.n == 0 else rate * share(table, vigour)
    both, falls = mean + rain, mean * p + rain
    left = scalars.exp(-both * time)
    return min((1.0 - left) / (both * left + falls * (1.0 - left)), 1.0 / (rate + rain)) if both > 0 else time


def share(table: Table, vigour: np.ndarray) -> float:
    """Return the mean of `vigour` over living plants, bit-identical for any order of rows."""
    parts = (vigour[table.alive[: table.high]] * np.float32(1 << 24)).astype(np.int64)
    return int(parts.sum()) / ((1 << 24) * parts.size)


@lone_njit
def stands(alive, x, y, inverse, taken):
    """Write the row of the plant on each site to taken i64[ny, nx] (−1: none), the last row if several plants
    share a site."""
    ny, nx = taken.shape
    flat, cell = taken.reshape(-1), np.empty(BLOCK, np.int32)
    flat[:] = -1
    for first in range(0, alive.size, BLOCK):
        size = min(BLOCK, alive.size - first)
        cells_at(first, size, (x, y, y), (1, ny, nx), (inverse[0], inverse[1], np.float32(0.0)), cell)
        for k in range(size):
            if alive[first + k]:
                flat[np.uint32(cell[k])] = first + k


@njit
def sprout(
    first: int,
    last: int,
    taken: np.ndarray,
    seeds: Seeds,
    fertile: np.ndarray,
    inverse: np.ndarray,
    ground: Ground,
    space: Extent,
    sprouts: Sprouts,
) -> None:
    """List the free sites on which a seed sprouts, in blocks first … last − 1 of SITES sites each, with the
    row and uid of its parent (−1 and 0: seed rain) and its position. The lists begin at the first site's
    index; their length is in `found` at the first block. `fertile` f32[ny, nx] multiplies both rates; a map
    of one cell means 1 everywhere."""
    everywhere, rain_everywhere, reach, vigour, key, salt, uid = seeds
    (site, parent, parents, xs, ys, found), lengths = sprouts, space.lengths
    (ny, nx), flat, luck, n = taken.shape, taken.reshape(-1), np.empty(SITES, np.float32), first * SITES
    rate, rain, near = everywhere, rain_everywhere, np.empty(SITES, np.int64)
    most = rate + rain if fertile.size <= 1 else np.float32(np.inf)
    for block in range(first, last):
        begin, found[block] = block * SITES, 0
        size = min(SITES, flat.size - begin)
        for k in range(lucky(begin, size, flat, key, random.SPREAD + salt, most, luck, near)):
            s, u = begin + near[k], luck[k]
            j, i = s // nx, s % nx
            if fertile.size > 1:
                y, x = np.float32((j + 0.5) / inverse[1]), np.float32((i + 0.5) / inverse[0])
                factor = fertile[
                    cell_of(y * ground.inverse[1], fertile.shape[0]),
                    cell_of(x * ground.inverse[0], fertile.shape[1]),
                ]
                rate, rain = everywhere * factor, rain_everywhere * factor
            if u >= rate + rain:
                continue
            if ground.kind.size > 1:
                x, y = np.float32((i + 0.5) / inverse[0]), np.float32((j + 0.5) / inverse[1])
                kind = ground_at(ground, x, y)
                if kind in (WATER, ROCK):
                    continue
            row = np.int64(-1)
            if u < rate:
                a, b = (
                    draw(key, s, random.SPREAD + salt + (1 << 8)),
                    draw(key, s, random.SPREAD + salt + (2 << 8)),
                )
                if reach == 0:
                    row = taken[min(int(a * ny), ny - 1), min(int(b * nx), nx - 1)]
                else:
                    jj, ii = j + int(a * (2 * reach + 1)) - reach, i + int(b * (2 * reach + 1)) - reach
                    if space.torus:
                        row = taken[jj % ny, ii % nx]
                    elif 0 <= jj < ny and 0 <= ii < nx:
                        row = taken[jj, ii]
                if row < 0 or (vigour.size and draw(key, s, random.SPREAD + salt + (5 << 8)) >= vigour[row]):
                    continue
            site[n], parent[n] = s, row
            parents[n] = 0 if row < 0 else (uid[row] if uid.size else np.uint64(row))
            xs[n] = on_site(i, draw(key, s, random.SPREAD + salt + (3 << 8)), inverse[0], lengths[0])
            ys[n] = on_site(j, draw(key, s, random.SPREAD + salt + (4 << 8)), inverse[1], lengths[1])
            n += 1
    if last > first:
        found[first] = n - first * SITES


@njit
def lucky(begin, size, flat, key, purpose, most, luck, near):
    """Among `size` sites (at most SITES) starting at `begin`, list the free sites that draw a number below
    `most`, each as its offset from `begin` and its number. Return how many there are. Branch-free, because the
    branches would be unpredictable."""
    free = few = 0
    for k in range(size):
        near[np.uint64(free)] = k
        free += flat[np.uint64(begin + k)] < 0
    for k in range(free):
        luck[k] = draw(key, begin + near[k], purpose)
    for k in range(free):
        site, u = near[k], luck[k]
        near[np.uint64(few)], luck[np.uint64(few)] = site, u
        few += u < most
    return few


@njit
def on_site(i, u, inverse, length):
    """Return the coordinate [m] at which a seed sprouts within column or row i of the sites, given a number u
    in [0, 1)."""
    return min(
        (np.float64(i) + np.float64(u)) / np.float64(inverse),
        np.float64(np.nextafter(length, np.float32(0.0))),
    )
