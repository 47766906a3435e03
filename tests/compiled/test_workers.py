import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.compiled import workers
from ecs_eco.compiled.pace import AGAIN, RARELY, SAMPLES, SOON, WARM, Pace
from ecs_eco.compiled.workers import IDLE, Workers


def ways_of(pace, ticks, seconds):
    """Let so many ticks pass that take `seconds(divided, tick)`; return the way of each."""
    ways = []
    for tick in range(ticks):
        ways.append(pace.divide())
        pace.note(ways[-1], seconds(ways[-1], tick))
    return np.array(ways)


@pytest.mark.parametrize("tick", [0.001, 1.0])
@pytest.mark.parametrize(("divided", "alone", "better"), [(1.0, 1.9, True), (1.0, 0.7, False)])
def test_a_tick_goes_the_way_that_took_less_time_and_the_other_is_tried_again(divided, alone, better, tick):
    pace, warm = Pace(), math.ceil(WARM / (tick * 0.7)) + 1
    longest = warm + SAMPLES  # ticks of a try
    ways = ways_of(pace, 10 * RARELY * longest, lambda way, _: tick * (divided if way else alone))
    assert ways[:SAMPLES].all()
    changes = np.flatnonzero(np.diff(ways)) + 1
    begins, ends = changes[ways[changes] != better], changes[ways[changes] == better]
    ends = ends[ends > begins[0]]
    lengths = ends - begins[: len(ends)]
    assert (lengths >= SAMPLES).all()
    assert (lengths <= longest).all()
    waits = tick * (begins[1 : len(ends) + 1] - ends[: len(begins) - 1]) * min(divided, alone)
    cost = tick * max(divided, alone) * lengths[: len(waits)]
    assert (waits >= AGAIN * cost * 0.9).all()
    assert (waits[5:] >= RARELY * cost[5:] * 0.9).all()
    assert len(begins) >= 6


@pytest.mark.parametrize("better", [True, False])
def test_the_other_way_is_taken_soon_after_it_has_become_better(better):
    """A second core that is free again, or has other work now."""
    change = 20 * RARELY
    ways = ways_of(
        Pace(),
        2 * change + RARELY * 10,
        lambda way, tick: 1.0 if way == (better if tick < change else not better) else 1.3,
    )
    assert (ways[change // 2 : change] == better).mean() > 0.95
    sooner = change + 2 * SOON * 8  # the chosen way takes longer than it did
    assert (ways[sooner : sooner + RARELY] != better).mean() > 0.9


def test_a_way_that_becomes_better_without_notice_is_found_in_the_end():
    change = 20 * RARELY
    ways = ways_of(Pace(), 40 * RARELY, lambda way, tick: (0.6 if tick > change else 1.3) if way else 1.0)
    assert not ways[change // 2 : change].mean() > 0.05
    assert ways[change + 8 * RARELY :].mean() > 0.9


@pytest.mark.parametrize("way", [True, False])
def test_who_slept_is_slow_at_first_and_that_does_not_count(way):
    """The first ticks of a way take twice as long as the other's, all later ones half as long."""
    pace, since = Pace(), 0
    for _ in range(4000):
        divide = pace.divide()
        since = since + 1 if divide == way else 0
        pace.note(divide, 0.004 if divide != way else 0.008 if since < 5 else 0.002)
    assert pace.better == way


def test_one_long_tick_decides_nothing():
    pace = Pace()
    ways_of(pace, 4 * SAMPLES, lambda way, tick: 100.0 if tick == 3 else 1.0 if way else 1.5)
    assert pace.better


def test_tries_of_a_way_that_takes_twice_as_long_cost_little():
    pace, spent = Pace(), 0.0
    for _ in range(100_000):
        way = pace.divide()
        seconds = 0.004 if way else 0.002
        pace.note(way, seconds)
        spent += seconds
    assert spent < 100_000 * 0.002 * 1.01


def test_in_a_tick_alone_no_work_is_divided(monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 10)
    both, parts = Workers(2), []

    def kernel(first, last):
        parts.append((first, last))

    for divided in (True, False):
        both.pace.way = divided
        parts.clear()
        both.tick(lambda: both.split(kernel, 100), lambda: 100)
        assert (len(parts) > 1) == divided
    both.end()
    assert parts == [(0, 100)]


def test_ticks_without_work_to_divide_are_not_measured(monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 10)
    world = World(threads=2)
    world.run(3)
    assert not world.workers.pace.passed


def test_after_a_tick_with_nothing_to_divide_some_go_without_asking(monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 10)
    both, asked = Workers(2), []
    for _ in range(2 * IDLE + 2):
        both.tick(lambda: asked.append(both.parallel), lambda: 5)
    both.end()
    assert asked == [True, *[False] * IDLE] * 2


def test_the_way_changes_no_result(monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 10)
    out = []
    for threads in (1, 2):
        these, totals = Workers(threads), np.zeros(100)

        def kernel(first, last, totals=totals):
            totals[first:last] += np.arange(first, last)

        for k in range(20):
            these.pace.way = k % 3 == 0
            these.tick(lambda these=these, kernel=kernel: these.split(kernel, 100), lambda: 100)
        these.end()
        out.append(totals)
    np.testing.assert_array_equal(*out)
