"""What organisms see with: ranges, fields of view and rays of their sensors, as a page draws them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Position, Senses

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World
    from ecs_eco.engine.table import Table

SEEING = ("nearest", "rays", "approach", "property")


def eyes_of(sensors: Any) -> list[dict[str, Any]]:
    """Return the sensors of a species that reach further than its body: name, kind, targets, reach [m], field
    of view [rad] and, of rays, their number and direction; `sensors` as in a manifest."""
    out = []
    for number, sensor in enumerate(sensors or ()):
        if sensor["kind"] not in SEEING:
            continue
        eye = {
            "number": number,
            "name": sensor.get("name") or "",
            "kind": sensor["kind"],
            "targets": _targets(sensor),
            "reach": float(sensor["radius"]),
            "fov": min(float(sensor.get("fov", 2 * math.pi)), 2 * math.pi),
        }
        if sensor["kind"] == "rays":
            eye |= {
                "count": int(sensor["count"]),
                "angle": float(sensor.get("angle", 0.0)),
                "each": sensor.get("report") == "per_ray",
            }
        if sensor.get("kin"):
            eye["kin"] = sensor["kin"]
        out.append(eye)
    return out


def _targets(sensor: Mapping[str, Any]) -> list[str]:
    of = sensor.get("target") or sensor.get("targets") or sensor.get("of") or []
    return [of] if isinstance(of, str) else list(of)


def reach_of(world: World, table: Table, row: int) -> dict[str, float]:
    """Return how far the sensors of one organism reach now [m], by the number of the sensor, where that is
    its own or depends on the light."""
    config, out = table.species.config, {}
    for number, sensor in enumerate(() if config is None else config.sensors):
        if sensor.kind not in SEEING:
            continue
        reach = float(sensor.radius)
        if number in table.species.own_ranges:
            reach = float(table[Senses].radius[row, number])
        sight = getattr(sensor, "sight", None)
        if sight is not None:
            p = table[Position]
            places = (np.array([axis[row]], np.float32) for axis in (p.x, p.y, p.z))
            light = float(world.surroundings("light", *places)[0])
            reach = min(reach, float(sensor.blind) + float(sight) * light)
        if reach != float(sensor.radius):
            out[str(number)] = round(reach, 3)
    return out
