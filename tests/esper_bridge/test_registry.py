"""Who comes and goes through esper, and when its entities are made."""

import gc

import esper
import pytest

from ecs_eco import System
from ecs_eco.components import Body, Position, Velocity
from ecs_eco.esper_bridge import turns
from tests.esper_bridge.populations import Coat, Tag


def test_an_entity_goes_to_the_one_table_that_has_its_components_and_else_the_tables_are_named(world):
    with world:
        esper.create_entity(Position(x=5), Body())
        assert (world.tables["hare"].n, world.tables["fox"].n) == (4, 1), "the hares have these and no others"
        esper.create_entity(Coat())
        assert world.tables["fox"].n == 2
        with pytest.raises(
            TypeError,
            match=r"create_entity\(Position\): hare, "
            r"fox of .* have these components; name one of them, as in world\.spawn\('hare', …\)",
        ):
            esper.create_entity(Position())
        for things in ((), (Tag(),), (Velocity(), Tag())):
            with pytest.raises(
                TypeError, match=r"its tables are hare \(Position, Body\); fox \(Position, Body, Coat\)"
            ):
                esper.create_entity(*things)
        with pytest.raises(ValueError, match=r"Position\.x is nan"):
            esper.create_entity(Position(x=float("nan")), Body(), Coat())
        assert not esper.get_component(Velocity)
        assert not esper.get_component(Tag)
        assert len(esper.get_component(Position)) == 6
    assert [t.waiting for t in world.tables.values()] == [0, 0]


def test_components_handed_over_are_the_handles_of_the_newborn(world):
    place = Position(x=5)
    with world:
        entity = esper.create_entity(place, Body(), Coat())
        assert esper.component_for_entity(entity, Position) is place
        place.x = 6
        assert world.get(world.uid(entity), Position).x == 6
        assert esper.has_component(entity, Coat)


def test_an_entity_created_within_a_tick_is_in_esper_at_once_and_lives_from_the_end_of_reproduce_on(world):
    class Breed(esper.Processor):
        def process(self):
            if not hasattr(self, "entity"):
                self.place = Position(x=5)
                self.entity = esper.create_entity(self.place, Body())
                self.stillborn = esper.create_entity(Position(), Body())
                assert esper.entity_exists(self.entity)
                assert world.uid(self.entity) == 0
                assert len(esper.get_component(Position)) == 6
                assert world.tables["hare"].n == 3
                self.place.x = 14  # written before its birth, and brought back around the torus
                esper.delete_entity(self.stillborn)
                assert not esper.entity_exists(self.stillborn)
                with pytest.raises(
                    RuntimeError,
                    match=r"esper\.clear_dead_entities, .*: "
                    r"deaths take effect at the end of the `die` phase",
                ):
                    esper.process()
                with pytest.raises(RuntimeError, match="omit `immediate`"):
                    esper.delete_entity(world.entity(1), immediate=True)
                assert len(esper.get_component(Position)) == 5

    breed = world.add_system(Breed())
    world.run(1)
    assert world.tables["hare"].n == 4
    uid = world.uid(breed.entity)
    assert (uid, world.get(uid, Position).x, breed.place.x) == (5, 4, 4)
    breed.place.x = 2
    assert world.get(uid, Position).x == 2


def test_systems_that_look_through_esper_in_a_tick_see_its_births_and_deaths(world):
    seen = []

    class Look(System):
        needs = (Coat,)
        phase = "record"

        def update(self, table, world):
            seen.append(len(esper.get_component(Position)))

    world.add_system(Look())
    world.run(1)
    world.kill(1)
    world.spawn("fox", n=3)
    world.run(1)
    assert seen == [4, 6]


def test_births_and_deaths_that_nobody_looks_at_make_no_handles(world):
    def held():
        return len(dict.keys(world.context.registry.entities))

    world.spawn("hare", n=100)
    world.kill(1)
    world.run(2)
    assert held() == 0
    with world:
        world.run(1)
        assert held() == 0
        entity = world.entity(2)
        assert held() == 1
        assert len(esper.get_component(Position)) == 103
        assert (held(), world.entity(2)) == (103, entity)


def test_handlers_of_esper_hear_births_and_deaths_and_may_look_at_them(world):
    heard = []

    def born(entity):
        heard.append(("born", world.uid(entity), esper.component_for_entity(entity, Position).x))

    def died(entity, cause):
        heard.append((cause, world.uid(entity), esper.component_for_entity(entity, Position).x))

    with world:
        esper.set_handler("birth", born)
        esper.set_handler("death", died)
        esper.delete_entity(world.entity(3))
    world.kill(1, "hunger")
    world.spawn("fox", Position(x=7), n=2)
    world.run(1)
    world.kill(5)
    world.flush()
    assert heard == [("hunger", 1, 1), ("deleted", 3, 3), ("born", 5, 7), ("born", 6, 7), ("culled", 5, 7)]
    with world:
        esper.remove_handler("birth", born)
        esper.create_entity(Position(), Body(), Coat())
    assert len(heard) == 5


def test_a_handler_that_nobody_holds_hears_nothing_more_whatever_world_esper_shows(world):
    heard = []

    class Ear:
        def hear(self, entity):
            heard.append(entity)

    ears = Ear(), Ear()
    with world:
        for ear in ears:
            esper.set_handler("birth", ear.hear)
        esper.create_entity(Coat())
    del ears, ear
    gc.collect()
    with world:
        esper.create_entity(Coat())
        assert "birth" not in esper.event_registry
    assert len(heard) == 2, "the dead ears are gone"


def test_what_esper_alone_knows_stays_when_rows_move_and_tables_get_components(world):
    with world:
        entity, place = world.entity(3), esper.component_for_entity(world.entity(3), Position)
        esper.add_component(entity, Tag("kept"))
        world.tables["hare"].reorder([2, 1, 0])
        world.tables["hare"].add_component(Coat)
        assert (world.entity(3), esper.component_for_entity(entity, Tag).text) == (entity, "kept")
        assert esper.has_component(entity, Coat)
        assert (place.x, esper.component_for_entity(entity, Position) is place) == (3, True)


def test_a_processor_may_be_placed_by_a_priority_of_espers(world):
    order = []

    class Note(esper.Processor):
        def process(self):
            order.append(type(self).__name__)

    kinds = [type(name, (Note,), {}) for name in ("Last", "First", "Middle")]
    with world:
        for kind, priority in zip(kinds, (-99_000_000, 5, 0), strict=True):
            esper.add_processor(kind(), priority)
        esper.process()
    assert order == ["First", "Middle", "Last"]


def test_a_world_that_esper_has_deleted_says_so(world):
    esper.delete_world(world.context.name)
    for use in (lambda: world.run(1), world.__enter__):
        with pytest.raises(
            RuntimeError, match=r"esper\.delete_world\('ecs-eco \d+'\) has deleted world 'world'"
        ):
            use()
    assert not turns.turn.held()
    assert (world.tick, world.get(1, Position).x) == (0, 1)
    assert world.digest()
