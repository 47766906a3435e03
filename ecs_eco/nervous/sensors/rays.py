"""The sensor that casts rays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.components import Body, Shape
from ecs_eco.nervous.sensors.sense import Sense, in_light, of_sensor, own_range, place_of
from ecs_eco.space.bodies import merged, opaque_ground, solids, tops
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.sight import Rays, cast
from ecs_eco.space.solid_sight import cast_on_solids

if TYPE_CHECKING:
    from ecs_eco.compiled.per_row import Number
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def cast_rays(
    targets: list[str],
    count: int,
    fov: float,
    reach: float,
    report: str,
    number: int = 0,
    at: Sequence[float] = (),
    angle: float = 0.0,
    by_light: float | None = None,
    blind: float = 0.0,
) -> Sense:
    """Cast rays that stop at the first body, rock or wall; report closeness per ray, or the closest hit of
    each type.

    They start at a point on the body, `at`, and spread to both sides of a direction at `angle` from the
    heading. With `by_light` [m], they reach blind + by_light × light at the eye [m], but never farther than
    without it.
    """
    alike = fan(count, fov, angle)

    def read(world: SpatialWorld, table: Table, seekers: Seekers, out: np.ndarray, column: int) -> None:
        radius, own = own_range(table, seekers, number, reach)
        each = of_sensor(table, seekers, number, fov=fov, angle=angle)
        ray_cos, ray_sin = fan(count, *each) if isinstance(each[0], np.ndarray) else alike
        place = place_of(table, seekers, number, at, world.space)
        if by_light is not None:
            own = np.maximum(
                in_light(world, table, seekers, number, place, own, by_light, blind), np.float32(1e-6)
            )
            radius = float(own.max(initial=1e-6))
        names = [n for n, t in world.tables.items() if Body in t and (n in targets or t.species.body.opaque)]
        names, hit, distance = trace(world, table, seekers, place, names, radius, ray_cos, ray_sin)
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
            for way, along in enumerate((ray_cos, ray_sin)):
                towards = along[best] if along.ndim == 1 else along[np.arange(seekers.n), best]
                out[:, c + way] = np.where(value > 0, towards, 0)
            out[:, c + 2 : c + width - 1] = 0
            out[:, c + width - 1] = value

    return Sense(read, divisible=by_light is None)


def fan(count: int, fov: Number, angle: Number) -> tuple[np.ndarray, np.ndarray]:
    """Return the cosine and sine of the rays' angles from the heading: f32[count], or f32[n, count] if `fov`
    and `angle` [rad] are arrays for n seekers."""
    steps = np.arange(count) - (count - 1) / 2
    # no duplicate ray on a full circle
    turn = np.where(fov >= 2 * math.pi - 1e-5, fov, fov * count / max(count - 1, 1)) / count
    angles = steps * turn[..., None] + np.asarray(angle)[..., None]
    return arrays.cos(angles).astype(np.float32), arrays.sin(angles).astype(np.float32)


def trace(
    world: SpatialWorld,
    table: Table,
    seekers: Seekers,
    place: tuple[np.ndarray, ...],
    kinds: list[str],
    radius: float,
    ray_cos: np.ndarray,
    ray_sin: np.ndarray,
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return the kinds of bodies and, for each seeker and ray, the index of the kind that is hit first,
    i32[n, rays] (−1: none, −2: rock or wall), and the distance of the hit, f32[n, rays] [m]."""
    space, ground, eye = world.space, opaque_ground(world), tops(table, seekers.rows)
    shaped = [n for n in kinds if Shape in world.tables[n]]
    spheres = [n for n in kinds if n not in shaped]
    poses, bodies = seekers.poses_at(*place), merged(world, spheres)
    hit = np.empty((seekers.n, ray_cos.shape[-1]), np.int32)
    distance = np.zeros((seekers.n, ray_cos.shape[-1]), np.float32)
    rays = Rays(ray_cos, ray_sin, np.float32(radius), eye, hit, distance)
    reach = space.reach(radius + float(bodies.largest))
    world.split(cast, seekers.n, poses, bodies, rays, reach, ground, space.extent)
    if shaped:
        others = solids(world, shaped)
        others = others._replace(kind=others.kind + np.int32(len(spheres)))
        world.split(cast_on_solids, seekers.n, poses, others, rays, ground, space.extent)
    return [*spheres, *shaped], hit, distance
