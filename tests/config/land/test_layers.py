"""Vector layers: lakes with islands, classes, roads and fences, in the coordinate system of the raster."""

import struct

import numpy as np
import pytest

from ecs_eco.config.land.layers import parts_of, within
from ecs_eco.config.land.raster import RasterError
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
        [[0, 5], [5, 5], [5, 10]], [[8, 10], [8, 2]]]
    assert within(np.array([[-1.0, -1], [-1, 20]]), (10.0, 10.0)) == []


@pytest.fixture
def layers(tmp_path, monkeypatch):
    raw = pytest.importorskip("pyogrio.raw", reason="needs the extra geo")
    monkeypatch.chdir(tmp_path)
    np.savez(tmp_path / "dem.npz", topo=np.zeros((6, 8)), dx=10.0, dy=10.0, xmin=500_000.0, ymin=4e6,
             ymax=4e6 + 60, crs="EPSG:32616")

    def write(name, kind, *shapes, crs="EPSG:32616"):
        moved = [[[(x + 500_000, y + 4e6) for x, y in ring] for ring in rings] for rings in shapes]
        kinds = {2: "LineString", 3: "Polygon"}
        raw.write(tmp_path / name, np.array([wkb(kind, *rings) for rings in moved], object), [], [],
                  geometry_type=kinds[kind], crs=crs)
        return tmp_path / name

    return write


def made(**terrain):
    from ecs_eco import World

    return World.from_config(WORLD | {"space": {"size": [80.0, 60.0], "edges": "walls"},
                                      "terrain": WORLD["terrain"] | terrain}).terrain


def test_lakes_have_islands_and_classes_their_areas(layers):
    layers("lakes.gpkg", 3, [SQUARE, ISLAND])
    layers("wood.gpkg", 3, [[(0, 0), (20, 0), (20, 60), (0, 60), (0, 0)]])
    terrain = made(classes={"wood": {"pace": 0.5}}, layers=[
        {"file": "lakes.gpkg", "make": "lakes"}, {"file": "wood.gpkg", "make": "class", "land": "wood"}])
    wet = np.zeros((6, 8), int)
    wet[1:4, 1:5] = 1
    wet[2, 2] = 0
    assert terrain.ground.tolist() == wet.tolist()
    assert (terrain.pace[:, :2] == 0.5).all()
    assert (terrain.pace[:, 2:] == 1).all()


def test_roads_and_fences_lie_where_their_lines_are(layers):
    layers("lines.gpkg", 2, [[(-100, 25), (200, 25)]])
    terrain = made(layers=[{"file": "lines.gpkg", "make": "roads", "width": 10.0, "pace": 2.0, "cost": 0.5},
                           {"file": "lines.gpkg", "make": "fences"}])
    assert [road.line.tolist() for road in terrain.roads] == [[[0, 25], [80, 25]]]
    assert (terrain.pace[2] == 2).all()
    assert (terrain.toll[2] == 0.5).all()
    assert (terrain.ground[2] == 3).all()
    assert (terrain.ground[3] == 0).all()


def test_another_coordinate_system_is_brought_to_that_of_the_raster(layers):
    warp = pytest.importorskip("rasterio.warp", reason="needs the extra geo")
    raw = pytest.importorskip("pyogrio.raw")
    x, y = warp.transform("EPSG:32616", "EPSG:4326", [500_010, 500_070], [4e6 + 25, 4e6 + 25])
    raw.write("degrees.gpkg", np.array([wkb(2, list(zip(x, y, strict=True)))], object), [], [],
              geometry_type="LineString", crs="EPSG:4326")
    line = made(layers=[{"file": "degrees.gpkg", "make": "fences"}]).fences[0]
    assert line == pytest.approx(np.array([[10, 25], [70, 25]]), abs=0.01)


@pytest.mark.parametrize(("layer", "fault"), [
    ({"file": "gone.gpkg", "make": "lakes"}, "cannot be read"),
    ({"file": "lines.gpkg", "make": "lakes"}, "holds lines alone; allowed: areas, for lakes"),
    ({"file": "lines.gpkg", "make": "roads", "layer": "line"}, 'did you mean "lines"?'),
    ({"file": "lines.gpkg", "make": "class", "land": "wod"}, "no class of this name"),
])  # fmt: skip
def test_layers_that_cannot_be_are_refused_with_their_place(layers, layer, fault):
    layers("lines.gpkg", 2, [[(0, 25), (80, 25)]])
    with pytest.raises(ValueError, match=r"terrain\.layers\.0") as error:
        made(layers=[layer], classes={"wood": {"above": 5.0}})
    assert fault in str(error.value)


def test_layers_need_a_raster_that_says_where_it_lies(layers, tmp_path):
    layers("lines.gpkg", 2, [[(0, 25), (80, 25)]])
    np.savez(tmp_path / "dem.npz", topo=np.zeros((6, 8)))
    with pytest.raises(ValueError, match="does not say where it lies") as error:
        made(layers=[{"file": "lines.gpkg", "make": "roads"}])
    assert not isinstance(error.value, RasterError)
