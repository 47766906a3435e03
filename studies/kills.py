"""Does a run that is killed repeatedly, at any moment and even during a write, end with the same bytes as an
uninterrupted run?"""

import os
import signal
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.runs import small, summary
from studies.common.study import Study, verdict


def live(world: dict[str, Any], seed: int, ticks: int, every: int, out: Path) -> None:
    """Start or resume a run."""
    from ecs_eco.record import resume, run_to_folder

    if (out / "manifest.json").is_file():
        resume(out, report=False, complain=lambda text: None, trust=True)
    else:
        run_to_folder(
            world,
            seed=seed,
            ticks=ticks,
            out=out,
            policies="untrained",
            learn=True,
            snapshot_every=5,
            checkpoint_every=every,
            report=False,
            trust=True,
        )


def kill_once(work: Any, wait: float) -> bool:
    """Fork a process to do the work, and kill it after `wait` seconds; return whether it had already
    ended. Raise RuntimeError if it ended with an error."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            work()
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)
    deadline = time.monotonic() + wait
    while time.monotonic() < deadline:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended and status:
            raise RuntimeError("the work failed; its error is above")
        if ended:
            return True
        time.sleep(0.0005)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return False


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Kill one run the required number of times, then let it finish; compare it with an uninterrupted run."""
    world, rng = small(case["world"], config["share"], case["brains"]), np.random.default_rng(case["seed"])
    if "network" in case:
        world["code"] = [case["network"].partition(":")[0]]
        for policy in (species["policy"] for species in world["species"].values()):
            if policy["kind"] != "none":
                del policy["hidden"]
                policy["network"] = case["network"]
    ticks, every = config["ticks"], config["checkpoint_every"]
    with tempfile.TemporaryDirectory() as place:
        live(world, case["seed"], ticks, every, Path(place) / "peace")
        whole, out = summary(Path(place) / "peace"), Path(place) / "killed"
        kills = writing = early = 0
        while kills < config["kills"]:
            if kill_once(
                lambda out=out: live(world, case["seed"], ticks, every, out),
                float(rng.uniform(0.0, config["longest"])),
            ):
                early += 1  # the run had finished: start another
                if early > 50:
                    break
                if summary(out) != whole:
                    return {"kills": kills, "during a write": writing, "same": False, "left behind": 0}
                out = Path(place) / f"killed-{early}"
                continue
            kills += 1
            writing += bool(list(out.rglob("*.tmp")))
        live(world, case["seed"], ticks, every, out)
        return {
            "kills": kills,
            "during a write": writing,
            "runs": early + 1,
            "same": summary(out) == whole,
            "left behind": len(list(out.rglob("*.tmp"))),
        }


def summarise(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Count kills, kills during a write, and runs that ended differently."""
    results = [c["result"] for c in cases]
    kills, writing = sum(r["kills"] for r in results), sum(r["during a write"] for r in results)
    wrong, left = sum(not r["same"] for r in results), sum(r["left behind"] for r in results)
    return [
        verdict("kills (SIGKILL) after which the run continued", kills, "200 or more", kills >= 200),
        verdict(
            "of these, kills during a write, which left a half-written file",
            writing,
            "60 or more",
            writing >= 60,
        ),
        verdict(
            "runs whose world or recording differs from an uninterrupted run",
            f"{wrong} of {len(results)}",
            "0",
            wrong == 0,
        ),
        verdict("half-written files left behind at the end", left, "0", left == 0),
    ]


STUDY = Study(
    name="kills",
    claim="A run that is killed at any moment can be resumed, and ends with the same bytes.",
    config={"ticks": 400, "checkpoint_every": 1, "share": 0.1, "kills": 60, "longest": 0.8},
    cases=[
        {"world": world, "brains": brains, "seed": 21 + i}
        for i, (world, brains) in enumerate(
            [
                ("predator-prey", "shared"),
                ("predator-prey", "individual"),
                ("reflexes", "individual"),
                ("lamb", "individual"),
                ("happiness", "individual"),
            ]
        )
    ],
    run=run,
    summarise=summarise,
    short_config={"ticks": 60, "kills": 6, "longest": 0.3},
    short_cases=[{"world": "predator-prey", "brains": "shared", "seed": 21}],
)

if __name__ == "__main__":
    STUDY.main()
