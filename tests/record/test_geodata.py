"""Tracks as geographic data: places in the coordinate system of the land, readable by GDAL and by Arrow."""

import json
import resource
import struct

import numpy as np
import pyarrow.parquet as pq
import pytest

from ecs_eco.config.land.land import Land
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record import run_to_folder
from ecs_eco.record.geodata import write_tracks

OX = {
    "count": 6,
    "body": {"radius": 1.0},
    "locomotion": {"speed": {"walk": 2.0}},
    "actions": {"speed": ["walk"]},
    "default_action": {"speed": "walk"},
}


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Oxen that walk for ten ticks over a slope, with a snapshot every five."""
    monkeypatch.chdir(tmp_path)

    def make(edges="walls", **more):
        np.savez(
            tmp_path / "dem.npz",
            z=np.add.outer(np.zeros(40), np.arange(50.0)),
            **{"dx": 10.0, "dy": 10.0} | more,
        )
        terrain = {"raster": "dem.npz", "cell": 10.0, "corner": [100.0, 50.0]} if edges == "walls" else None
        world = {
            "format": 1,
            "name": "w",
            "space": {"size": [300.0, 200.0], "edges": edges},
            "species": {"ox": OX, "cow": OX},
        } | ({"terrain": terrain} if terrain else {})
        run_to_folder(world, ticks=10, out=tmp_path / "run", snapshot_every=5, report=False)
        return tmp_path / "run"

    return make


UTM = {"xmin": 500_000.0, "ymin": 4e6, "ymax": 4e6 + 400, "crs": "EPSG:32616"}
DEGREES = {"dx": 2e-4, "dy": 1e-4, "xmin": 8.0, "ymin": 50.0, "ymax": 50.004, "crs": "EPSG:4326"}


def test_places_are_in_the_coordinate_system_of_the_land_with_their_elevations(run, tmp_path):
    written = write_tracks(run(**UTM), "t.csv")
    head, *rows = (tmp_path / "t.csv").read_text().replace('"', "").splitlines()
    assert head == "species,uid,tick,time,elevation,x,y"
    assert written == (len(rows), 12, "EPSG:32616")
    assert len(rows) >= 24
    east = np.array([float(row.split(",")[5]) for row in rows])
    north = np.array([float(row.split(",")[6]) for row in rows])
    assert east.min() >= 500_100
    assert east.max() <= 500_400
    assert north.min() >= 4e6 + 50
    elevation = np.array([float(row.split(",")[4]) for row in rows])
    assert elevation == pytest.approx(np.floor((east - 500_000) / 10), abs=1.01)


def test_geoparquet_holds_points_in_degrees(run):
    write_tracks(run(**DEGREES), "t.parquet", "ox")
    table = pq.read_table("t.parquet")
    geo = json.loads(table.schema.metadata[b"geo"])["columns"]["geometry"]
    assert "crs" not in geo  # degrees on WGS 84 are the default
    assert geo["geometry_types"] == ["Point"]
    assert set(table["species"].to_pylist()) == {"ox"}
    order, kind, x, y = struct.unpack("<BIdd", table["geometry"][0].as_py())
    assert (order, kind) == (1, 1)
    assert 8.0 < x < 8.005
    assert 50.0 < y < 50.004
    assert geo["bbox"][0] <= x <= geo["bbox"][2]


def test_geopackage_holds_lines_with_their_coordinate_system(run):
    raw = pytest.importorskip("pyogrio.raw", reason="needs the extra geo")
    assert write_tracks(run(**UTM), "t.gpkg", lines=True).individuals == 12
    meta, _, geometry, fields = raw.read("t.gpkg")
    assert meta["crs"] == "EPSG:32616"
    assert meta["geometry_type"] == "LineString"
    assert len(geometry) == 12
    assert dict(zip(meta["fields"], fields, strict=True))["places"].tolist() == [2] * 12
    write_tracks("run", "t.gpkg")  # in its place
    assert raw.read("t.gpkg")[0]["geometry_type"] == "Point"


def test_a_world_without_land_is_written_in_metres(run):
    folder = run("torus")
    assert write_tracks(folder, "t.parquet").crs == ""
    table = pq.read_table("t.parquet")
    assert json.loads(table.schema.metadata[b"geo"])["columns"]["geometry"]["crs"] is None
    assert "elevation" not in table.column_names


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        ({"file": "t.shp"}, "unsupported format; expected: a file ending in .gpkg, .parquet, .csv"),
        ({"species": "axe"}, "no such species in this run"),
        ({"lines": True}, "cannot be drawn on a torus"),
    ],
)
def test_what_cannot_be_written_is_refused(run, words, fault):
    folder = run("torus")
    with pytest.raises(ConfigError) as error:
        write_tracks(folder, **{"file": "t.csv"} | words)
    assert fault in str(error.value)


@pytest.mark.parametrize("ending", ["csv", "parquet", "gpkg"])
def test_a_full_disk_is_told_with_the_file_and_leaves_nothing(run, tmp_path, ending):
    if ending == "gpkg":
        pytest.importorskip("pyogrio", reason="ecs-eco[geo] is not installed")
    folder, soft = run(**DEGREES), resource.getrlimit(resource.RLIMIT_FSIZE)
    before = sorted(tmp_path.iterdir())
    resource.setrlimit(resource.RLIMIT_FSIZE, (500, soft[1]))
    try:
        with pytest.raises(OSError, match=f"t.{ending}"):
            write_tracks(folder, tmp_path / f"t.{ending}")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, soft)
    assert sorted(tmp_path.iterdir()) == before


@pytest.fixture
def placed(run, tmp_path):
    """A run whose land says that it is in another coordinate system."""

    def make(crs, **more):
        folder = run(**UTM)
        arrays = dict(np.load(folder / "terrain.npz"))
        about = json.loads(str(arrays["about"])) | {"crs": crs}
        arrays["about"] = np.array(json.dumps(about))
        arrays["about"] = Land.of(arrays).arrays()["about"]
        np.savez(folder / "terrain.npz", **{k: v for k, v in (arrays | more).items() if v is not None})
        return folder

    return make


@pytest.mark.parametrize("ending", ["csv", "parquet", "gpkg"])
def test_the_land_of_a_stranger_s_run_names_no_address(placed, ending):
    with pytest.raises(ConfigError, match=r"terrain\.npz: crs = .*\n.*not a coordinate system"):
        write_tracks(placed("http://127.0.0.1:9/crs"), f"t.{ending}")


@pytest.mark.parametrize("ending", ["parquet", "gpkg"])
def test_a_coordinate_system_unknown_to_proj_is_refused(placed, ending):
    pytest.importorskip("rasterio", reason="needs the extra geo")
    with pytest.raises(ConfigError, match=r"terrain\.npz: crs = .EPSG:0.\n +unknown to PROJ"):
        write_tracks(placed("EPSG:0"), f"t.{ending}")


def test_land_without_elevations_is_refused(placed):
    with pytest.raises(ConfigError, match="has no elevations"):
        write_tracks(placed("EPSG:32616", height=None), "t.csv")
