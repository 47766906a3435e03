"""Senses: each fills its channels, some columns of the observation matrix f32[n, channels], for all seekers of a table."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Biology, Body, Chemistry, Metabolism, Physical, Position, Senses
from ecs_eco.engine.code import handed_over
from ecs_eco.engine.jit import njit
from ecs_eco.nervous import flow
from ecs_eco.space import sight
from ecs_eco.space.field import at as field_at
from ecs_eco.space.geometry import back_into, into
from ecs_eco.space.nearest import nearest

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World
    from ecs_eco.engine.table import Table


class Seekers:
    """Those of a table that sense now, in canonical order: rows i64[n], the index, cosine and sine of the headings f32[n]."""

    def __init__(self, world: "World", table: "Table") -> None:
        self.index = world.index(table)
        self.rows = self.index.rows.copy()
        self.heading = table[Position].heading[self.rows]
        self.cos, self.sin = np.cos(self.heading), np.sin(self.heading)
        self.radius = table[Body].radius[self.rows] if Body in table else np.zeros(self.rows.size, np.float32)
        self.n = self.rows.size


Sense = Callable[["World", "Table", Seekers, np.ndarray, int], None]
"""sense(world, table, seekers, observations f32[n, channels], first column): writes its channels for every seeker."""


def own_column(table: "Table", name: str, substances: list[str]) -> np.ndarray:
    """Return the column of a property or substance by name: f32[capacity]."""
    if name == "energy":
        return table[Metabolism].energy
    if name in ("age", "fertility"):
        return getattr(table[Biology], name)
    if name in substances:
        return table[Chemistry].molarity[:, substances.index(name)]
    return getattr(table[Physical], name)


def own(property: str, scale: float, substances: list[str]) -> Sense:
    """Feel a property of the own body, as a share of `scale`."""
    factor = np.float32(1.0 / scale)

    def sense(world: "World", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        world.split(_own, seekers.n, own_column(table, property, substances), seekers.rows, factor, out, column)

    return sense


def own_range(table: "Table", seekers: Seekers, number: int, radius: float) -> tuple[float, np.ndarray]:
    """Return how far the sensor reaches at most, and for each seeker f32[n] [m]; `radius` where that is not its own."""
    if number not in table.species.own_ranges or not seekers.n:
        return radius, np.full(seekers.n, radius, np.float32)
    own = table[Senses].radius[seekers.rows, number]
    return float(own.max()), own


def see_nearest(target: str, reach: float, fov: float, occlusion: bool, number: int = 0, by_light: float | None = None,
                blind: float = 0.0) -> Sense:
    """See the nearest of a kind: its direction in the body's frame, as a unit vector, and 1 − distance/reach.

    With `by_light` [m] it sees as far as blind + by_light × light at its eye [m], and never further than without.
    """
    cos_half_fov = np.float32(-2.0 if fov >= 2 * math.pi - 1e-5 else math.cos(fov / 2))

    def sense(world: "World", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        radius, own = own_range(table, seekers, number, reach)
        targets, mine = world.index(world.tables[target]), seekers.index
        if by_light is not None:
            light = world.surroundings("light", mine.x, mine.y, mine.z)
            own = np.minimum(own, np.float32(blind) + np.float32(by_light) * light)
            radius = max(float(own.max(initial=0.0)), 1e-6)
        found, distance2 = np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32)
        nearest(mine, targets, radius, found, distance2, world.split)
        if occlusion or cos_half_fov > -1:
            space, ground, inverse = world.space, *rocks(world)
            bodies: Any = opaque(world) if occlusion else targets
            radii = bodies.radius if occlusion else targets.x
            largest = np.float32(bodies.largest if occlusion else 0.0)
            world.split(sight.nearest_visible, seekers.n, mine.x, mine.y, mine.z, mine.uid, seekers.cos, seekers.sin,
                        targets.x, targets.y, targets.z, targets.uid, targets.start, bodies.x, bodies.y, bodies.z, radii, bodies.uid,
                        bodies.start, occlusion, largest, *space.shape, space.inverse, space.lengths, space.torus, space.reach(radius),
                        np.float32(radius),
                        cos_half_fov, ground, inverse, found, distance2)
        world.split(_bearings, seekers.n, mine.x, mine.y, mine.z, seekers.cos, seekers.sin, targets.x, targets.y, targets.z, found,
                    distance2, world.space.lengths, world.space.torus, world.space.volume, own, out, column)

    sense.by_light = by_light is not None  # type: ignore[attr-defined]
    return sense


def cast_rays(targets: list[str], count: int, fov: float, reach: float, report: str, number: int = 0) -> Sense:
    """Cast rays that stop at the first body, rock or wall; report closeness per ray, or the closest hit of each type."""
    turn = fov if fov >= 2 * math.pi - 1e-5 else fov * count / max(count - 1, 1)  # no ray twice on a full circle
    angles = (np.arange(count) - (count - 1) / 2) * (turn / count)
    ray_cos, ray_sin = np.cos(angles).astype(np.float32), np.sin(angles).astype(np.float32)

    def sense(world: "World", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        space, mine, (ground, inverse) = world.space, seekers.index, rocks(world)
        radius, own = own_range(table, seekers, number, reach)
        names = [n for n, t in world.tables.items() if Body in t and (n in targets or t.species.opaque is not False)]
        bodies = merged(world, names)
        hit = np.empty((seekers.n, count), np.int32)
        distance = np.empty((seekers.n, count), np.float32)
        world.split(sight.cast, seekers.n, mine.x, mine.y, mine.z, mine.uid, seekers.cos, seekers.sin, mine.x, bodies.x, bodies.y,
                    bodies.z, bodies.radius, bodies.uid, bodies.kind, bodies.start, *space.shape, space.inverse, space.lengths,
                    space.torus, space.reach(radius + bodies.largest), np.float32(radius), ray_cos, ray_sin, ground, inverse, hit, distance)
        near = np.maximum(np.float32(1) - distance / own[:, None], np.float32(0))
        width = count if report == "per_ray" else (4 if space.volume else 3)
        for i, target in enumerate(targets):
            of_kind = hit == (-2 if target == "wall" else names.index(target))
            closeness = np.where(of_kind, near, np.float32(0))
            c = column + i * width
            if report == "per_ray":
                out[:, c : c + count] = closeness
                continue
            best = closeness.argmax(axis=1)
            value = closeness[np.arange(seekers.n), best]
            out[:, c] = np.where(value > 0, ray_cos[best], 0)
            out[:, c + 1] = np.where(value > 0, ray_sin[best], 0)
            out[:, c + 2 : c + width - 1] = 0
            out[:, c + width - 1] = value

    return sense


def nose(seekers: Seekers, forward: Any, left: Any, space: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y f32[n] of a place on each body, given in radii ahead and to the left."""
    x = seekers.index.x + seekers.radius * (forward * seekers.cos - left * seekers.sin)
    y = seekers.index.y + seekers.radius * (forward * seekers.sin + left * seekers.cos)
    return back_into(x, space.lengths[0], space.wrap[0]), back_into(y, space.lengths[1], space.wrap[1])


def smell(field: str, at: list[float], scale: float, number: int = 0) -> Sense:
    """Smell a field at a place of the body: c/(c + scale), the occupancy of receptors that are half bound at `scale`."""
    forward, left, up = (np.float32(v) for v in [*at, 0.0, 0.0, 0.0][:3])

    def sense(world: "World", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        f, mine, space = world.fields[field], seekers.index, world.space
        x, y = mine.x, mine.y
        body = (seekers.radius, seekers.cos, seekers.sin, forward, left)
        if number in table.species.own_places:  # the kernel finds each one's nose where its body is
            own = table[Senses]
            x, y = nose(seekers, own.forward[seekers.rows, number], own.left[seekers.rows, number], space)
            body = (seekers.radius, seekers.cos, seekers.sin, np.float32(0), np.float32(0))
        if space.volume:
            world.split(_sniff_volume, seekers.n, f.value, f.inverse, x, y, mine.z, *body, up, np.float32(scale), space.lengths,
                        space.torus, out, column)
        else:
            world.split(_sniff_plane, seekers.n, f.value[0], f.inverse, x, y, *body, np.float32(scale), space.torus, out, column)

    return sense


def touch(targets: list[str] | None, wall: bool, at: list[float], reach: float = 0.0) -> Sense:
    """Feel whether a body of a kind, or a wall, touches the own body within a sector of directions."""

    def sense(world: "World", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        out[:, column] = 0
        mine, space = seekers.index, world.space
        names = [n for n, t in world.tables.items() if Body in t and Position in t] if targets is None else targets
        if names:
            bodies = merged(world, names)
            widest = float(seekers.radius.max(initial=0.0)) + bodies.largest + reach
            world.split(_touch, seekers.n, mine.x, mine.y, mine.z, mine.uid, seekers.radius, seekers.heading,
                        bodies.x, bodies.y, bodies.z, bodies.radius, bodies.uid, bodies.start, *space.shape, space.inverse, space.lengths,
                        space.torus, space.reach(widest), np.float32(reach), np.float32(at[0]), np.float32(at[1]), out, column)
        if wall and (space.volume or not space.torus):
            _touch_walls(mine.x, mine.y, mine.z, seekers.radius, seekers.heading, space.lengths, space.torus,
                         space.volume, np.float32(at[0]), np.float32(at[1]), out, column)

    return sense


def ambient(quantity: str, zero: float, scale: float, at: Sequence[float] = (), number: int = 0, dark: float | None = None) -> Sense:
    """Read light, temperature or pressure of the surroundings at a place of the body, as (value − zero)/scale.

    With `dark` the value is log10(1 + value/dark).
    """
    forward, left, up = (np.float32(v) for v in [*at, 0.0, 0.0, 0.0][:3])

    def sense(world: "World", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        x, y, z = seekers.index.x, seekers.index.y, seekers.index.z
        own, space = number in table.species.own_places, world.space
        if own or forward or left or up:
            of = table[Senses] if own else None
            ahead, aside = (forward, left) if of is None else (of.forward[seekers.rows, number], of.left[seekers.rows, number])
            x, y = nose(seekers, ahead, aside, space)
            z = back_into(z + seekers.radius * up, space.lengths[2], space.wrap[2]) if space.volume else z
        value = world.surroundings(quantity, x, y, z)
        if dark is not None:
            value = np.log10(np.float32(1) + value / np.float32(dark))
        out[:, column] = (value - np.float32(zero)) / np.float32(scale)

    return sense


def rocks(world: "World") -> tuple[np.ndarray, np.ndarray]:
    """Return the ground map and its scale; a map of one cell stands for open ground."""
    if world.terrain is None:
        return sight.NO_GROUND, np.zeros(2, np.float32)
    return world.terrain.ground, world.terrain.inverse


def opaque(world: "World") -> sight.Bodies:
    """Return all bodies that hide what is behind them."""
    return merged(world, [n for n, t in world.tables.items() if Body in t and t.species.opaque is not False])


def merged(world: "World", names: list[str]) -> sight.Bodies:
    """Return the bodies of several tables in one index, rebuilt when one of them has changed."""
    tables = [world.tables[n] for n in names]
    key, version = tuple(names), tuple(t.version for t in tables)
    if world._merged.get(key, (None, None))[0] != version:
        parts = []
        for table in tables:
            rows, p = world.index(table).rows, table[Position]
            parts.append((p.x[rows], p.y[rows], p.z[rows], table[Body].radius[rows], table.uid[rows]))
        world._merged[key] = (version, sight.Bodies(world.space, parts))
    return world._merged[key][1]


def senses_of(species: Any, dims: int, substances: list[str], find: Callable[[Any], Any] = handed_over) -> list[tuple[Sense, int]]:
    """Return (sense, number of channels) for each sensor of a species' configuration."""
    made = [find(s.function) if s.kind == "custom" else _sense_of(s, substances, i) for i, s in enumerate(species.sensors)]
    return [(sense, len(s.channels(dims))) for sense, s in zip(made, species.sensors, strict=True)]


def _sense_of(s: Any, substances: list[str], number: int) -> Sense:
    if s.kind == "own":
        return own(s.property, s.scale, substances)
    if s.kind == "nearest":
        return see_nearest(s.target, s.radius, s.fov, s.occlusion, number, s.sight, s.blind)
    if s.kind == "rays":
        return cast_rays(s.targets, s.count, s.fov, s.radius, s.report, number)
    if s.kind == "smell":
        return smell(s.field, s.at, s.scale, number)
    if s.kind == "touch":
        names = None if s.target == "any" else ([] if s.target == "wall" else [s.target])
        return touch(names, s.target in ("any", "wall"), s.at)
    if s.kind == "gradient":
        return flow.smell_gradient(s.field, s.span, s.scale)
    if s.kind == "approach":
        return flow.feel_approach(s.target, s.radius, s.scale)
    return ambient(s.kind, s.zero, s.scale, s.at, number, getattr(s, "dark", None))


@njit
def _own(first, last, value, rows, factor, out, column):
    for i in range(first, last):
        out[i, column] = value[rows[i]] * factor


@njit
def _bearings(first, last, ox, oy, oz, cos, sin, tx, ty, tz, found, distance2, lengths, torus, volume, radius, out, column):
    for i in range(first, last):
        j = found[i]
        if j < 0 or distance2[i] > radius[i] * radius[i]:
            out[i, column] = 0
            out[i, column + 1] = 0
            out[i, column + 2] = 0
            if volume:
                out[i, column + 3] = 0
            continue
        dx, dy, dz = sight.offset(ox[i], oy[i], oz[i], tx[j], ty[j], tz[j], lengths, torus)
        distance = np.sqrt(distance2[i])
        inverse = np.float32(1.0) / max(distance, np.float32(1e-6))
        out[i, column] = (dx * cos[i] + dy * sin[i]) * inverse
        out[i, column + 1] = (dy * cos[i] - dx * sin[i]) * inverse
        c = column + 2
        if volume:
            out[i, c] = dz * inverse
            c += 1
        out[i, c] = np.float32(1.0) - distance / radius[i]


@njit
def _sniff_plane(first, last, value, inverse, ox, oy, radius, cos, sin, forward, left, scale, torus, out, column):
    """Read the field f32[ny, nx] at the noses; without branches and with unsigned indices, so that it becomes vector code."""
    ny, nx = value.shape
    flat = value.reshape(-1)
    half, zero, one, fnx, fny = np.float32(0.5), np.float32(0.0), np.float32(1.0), np.float32(nx), np.float32(ny)
    last_x, last_y = fnx - one, fny - one
    for i in range(first, last):
        r = radius[i]
        gx = (ox[i] + r * (forward * cos[i] - left * sin[i])) * inverse[0] - half
        gy = (oy[i] + r * (forward * sin[i] + left * cos[i])) * inverse[1] - half
        bx, by = np.floor(gx), np.floor(gy)
        fx, fy = gx - bx, gy - by
        if torus:
            x0, y0 = bx + fnx if bx < zero else bx, by + fny if by < zero else by
            x0, y0 = x0 - fnx if x0 >= fnx else x0, y0 - fny if y0 >= fny else y0
            x0, y0 = x0 if x0 > zero else zero, y0 if y0 > zero else zero
            x0, y0 = x0 if x0 < last_x else last_x, y0 if y0 < last_y else last_y
            x1, y1 = x0 + one, y0 + one
            x1, y1 = x1 - fnx if x1 >= fnx else x1, y1 - fny if y1 >= fny else y1
        else:
            x0, y0, x1, y1 = bx if bx > zero else zero, by if by > zero else zero, bx + one, by + one
            x1, y1 = x1 if x1 > zero else zero, y1 if y1 > zero else zero
            x0, y0, x1, y1 = min(x0, last_x), min(y0, last_y), min(x1, last_x), min(y1, last_y)
        i0, i1, j0, j1 = np.uint32(x0), np.uint32(x1), np.uint32(y0) * np.uint32(nx), np.uint32(y1) * np.uint32(nx)
        south, north = (one - fx) * flat[j0 + i0] + fx * flat[j0 + i1], (one - fx) * flat[j1 + i0] + fx * flat[j1 + i1]
        c = (one - fy) * south + fy * north
        out[i, column] = c / (c + scale)


@njit
def _sniff_volume(first, last, value, inverse, ox, oy, oz, radius, cos, sin, forward, left, up, scale, lengths, torus, out, column):
    """Read the field f32[nz, ny, nx] at the noses."""
    for i in range(first, last):
        r = radius[i]
        x = into(ox[i] + r * (forward * cos[i] - left * sin[i]), lengths[0], torus)
        y = into(oy[i] + r * (forward * sin[i] + left * cos[i]), lengths[1], torus)
        z = into(oz[i] + r * up, lengths[2], False)
        c = field_at(value, x, y, z, inverse, torus)
        out[i, column] = c / (c + scale)


@njit
def within(angle, begin, end):
    """Return whether an angle lies in the sector from `begin` counter-clockwise to `end` (a whole circle where they span it)."""
    turn = np.float32(6.2831855)
    width = end - begin
    if width >= turn - np.float32(1e-5):
        return True
    a = angle - begin
    a -= turn * np.float32(np.floor(a / turn))
    if width < 0:
        width += turn
    return a <= width


@njit
def _touch(first, last, ox, oy, oz, ou, radius, heading, bx, by, bz, br, bu, bstart, nx, ny, nz, inverse, lengths, torus, reach_cells,
           reach, begin, end, out, column):
    near = np.empty(bx.size, np.int64)
    for i in range(first, last):
        r = radius[i]
        n = sight.gather(ox[i], oy[i], oz[i], reach_cells, bstart, bx, by, bz, nx, ny, nz, inverse, lengths, torus, near)
        for q in range(n):
            e = near[q]
            if bu[e] == ou[i]:
                continue
            dx, dy, dz = sight.offset(ox[i], oy[i], oz[i], bx[e], by[e], bz[e], lengths, torus)
            s = r + br[e] + reach
            if dx * dx + dy * dy + dz * dz <= s * s and within(np.float32(np.arctan2(dy, dx)) - heading[i], begin, end):
                out[i, column] = 1
                break


@njit
def _touch_walls(ox, oy, oz, radius, heading, lengths, torus, volume, begin, end, out, column):
    half = np.float32(1.5707964)
    for i in range(radius.size):
        r, h = radius[i], heading[i]
        if volume and (oz[i] <= r or oz[i] >= lengths[2] - r):
            out[i, column] = 1
        if torus:
            continue
        if ((ox[i] >= lengths[0] - r and within(-h, begin, end)) or (ox[i] <= r and within(half + half - h, begin, end))
                or (oy[i] >= lengths[1] - r and within(half - h, begin, end)) or (oy[i] <= r and within(-half - h, begin, end))):
            out[i, column] = 1
