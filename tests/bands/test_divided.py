import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from ecs_eco import World
from ecs_eco.bands import divide
from ecs_eco.bands.widths import eaters_in_line
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError

ROAMING = str(Path(__file__).parents[2] / "examples" / "roaming.toml")  # speeds and turns are numbers
SHORT = {
    "predator-prey": [
        "species.deer.ppo.horizon=8",
        "species.wolf.ppo.horizon=8",
        "space.cell=2.0",  # low rows, so that edges shift
        "species.deer.ppo.minibatch_size=4096",
        "space.size=[120.0, 120.0]",
        "species.grass.count=1000",
        "species.deer.count=600",
        "species.wolf.count=80",
    ],
    "reflexes": [
        "species.goat.ppo.horizon=8",
        "species.goat.reproduction.age_min=5.0",
        "species.goat.max_count=500",
        "species.green.max_count=3520",
        "species.goat.reproduction.energy_min=0.5",
    ],
    ROAMING: [
        "species.deer.ppo.horizon=8",
        "species.deer.metabolism.energy=0.9",
        "species.deer.metabolism.basal=0.03",
        "species.deer.reproduction.rate=0.2",
    ],
}
SAME = """
import json, sys
from mpi4py import MPI
from ecs_eco import World
from ecs_eco.bands import divide, divided
from ecs_eco.components import Position
from ecs_eco.config import load

divided.EVERY, divided.UNEVEN = 4, 1.0
name, ticks, changes, policies = json.loads(sys.argv[1])
comm = MPI.COMM_WORLD
one, many = (World.from_config(load(name, changes), seed=3, policies=policies, learn=True) for _ in range(2))
one.run(4)
many.run(4)
bands = divide(many, state=True)
seen = {"part": True, "births": many.next_uid, "deaths": 0}
many.on_death.append(lambda table, rows: seen.update(deaths=seen["deaths"] + len(rows)))
for tick in range(ticks):
    one.run(1)
    many.run(1)
    for table in many.tables.values():
        all_ = comm.allreduce(table.n)
        seen["part"] &= all_ == one.tables[table.name].n and (table.n < all_ or comm.size == 1)
same = one.digest() == many.digest()
counts = [{c: world.series()[c].to_pylist() for c in ("tick", "n", "births", "deaths", "refused")}
          for world in (one, many)]
same &= comm.rank > 0 or counts[0] == counts[1]
path = "the-whole.safetensors"
many.save(path)
if comm.rank == 0:
    resumed = World.restore(path, record=False)
    one.run(9)
    resumed.run(9)
    same &= one.digest() == resumed.digest()
many.run(9)
if comm.rank:
    one.run(9)
same &= one.digest() == many.digest()
deaths, moved = comm.allreduce(seen["deaths"]), comm.allreduce(bands.moved)
if comm.rank == 0:
    print(json.dumps({"same": same, "part": seen["part"], "births": many.next_uid - seen["births"],
                      "deaths": deaths, "moved": moved, "shifts": bands.shifts}), flush=True)
"""
HAND = """
from mpi4py import MPI
from ecs_eco import World
from ecs_eco.bands import divide
from ecs_eco.bands.widths import eaters_in_line

try:
    divide(World(), state=True)
except Exception as error:
    print("refused", MPI.COMM_WORLD.rank, error, flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "n"),
    [*((name, n) for name in ("predator-prey", "reflexes") for n in (1, 2, 4)), (ROAMING, 3)],
    ids=lambda value: Path(str(value)).stem,
)
def test_each_process_holds_a_part_and_together_they_are_the_world_of_one(mpirun, name, n):
    policies = "untrained" if name == ROAMING else "trained"
    ended = mpirun(n, SAME, json.dumps([name, 28, SHORT[name], policies]))
    assert ended.returncode == 0, ended.stdout + ended.stderr
    said = json.loads(ended.stdout)
    assert said["same"]
    assert said["part"]
    assert said["births"] > 20
    assert said["deaths"] > 20
    if n > 1:
        assert said["moved"] > 20
        assert said["shifts"] > 0


@pytest.mark.slow
def test_all_processes_are_told_what_cannot_be_divided(mpirun):
    ended = mpirun(2, HAND)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert ended.stdout.count("refused") == 2
    assert "a world built in Python" in ended.stdout


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        ("diel-migration", [], ["space.size", "a volume", "with water"]),
        ("lamb", [], ["with substances", "the system Suckle"]),
        ("happiness", [], ["species.berry.genome", "plants with genes"]),
        ("predator-prey", ['species.wolf.diet.0.confusion="deer"'], ["diet.0.confusion", "confused by"]),
        ("predator-prey", ['species.wolf.diet.0.eats="wolf"'], ["species", "can eat itself"]),
    ],
)
def test_a_world_that_cannot_be_divided_is_refused_with_what_can_be_done(name, changes, words, alone):
    world = World.from_config(load(name, changes), seed=1, record=False)
    with pytest.raises(ConfigError) as error:
        divide(world, alone(2), state=True)
    for word in [*words, "--bands without --divided"]:
        assert word in str(error.value)


def test_a_meal_reaches_as_far_as_the_food_chain_is_long():
    def table(name, *foods):
        return SimpleNamespace(
            name=name, species=SimpleNamespace(diet=[SimpleNamespace(eats=f) for f in foods])
        )

    tables = [table("a", "b"), table("b", "c", "e"), table("c", "d"), table("d"), table("e", "d")]
    assert [eaters_in_line(tables[i:]) for i in range(4)] == [3, 2, 1, 1]
    assert eaters_in_line([table("a", "b"), table("b", "a")]) > 2


def test_bands_lower_than_ghosts_reach_are_refused_with_the_numbers(alone):
    world = World.from_config(load("predator-prey", SHORT["predator-prey"]), seed=1, record=False)
    with pytest.raises(ConfigError, match=r"9 bands would be 13.3333 m high.* 14 m: 12.4 m for sens"):
        divide(world, alone(9), state=True)
