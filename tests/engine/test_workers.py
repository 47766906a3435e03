import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.engine import workers
from ecs_eco.engine.workers import AGAIN, RARELY, SAMPLES, Pace, Workers


@pytest.mark.parametrize(("divided", "alone", "better"), [(1.0, 1.9, True), (1.0, 0.7, False)])
def test_a_tick_goes_the_way_that_took_less_time_and_the_other_is_tried_again(divided, alone, better):
    pace, ways = Pace(), []
    for _ in range(10 * RARELY):
        ways.append(pace.divide())
        pace.note(ways[-1], divided if ways[-1] else alone)
    assert ways[:SAMPLES] == [True] * SAMPLES
    assert ways[SAMPLES : 2 * SAMPLES] == [False] * SAMPLES
    later = ways[2 * SAMPLES :]
    tried = np.flatnonzero(np.array(later) != better)
    assert AGAIN <= tried[0] + SAMPLES <= 2 * AGAIN + SAMPLES
    assert (np.diff(tried) >= AGAIN).all()
    assert (np.diff(tried)[2:] == RARELY).all()
    assert len(tried) >= 9


@pytest.mark.parametrize("better", [True, False])
def test_the_other_way_is_taken_soon_after_it_has_become_better(better):
    """A second core that is free again, or has other work now."""
    pace, ways = Pace(), []
    for tick in range(20 * RARELY):
        ways.append(pace.divide())
        pace.note(ways[-1], 1.0 if ways[-1] == (better if tick < 10 * RARELY else not better) else 1.3)
    assert ways[9 * RARELY : 10 * RARELY].count(better) >= RARELY - 1
    changed = 10 * RARELY + RARELY + SAMPLES
    assert ways[changed : changed + RARELY].count(not better) >= RARELY - 4


def test_one_long_tick_decides_nothing():
    pace = Pace()
    for tick in range(AGAIN - 1):
        divide = pace.divide()
        pace.note(divide, 100.0 if tick == 0 else 1.0 if divide else 1.5)
    assert pace.better


def test_a_second_thread_whose_core_has_other_work_is_left_alone():
    pace = Pace()
    for tick in range(20 * AGAIN):
        divide = pace.divide()
        pace.note(divide, 1.0 if not divide else 0.6 if tick < AGAIN else 1.3)
    assert not pace.better


def test_in_a_tick_alone_no_work_is_divided(monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 10)
    both, parts = Workers(2), []

    def kernel(first, last):
        parts.append((first, last))

    for _ in range(SAMPLES + 1):
        parts.clear()
        both.tick(lambda: both.split(kernel, 100), lambda: 100)
    both.end()
    assert parts == [(0, 100)]


def test_ticks_without_work_to_divide_are_not_measured(monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 10)
    world = World(threads=2)
    world.run(3)
    assert not world._workers.pace.divided


def test_the_way_changes_no_result(monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 10)
    out = []
    for threads in (1, 2):
        these, totals = Workers(threads), np.zeros(100)

        def kernel(first, last, totals=totals):
            totals[first:last] += np.arange(first, last)

        for _ in range(20):
            these.tick(lambda these=these, kernel=kernel: these.split(kernel, 100), lambda: 100)
        these.end()
        out.append(totals)
    np.testing.assert_array_equal(*out)
