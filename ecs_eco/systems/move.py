"""Organisms move as they have decided."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.compiled.elementary import arrays, power
from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.compiled.per_row import is_own, of_row, row_of
from ecs_eco.compiled.trigonometry import sine_and_cosine
from ecs_eco.components import Motor, Nervous, Position, SpeedScale, Velocity
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value
from ecs_eco.life.gaits import Gaits, own_gaits
from ecs_eco.life.sizes import share_of_adult
from ecs_eco.life.torpor import awake
from ecs_eco.nervous.decision import first_of, first_on
from ecs_eco.space.barriers import barriers, stop
from ecs_eco.space.bodies import ground_of
from ecs_eco.space.geometry import Extent, cells_of, half_cells, into
from ecs_eco.space.terrain import FENCE, OPEN, Ground, along, ground_at, height_at

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.geometry import Space
    from ecs_eco.space.terrain import Terrain
    from ecs_eco.space.world import SpatialWorld

NO_MOTOR = np.zeros((1, 1), np.float32)
NO_SCALE = np.ones(0, np.float32)
NOT_ASKED = np.zeros(0, np.float32)
BLOCK = 64  # rows


class Bodies(NamedTuple):
    """Position and motion of bodies, for kernels: f32[rows]."""

    x: np.ndarray  # [m]
    y: np.ndarray
    z: np.ndarray
    heading: np.ndarray  # [rad]
    speed: np.ndarray  # [m/s]
    climb: np.ndarray  # [m/s]
    cost: np.ndarray


class Move(System):
    """An animal turns, then moves forward at the speed of its gait and pays the cost.

    Moving uphill costs more. SpeedScale multiplies the speed of every gait, and its square multiplies the
    cost; the size of growing young has the same effect. Animals stop at the edge of water, rock, fences and
    walls; roads change speed and cost; torpid animals do not move. In a volume, the group `climb` moves an
    animal up and down, either at a separate speed or along a slope at the speed of its gait. With drag, speed
    approaches the gait's speed by dv/dt = drag (v_gait − v), the balance of thrust and Stokes' drag (Stokes
    1851), solved exactly. The center of a solid animal stops at an immovable solid capsule or box, however
    fast the animal is.

    Continuous speed [m/s], turn [rad/s], climb [m/s] and pitch [rad] are used directly; the cost of a speed
    between two gaits is interpolated linearly.
    """

    needs = (Position, Velocity, Nervous)
    phase = "move"
    divisible = True
    submodel = Submodel(
        "Movement",
        where=("locomotion",),
        reads=("locomotion",),
        rules={
            "": "`heading(t + dt) = heading(t) ± turn dt`; then `x(t + dt) = x(t) + v dt cos(heading)` and "
            "`y(t + dt) = y(t) + v dt sin(heading)`, where v is the speed of the gait.",
            "locomotion.cost": "Metabolism burns the cost of the gait.",
            "locomotion.drag": "Speed approaches the gait's speed: `dv/dt = drag (v_gait − v)` (Stokes "
            "1851), solved exactly.",
            "locomotion.climb": "`dz/dt = ± climb`.",
            "locomotion.pitch": "An animal that swims up or down moves along a slope of angle `pitch`: "
            "`v sin(pitch)` upward and `v cos(pitch)` forward.",
            "terrain.slope_cost": "Uphill, the cost is multiplied by `1 + slope_cost × rise/distance`.",
            "space.edges=torus": "An animal that leaves on one side reappears on the opposite side.",
            "space.edges=walls": "The edges of the world stop an animal.",
            "terrain.lakes": "An animal stops at the edge of a lake.",
            "terrain.rocks": "An animal stops at the edge of a rock.",
            "interventions.kind=fence": "An animal stops at a fence.",
            "terrain.roads": "Roads multiply speed by `pace` and cost by `cost`.",
            "growth.pace": "The speed of young animals is multiplied by `(mass/adult mass)^pace`.",
        },
        changes=("Position", "Velocity"),
    )

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Move one species."""
        gaits = own_gaits(table)
        if gaits is None:
            return
        p, v, terrain = table[Position], table[Velocity], world.terrain
        pace = paces(table)
        factor = None if terrain is None or terrain.pace is None else _on_roads(table, terrain)
        if factor is not None:
            pace = factor[0] * (pace[: table.high] if pace.size else np.float32(1))
        command = table[Motor].command if Motor in table else NO_MOTOR
        moving, alive = awake(table), table.alive[: table.high]
        if moving is not table.alive:
            for flow in (v.speed, v.climb, v.cost):
                flow[table.alive & ~moving] = 0
        walls = barriers(world) if table.species.body.solid else None
        before = None if walls is None else np.stack([p.x, p.y, p.z], 1)[: table.high]
        gone = NOT_ASKED if walls is None else np.zeros(table.high, np.float32)
        world.split(
            move,
            table.high,
            moving,
            table[Nervous].decision,
            command,
            gaits,
            pace,
            np.float32(world.dt),
            world.space.extent,
            ground_of(world),
            np.float32(0.0 if terrain is None else terrain.slope_cost),
            Bodies(p.x, p.y, p.z, p.heading, v.speed, v.climb, v.cost),
            gone,
        )
        if factor is not None:
            v.cost[: table.high][alive] *= factor[1][alive]
        if walls is not None and before is not None:
            rows = table.rows()
            share = stop(world, table, walls, before, ways(table, world.space, before, gone)[rows])
            v.speed[rows] *= share
            v.climb[rows] *= share
        table.version += 1


def ways(table: Table, space: Space, before: np.ndarray, gone: np.ndarray) -> np.ndarray:
    """Return the displacements f32[rows, 3] [m] of organisms that have moved forward by f32[rows] [m] from
    positions f32[rows, 3] [m], possibly several times around a torus."""
    p, n = table[Position], len(before)
    way = np.stack([p.x, p.y, p.z], 1)[:n] - before
    if space.torus:
        for axis, part in enumerate((arrays.cos(p.heading[:n]), arrays.sin(p.heading[:n]))):
            way[:, axis] += space.lengths[axis] * np.round((gone * part - way[:, axis]) / space.lengths[axis])
    return way


def _on_roads(table: Table, terrain: Terrain) -> tuple[np.ndarray, np.ndarray]:
    """Return the factors for speed and cost at each position, f32[high] each; the cost factor cancels the
    squared pace by which `move` multiplies costs."""
    p, high, (ny, nx) = table[Position], table.high, terrain.shape
    i, j = cells_of(p.x[:high], terrain.inverse[0], nx), cells_of(p.y[:high], terrain.inverse[1], ny)
    assert terrain.pace is not None
    assert terrain.toll is not None
    pace = terrain.pace[j, i]
    return pace, terrain.toll[j, i] / (pace * pace)


def paces(table: Table) -> np.ndarray:
    """Return the factor f32[rows] by which genes and size multiply each organism's speeds; empty if all
    factors are 1."""
    pace = table[SpeedScale].pace if SpeedScale in table else NO_SCALE
    if (growth := table.species.growth) is None:
        return pace
    exponent = own_value(table, "growth.pace", np.float32(growth.pace))
    if not isinstance(exponent, np.ndarray) and exponent == 0:
        return pace
    young = power(share_of_adult(table), exponent).astype(np.float32)
    return young * pace[: table.high] if pace.size else young


@lone_njit
def move(
    first: int,
    last: int,
    alive: np.ndarray,
    decision: np.ndarray,
    command: np.ndarray,
    gaits: Gaits,
    pace: np.ndarray,
    dt: np.float32,
    space: Extent,
    ground: Ground,
    slope_cost: np.float32,
    bodies: Bodies,
    gone: np.ndarray,
) -> None:
    """Move the living rows first … last − 1. `gone` f32[rows] receives the distance [m] that each has moved
    forward, unless it is empty.

    Rows are processed in blocks, so that many sines and cosines are computed at once.
    """
    if first >= last:
        return
    _, _, z, heading, speed, climb, cost = bodies
    layout, speeds, costs, turns, climbs, pitches, drag = gaits
    left, mean_left = lag(of_row(drag, first), dt)
    sine, cosine = np.empty(BLOCK, np.float32), np.empty(BLOCK, np.float32)
    ahead = np.empty(BLOCK, np.float32)
    gait, turn = np.empty(BLOCK, np.int32), np.empty(BLOCK, np.int32)
    whole, zero = np.float32(6.2831855), np.float32(0.0)
    for start in range(first, last, BLOCK):
        size = min(BLOCK, last - start)
        first_of(decision, start, size, layout[0, 0], layout[0, 1], layout[0, 2], gait)
        first_of(decision, start, size, layout[1, 0], layout[1, 1], layout[1, 2], turn)
        for i in range(size):
            row = start + i
            ahead[i] = zero
            if not alive[row]:
                continue
            if is_own(drag):
                left, mean_left = lag(of_row(drag, row), dt)
            way = turn[i]
            if way >= 0 or layout[1, 1] < 0:
                h = heading[row] + (row_of(turns, row)[way] if way >= 0 else command[row, layout[1, 0]]) * dt
                heading[row] = h - whole * np.float32(np.floor(h / whole))
            way = gait[i]
            v, c = (row_of(speeds, row)[way], row_of(costs, row)[way]) if way >= 0 else (zero, zero)
            if layout[0, 1] < 0:
                v = command[row, layout[0, 0]]
                c = cost_between(v, row_of(speeds, row), row_of(costs, row))
            if pace.size:
                v *= pace[row]
                c *= pace[row] * pace[row]
            if space.lengths[2] > 0:  # a volume
                up, v = climbing(decision, command, row, layout, row_of(climbs, row), row_of(pitches, row), v)
                z[row] = into(z[row] + (up + (climb[row] - up) * mean_left) * dt, space.lengths[2], False)
                climb[row] = up + (climb[row] - up) * left
            ahead[i] = v + (speed[row] - v) * mean_left
            speed[row] = v + (speed[row] - v) * left
            cost[row] = c
        go_ahead(start, size, ahead, sine, cosine, drag, dt, space, ground, slope_cost, bodies)
        for i in range(size if gone.size else 0):
            gone[start + i] = max(ahead[i], zero) * dt


@lone_njit
def go_ahead(start, size, ahead, sine, cosine, drag, dt, space, ground, slope_cost, bodies):
    """Move a block of rows, starting at `start`, along their headings at speeds `ahead`, which are reduced
    where the path is blocked. `sine` and `cosine` are scratch arrays."""
    x, y, heading, lengths, torus = bodies.x, bodies.y, bodies.heading, space.lengths, space.torus
    for i in range(size):
        sine[i], cosine[i] = sine_and_cosine(heading[start + i])
    if ground.kind.size > 1 or ground.height.size > 1:
        for i in range(size):
            if ahead[i] > 0:
                ahead[i] = over_land(
                    start + i, ahead[i], sine[i], cosine[i], drag, dt, space, ground, slope_cost, bodies
                )
        return
    for i in range(size):
        row, v = start + i, ahead[i]
        nx, ny = (
            into(x[row] + v * dt * cosine[i], lengths[0], torus),
            into(y[row] + v * dt * sine[i], lengths[1], torus),
        )
        x[row] = nx if v > np.float32(0.0) else x[row]
        y[row] = ny if v > np.float32(0.0) else y[row]


@njit
def over_land(row, v, sine, cosine, drag, dt, space, ground, slope_cost, bodies):
    """Move one organism forward at speed v until its path is blocked; moving uphill costs more. Return its
    speed."""
    x, y, speed, cost = bodies.x, bodies.y, bodies.speed, bodies.cost
    if ground.kind.size > 1:
        v = free_way(x[row], y[row], sine, cosine, v, dt, ground, space)
        speed[row] = min(v, speed[row]) if of_row(drag, row) > 0 else v
    if v > 0:
        nx, ny = along(x[row], y[row], v * dt * cosine, v * dt * sine, space)
        if ground.height.size > 1:
            rise = height_at(ground, nx, ny, space.torus) - height_at(ground, x[row], y[row], space.torus)
            cost[row] += cost[row] * slope_cost * max(rise, np.float32(0.0)) / (v * dt)
        x[row] = nx
        y[row] = ny
    return v


@njit
def climbing(decision, command, row, layout, climbs, pitches, v):
    """Return the upward and forward components of the gait's speed v."""
    way = first_on(decision, row, layout[2, 0], layout[2, 1], layout[2, 2])
    up, angle = (climbs[way], pitches[way]) if way >= 0 else (np.float32(0.0), np.float32(0.0))
    if layout[2, 1] < 0:
        up = command[row, layout[2, 0]]
    if layout[3, 1] < 0:
        angle = command[row, layout[3, 0]]
    if angle != 0:
        sine, cosine = sine_and_cosine(angle)
        up += v * sine
        v *= cosine
    return up, v


@njit
def lag(drag, dt):
    """Return the share of the old speed that is left after a tick of dt [s], and its mean over the tick."""
    left = np.exp(-drag * dt) if drag > 0 else np.float32(0.0)
    mean_left = (np.float32(1.0) - left) / (drag * dt) if drag > 0 else np.float32(0.0)
    return left, mean_left


@njit
def cost_between(v, speeds, costs):
    """Return the cost of a speed, interpolated linearly between ascending speeds f32[k]; outside their range,
    it is the cost of the slowest or fastest."""
    if v <= speeds[0]:
        return costs[0]
    for k in range(1, speeds.size):
        if v <= speeds[k]:
            share = (v - speeds[k - 1]) / (speeds[k] - speeds[k - 1])
            return costs[k - 1] + share * (costs[k] - costs[k - 1])
    return costs[-1]


@njit
def free_way(x, y, sine, cosine, v, dt, ground, space):
    """Return the speed at which a step of dt [s] ends just before water, rock or a fence; checks every half
    cell of the path, up to the sum of the space's length and width.

    An animal on the line of a new fence can walk off it.
    """
    v = min(v, (space.lengths[0] + space.lengths[1]) / dt)
    on = ground_at(ground, x, y) == FENCE
    steps = half_cells(v * dt, ground.inverse, space.lengths)
    for s in range(1, steps + 1):
        way = v * dt * np.float32(s) / np.float32(steps)
        kind = ground_at(ground, *along(x, y, way * cosine, way * sine, space))
        if kind != OPEN and not (on and kind == FENCE):
            return v * np.float32(s - 1) / np.float32(steps)
        on = on and kind == FENCE
    return v
