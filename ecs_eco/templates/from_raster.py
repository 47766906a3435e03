"""Write a starter world based on an elevation raster."""

from __future__ import annotations

import json
import math
import os
import re
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.config import load
from ecs_eco.config.land.land import metres
from ecs_eco.config.land.raster import Raster, RasterError, read_raster
from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.engine.files import write

TEMPLATE = Path(__file__).parent / "land" / "land.toml"
MOST_CELLS = 600  # maximum along each side; for a larger raster, the middle is used
SITES = 15_000  # number of grass tufts
CLASS = (
    "[terrain.classes.{name}]\n{where}\ngrowth = {growth}                      # multiplier for grass growth\n"
    "pace = {pace}                        # multiplier for walking speed\n"
    'shelter = {shelter}                     # share of attacks that fail\ncolor = "{color}"\n\n'
)


def world_from_raster(
    raster: str,
    out: str | Path | None = None,
    *,
    band: int | str | None = None,
    cell: float | None = None,
    crs: str | None = None,
) -> Path:
    """Write a world file based on the elevations of a raster, and return its path.

    By default, the file is named after the raster and is in the current folder. `cell` [m] is required if the
    raster does not specify its cell size. Raises ConfigError for invalid input, or if the file exists.
    """
    try:
        own = re.match(r"[A-Za-z_]\w+:", raster)
        held = read_raster(*(raster, Path()) if own else (Path(raster).name, Path(raster).parent), band, crs)
        per = metres(held)
    except RasterError as error:
        raise ConfigError(
            [
                p.moved(key=(), source="RASTER" if p.key == ("raster",) else f"--{p.key[0]}")
                for p in error.problems
            ],
            "unusable raster",
        ) from None
    name = _name(raster)
    path = Path(f"{name}.toml") if out is None else Path(out)
    if path.suffix != ".toml" or path.exists():
        what = "already exists" if path.exists() else "is not the name of a world file"
        raise ConfigError([Problem((), what, str(path), "a new file ending in .toml", source="FILE")])
    side = _side(held, per, cell)
    there = raster if own else os.path.relpath(raster, path.parent)
    if there.startswith(".."):
        near = str(Path(raster).with_name(path.name))
        what = "is neither in the raster's folder nor in a folder above it"
        raise ConfigError([Problem((), what, str(path), near, source="FILE")])
    keys = {"raster": Path(there).as_posix(), "file": path.as_posix()}
    text = TEMPLATE.read_text(encoding="utf-8").format(**keys, **_values(held, per, side, name, band, crs))
    write(path, re.sub(r"\n\n(cell = )", r"\n\1", text))
    try:
        load(path)
    except ConfigError:
        path.unlink()
        raise
    return path


def _side(raster: Raster, per: tuple[float, float], cell: float | None) -> float:
    """Return the cell size of the height map [m]."""
    if cell is not None:
        return cell
    if raster.dx is None or raster.dy is None:
        raise ConfigError(
            [
                Problem(
                    (),
                    "is missing: the raster does not specify its cell size",
                    allowed="the cell size [m], such as --cell 30",
                    source="--cell",
                )
            ]
        )
    return float(f"{min(raster.dx * per[0], raster.dy * per[1]):.3g}")


def _values(
    raster: Raster, per: tuple[float, float], side: float, name: str, band: int | str | None, crs: str | None
) -> dict[str, Any]:
    """Return the values that complete the template."""
    dx, dy = (
        (side, side) if raster.dx is None or raster.dy is None else (raster.dx * per[0], raster.dy * per[1])
    )
    ny, nx = raster.values.shape
    n = [min(MOST_CELLS, math.floor(k * d / side + 1e-6)) for k, d in ((nx, dx), (ny, dy))]
    size = [round(k * side, 6) for k in n]
    corner = [
        round(max(0.0, (k * d - s) // 2 // side * side), 6)
        for k, d, s in ((nx, dx, size[0]), (ny, dy, size[1]))
    ]
    if min(n) < 4:
        raise ConfigError(
            [Problem((), f"leaves {n[0]} × {n[1]} cells", side, "a smaller cell size", source="--cell")]
        )
    first = [round(c / d) for c, d in zip(corner, (dx, dy), strict=True)]
    last = [f + math.ceil(s / d) for f, s, d in zip(first, size, (dx, dy), strict=True)]
    part = raster.values[::-1][first[1] : last[1], first[0] : last[0]]
    lowest = float(np.nanmin(part))
    own: dict[str, Any] = {
        "band": band,
        "crs": crs,
        "corner": corner if any(corner) else None,
        "missing": lowest if np.isnan(part).any() else None,
    }
    part = np.where(np.isnan(part), lowest, part)
    grass = _round(max(side, math.sqrt(size[0] * size[1] / SITES)))
    written = "\n".join(f"{key} = {json.dumps(value)}" for key, value in own.items() if value is not None)
    return {
        "name": name,
        "title": f"Deer on the land of {name.replace('-', ' ')}",
        "width": size[0],
        "height": size[1],
        "cell": side,
        "keys": written,
        "drainage": _drainage(part, size),
        "classes": _classes(part, (dx, dy)),
        **_living(grass, size),
    }


def _drainage(part: np.ndarray, size: list[float]) -> str:
    """Return the drainage: a sea if part of the land is below 0, lakes in deep hollows, and streams where at
    least a hundredth of the land drains."""
    sea = "sea = 0.0, " if 0.01 < float((part <= 0).mean()) < 0.9 else ""
    deep = _round(max(1.0, 0.01 * float(np.ptp(part))))
    return f"{{ {sea}depth = {deep}, stream = {_round(0.01 * size[0] * size[1])} }}"


def _classes(part: np.ndarray, sides: tuple[float, float]) -> str:
    """Return the classes: wood above the median elevation, heath above the 85th percentile, and steep ground."""
    land = part[part > 0] if (part > 0).any() else part
    wood, heath = (_round(float(np.percentile(land, q))) for q in (50, 85))
    steep = _round(float(np.percentile(np.hypot(*np.gradient(part, sides[1], sides[0])), 95)))
    made = [
        ("wood", f"above = {wood}", 0.8, 0.9, 0.5, "#7c9a68"),
        ("heath", f"above = {heath}", 0.5, 1.0, 0.1, "#b9a77c"),
        ("steep", f"steeper = {max(steep, 1e-3)}", 0.3, 0.6, 0.2, "#a39a8e"),
    ]
    if wood >= heath:
        made = made[2:]
    return "".join(
        CLASS.format(name=n, where=w, growth=g, pace=p, shelter=s, color=c) for n, w, g, p, s, c in made
    )


def _living(spacing: float, size: list[float]) -> dict[str, Any]:
    """Return the numbers of the starter meadow (2 m sites, 1 s ticks), converted to this scale.

    Lengths and times are scaled by the same factor, so speeds stay the same.
    """
    by = spacing / 2
    sites = round(size[0] / spacing) * round(size[1] / spacing)
    lengths = {"patch": 0.3, "reach": 0.1, "radius": 6.0, "dispersal": 1.0}
    rates = {"spread": 0.04, "rain": 0.0005, "basal": 0.004, "walk": 0.006, "turn": 0.8, "birth": 0.005}
    times = {"dt": 1.0, "old": 1200.0, "adult": 100.0}
    return (
        {k: _round(v * by) for k, v in {**lengths, **times}.items()}
        | {k: _round(v / by, 4) for k, v in rates.items()}
        | {
            "spacing": spacing,
            "chance": _round(1 - 0.8 ** (1 / by), 4),
            "grass": round(0.4 * sites),
            "deer": round(0.075 * sites),
        }
    )


def _round(value: float, digits: int = 2) -> float:
    return float(f"{value:.{digits}g}")


def _name(raster: str) -> str:
    stem = re.sub(r"[^A-Za-z0-9]+", "-", Path(raster.rpartition(":")[2]).stem).strip("-")[:40]
    return stem if stem[:1].isalpha() else f"land-{stem}".rstrip("-")
