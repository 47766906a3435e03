"""Kernels in parts, which several threads take: each part once, whoever does it."""

import os
import subprocess
import sys
import threading
import time

import numba
import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

from ecs_eco.compiled import helpers, parts, team, workers
from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.numba_version import plain
from ecs_eco.compiled.workers import Workers

pytestmark = pytest.mark.skipif(plain(), reason="only kernels of our own have parts")


@njit
def count(first, last, times, weights, more, twice, pair):
    for i in range(first, last):
        times[i] += weights[i % weights.size] * (2 if twice else 1) + more + pair[0]


@njit
def fail_at(first, last, where):
    for i in range(first, last):
        if i == where:
            raise ValueError("no")


@njit
def slow(first, last, out):
    for i in range(first, last):
        for k in range(20_000):
            out[i] += (k * 7) % 3


@pytest.fixture(params=[2, 3])
def threads(request, monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 1)
    monkeypatch.setattr(workers, "PART", 1)
    those = Workers(request.param)
    yield those
    those.end()


@pytest.mark.parametrize("awake", [0, 1e-5, helpers.AWAKE])
def test_every_part_is_done_once_whether_helpers_are_awake_asleep_or_late(threads, monkeypatch, awake):
    monkeypatch.setattr(helpers, "AWAKE", awake)
    rng = np.random.default_rng(0)
    weights = np.arange(1, 4, dtype=np.float32)
    for turn in range(500):
        n = int(rng.integers(2, 3000))
        times = np.zeros(n)
        threads.split(count, n, times, weights, 0.5, True, (1, 2.0))
        np.testing.assert_array_equal(times, 2 * weights[np.arange(n) % 3] + 1.5)
        if turn % 100 == 0:
            time.sleep(0.01)


def test_helpers_take_parts(threads):
    """All cores may have other work for a while, hence the time."""
    out, until = np.zeros(64), time.monotonic() + 60
    threads.split(slow, 64, out)
    while time.monotonic() < until:
        begun = time.thread_time()
        threads.split(slow, 64, out)
        own = time.thread_time() - begun
        begun = time.thread_time()
        slow(0, 64, out)
        if own < 0.8 * (time.thread_time() - begun):
            break
    else:
        raise AssertionError("this thread did all by itself, for a minute")


def test_what_fails_in_one_part_is_said_and_the_next_call_is_as_usual(threads):
    for where in (0, 999):
        with pytest.raises(RuntimeError, match="fail_at: it failed in one of"):
            threads.split(fail_at, 1000, where)
        threads.split(fail_at, 1000, -1)
    times = np.zeros(1000)
    threads.split(count, 1000, times, np.ones(1, np.float32), 0.0, False, (0, 0.0))
    assert (times == 1).all()


def test_kernels_of_unlike_arguments_follow_each_other(threads):
    a, b = np.zeros(100), np.zeros(100, np.float32)
    for _ in range(100):
        threads.split(count, 100, a, np.ones(1, np.float32), 0.0, False, (0, 0.0))
        threads.split(count, 100, b, np.ones(2), 1, False, (1, 0))
    assert (a == 100).all()
    assert (b == 300).all()


def test_what_is_no_kernel_of_ours_is_divided_too(threads):
    plain = numba.njit(nogil=True)(count.py_func)
    for function in (plain, count.py_func):
        times = np.zeros(100)
        threads.split(function, 100, times, np.ones(1, np.float32), 0.0, False, (0, 0.0))
        assert (times == 1).all()


def test_what_a_kernel_returns_is_let_go(threads):
    @njit
    def copied(first, last, out):
        out[first:last] += 1
        return out[first:last].copy()

    out = np.zeros(1000)
    threads.split(copied, 1000, out)
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats()
    for _ in range(99):
        threads.split(copied, 1000, out)
    after = rtsys.get_allocation_stats()
    _nrt_python.memsys_disable_stats()
    assert (out == 100).all()
    assert after.alloc - before.alloc == after.free - before.free > 100


def test_arguments_may_have_defaults(threads):
    @njit
    def raised(first, last, out, by=2):
        out[first:last] += by

    out = np.zeros(100)
    threads.split(raised, 100, out)
    assert (out == 2).all()


def test_after_an_interruption_nobody_is_at_work(threads, monkeypatch):
    """As a second Ctrl-C would, while this thread waits for one who is late."""
    record, naps = threads.team.record, []

    def nap(seconds):
        naps.append(seconds)
        if len(naps) == 1:
            raise KeyboardInterrupt
        record[parts.INSIDE] = 0

    monkeypatch.setattr(team.time, "sleep", nap)
    times = np.zeros(100)
    threads.split(count, 100, times, np.ones(1, np.float32), 0.0, False, (0, 0.0))
    record[parts.INSIDE] = 1  # one who never leaves
    with pytest.raises(KeyboardInterrupt):
        threads.team._wait()
    assert len(naps) == 2
    assert record[parts.INSIDE] == 0


def test_a_helper_that_is_late_is_waited_for(threads, monkeypatch):
    monkeypatch.setattr(team, "AWAKE", 0)
    out, expected = np.zeros(8), np.zeros(8)
    slow(0, 8, expected)
    for turn in range(1, 100):
        threads.split(slow, 8, out)
        np.testing.assert_array_equal(out, turn * expected)


def test_too_many_arguments_are_refused(monkeypatch):
    @njit
    def one(first, last, a, b, c):
        a[first] = b[first] + c[first]

    monkeypatch.setattr(parts, "ROOM", 100)
    those, a = team.Team(1), np.zeros(9)
    with pytest.raises(Exception, match="one: its arguments take 168 bytes; at most 100 can be divided"):
        those.run(one, 0, 9, 2, (a, a, a))


def test_worlds_in_threads_have_teams_of_their_own(monkeypatch):
    monkeypatch.setattr(workers, "PARALLEL_FROM", 1)
    monkeypatch.setattr(workers, "PART", 10)
    sums = {}

    def live(number):
        those, times = Workers(2), np.zeros(1000)
        for _ in range(300):
            those.split(count, 1000, times, np.ones(1, np.float32), float(number), False, (0, 0.0))
        those.end()
        sums[number] = times

    several = [threading.Thread(target=live, args=(k,)) for k in range(3)]
    for thread in several:
        thread.start()
    for thread in several:
        thread.join()
    for number, times in sums.items():
        assert (times == 300 * (1 + number)).all()


SCRIPT = """
import numpy as np
from ecs_eco.compiled import jit
from ecs_eco.systems.age import grow_old
from ecs_eco.compiled.team import Team

n = 100
those = Team(1)
age = np.zeros(n, np.float32)
those.run(grow_old, 0, n, 4, (np.ones(n, bool), np.zeros(n, np.int64), 4, 1.0, age, np.zeros(n, np.float32)))
assert (age == 1).all(), age  # it was set to 0
print(jit.FOLDER.compiled)
those.helpers[0].end()
"""


@pytest.mark.slow
def test_kernels_in_parts_are_kept_on_disk(tmp_path):
    compiled = [
        int(
            subprocess.run(
                [sys.executable, "-c", SCRIPT],
                capture_output=True,
                text=True,
                check=True,
                env=os.environ | {"ECS_ECO_CACHE": str(tmp_path)},
            ).stdout
        )
        for _ in range(2)
    ]
    assert compiled[0] > 0
    assert compiled[1] == 0
