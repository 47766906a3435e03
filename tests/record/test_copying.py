"""A copy lives on its own and goes on to the same bytes; a fork has other chance from there."""

import copy

import numpy as np
import pytest

from ecs_eco import System, World
from ecs_eco.components import Metabolism, Position
from ecs_eco.engine.errors import CheckpointError


@pytest.fixture(params=["predator-prey", "reflexes", "diel-migration"])
def world(request):
    return World.from_config(
        request.param, seed=4, policies="untrained", learn=True if request.param == "predator-prey" else None
    )


def test_a_copy_has_the_same_digest_and_the_same_future(world):
    world.run(7)
    twin = world.copy()
    assert twin.digest() == world.digest()
    assert twin.run(9).digest() == world.run(9).digest()


def test_a_copy_is_of_its_own(world):
    before = world.run(3).digest()
    twin = world.copy()
    twin.run(4)
    assert world.digest() == before
    assert twin.digest() != before
    for name, table in world.tables.items():
        for component, columns in table.columns.items():
            for field, array in vars(columns).items():
                theirs = getattr(twin.tables[name][component], field)
                assert isinstance(array, np.ndarray) is False or not np.shares_memory(array, theirs)


def test_a_copy_takes_along_what_is_asked_for():
    world = World.from_config("predator-prey", seed=4, policies="untrained").run(2)
    world.spawn("deer", Position(x=1.0, y=1.0), n=3)
    world.intervene({"kind": "cull", "species": "wolf", "share": 0.5})
    twin = world.copy(threads=2)
    assert twin.run(3).digest() == world.run(3).digest()


def test_a_copy_records_on_its_own():
    world = World.from_config("predator-prey", seed=4, policies="untrained").run(2)
    twin = world.copy().run(3)
    assert twin.series().equals(world.run(3).series())


def test_a_fork_has_other_chance_from_there(world):
    world.run(3)
    forks = [world.fork(seed=seed) for seed in (1, 2, 1, world.seed)]
    assert forks[3].digest() == world.digest()
    digests = [fork.run(5).digest() for fork in forks]
    assert digests[0] == digests[2] != digests[1]
    assert digests[3] == world.run(5).digest()


@pytest.mark.parametrize("how", [copy.copy, copy.deepcopy, lambda world: world.__reduce__()])
def test_other_ways_to_copy_are_refused(how):
    with pytest.raises(TypeError, match=r"world\.(copy\(\)|save\(path\))"):
        how(World())


def test_a_world_made_by_hand_is_copied_by_making_another(tmp_path):
    def make():
        world = World((10.0, 10.0))
        world.add_table("ant", Position, Metabolism)
        return world

    world = make()
    world.spawn("ant", n=3)
    world.run(2)
    with pytest.raises(CheckpointError, match="copy of the world 'world': it was built by hand"):
        world.copy()
    other = make()
    other.load(world.save(tmp_path / "w.safetensors"))
    assert other.digest() == world.digest()


class Starve(System):
    needs = (Metabolism,)

    def update(self, table, world):
        table[Metabolism].energy[: table.high] *= np.float32(0.999)


def test_a_system_of_ones_own_is_made_anew_for_a_copy():
    named = World.from_config("reflexes", seed=1, policies="untrained", systems=[Starve]).run(2)
    assert named.copy().run(2).digest() == named.run(2).digest()
    handed = World.from_config("reflexes", seed=1, policies="untrained", systems=[Starve()]).run(2)
    with pytest.raises(
        CheckpointError, match=r"Starve was passed as an instance.*world.copy\(systems=\[…\]\)"
    ):
        handed.copy()
    assert handed.copy(systems=[Starve()]).run(2).digest() == handed.run(2).digest()
    added = World.from_config("reflexes", seed=1, policies="untrained").run(2)
    added.add_system(Starve())
    with pytest.raises(CheckpointError, match="copy of the world 'reflexes': was saved with the systems"):
        added.copy()
    assert added.copy(prepare=lambda w: w.add_system(Starve())).run(2).digest() == added.run(2).digest()
