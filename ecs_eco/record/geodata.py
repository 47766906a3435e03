"""Tracks of a run as geographic data: GeoPackage, GeoParquet or CSV, in the land's coordinate system."""

import json
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from ecs_eco.config.land.land import KEPT, Land, kept_land
from ecs_eco.config.land.raster import DEGREES, EXAMPLE, INSTALL, RasterError, parsed, read_npz, refused
from ecs_eco.engine import files
from ecs_eco.engine.errors import listed, nearest, refusal
from ecs_eco.record.parquet import read_parts
from ecs_eco.record.seal import read_manifest

ENDINGS = (".gpkg", ".parquet", ".csv")
POINT = np.dtype([("order", "u1"), ("kind", "<u4"), ("x", "<f8"), ("y", "<f8")])  # well-known binary
NOWHERE = pa.schema(
    {"tick": pa.int64(), "species": pa.string(), "uid": pa.uint64(), "x": pa.float32(), "y": pa.float32()}
).empty_table()
NO_LAND = Land(np.zeros((1, 1), np.float32), np.zeros((1, 1), np.uint8), np.zeros((1, 1), np.bool_))


class Tracks(NamedTuple):
    """The written tracks: numbers of positions and individuals, and the coordinate system ("": meters from
    the world's corner)."""

    places: int
    individuals: int
    crs: str


def write_tracks(
    run: str | Path, file: str | Path, species: str | None = None, lines: bool = False
) -> Tracks:
    """Write the positions of organisms at each snapshot of a run. Each row is a position with species, uid,
    tick, time [s], elevation [m] and a point or, with `lines`, the path of an organism with at least two
    positions.

    Raises ConfigError if the format or the request is invalid, RecordingError if the run is unreadable, or
    OSError.
    """
    run, file = Path(run), Path(file)
    if file.suffix.lower() not in ENDINGS:
        raise refusal(
            (), "unsupported format", str(file), f"a file ending in {listed(ENDINGS)}", source="FILE"
        )
    manifest = read_manifest(run)
    known = list(manifest.get("species") or ())
    if species is not None and species not in known:
        raise refusal(
            (), "no such species in this run", species, listed(known), nearest(species, known), "--species"
        )
    if lines and manifest["config"]["space"]["edges"] == "torus":
        raise refusal((), "cannot be drawn on a torus", "", "points, or a world with walls", source="--lines")
    if lines and file.suffix.lower() == ".csv":
        raise refusal(
            (), "cannot be written to a CSV file", str(file), "a .gpkg or a .parquet", source="--lines"
        )
    table = _places(run, species, float(manifest.get("dt", 1.0)))
    land = kept_land(run) if "land" in manifest and (run / KEPT).is_file() else NO_LAND
    x, y = land.coordinates(*(table[axis].to_numpy().astype(np.float64) for axis in "xy"))
    individuals = len(pc.unique(table["uid"]))
    if "land" in manifest:
        table = table.append_column("elevation", pa.array(_elevations(run, manifest, table)))
    table = table.drop_columns(["x", "y"])
    if lines:
        table, geometry = _lines(table, x, y)
    else:
        geometry = _points(x, y)
    try:
        if file.suffix.lower() == ".csv":
            _csv(table, x, y, file)
        elif file.suffix.lower() == ".parquet":
            _geoparquet(table, geometry, (x, y), land.crs, lines, file)
        else:
            _geopackage(table, geometry, land.crs, lines, file)
    except RasterError as error:
        raise RasterError([p.moved(source=str(run / KEPT)) for p in error.problems]) from None
    return Tracks(len(x), individuals, land.crs)


def _places(run: Path, species: str | None, dt: float) -> pa.Table:
    """Return species, uid, tick, time, x and y, sorted by uid and tick."""
    table = read_parts(run / "snapshots", ["tick", "species", "uid", "x", "y"])
    table = table if table.num_columns else NOWHERE  # no snapshot contains organisms
    names = table["species"].cast(pa.string())
    table = table.set_column(table.column_names.index("species"), "species", names)
    if species is not None:
        table = table.filter(pc.equal(table["species"], species))
    table = table.sort_by([("uid", "ascending"), ("tick", "ascending")])
    time = pa.array(table["tick"].to_numpy().astype(np.float64) * dt)
    return table.append_column("time", time).select(["species", "uid", "tick", "time", "x", "y"])


def _elevations(run: Path, manifest: dict[str, Any], table: pa.Table) -> np.ndarray:
    height = read_npz(run / KEPT).get("height", np.zeros(0))
    if height.ndim != 2 or not height.size:
        raise refused("raster", "has no elevations", str(run / KEPT), "the land saved by this run")
    size, (ny, nx) = manifest["config"]["space"]["size"], height.shape
    i = (table["x"].to_numpy() / size[0] * nx).astype(np.int64).clip(0, nx - 1)
    j = (table["y"].to_numpy() / size[1] * ny).astype(np.int64).clip(0, ny - 1)
    out: np.ndarray = height[j, i]
    return out


def _points(x: np.ndarray, y: np.ndarray) -> pa.Array:
    """Return points as well-known binary."""
    made = np.zeros(x.size, POINT)
    made["order"], made["kind"], made["x"], made["y"] = 1, 1, x, y
    ends = np.arange(x.size + 1, dtype=np.int64) * POINT.itemsize
    return pa.Array.from_buffers(
        pa.large_binary(), x.size, [None, pa.py_buffer(ends.tobytes()), pa.py_buffer(made.tobytes())]
    )


def _lines(table: pa.Table, x: np.ndarray, y: np.ndarray) -> tuple[pa.Table, pa.Array]:
    """Return one row for each organism with at least two positions; its path is well-known binary."""
    uid, tick = table["uid"].to_numpy(), table["tick"].to_numpy()
    first = np.flatnonzero(np.append(True, uid[1:] != uid[:-1])) if uid.size else np.zeros(0, np.int64)
    last = np.append(first[1:], uid.size) if uid.size else first
    first, last = first[last - first > 1], last[last - first > 1]
    way = np.stack([x, y], 1).astype("<f8")
    head = np.array([(1, 2)], np.dtype([("order", "u1"), ("kind", "<u4")])).tobytes()
    shapes = [
        head + np.uint32(b - a).astype("<u4").tobytes() + way[a:b].tobytes()
        for a, b in zip(first.tolist(), last.tolist(), strict=True)
    ]
    rows = pa.table(
        {
            "species": table["species"].take(pa.array(first)),
            "uid": uid[first],
            "first": tick[first],
            "last": tick[last - 1],
            "places": last - first,
        }
    )
    return rows, pa.array(shapes, pa.large_binary())


def _csv(table: pa.Table, x: np.ndarray, y: np.ndarray, file: Path) -> None:
    from pyarrow import csv

    with files.writing(file) as beside:
        csv.write_csv(table.append_column("x", pa.array(x)).append_column("y", pa.array(y)), beside)


def _geoparquet(
    table: pa.Table,
    geometry: pa.Array,
    places: tuple[np.ndarray, np.ndarray],
    crs: str,
    lines: bool,
    file: Path,
) -> None:
    """Write GeoParquet 1.1, whose default coordinate system is degrees on WGS 84."""
    import pyarrow.parquet as pq

    about: dict[str, Any] = {"encoding": "WKB", "geometry_types": ["LineString" if lines else "Point"]}
    if crs.upper() not in DEGREES[:2]:
        about["crs"] = _projjson(crs, file) if crs else None
    if places[0].size:
        about["bbox"] = [float(f(axis)) for f in (np.min, np.max) for axis in places]
    geo = {"version": "1.1.0", "primary_column": "geometry", "columns": {"geometry": about}}
    table = table.append_column("geometry", geometry).replace_schema_metadata({"geo": json.dumps(geo)})
    with files.writing(file) as beside:
        pq.write_table(table, beside, compression="zstd")


def _projjson(crs: str, file: Path) -> Any:
    try:
        return parsed(crs).to_dict(projjson=True)
    except ImportError:
        raise refusal(
            (),
            f"needs rasterio, which is not installed, to name {crs}",
            str(file),
            f"{INSTALL}; or a .csv",
            source="FILE",
        ) from None


def _geopackage(table: pa.Table, geometry: pa.Array, crs: str, lines: bool, file: Path) -> None:
    try:
        from pyogrio import errors, raw
    except ImportError:
        raise refusal(
            (),
            "needs pyogrio, which is not installed",
            str(file),
            f"{INSTALL}; or write .parquet or .csv, which need no extra library",
            source="FILE",
        ) from None
    columns = [table[name].to_numpy() for name in table.column_names]
    columns = [c.astype(np.int64) if c.dtype == np.uint64 else c for c in columns]
    made = BytesIO()  # an interrupted GDAL would leave temporary files
    try:
        raw.write(
            made,
            np.array(geometry.to_pylist(), object),
            columns,
            table.column_names,
            driver="GPKG",
            layer="tracks",
            geometry_type="LineString" if lines else "Point",
            crs=crs or None,
        )
    except errors.CRSError:
        raise refused("crs", "unknown to PROJ", crs, EXAMPLE) from None
    files.write(file, made.getvalue())
