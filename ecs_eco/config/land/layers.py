"""Read vector layers (GeoJSON directly, other formats through pyogrio) and map them onto a world's cells."""

import glob
import io
import json
import re
import struct
import warnings
import zipfile
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.config.land.raster import FARTHEST, INSTALL, RasterError, degrees, path_of, refused
from ecs_eco.config.models.land import Layer
from ecs_eco.config.models.surroundings import Terrain
from ecs_eco.engine.errors import listed, nearest
from ecs_eco.engine.files import read_bytes

Line = np.ndarray  # f64[k, 2]
Content = tuple[str, list[str], list[tuple[int, Line]]]
POINT, LINE, AREA = 1, 2, 3  # WKB type codes; Multi types are 3 higher; 7 is a collection
BEGINNINGS = {
    ".gpkg": b"SQLite format 3\0",
    ".shp": b"\0\0\x27\n",
    ".fgb": b"fgb\x03fgb",
    ".geojson": b"{",
    ".json": b"{",
}
SHAPES = {
    "Point": (POINT, 0),
    "MultiPoint": (POINT, 1),
    "LineString": (LINE, 0),
    "MultiLineString": (LINE, 1),
    "Polygon": (AREA, 1),
    "MultiPolygon": (AREA, 2),
}
"""GeoJSON shapes, and the nesting depth of their lines."""
LINES = ("roads", "fences")  # layers made of lines
NAMES = {POINT: "points", LINE: "lines", AREA: "areas"}


def lay(
    terrain: Terrain, folder: Path, frame: Any, kinds: np.ndarray, lakes: np.ndarray
) -> list[dict[str, Any]]:
    """Mark lakes and classes on the maps [ny, nx], and return roads and fences [m]. Raises RasterError."""
    lines: list[dict[str, Any]] = []
    for i, layer in enumerate(terrain.layers):
        try:
            parts = _parts_of_layer(layer, folder, frame)
        except RasterError as error:
            (problem,) = error.problems
            key = ("layers", i, "layer" if problem.key == ("layer",) else "file")
            raise RasterError([problem.moved(key=key)]) from None
        if layer.make in LINES:
            strip = {"width": layer.width, "pace": layer.pace, "cost": layer.cost}
            made = {"make": layer.make, **(strip if layer.make == "roads" else {})}
            pieces = [piece for part in parts for piece in within(part, frame.size)]
            lines += [{**made, "line": piece.round(6).tolist()} for piece in pieces]
        elif layer.make == "lakes":
            lakes |= covered(parts, frame)
        else:
            kinds[covered(parts, frame)] = 1 + list(terrain.classes).index(str(layer.land))
    return lines


def _parts_of_layer(layer: Layer, folder: Path, frame: Any) -> list[Line]:
    """Return the lines or areas that a layer uses, in world coordinates [m]."""
    if frame.place is None:
        fault = "needs a raster with coordinates, but `raster` has none"
        raise refused("file", fault, layer.file, "a raster with coordinates")
    wanted, found = LINE if layer.make in LINES else AREA, [*_shapes(layer, folder, frame.raster.crs)]
    if found and not any(kind == wanted for kind, _ in found):
        fault = f"contains only {listed(sorted({NAMES[kind] for kind, _ in found}))}"
        raise refused("file", fault, layer.file, f"{NAMES[wanted]}, for {layer.make}")
    return [(part - frame.place[:2]) / frame.place[2:] for kind, part in found if kind == wanted]


def _shapes(layer: Layer, folder: Path, crs: str) -> Iterator[tuple[int, Line]]:
    """Yield a layer's lines and the rings of its areas, f64[k, 2] in the coordinate system `crs`."""
    try:
        own, names, shapes = _content(path_of(layer.file, folder), layer.layer)
        if layer.layer is not None and layer.layer not in names:
            fault = "no layer with this name"
            raise refused("layer", fault, layer.layer, listed(names), nearest(layer.layer, names))
        if crs and own and own != crs:
            degrees(own)  # raises RasterError for an unknown coordinate system
            shapes = [(kind, _brought(part, own, crs, layer)) for kind, part in shapes]
    except ImportError:
        raise refused("file", "needs pyogrio, which is not installed", layer.file, INSTALL) from None
    except RasterError:
        raise
    except Exception as error:  # GDAL raises many types of errors
        fault = f"cannot be read: {getattr(error, 'strerror', None) or error}"
        raise refused("file", fault, layer.file, f"a file ending in {listed(BEGINNINGS)}") from None
    for kind, part in shapes:
        if not (np.abs(part) <= FARTHEST).all():  # also rejects NaN
            fault = "has coordinates that are impossible on Earth"
            allowed = f"coordinates in meters or degrees, up to {FARTHEST:g}"
            raise refused("file", fault, layer.file, allowed)
        if len(part):  # "POLYGON EMPTY" has no corners
            yield kind, part


def _content(path: Path, layer: str | None) -> Content:
    """Return a file's coordinate system ("" if unknown), the names of its layers, and the shapes of one layer
    (empty if the layer does not exist).

    GDAL receives the file's bytes (for the several files of a Shapefile, those of a ZIP archive), and only if
    the file begins as its format requires. Otherwise, GDAL would choose among all its drivers, and some of
    them open addresses given in a file or in its path.
    """
    kind = path.suffix.lower()
    content = read_bytes(path)
    if kind not in BEGINNINGS or not content.lstrip().startswith(BEGINNINGS[kind]):
        raise ValueError("has a different file format")
    if kind in (".geojson", ".json"):
        return _of_geojson(json.loads(content), path.stem, layer)
    import pyogrio
    from pyogrio.raw import read

    if kind == ".shp":
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as parts:
            for other in path.parent.glob(f"{glob.escape(path.stem)}.*"):
                if other.suffix.lower() in (".shp", ".shx", ".dbf", ".prj", ".cpg"):
                    parts.writestr(f"{path.stem}{other.suffix.lower()}", read_bytes(other))
        content = packed.getvalue()
    with warnings.catch_warnings(action="ignore"):  # bytes have no file name extension, which GDAL expects
        names = [str(name) for name, _ in pyogrio.list_layers(content)]
        if not names or layer not in (None, *names):
            return "", names, []
        meta, _, geometry, _ = read(content, layer=layer or names[0], columns=[], force_2d=True)
    shapes = [part for shape in geometry if shape is not None for part in parts_of(shape)]
    return meta["crs"] or "", names, shapes


def _of_geojson(data: Any, stem: str, layer: str | None) -> Content:
    """Return the same for GeoJSON (RFC 7946), which can name its coordinate system as in its version of 2008."""
    crs = data.get("crs") or {"type": "name", "properties": {"name": "EPSG:4326"}}
    if crs["type"] != "name":
        raise ValueError("links to its coordinate system")
    name = re.sub(r"^urn:ogc:def:crs:(\w+):[^:]*:", r"\1:", crs["properties"]["name"])
    features = data["features"] if data["type"] == "FeatureCollection" else [data]
    shapes = [f["geometry"] if f["type"] == "Feature" else f for f in features]
    names = [str(data.get("name", stem))]
    parts = [part for shape in shapes if shape is not None for part in _of_shape(shape)]
    return "EPSG:4326" if name == "OGC:CRS84" else name, names, parts if layer in (None, *names) else []


def _of_shape(shape: Any) -> list[tuple[int, Line]]:
    if shape["type"] == "GeometryCollection":
        return [part for inner in shape["geometries"] for part in _of_shape(inner)]
    kind, deep = SHAPES[shape["type"]]
    lists = [shape["coordinates"]]
    for _ in range(deep):
        lists = [inner for outer in lists for inner in outer]
    lines = [[point] for point in lists] if kind == POINT else lists
    return [(kind, np.array([corner[:2] for corner in line], np.float64).reshape(-1, 2)) for line in lines]


def _brought(part: Line, own: str, crs: str, layer: Layer) -> Line:
    try:
        from rasterio.warp import transform
    except ImportError:
        allowed = f"the same coordinate system, or rasterio to convert it: {INSTALL}"
        raise refused("file", f"is in {own}, but the raster is in {crs}", layer.file, allowed) from None
    return np.array(transform(own, crs, *part.T.tolist())[:2]).T


def parts_of(wkb: bytes) -> list[tuple[int, Line]]:
    """Return the points, lines and rings of two-dimensional well-known binary (OGC 06-103r4, section 8)."""
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
    if kind > 7:
        raise ValueError(f"has shapes other than points, lines and areas: type {kind} of well-known binary")
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
    """Return whether each cell's center is within the areas, bool[ny, nx].

    A center is inside if a ray from it crosses the rings an odd number of times, so holes remain holes.
    """
    out = np.zeros((frame.ny, frame.nx), np.bool_)
    cx = (np.arange(frame.nx) + 0.5) * frame.size[0] / frame.nx
    cy = (np.arange(frame.ny) + 0.5) * frame.size[1] / frame.ny
    for ring in rings:
        low, high = np.searchsorted(cy, [ring[:, 1].min(), ring[:, 1].max()])
        (ax, ay), (bx, by) = ring[:-1].T, ring[1:].T
        for j in range(low, high):
            k = (ay <= cy[j]) != (by <= cy[j])  # edges that cross this row
            x = ax[k] + (cy[j] - ay[k]) / (by[k] - ay[k]) * (bx[k] - ax[k])
            out[j] ^= np.searchsorted(np.sort(x), cx) % 2 == 1
    return out


def within(line: Line, size: tuple[float, float]) -> list[Line]:
    """Return the parts of a line that lie inside the world (Liang & Barsky 1984)."""
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
