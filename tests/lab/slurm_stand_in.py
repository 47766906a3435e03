"""A stand-in for SLURM that behaves as its manual pages say: sbatch, squeue, scontrol and preemption.

    python slurm_stand_in.py sbatch --parsable SCRIPT

Its state is in the folder $SLURM_STAND_IN. A submitted array has a controller, a process that runs at most
%LIMIT of its tasks at a time; at its time limit less the notice of --signal=B:SIGNAL@NOTICE the batch shell
alone gets the signal, at the limit all of the task is killed. Who is requeued or preempted is run again, with
SLURM_RESTART_COUNT one higher. Times are in seconds: --time=0:05.
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

HOME = Path(os.environ["SLURM_STAND_IN"])
PENDING, RUNNING, COMPLETED, FAILED, TIMEOUT = "PENDING", "RUNNING", "COMPLETED", "FAILED", "TIMEOUT"


@contextmanager
def state() -> Iterator[dict[str, Any]]:
    """The state of all arrays, to be read and changed by one process at a time."""
    HOME.mkdir(parents=True, exist_ok=True)
    with open(HOME / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        path = HOME / "state.json"
        content = json.loads(path.read_text()) if path.exists() else {"next": 100, "arrays": {}}
        yield content
        beside = HOME / "state.json.new"  # whoever looks without the lock sees all or nothing
        beside.write_text(json.dumps(content))
        beside.replace(path)


def sbatch(words: list[str]) -> None:
    """Submit a script: read its #SBATCH lines, expand its array, start its controller, print its id."""
    assert words[0] == "--parsable"
    options: dict[str, str] = {}
    for line in Path(words[1]).read_text().splitlines()[1:]:
        if not line.startswith("#SBATCH "):
            break
        key, _, value = line.removeprefix("#SBATCH --").partition("=")
        options[key] = value
    spec, _, limit = options["array"].partition("%")
    indices = [i for part in spec.split(",") for i in _range(part)]
    most = int(os.environ.get("MAX_ARRAY_SIZE", 1001))
    if max(indices) >= most:
        sys.exit("sbatch: error: Batch job submission failed: Invalid job array specification")
    if options.get("partition", "all") != "all":
        sys.exit("sbatch: error: invalid partition specified: " + options["partition"])
    with state() as now:
        number = now["next"]
        now["next"] += 1 + len(indices)
        tasks = {
            str(i): {"state": PENDING, "restarts": 0, "id": number + 1 + k, "log": []}
            for k, i in enumerate(indices)
        }
        now["arrays"][str(number)] = {
            "script": str(Path(words[1]).absolute()),
            "options": options,
            "limit": int(limit or len(indices)),
            "tasks": tasks,
        }
    subprocess.Popen(
        [sys.executable, __file__, "controller", str(number)],
        start_new_session=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    print(f"{number};stand-in")


def squeue(words: list[str]) -> None:
    """Print array and index of all tasks that are pending or running."""
    given = dict(word.removeprefix("--").partition("=")[::2] for word in words)
    assert given["format"] == "%F %K"
    assert int(given["user"]) == os.getuid()
    with state() as now:
        for number, array in now["arrays"].items():
            if array["options"]["job-name"] == given["name"]:
                for i, task in array["tasks"].items():
                    if task["state"] in (PENDING, RUNNING):
                        print(number, i)


def scontrol(words: list[str]) -> None:
    """show config; requeue ID."""
    if words == ["show", "config"]:
        print(f"MaxArraySize            = {os.environ.get('MAX_ARRAY_SIZE', 1001)}")
        return
    assert words[0] == "requeue"
    with state() as now:
        for array in now["arrays"].values():
            for task in array["tasks"].values():
                if task["id"] == int(words[1]):
                    assert "requeue" in array["options"]
                    task["wish"] = "requeue"


def preempt(words: list[str]) -> None:
    """ARRAY INDEX: not a command of SLURM's; kills a running task and queues it again."""
    with state() as now:
        now["arrays"][words[0]]["tasks"][words[1]]["wish"] = "preempt"


def notice(words: list[str]) -> None:
    """ARRAY INDEX: not a command of SLURM's; what happens to a running task ahead of its time limit."""
    with state() as now:
        now["arrays"][words[0]]["tasks"][words[1]]["wish"] = "notice"


def controller(words: list[str]) -> None:
    """Run the tasks of an array until none is left."""
    number, running = words[0], dict[str, tuple[subprocess.Popen[bytes], float, bool]]()
    while True:
        with state() as now:
            array = now["arrays"][number]
            after = array["options"].get("dependency", "").removeprefix("afterany:")
            free = not after or all(
                t["state"] not in (PENDING, RUNNING) for t in now["arrays"][after]["tasks"].values()
            )
            for i, task in array["tasks"].items():
                if i in running:
                    running[i] = _look(task, array["options"], *running[i])
                    if task["state"] != RUNNING:
                        del running[i]
                elif task["state"] == PENDING and free and len(running) < array["limit"]:
                    running[i] = _start(number, i, task, array), time.monotonic(), False
            if not running and all(t["state"] != PENDING for t in array["tasks"].values()):
                return
        time.sleep(0.02)


def _start(number: str, index: str, task: dict[str, Any], array: dict[str, Any]) -> subprocess.Popen[bytes]:
    task["state"] = RUNNING
    task["log"].append("started")
    known = {
        "SLURM_ARRAY_JOB_ID": number,
        "SLURM_ARRAY_TASK_ID": index,
        "SLURM_JOB_ID": str(task["id"]),
        "SLURM_RESTART_COUNT": str(task["restarts"]),
    }
    output = array["options"]["output"].replace("%A", number).replace("%a", index)
    with open(output, "ab" if array["options"].get("open-mode") == "append" else "wb") as out:
        return subprocess.Popen(
            ["bash", array["script"]],
            env=os.environ | known,
            stdout=out,
            stderr=out,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
        )


def _look(
    task: dict[str, Any], options: dict[str, str], shell: subprocess.Popen[bytes], begun: float, told: bool
) -> tuple[subprocess.Popen[bytes], float, bool]:
    """Signal, end, requeue or bury a running task, as it is due."""
    seconds, limit = time.monotonic() - begun, _seconds(options.get("time"))
    name, notice = re.fullmatch(r"B:(\w+)@(\d+)", options["signal"]).groups()  # type: ignore[union-attr]
    wish = task.pop("wish", "")
    due = wish == "notice" or (not told and seconds > limit - int(notice))
    wish = "" if wish == "notice" else wish
    if wish == "preempt" or (wish == "requeue" and shell.poll() is None) or seconds > limit:
        with suppress(ProcessLookupError):
            os.killpg(shell.pid, signal.SIGKILL)
        shell.wait()
    elif due:
        shell.send_signal(getattr(signal, f"SIG{name}"))
        task["log"].append("signalled")
        told = True
    if wish:
        task["state"] = PENDING
        task["restarts"] += 1
        task["log"].append(wish)
    elif shell.poll() is not None:
        task["state"] = TIMEOUT if seconds > limit else FAILED if shell.returncode else COMPLETED
        task["log"].append(task["state"])
    return shell, begun, told


def _range(part: str) -> range:
    first, _, last = part.partition("-")
    return range(int(first), int(last or first) + 1)


def _seconds(text: str | None) -> float:
    if text is None:
        return float("inf")
    minutes, _, seconds = text.partition(":")
    return 60.0 * int(minutes) + int(seconds)


if __name__ == "__main__":
    called = {f.__name__: f for f in (sbatch, squeue, scontrol, preempt, notice, controller)}
    called[sys.argv[1]](sys.argv[2:])
