"""Human use of the ground: fences, roads and areas of land use."""

from collections.abc import Iterable, Mapping
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.style import Axes
from ecs_eco.config.land.land import kept_land
from ecs_eco.engine.errors import ConfigError

Land = dict[str, list[dict[str, Any]]]
ROAD, FENCE = "#d8ccb4", "#222222"
USES = {"harvest": "#b2182b", "plant": "#1b7837"}  # colors of areas


def land_at(config: Mapping[str, Any], intervened: Iterable[Any], tick: int, run: Path | None = None) -> Land:
    """Return `fences`, `roads` and `areas` at the end of a tick. Each has a `line` of corners or a `region`,
    in the format of a world file [m]; roads also have a `width` [m], and areas have a `kind` and a `species`.
    `config` and `intervened` are from a run's manifest. Land use that covers the whole world is left out. For
    real land, the lines of its layers are read from the folder `run`."""
    terrain = config.get("terrain") or {}
    lines = _of_layers(run) if run is not None and terrain.get("layers") else []
    standing: Land = {
        "fence": [{"line": one["line"]} for one in lines if one["make"] == "fences"],
        "road": [_shape(road) for road in terrain.get("roads", ())]
        + [_shape(one) for one in lines if one["make"] == "roads"],
    }
    for when, order in intervened:
        if not isinstance(order, Mapping) or when > tick or order.get("kind") not in standing:
            continue
        known, shape = standing[order["kind"]], _shape(order)
        if not order.get("remove"):
            known.append(shape)
        elif _where(shape) == (None, None):
            known.clear()
        else:
            gone = next((other for other in known if _where(other) == _where(shape)), None)
            standing[order["kind"]] = [other for other in known if other is not gone]
    areas = []
    for use in config.get("land_use") or ():
        until = use.get("until")
        if use.get("region") and use.get("at", 0) <= tick and (until is None or tick <= until):
            areas.append({key: use[key] for key in ("kind", "species", "region")})
    return {"fences": standing["fence"], "roads": standing["road"], "areas": areas}


@lru_cache(maxsize=4)
def _of_layers(run: Path) -> list[dict[str, Any]]:
    """Return the lines of the land stored in a run folder (empty if it cannot be read)."""
    try:
        return kept_land(run).lines
    except ConfigError:
        return []


def _shape(order: Mapping[str, Any]) -> dict[str, Any]:
    """Return the position of a fence or road."""
    shape = {key: order[key] for key in ("line", "region") if order.get(key) is not None}
    return shape | ({"width": order.get("width", 1.0)} if order.get("kind", "road") == "road" else {})


def _where(shape: Mapping[str, Any]) -> tuple[Any, Any]:
    return shape.get("line"), shape.get("region")


def draw_land(ax: Axes, land: Land) -> list[Any]:
    """Draw the land below everything else, on axes in meters; return the artists."""
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Circle, Polygon, Rectangle

    drawn: list[Any] = []
    for road in land["roads"]:
        corners = strip(np.array(road["line"], float), road["width"])
        drawn.append(ax.add_collection(PolyCollection(corners, facecolor=ROAD, lw=0, zorder=0.6)))
    shapes: list[tuple[dict[str, Any], dict[str, Any]]] = [
        (area, {"ec": USES[area["kind"]], "ls": (0, (2, 2)), "lw": 1.0}) for area in land["areas"]
    ]
    shapes += [(fence, {"ec": FENCE, "ls": (0, (3, 1)), "lw": 1.2}) for fence in land["fences"]]
    for shape, style in shapes:
        match shape.get("region", ()):
            case (x, y, radius):
                patch: Any = Circle((x, y), radius, **style)
            case (x, y, right, top):
                patch = Rectangle((x, y), right - x, top - y, **style)
            case _:
                patch = Polygon(shape["line"], closed=False, **style)
        patch.set(fill=False, zorder=0.8)
        drawn.append(ax.add_patch(patch))
    return drawn


def strip(line: np.ndarray, width: float) -> list[np.ndarray]:
    """Return the corners f64[4, 2] of rectangles along a line f64[k, 2], half a width longer to leave no gaps."""
    out = []
    for a, b in pairwise(line):
        along = (b - a) / max(float(np.hypot(*(b - a))), 1e-30) * width / 2
        aside = np.array([-along[1], along[0]])
        out.append(np.array([a - along + aside, b + along + aside, b + along - aside, a - along - aside]))
    return out
