"""The land that a world covers: elevations, classes, lakes and lines from rasters and vector layers."""

import glob
import hashlib
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Self

import numpy as np

from ecs_eco.config.land.layers import lay
from ecs_eco.config.land.raster import (
    DAMAGED,
    INSTALL,
    Raster,
    RasterError,
    degrees,
    path_of,
    read_npz,
    read_raster,
    refused,
    require_definition,
    web_mercator,
)
from ecs_eco.config.models.surroundings import Terrain

KEPT = "terrain.npz"  # the land of a run, saved in its folder
WATER, ROCK = 1, 2  # same values as in ecs_eco.space.terrain
# WGS 84: equatorial radius [m] and squared eccentricity [1]
RADIUS, ECCENTRICITY2 = 6_378_137.0, 0.00669437999014
# coordinate systems known to be in meters on the ground: UTM and national grids
TRUE_METRES = re.compile(
    r"EPSG:(32[67](0[1-9]|[1-5]\d|60)|258(2[89]|3[0-8])|269(0[1-9]|1\d|2[0-3])|2056|2154|2193|3006|3067|27700|28992)"
    r'|\s*PROJC(S|RS)\["[^"]*UTM[ _]zone[ _]\d+[NS]".*|\s*\+proj=utm (?!.*(units=(?!m\b)|to_meter)).*',
    re.IGNORECASE | re.DOTALL,
)
Place = tuple[float, float, float, float]  # x and y of the world's corner, and their increase per meter


@dataclass(frozen=True)
class Land:
    """Land: elevations f32[ny, nx] [m], southernmost row first; classes u8[ny, nx], 0 for none and i + 1 for
    class i; lakes from vector layers; and the lines of roads and fences."""

    elevation: np.ndarray
    kinds: np.ndarray
    lakes: np.ndarray
    lines: list[dict[str, Any]] = field(default_factory=list)
    place: Place | None = None  # in units of `crs`
    crs: str = ""

    @cached_property
    def sha256(self) -> str:
        """The hash of the land."""
        h = hashlib.sha256(json.dumps([self.lines, self.place, self.crs]).encode())
        for array in (self.elevation, self.kinds, self.lakes):
            h.update(str((array.shape, array.dtype.str)).encode())
            h.update(np.ascontiguousarray(array).tobytes())
        return h.hexdigest()

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the land as plain arrays."""
        text = json.dumps({"lines": self.lines, "place": self.place, "crs": self.crs, "sha256": self.sha256})
        return {
            "elevation": self.elevation,
            "kinds": self.kinds,
            "lakes": self.lakes,
            "about": np.array(text),
        }

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """Return the land from the result of `arrays()`."""
        about = json.loads(str(arrays["about"]))
        west, south, per_x, per_y = map(float, about["place"] or [0, 0, 1, 1])
        place = None if about["place"] is None else (west, south, per_x, per_y)
        return cls(arrays["elevation"], arrays["kinds"], arrays["lakes"], about["lines"], place, about["crs"])

    def part(self, nx: int, ny: int) -> Self:
        """Return the southwest part with nx × ny cells; raise RasterError if the land is smaller."""
        if (ny, nx) == self.elevation.shape:
            return self
        has = self.elevation.shape
        if nx > has[1] or ny > has[0]:
            saved = f"this run saved {has[1]} × {has[0]} cells, but the world has {nx} × {ny}"
            allowed = "the original space.size, or a smaller one"
            raise refused("raster", f"smaller than the world: {saved}", "", allowed)
        cut = {name: getattr(self, name)[:ny, :nx] for name in ("elevation", "kinds", "lakes")}
        return replace(self, **cut)

    def coordinates(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Convert positions in the world [m] to units of `crs`, if the land's location is known."""
        if self.place is None:
            return x, y
        west, south, per_x, per_y = self.place
        return west + x * per_x, south + y * per_y


def read_land(terrain: Terrain, size: Sequence[float], folder: Path) -> Land:
    """Read the land of a world or, in the folder of a run, the land that the run saved.

    Raises a RasterError with keys relative to `terrain`.
    """
    if (folder / KEPT).is_file() and (folder / "manifest.json").is_file():
        return kept_land(folder).part(*cells(terrain, size))
    names = [terrain.raster, terrain.cover, *(layer.file for layer in terrain.layers)]
    stamps = tuple(stamp for name in names if name for stamp in _stamps(name, folder))
    return _read(terrain.model_dump_json(), tuple(size[:2]), folder, stamps)


def kept_land(folder: Path) -> Land:
    """Return the land saved in the folder of a run; raise RasterError if the file is damaged."""
    try:
        arrays = read_npz(folder / KEPT)
        land = Land.of(arrays)
        require_definition(land.crs)
        if json.loads(str(arrays["about"]))["sha256"] == land.sha256:
            return land
    except RasterError as error:
        raise RasterError([p.moved(source=str(folder / KEPT)) for p in error.problems]) from None
    except DAMAGED as error:
        raise refused("raster", f"cannot read the land of this run: {error}", str(folder / KEPT)) from None
    raise refused(
        "raster", "the saved land of this run was changed", str(folder / KEPT), "the unchanged file"
    )


def cells(terrain: Terrain, size: Sequence[float]) -> tuple[int, int]:
    """Return the number of cells of the height map along x and y."""
    return max(1, round(size[0] / terrain.cell)), max(1, round(size[1] / terrain.cell))


def _stamps(name: str, folder: Path) -> list[tuple[str, int, int]]:
    """Return names, times and sizes of a file and of those that belong to it, such as .prj and .dbf."""
    try:
        path = path_of(name, folder)
        files = [(file.name, file.stat()) for file in path.parent.glob(f"{glob.escape(path.stem)}.*")]
    except (OSError, ValueError, RasterError):
        return []
    return sorted((file, status.st_mtime_ns, status.st_size) for file, status in files)


@lru_cache(maxsize=8)
def _read(text: str, size: tuple[float, float], folder: Path, stamps: tuple[Any, ...]) -> Land:
    """Read the land of a `terrain` section in JSON; `stamps` prevents the cache from returning outdated land."""
    terrain = Terrain.model_validate_json(text)
    assert terrain.raster is not None
    raster = read_raster(terrain.raster, folder, terrain.band, terrain.crs)
    frame = Frame(terrain, size, raster)
    raw = frame.elevations(terrain.missing)
    kinds = np.zeros(raw.shape, np.uint8)
    codes = _codes(terrain, folder, frame) if terrain.cover else None
    north, east = np.gradient(raw, frame.side) if min(raw.shape) > 1 else np.zeros((2, *raw.shape))
    rise = np.sqrt(north * north + east * east)
    for i, land in enumerate(terrain.classes.values()):
        conditions = [
            *([np.isin(codes, land.codes)] if land.codes and codes is not None else []),
            *([raw >= land.above] if land.above is not None else []),
            *([raw < land.below] if land.below is not None else []),
            *([rise >= land.steeper] if land.steeper is not None else []),
        ]
        if conditions:  # a class without conditions applies only to areas of a layer
            kinds[np.logical_and.reduce(conditions)] = i + 1
    lakes, lines = np.zeros(raw.shape, np.bool_), []
    if terrain.layers:
        lines = lay(terrain, folder, frame, kinds, lakes)
    return Land(
        (raw * (terrain.vertical or 1.0)).astype(np.float32), kinds, lakes, lines, frame.place, raster.crs
    )


class Frame:
    """The positions of a world's height-map cells in a raster."""

    def __init__(self, terrain: Terrain, size: Sequence[float], raster: Raster) -> None:
        self.raster, scale = raster, terrain.scale or 1.0
        self.nx, self.ny = cells(terrain, size)
        self.size = float(size[0]), float(size[1])
        self.side = terrain.cell / scale  # [m] in the real landscape
        corner = terrain.corner or [0.0, 0.0]
        per_x, per_y = metres(raster)
        dx, dy = (
            (self.side, self.side)
            if raster.dx is None or raster.dy is None
            else (raster.dx * per_x, raster.dy * per_y)
        )
        rows, columns = raster.values.shape
        wide, high = columns * dx, rows * dy
        need = [size[0] / scale + corner[0], size[1] / scale + corner[1]]
        if need[0] > wide * (1 + 1e-6) or need[1] > high * (1 + 1e-6):
            raise _smaller(terrain, raster, (wide, high), need, scale)
        # centers of the cells, in raster cells from its west and south edges
        self.x = ((np.arange(self.nx) + 0.5) * size[0] / self.nx / scale + corner[0]) / dx
        self.y = ((np.arange(self.ny) + 0.5) * size[1] / self.ny / scale + corner[1]) / dy
        self.place: Place | None = None
        if raster.west is not None and raster.north is not None and raster.dx and raster.dy:
            south = raster.north - rows * raster.dy
            self.place = (
                raster.west + corner[0] / per_x,
                south + corner[1] / per_y,
                1 / scale / per_x,
                1 / scale / per_y,
            )

    def elevations(self, missing: float | None) -> np.ndarray:
        """Return linearly interpolated elevations f64[ny, nx] [m] at cell centers."""
        values = self.raster.values[::-1]
        if missing is not None:
            values = np.where(np.isnan(values), missing, values)
        out = _between(_between(values, self.y).T, self.x).T
        if (gaps := np.argwhere(np.isnan(out))).size:
            j, i = gaps[0]
            column, row = int(self.x[i]), len(values) - 1 - int(self.y[j])
            raise refused(
                "raster",
                f"{len(gaps):,} cells of the world have no elevation; the first is at "
                f"column {column + 1}, row {row + 1} of the raster",
                float("nan"),
                "a part without gaps (`corner`, space.size), or `missing`, an elevation for such cells [m]",
            )
        return out

    def nearest(self, other: Raster, part: str) -> np.ndarray:
        """Return the values f64[ny, nx] of another raster at cell centers. Raises RasterError."""
        own, values = self.raster, other.values[::-1]
        if other.west is None or own.west is None or self.place is None:
            if values.shape != own.values.shape:
                fault = f"has {values.shape[1]} × {values.shape[0]} cells and no coordinates"
                allowed = f"as many cells as `raster`: {own.values.shape[1]} × {own.values.shape[0]}"
                raise refused(part, fault, "", allowed)
            return _picked(values, self.x, self.y)
        if other.crs and own.crs and other.crs != own.crs:
            allowed = f"{own.crs}, as in `raster`; convert it with gdalwarp -t_srs"
            raise refused(part, "has a different coordinate system", other.crs, allowed)
        dx, dy = _whole(other.dx), _whole(other.dy)
        x = (own.west + self.x * _whole(own.dx) - other.west) / dx
        south = _whole(own.north) - len(own.values) * _whole(own.dy)
        y = (south + self.y * _whole(own.dy) - (_whole(other.north) - len(values) * dy)) / dy
        if min(x[0], y[0]) < -1e-6 or x[-1] > values.shape[1] + 1e-6 or y[-1] > len(values) + 1e-6:
            raise refused(part, "does not cover the world", "", "a raster of the same land")
        return _picked(values, x, y)


def _picked(values: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the values at x and y, which are measured in cells from the first column and row."""
    rows, columns = (at.astype(np.int64).clip(0, n - 1) for at, n in zip((y, x), values.shape, strict=True))
    return values[np.ix_(rows, columns)]


def metres(raster: Raster) -> tuple[float, float]:
    """Return the number of meters per unit of x and y; for degrees and Web Mercator, on the WGS 84 ellipsoid
    at the middle latitude (Snyder 1987, pages 25 and 41).

    Raises RasterError if the middle latitude is unknown or if units differ greatly from meters on the ground.
    """
    mercator = web_mercator(raster.crs)
    if not mercator and (not raster.crs or not degrees(raster.crs)):
        _require_metres(raster)
        return 1.0, 1.0
    if raster.north is None:
        fault = f"is in {raster.crs[:40]} but has no coordinates, so its latitude is unknown"
        raise refused("raster", fault, "", "a raster with coordinates, or a raster in meters")
    middle = raster.north - len(raster.values) * _whole(raster.dy) / 2
    most = math.pi * RADIUS if mercator else 90.0
    if not abs(middle) < most:
        fault = f"is {middle:g} {'meters' if mercator else 'degrees'} north of the equator"
        raise refused("raster", fault, raster.crs, f"-{most:.10g} to {most:.10g}")
    if mercator:
        north = middle / RADIUS
        cosine = 1 / _cosine(-north * north)
        x, y = _lengths(cosine, 1.0)
        return x, y * cosine
    return _of_degrees(middle)


def _of_degrees(latitude: float) -> tuple[float, float]:
    angle = latitude * math.pi / 180
    return _lengths(_cosine(angle * angle), math.pi / 180 * RADIUS)


def _lengths(cosine: float, unit: float) -> tuple[float, float]:
    """Return the meters east and north that an angle spans; `unit` is its length [m] at the equator."""
    curved = 1 - ECCENTRICITY2 * (1 - cosine * cosine)
    long = unit / math.sqrt(curved)
    return long * cosine, long * (1 - ECCENTRICITY2) / curved


def _require_metres(raster: Raster) -> None:
    """Raise RasterError if, according to rasterio, a raster's meters are not meters on the ground."""
    if not raster.crs or raster.north is None or raster.west is None:
        return
    try:
        from rasterio.warp import transform
    except ImportError:
        if TRUE_METRES.fullmatch(raster.crs):
            return
        fault = f"is in {raster.crs[:40]}; only rasterio, which is not installed, can check its unit"
        raise refused("raster", fault, "", f"UTM, such as EPSG:32616, or degrees; or {INSTALL}") from None
    rows, columns = raster.values.shape
    dx, dy = _whole(raster.dx), _whole(raster.dy)
    x, y = raster.west + columns * dx / 2, raster.north - rows * dy / 2
    try:
        east, north = transform(raster.crs, "EPSG:4326", [x - dx, x + dx, x, x], [y, y, y - dy, y + dy])[:2]
    except Exception as error:  # GDAL raises many types of errors
        raise refused(
            "raster",
            f"is in {raster.crs[:40]}, which cannot be converted to degrees: {error}",
            "",
            "a coordinate system of a place on Earth",
        ) from None
    per_x, per_y = _of_degrees(sum(north) / 4)
    for k, side in ((0, dx), (2, dy)):
        metre = math.hypot((east[k + 1] - east[k]) * per_x, (north[k + 1] - north[k]) * per_y) / (2 * side)
        if math.isfinite(metre) and abs(metre - 1) > 0.05:
            fault = f"a meter of {raster.crs[:40]} is {metre:.3g} m on the ground here"
            allowed = "a coordinate system in meters on the ground, such as UTM; convert it with gdalwarp"
            raise refused("raster", fault, "", allowed)


def _cosine(square: float) -> float:
    """Return the cosine of an angle of at most π/2 [rad] from its square, or the hyperbolic cosine if the
    square is negative. The power series gives the same bits on every machine."""
    term = total = 1.0
    for k in range(1, 30, 2):
        term *= -square / (k * (k + 1))
        total += term
    return total


def _whole(value: float | None) -> float:
    assert value is not None
    return value


def _codes(terrain: Terrain, folder: Path, frame: Frame) -> np.ndarray:
    assert terrain.cover is not None
    try:
        other = read_raster(terrain.cover, folder, terrain.cover_band)
    except RasterError as error:
        at = {"raster": "cover", "band": "cover_band", "crs": "cover"}
        raise RasterError(
            [p.moved(key=tuple(at.get(str(k), k) for k in p.key)) for p in error.problems]
        ) from None
    return np.nan_to_num(frame.nearest(other, "cover"), nan=-(2.0**40)).astype(np.int64)


def _between(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Interpolate the rows of a map linearly at positions measured in rows from its edge."""
    at = np.clip(places - 0.5, 0, len(values) - 1)
    near = np.round(at)
    at = np.where(np.abs(at - near) < 1e-6, near, at)
    low = np.floor(at).astype(np.int64)
    share = (at - low)[:, None]
    high = np.where(share[:, 0] > 0, np.minimum(low + 1, len(values) - 1), low)
    out: np.ndarray = (1 - share) * values[low] + share * values[high]
    return out


def _smaller(
    terrain: Terrain, raster: Raster, has: tuple[float, float], need: list[float], scale: float
) -> RasterError:
    corner = terrain.corner or [0.0, 0.0]
    most = [max(0.0, (has[k] - corner[k]) * scale) for k in range(2)]
    hint = ""
    if raster.dx is not None and not raster.crs and max(_whole(raster.dx), _whole(raster.dy)) < 0.1:
        hint = ', or crs = "EPSG:4326" if its unit is degrees'
    fault = (
        f"smaller than the world: it covers {has[0]:,.6g} × {has[1]:,.6g} m, but the world needs "
        f"{need[0]:,.6g} × {need[1]:,.6g} m"
    )
    return refused("raster", fault, terrain.raster, f"space.size up to [{most[0]:.6g}, {most[1]:.6g}]{hint}")
