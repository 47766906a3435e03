"""Rasters of three kinds hold the same numbers in the same order: the first row is in the north."""

import importlib
import os
import re

import numpy as np
import pytest

from ecs_eco.config.land.raster import RasterError, degrees, read_raster

GRID = np.arange(12.0).reshape(3, 4)
HEAD = "ncols 4\nnrows 3\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n"


def rows(values):
    return "\n".join(" ".join(f"{v:g}" for v in row) for row in values) + "\n"


def test_an_ascii_grid_begins_in_the_north_and_knows_where_it_lies(tmp_path):
    grid = GRID.copy()
    grid[1, 2] = -1
    (tmp_path / "dem.asc").write_text(HEAD + rows(grid))
    (tmp_path / "dem.prj").write_text('PROJCS["UTM"]')
    raster = read_raster("dem.asc", tmp_path)
    assert np.isnan(raster.values[1, 2])
    assert raster.values[[0, 2], [0, 3]].tolist() == [0.0, 11.0]
    assert raster[1:] == (100.0, 230.0, 10.0, 10.0, 'PROJCS["UTM"]')


def test_the_corner_of_an_ascii_grid_may_be_the_centre_of_a_cell(tmp_path):
    (tmp_path / "dem.asc").write_text(HEAD.replace("corner", "center") + rows(GRID))
    assert read_raster("dem.asc", tmp_path)[1:3] == (95.0, 225.0)


@pytest.mark.parametrize(
    ("line", "written"),
    [
        ("NODATA_value  -9999", "-9999"),
        ("nodata_value -9999.0", "-9999"),
        ("NODATA_VALUE\tnan", "nan"),
        ("NODATA_value -nan", "-nan"),
        ("NODATA_value 0", "0"),
        ("", "-9999"),
        ("NODATA_value inf", "inf"),
        ("NODATA_value  -3.4028234663852886e+38", "-3.4028234663852886e+38"),
        ("NODATA_value  -3.4028235e+38", "-3.402823e+38"),
        ("NODATA_value -1.7976931348623157e+308", "-1.7976931348623157e+308"),
    ],
)
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_every_way_to_say_that_there_is_no_number_is_read(tmp_path, line, written, mark):
    grid = [[written, "1", "2", "3"], ["4", written, "6", "7"], ["8", "9", "10", "11"]]
    head = HEAD.replace("NODATA_value -1", line).replace("\n\n", "\n")
    (tmp_path / "dem.asc").write_text(
        mark + head + "\n".join(" " + " ".join(row) for row in grid) + "\r\n", encoding="utf-8"
    )
    raster = read_raster("dem.asc", tmp_path)
    assert np.argwhere(np.isnan(raster.values)).tolist() == [[0, 0], [1, 1]]
    assert np.nansum(raster.values) == 61
    assert raster[1:5] == (100.0, 230.0, 10.0, 10.0)


def test_a_row_of_two_that_begins_with_a_gap_is_no_line_of_the_head(tmp_path):
    (tmp_path / "dem.asc").write_text("ncols 2\nnrows 2\ncellsize 10\nNODATA_value nan\nnan 5\n6 nan\n")
    assert np.nan_to_num(read_raster("dem.asc", tmp_path).values, nan=-1).tolist() == [[-1, 5], [6, -1]]


def test_an_ascii_grid_may_have_cells_that_are_no_squares(tmp_path):
    (tmp_path / "dem.asc").write_text(HEAD.replace("cellsize 10", "dx 10\ndy 20") + rows(GRID))
    assert read_raster("dem.asc", tmp_path)[1:5] == (100.0, 260.0, 10.0, 20.0)


def test_rows_of_an_npz_whose_latitudes_rise_are_turned(tmp_path):
    np.savez(tmp_path / "dem.npz", topo=GRID, latitude=[1.0, 2.0, 3.0], longitude=[5.0, 5.5, 6.0, 6.5])
    raster = read_raster("dem.npz", tmp_path)
    assert raster.values[0].tolist() == [8.0, 9.0, 10.0, 11.0]
    assert raster[1:] == (4.75, 3.5, 0.5, 1.0, "EPSG:4326")


def test_an_npz_may_have_several_bands_and_nothing_but_numbers(tmp_path):
    np.savez(tmp_path / "dem.npz", first=GRID, other=-GRID, dx=2.0, dy=3.0, name="a word")
    assert read_raster("dem.npz", tmp_path, 2).values[2, 3] == -11
    assert read_raster("dem.npz", tmp_path, "other").values[2, 3] == -11
    raster = read_raster("dem.npz", tmp_path)
    assert raster.values[2, 3] == 11
    assert raster[1:] == (None, None, 2.0, 3.0, "")
    assert raster.dx is not None


@pytest.mark.parametrize(
    ("band", "fault"),
    [(3, "no such band; expected: 1 to 2"), (99, "no such band"), ("othr", 'did you mean "other"?')],
)
def test_a_band_that_is_not_there_is_refused_with_those_that_are(tmp_path, band, fault):
    np.savez(tmp_path / "dem.npz", first=GRID, other=-GRID)
    with pytest.raises(RasterError, match="band") as error:
        read_raster("dem.npz", tmp_path, band)
    assert fault in str(error.value)


@pytest.mark.parametrize(
    ("name", "content", "fault"),
    [
        ("dem.asc", HEAD + "1 2 3\n", "has 3 numbers, but ncols × nrows is 12"),
        ("dem.asc", HEAD + rows(GRID).replace("5", "wet"), "not an ESRI ASCII grid"),
        ("dem.asc", "nrows 3\n1 2 3\n", "it lacks ncols, cellsize"),
        ("dem.npz", "no zip", "not an .npz"),
        ("gone.npz", None, "cannot be read"),
        ("go\0ne.npz", None, "cannot be read"),
        ("dem.asc", HEAD.replace("4", "1e300") + rows(GRID), "ncols is not a number"),
        ("dem.asc", HEAD.replace("4", "nan") + rows(GRID), "ncols is not a number"),
    ],
)
def test_files_that_hold_no_grid_are_refused(tmp_path, name, content, fault):
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(RasterError, match="raster") as error:
        read_raster(name, tmp_path)
    assert fault in str(error.value)


def test_an_npz_with_objects_is_refused(tmp_path):
    np.savez(tmp_path / "dem.npz", topo=np.array([[None, {}]], object))
    with pytest.raises(RasterError, match="plain arrays"):
        read_raster("dem.npz", tmp_path)


def test_damaged_npz_are_refused_or_hold_numbers(tmp_path):
    np.savez_compressed(tmp_path / "dem.npz", topo=np.random.default_rng(3).random((40, 40)))
    whole = (tmp_path / "dem.npz").read_bytes()
    outcomes = set()
    for at in range(0, len(whole), len(whole) // 60):
        (tmp_path / f"{at}.npz").write_bytes(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
        try:
            outcomes.add(read_raster(f"{at}.npz", tmp_path).values.shape)
        except RasterError:
            outcomes.add("refused")
    assert outcomes <= {"refused", (40, 40)}
    assert "refused" in outcomes


def test_a_changed_file_is_read_again(tmp_path):
    np.savez(tmp_path / "dem.npz", topo=GRID)
    assert read_raster("dem.npz", tmp_path).values[0, 1] == 1
    np.savez(tmp_path / "dem.npz", topo=GRID * 2, more=GRID)
    assert read_raster("dem.npz", tmp_path).values[0, 1] == 2


def test_a_raster_may_come_with_an_installed_package(tmp_path):
    name = "matplotlib:mpl-data/sample_data/jacksboro_fault_dem.npz"
    raster = read_raster(name, tmp_path, crs="EPSG:4326")
    assert raster.values.shape == (344, 403)
    assert (np.nanmin(raster.values), np.nanmax(raster.values)) == (236, 1076)
    assert raster.north == pytest.approx(36.73291667)
    with pytest.raises(RasterError, match="not installed"):
        read_raster("no_such_package:dem.npz", tmp_path)


def test_degrees_are_told_from_metres():
    assert degrees("EPSG:4326")
    assert degrees('GEOGCS["WGS 84",DATUM["…"]]')


def test_geotiff_is_read_through_rasterio(tmp_path):
    rasterio = pytest.importorskip("rasterio", reason="needs the extra geo")
    with rasterio.open(
        tmp_path / "dem.tif",
        "w",
        driver="GTiff",
        width=4,
        height=3,
        count=2,
        dtype="float32",
        crs="EPSG:32616",
        nodata=-99,
        transform=rasterio.Affine(10, 0, 100, 0, -20, 230),
    ) as file:
        file.write(GRID.astype("float32"), 1)
        file.write(np.where(GRID == 5, -99, GRID).astype("float32"), 2)
        file.set_band_description(2, "surface")
    first, second = read_raster("dem.tif", tmp_path), read_raster("dem.tif", tmp_path, "surface")
    assert np.array_equal(first.values, GRID)
    assert np.isnan(second.values[1, 1])
    assert first[1:] == (100.0, 230.0, 10.0, 20.0, "EPSG:32616")
    assert degrees("EPSG:4617")
    assert not degrees("EPSG:32616")
    with pytest.raises(RasterError, match="1 to 2"):
        read_raster("dem.tif", tmp_path, 3)


def test_a_geotiff_holds_what_its_scale_and_offset_say(tmp_path):
    rasterio = pytest.importorskip("rasterio", reason="needs the extra geo")
    with rasterio.open(
        tmp_path / "dem.tif",
        "w",
        driver="GTiff",
        width=4,
        height=3,
        count=2,
        dtype="int16",
        crs="EPSG:32616",
        nodata=-1,
        transform=rasterio.Affine(10, 0, 100, 0, -10, 230),
    ) as file:
        file.write(np.where(GRID == 5, -1, 10 * GRID).astype("int16"), 1)
        file.write(GRID.astype("int16"), 2)
        file.scales, file.offsets = (0.1, 1.0), (100.0, 0.0)
    first, second = (read_raster("dem.tif", tmp_path, band).values for band in (1, 2))
    assert np.isnan(first[1, 1])
    assert first[GRID != 5] == pytest.approx(100 + GRID[GRID != 5])
    assert np.array_equal(second, GRID)


@pytest.mark.parametrize("kind", ["int16", "float32", "float64"])
def test_ascii_grids_as_gdal_writes_them_hold_what_it_was_given(tmp_path, kind):
    rasterio = pytest.importorskip("rasterio", reason="needs the extra geo")
    nodata = {"int16": -32768, "float32": -3.4028234663852886e38, "float64": float("nan")}[kind]
    with rasterio.open(
        tmp_path / "dem.tif",
        "w",
        driver="GTiff",
        width=4,
        height=3,
        count=1,
        dtype=kind,
        crs="EPSG:32616",
        nodata=nodata,
        transform=rasterio.Affine(10, 0, 100, 0, -20, 260),
    ) as file:
        file.write(np.where(GRID == 5, nodata, GRID).astype(kind), 1)
    copy = importlib.import_module("rasterio.shutil").copy
    copy(tmp_path / "dem.tif", tmp_path / "dem.asc", driver="AAIGrid")
    own, gdal = read_raster("dem.asc", tmp_path), read_raster("dem.tif", tmp_path)
    assert np.array_equal(own.values, gdal.values, equal_nan=True)
    assert own[1:5] == gdal[1:5]


# --- files of strangers -------------------------------------------------------------------------------------


def test_a_raster_is_in_the_folder_of_its_world(tmp_path):
    (tmp_path / "world").mkdir()
    np.savez(tmp_path / "dem.npz", topo=GRID)
    (tmp_path / "world" / "link.npz").symlink_to(tmp_path / "dem.npz")
    for name in ("../dem.npz", str(tmp_path / "dem.npz"), "link.npz", "matplotlib:../numpy/__init__.py"):
        with pytest.raises(RasterError, match="is outside the world's folder"):
            read_raster(name, tmp_path / "world")
    assert read_raster("world/../dem.npz", tmp_path).values.shape == (3, 4)


@pytest.mark.parametrize("name", ["dem.npz", "dem.asc", "dem.tif", "dem.dem"])
def test_a_pipe_is_refused_and_not_waited_for(tmp_path, name):
    os.mkfifo(tmp_path / name)
    with pytest.raises(RasterError, match=r"is not a regular file|needs rasterio"):
        read_raster(name, tmp_path)


def test_the_pipe_that_would_name_the_coordinate_system_of_a_grid_is_passed_over(tmp_path):
    (tmp_path / "dem.asc").write_text(HEAD + rows(GRID))
    os.mkfifo(tmp_path / "dem.prj")
    assert read_raster("dem.asc", tmp_path).crs == ""


@pytest.mark.parametrize(
    ("head", "fault"),
    [
        (HEAD.replace("100", "1e17"), "its west edge at 1e+17"),
        (HEAD.replace("200", "1e17"), "its north edge"),
        (HEAD.replace("cellsize 10", "cellsize 1e-12"), "cells with side 1e-12"),
    ],
)
def test_coordinates_that_are_nowhere_on_the_earth_are_refused(tmp_path, head, fault):
    (tmp_path / "dem.asc").write_text(head + rows(GRID))
    with pytest.raises(RasterError, match=re.escape(fault)):
        read_raster("dem.asc", tmp_path)


@pytest.mark.parametrize(
    "crs",
    [
        "http://127.0.0.1:9/crs",
        "/etc/hostname",
        "crs.prj",
        "file:///etc/hostname",
        "+proj=utm +zone=16 +nadgrids=http://127.0.0.1:9/g.tif +type=crs",
        "http://127.0.0.1:9/Pseudo-Mercator",
        "Pseudo-Mercator.prj",
        "+proj=merc +nadgrids = Pseudo-Mercator.tif +type=crs",
        "+proj=merc +nadgrids=@null,Pseudo-Mercator.tif +type=crs",
        "+init=Pseudo-Mercator:1",
        'VERT_CS["Pseudo-Mercator",VERT_DATUM["x",2005,EXTENSION["PROJ4_GRIDS","x.gtx"]]]',
        'BOUNDCRS["Pseudo-Mercator",METHOD["NTv2"],PARAMETERFILE["x","x.gsb"]]',
    ],
)
def test_a_coordinate_system_is_no_address_and_no_file(tmp_path, crs):
    (tmp_path / "dem.asc").write_text(HEAD + rows(GRID))
    with pytest.raises(RasterError, match="not a coordinate system"):
        degrees(crs)
    with pytest.raises(RasterError, match="not a coordinate system"):
        read_raster("dem.asc", tmp_path, crs=crs)
    (tmp_path / "other.asc").write_text(HEAD + rows(GRID))
    (tmp_path / "other.prj").write_text(crs)
    with pytest.raises(RasterError, match="not a coordinate system"):
        read_raster("other.asc", tmp_path)


@pytest.mark.parametrize(
    "crs",
    [
        "EPSG:32616",
        "OGC:CRS84",
        "+init=epsg:4326",
        "+proj=utm +zone=16 +datum=WGS84 +units=m +no_defs",
        "+proj=merc +a=6378137 +b=6378137 +units=m +nadgrids=@null +wktext +no_defs",
        'PROJCS["OSGB36 / British National Grid",GEOGCS["OSGB36"]]',
    ],
)
def test_codes_and_definitions_are_coordinate_systems(tmp_path, crs):
    (tmp_path / "dem.asc").write_text(HEAD + rows(GRID))
    assert read_raster("dem.asc", tmp_path, crs=crs).crs == crs


def test_a_grid_of_gdal_with_a_byte_order_mark_is_read(tmp_path):
    (tmp_path / "dem.asc").write_text(HEAD + rows(GRID), encoding="utf-8-sig")
    (tmp_path / "plain.asc").write_text(HEAD + rows(GRID))
    read, plain = (read_raster(name, tmp_path) for name in ("dem.asc", "plain.asc"))
    assert read[1:] == plain[1:]
    assert np.array_equal(read.values, plain.values, equal_nan=True)


def test_gdal_gets_the_driver_that_a_name_calls_for_whatever_the_content_says(tmp_path, requests):
    pytest.importorskip("rasterio", reason="needs the extra geo")
    source = f"<SourceFilename>/vsicurl/{requests.address}/x.tif</SourceFilename><SourceBand>1</SourceBand>"
    text = (
        '<VRTDataset rasterXSize="4" rasterYSize="4"><VRTRasterBand dataType="Float32" band="1">'
        f"<SimpleSource>{source}</SimpleSource></VRTRasterBand></VRTDataset>"
    )
    for name in ("dem.tif", "dem.vrt", "dem.hgt", "N46E007.hgt", "dem.dem", "dem.dt1", "dem.xyz"):
        (tmp_path / name).write_text(text)
        with pytest.raises(RasterError, match="raster"):
            read_raster(name, tmp_path)
    with pytest.raises(RasterError, match="raster"):
        read_raster(f"/vsicurl/{requests.address}/x.tif", tmp_path)
    assert requests.paths == []
