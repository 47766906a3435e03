"""The sensor that casts rays."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Body, Shape
from ecs_eco.nervous.sensors.sense import Seekers, Sense, own_range, place_of
from ecs_eco.space import sight
from ecs_eco.space.bodies import merged, rocks, solids
from ecs_eco.space.solid_sight import cast_on_solids

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def cast_rays(targets: list[str], count: int, fov: float, reach: float, report: str,
              number: int = 0, at: Sequence[float] = (), angle: float = 0.0) -> Sense:
    """Cast rays that stop at the first body, rock or wall; report closeness per ray,
    or the closest hit of each type.

    They begin at a place on the body, `at`, and spread to both sides of `angle` from the heading.
    """
    # no ray twice on a full circle
    turn = fov if fov >= 2 * math.pi - 1e-5 else fov * count / max(count - 1, 1)
    angles = (np.arange(count) - (count - 1) / 2) * (turn / count) + angle
    ray_cos, ray_sin = np.cos(angles).astype(np.float32), np.sin(angles).astype(np.float32)

    def sense(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        radius, own = own_range(table, seekers, number, reach)
        place = place_of(table, seekers, number, at, world.space)
        names = [n for n, t in world.tables.items()
                 if Body in t and (n in targets or t.species.opaque is not False)]
        names, hit, distance = trace(world, seekers, place, names, radius, ray_cos, ray_sin)
        near = np.maximum(np.float32(1) - distance / own[:, None], np.float32(0))
        width = count if report == "per_ray" else (4 if world.space.volume else 3)
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


def trace(world: "SpatialWorld", seekers: Seekers, place: tuple[np.ndarray, ...], kinds: list[str],
          radius: float, ray_cos: np.ndarray,
          ray_sin: np.ndarray) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return the kinds of bodies in the order of their numbers; and for each seeker and ray the number of
    what is hit first, i32[n, rays], −1 none, −2 rock or wall, and how far it is, f32[n, rays] [m]."""
    space, mine, (ground, inverse) = world.space, seekers.index, rocks(world)
    shaped = [n for n in kinds if Shape in world.tables[n]]
    spheres = [n for n in kinds if n not in shaped]
    bodies = merged(world, spheres)
    hit = np.empty((seekers.n, ray_cos.size), np.int32)
    distance = np.empty((seekers.n, ray_cos.size), np.float32)
    world.split(sight.cast, seekers.n, *place, mine.uid, seekers.cos, seekers.sin, mine.x,
                bodies.x, bodies.y, bodies.z, bodies.radius, bodies.uid, bodies.kind, bodies.start,
                *space.shape, space.inverse, space.lengths,
                space.torus, space.reach(radius + bodies.largest), np.float32(radius), ray_cos, ray_sin,
                ground, inverse, hit, distance)
    if shaped:
        others = solids(world, shaped)
        world.split(cast_on_solids, seekers.n, *place, mine.uid, seekers.cos, seekers.sin, others.form,
                    others.uid, others.kind + np.int32(len(spheres)), *space.shape, space.inverse,
                    space.lengths, space.torus, *others.cells, np.float32(radius), ray_cos, ray_sin, hit,
                    distance)
    return [*spheres, *shaped], hit, distance
