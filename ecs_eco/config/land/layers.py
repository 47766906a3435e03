"""Reads vector layers through pyogrio, and lays them on the cells of a world: areas on maps, lines as they
are.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.config.land.raster import INSTALL, RasterError
from ecs_eco.config.models.land import Layer
from ecs_eco.config.models.surroundings import Terrain
from ecs_eco.engine.errors import Problem, listed, nearest

Line = np.ndarray  # f64[k, 2]
POINT, LINE, AREA = 1, 2, 3  # of WKB; + 3 for several of them; 7 is a collection
NAMES = {POINT: "points", LINE: "lines", AREA: "areas"}


def lay(terrain: Terrain, folder: Path, frame: Any, kinds: np.ndarray,
        lakes: np.ndarray) -> list[dict[str, Any]]:
    """Mark the lakes and classes of all layers on maps [ny, nx], in their order; return the lines of roads
    and fences in the world [m]. Raises RasterError."""
    lines: list[dict[str, Any]] = []
    for i, layer in enumerate(terrain.layers):
        if frame.place is None:
            raise _refused(i, "file", "given with a raster that does not say where it lies", layer.file,
                           "a raster with coordinates")
        wanted = LINE if layer.make in ("roads", "fences") else AREA
        shapes = shapes_of(layer, folder, frame.raster.crs, i)
        found = [(kind, _to_world(part, frame)) for kind, part in shapes]
        if found and not any(kind == wanted for kind, _ in found):
            raise _refused(i, "file", f"holds {listed(sorted({NAMES[kind] for kind, _ in found}))} alone",
                           layer.file, f"{NAMES[wanted]}, for {layer.make}")
        parts = [part for kind, part in found if kind == wanted]
        if wanted == LINE:
            made: dict[str, Any] = {"make": layer.make}
            if layer.make == "roads":
                made |= {"width": layer.width, "pace": layer.pace, "cost": layer.cost}
            lines += [{**made, "line": piece.round(6).tolist()} for part in parts
                      for piece in within(part, frame.size)]
            continue
        inside = covered(parts, frame)
        if layer.make == "lakes":
            lakes |= inside
        else:
            kinds[inside] = 1 + list(terrain.classes).index(str(layer.land))
    return lines


def shapes_of(layer: Layer, folder: Path, crs: str, number: int) -> Iterator[tuple[int, Line]]:
    """The lines and the rings of areas of a layer, f64[k, 2] in the coordinate system `crs`; raises
    RasterError."""
    try:
        import pyogrio
        from pyogrio.errors import DataLayerError, DataSourceError
        from pyogrio.raw import read
    except ImportError:
        raise _refused(number, "file", "needs pyogrio, which is not installed", layer.file, INSTALL) from None
    path = folder / layer.file
    try:
        names = [str(name) for name, _ in pyogrio.list_layers(path)]
        if layer.layer is not None and layer.layer not in names:
            raise _refused(number, "layer", "no layer of this name", layer.layer, listed(names),
                           nearest(layer.layer, names))
        meta, _, geometry, _ = read(path, layer=layer.layer, columns=[], force_2d=True)
    except (DataSourceError, DataLayerError) as error:
        raise _refused(number, "file", f"cannot be read: {error}", layer.file,
                       "a file that GDAL reads") from None
    own = meta["crs"] or crs
    for shape in geometry:
        for kind, part in () if shape is None else parts_of(shape):
            yield kind, part if own == crs or not crs else _brought(part, own, crs, layer, number)


def _brought(part: Line, own: str, crs: str, layer: Layer, number: int) -> Line:
    try:
        from rasterio.warp import transform
    except ImportError:
        raise _refused(number, "file", f"is in {own}, and the raster in {crs}", layer.file,
                       f"the same coordinate system, or rasterio to change it: {INSTALL}") from None
    return np.array(transform(own, crs, *part.T.tolist())[:2]).T


def parts_of(wkb: bytes) -> list[tuple[int, Line]]:
    """The points, lines and rings in a well-known binary of two coordinates (OGC 06-103r4, section 8)."""
    return _parts(wkb, 0)[0]


def _parts(wkb: bytes, at: int) -> tuple[list[tuple[int, Line]], int]:
    order = "<" if wkb[at] == 1 else ">"
    (kind,) = struct.unpack_from(f"{order}I", wkb, at + 1)
    at += 5

    def corners(n: int) -> Line:
        return np.frombuffer(wkb, f"{order}f8", 2 * n, at).reshape(n, 2).astype(np.float64)

    if kind == POINT:
        return [(POINT, corners(1))], at + 16
    out: list[tuple[int, Line]] = []
    (n,) = struct.unpack_from(f"{order}I", wkb, at)
    at += 4
    if kind == LINE:
        return [(LINE, corners(n))], at + 16 * n
    for _ in range(n):
        if kind == AREA:
            (k,) = struct.unpack_from(f"{order}I", wkb, at)
            at += 4
            out.append((AREA, corners(k)))
            at += 16 * k
        else:
            inner, at = _parts(wkb, at)
            out += inner
    return out, at


def covered(rings: list[Line], frame: Any) -> np.ndarray:
    """Which cells have their centre within areas, bool[ny, nx]: those that a line from there crosses the
    rings an odd number of times, so that holes are holes."""
    out = np.zeros((frame.ny, frame.nx), np.bool_)
    cx = (np.arange(frame.nx) + 0.5) * frame.size[0] / frame.nx
    cy = (np.arange(frame.ny) + 0.5) * frame.size[1] / frame.ny
    for ring in rings:
        low, high = np.searchsorted(cy, [ring[:, 1].min(), ring[:, 1].max()])
        (ax, ay), (bx, by) = ring[:-1].T, ring[1:].T
        for j in range(low, high):
            k = (ay <= cy[j]) != (by <= cy[j])  # the sides that cross this row
            x = ax[k] + (cy[j] - ay[k]) / (by[k] - ay[k]) * (bx[k] - ax[k])
            out[j] ^= np.searchsorted(np.sort(x), cx) % 2 == 1
    return out


def within(line: Line, size: tuple[float, float]) -> list[Line]:
    """The pieces of a line that are in the world (Liang & Barsky 1984)."""
    pieces: list[list[np.ndarray]] = []
    for a, b in pairwise(line):
        way, first, last = b - a, 0.0, 1.0
        for axis in range(2):
            if way[axis] == 0:
                first = first if 0 <= a[axis] <= size[axis] else 2.0
                continue
            t = sorted(((0 - a[axis]) / way[axis], (size[axis] - a[axis]) / way[axis]))
            first, last = max(first, t[0]), min(last, t[1])
        if first >= last:
            continue
        begin, end = a + first * way, b if last == 1.0 else a + last * way
        if pieces and first == 0.0 and np.array_equal(pieces[-1][-1], a):
            pieces[-1].append(end)
        else:
            pieces.append([begin, end])
    return [np.clip(np.array(piece), 0, size) for piece in pieces]


def _to_world(part: Line, frame: Any) -> Line:
    west, south, per_x, per_y = frame.place
    return np.stack([(part[:, 0] - west) / per_x, (part[:, 1] - south) / per_y], 1)


def _refused(number: int, part: str, what: str, value: object, allowed: str = "",
             near: str = "") -> RasterError:
    return RasterError([Problem(("layers", number, part), what, value, allowed, near)])
