"""What the digest sees: all that decides the future, and nothing else."""

import json

import numpy as np
import pytest

from ecs_eco import System, World
from ecs_eco.components import Biology, Metabolism, Position
from ecs_eco.config import load
from ecs_eco.record import checkpoint
from ecs_eco.testing import shuffle


def small(**more):
    return World.from_config("predator-prey", seed=3, policies="untrained", **more)


@pytest.fixture(scope="module")
def begun():
    return small().run(2)


def spawned(world):
    world.spawn("deer", Position(x=3.0, y=4.0))


def doomed(world):
    deer = world.tables["deer"]
    world.kill(int(deer.uid[deer.by_uid()[0]]))


def killed_by_another(world):
    deer = world.tables["deer"]
    world.kill(int(deer.uid[deer.by_uid()[0]]), killer=7)


def killed_of_another_cause(world):
    deer = world.tables["deer"]
    world.kill(int(deer.uid[deer.by_uid()[0]]), cause="lightning")


def asked(world):
    world.intervene({"kind": "cull", "species": "deer", "count": 1})


def retuned(world):
    from ecs_eco.config.loading import changed
    from ecs_eco.life.reconfigure import reconfigure

    reconfigure(world, changed(world.config, {"species.deer.metabolism.basal": 0.123}))


def warmed(world):
    world.ambient["temperature"] += 1


def barren(world):
    world.reproduction = False


def lit(world):
    world.environment["light"] = lambda world, x, y, z: np.ones(x.size, np.float32)


DONE = [spawned, doomed, killed_by_another, killed_of_another_cause, asked, retuned, warmed, barren, lit]


@pytest.mark.parametrize("change", DONE, ids=lambda f: f.__name__)
def test_what_is_asked_for_or_changed_is_in_the_digest(change, begun):
    world = small().run(2)
    assert world.digest() == begun.digest()
    change(world)
    assert world.digest() != begun.digest()


def test_digests_tell_apart_what_kills_and_who(begun):
    collected = set()
    for change in (doomed, killed_by_another, killed_of_another_cause):
        world = small().run(2)
        change(world)
        collected.add(world.digest())
    assert len(collected) == 3


def test_interventions_to_come_are_in_the_digest_and_those_done_are_not():
    cull = {"kind": "cull", "species": "deer", "count": 1, "region": [0.0, 0.0, 1e-3], "at": 1}
    worlds = [
        World.from_config(load("predator-prey", {"interventions": what}), seed=3, policies="untrained")
        for what in ([], [cull])
    ]
    assert worlds[0].digest() != worlds[1].digest()
    assert worlds[0].run(1).digest() != worlds[1].run(1).digest()
    assert worlds[0].run(1).digest() == worlds[1].run(1).digest()


def test_neither_names_nor_the_recorder_are_in_the_digest():
    other = load("predator-prey", {"name": "other", "title": "x"})
    renamed = World.from_config(other, seed=3, policies="untrained", record=False)
    assert renamed.digest() == small().digest()


def test_a_state_of_ones_own_is_in_the_digest():
    class Count(System):
        n = 0

        def process(self):
            self.n += 1

        def state(self):
            return {"n": np.array(self.n)}

        def load(self, state):
            self.n = int(state["n"])

    worlds = [World(), World()]
    for world in worlds:
        world.add_system(Count())
    assert worlds[0].digest() == worlds[1].digest()
    worlds[0].systems[0].n = 5
    assert worlds[0].digest() != worlds[1].digest()


def test_a_restored_world_has_the_digest_of_the_saved_one(tmp_path):
    world = small(learn=True).run(5)
    for change in (spawned, doomed, asked, warmed):
        change(world)
    assert World.restore(world.save(tmp_path / "w.safetensors")).digest() == world.digest()


def test_two_equal_runs_give_checkpoints_of_equal_bytes(tmp_path):
    collected = set()
    for i in range(6):
        world = small(learn=True).run(3)
        collected.add(world.save(tmp_path / f"{i}.safetensors").read_bytes())
    assert len(collected) == 1
    head = collected.pop()
    meta = json.loads(head[8 : 8 + int.from_bytes(head[:8], "little")])["__metadata__"]
    assert list(meta) == sorted(meta)
    assert checkpoint.read(tmp_path / "0.safetensors")[0]["clock"]["tick"] == 3


def test_what_is_emitted_after_the_fields_turn_is_saved(tmp_path):
    world = World.from_config("diel-migration", seed=1, policies="untrained").run(1)
    name, field = next(iter(world.fields.items()))
    before = world.digest()
    field.emit(*(np.array([1.0], np.float32) for _ in range(4)))
    assert world.digest() != before
    again = World.restore(world.save(tmp_path / "w.safetensors"))
    assert np.array_equal(again.fields[name].source, field.source)
    assert again.run(2).digest() == world.run(2).digest()


def test_reordered_rows_change_nothing_of_a_world_that_learns():
    plain, moved = small(learn=True), small(learn=True)
    horizon = plain.tables["deer"].species.nerves.learner.ppo.horizon
    plain.run(horizon // 2)
    moved.run(horizon // 2)
    shuffle(moved, 4)
    assert moved.digest() == plain.digest()
    for ticks in (1, horizon // 3, horizon // 3):
        plain.run(ticks)
        shuffle(moved.run(ticks), ticks)
        assert moved.digest() == plain.digest()
    assert plain.tables["deer"].species.nerves.learner.updates == 1


def test_reorder_refuses_what_are_not_the_living_rows():
    world = World()
    table = world.add_table("ant", Metabolism)
    world.spawn("ant", n=3)
    world.flush()
    for rows in ([0, 1], [0, 1, 1], [0, 1, 5]):
        with pytest.raises(ValueError, match="reorder needs its 3 living rows, each once"):
            table.reorder(np.array(rows))


def test_a_part_of_a_table_may_follow_its_rows():
    class Marks:
        def __init__(self):
            self.mark = np.arange(64)

        def reorder(self, order):
            self.mark = self.mark[order]

    world = World()
    table = world.add_table("ant", Biology)
    table.own["marks"] = Marks()
    world.spawn("ant", n=3)
    world.flush()
    table.reorder(np.array([2, 0, 1]))
    assert table.own["marks"].mark[:3].tolist() == [2, 0, 1]
