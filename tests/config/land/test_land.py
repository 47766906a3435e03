"""The land of a world: the part of a raster that it covers, in metres, with its classes."""

import copy
import sys

import numpy as np
import pytest

from ecs_eco.config import load
from ecs_eco.config.notes import notes
from ecs_eco.engine.errors import ConfigError

DEM = np.array([[5.0, 6, 7, 8], [1, 2, 3, 4], [0, 0, 1, 2]])  # north first
WORLD = {
    "format": 1,
    "name": "real",
    "space": {"size": [40.0, 30.0], "edges": "walls"},
    "terrain": {"raster": "dem.npz", "cell": 10.0},
    "species": {"ox": {"count": 1, "body": {"radius": 1.0}}},
}
FAULT = "matplotlib:mpl-data/sample_data/jacksboro_fault_dem.npz"


@pytest.fixture
def at(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.savez(tmp_path / "dem.npz", topo=DEM)
    return tmp_path


def land(**changes):
    return load(copy.deepcopy(WORLD), changes)._land


def refused(**changes):
    with pytest.raises(ConfigError) as error:
        land(**changes)
    return str(error.value)


def test_cells_of_a_raster_without_a_place_are_those_of_the_height_map_and_the_first_row_is_the_south(at):
    assert np.array_equal(land().elevation, DEM[::-1])
    assert land().place is None


def test_a_world_may_cover_a_part_of_it(at):
    part = land(**{"space.size": [20.0, 20.0], "terrain.corner": [10.0, 10.0]})
    assert part.elevation.tolist() == [[2, 3], [6, 7]]


def test_finer_cells_lie_on_straight_lines_between_those_of_the_raster(at):
    np.savez(at / "dem.npz", topo=DEM, dx=10.0, dy=10.0)
    fine = land(**{"terrain.cell": 5.0}).elevation
    assert fine.shape == (6, 8)
    middle = 0.75 * DEM[1] + 0.25 * DEM[2]  # 12.5 m from the south: rows at 5 and 15 m
    assert fine[2, 2] == pytest.approx(0.25 * middle[0] + 0.75 * middle[1])
    assert fine[2, 3] == pytest.approx(0.75 * middle[1] + 0.25 * middle[2])
    assert fine[0, 0] == DEM[2, 0]


def test_a_scaled_world_is_smaller_and_as_steep_as_its_vertical_factor_says(at):
    small = land(
        **{"space.size": [4.0, 3.0], "terrain.cell": 1.0, "terrain.scale": 0.1, "terrain.vertical": 0.1}
    )
    assert small.elevation == pytest.approx(DEM[::-1] * 0.1)


def test_classes_are_by_elevation_slope_and_codes_and_the_last_one_counts(at):
    np.savez(at / "cover.npz", codes=[[1, 1, 2, 2], [1, 1, 2, 2], [3, 3, 3, 3]])
    classes = {"low": {"below": 2.0}, "forest": {"codes": [2, 3], "above": 1.0}, "steep": {"steeper": 0.45}}
    made = land(**{"terrain.cover": "cover.npz", "terrain.classes": classes})
    assert made.kinds.tolist() == [[1, 1, 2, 2], [1, 0, 2, 2], [0, 0, 2, 2]]
    rise = land(**{"terrain.classes": {"steep": {"steeper": 0.3}}}).kinds
    assert rise.tolist() == (np.hypot(*np.gradient(DEM[::-1], 10.0)) >= 0.3).astype(int).tolist()


def test_degrees_are_metres_at_the_latitude_of_the_raster(at):
    real = land(
        **{
            "terrain.raster": FAULT,
            "terrain.crs": "EPSG:4326",
            "space.size": [29_900.0, 31_800.0],
            "terrain.cell": 90.0,
        }
    )
    x, y = real.coordinates(np.array([0.0, 29_900.0]), np.array([0.0, 31_800.0]))
    # 344 rows of 3 arc seconds are 0.28667 degrees; a degree of latitude is 110.97 km at 36.6 degrees north
    assert (x[0], y[0]) == pytest.approx((-84.41375, 36.44625))
    assert y[1] - y[0] == pytest.approx(31.8 / 110.97, rel=1e-4)
    assert x[1] - x[0] == pytest.approx(29.9 / 89.51, rel=1e-3)


def mercator(latitude):
    """Return the northing in Web Mercator [m]."""
    return 6_378_137 * np.arctanh(np.sin(np.radians(latitude)))


@pytest.mark.parametrize(("latitude", "metre"), [(0.0, 1.0), (-45.0, 0.7085), (60.0, 0.5013)])
def test_a_metre_of_web_mercator_is_that_of_the_land(at, latitude, metre):
    middle = mercator(latitude)
    np.savez(
        at / "dem.npz",
        topo=DEM,
        xmin=0.0,
        ymin=middle - 150,
        ymax=middle + 150,
        dx=100.0,
        dy=100.0,
        crs="EPSG:3857",
    )
    sides = {"space.size": [200 * metre, 200 * metre], "terrain.cell": 50 * metre}
    x, y = land(**sides).coordinates(np.array([0.0, 100.0]), np.array([0.0, 100.0]))
    assert x[1] - x[0] == pytest.approx(100 / metre, rel=3e-4)
    assert y[1] - y[0] == pytest.approx(100 / metre, rel=8e-3)  # the earth is no sphere
    assert "smaller than the world" in refused(**sides | {"space.size": [450 * metre, 200 * metre]})


def test_where_a_unit_is_no_metre_a_note_says_how_long_it_is(at):
    more = {"space.size": [2990.0, 3180.0], "terrain.cell": 90.0}
    config = load(copy.deepcopy(WORLD), {"terrain.raster": FAULT, "terrain.crs": "EPSG:4326"} | more)
    (note,) = (line for line in notes(config) if line.startswith("terrain"))
    assert "EPSG:4326" in note
    assert "89487.8 m from west to east and 110970 m from south to north" in note  # at 36.59° N
    np.savez(at / "dem.npz", topo=DEM, xmin=0.0, ymin=0.0, ymax=30.0, dx=10.0, dy=10.0, crs="EPSG:32616")
    assert not [line for line in notes(load(copy.deepcopy(WORLD))) if line.startswith("terrain")]


def test_degrees_at_an_unknown_latitude_are_refused(at):
    np.savez(at / "dem.npz", topo=DEM, dx=0.001, dy=0.001, crs="EPSG:4326")
    assert "so its latitude is unknown" in refused()


def test_metres_of_a_map_that_are_none_of_the_land_are_refused(at):
    pytest.importorskip("rasterio", reason="needs the extra geo")
    where = {"topo": DEM, "xmin": 500_000.0, "dx": 10.0, "dy": 10.0}
    np.savez(at / "dem.npz", **where, ymin=8_362_698.0, ymax=8_362_728.0, crs="EPSG:3395")
    assert "a meter of EPSG:3395 is 0.5" in refused()
    np.savez(at / "dem.npz", **where, ymin=6_600_000.0, ymax=6_600_030.0, crs="EPSG:32632")
    assert land().place is not None
    np.savez(at / "dem.npz", **where, ymin=0.0, ymax=30.0, crs='LOCAL_CS["x",UNIT["metre",1]]')
    assert "cannot be converted to degrees" in refused()


ESRI = 'PROJCS["WGS_1984_UTM_Zone_16N",GEOGCS["GCS_WGS_1984"],UNIT["Meter",1.0]]'


@pytest.mark.parametrize(
    ("crs", "known"),
    [
        ("EPSG:32616", True),
        ("EPSG:25832", True),
        ("+proj=utm +zone=16 +datum=WGS84 +units=m", True),
        (ESRI, True),
        ("EPSG:32661", False),  # polar
        ("EPSG:3395", False),
        ("EPSG:2263", False),  # feet
        ("EPSG:4267", False),  # degrees
        ("+proj=utm +zone=16 +units=us-ft", False),
        (ESRI.replace("16N", "16N_ftUS"), False),
    ],
)
def test_without_rasterio_only_known_metres_are_believed(at, monkeypatch, crs, known):
    for name in ("rasterio", "rasterio.crs", "rasterio.warp"):
        monkeypatch.setitem(sys.modules, name, None)
    np.savez(at / "dem.npz", topo=DEM, xmin=5e5, ymin=6e6, ymax=6e6 + 30, dx=10.0, dy=10.0, crs=crs)
    if known:
        assert land().crs == crs
    else:
        assert "only rasterio, which is not installed, can check its unit" in (text := refused())
        assert ".[geo]" in text


def test_missing_cells_are_refused_with_the_first_of_them_or_filled(at):
    holes = DEM.copy()
    holes[0, 3] = holes[1, 2] = np.nan
    np.savez(at / "dem.npz", topo=holes)
    text = refused()
    assert "2 cells of the world have no elevation; the first is at column 3, row 2" in text
    assert land(**{"terrain.missing": -5.0}).elevation[1].tolist() == [1, 2, -5, 4]
    assert land(**{"space.size": [20.0, 30.0]}).elevation.shape == (3, 2)  # a part without holes


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        (
            {"space.size": [50.0, 30.0]},
            "smaller than the world: it covers 40 × 30 m, but the world needs 50 ×",
        ),
        ({"terrain.corner": [0.0, 10.0]}, "space.size up to [40, 20]"),
        ({"terrain.band": 2}, "terrain.band = 2\n  no such band; expected: 1, the only one (topo)"),
        ({"terrain.band": "tpo"}, 'did you mean "topo"?'),
        ({"terrain.raster": "dam.npz"}, 'terrain.raster = "dam.npz"\n  cannot be read'),
        ({"space.edges": "torus"}, 'differ, but a torus joins them; expected: space.edges = "walls"'),
        ({"terrain.hills": {"amplitude": 1.0, "scale": 9.0}}, "given together with a raster"),
        ({"terrain.classes": {"wood": {"codes": [1]}}}, "there is no raster of classes"),
        ({"terrain.classes": {"wood": {}}}, "does not define where it is"),
        ({"terrain.classes": {"wood": {"above": 3.0, "below": 2.0}}}, "not above `above`"),
        ({"terrain.classes": {"wood": {"above": 3.0, "growht": 2.0}}}, 'did you mean "growth"?'),
        (
            {
                "terrain.cover": "dem.npz",
                "terrain.cover_band": 7,
                "terrain.classes": {"wood": {"codes": [1]}},
            },
            "terrain.cover_band = 7\n  no such band",
        ),
        ({"terrain.drainage": {}}, "does not define where water collects"),
        ({"terrain.raster": FAULT}, 'or crs = "EPSG:4326" if its unit is degrees'),
    ],
)
def test_land_that_cannot_be_is_refused_with_its_place(at, changes, fault):
    assert fault in refused(**changes)


def test_keys_of_real_land_need_a_raster():
    data = copy.deepcopy(WORLD)
    del data["terrain"]["raster"]
    with pytest.raises(ConfigError, match="given without a raster"):
        load(data, {"terrain.missing": 1.0})


def test_the_hash_of_a_world_is_that_of_its_land_too_and_without_land_as_before(at):
    one = load(copy.deepcopy(WORLD)).config_hash
    np.savez(at / "dem.npz", topo=DEM + 1, other=DEM)
    assert load(copy.deepcopy(WORLD)).config_hash != one
    flat = copy.deepcopy(WORLD) | {"terrain": {"cell": 10.0}}
    assert "raster" not in load(flat).resolved()["terrain"]
    assert set(load(flat).resolved()["terrain"]) == {
        "cell",
        "hills",
        "mountains",
        "rocks",
        "lakes",
        "slope_cost",
    }


def test_a_changed_definition_beside_the_raster_is_read_again(at):
    head = "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\n"
    (at / "dem.asc").write_text(head + "\n".join(" ".join(map(str, row)) for row in DEM))
    (at / "dem.prj").write_text("EPSG:32616")
    assert land(**{"terrain.raster": "dem.asc"}).crs == "EPSG:32616"
    (at / "dem.prj").write_text("EPSG:32617")
    assert land(**{"terrain.raster": "dem.asc"}).crs == "EPSG:32617"
