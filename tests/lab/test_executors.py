"""Engines: their names, and executors that are made or lent."""

from __future__ import annotations

import builtins
import sys
import threading
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Any

import pytest

from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab.executors import engine, executor, workers_of
from ecs_eco.lab.pool import Pool
from ecs_eco.lab.work import Work, completed


def test_without_a_name_it_is_two_processes_of_this_machine() -> None:
    pool = executor()
    assert isinstance(pool, Pool)
    assert pool.workers == 2


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("rai", 'no such engine; expected: local, ray, slurm; did you mean "ray"?'),
        ("slurm", "runs only whole sweeps; expected: local or ray; SLURM runs sweeps (`ecs-eco sweep PLAN"),
    ],
)
def test_engines_that_cannot_be_had_are_refused_with_what_can(name: str, words: str) -> None:
    with pytest.raises(ConfigError) as caught:
        executor(name)
    assert words in str(caught.value)
    assert str(caught.value).splitlines()[1].startswith("--on: ")


def test_without_ray_it_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *more: Any) -> Any:
        if name == "ray":
            raise ImportError(name)
        return real(name, *more)

    monkeypatch.delitem(sys.modules, "ray", raising=False)
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ConfigError, match=r'Ray is not installed; expected: .*pip install -e "\.\[ray\]"'):
        executor("ray")


def test_an_executor_that_is_lent_is_left_running_and_what_waits_in_it_is_cancelled() -> None:
    hold, begun = threading.Event(), threading.Event()

    def work() -> bool:
        begun.set()
        return hold.wait(60)

    def interrupted(own: Executor) -> None:
        with engine(own) as lent, Work[int](lent) as calls:
            calls.add(1, work)
            calls.add(2, work)
            assert calls.arrived(0.0) == []
            futures.extend(calls.running)
            assert begun.wait(60)
            raise KeyboardInterrupt

    futures: list[Future[bool]] = []
    with ThreadPoolExecutor(1) as own:
        with pytest.raises(KeyboardInterrupt):
            interrupted(own)
        assert futures[1].cancelled()
        hold.set()
        assert futures[0].result()
        assert own.submit(int, "3").result() == 3


def test_results_come_as_they_are_done_with_their_keys() -> None:
    with ThreadPoolExecutor(2) as own, engine(own, 5) as lent:
        results = {
            key: future.exception() or future.result()
            for key, future in completed(lent, {"a": (int, "1"), "b": (int, "x")})
        }
    assert results["a"] == 1
    assert isinstance(results["b"], ValueError)


def test_calls_that_are_stopped_leave_an_executor_of_ones_own_running() -> None:
    hold = threading.Event()
    with ThreadPoolExecutor(1) as own:
        assert workers_of(own) == 1
        assert workers_of(Executor()) == 2
        calls = Work[int](own)
        for key in range(3):
            calls.add(key, hold.wait, 60)
        assert calls.arrived(0.0) == []
        waiting = list(calls.running)[1:]
        calls.stop()
        assert [future.cancelled() for future in waiting] == [True, True]
        assert len(calls) == 0
        hold.set()
        assert own.submit(int, "3").result() == 3
