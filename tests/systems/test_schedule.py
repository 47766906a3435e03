from ecs_eco import systems
from ecs_eco.engine.phases import PHASES
from ecs_eco.systems.schedule import RESPAWNING, SCHEDULE, schedule


def test_the_schedule_names_every_phase_in_order():
    assert tuple(SCHEDULE) == tuple(RESPAWNING) == PHASES


def test_every_system_stands_in_the_phase_that_it_declares():
    for phases in (SCHEDULE, RESPAWNING):
        assert [
            (phase, s.__name__) for phase, those in phases.items() for s in those if s.phase != phase
        ] == []


def test_every_shipped_system_has_its_place():
    assert {
        s.__name__ for phases in (SCHEDULE, RESPAWNING) for those in phases.values() for s in those
    } == set(systems.__all__)


def test_worlds_share_no_system():
    first, second = schedule(), schedule()
    assert not {id(s) for s in first} & {id(s) for s in second}
    assert len(first) == sum(map(len, SCHEDULE.values()))


def test_the_dead_are_replaced_where_nobody_gives_birth():
    assert [type(s).__name__ for s in schedule(respawn=True)][-3:] == ["Respawn", "Reproduce", "Spread"]
    assert [type(s).__name__ for s in schedule()][-3:] == ["Reproduce", "GiveBirth", "Spread"]
