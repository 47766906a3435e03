"""Ray as an executor, in processes of its own, for it leaves threads behind; skipped where it is missing."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from ecs_eco.lab.pool import PINS
from ecs_eco.lab.ray_executor import Imported, _knock, settings

ROOT = Path(__file__).parents[2]
CALLS = """
import json, os, signal, time
from ecs_eco.lab.executors import executor
from ecs_eco.lab.work import completed
from ecs_eco.engine.errors import ConfigError, Problem

def square(x):
    return x * x, os.getpid(), os.environ["NUMBA_NUM_THREADS"]

def refuse(x):
    raise ConfigError([Problem((), "no", x)])

def killed_once(path):
    if not os.path.exists(path):
        open(path, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    return "again"

def live():
    for tick in range(6000):
        time.sleep(0.1)

def stopped_once(path):  # as by the signal that a machine sends before it is taken away
    if not os.path.exists(path):
        open(path, "w").close()
        raise KeyboardInterrupt
    return "again"

if __name__ == "__main__":
    with executor("ray", 2) as pool:
        jobs = {i: (square, i) for i in range(6)}
        results = {key: future.result() for key, future in completed(pool, jobs)}
        error = pool.submit(refuse, 3).exception()
        lost = [pool.submit(call, call.__name__).result() for call in (killed_once, stopped_once)]
        late = [pool.submit(live) for _ in range(3)]
        time.sleep(1)
        begin = time.monotonic()
        pool.terminate()
        print(json.dumps({"results": results, "here": os.getpid(),
                          "error": [type(error).__name__, str(error)], "lost": lost,
                          "cancelled": [f.cancelled() for f in late],
                          "seconds": time.monotonic() - begin, "workers": pool.workers}))
"""


def output_of(*words: str | Path, cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    pytest.importorskip("ray")
    before = {name: value for name, value in os.environ.items() if name != "RAY_ADDRESS"}
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return subprocess.run(
        [sys.executable, *words],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=540,
        env=before | {"PYTHONPATH": path} | variables,
        check=False,
    )


def said_by(done: subprocess.CompletedProcess[str]) -> Any:
    """What a script printed as JSON; Ray prints, too."""
    return json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))


@pytest.mark.slow
def test_calls_are_tasks_of_one_thread_which_are_called_again_and_can_be_stopped(tmp_path: Path) -> None:
    script = tmp_path / "calls.py"
    script.write_text(CALLS)
    done = output_of(script, cwd=tmp_path, RAY_ADDRESS="local")
    assert done.returncode == 0, done.stderr
    said = said_by(done)
    assert {int(key): value[0] for key, value in said["results"].items()} == {i: i * i for i in range(6)}
    assert {value[2] for value in said["results"].values()} == {"1"}
    assert said["here"] not in {value[1] for value in said["results"].values()}
    assert said["error"] == ["ConfigError", "1 problem\n: 3\n  no"]
    assert said["lost"] == ["again", "again"]
    assert said["cancelled"] == [True, True, True]
    assert said["seconds"] < 25
    assert said["workers"] == 2


@pytest.mark.slow
def test_runs_go_on_from_their_checkpoints_when_a_worker_and_a_node_are_killed(tmp_path: Path) -> None:
    done = output_of("-m", "tests.lab.ray_cluster", tmp_path, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    said = said_by(done)
    assert said["ray"] == said["plain"]
    assert len(set(said["plain"].values())) == 4
    begun = [tick for ticks in said["begun"].values() for tick in ticks]
    assert len([tick for tick in begun if tick > 0]) >= 2, begun


def test_a_cluster_that_is_gone_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="refused"):
        _knock("127.0.0.1:9")
    done = output_of(
        "-c",
        "from ecs_eco.lab.executors import executor; executor('ray')",
        cwd=tmp_path,
        RAY_ADDRESS="127.0.0.1:9",
    )
    assert (
        "no Ray cluster answers there: Connection refused; expected: the address printed by `ray"
        in done.stderr
    )


def test_the_client_of_ray_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = output_of(
        "-c",
        "from ecs_eco.lab.executors import executor; executor('ray')",
        cwd=tmp_path,
        RAY_ADDRESS="ray://127.0.0.1:9",
    )
    assert "`ray job submit`" in done.stderr


def test_workers_look_for_modules_where_this_process_does_and_not_in_the_present_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folders = Imported()
    folders.extend([str(tmp_path), str(Path(json.__file__).parents[1])])  # Ray adds the present folder always
    assert folders == [str(Path(json.__file__).parents[1])]
    monkeypatch.syspath_prepend(tmp_path)  # a script that lies there
    folders.extend([str(tmp_path)])
    assert folders[-1] == str(tmp_path)


def test_tasks_run_with_one_thread_and_with_the_settings_that_results_depend_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    monkeypatch.setenv("ECS_ECO_PORTABLE", "1")
    monkeypatch.setenv("NUMBA_CPU_NAME", "haswell")
    monkeypatch.setenv("ECS_ECO_CACHE", "/here")
    found = settings()
    assert {found[name] for name in (*PINS, "PYTHONSAFEPATH")} == {"1"}
    assert (found["ECS_ECO_PORTABLE"], found["NUMBA_CPU_NAME"]) == ("1", "haswell")
    assert "ECS_ECO_CACHE" not in found
