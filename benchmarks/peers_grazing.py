"""The common task of `peers.py`: grazers that flee from each other, in a bare loop and in ecs-eco.

The space is a torus with one tuft per 3 m site. In each tick (1 s), every grazer finds the nearest other
grazer within REACH, turns away from it by TURN, walks SPEED, pays COST, eats the tuft that it touches and
gains GAIN up to a store of 1. With at least ENOUGH energy, it divides with probability CHANCE and gives its
young GIVEN; without any energy, it dies. A site without a tuft grows one with probability REGROWTH.
"""

import math
from collections.abc import Callable
from typing import Any

import numba as nb
import numpy as np

DENSITY = 0.045  # initial grazers per square meter: ten within REACH
REACH, TURN, SPEED, COST, GAIN = 8.4, 0.8, 0.5, 0.02, 0.4
ENOUGH, GIVEN, CHANCE, REGROWTH, SITE, BITE = 0.8, 0.4, 0.1, 0.02, 3.0, 0.7
Model = tuple[Callable[[], object], Callable[[], int]]  # run a tick; return the number of living agents


def side(n: int) -> float:
    """Return the world's side [m], a whole number of sites."""
    return SITE * round(math.sqrt(n / DENSITY) / SITE)


def bare(n: int, seed: int) -> Model:
    """Run the task as compiled loops over arrays, without identities, records or ledgers: the lower bound."""
    rng = np.random.default_rng(seed)
    size, room = side(n), 4 * n
    x, y, heading = (rng.uniform(0, top, room) for top in (size, size, 2 * math.pi))
    energy = np.full(room, 0.5)
    sites = int(size / SITE)
    ripe = np.ones((sites, sites), np.bool_)
    cells = int(size / REACH)
    state = np.array([n])

    def tick() -> None:
        state[0] = _tick(x, y, heading, energy, ripe, state[0], size, cells, rng)

    return tick, lambda: int(state[0])


@nb.njit(cache=True, fastmath=True)
def _tick(x, y, heading, energy, ripe, n, size, cells, rng):
    _flee(x, y, heading, n, size, cells)
    born = _live(x, y, heading, energy, ripe, n, size, rng)
    alive = 0
    for i in range(born):
        if energy[i] > 0:
            x[alive], y[alive], heading[alive], energy[alive] = x[i], y[i], heading[i], energy[i]
            alive += 1
    for i in range(ripe.shape[0]):
        for j in range(ripe.shape[1]):
            if not ripe[i, j] and rng.random() < REGROWTH:
                ripe[i, j] = True
    return alive


@nb.njit(cache=True, fastmath=True)
def _flee(x, y, heading, n, size, cells):
    start, order, cell = _sorted(x, y, n, size / cells, cells)
    turn = np.zeros(n)
    for i in range(n):
        cx, cy, best, left = cell[i] % cells, cell[i] // cells, REACH * REACH, 0.0
        for dj in range(-1, 2):
            for di in range(-1, 2):
                c = (cy + dj) % cells * cells + (cx + di) % cells
                for k in range(start[c], start[c + 1]):
                    j = order[k]
                    dx, dy = x[j] - x[i], y[j] - y[i]
                    dx -= size * round(dx / size)
                    dy -= size * round(dy / size)
                    d = dx * dx + dy * dy
                    if j != i and d < best:
                        best, left = d, math.cos(heading[i]) * dy - math.sin(heading[i]) * dx
        if best < REACH * REACH:
            turn[i] = -TURN if left > 0 else TURN
    for i in range(n):
        heading[i] += turn[i]


@nb.njit(cache=True)
def _sorted(x, y, n, width, cells):
    start = np.zeros(cells * cells + 1, np.int64)
    cell = np.empty(n, np.int64)
    for i in range(n):
        cell[i] = min(int(y[i] / width), cells - 1) * cells + min(int(x[i] / width), cells - 1)
        start[cell[i] + 1] += 1
    start = np.cumsum(start)
    order, place = np.empty(n, np.int64), start[:-1].copy()
    for i in range(n):
        order[place[cell[i]]] = i
        place[cell[i]] += 1
    return start, order, cell


@nb.njit(cache=True, fastmath=True)
def _live(x, y, heading, energy, ripe, n, size, rng):
    sites, born = ripe.shape[0], n
    for i in range(n):
        x[i] = (x[i] + SPEED * math.cos(heading[i])) % size
        y[i] = (y[i] + SPEED * math.sin(heading[i])) % size
        energy[i] -= COST
        sx, sy = min(int(x[i] / SITE), sites - 1), min(int(y[i] / SITE), sites - 1)
        dx, dy = x[i] - (sx + 0.5) * SITE, y[i] - (sy + 0.5) * SITE
        if ripe[sy, sx] and dx * dx + dy * dy < BITE * BITE:
            ripe[sy, sx] = False
            energy[i] = min(1.0, energy[i] + GAIN)
        if energy[i] >= ENOUGH and rng.random() < CHANCE and born < len(x):
            energy[i] -= GIVEN
            x[born], y[born], energy[born] = x[i], y[i], GIVEN
            heading[born] = rng.random() * 2 * math.pi
            born += 1
    return born


def ecs_eco(n: int, seed: int) -> Model:
    """Run the task as a world file, with energy ledgers, causes of death, identities and parents."""
    from ecs_eco import World

    world = World.from_config(config(n), seed=seed)
    return lambda: world.run(1), lambda: int(world.tables["grazer"].n)


def config(n: int) -> dict[str, Any]:
    """Return the world."""
    size = side(n)
    return {
        "format": 1,
        "name": "grazing",
        "dt": 1.0,
        "space": {"size": [size, size], "edges": "torus"},
        "species": {
            "tuft": {
                "count": int(size / SITE) ** 2,
                "body": {"radius": 0.3, "opaque": False},
                "reproduction": {"kind": "spread", "rate": 0.0, "seed_rain": REGROWTH, "spacing": SITE},
            },
            "grazer": {
                "count": n,
                "body": {"radius": 0.2, "opaque": False},
                "metabolism": {"energy": 0.5, "energy_max": 1.0, "basal": COST},
                "locomotion": {"speed": {"walk": SPEED}, "turn": TURN},
                "diet": [{"eats": "tuft", "reach": BITE - 0.5, "gain": GAIN}],
                "sensors": [{"kind": "nearest", "target": "grazer", "range": REACH}],
                "actions": {"speed": ["walk"], "turn": ["left", "none", "right"], "eat": ["eat"]},
                "always_on": ["eat"],
                "default_action": {"speed": "walk", "turn": "none"},
                "reflex": {"formulas": {"walk": "1", "left": "-grazer_left", "right": "grazer_left"}},
                "reproduction": {
                    "kind": "asexual",
                    "rate": CHANCE,
                    "energy_min": ENOUGH,
                    "energy_given": GIVEN,
                    "dispersal": 0.1,
                },
                "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
            },
        },
    }
