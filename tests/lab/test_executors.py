"""Engines: their names, and executors that are made or lent."""

from __future__ import annotations

import builtins
import sys
import threading
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any

import pytest

from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab.executors import completed, engine, executor, terminate, workers_of
from ecs_eco.lab.pool import Pool


def test_without_a_name_it_is_two_processes_of_this_machine() -> None:
    pool = executor()
    assert isinstance(pool, Pool)
    assert pool.workers == 2


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("rai", 'no such engine; allowed: local, ray, slurm; did you mean "ray"?'),
        ("slurm", "takes whole sweeps only; allowed: local, ray; SLURM runs sweeps, `ecs-eco sweep PLAN"),
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
    with pytest.raises(ConfigError, match=r'Ray is not installed; allowed: .*pip install "ecs-eco\[ray\]"'):
        executor("ray")


def test_an_executor_that_is_lent_is_left_running_and_what_waits_in_it_is_cancelled() -> None:
    hold, begun = threading.Event(), threading.Event()

    def work() -> bool:
        begun.set()
        return hold.wait(60)

    with ThreadPoolExecutor(1) as own:
        with pytest.raises(KeyboardInterrupt), engine(own) as lent:  # noqa: PT012
            first, second = lent.submit(work), lent.submit(work)
            assert begun.wait(60)
            raise KeyboardInterrupt
        assert second.cancelled()
        hold.set()
        assert first.result()
        assert own.submit(int, "3").result() == 3


def test_results_come_as_they_are_done_with_their_keys() -> None:
    with ThreadPoolExecutor(2) as own, engine(own, 5) as lent:
        assert workers_of(lent) == 5
        results = {
            key: future.exception() or future.result()
            for key, future in completed(lent, int, {"a": ("1",), "b": ("x",)})
        }
    assert results["a"] == 1
    assert isinstance(results["b"], ValueError)


def test_an_executor_without_an_end_of_its_own_is_told_to_begin_no_more() -> None:
    own = ThreadPoolExecutor(3)
    assert workers_of(own) == 3
    assert workers_of(Executor()) == 2
    terminate(own)
    with pytest.raises(RuntimeError, match="after shutdown"):
        own.submit(int)
