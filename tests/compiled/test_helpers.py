import gc
import os
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest

from ecs_eco.compiled import helpers, workers
from ecs_eco.compiled.helpers import Helper
from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.parts import record_of_a_team
from ecs_eco.compiled.workers import Workers

LONG = 0.05  # [s] longer than a helper stays awake


@njit
def add(first, last, numbers):
    for i in range(first, last):
        numbers[i] += i


@pytest.fixture
def helper():
    one = Helper(record_of_a_team())
    yield one
    one.end()


@pytest.mark.parametrize("awake", [0, 1e-6, helpers.AWAKE])
def test_it_does_what_it_is_asked_for_awake_or_asleep(helper, monkeypatch, awake):
    monkeypatch.setattr(helpers, "AWAKE", awake)
    numbers = np.zeros(100)
    for n in range(300):
        helper.start(add, 0, 100, numbers)
        helper.finish()
        assert numbers[99] == 99 * (n + 1)
        if n % 100 == 0:
            time.sleep(LONG)


def test_it_works_beside_who_asks(helper):
    met = threading.Barrier(2, timeout=60)
    helper.start(met.wait)
    met.wait()
    helper.finish()


def test_who_waits_long_is_woken(helper):
    done = []
    helper.start(lambda: (time.sleep(LONG), done.append(True)))
    helper.finish()
    assert done == [True]


def test_what_it_raises_is_raised_once_by_who_waits(helper):
    def fail():
        raise ValueError("no")

    helper.start(fail)
    with pytest.raises(ValueError, match="no"):
        helper.finish()
    helper.start(lambda: None)
    helper.finish()


def test_it_ends_and_begins_again():
    helper, seen = Helper(record_of_a_team()), []
    for _ in range(2):
        helper.start(lambda: seen.append(threading.current_thread()))
        helper.finish()
        helper.end()
    for thread in seen:
        thread.join(60)
        assert not thread.is_alive()
    helper.end()


def test_it_keeps_nothing_of_what_it_did(helper):
    array = np.zeros(3)
    gone = weakref.ref(array)
    helper.start(add, 0, 3, array)
    helper.finish()
    del array
    assert gone() is None


@pytest.fixture
def divided(monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 1)


@pytest.mark.parametrize("threads", [2, 3, 5])
def test_all_of_a_range_is_done_once(divided, threads):
    these, numbers = Workers(threads), np.zeros(101)
    for _ in range(50):
        these.split(add, 101, numbers)
    np.testing.assert_array_equal(numbers, 50 * np.arange(101))
    these.end()


def test_who_is_ready_does_parts_of_who_is_late(divided, monkeypatch):
    monkeypatch.setattr(workers, "PART", 10)
    these, done, all_others = Workers(2), [], threading.Event()

    def kernel(first, last):
        if first == 0:
            assert all_others.wait(60)
        done.append((first, last, threading.current_thread()))
        if len(done) == 7:
            all_others.set()

    these.split(kernel, 80)
    assert [part[:2] for part in sorted(done[:-1])] == [(k, k + 10) for k in range(10, 80, 10)]
    assert len({thread for *_, thread in done[:-1]}) == 1
    assert done[-1] == (0, 10, threading.current_thread())
    these.end()


@pytest.mark.parametrize("pieces", [1, 2, 7])
def test_all_pieces_are_done_once(divided, pieces):
    class Many:
        n = 100

    these, done = Workers(3), []
    these.together([Many], *[lambda k=k: done.append(k) for k in range(pieces)])
    assert sorted(done) == list(range(pieces))
    these.end()


@pytest.mark.parametrize("where", [0, 50])
def test_an_error_in_any_part_is_raised_when_all_have_ended(divided, where):
    these, ended = Workers(2), []

    def kernel(first, last):
        if first == where:
            raise ValueError("no")
        time.sleep(LONG)
        ended.append(first)

    with pytest.raises(ValueError, match="no"):
        these.split(kernel, 100)
    assert ended == [50 - where]
    numbers = np.zeros(100)
    these.split(add, 100, numbers)
    np.testing.assert_array_equal(numbers, np.arange(100))
    these.end()


def test_an_interrupt_waits_for_the_others(divided):
    these, ended = Workers(2), []

    def kernel(first, last):
        if first == 0:
            raise KeyboardInterrupt
        time.sleep(LONG)
        ended.append(first)

    with pytest.raises(KeyboardInterrupt):
        these.split(kernel, 100)
    assert ended == [50]
    these.end()


def test_of_two_threads_that_divide_work_one_does_its_own_alone(divided):
    these, inside, parts = Workers(2), threading.Event(), []
    go_on = threading.Event()

    def slow(first, last):
        inside.set()
        go_on.wait(60)

    other = threading.Thread(target=these.split, args=(slow, 100))
    other.start()
    inside.wait(60)
    these.split(lambda first, last: parts.append((first, last)), 100)
    go_on.set()
    other.join(60)
    assert parts == [(0, 100)]
    these.split(lambda first, last: parts.append((first, last)), 100)
    assert sorted(parts[1:]) == [(0, 50), (50, 100)]
    these.end()


@pytest.mark.slow
def test_a_process_ends_while_they_are_awake():
    code = (
        "import numpy as np; from ecs_eco.compiled import workers; workers.PARALLEL_FROM = 1; "
        "these = workers.Workers(4); these.split(lambda a, b: None, 100)"
    )
    for _ in range(3):
        done = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            timeout=120,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        )
        assert (done.returncode, done.stderr) == (0, "")


def test_threads_end_with_what_they_helped(divided):
    these, seen, met = Workers(2), [], threading.Barrier(2, timeout=60)

    def kernel(first, last):
        seen.append(threading.current_thread())
        met.wait()  # else one of them might do both parts

    these.split(kernel, 100)
    helper = next(thread for thread in seen if thread is not threading.current_thread())
    del these
    gc.collect()
    helper.join(60)
    assert not helper.is_alive()
