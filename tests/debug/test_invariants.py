"""What holds at any time: finite numbers, who is who, places, the order of an index."""

import esper
import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Metabolism, Position
from ecs_eco.debug import DebugError
from ecs_eco.testing import arrange
from tests.debug.wrong import Wool, deer
from tests.worlds.herd import HERD

F = np.float32


# --- not a number -------------------------------------------------------------------------------------------


def test_nan_in_a_column_is_caught(caught):
    def work(table, world):
        table[Biology].age[table.by_uid()[1]] = np.nan

    assert caught(work) == (
        f"species 'deer': Biology.age of uid {caught.uids[1]} (row 1) is nan; expected finite numbers"
    )


def test_infinity_in_a_vector_and_in_a_heavy_column_is_caught(caught):
    def work(table, world):
        table[Wool].length[table.rows(), 1] = np.inf

    def heavy(table, world):
        table[Wool].weights[0] = [0, 0, -np.inf]

    message = caught(work, components=[Wool])
    assert (
        message == f"species 'deer': Wool.length[1] of uid {caught.uids[0]} (row 0) is inf (1 more); "
        "expected finite numbers"
    )
    assert (
        caught(heavy, components=[Wool])
        == f"species 'deer': Wool.weights[2] of uid {caught.uids[0]} (row 0) is -inf; "
        "expected finite numbers"
    )


def test_nan_in_a_field_is_caught(caught):
    def work(table, world):
        world.fields["musk"].value[0, 1, 2] = np.nan

    message = caught(work, world={"fields": {"musk": {"cell": 2.0}}})
    assert "field 'musk' is nan in the cell (z, y, x) = (0, 1, 2)" in message


def test_nan_in_a_reading_is_caught_after_sense(debug, meadow):
    def broken(world, table, seekers, out, first):
        out[:, first] = np.where(table.uid[seekers.rows] == second, np.nan, 0)

    world = meadow(
        sensors=[
            {"kind": "own", "property": "energy"},
            {"kind": "custom", "name": "ear", "function": broken, "width": 1},
        ]
    )
    _, second = deer(world)
    with pytest.raises(DebugError) as error:
        world.run(1)
    assert str(error.value) == (
        "after Sense, tick 0, species 'deer': the reading 'ear' "
        f"of uid {second} (row 1) is nan; expected finite numbers"
    )


def test_nan_in_the_weights_of_a_shared_policy_is_caught(caught):
    def work(table, world):
        table.species.nerves.brain.named()["policy.head.bias"][1] = np.nan

    message = caught(work, policy={"kind": "shared", "hidden": [4]}, options={"policies": "untrained"})
    assert (
        message == "species 'deer': weight policy.head.bias[1] of the policy is nan; expected finite numbers"
    )


def test_nan_in_the_brain_of_one_is_caught(debug):
    world = World.from_config(HERD)
    goats = world.table("goat")
    policy = next(c for c in goats.columns if c.__name__ == "Policy")
    world.run(1)
    goats[policy].weights[7] = np.nan
    with pytest.raises(DebugError) as error:
        world.run(1)
    assert str(error.value).startswith(
        "after code between ticks, tick 1, species 'goat': Policy.weights[0] of uid "
    )
    assert "(row 7) is nan; expected" in str(error.value)


def test_a_cause_of_death_where_nobody_lives_is_caught(caught):
    def work(table, world):
        table.cause[9] = 1

    assert (
        caught(work)
        == "species 'deer': cause of row 9 is 1; the row is free; deaths are requested only for living organisms"
    )


# --- who is who ---------------------------------------------------------------------------------------------


def test_two_with_one_uid_are_caught(debug, meadow):
    world = meadow().run(1)
    uid = deer(world)[0]
    world.table("grass").uid[1] = uid
    with pytest.raises(DebugError) as error:
        world.run(1)
    assert str(error.value) == (
        "after code between ticks, tick 1, species 'grass': "
        f"uid {uid} is in row 1 and in row 0 of 'deer'; each uid may be assigned only once"
    )


def test_a_uid_that_was_never_given_is_caught(debug, meadow):
    world = meadow().run(1)
    world.table("deer").uid[1] = 50
    with pytest.raises(DebugError, match=r"species 'deer': uid 50 is in row 1, but the next free uid is 5"):
        world.run(1)


class Eraser(esper.Processor):
    """Takes an entity out of esper's own dict, past all of its functions."""

    def process(self):
        for entity, (m,) in list(esper.get_components(Metabolism)):
            if m.energy == 0.5 and self.world.tick == 2:
                dict.pop(esper._entities, entity)


def test_an_organism_that_a_processor_deletes_dies_in_debug_mode_too(debug):
    class Cat(esper.Processor):
        def process(self):
            for entity, _ in esper.get_component(Metabolism):
                esper.delete_entity(entity)
            esper.create_entity(Position(x=2), Metabolism())

    world = World((9.0, 9.0))
    world.add_table("mouse", Position, Metabolism)
    world.add_system(Cat())
    world.spawn("mouse", n=2)
    world.run(3)
    assert (world.table("mouse").n, world.next_uid) == (1, 6)


def test_an_entity_that_a_processor_takes_out_behind_the_table_is_made_again(debug):
    world = World((9.0, 9.0))
    world.add_table("mouse", Position, Metabolism)
    world.add_system(Eraser())
    world.spawn("mouse", Metabolism(energy=0.5))
    world.run(5)
    with world:
        assert esper.component_for_entity(world.entity(1), Metabolism).energy == 0.5


def test_components_that_a_processor_replaces_are_caught(debug):
    class Swap(esper.Processor):
        def process(self):
            dict.__setitem__(esper._entities[world.entity(1)], Metabolism, Metabolism(energy=9.0))

    world = World((9.0, 9.0))
    world.add_table("mouse", Position, Metabolism)
    world.add_system(Swap())
    world.spawn("mouse")
    with pytest.raises(DebugError, match="Metabolism of esper's entity 1 is not the component of uid 1"):
        world.run(1)


# --- places -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("x", 20.0, "Position.x of uid {uid} (row 1) is 20.0; expected [0, 20)"),
        ("y", -0.5, "Position.y of uid {uid} (row 1) is -0.5; expected [0, 20)"),
        ("heading", 7.0, "Position.heading of uid {uid} (row 1) is 7.0; expected [0, 2π)"),
        ("heading", -1.0, "Position.heading of uid {uid} (row 1) is -1.0; expected [0, 2π)"),
    ],
)
def test_a_place_outside_the_space_and_a_heading_outside_the_circle_are_caught(caught, field, value, message):
    def work(table, world):
        getattr(table[Position], field)[1] = value
        table.version += 1

    assert caught(work) == "species 'deer': " + message.format(uid=caught.uids[1])


def test_an_index_that_a_system_disorders_is_caught(caught):
    def work(table, world):
        index = world.index(table)
        index.rows[:2], index.uid[:2] = index.rows[1::-1].copy(), index.uid[1::-1].copy()

    message = caught(work, setup=lambda world: arrange(world, "deer", x=1.5, y=1.5))
    assert (
        message == "species 'deer': entry 1 of the neighbor index, uid "
        f"{caught.uids[0]}, follows uid {caught.uids[1]} in the same cell; systems may only read the index"
    )
