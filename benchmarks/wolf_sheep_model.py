"""The rules of Mesa 3.5's WolfSheep (after Wilensky 1997), with components and systems of our own.

A tick: all sheep act in random order, then all wolves. An animal moves to one of four cells, pays 1, eats,
and starves below 0 or else may give birth, which halves its energy. Newborn act from the next tick on.
"""

import numpy as np

from ecs_eco import System, World, component, draw, f64, i32, njit

DEFAULT = {"sheep_reproduce": .04, "wolf_reproduce": .05, "sheep_gain": 4.0, "wolf_gain": 20., "regrowth": 30}
SHEEP_ORDER, SHEEP_MOVE, SHEEP_BIRTH, WOLF_ORDER, WOLF_MOVE, WOLF_PREY, WOLF_BIRTH = range(100, 107)


@component
class Animal:  # a sheep or a wolf
    cell: i32 = 0
    energy: f64 = 0.0  # [ticks it lasts]


@component
class Grass:  # of one cell
    ripe: i32 = 0  # the tick from which on it can be eaten


@njit
def shuffled(alive, key, purpose):
    """Return the living rows in random order (Fisher and Yates, inside out)."""
    order, n = np.empty(alive.size, np.int32), 0
    for row in range(alive.size):
        if alive[row]:
            k = int(draw(key, row, purpose) * (n + 1))
            order[n], order[k], n = order[k], row, n + 1
    return order[:n]


@njit
def best(around, rank, chance):
    """Return a random one of the highest-ranking cells around; `chance` is in [0, 1)."""
    top = max(rank[around[0]], rank[around[1]], rank[around[2]], rank[around[3]])
    n = 0
    for cell in around:
        n += rank[cell] == top
    k = int(chance * n)
    for cell in around:
        k -= rank[cell] == top
        if k < 0:
            break
    return cell


@njit
def take(after, head, chance):
    """Take a random member out of the chain after[head], after[after[head]], … and return it."""
    n, member = 0, after[head]
    while member >= 0:
        n, member = n + 1, after[member]
    for _ in range(int(chance * n)):
        head = after[head]
    member = after[head]
    after[head] = after[member]
    return member


@njit
def live(sheep, wolves, lamb, pup, ripe, tick, key, around, starved, eaten, p_lamb, p_pup, sheep_gain,
         wolf_gain, regrowth):
    """Let all act once, mark the rows that gave birth, and return the number of ripe cells."""
    n, n_ripe = lamb.size, (ripe <= tick).sum()
    after = np.full(2 * n + ripe.size, -1, np.int32)  # chains of sheep: row i as i, its lamb as n + i
    first = after[2 * n :]  # by cell: where its chain begins
    alive, cell, energy, cause = sheep
    w_alive, w_cell, w_energy, w_cause = wolves
    pack = shuffled(w_alive, key, WOLF_ORDER)
    rank = (1 + (ripe <= tick)).astype(np.int8)  # for sheep: 2 grass, 1 bare, 0 a wolf
    for row in pack:
        rank[w_cell[row]] = 0
    for row in shuffled(alive, key, SHEEP_ORDER):
        there = best(around[cell[row]], rank, draw(key, row, SHEEP_MOVE))
        here = cell[row] = there if rank[there] else cell[row]  # wolves all around: it stays
        energy[row] -= 1.0
        if ripe[here] <= tick:
            energy[row] += sheep_gain
            ripe[here], rank[here], n_ripe = tick + regrowth + 1, min(rank[here], 1), n_ripe - 1
        if energy[row] < 0.0:
            cause[row] = starved
            continue
        first[here], after[row] = row, first[here]
        if draw(key, row, SHEEP_BIRTH) < p_lamb:
            energy[row], lamb[row] = energy[row] / 2.0, True
            first[here], after[n + row] = n + row, row
    rank[:] = first >= 0  # for wolves: 1 a sheep
    for row in pack:
        here = w_cell[row] = best(around[w_cell[row]], rank, draw(key, row, WOLF_MOVE))
        w_energy[row] -= 1.0
        if first[here] >= 0:
            w_energy[row] += wolf_gain
            prey = take(after, 2 * n + here, draw(key, row, WOLF_PREY))
            rank[here] = first[here] >= 0
            if prey < n:
                cause[prey] = eaten
            else:
                lamb[prey - n] = False
        if w_energy[row] < 0.0:
            w_cause[row] = starved
        elif draw(key, row, WOLF_BIRTH) < p_pup:
            w_energy[row], pup[row] = w_energy[row] / 2.0, True
    return n_ripe


class Live(System):
    """All sheep act in random order, then all wolves."""

    def process(self):
        sheep, wolf, grass = self.world.tables.values()
        herd, pack = [(t.alive, t[Animal].cell, t[Animal].energy, t.cause) for t in (sheep, wolf)]
        lamb, pup = np.zeros(sheep.capacity, np.bool_), np.zeros(wolf.capacity, np.bool_)
        now = grass[Grass].ripe, self.world.tick + 1, self.world.key
        self.n_ripe = live(herd, pack, lamb, pup, *now, *self.rules)
        for table, born, (_, cell, energy, _) in ((sheep, lamb, herd), (wolf, pup, pack)):
            if (parents := born.nonzero()[0]).size:
                values = {(Animal, "cell"): cell[parents], (Animal, "energy"): energy[parents]}
                table.request(table.uid[parents], values)


class Collect(System):
    """Keeps the numbers of sheep, wolves and ripe cells after each tick."""

    phase = "record"

    def process(self):
        self.series.append((self.world.tables["sheep"].n, self.world.tables["wolf"].n, self.live.n_ripe))


def build(width, seed, parameters=DEFAULT):
    """Return a world of width² cells, 100 sheep and 50 wolves per 400 of them, and what counts them."""
    rng, n, p = np.random.default_rng(seed), width * width, parameters
    world, live, collect = World((width, width), seed=seed), Live(), Collect()
    for name, k, gain in (("sheep", n // 4, p["sheep_gain"]), ("wolf", n // 8, p["wolf_gain"])):
        values = {(Animal, "cell"): rng.integers(n, size=k), (Animal, "energy"): rng.random(k) * 2 * gain}
        world.add_table(name, Animal).request(np.zeros(k, np.uint64), values)
    countdown = rng.integers(p["regrowth"], size=n) * rng.integers(2, size=n)  # 0: ripe; 1: not yet at tick 1
    ripe = {(Grass, "ripe"): countdown + (countdown > 0)}
    world.add_table("grass", Grass).request(np.zeros(n, np.uint64), ripe)
    cells = np.arange(n, dtype=np.int32).reshape(width, width)  # of a torus
    around = np.stack([np.roll(cells, by, axis).ravel() for by in (1, -1) for axis in (0, 1)], axis=1)
    live.rules = (around, world.cause("starved"), world.cause("eaten by wolf"), *(p[k] for k in DEFAULT))
    collect.live, collect.series = live, [(n // 4, n // 8, int((countdown == 0).sum()))]
    world.add_system(live)
    return world, world.add_system(collect)
