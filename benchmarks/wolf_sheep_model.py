"""Mesa 3.5's WolfSheep rules (after Wilensky 1997), implemented with custom components and systems.

In a tick, all sheep act in random order, then all wolves. An animal moves to one of four cells, pays 1 unit
of energy and eats. It starves if its energy falls below 0; otherwise it may give birth, which halves its
energy. Newborns first act in the next tick.
"""

import numpy as np

from ecs_eco import System, World, component, draw, f64, i32, njit
from ecs_eco.engine.random import bits

DEFAULT = {
    "sheep_reproduce": 0.04,
    "wolf_reproduce": 0.05,
    "sheep_gain": 4.0,
    "wolf_gain": 20.0,
    "regrowth": 30,
}
SHEEP_ORDER, SHEEP_MOVE, SHEEP_BIRTH, WOLF_ORDER, WOLF_MOVE, WOLF_PREY, WOLF_BIRTH = range(100, 107)


@component
class Animal:  # a sheep or a wolf
    cell: i32 = 0
    energy: f64 = 0.0  # [ticks it lasts]


@component
class Grass:  # of one cell
    ripe: i32 = 0  # first tick in which it can be eaten


@njit
def shuffled(alive, key, purpose):
    """Return the living rows in random order (Fisher–Yates)."""
    order, n = np.empty(alive.size + 1, np.uint32), 0
    for row in range(alive.size):
        order[n], n = row, n + alive[row]
    for i in range(1, n):
        k = int(draw(key, i, purpose) * (i + 1))
        order[i], order[k] = order[k], order[i]
    return order[:n]


@njit
def best(cell, width, rank, bits):
    """Return the highest-ranked of the four neighboring cells and its rank; 16 random bits break ties."""
    cell, n, x, top = np.int64(cell), width * width, np.int64(np.uint32(cell) % np.uint32(width)), -1
    up, down, left, right = (
        cell - width,
        cell + width,
        cell - 1,
        cell + 1,
    )  # offset that wraps it back onto the torus
    there = up
    for near in (
        up if up >= 0 else up + n,
        down if down < n else down - n,
        left if x > 0 else left + width,
        right if x < width - 1 else right - width,
    ):
        score = np.int64(rank[np.uint64(near)]) << 16 | np.int64(bits & np.uint64(0xFFFF))
        there, top, bits = near if score > top else there, max(top, score), bits >> np.uint64(16)
    return np.uint64(there), top >> 16


@njit
def take(after, head, chance):
    """Remove a random member from the chain after[head], after[after[head]], … and return it."""
    n, member = 0, after[head]
    while member >= 0:
        n, member = n + 1, after[member]
    for _ in range(int(chance * n)):
        head = after[head]
    member = after[head]
    after[head] = after[member]
    return member


@njit
def live(
    alive,
    cell,
    energy,
    cause,
    lamb,
    w_alive,
    w_cell,
    w_energy,
    w_cause,
    pup,
    ripe,
    tick,
    key,
    width,
    starved,
    eaten,
    p_lamb,
    p_pup,
    sheep_gain,
    wolf_gain,
    regrowth,
):
    """Execute all actions once, mark the rows that gave birth, and return the number of ripe cells."""
    order, pack = shuffled(alive, key, SHEEP_ORDER), shuffled(w_alive, key, WOLF_ORDER)
    n, n_ripe, now, again = order.size, 0, np.int32(tick), np.int32(tick + regrowth + 1)
    after = np.full(2 * n + ripe.size, -1, np.int32)  # chains of sheep: order[i] is i, and its lamb is n + i
    first, rank = after[2 * n :], np.empty(ripe.size, np.uint8)  # by cell: the start of its chain, and
    for here in range(ripe.size):
        rank[here] = 2 + (ripe[here] <= now)  # for sheep: 2 if there is no wolf, plus 1 for grass
        n_ripe += ripe[here] <= now
    for row in pack:
        rank[w_cell[row]] &= 1
    for i in range(n):
        row = order[i]
        there, safe = best(cell[row], width, rank, bits(key, i, SHEEP_MOVE))
        here = np.uint64(there if safe > 1 else cell[row])  # surrounded by wolves, it stays
        grass = rank[here] & 1
        left = energy[row] - 1.0 + sheep_gain * grass
        lamb[row] = left >= 0.0 and draw(key, i, SHEEP_BIRTH) < p_lamb
        cell[row], energy[row] = here, left / 2.0 if lamb[row] else left
        rank[here], n_ripe = rank[here] - grass, n_ripe - grass
        if left < 0.0:
            cause[row] = starved
        else:
            after[i], after[n + i], first[here] = first[here], i, i + n * lamb[row]
    for here in range(ripe.size):
        grazed = (ripe[here] <= now) & (rank[here] & np.uint8(1) == np.uint8(0))
        ripe[here] = max(ripe[here], np.int32(again * np.int32(grazed)))
        rank[here] = first[here] >= 0  # for wolves: 1 a sheep
    for i in range(pack.size):
        row = pack[i]
        here, sheep = best(w_cell[row], width, rank, bits(key, i, WOLF_MOVE))
        left = w_energy[row] - 1.0 + wolf_gain * sheep
        pup[row] = left >= 0.0 and draw(key, i, WOLF_BIRTH) < p_pup
        w_cell[row], w_energy[row] = here, left / 2.0 if pup[row] else left
        if left < 0.0:
            w_cause[row] = starved
        if sheep:
            prey = take(after, 2 * n + here, draw(key, i, WOLF_PREY))
            rank[here] = first[here] >= 0
            if prey < n:
                cause[order[prey]] = eaten
            else:
                lamb[order[prey - n]] = False
    return n_ripe


class Live(System):
    """All sheep act in random order, then all wolves."""

    def process(self):
        sheep, wolf, grass = self.world.tables.values()
        herd, pack = [
            (t.alive, t[Animal].cell, t[Animal].energy, t.cause, np.zeros(t.capacity, np.bool_))
            for t in (sheep, wolf)
        ]
        now = grass[Grass].ripe, self.world.tick + 1, self.world.key
        self.n_ripe = live(*herd, *pack, *now, *self.rules)
        for table, (_, cell, energy, _, born) in ((sheep, herd), (wolf, pack)):
            if (parents := born.nonzero()[0]).size:
                values = {(Animal, "cell"): cell[parents], (Animal, "energy"): energy[parents]}
                table.request(table.uid[parents], values)


class Collect(System):
    """Records the numbers of sheep, wolves and ripe cells after each tick."""

    phase = "record"

    def process(self):
        self.series.append((self.world.tables["sheep"].n, self.world.tables["wolf"].n, self.live.n_ripe))


def build(width, seed, parameters=DEFAULT):
    """Return a world of width² cells, with 100 sheep and 50 wolves per 400 cells, and its collector of
    counts."""
    rng, n, p = np.random.default_rng(seed), width * width, parameters
    world, live, collect = World((width, width), seed=seed), Live(), Collect()
    for name, k, gain in (("sheep", n // 4, p["sheep_gain"]), ("wolf", n // 8, p["wolf_gain"])):
        values = {(Animal, "cell"): rng.integers(n, size=k), (Animal, "energy"): rng.random(k) * 2 * gain}
        world.add_table(name, Animal).request(np.zeros(k, np.uint64), values)
    countdown = rng.integers(p["regrowth"], size=n) * rng.integers(2, size=n)  # 0: ripe; 1: not yet at tick 1
    ripe = {(Grass, "ripe"): countdown + (countdown > 0)}
    world.add_table("grass", Grass).request(np.zeros(n, np.uint64), ripe)
    live.rules = (width, world.cause("starved"), world.cause("eaten by wolf"), *(p[k] for k in DEFAULT))
    collect.live, collect.series = live, [(n // 4, n // 8, int((countdown == 0).sum()))]
    world.add_system(live)
    return world, world.add_system(collect)
