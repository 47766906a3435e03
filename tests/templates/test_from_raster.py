"""`world from-raster` writes a world that runs, of rasters that say where they lie and of others."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.templates import world_from_raster

FAULT = "matplotlib:mpl-data/sample_data/jacksboro_fault_dem.npz"
COAST = "matplotlib:mpl-data/sample_data/topobathy.npz"


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def hills(**more):
    y, x = np.mgrid[:40, :50]
    np.savez("my dem 2.npz", z=100 + 30 * np.sin(x / 5) * np.cos(y / 7), **more)


def test_a_raster_of_a_package_becomes_a_world_with_its_whole_land():
    config = load(world_from_raster(FAULT, crs="EPSG:4326"))
    assert config.name == "jacksboro-fault-dem"
    assert config.terrain.cell == 74.6
    assert config.space.size == pytest.approx([403 * 74.5, 344 * 92.5], rel=0.01)
    assert set(config.terrain.classes) == {"wood", "heath", "steep"}
    assert config._land.kinds.max() == 3


def test_a_coast_has_a_sea_in_which_nobody_stands():
    world = World.from_config(world_from_raster(COAST, "coast.toml"), policies="random")
    assert world.config.terrain.drainage.sea == 0.0
    assert 0.4 < (world.terrain.ground == 1).mean() < 0.6
    deer = world.tables["deer"]
    from ecs_eco.components import Position

    assert world.terrain.free(deer[Position].x[deer.rows()], deer[Position].y[deer.rows()]).all()


def test_it_runs_and_deer_and_grass_live_on(here):
    hills(dx=25.0, dy=25.0)
    path = world_from_raster("my dem 2.npz")
    assert path.name == "my-dem-2.toml"
    world = World.from_config(path).run(300)
    assert world.tables["deer"].n > 20
    assert world.tables["grass"].n > 300
    assert world.next_uid > 1500  # some were born


def test_rasters_that_do_not_say_their_size_need_a_cell_and_gaps_are_filled(here):
    hills()
    with pytest.raises(ConfigError, match="--cell"):
        world_from_raster("my dem 2.npz")
    assert load(world_from_raster("my dem 2.npz", cell=30.0)).space.size == [1500.0, 1200.0]
    (here / "maps").mkdir()
    np.savez("holes.npz", z=np.where(np.eye(40, 50) > 0, np.nan, 7.0))
    with pytest.raises(ConfigError, match=r"FILE: .*\n.*above it; expected: holes.toml"):
        world_from_raster("holes.npz", "maps/holes.toml", cell=30.0)
    (here / "holes.npz").rename(here / "maps" / "holes.npz")
    path = world_from_raster("maps/holes.npz", cell=30.0)
    assert 'raster = "maps/holes.npz"' in path.read_text()
    for command in ("watch", "check"):
        assert f"ecs-eco {command} {path.as_posix()}" in path.read_text()
    assert load(path).terrain.missing == 7.0


def test_a_large_raster_gives_its_middle():
    np.savez("large.npz", z=np.arange(700.0 * 610).reshape(610, 700))
    config = load(world_from_raster("large.npz", cell=10.0))
    assert config.space.size == [6000.0, 6000.0]
    assert config.terrain.corner == [500.0, 50.0]


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        ({"raster": "gone.tif"}, 'RASTER: "gone.tif"\n  cannot be read'),
        ({"raster": "land.toml"}, 'RASTER: "land.toml"\n  has an unsupported format'),
        ({"band": 9}, "--band: 9\n  no such band"),
        ({"out": "there.toml"}, "already exists"),
        ({"out": "world.txt"}, "is not the name of a world file"),
        ({"cell": 400.0}, "leaves 3 × 2 cells"),
    ],
)
def test_what_cannot_be_is_refused(here, words, fault):
    hills(dx=25.0, dy=25.0)
    for name in ("there.toml", "land.toml"):
        (here / name).write_text("")
    with pytest.raises(ConfigError) as error:
        world_from_raster(**{"raster": "my dem 2.npz"} | words)
    assert fault in str(error.value)
    assert "dem.toml" not in str(error.value)
