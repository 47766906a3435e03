"""The pool: an executor of processes, or this one."""

from __future__ import annotations

import multiprocessing
import os
import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest

from ecs_eco.lab.pool import Pool
from ecs_eco.lab.work import completed


def raise_interrupt() -> None:
    raise KeyboardInterrupt


def test_one_worker_is_this_process() -> None:
    with Pool(1) as pool:
        assert pool.submit(os.getpid).result() == os.getpid()
        assert isinstance(pool.submit(int, "x").exception(), ValueError)
        with pytest.raises(KeyboardInterrupt):
            pool.submit(raise_interrupt)


def test_one_worker_begins_a_job_once_the_one_before_was_handed_out() -> None:
    done: list[int] = []
    with Pool(1) as pool:
        for key, future in completed(pool, {1: (done.append, 1), 2: (done.append, 2)}):
            assert future.done()
            assert done == list(range(1, key + 1))


def test_several_workers_are_processes_of_one_thread_each() -> None:
    with Pool(2) as pool:
        jobs = {
            "pid": (eval, "__import__('os').getpid()"),
            "threads": (eval, "__import__('os').environ['OMP_NUM_THREADS']"),
        }
        results = {key: future.result() for key, future in completed(pool, jobs)}
    assert results["pid"] != os.getpid()
    assert results["threads"] == "1"
    assert multiprocessing.active_children() == []


def test_workers_take_no_modules_of_the_folder_that_they_run_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("multiprocessing", "signal", "pickle", "pydantic"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'mark')!r}, 'w')\n")
    monkeypatch.chdir(tmp_path)
    with Pool(2) as pool:
        assert pool.submit(os.getpid).result() != os.getpid()
    assert not (tmp_path / "mark").exists()
    assert "PYTHONSAFEPATH" not in os.environ


def test_a_killed_worker_breaks_all_that_is_not_done_and_what_is_submitted_afterwards() -> None:
    with Pool(2) as pool:
        assert isinstance(pool.submit(os._exit, 1).exception(), BrokenProcessPool)
        assert isinstance(pool.submit(os.getpid).exception(), BrokenProcessPool)


def test_ctrl_c_ends_workers_whatever_they_do() -> None:
    def interrupted() -> None:
        with Pool(2) as pool:
            pool.submit(os.getpid).result()
            pool.submit(time.sleep, 600)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert multiprocessing.active_children() == []


def test_a_pool_that_was_terminated_starts_other_workers() -> None:
    with Pool(2) as pool:
        first = pool.submit(os.getpid).result()
        pool.submit(time.sleep, 600)
        pool.terminate()
        assert pool.submit(os.getpid).result() != first


def test_a_pool_needs_a_worker() -> None:
    with pytest.raises(ValueError, match="workers must be 1 or more, got 0"):
        Pool(0)
