"""Vector layers: lakes with islands, classes, roads and fences, in the coordinate system of the raster."""

import json
import os
import struct

import numpy as np
import pytest

from ecs_eco.config.land.layers import parts_of, within
from ecs_eco.config.land.raster import RasterError
from ecs_eco.engine.errors import ConfigError
from tests.config.land.test_land import WORLD

SQUARE = [(10, 10), (50, 10), (50, 40), (10, 40), (10, 10)]
ISLAND = [(20, 20), (30, 20), (30, 30), (20, 30), (20, 20)]


def wkb(kind, *rings):
    lines = [struct.pack("<I", len(ring)) + np.array(ring, "<f8").tobytes() for ring in rings]
    head = struct.pack("<BI", 1, kind)
    return head + (lines[0] if kind == 2 else struct.pack("<I", len(lines)) + b"".join(lines))


def test_shapes_are_taken_apart():
    assert [(k, p.tolist()) for k, p in parts_of(wkb(2, [(1, 2), (3, 4)]))] == [(2, [[1, 2], [3, 4]])]
    area = parts_of(wkb(3, SQUARE, ISLAND))
    assert [(k, len(p)) for k, p in area] == [(3, 5), (3, 5)]
    several = struct.pack("<BII", 1, 6, 2) + wkb(3, SQUARE) + wkb(3, ISLAND)
    assert [p.tolist() for _, p in parts_of(several)] == [p.tolist() for _, p in area]
    assert parts_of(struct.pack(">BIdd", 0, 1, 7.0, 8.0))[0][1].tolist() == [[7, 8]]


def test_lines_are_cut_at_the_edge_of_the_world():
    line = np.array([[-5.0, 5], [5, 5], [5, 15], [8, 15], [8, 2]])
    assert [piece.tolist() for piece in within(line, (10.0, 10.0))] == [
        [[0, 5], [5, 5], [5, 10]],
        [[8, 10], [8, 2]],
    ]
    assert within(np.array([[-1.0, -1], [-1, 20]]), (10.0, 10.0)) == []


@pytest.fixture
def layers(tmp_path, monkeypatch):
    raw = pytest.importorskip("pyogrio.raw", reason="needs the extra geo")
    monkeypatch.chdir(tmp_path)
    np.savez(
        tmp_path / "dem.npz",
        topo=np.zeros((6, 8)),
        dx=10.0,
        dy=10.0,
        xmin=500_000.0,
        ymin=4e6,
        ymax=4e6 + 60,
        crs="EPSG:32616",
    )

    def write(name, kind, *shapes, crs="EPSG:32616"):
        moved = [[[(x + 500_000, y + 4e6) for x, y in ring] for ring in rings] for rings in shapes]
        kinds = {2: "LineString", 3: "Polygon"}
        raw.write(
            tmp_path / name,
            np.array([wkb(kind, *rings) for rings in moved], object),
            [],
            [],
            geometry_type=kinds[kind],
            crs=crs,
        )
        return tmp_path / name

    return write


def made(**terrain):
    from ecs_eco import World

    return World.from_config(
        WORLD | {"space": {"size": [80.0, 60.0], "edges": "walls"}, "terrain": WORLD["terrain"] | terrain}
    ).terrain


def test_lakes_have_islands_and_classes_their_areas(layers):
    layers("lakes.gpkg", 3, [SQUARE, ISLAND])
    layers("wood.gpkg", 3, [[(0, 0), (20, 0), (20, 60), (0, 60), (0, 0)]])
    terrain = made(
        classes={"wood": {"pace": 0.5}},
        layers=[
            {"file": "lakes.gpkg", "make": "lakes"},
            {"file": "wood.gpkg", "make": "class", "land": "wood"},
        ],
    )
    wet = np.zeros((6, 8), int)
    wet[1:4, 1:5] = 1
    wet[2, 2] = 0
    assert terrain.ground.tolist() == wet.tolist()
    assert (terrain.pace[:, :2] == 0.5).all()
    assert (terrain.pace[:, 2:] == 1).all()


def test_roads_and_fences_lie_where_their_lines_are(layers):
    layers("lines.gpkg", 2, [[(-100, 25), (200, 25)]])
    terrain = made(
        layers=[
            {"file": "lines.gpkg", "make": "roads", "width": 10.0, "pace": 2.0, "cost": 0.5},
            {"file": "lines.gpkg", "make": "fences"},
        ]
    )
    assert [road.line.tolist() for road in terrain.roads] == [[[0, 25], [80, 25]]]
    assert (terrain.pace[2] == 2).all()
    assert (terrain.toll[2] == 0.5).all()
    assert (terrain.ground[2] == 3).all()
    assert (terrain.ground[3] == 0).all()


def test_another_coordinate_system_is_brought_to_that_of_the_raster(layers):
    warp = pytest.importorskip("rasterio.warp", reason="needs the extra geo")
    raw = pytest.importorskip("pyogrio.raw")
    x, y = warp.transform("EPSG:32616", "EPSG:4326", [500_010, 500_070], [4e6 + 25, 4e6 + 25])
    raw.write(
        "degrees.gpkg",
        np.array([wkb(2, list(zip(x, y, strict=True)))], object),
        [],
        [],
        geometry_type="LineString",
        crs="EPSG:4326",
    )
    line = made(layers=[{"file": "degrees.gpkg", "make": "fences"}]).fences[0]
    assert line == pytest.approx(np.array([[10, 25], [70, 25]]), abs=0.01)


@pytest.mark.parametrize(
    ("layer", "fault"),
    [
        ({"file": "gone.gpkg", "make": "lakes"}, "cannot be read"),
        ({"file": "lines.gpkg", "make": "lakes"}, "contains only lines; expected: areas, for lakes"),
        ({"file": "lines.gpkg", "make": "roads", "layer": "line"}, 'did you mean "lines"?'),
        ({"file": "lines.gpkg", "make": "class", "land": "wod"}, "no class with this name"),
    ],
)
def test_layers_that_cannot_be_are_refused_with_their_place(layers, layer, fault):
    layers("lines.gpkg", 2, [[(0, 25), (80, 25)]])
    with pytest.raises(ValueError, match=r"terrain\.layers\.0") as error:
        made(layers=[layer], classes={"wood": {"above": 5.0}})
    assert fault in str(error.value)


def test_layers_need_a_raster_that_says_where_it_lies(layers, tmp_path):
    layers("lines.gpkg", 2, [[(0, 25), (80, 25)]])
    np.savez(tmp_path / "dem.npz", topo=np.zeros((6, 8)))
    with pytest.raises(ValueError, match="needs a raster with coordinates") as error:
        made(layers=[{"file": "lines.gpkg", "make": "roads"}])
    assert not isinstance(error.value, RasterError)


# --- GeoJSON, and files of strangers ------------------------------------------------------------------------

RING = [[10, 10], [50, 10], [50, 40], [10, 40], [10, 10]]
UTM = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32616"}}


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a raster whose corner is at (0, 0), and a way to lay a layer on it."""
    monkeypatch.chdir(tmp_path)
    np.savez(
        tmp_path / "dem.npz",
        topo=np.zeros((6, 8)),
        dx=10.0,
        dy=10.0,
        xmin=0.0,
        ymin=0.0,
        ymax=60.0,
        crs="EPSG:32616",
    )

    def lay(name, content=None, **more):
        if content is not None:
            (tmp_path / name).write_bytes(
                content if isinstance(content, bytes) else json.dumps(content).encode()
            )
        return made(layers=[{"file": name, "make": "lakes"} | more])

    return lay


def test_geojson_needs_no_library(place):
    area = {"type": "Polygon", "coordinates": [RING]}
    feature = {"type": "Feature", "properties": {"a": 1}, "geometry": area}
    wet = place(
        "a.geojson",
        {"type": "FeatureCollection", "crs": UTM, "features": [feature, feature | {"geometry": None}]},
    ).ground
    assert wet.sum() == 12
    assert wet[1:4, 1:5].all()
    several = {
        "type": "GeometryCollection",
        "crs": UTM,
        "geometries": [
            {"type": "MultiPolygon", "coordinates": [[[[*corner, 7.5] for corner in RING]]]},
            {"type": "Point", "coordinates": [1, 1]},
        ],
    }
    assert (place("b.json", several).ground == wet).all()
    line = {"type": "MultiLineString", "coordinates": [[[0, 5], [80, 5]], [[0, 9], [80, 9]]], "crs": UTM}
    from ecs_eco.config import load

    land = (
        load(
            WORLD
            | {
                "space": {"size": [80.0, 60.0], "edges": "walls"},
                "terrain": WORLD["terrain"] | {"layers": [{"file": "c.json", "make": "fences"}]},
            }
        )
        if place("c.json", line, make="fences")
        else None
    )
    assert [piece["line"] for piece in land._land.lines] == [[[0, 5], [80, 5]], [[0, 9], [80, 9]]]


@pytest.mark.parametrize(
    ("name", "content", "fault"),
    [
        (
            "a.geojson",
            {
                "type": "Polygon",
                "coordinates": [RING],
                "crs": {"type": "link", "properties": {"href": "{address}/crs", "type": "proj4"}},
            },
            "links to its coordinate system",
        ),
        (
            "a.geojson",
            {
                "type": "Polygon",
                "coordinates": [RING],
                "crs": {"type": "name", "properties": {"name": "{address}/crs"}},
            },
            "not a coordinate system",
        ),
        (
            "a.geojson",
            {"type": "gdal_streamed_alg", "command_line": "gdal vector read {address}/x"},
            "cannot be read",
        ),
        (
            "a.geojson",
            {"type": "Polygon", "coordinates": [[[1e300, 0], [0, 1]]], "crs": UTM},
            "impossible on Earth",
        ),
        ("a.geojson", {"type": "Polygon", "coordinates": [[["x", 0]]], "crs": UTM}, "cannot be read"),
        ("a.geojson", {"type": "Polygon", "coordinates": 7, "crs": UTM}, "cannot be read"),
        ("a.geojson", b"[" * 100_000, "cannot be read"),
        ("a.geojson", b"{" + b'"a":[' * 100_000, "cannot be read"),
        (
            "a.gpkg",
            b'<OGRVRTDataSource><OGRVRTLayer name="x"><SrcDataSource>/vsicurl/{address}/x.gpkg'
            b"</SrcDataSource></OGRVRTLayer></OGRVRTDataSource>",
            "has a different file format",
        ),
        ("a.vrt", b"<OGRVRTDataSource/>", "has a different file format"),
        ("a.gml", b"<gml/>", "has a different file format"),
        ("{address}/a.geojson", None, "is outside the world's folder"),
        ("/vsicurl/{address}/a.gpkg", None, "is outside the world's folder"),
        ("../a.gpkg", None, "is outside the world's folder"),
    ],
)
def test_no_layer_leads_elsewhere(place, requests, name, content, fault):
    def filled(text):
        return text.replace("{address}", requests.address)

    if content is not None:
        content = filled(content.decode() if isinstance(content, bytes) else json.dumps(content)).encode()
    with pytest.raises(ConfigError) as error:
        place(filled(name), content)
    assert fault in str(error.value)
    assert requests.paths == []


@pytest.mark.parametrize("name", ["a.geojson", "a.gpkg", "a.shp", "a.fgb"])
def test_a_pipe_in_the_place_of_a_layer_is_not_waited_for(place, tmp_path, name):
    os.mkfifo(tmp_path / name)
    with pytest.raises(ConfigError, match="is not a regular file"):
        place(name)


def test_a_pipe_beside_a_shapefile_is_not_waited_for(layers, tmp_path):
    layers("a.shp", 3, [SQUARE])
    assert made(layers=[{"file": "a.shp", "make": "lakes"}]).ground.sum() == 12
    (tmp_path / "a.dbf").unlink()
    os.mkfifo(tmp_path / "a.dbf")
    with pytest.raises(ConfigError, match="is not a regular file"):
        made(layers=[{"file": "a.shp", "make": "fences"}])


@pytest.mark.parametrize("head", ["{address}", "OGCAPI:{address}", "zip:", "x.zip!", "vsi?"])
def test_the_path_of_a_shapefile_is_never_an_address(layers, tmp_path, requests, head):
    layers("a.shp", 3, [SQUARE])
    folder = "./" + head.format(address=requests.address).replace("//", "/")
    (tmp_path / folder).mkdir(parents=True)
    for part in tmp_path.glob("a.*"):
        part.rename(tmp_path / folder / part.name)
    assert made(layers=[{"file": f"{folder}/a.shp", "make": "lakes"}]).ground.sum() == 12
    assert requests.paths == []


def test_an_address_as_coordinate_system_of_the_raster_is_not_asked(place, tmp_path, requests):
    pytest.importorskip("rasterio", reason="needs the extra geo")
    dem = dict(np.load("dem.npz")) | {"crs": f"{requests.address}/Pseudo-Mercator"}
    np.savez("dem.npz", **dem)
    with pytest.raises(ConfigError, match=r"terrain\.crs.*\n.*not a coordinate system"):
        place("a.geojson", {"type": "Polygon", "coordinates": [RING]})
    assert requests.paths == []


def test_shapes_that_cannot_be_brought_to_the_raster_are_refused(layers, tmp_path):
    pytest.importorskip("rasterio", reason="needs the extra geo")
    far = {"type": "Polygon", "coordinates": [[[0, 95], [1e6, 95], [1e6, -95], [0, 95]]]}  # degrees
    (tmp_path / "far.geojson").write_text(json.dumps(far))
    with pytest.raises(ConfigError, match=r"cannot be read|impossible on Earth"):
        made(layers=[{"file": "far.geojson", "make": "lakes"}])
