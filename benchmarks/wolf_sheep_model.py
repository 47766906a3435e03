"""The rules of Mesa 3.5's WolfSheep (after Wilensky 1997), with components and systems of our own.

A tick: all sheep act in random order, then all wolves, each seeing what those before it did. An animal moves to one of
the four neighbouring cells, pays 1, eats, and starves below 0 or else gives birth with a fixed probability, sharing its
energy. Sheep avoid wolves and seek grass, wolves seek sheep. Newborn act from the next tick on; lambs may be eaten before.
"""

import numpy as np
from numba import njit

from ecs_eco import System, World, component, f64, i32
from ecs_eco.random import draw

DEFAULT = {"sheep_reproduce": 0.04, "wolf_reproduce": 0.05, "sheep_gain": 4.0, "wolf_gain": 20.0, "regrowth": 30}
SHEEP_ORDER, SHEEP_MOVE, SHEEP_BIRTH, WOLF_ORDER, WOLF_MOVE, WOLF_PREY, WOLF_BIRTH = range(100, 107)  # purposes of draws


@component
class Animal:
    """A sheep or a wolf."""

    cell: i32 = 0
    energy: f64 = 0.0  # [ticks it lasts]


@component
class Grass:
    """The grass of one cell."""

    ripe: i32 = 0  # the tick from which on it can be eaten


@njit(cache=True)
def shuffled(alive, key, purpose):
    """Return the living rows in random order (Fisher and Yates, inside out)."""
    order, n = np.empty(alive.size, np.int32), 0
    for row in range(alive.size):
        if alive[row]:
            k = int(draw(key, row, purpose) * (n + 1))
            order[n], order[k], n = order[k], row, n + 1
    return order[:n]


@njit(cache=True)
def best(around, rank, chance):
    """Return a random one of the highest-ranking cells around; `chance` is in [0, 1)."""
    top = max(max(rank[around[0]], rank[around[1]]), max(rank[around[2]], rank[around[3]]))
    n = 0
    for cell in around:
        n += rank[cell] == top
    k, found = int(chance * n), around[0]
    for cell in around:
        if rank[cell] == top:
            found = cell if k == 0 else found
            k -= 1
    return found


@njit(cache=True)
def take(after, head, chance):
    """Take a random member out of the chain after[head], after[after[head]], … and return it."""
    n, member = 0, after[head]
    while member >= 0:
        n, member = n + 1, after[member]
    before = head
    for _ in range(int(chance * n)):
        before = after[before]
    member = after[before]
    after[before] = after[member]
    return member


@njit(cache=True)
def live(sheep, wolves, ripe, lambs, pups, tick, key, around, starved, eaten,
         sheep_reproduce, wolf_reproduce, sheep_gain, wolf_gain, regrowth):  # fmt: skip
    """Let all act once, put the parents of lambs and pups into these; return their numbers and that of ripe cells."""
    n_rows, n_lambs, n_pups, n_ripe = lambs.size, 0, 0, 0
    after = np.full(2 * n_rows + ripe.size, -1, np.int32)  # chains of a cell's sheep, from n_rows on of its lambs
    first = after[2 * n_rows :]  # by cell: where its chain begins
    rank = np.empty(ripe.size, np.int8)  # for sheep: 2 grass, 1 bare, 0 a wolf; for wolves: 1 sheep
    for cell in range(ripe.size):
        n_ripe += ripe[cell] <= tick
        rank[cell] = 1 + (ripe[cell] <= tick)
    alive, cells, energy, cause = wolves
    for row in range(alive.size):
        if alive[row]:
            rank[cells[row]] = 0

    alive, cells, energy, cause = sheep
    for row in shuffled(alive, key, SHEEP_ORDER):
        there = best(around[cells[row]], rank, draw(key, row, SHEEP_MOVE))
        here = cells[row] = there if rank[there] else cells[row]  # wolves all around: it stays
        energy[row] -= 1.0
        if ripe[here] <= tick:
            energy[row] += sheep_gain
            ripe[here], rank[here], n_ripe = tick + regrowth + 1, min(rank[here], 1), n_ripe - 1
        if energy[row] < 0.0:
            cause[row] = starved
            continue
        first[here], after[row] = row, first[here]
        if draw(key, row, SHEEP_BIRTH) < sheep_reproduce:
            energy[row] /= 2.0
            first[here], after[n_rows + n_lambs], lambs[n_lambs] = n_rows + n_lambs, row, row
            n_lambs += 1

    for cell in range(ripe.size):
        rank[cell] = first[cell] >= 0
    alive, cells, energy, w_cause = wolves
    for row in shuffled(alive, key, WOLF_ORDER):
        here = cells[row] = best(around[cells[row]], rank, draw(key, row, WOLF_MOVE))
        energy[row] -= 1.0
        if rank[here]:
            energy[row] += wolf_gain
            prey = take(after, 2 * n_rows + here, draw(key, row, WOLF_PREY))
            rank[here] = first[here] >= 0
            if prey < n_rows:
                cause[prey] = eaten
            else:
                lambs[prey - n_rows] = -1  # it never joins the table
        if energy[row] < 0.0:
            w_cause[row] = starved
        elif draw(key, row, WOLF_BIRTH) < wolf_reproduce:
            energy[row] /= 2.0
            pups[n_pups], n_pups = row, n_pups + 1

    n_born = 0
    for row in lambs[:n_lambs]:
        if row >= 0:
            lambs[n_born], n_born = row, n_born + 1
    return n_born, n_pups, n_ripe


class Live(System):
    """All sheep act in random order, then all wolves."""

    def __init__(self, *arguments):
        self.arguments = arguments

    def process(self):
        world = self.world
        sheep, wolf, grass = world.tables.values()
        a, b = sheep[Animal], wolf[Animal]
        herd, pack = (sheep.alive, a.cell, a.energy, sheep.cause), (wolf.alive, b.cell, b.energy, wolf.cause)
        lambs, pups = np.empty(sheep.capacity, np.int64), np.empty(wolf.capacity, np.int64)
        n_lambs, n_pups, self.n_ripe = live(herd, pack, grass[Grass].ripe, lambs, pups, world.tick + 1, world.key, *self.arguments)
        for table, animal, parents in ((sheep, a, lambs[:n_lambs]), (wolf, b, pups[:n_pups])):
            if parents.size:
                table.request(table.uid[parents], {(Animal, "cell"): animal.cell[parents], (Animal, "energy"): animal.energy[parents]})


class Collect(System):
    """Keeps the numbers of sheep, wolves and ripe cells before the first tick and after each."""

    phase = "record"

    def __init__(self, live, ripe):
        self.live, self.series = live, [(live.world.tables["sheep"].n, live.world.tables["wolf"].n, int((ripe == 0).sum()))]

    def process(self):
        tables = self.world.tables
        self.series.append((tables["sheep"].n, tables["wolf"].n, self.live.n_ripe))


def build(width, seed, parameters=DEFAULT):
    """Return a world of width² cells with 100 sheep and 50 wolves per 400 cells, and the system that collects."""
    rng, n, p = np.random.default_rng(seed), width * width, parameters
    x, y = np.arange(n) % width, np.arange(n) // width * width
    around = np.stack([(x + 1) % width + y, (x - 1) % width + y, x + (y + width) % n, x + (y - width) % n], axis=1)
    world = World((width, width), seed=seed)
    for name, k, gain in (("sheep", n // 4, p["sheep_gain"]), ("wolf", n // 8, p["wolf_gain"])):
        values = {(Animal, "cell"): rng.integers(n, size=k), (Animal, "energy"): rng.random(k) * 2 * gain}
        world.add_table(name, Animal).request(np.zeros(k, np.uint64), values)
    countdown = rng.integers(p["regrowth"], size=n) * rng.integers(2, size=n)  # half of the cells are ripe, others may be
    ripe = np.where(countdown, countdown + 1, 0)
    world.add_table("grass", Grass).request(np.zeros(n, np.uint64), {(Grass, "ripe"): ripe})
    world.flush()
    causes = world.cause("starved"), world.cause("eaten by wolf")
    live = world.add_system(Live(around.astype(np.int32), *causes, *(p[k] for k in DEFAULT)))
    return world, world.add_system(Collect(live, ripe))
