"""Malicious land data: rasters and layers that contradict their names, contain network addresses, are pipes,
refer to other folders, or have impossible coordinates. A request to an address leaves a mark."""

from __future__ import annotations

import json
import os
import random
import threading
from collections.abc import Iterator
from functools import cache
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np

from ecs_eco.config.edit import as_toml
from studies.common.malicious.ground import Attack, Ground, cli
from studies.common.malicious.templates import world_of

HEAD = "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 5\nNODATA_value -9999\n"
ROWS = "1 2 3 4\n" * 4
RASTERS = (
    ".tif",
    ".tiff",
    ".hgt",
    ".dem",
    ".dt0",
    ".dt1",
    ".dt2",
    ".vrt",
    ".img",
    ".nc",
    ".asc",
    ".grd",
    ".npz",
    ".jp2",
    ".zarr",
    ".gpkg",
    "",
)
LAYERS = (
    ".gpkg",
    ".shp",
    ".fgb",
    ".geojson",
    ".json",
    ".gml",
    ".kml",
    ".csv",
    ".vrt",
    ".sqlite",
    ".gpx",
    ".zip",
)
RING = [[1, 1], [9, 1], [9, 9], [1, 1]]


@cache
def address(ground: Ground) -> str:
    """Return the address of a local server that leaves a mark for each request."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            (ground.marks / "request").touch()
            self.send_error(404)

        do_HEAD = do_POST = do_GET

        def log_message(self, *_: Any) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"127.0.0.1:{server.server_port}"


def by_hand(ground: Ground) -> Iterator[Attack]:
    """Yield handmade rasters and layers of all kinds."""
    for i, (label, terrain, content) in enumerate((*_rasters(ground), *_layers(ground))):
        yield _attack(ground, label, terrain, content, i)


def by_mutation(ground: Ground, seed: int, number: int) -> Iterator[Attack]:
    """Yield harmless files with bytes changed, removed or duplicated."""
    files = list(_harmless(ground).items())
    for i in range(number):
        chance = random.Random(seed * 1_000_000 + i)
        name, content = chance.choice(files)
        data = bytearray(content)
        for _ in range(chance.choice((1, 3, 30))):
            at = chance.randrange(len(data))
            data[at : at + chance.choice((0, 1, 1, 1, 4))] = chance.randbytes(chance.choice((1, 1, 2, 8)))
        yield _attack(
            ground, f"{seed}.{i}: {name}", _naming(name), {name: bytes(data[: chance.choice((None, at))])}, i
        )


def _naming(name: str) -> dict[str, Any]:
    """Return a terrain that uses a file as its input."""
    if name.startswith("layer"):
        return {"layers": [{"file": name, "make": "lakes"}]}
    return {"raster": name}


def _attack(
    ground: Ground, label: str, terrain: dict[str, Any], content: dict[str, bytes | None], turn: int
) -> Attack:
    """Return an attack that checks a world on this land; every fourth world is also run. If content is None,
    the file is a pipe."""
    folder = ground.new()
    folder.mkdir()
    (folder / "plain.asc").write_text(HEAD + ROWS)
    for name, data in content.items():
        if data is None:
            os.mkfifo(folder / name)
        else:
            (folder / name).write_bytes(data)
    path = folder / "world.toml"
    land = {"raster": "plain.asc", "cell": 5.0} | terrain
    data = world_of("systems.*") | {
        "systems": [],
        "terrain": land,
        "space": {"size": [10.0, 10.0], "edges": "walls"},
    }
    path.write_text(as_toml(data), encoding="utf-8")
    run = cli("run", path, "--ticks", "1", "--out", folder / "out", "-q", "--no-report")
    return Attack(
        f"land: {label[:80]}",
        ["terrain", "WORLD"],
        [("check", cli("check", path)), *([("run", run)] if turn % 4 == 0 else [])],
    )


def _rasters(ground: Ground) -> Iterator[tuple[str, dict[str, Any], dict[str, bytes | None]]]:
    here = address(ground)
    source = f"<SourceFilename>/vsicurl/http://{here}/x.tif</SourceFilename><SourceBand>1</SourceBand>"
    virtual = (
        '<VRTDataset rasterXSize="4" rasterYSize="4"><VRTRasterBand dataType="Float32" band="1">'
        f"<SimpleSource>{source}</SimpleSource></VRTRasterBand></VRTDataset>"
    ).encode()
    for kind in RASTERS:
        yield f"a virtual raster named {kind}", {"raster": f"a{kind}"}, {f"a{kind}": virtual}
    elsewhere = [
        f"http://{here}/a.tif",
        f"/vsicurl/http://{here}/a.tif",
        f"vrt://http://{here}/a.tif",
        f"/vsizip//vsicurl/http://{here}/a.zip",
        f"WMS:http://{here}/",
        f"GTIFF_DIR:1:http://{here}/a.tif",
        "../other.asc",
        str(ground.home / "path" / "evil.py"),
        "/proc/self/environ",
        "/dev/stdin",
        ".",
        "matplotlib:../numpy/__init__.py",
        "matplotlib:/etc/hostname",
        "a\nb.asc",
        "\x1b[2J.asc",
    ]
    for name in elsewhere:
        yield f"raster = {name}", {"raster": name}, {}
        yield f"cover = {name}", {"cover": name}, {}
    for kind in (".npz", ".asc", ".grd", ".tif", ".hgt"):
        yield f"a pipe named {kind}", {"raster": f"a{kind}"}, {f"a{kind}": None}
    yield "a pipe for a coordinate system", {}, {"plain.prj": None}
    for crs in (
        f"http://{here}/crs",
        f"+proj=utm +zone=16 +nadgrids=http://{here}/g.tif +type=crs",
        f'{{"$schema": "http://{here}/s", "type": "GeographicCRS"}}',
        "+proj=longlat +nadgrids=a.asc",
        "world.toml",
        "EPSG:0",
        "GEOGCS[",
        "{",
    ):
        yield f"crs = {crs}", {"crs": crs}, {}
        yield f"prj with {crs}", {}, {"plain.prj": crs.encode()}
    yield from _numbers(ground)


def _numbers(ground: Ground) -> Iterator[tuple[str, dict[str, Any], dict[str, bytes | None]]]:
    """Return rasters with impossible headers, values and axes."""
    for old, new in (
        ("xllcorner 0", "xllcorner 1e17"),
        ("yllcorner 0", "yllcorner -1e17"),
        ("cellsize 5", "cellsize 1e-300"),
        ("cellsize 5", "cellsize 1e17"),
        ("cellsize 5", "cellsize nan"),
        ("ncols 4", "ncols 1e17"),
        ("ncols 4", "ncols -4"),
        ("ncols 4", "ncols 4.5"),
        ("NODATA_value -9999", "NODATA_value nan"),
    ):
        grid = (HEAD.replace(old, new) + ROWS).encode()
        yield f"a grid with {new}", {"raster": "a.asc"}, {"a.asc": grid}
    for value in ("1e308", "-1e308", "1e400", "inf", "nan", "1_0", "0x10"):
        grid = (HEAD + ROWS.replace("3", value)).encode()
        yield f"a grid of {value}", {"raster": "a.asc"}, {"a.asc": grid}
        yield f"a cover of {value}", {"cover": "a.asc", "classes": {"wood": {"codes": [3]}}}, {"a.asc": grid}
    axes: tuple[dict[str, Any], ...] = (
        {"latitude": [91.0, 92, 93, 94], "longitude": [1.0, 2, 3, 4]},
        {"y": [1.0, 1, 1, 1], "x": [1.0, 1, 1, 1]},
        {"y": [np.nan] * 4, "x": [1.0, 2, 3, 4]},
        {"y": [-1e308, 0, 1, 1e308], "x": [1.0, 2, 3, 4]},
        {"dx": np.inf, "dy": 1.0},
        {"dx": 1e-320, "dy": 1.0},
        {"dx": 5.0, "dy": 5.0, "xmin": np.nan, "ymin": 0.0, "ymax": 20.0},
    )
    for each in axes:
        yield f"axes {each}", {"raster": "a.npz"}, {"a.npz": _npz(ground, **each)}


def _layers(ground: Ground) -> Iterator[tuple[str, dict[str, Any], dict[str, bytes | None]]]:
    here = address(ground)
    source = f"<SrcDataSource>/vsicurl/http://{here}/x.gpkg</SrcDataSource>"
    virtual = f'<OGRVRTDataSource><OGRVRTLayer name="x">{source}</OGRVRTLayer></OGRVRTDataSource>'.encode()
    for kind in LAYERS:
        yield f"a virtual layer named {kind}", _naming(f"layer{kind}"), {f"layer{kind}": virtual}
        yield f"a pipe named {kind}", _naming(f"layer{kind}"), {f"layer{kind}": None}
    for name in (
        f"http://{here}/a.geojson",
        f"/vsicurl/http://{here}/a.gpkg",
        f"WFS:http://{here}/",
        f"PG:host={here}",
        "../other.gpkg",
        "/proc/self/environ",
        ".",
    ):
        yield f"layer {name}", {"layers": [{"file": name, "make": "roads"}]}, {}
    named = [{"type": "name", "properties": {"name": name}} for name in (f"http://{here}/crs", 7)]
    for crs in (
        {"type": "link", "properties": {"href": f"http://{here}/crs", "type": "proj4"}},
        {"type": "url", "properties": {"url": f"http://{here}/crs"}},
        {"type": "name"},
        7,
        "EPSG:4326",
        *named,
    ):
        yield f"GeoJSON whose crs is {crs}", _naming("layer.json"), {"layer.json": _geojson(RING, crs=crs)}
    rings: tuple[Any, ...] = (
        [[1e300, 0], [0, 1], [1, 1]],
        [[0, 95], [1e6, 95], [1, -95]],
        [["x", 0]],
        [[None, 1]],
        [[]],
        [],
        7,
        None,
        [[1]],
        [[10**400, 1]],
        [[True, False]],
        [[[1, 2]]],
        {},
    )
    for ring in rings:
        yield f"GeoJSON of {str(ring)[:40]}", _naming("layer.json"), {"layer.json": _geojson(ring)}
    algorithm = {"type": "gdal_streamed_alg", "command_line": f"gdal vector read http://{here}/x"}
    for text in (
        b"{",
        b"{}",
        b'{"type": "FeatureCollection"}',
        json.dumps(algorithm).encode(),
        b'{"type": "Feature", "geometry": {"type": "Curve"}}',
        b'{"type":' + b"[" * 100_000,
        b'{"type": "FeatureCollection", "features": 7}',
        b"{\xff}",
    ):
        yield f"GeoJSON {text[:40]!r}", _naming("layer.json"), {"layer.json": text}


def _geojson(ring: Any, **more: Any) -> bytes:
    return json.dumps({"type": "Polygon", "coordinates": [ring]} | more).encode()


def _npz(ground: Ground, **arrays: Any) -> bytes:
    path = ground.new().with_suffix(".npz")
    np.savez(path, topo=np.arange(16.0).reshape(4, 4), **arrays)
    return path.read_bytes()


@cache
def _harmless(ground: Ground) -> dict[str, bytes]:
    """Return a small file of every kind that this installation can write."""
    out = {
        "a.asc": (HEAD + ROWS).encode(),
        "a.npz": _npz(ground, dx=5.0, dy=5.0),
        "layer.json": _geojson(RING),
    }
    try:
        import rasterio
        from pyogrio import raw
    except ImportError:
        return out
    folder = ground.new()
    folder.mkdir()
    with rasterio.open(
        folder / "a.tif",
        "w",
        driver="GTiff",
        width=4,
        height=4,
        count=1,
        dtype="float32",
        crs="EPSG:32616",
        transform=rasterio.Affine(5, 0, 0, 0, -5, 20),
    ) as file:
        file.write(np.arange(16, dtype=np.float32).reshape(4, 4), 1)
    line = bytes.fromhex("0102000000020000000000000000000000000000000000000000000000000014400000000000001440")
    for name in ("layer.gpkg", "layer.fgb", "layer.shp"):
        raw.write(
            folder / name, np.array([line], object), [], [], geometry_type="LineString", crs="EPSG:32616"
        )
    return out | {
        path.name: path.read_bytes()
        for path in folder.iterdir()
        if path.suffix in (".tif", ".gpkg", ".fgb", ".shp")
    }
