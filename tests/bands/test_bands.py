import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.bands import Bands
from ecs_eco.config import load

SHORT = [
    "species.deer.ppo.horizon=8",
    "species.wolf.ppo.horizon=8",
    "species.deer.ppo.minibatch_size=4096",
    "species.goat.ppo.horizon=8",
    "space.size=[120.0, 120.0]",
    "species.grass.count=1000",
    "species.deer.count=600",
    "species.wolf.count=80",
]
SAME = """
import json, sys
from mpi4py import MPI
from ecs_eco import World
from ecs_eco.bands import divide
from ecs_eco.config import load

for name, learn, ticks, changes in json.loads(sys.argv[1]):
    one, many = (World.from_config(load(name, changes), seed=3, learn=learn, record=False) for _ in range(2))
    bands = divide(many, least=8)
    one.run(ticks)
    many.run(ticks)
    same = one.digest() == many.digest()
    MPI.COMM_WORLD.Barrier()
    if MPI.COMM_WORLD.rank == 0:
        print(name, "same" if same and bands.traffic.received else "OTHER", bands.traffic, flush=True)
    if not same:
        MPI.COMM_WORLD.Abort(3)
"""


def of(name):
    """Return those of the changes that concern a world."""
    known = load(name).species
    return [c for c in SHORT if c.split(".")[1] in known or (c.startswith("space") and "deer" in known)]


def run_same(mpirun, n, cases):
    import json

    ended = mpirun(n, SAME, json.dumps(cases))
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "OTHER" not in ended.stdout
    assert ended.stdout.count("same") == len(cases)


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 4])
def test_the_world_is_the_same_in_one_process_and_in_bands_while_all_learn(mpirun, n):
    run_same(mpirun, n, [(name, True, 20, of(name)) for name in ("predator-prey", "reflexes")])


@pytest.mark.slow
def test_every_shipped_world_is_the_same_in_bands(mpirun):
    run_same(
        mpirun,
        3,
        [
            (name, None, 12, [])
            for name in ("diel-migration", "happiness", "innate", "island", "lamb", "learning-krill")
        ],
    )


def test_bands_are_whole_rows_of_cells_with_about_as_many_organisms(alone):
    world = World.from_config(load("predator-prey"), seed=1, record=False)
    world.flush()
    index = world.index(world.tables["deer"])
    for size in (1, 2, 5, 1000):
        rows, entries = Bands(world, alone(size)).cut(index)
        along = index.start[:: index.space.shape[0]]
        assert rows[0] == 0
        assert rows[-1] == index.space.shape[1]
        assert entries[-1] == index.n
        assert (np.diff(rows) >= 0).all()
        assert (along[rows] == entries).all()
        fullest = np.diff(along).max()
        assert np.diff(entries).max() <= index.n / size + fullest


def test_parts_and_fields_of_all_processes_are_everything_once(alone):
    world = World()
    for size in (1, 3, 7):
        all_bands = [Bands(world, alone(size, rank)) for rank in range(size)]
        parts = [band.part(10) for band in all_bands]
        assert [i for first, last in parts for i in range(first, last)] == list(range(10))
        assert sorted(name for band in all_bands for name in band.mine("abcd")) == list("abcd")


def test_within_a_band_a_kernel_runs_over_that_band_alone_and_elsewhere_over_all(alone):
    world = World.from_config(load("predator-prey"), seed=1, record=False)
    world.flush()
    index, seen = world.index(world.tables["deer"]), []
    bands = world.bands = Bands(world, alone(4, 1))
    rows, entries = bands.cut(index)
    with bands.over(index):
        for n in (index.n, index.space.shape[1], 17):
            world.split(lambda first, last: seen.append((first, last)), n)
    world.split(lambda first, last: seen.append((first, last)), index.n)
    assert seen == [tuple(entries[1:3]), tuple(rows[1:3]), (0, 17), (0, index.n)]
