"""The door for users: every function of esper works on a living world as esper says,
or says what to do instead."""

import esper
import pytest

from ecs_eco import System, World
from ecs_eco.components import Body, Position
from tests.esper_bridge.populations import Coat, Tag, populated


class Count(esper.Processor):
    """Counts its calls."""

    def __init__(self) -> None:
        self.calls = 0

    def process(self, *arguments) -> None:
        self.calls += 1


def checks_dispatch_event(world):
    heard = []

    def hear(*arguments):
        heard.append(arguments)

    esper.set_handler("thunder", hear)
    esper.dispatch_event("thunder", 3, "west")
    esper.dispatch_event("rain")
    assert heard == [(3, "west")]


def checks_remove_handler(world):
    class Ear:
        def hear(self):
            raise AssertionError

    def hear():
        raise AssertionError

    ear = Ear()
    for handler in (hear, ear.hear):
        esper.set_handler("thunder", handler)
        esper.remove_handler("thunder", handler)
        esper.dispatch_event("thunder")
        esper.remove_handler("thunder", handler)
    assert not esper.event_registry


def checks_list_worlds(world):
    assert esper.list_worlds().count(world.context.name) == 1


def checks_switch_world(world):
    esper.switch_world("another")
    assert not list(esper.get_entities())
    world.run(1)
    assert esper.current_world == "another"
    esper.switch_world(world.context.name)
    assert len(list(esper.get_entities())) == 4
    esper.delete_world("another")


def checks_delete_world(world):
    with pytest.raises(PermissionError):
        esper.delete_world(world.context.name)


def checks_clear_cache(world):
    before = esper.get_component(Position)
    esper.clear_cache()
    assert sorted(e for e, _ in esper.get_component(Position)) == sorted(e for e, _ in before)


def checks_clear_database(world):
    with pytest.raises(
        RuntimeError, match=r"esper\.clear_database, world 'world': would remove all organisms"
    ):
        esper.clear_database()
    assert len(esper.get_component(Position)) == 4
    assert esper.create_entity(Position(), Body(), Coat()) == 5, "numbers go on"


def checks_add_processor(world):
    processor = Count()
    esper.add_processor(processor)
    assert world.systems[-1] is processor
    world.run(2)
    assert processor.calls == 2


def checks_remove_processor(world):
    processor = Count()
    esper.add_processor(processor)
    world.run(1)
    esper.remove_processor(Count)
    esper.remove_processor(Count)
    world.run(1)
    assert processor.calls == 1
    assert processor not in world.systems

    class Grow(System):
        needs = (Position,)

        def update(self, table, world):
            pass

    system = world.add_system(Grow())
    with pytest.raises(RuntimeError, match="Grow is part of the schedule and cannot be removed"):
        esper.remove_processor(Grow)
    assert esper.get_processor(Grow) is system


def checks_get_processor(world):
    processor = Count()
    esper.add_processor(processor)
    assert esper.get_processor(Count) is processor
    assert esper.get_processor(esper.Processor) is None


def checks_create_entity(world):
    entity = esper.create_entity(Position(x=7.5), Body(mass=4), Coat(), Tag("new"))
    assert (world.tables["fox"].n, world.uid(entity)) == (2, 5)
    assert world.get(5, Position).x == esper.component_for_entity(entity, Position).x == 7.5
    assert esper.component_for_entity(entity, Tag).text == "new"


def checks_delete_entity(world):
    entity = world.entity(2)
    esper.delete_entity(entity)
    assert not esper.entity_exists(entity)
    assert world.get(2, Position).x == 2, "it dies at the end of the `die` phase"
    esper.delete_entity(entity)
    world.kill(2)
    world.run(1)
    assert [world.tables["hare"].n, world.causes] == [2, ["culled", "deleted"]]
    with pytest.raises(KeyError, match="world 'world' has no entity 1: it has died or never existed"):
        esper.delete_entity(entity)
    other = world.entity(3)
    esper.delete_entity(other, immediate=True)
    assert not esper.entity_exists(other)
    assert world.tables["hare"].n == 1


def checks_entity_exists(world):
    entity = world.entity(1)
    assert esper.entity_exists(entity)
    assert not esper.entity_exists(999)
    world.kill(1)
    assert not esper.entity_exists(entity), "as one that esper.delete_entity has marked"


def checks_get_entities(world):
    assert len(list(esper.get_entities())) == 4
    for entity in esper.get_entities():
        esper.delete_entity(entity, immediate=True)
    assert not list(esper.get_entities())


def checks_component_for_entity(world):
    esper.component_for_entity(world.entity(1), Position).x = 5
    assert world.tables["hare"][Position].x[0] == 5
    with pytest.raises(KeyError):
        esper.component_for_entity(world.entity(1), Coat)
    with pytest.raises(KeyError, match="no entity 99"):
        esper.component_for_entity(99, Position)


def checks_components_for_entity(world):
    assert [type(c) for c in esper.components_for_entity(world.entity(4))] == [Position, Body, Coat]


def checks_has_component(world):
    assert esper.has_component(world.entity(4), Coat)
    assert not esper.has_component(world.entity(1), Coat)


def checks_has_components(world):
    assert esper.has_components(world.entity(4), Coat, Body)
    assert not esper.has_components(world.entity(1), Coat, Body)


def checks_add_component(world):
    entity = world.entity(1)
    esper.add_component(entity, Tag("marked"))
    esper.add_component(entity, Tag("again"))
    assert [(e, t.text) for e, t in esper.get_component(Tag)] == [(entity, "again")]
    with pytest.raises(
        TypeError,
        match=r"belongs to the table 'hare', and its Position already exists: "
        r"set its fields, as in "
        r"esper\.component_for_entity\(1, Position\)\.x = …",
    ):
        esper.add_component(entity, Position(x=3))
    with pytest.raises(
        TypeError,
        match=r"all entities of a table have the same components: "
        r"world\.table\('hare'\)\.add_component\(Coat\)",
    ):
        esper.add_component(entity, Coat())
    with pytest.raises(TypeError, match="have the same components"):
        esper.add_component(entity, Coat(), type_alias=str)
    with pytest.raises(KeyError, match="no entity 99"):
        esper.add_component(99, Tag())
    assert (
        len(esper.get_component(Position)),
        len(esper.get_component(Coat)),
        len(esper.get_component(Tag)),
    ) == (4, 1, 1)


def checks_remove_component(world, remove=None):
    entity, remove = world.entity(4), remove or esper.remove_component
    esper.add_component(entity, Tag("x"))
    assert remove(entity, Tag).text == "x"
    with pytest.raises(
        TypeError, match="belongs to the table 'fox', whose entities all have Coat; change its values"
    ):
        remove(entity, Coat)
    assert [e for e, _ in esper.get_component(Coat)] == [entity]


def checks_try_remove_component(world):
    checks_remove_component(world, esper.try_remove_component)
    assert esper.try_remove_component(world.entity(1), Coat) is None
    assert esper.try_remove_component(world.entity(1), Tag) is None


def checks_get_component(world):
    assert sorted(p.x for _, p in esper.get_component(Position)) == [1, 2, 3, 9]


def checks_get_components(world):
    assert [(p.x, c.colour) for _, (p, c) in esper.get_components(Position, Coat)] == [(9, 0.5)]


def checks_try_component(world):
    assert esper.try_component(world.entity(1), Coat) is None
    assert esper.try_component(99, Coat) is None
    assert esper.try_component(world.entity(4), Coat).colour == 0.5


def checks_try_components(world):
    assert esper.try_components(world.entity(1), Position, Coat) is None
    assert [type(c) for c in esper.try_components(world.entity(4), Position, Coat)] == [Position, Coat]


def checks_clear_dead_entities(world):
    esper.delete_entity(world.entity(1))
    esper.clear_dead_entities()
    assert (world.tick, world.tables["hare"].n, len(esper.get_component(Position))) == (0, 2, 3)
    esper.clear_dead_entities()


def checks_process(world, process=None):
    processor = Count()
    esper.add_processor(processor)
    esper.delete_entity(world.entity(1))
    (process or esper.process)()
    assert (world.tick, processor.calls, world.tables["hare"].n) == (1, 1, 2)
    with pytest.raises(
        TypeError,
        match=r"systems of the world 'world' take no arguments; "
        r"world\.dt is the length of a tick",
    ):
        (process or esper.process)(0.1)
    assert world.run(1).tick == 2


def checks_timed_process(world):
    checks_process(world, esper.timed_process)
    assert list(esper.process_times) == ["Tick"]


def checks_Processor(world):
    with pytest.raises(NotImplementedError):
        esper.Processor().process()
    checks_add_processor(world)


PUBLIC = sorted(
    name
    for name, thing in vars(esper).items()
    if getattr(thing, "__module__", "") == "esper" and name[0] != "_"
)
CHECKS = {
    name.removeprefix("checks_"): check for name, check in globals().items() if name.startswith("checks_")
}
CHECKS["set_handler"] = checks_dispatch_event


@pytest.mark.parametrize("debug", ["0", "1"], ids=["plain", "debug"])
@pytest.mark.parametrize("name", PUBLIC)
def test_every_function_of_esper_works_on_a_living_world_or_says_what_to_do(name, debug, monkeypatch):
    monkeypatch.setenv("ECS_ECO_DEBUG", debug)
    world = populated(World((10, 10)))
    with world:
        CHECKS[name](world)
        world.run(1)
    assert world.tick >= 1


def test_no_function_of_esper_is_left_out_and_other_worlds_of_esper_are_as_they_were():
    assert len(PUBLIC) == 30
    assert sorted(CHECKS) == PUBLIC
    entity = esper.create_entity(Tag())
    esper.add_component(entity, Position())
    esper.delete_entity(entity, immediate=True)
    assert type(esper._entities) is dict
