"""Worker processes: threads, and how they end."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

from ecs_eco.lab.pool import ENDED, PINS, finishing, one_thread_each
from ecs_eco.record import run_to_folder

SCRIPT = """
import os, sys, time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from ecs_eco.lab.pool import begin_worker

def work(path):
    with open(path, "w") as file:
        file.write(str(os.getpid()))
    os.replace(path, path + ".done")
    time.sleep(300)

if __name__ == "__main__":
    with ProcessPoolExecutor(1, get_context("spawn"), initializer=begin_worker) as pool:
        for i in range(3):
            pool.submit(work, f"{sys.argv[1]}/{i}")
"""


def work_in_a_thread():
    """Do a call as Dask's workers do: in a thread of theirs, and tell what came of it."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(work).result()


def work():
    with finishing():
        return threading.current_thread() is not threading.main_thread()


@pytest.mark.slow
def test_a_call_in_a_thread_of_a_worker_does_its_work_and_hears_no_signals():
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert pool.submit(work_in_a_thread).result()
        assert not pool.submit(work).result()


def last_tick(config, folder):
    """Work that is told to end in the last tick of its run."""

    def told(done, total):
        if done == total:
            os.kill(os.getpid(), signal.SIGTERM)

    with finishing():
        run_to_folder(config, 1, 4, folder, "untrained", progress=told, report=False)


def lost(*_):
    """Work that is told to end where nothing that is raised gets through."""

    class Dying:
        def __del__(self):
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(1)

    with finishing():
        Dying()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("work", [last_tick, lost])
def test_a_worker_that_is_told_to_end_ends_though_its_work_was_done_by_then(menagerie, tmp_path, work):
    """A pool of which one worker was killed tells the others once, and waits for them."""
    process = get_context("spawn").Process(target=work, args=(menagerie(), tmp_path / "run"))
    process.start()
    process.join(120)
    assert process.exitcode == ENDED
    process.close()


def test_a_worker_ends_when_its_parent_is_killed(tmp_path):
    script = tmp_path / "pool.py"
    script.write_text(SCRIPT)
    parent = subprocess.Popen([sys.executable, script, tmp_path])
    try:
        done = tmp_path / "0.done"
        assert until(done.exists, 60), "the worker did not begin"
        worker = int(done.read_text())
    finally:
        parent.kill()
        parent.wait()
    assert until(lambda: not alive(worker), 30), "the worker outlived its parent"
    assert not (tmp_path / "1.done").exists()


def alive(pid: int) -> bool:
    """Whether a process runs; one that ended and that nobody asked for its result does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def until(condition, seconds: float) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False


def test_processes_have_one_thread_each_and_the_own_one_keeps_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with one_thread_each():
        assert [os.environ[name] for name in PINS] == ["1"] * len(PINS)
    assert os.environ["OMP_NUM_THREADS"] == "3"
    assert "MKL_NUM_THREADS" not in os.environ
