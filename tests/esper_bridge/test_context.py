"""The context of a world: esper's own functions over the columns, and worlds that do not mix."""

import gc
import threading
import weakref

import esper
import pytest

from ecs_eco import System, World
from ecs_eco.components import Body, Position
from ecs_eco.esper_bridge import turns
from ecs_eco.esper_bridge.context import Context
from tests.esper_bridge.populations import Coat


class Freed:
    """Garbage that removes an esper context once it is collected, as a world does."""

    def __init__(self, name, state):
        self.me = self
        esper._context_map[name] = state
        weakref.finalize(self, esper._context_map.pop, name)


def test_a_context_may_be_removed_while_another_one_is_made(world):
    thresholds = gc.get_threshold()
    others = [Freed(f"another {i}", world.context.registry.state) for i in range(30)]
    try:
        for later in range(1, 30):
            gc.collect()
            gc.disable()
            Freed("freed", world.context.registry.state)
            gc.set_threshold(gc.get_count()[0] + later)  # collects at the allocation after so many others
            gc.enable()
            Context(world).end()
            gc.collect()
            assert "freed" not in esper._context_map
        assert len(others) == 30
    finally:
        gc.enable()
        gc.set_threshold(*thresholds)


def test_component_for_entity_reads_and_writes_the_column(world):
    with world:
        handle = esper.component_for_entity(world.entity(2), Position)
        assert handle.x == 2
        handle.x = 4.5
        esper.component_for_entity(world.entity(3), Body).mass = 70
        assert not esper.has_component(world.entity(1), Coat)
    assert world.tables["hare"][Position].x[:3].tolist() == [1, 4.5, 3]
    assert world.tables["hare"][Body].mass[:3].tolist() == [1, 2, 70]


def test_get_components_sees_all_tables_and_loops_may_write(world):
    with world:
        assert len(esper.get_component(Position)) == 4
        assert [round(c.colour, 2) for _, (_, _, c) in esper.get_components(Position, Body, Coat)] == [0.5]
        for _, (position, body) in esper.get_components(Position, Body):
            position.y = position.x + body.radius
    assert world.tables["hare"][Position].y[:3].tolist() == [1.5, 2.5, 3.5]
    assert world.tables["fox"][Position].y[0] == 9.5


def test_the_registry_follows_births_deaths_and_reused_rows(world):
    with world:
        first = {uid: world.entity(uid) for uid in (1, 2, 3, 4)}
        world.kill(2)
        world.spawn("hare", Position(x=7), n=2)
        world.run(1)  # within `with world:` the registry is brought up to date after it
        assert len(esper.get_component(Position)) == 5
        assert not esper.entity_exists(first[2])
        assert [world.entity(u) for u in (1, 3, 4)] == [first[u] for u in (1, 3, 4)]
        assert esper.component_for_entity(world.entity(5), Position).x == 7
        assert len({*first.values(), world.entity(5), world.entity(6)}) == 6
    with pytest.raises(KeyError, match="no living entity has the uid 2"):
        world.entity(2)


def test_handles_stay_valid_when_tables_grow_and_are_made_anew_when_rows_move(world):
    with world:
        handle = esper.component_for_entity(world.entity(3), Position)
        world.spawn("hare", n=500)
        world.run(1)
        assert handle.x == 3
        handle.x = 6
        table = world.tables["hare"]
        assert table[Position].x[2] == 6
        table.reorder(table.rows()[::-1].copy())
        world.sync()
        assert esper.component_for_entity(world.entity(3), Position).x == 6
        assert esper.component_for_entity(world.entity(1), Position).x == 1
        assert len(esper.get_component(Position)) == 504


def test_a_component_added_later_is_on_the_handles(world):
    with world:
        world.tables["hare"].add_component(Coat, colour=0.25)
        world.sync()
        assert sorted(c.colour for _, c in esper.get_component(Coat)) == [0.25, 0.25, 0.25, 0.5]


def test_a_plain_processor_sees_the_current_registry_and_what_it_moves_is_moved(world):
    class Drift(esper.Processor):
        seen = []

        def process(self):
            places = esper.get_component(Position)
            self.seen.append(len(places))
            for _, position in places:
                position.x = (position.x + 1) % 10

    class Look(System):
        needs = (Position,)
        phase = "metabolise"
        nearest = []

        def update(self, table, world):
            self.nearest.append(world.index(table).x.tolist())

    world.add_system(Drift(), phase="interact")
    world.add_system(Look())
    world.run(1)
    world.kill(1)
    world.spawn("fox", n=2)
    world.run(2)
    assert Drift.seen == [4, 4, 5]  # the one killed lives until the `die` phase, the newborn come after it
    assert Look.nearest == [[2, 3, 4], [0], [3, 4, 5], [1], [5, 6], [1, 1, 2]]


def test_a_plain_processor_may_move_the_same_ones_every_tick(world):
    class Drift(esper.Processor):
        def process(self):
            for _, position in esper.get_component(Position):
                position.x = (position.x + 1) % 10

    class Look(System):
        needs = (Position, Coat)
        phase = "metabolise"
        seen = []

        def update(self, table, world):
            self.seen.append(world.index(table).x.tolist())

    world.add_system(Drift())
    world.add_system(Look())
    world.run(3)
    assert Look.seen == [[0], [1], [2]]


def test_what_handles_move_between_ticks_is_where_systems_find_it(world):
    collected = []

    class Look(System):
        needs = (Position, Coat)

        def update(self, table, world):
            collected.append(world.index(table).x.tolist())

    world.add_system(Look())
    world.run(1)
    world.get(4, Position).x = 3
    world.run(1)
    assert collected == [[9], [3]]


def test_worlds_do_not_mix():
    worlds = [World((10, 10), seed=i, name=f"w{i}") for i in range(3)]
    for i, world in enumerate(worlds):
        world.add_table("hare", Position)
        world.spawn("hare", Position(x=i), n=i + 1)

        class Step(esper.Processor):
            def process(self):
                for _, position in esper.get_component(Position):
                    position.x += 1

        world.add_system(Step())
    worlds[0].run(2)
    worlds[2].run(1)
    with worlds[1]:
        worlds[1].run(1)
        assert len(esper.get_component(Position)) == 2
        with worlds[2]:
            assert len(esper.get_component(Position)) == 3
            worlds[0].run(1)  # another's ticks leave this one entered
            assert len(esper.get_component(Position)) == 3
        with worlds[1]:  # entering twice is harmless
            pass
        assert len(esper.get_component(Position)) == 2
    assert not esper.get_component(Position)  # outside, esper's own world
    assert [w.tables["hare"][Position].x[: i + 1].tolist() for i, w in enumerate(worlds)] == [
        [3],
        [2, 2],
        [3, 3, 3],
    ]
    assert [w.next_uid for w in worlds] == [2, 3, 4]


def test_a_world_that_nobody_holds_frees_its_context_and_columns(menagerie):
    gc.collect()  # worlds of other tests
    kept = set(esper.list_worlds())
    world = World.from_config(menagerie(), policies="untrained", learn=True, threads=2)
    with world:
        world.run(2)
    column = weakref.ref(world.tables["ram"][Position].x)
    gone = weakref.ref(world)
    context = world.context.name
    assert context in esper.list_worlds()
    del world
    gc.collect()
    assert gone() is None
    assert set(esper.list_worlds()) == kept
    assert column() is None
    with pytest.raises(KeyError):
        esper.delete_world(context)


def test_a_world_freed_within_its_own_context_leaves_esper_in_the_default():
    world = World((5, 5))
    world.__enter__()
    del world
    gc.collect()
    assert esper.current_world == "default"


@pytest.mark.parametrize("elsewhere", [False, True])
def test_a_world_freed_within_its_own_context_keeps_no_turn_from_others(elsewhere):
    """Garbage is collected by whichever thread is at work."""

    def do(work):
        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        thread.join(30)
        assert not thread.is_alive()

    def take():
        with turns.turn:
            pass

    world = World((5, 5))
    world.__enter__().itself = world
    freed = weakref.ref(world)
    gc.collect()
    gc.disable()
    try:
        del world
        assert freed() is not None
        do(gc.collect) if elsewhere else gc.collect()
        assert freed() is None
    finally:
        gc.enable()
    do(take)  # while the thread that abandoned the world waits
    take()


def test_a_world_that_cannot_be_entered_keeps_no_turn_and_leaves_esper_as_it_was(monkeypatch):
    world = World((5, 5))
    monkeypatch.setattr(world.context, "show", lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        world.__enter__()
    assert esper.current_world == "default"
    assert not turns.turn.held()
