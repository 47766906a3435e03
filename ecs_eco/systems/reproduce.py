"""Animals give birth (the paper's simplified reproduction, and division)."""

from typing import Any

import numpy as np

from ecs_eco import random
from ecs_eco._numba import njit
from ecs_eco.components import Biology, Body, Metabolism, Position
from ecs_eco.nervous.senses import rocks
from ecs_eco.random import draw
from ecs_eco.space.geometry import into
from ecs_eco.space.sight import gather, offset
from ecs_eco.space.terrain import OPEN, ground_at
from ecs_eco.system import System

TRIES = 8  # places looked at before a birth is given up for want of room


class Reproduce(System):
    """A fed and grown parent gives birth with a probability per second, and pays the newborn's energy.

    The newborn appears at a random place that no body occupies (`anywhere`, or within `dispersal` of the parent);
    where another of its kind lives within `spacing`, the birth fails and costs nothing.
    """

    needs = (Position, Body, Metabolism, Biology)
    phase = "reproduce"

    def update(self, table: Any, world: Any) -> None:
        """Let one species reproduce."""
        way = table.traits.get("reproduction")
        if way is None or way.kind == "spread" or not world.reproduction:
            return
        m, b = table[Metabolism], table[Biology]
        high = table.high
        parents = np.empty(table.n, np.int64)
        n = _ready(table.alive[:high], m.energy, b.age, b.fertility, table.uid, np.float32(way.energy_min), np.float32(way.age_min),
                   np.float32(1 - np.exp(-way.rate * world.dt)), world.key, parents)
        room = table.n if table.traits["max_count"] is None else table.traits["max_count"] - table.n
        if n == 0 or room <= 0:
            return
        parents = parents[:n]
        parents = parents[np.argsort(table.uid[parents])][:room]
        places = self.places(table, world, parents, way)
        born = places[:, 3] > 0
        parents, places = parents[born], places[born]
        if not parents.size:
            return
        given = np.full(parents.size, way.energy_given, np.float32)
        before = m.energy[parents].copy()
        m.energy[parents] = before - given
        m.given[parents] += before - m.energy[parents]
        table.request(table.uid[parents], newborn(table, world, places[:, :3], table.uid[parents], given))

    def places(self, table: Any, world: Any, parents: np.ndarray, way: Any) -> np.ndarray:
        """Return (x, y, z, whether there is room) for each parent's newborn: f32[n, 4]."""
        space, p, own = world.space, table[Position], world.index(table)
        out = np.zeros((parents.size, 4), np.float32)
        radius = float(table.defaults[Body]["radius"])
        ground, inverse = rocks(world)
        near = np.float32(-1.0 if way.place == "anywhere" else way.dispersal or 1.0)
        _place(table.uid[parents], p.x[parents], p.y[parents], p.z[parents], near, np.float32(way.spacing), own.x, own.y, own.z, own.start,
               space.reach(max(way.spacing, 1e-3)), *space.shape, space.inverse, space.lengths, space.torus, space.volume, ground, inverse,
               world.key, 0, out)
        for attempt in range(1, TRIES + 1):
            taken = np.zeros(parents.size, np.bool_)
            for other in world.tables.values():
                if other.n and other.traits.get("opaque", False) and Body in other:
                    index = world.index(other)
                    s = np.float32(radius + other.traits["radius"])
                    _occupied(out, index.x, index.y, index.z, index.start, s, space.reach(float(s)), *space.shape, space.inverse,
                              space.lengths, space.torus, taken)
            if not taken.any():
                break
            if attempt == TRIES:
                out[taken, 3] = 0
                break
            again = np.flatnonzero(taken)
            part = out[again]
            _place(table.uid[parents[again]], p.x[parents[again]], p.y[parents[again]], p.z[parents[again]], near, np.float32(way.spacing),
                   own.x, own.y, own.z, own.start, space.reach(max(way.spacing, 1e-3)), *space.shape, space.inverse, space.lengths,
                   space.torus, space.volume, ground, inverse, world.key, attempt, part)
            out[again] = part
        return out


def newborn(table: Any, world: Any, places: np.ndarray, parents: np.ndarray, energy: np.ndarray) -> dict[tuple[type, str], np.ndarray]:
    """Return the columns in which newborn differ from the table's defaults: place, heading, sex, energy."""
    turn = random.draw_many(world.key, parents, random.SEX + (1 << 8))
    values: dict[tuple[type, str], np.ndarray] = {(Position, "x"): places[:, 0], (Position, "y"): places[:, 1], (Position,
                                                   "z"): places[:, 2],
              (Position, "heading"): turn * np.float32(6.2831855), (Metabolism, "energy"): energy}
    if table.traits.get("sex") == "random":
        values[Biology, "sex"] = np.where(random.draw_many(world.key, parents, random.SEX) < 0.5, 1, 2).astype(np.uint8)
    return values


@njit
def _ready(alive, energy, age, fertility, uid, energy_min, age_min, chance, key, parents):
    n = 0
    for row in range(alive.size):
        if alive[row] and energy[row] >= energy_min and age[row] >= age_min:
            if draw(key, uid[row], random.BIRTH) < chance * fertility[row]:
                parents[n] = row
                n += 1
    return n


@njit
def _place(uid, px, py, pz, dispersal, spacing, ox, oy, oz, start, reach, nx, ny, nz, inverse, lengths, torus, volume, ground,
           ground_inverse, key, attempt, out):
    """Draw a place for each newborn; out[i, 3] is 1 where neither rock nor one of its kind within `spacing` forbids it."""
    near = np.empty(ox.size, np.int64)
    for i in range(uid.size):
        u, v, w = (draw(key, uid[i], random.PLACE + (attempt << 10)), draw(key, uid[i], random.PLACE + (1 << 8) + (attempt << 10)),
                   draw(key, uid[i], random.PLACE + (2 << 8) + (attempt << 10)))
        if dispersal < 0:
            x, y, z = u * lengths[0], v * lengths[1], w * lengths[2]
        else:
            r, a = dispersal * np.sqrt(u), np.float32(6.2831855) * v
            x, y = into(px[i] + r * np.cos(a), lengths[0], torus), into(py[i] + r * np.sin(a), lengths[1], torus)
            z = into(pz[i] + dispersal * (np.float32(2) * w - np.float32(1)), lengths[2], False) if volume else pz[i]
        free = ground.size == 1 or ground_at(ground, ground_inverse, x, y) == OPEN
        if free and spacing > 0:
            n = gather(x, y, z, reach, start, ox, oy, oz, nx, ny, nz, inverse, lengths, torus, near)
            for q in range(n):
                dx, dy, dz = offset(x, y, z, ox[near[q]], oy[near[q]], oz[near[q]], lengths, torus)
                if dx * dx + dy * dy + dz * dz < spacing * spacing:
                    free = False
                    break
            for j in range(i):  # and its siblings of this tick
                dx, dy, dz = offset(x, y, z, out[j, 0], out[j, 1], out[j, 2], lengths, torus)
                if out[j, 3] > 0 and dx * dx + dy * dy + dz * dz < spacing * spacing:
                    free = False
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = x, y, z, 1 if free else 0


@njit
def _occupied(places, ox, oy, oz, start, s, reach, nx, ny, nz, inverse, lengths, torus, taken):
    near = np.empty(ox.size, np.int64)
    for i in range(taken.size):
        if places[i, 3] == 0 or taken[i]:
            continue
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        n = gather(x, y, z, reach, start, ox, oy, oz, nx, ny, nz, inverse, lengths, torus, near)
        for q in range(n):
            dx, dy, dz = offset(x, y, z, ox[near[q]], oy[near[q]], oz[near[q]], lengths, torus)
            if dx * dx + dy * dy + dz * dz < s * s:
                taken[i] = True
                break
