"""Real land in a world: relief that costs and hides, water, growth, pace and shelter of classes."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism, Position, Velocity
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.space.geometry import Space
from ecs_eco.space.terrain import OPEN, OPEN_GROUND, ROCK, WATER, Ground, hill_between
from ecs_eco.systems import Feed, Grow, Move
from ecs_eco.testing import act, arrange

FAULT = "matplotlib:mpl-data/sample_data/jacksboro_fault_dem.npz"
OX = {"count": 1, "body": {"radius": 1.0}}
GOER = {
    "count": 3,
    "body": {"radius": 0.1},
    "locomotion": {"speed": {"walk": 2.0}, "cost": {"walk": 0.5}},
    "actions": {"speed": ["walk"]},
    "default_action": {"speed": "walk"},
}


@pytest.fixture
def made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def make(dem, species=None, size=None, cell=10.0, fields=None, substances=None, **terrain):
        dem = np.asarray(dem, float)
        np.savez(tmp_path / "dem.npz", topo=dem)
        size = size or [dem.shape[1] * cell, dem.shape[0] * cell]
        return World.from_config(
            {
                "format": 1,
                "name": "real",
                "space": {"size": size, "edges": "walls"},
                "substances": substances or {},
                "fields": fields or {},
                "terrain": {"raster": "dem.npz", "cell": cell, **terrain},
                "species": species or {"ox": OX},
            }
        )

    return make


def test_climbing_costs_by_the_slope_of_the_raster(made):
    west, flat = np.tile(np.arange(6.0) * 3.0, (4, 1)), np.zeros((4, 6))  # 3 m up in each 10 m to the east
    costs = []
    for dem in (west, flat):
        world = made(dem, {"goat": GOER}, slope_cost=2.0)
        arrange(world, "goat", x=[20.0, 30.0, 20.0], y=[15.0] * 3, heading=[0.0, 0.0, np.pi])
        act(world, Move)
        goats = world.tables["goat"]
        costs.append(goats[Velocity].cost[goats.by_uid()])
    assert costs[1] == pytest.approx([0.5] * 3)
    assert costs[0] == pytest.approx([0.5 * 1.6, 0.5 * 1.6, 0.5])  # 1 + 2 × 0.3 uphill, nothing down


def test_classes_have_their_pace_and_cost_and_a_road_its_own(made):
    dem = [[0, 0, 5, 5]] * 4
    road = [{"line": [[0.0, 35.0], [39.0, 35.0]], "width": 2.0, "pace": 3.0, "cost": 0.5}]
    world = made(
        dem,
        {"goat": GOER},
        slope_cost=0.0,
        roads=road,
        classes={"bog": {"above": 4.0, "pace": 0.5, "cost": 4.0}},
    )
    arrange(world, "goat", x=[5.0, 25.0, 25.0], y=[15.0, 15.0, 35.0], heading=0.0)
    act(world, Move)
    goats = world.tables["goat"]
    rows = goats.by_uid()
    assert goats[Position].x[rows] == pytest.approx([7.0, 26.0, 31.0])
    assert goats[Velocity].cost[rows] == pytest.approx([0.5, 2.0, 0.25])


def test_plants_grow_by_the_factor_of_their_class(made):
    moss = {
        "count": 3,
        "body": {"radius": 0.1},
        "metabolism": {"energy": 0.1, "energy_max": 9.0, "photosynthesis": 0.2},
    }
    world = made(
        [[0, 0, 5, 9]] * 4,
        {"moss": moss},
        classes={"wood": {"above": 4.0, "growth": 2.0}, "scree": {"above": 8.0, "growth": 0.0}},
    )
    arrange(world, "moss", x=[5.0, 25.0, 35.0], y=15.0)
    act(world, Grow)
    moss = world.tables["moss"]
    assert moss[Metabolism].energy[moss.by_uid()] == pytest.approx([0.3, 0.5, 0.1])


def test_plants_spread_faster_where_the_class_is_fertile_and_not_at_all_where_it_is_bare(made):
    grass = {
        "count": 0,
        "body": {"radius": 0.1},
        "reproduction": {"kind": "spread", "rate": 0.0, "seed_rain": 0.1, "spacing": 1.0},
    }
    world = made(
        [[0, 5, 9]] * 3,
        {"grass": grass},
        cell=20.0,
        classes={"wood": {"above": 4.0, "growth": 3.0}, "scree": {"above": 8.0, "growth": 0.0}},
    )
    world.run(1)
    x = world.tables["grass"][Position].x[world.tables["grass"].rows()]
    n = np.bincount((x / 20).astype(int), minlength=3)
    assert n[2] == 0
    assert n[0] == pytest.approx(120, abs=50)  # 1,200 sites, a tenth of them; three deviations are 31
    assert n[1] == pytest.approx(360, abs=80)


def test_land_shelters_prey_that_moves(made):
    hare = {
        "count": 400,
        "body": {"radius": 0.1},
        "locomotion": {"speed": {"sit": 0.0}},
        "actions": {"speed": ["sit"]},
    }
    fox = {
        "count": 400,
        "body": {"radius": 0.1},
        "diet": [{"eats": "hare", "reach": 0.1, "gain": 0.1}],
        "metabolism": {"energy": 0.1, "energy_max": 1.0},
    }
    caught = []
    for species in (hare, {k: v for k, v in hare.items() if k in ("count", "body")}):
        world = made(
            [[0, 5]] * 3,
            {"hare": species, "fox": fox},
            cell=20.0,
            classes={"wood": {"above": 4.0, "shelter": 0.75}},
        )
        i = np.arange(400)
        places = {"x": (1.0 + i % 20 * 2.0).tolist(), "y": (1.0 + i // 20 * 2.5).tolist()}
        arrange(world, "hare", **places)
        arrange(world, "fox", **places)
        act(world, Feed)
        prey = world.tables["hare"]
        rows = prey.by_uid()
        eaten = prey.cause[rows] != 0
        caught.append(
            [int(eaten[prey[Position].x[rows] < 20].sum()), int(eaten[prey[Position].x[rows] >= 20].sum())]
        )
    assert caught[1] == [200, 200]  # what does not move finds no shelter
    assert caught[0][0] == 200
    assert caught[0][1] == pytest.approx(50, abs=20)


def test_hollows_are_lakes_and_the_sea_and_streams_can_be_drunk_from(made):
    dem = np.add.outer(np.zeros(7), np.array([-2.0, 1, 2, 3, 4, 5, 6, 7]))
    dem[3, 4:6] = 1.0  # a hollow, 2 m deep: its outlet is to the west, at 3 m
    fields = {"water": {"substance": "water", "cell": 10.0, "initial": 50.0, "only": "lakes"}}
    world = made(
        dem, drainage={"sea": 0.0, "depth": 1.5, "stream": 600.0}, fields=fields, substances={"water": ""}
    )
    terrain = world.terrain
    ground = terrain.ground[::-1]
    assert (ground[:, 0] == WATER).all()
    assert ground[3, 4:6].tolist() == [WATER, WATER]
    assert terrain.height[::-1][3, 4:6].tolist() == [3.0, 3.0]  # its surface
    assert (terrain.height[:, 0] == 0).all()  # sea level
    wet = terrain.wet()[::-1]
    over = wet[2:5, 3]  # where the lake runs over: the three are as high as each other
    assert over.sum() == 1
    assert (ground[2:5, 3] == OPEN).all()
    assert not wet[0, 6]
    assert np.array_equal(world.fields["water"].value[0] > 0, terrain.wet())
    shallow = made(dem, drainage={"depth": 2.5}).terrain.ground
    assert (shallow == OPEN).all()


def test_classes_may_be_rock_and_water_and_nobody_stands_there(made):
    world = made(
        np.add.outer(np.zeros(9), np.arange(9.0)),
        {"ox": OX | {"count": 300}},
        classes={"sea": {"below": 2.0, "ground": "water"}, "cliff": {"above": 6.0, "ground": "rock"}},
    )
    assert (world.terrain.ground == ROCK).sum() == 27
    x = world.tables["ox"][Position].x[world.tables["ox"].rows()]
    assert x.min() >= 20
    assert x.max() < 60


# --- sight


def _line_of_sight(x, y, dx, dy, eye, top, height, inverse, size):
    """Whether ground rises above the straight line, looked at every half cell: in words, for all pairs at
    once."""
    one, two = np.float32(1), np.float32(2)
    ny, nx = height.shape

    def heights(px, py):
        px = np.minimum(np.maximum(px, np.float32(0)), np.nextafter(np.float32(size[0]), np.float32(0)))
        py = np.minimum(np.maximum(py, np.float32(0)), np.nextafter(np.float32(size[1]), np.float32(0)))
        gx, gy = px * inverse[0] - one / two, py * inverse[1] - one / two
        i, j = np.floor(gx).astype(int), np.floor(gy).astype(int)
        fx, fy = gx - i.astype(np.float32), gy - j.astype(np.float32)
        cells = [
            [height[np.clip(b, 0, ny - 1), np.clip(a, 0, nx - 1)] for a in (i, i + 1)] for b in (j, j + 1)
        ]
        west, east = ((one - fy) * cells[0][k] + fy * cells[1][k] for k in (0, 1))
        return (one - fx) * west + fx * east

    begin, end = heights(x, y) + eye, heights(x + dx, y + dy) + top
    steps = np.ceil(np.sqrt(dx * dx + dy * dy) * max(inverse[0], inverse[1]) * two).astype(int)
    hidden = np.zeros(x.size, np.bool_)
    for s in range(1, steps.max()):
        t = np.where(s < steps, np.float32(s) / np.maximum(steps, 1).astype(np.float32), one)
        over = heights(x + t * dx, y + t * dy) > begin + t * (end - begin)
        hidden |= over & (s < steps)
    return hidden


def test_sight_over_a_real_relief_is_the_plain_line_of_sight_for_100_000_pairs():
    from ecs_eco.config import load

    config = load(
        {
            "format": 1,
            "name": "fault",
            "space": {"size": [29_000.0, 31_000.0], "edges": "walls"},
            "terrain": {"raster": FAULT, "crs": "EPSG:4326", "cell": 90.0},
            "species": {"ox": OX},
        }
    )
    height, (ny, nx) = config._land.elevation, config._land.elevation.shape
    space = Space(config.space.size, "walls")
    inverse = np.array([nx / 29_000, ny / 31_000], np.float32)
    rng, n = np.random.default_rng(21), 100_000
    x, y = ((rng.random(n) * side).astype(np.float32) for side in config.space.size)
    way, angle = (rng.random(n) * 6000).astype(np.float32), rng.random(n) * 2 * np.pi
    there = [
        np.clip(a + way * f(angle), 0, side - 1)
        for a, f, side in ((x, np.cos, 29_000.0), (y, np.sin, 31_000.0))
    ]
    dx, dy = ((b - a).astype(np.float32) for a, b in zip((x, y), there, strict=True))
    eye, top = (rng.choice([0.5, 2.0, 30.0], n).astype(np.float32) for _ in range(2))
    plain = _line_of_sight(x, y, dx, dy, eye, top, height, inverse, config.space.size)
    ground = Ground(OPEN_GROUND.kind, height, inverse)
    ours = np.array(
        [hill_between(*pair, ground, space.extent) for pair in zip(x, y, dx, dy, eye, top, strict=True)]
    )
    assert 0.3 < plain.mean() < 0.9  # neither all nor nothing is hidden
    assert int((plain != ours).sum()) == 0


# --- keeping


def test_saved_worlds_find_their_land_again_and_refuse_another(made, tmp_path):
    world = made([[0, 1, 2, 3]] * 4, classes={"high": {"above": 2.0, "pace": 0.5}})
    again = World.restore(world.run(3).save(tmp_path / "w.safetensors"))
    assert again.digest() == world.digest()
    assert np.array_equal(again.terrain.pace, world.terrain.pace)
    np.savez(tmp_path / "dem.npz", topo=np.ones((4, 4)))
    with pytest.raises(CheckpointError, match="has changed since"):
        World.restore(tmp_path / "w.safetensors")


def test_a_run_keeps_its_land_and_goes_on_without_the_file(made, tmp_path):
    from ecs_eco.record import resume, run_to_folder

    config = made([[0, 1, 2, 3]] * 4, classes={"high": {"above": 2.0, "pace": 0.5}}).config
    run_to_folder(config, ticks=4, out=tmp_path / "run", report=False)
    whole = run_to_folder(config, ticks=8, out=tmp_path / "whole", report=False)
    (tmp_path / "dem.npz").unlink()
    assert resume(tmp_path / "run", until=8, report=False)["digest"] == whole["digest"]
    kept = np.load(tmp_path / "run" / "terrain.npz")
    assert kept["height"].shape == kept["ground"].shape == (4, 4)
    np.savez(tmp_path / "run" / "terrain.npz", **{**kept, "elevation": kept["elevation"] + 1})
    with pytest.raises(ValueError, match="land"):
        resume(tmp_path / "run", until=9, report=False)


def test_a_living_world_needs_its_files_no_more(made, tmp_path):
    world = made([[0, 1, 2, 3]] * 4).run(1)
    (tmp_path / "dem.npz").unlink()
    assert world.copy().digest() == world.digest()
    world.intervene({"kind": "add", "at": 1, "species": "ox", "count": 3})
    assert world.run(1).tables["ox"].n == 4


def test_other_land_is_another_digest(made):
    dem = np.zeros((4, 4))
    one = made(dem).digest()
    assert made(dem).digest() == one
    dem[3, 3] = 1e-3
    assert made(dem).digest() != one
