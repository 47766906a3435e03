import esper
import pytest

from ecs_eco import PHASES, System, World, component, f32


@component
class Heat:
    """Warmth."""

    kelvin: f32 = 300.0


@component
class Wool:
    """Insulation."""

    thickness: f32 = 0.01


def _noting(name, notes, phase_):
    class Note(System):
        phase = phase_

        def process(self, *_):
            notes.append(name)

    return Note()


def test_update_is_called_for_each_table_that_has_all_it_needs_in_order():
    world, seen = World(), []
    world.add_table("sheep", Wool, Heat)
    world.add_table("rock", Heat)
    world.add_table("lamb", Heat, Wool)

    class Cool(System):
        needs = Heat, Wool

        def update(self, table, world):
            seen.append((table.name, world.tick))

    world.add_system(Cool())
    world.run(2)
    assert seen == [("sheep", 0), ("lamb", 0), ("sheep", 1), ("lamb", 1)]


def test_systems_act_by_phase_then_by_the_order_in_which_they_were_added():
    world, notes = World(), []
    for phase in reversed(PHASES):
        for number in (1, 2):
            world.add_system(_noting((phase, number), notes, phase))
    world.run(1)
    assert notes == [(phase, number) for phase in PHASES for number in (1, 2)]


def test_a_phase_given_when_adding_wins():
    world, notes = World(), []
    world.add_system(_noting("late", notes, "sense"), phase="record")
    world.add_system(_noting("early", notes, "move"))
    world.run(1)
    assert notes == ["early", "late"]


def test_start_is_called_once_when_the_world_is_known():
    world, started = World(), []

    class Starter(System):
        def start(self, world):
            started.append((world.tick, self.world.name))

        def process(self, *_):
            pass

    world.add_system(Starter())
    world.run(3)
    assert started == [(0, "world")]


def test_misuse_is_refused():
    world = World()
    world.add_table("rock", Heat)

    class Empty(System):
        needs = (Heat,)

    class Lost(System):
        phase = "recrod"

    class Everywhere(System):
        needs = ()

        def update(self, table, world): ...

    with pytest.raises(ValueError, match=r"system Lost: unknown phase 'recrod'.*did you mean .record"):
        world.add_system(Lost())
    with pytest.raises(TypeError, match=r"is not an ecs_eco.System or esper.Processor; pass an instance"):
        world.add_system(Empty)
    with pytest.raises(TypeError, match=r"Careless has no `needs`: declare .*needs = \(\) for all tables"):

        class Careless(System):
            def update(self, table, world): ...

    world.add_system(Everywhere())
    system = world.add_system(Empty())
    with pytest.raises(ValueError, match="system Empty is already in a world; create another instance"):
        World().add_system(system)
    with pytest.raises(
        NotImplementedError, match=r"Empty defines neither update\(table, world\) nor process\(\)"
    ):
        world.run(1)
    assert esper.current_world == "default"  # an error in a tick leaves esper where it was
