import numpy as np
import pytest

from ecs_eco.components import Growth, Position
from ecs_eco.engine import random
from ecs_eco.engine.random import draw
from ecs_eco.space.geometry import Space
from ecs_eco.space.terrain import OPEN_GROUND
from ecs_eco.space.world import SpatialWorld
from ecs_eco.systems import Spread
from ecs_eco.systems.spread import EVERYWHERE, Seeds, Sprouts, listed, sprout, stands
from ecs_eco.testing import act, arrange

WAY = {"kind": "spread", "rate": 0.5, "seed_rain": 0.0, "spacing": 2.0}


def _slow(taken, rate, rain, reach, torus, key, vigour=None):
    ny, nx = taken.shape
    out = []
    for s in range(taken.size):
        j, i = divmod(s, nx)
        u = draw(key, s, random.SPREAD)
        if taken[j, i] >= 0 or u >= rate + rain:
            continue
        if u >= rate:
            out.append((s, -1))
            continue
        a, b = draw(key, s, random.SPREAD + (1 << 8)), draw(key, s, random.SPREAD + (2 << 8))
        if reach:
            jj, ii = j + int(a * (2 * reach + 1)) - reach, i + int(b * (2 * reach + 1)) - reach
        else:
            jj, ii = int(a * ny), int(b * nx)
        if torus:
            jj, ii = jj % ny, ii % nx
        if 0 <= jj < ny and 0 <= ii < nx and taken[jj, ii] >= 0:
            if vigour is None or draw(key, s, random.SPREAD + (5 << 8)) < vigour[taken[jj, ii]]:
                out.append((s, taken[jj, ii]))
    return out


@pytest.mark.parametrize("reach", [0, 1, 3])
@pytest.mark.parametrize("torus", [True, False])
@pytest.mark.parametrize(
    "vigour", [np.zeros(0, np.float32), np.linspace(0, 1, 810, dtype=np.float32)], ids=["even", "uneven"]
)
def test_the_kernel_is_its_slow_twin(reach, torus, vigour):
    rng = np.random.default_rng(1)
    taken = np.where(rng.random((27, 30)) < 0.4, rng.permutation(810).reshape(27, 30), -1)
    site, parent, parents = np.empty(810, np.int64), np.empty(810, np.int64), np.empty(810, np.uint64)
    uid, found = np.arange(500, 1310, dtype=np.uint64), np.empty(4, np.int64)
    key = random.tick_key(3, 4)
    scale = np.array([1, 1], np.float32)
    room_for = Sprouts(site, parent, parents, *np.empty((2, 810), np.float32), found)
    seeds = Seeds(np.float32(0.6), np.float32(0.2), reach, vigour, key, 0, uid)
    space = Space((30.0, 27.0), "torus" if torus else "walls").extent
    for first, last in ((3, 4), (0, 1), (1, 3)):  # blocks, in any order
        sprout(first, last, taken, seeds, EVERYWHERE, scale, OPEN_GROUND, space, room_for)
    assert found[2] == 0  # it was no first block
    site, parent, parents, _, _ = listed(room_for, found, found.nonzero()[0])
    n = site.size
    assert parents[:n].tolist() == [0 if row < 0 else 500 + row for row in parent[:n].tolist()]
    assert list(zip(site[:n].tolist(), parent[:n].tolist(), strict=True)) == _slow(
        taken, np.float32(0.6), np.float32(0.2), reach, torus, key, vigour if vigour.size else None
    )
    assert n > 100


def _grow(world):
    act(world, Spread)
    world.flush()
    world.tick += 1


def _meadow(meadow, count, way, world=None, **grass):
    return meadow(world=world, grass={"count": count, "reproduction": WAY | way, **grass})


def _sites(world):
    p, rows = world.tables["grass"][Position], world.tables["grass"].rows()
    return [(int(x / 2), int(y / 2)) for x, y in zip(p.x[rows], p.y[rows], strict=True)]


def test_one_plant_stands_on_a_site_from_the_start_and_for_ever(meadow):
    world = _meadow(meadow, 60, {"seed_rain": 0.05})
    for _ in range(30):
        sites = _sites(world)
        assert len(set(sites)) == len(sites)
        _grow(world)
    assert world.tables["grass"].n == 100
    _grow(world)
    assert world.tables["grass"].n == 100


def test_growth_is_logistic_with_a_seed_rain(meadow):
    world = _meadow(
        meadow, 3600, {"rate": 0.6, "seed_rain": 0.02, "spacing": 1.0}, {"space": {"size": [120.0, 120.0]}}
    )
    for _ in range(4):
        before = world.tables["grass"].n
        share = before / 14_400
        for _ in range(1000):  # the slow twin: dp/dt = (rain + rate p)(1 − p) in small steps
            share += 0.001 * (0.02 + 0.6 * share) * (1 - share)
        _grow(world)
        expected = share * 14_400 - before
        assert abs(world.tables["grass"].n - before - expected) < 3.5 * np.sqrt(expected)


def test_without_rain_nothing_comes_from_nothing(meadow):
    world = _meadow(meadow, 1, {"rate": 1.0})
    world.kill(int(world.tables["grass"].uid[0]))
    world.flush()
    act(world, Spread)
    world.flush()
    assert world.tables["grass"].n == 0


def test_parents_are_the_plants_whose_seeds_sprout_and_near_ones_stay_near(meadow):
    world = _meadow(meadow, 1, {"rate": 1.0, "place": "near", "dispersal": 2.0})
    grass = arrange(world, "grass", x=1, y=1)
    mother, born = int(grass.uid[0]), []
    world.on_birth.append(lambda table, rows, parents, _: born.extend(parents.tolist()))
    for _ in range(30):
        act(world, Spread)
        if grass.births:
            break
        world.tick += 1
    world.flush()
    assert set(born) == {mother}
    assert set(_sites(world)) <= {(i % 10, j % 10) for i in (-1, 0, 1) for j in (-1, 0, 1)}


def test_nothing_grows_on_rock_or_water_nor_beyond_max_count(meadow):
    world = _meadow(
        meadow,
        30,
        {"rate": 1.0, "seed_rain": 1.0},
        {"terrain": {"cell": 2.0, "lakes": [{"at": [10.0, 10.0], "radius": 6.0}]}},
    )
    for _ in range(20):
        _grow(world)
    p, rows = world.tables["grass"][Position], world.tables["grass"].rows()
    assert world.terrain.free(p.x[rows], p.y[rows]).all()
    assert world.tables["grass"].n == (world.terrain.ground == 0).sum()
    few = _meadow(meadow, 30, {"rate": 1.0, "seed_rain": 1.0}, max_count=33)
    act(few, Spread)
    few.flush()
    assert few.tables["grass"].n == 33


def test_max_count_leaves_room_for_seeds_anywhere(meadow):
    world, y = _meadow(meadow, 1, {"rate": 0.0, "seed_rain": 50.0}, max_count=6), []
    grass = arrange(world, "grass", x=1, y=1)
    for world.tick in range(60):
        act(world, Spread)
        y += [v for _, _, values in grass.births for v in values[Position, "y"]]
        grass.births = []
    assert len(y) == 300
    assert abs(np.mean(y) - 10) < 4 * 20 / np.sqrt(12 * 300)  # the middle of the world
    assert grass.species.refused == 60 * (99 - 5)


def test_two_species_of_plants_do_not_sprout_on_the_same_sites(meadow):
    way = {"count": 1, "reproduction": WAY | {"rate": 0.0, "seed_rain": 0.2, "spacing": 1.0}}
    world = meadow(world={"species": {"fern": {"body": {"radius": 0.25, "opaque": False}, **way}}}, grass=way)
    act(world, Spread)
    sites = []
    for name in ("grass", "fern"):
        values = world.tables[name].births[0][2]
        sites.append(
            {(int(x), int(y)) for x, y in zip(values[Position, "x"], values[Position, "y"], strict=True)}
        )
    assert len(sites[0] & sites[1]) < 0.5 * len(sites[0])  # a fifth by chance


def test_what_is_spent_on_defence_does_not_sprout(meadow):
    def births(defence):
        world = _meadow(
            meadow, 800, {"rate": 0.4, "spacing": 1.0}, {"space": {"size": [40.0, 40.0]}}, defence=defence
        )
        before = world.tables["grass"].n
        _grow(world)
        return world.tables["grass"].n - before

    free, dear = births({}), births({"toughness": 0.5, "poison": 0.5, "cost": 0.5})
    assert births({"toughness": 0.5, "poison": 0.5}) == free  # defence without a cost
    assert dear == pytest.approx(free / 2, rel=0.2)


def test_seeds_of_better_spreaders_take_more_sites(meadow):
    genome = {
        "loci": 4,
        "genes": [
            {"name": "runner", "trait": "reproduction.spread", "letters": 1, "values": [0.0, 0.25, 0.5, 1.0]}
        ],
    }
    world = _meadow(
        meadow, 800, {"rate": 0.4, "spacing": 1.0}, {"space": {"size": [40.0, 40.0]}}, genome=genome
    )
    grass, born = world.tables["grass"], []
    world.on_birth.append(
        lambda table, rows, first, second: born.extend(first.tolist()) if table is grass else None
    )
    spread = {
        int(u): float(s)
        for u, s in zip(grass.uid[grass.rows()], grass[Growth].spread[grass.rows()], strict=True)
    }
    _grow(world)
    counts = {rate: sum(spread[uid] == rate for uid in born) for rate in (0.0, 0.25, 0.5, 1.0)}
    assert len(born) > 50
    assert next(iter(counts.values())) == 0
    assert sorted(counts.values()) == list(counts.values())
    assert counts[1.0] == pytest.approx(4 * counts[0.25], rel=0.6)


@pytest.mark.parametrize("mark", ["lakes", "rocks"])
def test_at_the_rim_of_a_lake_or_a_rock_plants_stand_on_the_ground(meadow, mark):
    # 25 sites of 4 m; a lake around (10, 10) of 3.5 m covers one, and the rims of the four beside it, with
    # centres 4 m away
    terrain = {"cell": 0.5, mark: [{"at": [10.0, 10.0], "radius": 3.5}]}
    way = WAY | {"spacing": 4.0, "rate": 0.0, "seed_rain": 50.0}
    centred = []
    for seed in range(4):
        world = meadow(
            world={"space": {"size": [20.0, 20.0]}, "terrain": terrain},
            options={"seed": seed},
            grass={"count": 12, "reproduction": way},
        )
        table = world.tables["grass"]
        for number in (12, 24):  # founders, then seed rain on all that is left
            rows = table.rows()
            x, y = table[Position].x[rows], table[Position].y[rows]
            assert rows.size == number
            assert world.terrain.free(x, y).all()
            assert len(set(zip(x // 4, y // 4, strict=True))) == number
            centred += [(a, b) for a, b in zip(x.tolist(), y.tolist(), strict=True) if a % 4 == b % 4 == 2]
            act(world, Spread)
            world.flush()
    assert centred
    assert set(centred) <= {(6.0, 10.0), (14.0, 10.0), (10.0, 6.0), (10.0, 14.0)}


@pytest.mark.parametrize("crowded", [False, True], ids=["one a site", "two on some"])
def test_sites_are_known_whoever_was_born_or_died_since(crowded):
    world, rng, inverse = SpatialWorld((20.0, 20.0)), np.random.default_rng(5), np.ones(2, np.float32)
    table, sites = world.add_table("grass", Position), np.full((20, 20), -1, np.int64)
    for turn in range(30):
        free = np.flatnonzero(sites.reshape(-1) < 0)
        for site in rng.choice(400 if crowded else free, 9 if turn else 60, replace=False).tolist():
            world.spawn("grass", Position(x=site % 20 + 0.5, y=site // 20 + 0.5))
        world.flush()
        if turn % 5 == 3:  # some are born and die before anybody looks
            table.cause[rng.choice(table.rows(), 9, replace=False)] = world.cause("eaten")
            world.flush()
        stands(table.alive[: table.high], table[Position].x, table[Position].y, inverse, sites)
        assert (sites == _who_stands_where(table, sites.shape)).all()


def _who_stands_where(table, shape):
    taken = np.full(shape, -1)
    for row in table.rows():  # the last stands there
        taken[int(table[Position].y[row]), int(table[Position].x[row])] = row
    return taken
