"""Read rasters: NumPy's .npz and ESRI ASCII grids directly, and GeoTIFF and other formats through rasterio.

Files may be untrusted. They must be regular files in the folder of their world or a subfolder. GDAL receives
only their bytes and the one driver that they need, so it opens no other file and sends no request.
"""

import importlib.util
import io
import os
import re
import tokenize
import warnings
import zipfile
import zlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest
from ecs_eco.engine.files import MOST_BYTES, read_bytes

MOST_CELLS = 100_000_000
MOST_OF_CRS = 100_000  # [bytes]
INSTALL = 'pip install -e ".[geo]" in the source folder'
EXAMPLE = 'such as "EPSG:4326" or "EPSG:32616"'
SYNTAX = re.compile(r"\w+:[\w:.,+-]*|\s*\w+\s*\[.*|\s*\+.*", re.DOTALL)
# addresses, and files that PROJ would open, except "nadgrids=@null", which means no grid
OPENED = re.compile(
    r'://|grids\b(?!=@null(?![^\s"]))|PARAMETERFILE|\b(file|model|catalog)\s*=|\binit\s*=(?!epsg:\d+(?!\S))',
    re.IGNORECASE,
)
# common coordinate systems in degrees
DEGREES = ("EPSG:4326", "OGC:CRS84", "EPSG:4269", "EPSG:4258", "EPSG:4979")
DAMAGED = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    EOFError,
    NotImplementedError,
    RuntimeError,
    SyntaxError,
    MemoryError,
    OverflowError,
    tokenize.TokenError,
    zlib.error,
    zipfile.BadZipFile,
)
"""Errors that numpy raises for an invalid .npz file."""
GDAL = {
    ".tif": "GTiff",
    ".tiff": "GTiff",
    ".hgt": "SRTMHGT",
    ".dem": "USGSDEM",
    ".dt0": "DTED",
    ".dt1": "DTED",
    ".dt2": "DTED",
}  # drivers that read a single file and follow no file names in it
KINDS = f"a file ending in .npz, .asc or, with rasterio, in {listed(GDAL)}"
FARTHEST = 1e9  # maximum coordinate, in meters or degrees: the Earth's circumference is 4e7 m
LATITUDES, LONGITUDES = ("latitude", "lat", "y"), ("longitude", "lon", "x")


class Raster(NamedTuple):
    """Numbers on a grid, f64[ny, nx], northernmost row first; NaN means no value.

    `west` and `north` are the outer edges and `dx`, `dy` the sides of a cell, in units of `crs`; all four are
    None if the file does not state them. `crs` is "" if unknown.
    """

    values: np.ndarray
    west: float | None = None
    north: float | None = None
    dx: float | None = None
    dy: float | None = None
    crs: str = ""


class RasterError(ConfigError):
    """Error for a raster that cannot be read; the key of its problem is "raster", "band" or "crs"."""


def refused(part: str, what: str, value: object, allowed: str = "", near: str = "") -> RasterError:
    """Return the error for one problem."""
    return RasterError([Problem((part,), what, value, allowed, near)])


def path_of(name: str, folder: Path) -> Path:
    """Return the path of a raster: a file in `folder` or, for "package:path", in an installed package. Raises
    RasterError if the package does not exist or the file is outside the folder."""
    package, colon, rest = name.partition(":")
    if not (colon and re.fullmatch(r"[A-Za-z_]\w+", package)):
        return _below(folder, name, name)
    try:
        spec = importlib.util.find_spec(package)
    except (ImportError, ValueError):
        spec = None
    if spec is None or not spec.submodule_search_locations:
        raise refused("raster", f"the package {package} is not installed", name, "a file, or package:path")
    return _below(Path(next(iter(spec.submodule_search_locations))), rest, name)


def _below(folder: Path, rest: str, name: str) -> Path:
    """Return the path of a file in a folder; raise RasterError if it is outside, even through links."""
    path = folder / rest
    if "\0" in name:
        raise refused("raster", "cannot be read: not a file name", name, KINDS)
    if not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder)):
        allowed = "a file in the folder of the world file, or a subfolder"
        raise refused("raster", "is outside the world's folder", name, allowed)
    return path


def read_raster(name: str, folder: Path, band: int | str | None = None, crs: str | None = None) -> Raster:
    """Read one band of a raster file; `crs` is used if the file does not state one. Raises RasterError."""
    path = path_of(name, folder)
    try:
        os.stat(path)  # a missing file is reported before a missing package
        own = {".npz": _of_npz, ".asc": _of_ascii, ".grd": _of_ascii}
        raster = own.get(path.suffix.lower(), _of_gdal)(path, band)
    except OSError as error:
        raise refused("raster", f"cannot be read: {error.strerror or error}", name, KINDS) from None
    if raster.values.size == 0 or min(raster.values.shape) < 2:
        fault = f"has {raster.values.shape[1]} × {raster.values.shape[0]} cells"
        raise refused("raster", fault, name, "at least 2 cells along each side")
    raster = raster if crs is None or raster.crs else raster._replace(crs=crs)
    require_definition(raster.crs)
    _check_place(raster, name)
    return raster


def _check_place(raster: Raster, name: str) -> None:
    """Raise RasterError for a raster with coordinates that are impossible on Earth."""
    for word, value in (("west", raster.west), ("north", raster.north)):
        if value is not None and not abs(value) <= FARTHEST:
            fault = f"has its {word} edge at {value:g}"
            raise refused("raster", fault, name, f"coordinates in meters or degrees, up to {FARTHEST:g}")
    for value in (raster.dx, raster.dy):
        if value is not None and not 1 / FARTHEST < value < FARTHEST:
            raise refused(
                "raster", f"has cells with side {value:g}", name, "sides above 0, in meters or degrees"
            )


def require_definition(crs: str) -> None:
    """Raise RasterError unless `crs` is "", a code, WKT or a PROJ definition, and names no address or file."""
    if crs and (OPENED.search(crs) or not SYNTAX.fullmatch(crs)):
        raise refused("crs", "not a coordinate system", crs, EXAMPLE)


def web_mercator(crs: str) -> bool:
    """Return whether a coordinate system is Web Mercator, whose meters are true only at the equator."""
    return (
        re.search(
            r"^\s*(EPSG|ESRI):(3857|3785|900913|102100|102113)\s*$|Pseudo.Mercator|Auxiliary_Sphere"
            "|Popular Visualisation",
            crs,
            re.IGNORECASE,
        )
        is not None
    )


def degrees(crs: str) -> bool:
    """Return whether the unit of a coordinate system is degrees; raise RasterError for an unknown system."""
    require_definition(crs)
    if crs.upper() in DEGREES or re.match(r"\s*GEOG(CS|CRS|RAPHICCRS)\[", crs):
        return True
    try:
        return bool(parsed(crs).is_geographic)
    except ImportError:
        return False


def parsed(crs: str) -> Any:
    """Return rasterio's CRS; raise RasterError for an unknown system, ImportError without rasterio."""
    from rasterio.crs import CRS

    try:
        return CRS.from_user_input(crs)
    except ValueError as error:  # also CRSError
        raise refused("crs", f"unknown to PROJ: {error}", crs, EXAMPLE) from None


# --- .npz


def _of_npz(path: Path, band: int | str | None) -> Raster:
    arrays = read_npz(path)
    grids = [name for name, array in arrays.items() if array.ndim == 2 and array.dtype.kind in "iufb"]
    values = _checked(arrays[grids[_chosen(band, grids)]].astype(np.float64))
    ny, nx = values.shape
    x, y = (
        next((arrays[k].astype(np.float64) for k in names if k in arrays and arrays[k].shape == (n,)), None)
        for names, n in ((LONGITUDES, nx), (LATITUDES, ny))
    )
    crs = str(arrays["crs"]) if "crs" in arrays and arrays["crs"].ndim == 0 else ""
    if x is None or y is None or min(nx, ny) < 2:
        return Raster(values, *_edges(arrays), crs)
    dx, dy = abs(x[-1] - x[0]) / (nx - 1), abs(y[-1] - y[0]) / (ny - 1)
    values = values[:, ::-1] if x[-1] < x[0] else values
    values = values[::-1] if y[1] > y[0] else values
    if "longitude" in arrays or "lon" in arrays:
        crs = crs or "EPSG:4326"
    west, north = min(x[0], x[-1]) - dx / 2, max(y[0], y[-1]) + dy / 2
    return Raster(np.ascontiguousarray(values), west, north, dx, dy, crs)


def read_npz(path: Path) -> dict[str, np.ndarray]:
    """Return the arrays in an .npz file. Raises RasterError, OSError."""
    try:
        content = io.BytesIO(read_bytes(path))
        with zipfile.ZipFile(content) as parts:
            if sum(part.file_size for part in parts.infolist()) > 2 * MOST_BYTES:
                raise ValueError(f"it unpacks to more than {2 * MOST_BYTES:,} bytes")
        with np.load(content, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except DAMAGED as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        raise refused("raster", f"not an .npz file with plain arrays: {error}", str(path), KINDS) from None


def _edges(arrays: dict[str, np.ndarray]) -> tuple[float | None, float | None, float | None, float | None]:
    """Return west, north and the cell sides from the numbers xmin, ymin, ymax, dx and dy."""
    number = {name: float(a) for name, a in arrays.items() if a.ndim == 0 and a.dtype.kind in "iuf"}
    if not (number.get("dx") and number.get("dy")):
        return None, None, None, None
    known = {"xmin", "ymin", "ymax"} <= number.keys()
    north = max(number["ymin"], number["ymax"]) if known else None
    return number["xmin"] if known else None, north, abs(number["dx"]), abs(number["dy"])


def _chosen(band: int | str | None, names: list[str]) -> int:
    """Return the zero-based index of a band, given its number or name. Raises RasterError."""
    if not names:
        raise refused("raster", "has no two-dimensional array", "", "numbers on a grid")
    if isinstance(band, str) and band not in names:
        raise refused("band", "no band with this name", band, listed(names), nearest(band, names))
    number = names.index(band) + 1 if isinstance(band, str) else band or 1
    if number > len(names):
        allowed = f"1 to {len(names)}" if len(names) > 1 else "1, the only one"
        raise refused("band", "no such band", number, f"{allowed} ({listed(names)})")
    return number - 1


def _checked(values: np.ndarray) -> np.ndarray:
    if values.size > MOST_CELLS:
        raise refused("raster", f"has {values.size:.3g} cells", "", f"at most {MOST_CELLS:.0e}")
    values[~np.isfinite(values)] = np.nan
    return values


# --- ESRI ASCII grids


def _of_ascii(path: Path, band: int | str | None) -> Raster:
    if band not in (None, 1):
        raise refused("band", "no such band", band, "1: an ASCII grid has a single band")
    text = read_bytes(path).decode("utf-8-sig", "replace")
    head: dict[str, float] = {}
    at = 0
    for line in text.splitlines(keepends=True):
        match = re.fullmatch(r"\s*([A-Za-z_]+)\s+(\S+)\s*", line)
        if match is None or match[1].lower() == "nan":
            break
        name = match[1].lower()
        try:
            head[name] = float(match[2])
            if name != "nodata_value" and not abs(head[name]) < 1e18:
                raise ValueError
        except ValueError:
            raise refused("raster", f"{match[1]} is not a number", match[2], "an ESRI ASCII grid") from None
        at += len(line)
    nx, ny = int(head.get("ncols", 0)), int(head.get("nrows", 0))
    dx, dy = (head.get(name, head.get("cellsize", 0.0)) for name in ("dx", "dy"))
    if nx < 1 or ny < 1 or not dx > 0 or not dy > 0:
        missing = [n for n in ("ncols", "nrows", "cellsize") if n not in head]
        fault = f"not an ESRI ASCII grid: it lacks {listed(missing) or 'positive sizes'}"
        allowed = "ncols, nrows, xllcorner, yllcorner, cellsize, then the rows"
        raise refused("raster", fault, str(path), allowed)
    try:
        values = np.array(text[at:].split(), np.float64)
    except ValueError as error:
        raise refused("raster", f"not an ESRI ASCII grid: {error}", str(path), "numbers in rows") from None
    if values.size != nx * ny:
        fault = f"has {values.size:,} numbers, but ncols × nrows is {nx * ny:,}"
        raise refused("raster", fault, str(path), "as many numbers as its header states")
    with np.errstate(over="ignore"):  # float32's most negative number, written with more or fewer digits
        none = np.float32(head.get("nodata_value", -9999.0))
        values[(values.astype(np.float32) == none) | (abs(values) > 1e38)] = np.nan
    west = head["xllcorner"] if "xllcorner" in head else head.get("xllcenter", dx / 2) - dx / 2
    south = head["yllcorner"] if "yllcorner" in head else head.get("yllcenter", dy / 2) - dy / 2
    prj = path.with_suffix(".prj")
    crs = read_bytes(prj, MOST_OF_CRS).decode("utf-8", "replace").strip() if prj.is_file() else ""
    return Raster(_checked(values.reshape(ny, nx)), west, south + ny * dy, dx, dy, crs)


# --- GDAL


def _of_gdal(path: Path, band: int | str | None) -> Raster:
    driver = GDAL.get(path.suffix.lower())
    if driver is None:
        raise refused(
            "raster", "has an unsupported format", str(path), f"{KINDS}; convert it with gdal_translate"
        )
    try:
        import rasterio
    except ImportError:
        allowed = f"{INSTALL}; or an .npz or .asc file, which needs no extra package"
        raise refused("raster", "needs rasterio, which is not installed", str(path), allowed) from None
    try:
        with (
            warnings.catch_warnings(action="ignore", category=rasterio.errors.NotGeoreferencedWarning),
            rasterio.MemoryFile(read_bytes(path), filename=path.name) as held,
            held.open(driver=driver) as source,
        ):
            names = [name or f"band {i + 1}" for i, name in enumerate(source.descriptions)]
            number = _chosen(band, names) + 1
            if source.width * source.height > MOST_CELLS:
                allowed = f"at most {MOST_CELLS:.0e}: cut out a part, for example with gdal_translate -srcwin"
                raise refused("raster", f"has {source.width * source.height:.3g} cells", str(path), allowed)
            values = source.read(number, masked=True).astype(np.float64).filled(np.nan)
            values = values * source.scales[number - 1] + source.offsets[number - 1]
            return _placed_by_gdal(source, _checked(values), path)
    except ConfigError:
        raise
    except Exception as error:  # GDAL raises many types of errors
        raise refused("raster", f"cannot be read: {error}", str(path), KINDS) from None


def _placed_by_gdal(source: Any, values: np.ndarray, path: Path) -> Raster:
    crs = "" if source.crs is None else (source.crs.to_string() or "")
    t = source.transform
    if t.is_identity:
        return Raster(values, crs=crs)
    if t.b or t.d:
        fault = "is rotated: its rows do not run from west to east"
        raise refused("raster", fault, str(path), "a raster with north up; convert it with gdalwarp")
    projected = source.crs is not None and source.crs.is_projected
    unit = float(source.crs.linear_units_factor[1]) if projected else 1.0
    if unit != 1.0:
        allowed = "a coordinate system in meters or degrees; convert it with gdalwarp"
        raise refused("raster", f"is in units of {unit:g} m", str(path), allowed)
    values = values[::-1] if t.e > 0 else values
    values = values[:, ::-1] if t.a < 0 else values
    north = t.f + (t.e * values.shape[0] if t.e > 0 else 0.0)
    west = t.c + (t.a * values.shape[1] if t.a < 0 else 0.0)
    return Raster(np.ascontiguousarray(values), west, north, abs(t.a), abs(t.e), crs)
