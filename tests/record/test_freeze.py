"""Worlds that go on from a checkpoint: to the same bytes, whatever was cut, where and how often."""

import os
import subprocess
import sys

import esper
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from ecs_eco import System, World, component, f32
from ecs_eco.components import Biology, Metabolism, Position
from ecs_eco.engine.errors import CheckpointError, ConfigError
from ecs_eco.record import Recorder
from ecs_eco.testing import all_threads
from tests.worlds.herd import herd as herd_with


@component
class Wool:
    """The coat of one animal."""

    length: f32 = 0.01  # [m]


class Counter(System):
    """Counts ticks."""

    phase = "record"

    def __init__(self, n=0):
        self.n = n

    def process(self, *_):
        self.n += 1

    def state(self):
        return {"n": np.array(self.n)}

    def load(self, state):
        self.n = int(state["n"])


class Nothing(System):
    """Does nothing, as often as it was told to."""

    def __init__(self, times=1):
        self.times = times

    def process(self, *_):
        pass


class Tag:
    """A plain component of a user's own that can be saved."""

    def __init__(self, number):
        self.number = number

    def state(self):
        return {"number": np.array(self.number)}

    @classmethod
    def restore(cls, state):
        return cls(int(state["number"]))


class Secret:
    """One that cannot."""


@pytest.fixture
def herd():
    """The configuration of the herd with genes for everything, individual brains and sexual reproduction."""
    config = herd_with()
    config["species"]["goat"]["components"] = []
    config["species"]["goat"]["genome"]["genes"] = [
        g for g in config["species"]["goat"]["genome"]["genes"] if g["name"] != "wool"
    ]
    return config


def _same(one, two):
    return one.digest() == two.digest() and one.series().equals(two.series())


@pytest.mark.slow
@pytest.mark.parametrize("split", [0, 1, 17, 40])
def test_a_world_goes_on_from_a_checkpoint_to_the_same_bytes(menagerie, tmp_path, split):
    whole = World.from_config(menagerie(), policies="untrained", learn=True).run(50)
    begun = World.from_config(menagerie(), policies="untrained", learn=True).run(split)
    path = begun.save(tmp_path / "world.safetensors")
    world = World.restore(path)
    assert world.digest() == begun.digest()
    world.run(50 - split)
    assert _same(world, whole)
    assert _same(begun.run(50 - split), whole)  # saving changes nothing


@pytest.mark.slow
@settings(max_examples=20, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
@given(splits=st.lists(st.integers(0, 45), min_size=1, max_size=3), individual=st.booleans())
def test_wherever_and_however_often_a_run_is_cut_it_ends_the_same(
    menagerie, herd, tmp_path, splits, individual
):
    def make():
        return (
            World.from_config(herd)
            if individual
            else World.from_config(menagerie(), policies="untrained", learn=True)
        )

    world = make()
    for split in sorted(splits):
        world = World.restore(world.run(split - world.tick).save(tmp_path / "world.safetensors"))
    assert _same(world.run(45 - world.tick), make().run(45))


@pytest.mark.parametrize("split", [3, 30])
def test_individual_brains_pregnancies_and_genomes_go_on_too(herd, tmp_path, split):
    whole = World.from_config(herd).run(45)
    world = World.restore(World.from_config(herd).run(split).save(tmp_path / "herd.safetensors")).run(
        45 - split
    )
    assert _same(world, whole)


def test_who_comes_later_starts_from_the_same_trained_brain_after_a_restore(herd, tmp_path):
    from safetensors.numpy import save_file

    from ecs_eco.learning import Brain

    nerves = World.from_config(herd).tables["goat"].species.nerves
    brain = Brain(len(nerves.channels), nerves.choices, (6,), seed=9)
    save_file(brain.state(), tmp_path / "goat.safetensors")
    begun = World.from_config(herd, policies=str(tmp_path)).run(3)
    other = World.restore(begun.save(tmp_path / "world.safetensors"))
    newcomers = {"kind": "add", "species": "goat", "count": 5}
    for world in (begun, other):
        world.intervene(newcomers)
        world.run(4)
    assert _same(other, begun)


def test_a_checkpoint_may_go_on_with_another_number_of_threads(menagerie, tmp_path):
    config = menagerie(species={"ram": {"count": 120}})
    whole = World.from_config(config, policies="untrained", learn=True).run(30)
    path = (
        World.from_config(config, policies="untrained", learn=True)
        .run(11)
        .save(tmp_path / "world.safetensors")
    )
    with all_threads():
        assert _same(World.restore(path, threads=2).run(19), whole)


def test_a_new_process_goes_on_to_the_same_bytes(menagerie, tmp_path):
    whole = World.from_config(menagerie(), policies="untrained", learn=True).run(40)
    path = (
        World.from_config(menagerie(), policies="untrained", learn=True)
        .run(21)
        .save(tmp_path / "world.safetensors")
    )
    script = f"from ecs_eco import World\nprint(World.restore({str(path)!r}).run(19).digest())"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, env=os.environ
    )
    assert done.stdout.strip() == whole.digest()


def test_rows_stay_where_they_were_so_that_newborn_take_the_same(menagerie, tmp_path):
    world = World.from_config(menagerie(), policies="untrained").run(40)
    other = World.restore(world.save(tmp_path / "w.safetensors"))
    for name, table in world.tables.items():
        mine = other.tables[name]
        assert mine.rows().tolist() == table.rows().tolist()
        assert (mine.high, mine.n, mine.capacity) == (table.high, table.n, table.capacity)


def test_births_asked_for_and_deaths_not_yet_carried_out_are_kept(menagerie, tmp_path):
    def make():
        world = World.from_config(menagerie(), policies="untrained").run(5)
        world.spawn("ram", Position(x=3.0, y=4.0), Metabolism(energy=0.5), n=3, parent=7)
        world.kill(
            int(world.tables["ram"].uid[world.tables["ram"].by_uid()[0]]), "struck by lightning", killer=9
        )
        return world

    other = World.restore(make().save(tmp_path / "w.safetensors"))
    assert _same(other.run(5), make().run(5))
    assert "struck by lightning" in other.causes


def test_what_frozen_learning_and_random_policies_were_they_stay(menagerie, tmp_path):
    for i, options in enumerate(
        ({"policies": "random"}, {"policies": "untrained", "learn": False}, {"policies": {"ram": "random"}})
    ):
        whole = World.from_config(menagerie(), **options).run(20)
        assert _same(
            World.restore(
                World.from_config(menagerie(), **options).run(9).save(tmp_path / f"{i}.safetensors")
            ).run(11),
            whole,
        )


def test_controls_stay_in_force(herd, tmp_path):
    whole = World.from_config(herd, controls=("no-mutation", "neutral-drift")).run(40)
    begun = World.from_config(herd, controls=("no-mutation", "neutral-drift")).run(10)
    assert _same(World.restore(begun.save(tmp_path / "w.safetensors")).run(30), whole)


def test_pre_training_goes_on_too(menagerie, tmp_path):
    whole = World.from_config(menagerie(), policies="untrained", training=True, learn=True).run(30)
    begun = World.from_config(menagerie(), policies="untrained", training=True, learn=True).run(13)
    assert _same(World.restore(begun.save(tmp_path / "w.safetensors")).run(17), whole)


def test_systems_with_a_state_keep_it_and_instances_are_handed_in_again(menagerie, tmp_path):
    world = World.from_config(menagerie(), policies="random", systems=[Counter(5), Nothing(3)]).run(4)
    path = world.save(tmp_path / "w.safetensors")
    with pytest.raises(CheckpointError, match=r"Nothing was passed as an instance.*systems="):
        World.restore(path)
    other = World.restore(path, systems=[Nothing(3), Counter()]).run(2)
    assert next(s for s in other.systems if isinstance(s, Counter)).n == 11
    assert next(s for s in other.systems if isinstance(s, Nothing)).times == 3


def test_a_world_made_by_hand_is_made_again_and_loaded(tmp_path):
    def make():
        world = World((50.0, 50.0), seed=3)
        table = world.add_table("sheep", Position, Biology, Wool)
        world.add_system(Counter())
        return world, table

    world, _ = make()
    world.spawn("sheep", Position(x=3.0), Wool(length=0.5), n=4)
    world.run(3)
    path = world.save(tmp_path / "hand.safetensors")
    with pytest.raises(CheckpointError, match=r"built by hand.*world\.load"):
        World.restore(path)
    other, mine = make()
    other.load(path)
    assert other.digest() == world.digest()
    assert mine[Wool].length[mine.rows()].tolist() == [0.5] * 4
    assert other.run(1).tick == 4


def test_a_world_that_is_made_otherwise_is_left_as_it_was(tmp_path):
    world = World((50.0, 50.0), seed=3)
    world.add_table("sheep", Position, Wool)
    world.spawn("sheep", n=2)
    path = world.run(1).save(tmp_path / "hand.safetensors")
    for table, components, word in (
        ("goat", (Position, Wool), "tables sheep"),
        ("sheep", (Position,), "Wool of sheep"),
    ):
        other = World((50.0, 50.0), seed=4)
        other.add_table(table, *components)
        before = other.digest()
        with pytest.raises(CheckpointError, match=word):
            other.load(path)
        assert other.digest() == before
    other = World((50.0, 50.0), seed=4, dt=0.5)
    other.add_table("sheep", Position, Wool)
    with pytest.raises(CheckpointError, match=r"dt = 1\.0 s, but this world has 0\.5 s"):
        other.load(path)


def test_plain_components_with_the_protocol_are_saved_and_others_refused(menagerie, tmp_path):
    world = World.from_config(menagerie(), policies="random").run(2)
    uid = int(world.tables["ram"].uid[world.tables["ram"].by_uid()[3]])
    with world:
        esper.add_component(world.entity(uid), Tag(42))
    path = world.save(tmp_path / "w.safetensors")
    with pytest.raises(ConfigError, match="is not allowed to run"):
        World.restore(path)
    other = World.restore(path, trust=True)
    with other:
        assert esper.component_for_entity(other.entity(uid), Tag).number == 42
        assert len(esper.get_component(Tag)) == 1
    with world:
        esper.add_component(world.entity(uid), Secret())
    with pytest.raises(CheckpointError, match=rf"organism {uid} has a Secret.*state\(\)"):
        world.save(tmp_path / "w2.safetensors")
    assert not (tmp_path / "w2.safetensors").exists()


def test_events_kept_in_memory_go_on(menagerie, tmp_path):
    def make():
        world = World.from_config(menagerie(), policies="untrained", record=False)
        Recorder(world, keep_events=True)
        return world

    whole, begun = make().run(30), make().run(12)
    path = begun.save(tmp_path / "w.safetensors")
    other = World.restore(path, record=False, prepare=lambda world: Recorder(world, keep_events=True)).run(18)
    for kind in ("births", "deaths"):
        mine, theirs = other.recorder.events(kind), whole.recorder.events(kind)
        assert all((mine[name] == theirs[name]).all() for name in theirs)
        assert len(theirs["uid"]) > 3


def test_a_world_is_not_saved_within_a_tick(menagerie, tmp_path):
    class Saver(System):
        """Saves at the wrong moment."""

        def process(self, *_):
            self.world.save(tmp_path / "w.safetensors")

    with pytest.raises(RuntimeError, match="wait until the tick ends"):
        World.from_config(menagerie(), policies="random", systems=[Saver()]).run(1)
    assert list(tmp_path.iterdir()) == []
