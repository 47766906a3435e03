"""Deer that search for grass learn as much from external learners as from the built-in PPO.

    python -m studies.outside [--short]

The world is examples/grazing.toml, with population sizes held constant. Three learners get 131,072
transitions each: the built-in PPO; Stable-Baselines3's PPO on slots (examples/rl_slots.py); and single-file
PPO on PettingZoo's dicts (examples/rl_parallel.py). All three have two hidden layers of 64 units and, where
applicable, the same settings. A hand-written function (examples/rl_function.py) and random actions serve as
baselines. `from_torch` loads externally learned policies into the world, where all policies are measured in
the same way: a deer's energy intake per 100 ticks, over 300 ticks of a world with a different seed. The
settings were tested with seed 1 of the built-in PPO; the other learners were not tuned.

1. At the end, each learner's mean over seeds is at least 0.9 times the built-in learner's.
2. For all 1,000 observations tested, a loaded policy makes the same choice as its original module.
"""

from __future__ import annotations

import os
import statistics
import time
from importlib import import_module
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
import numpy as np
import torch

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.learning import from_torch
from examples import rl_function
from studies.common.study import Study, verdict

GRAZING, STEPS, LOOKS = rl_function.GRAZING, 131_072, 6
PPO = {"learning_rate": 1e-3, "discount": 0.95, "entropy": 0.003, "minibatch": 1024, "horizon": 64}
LEARNERS = {"built-in PPO": "", "SB3 on slots": "rl_slots", "PPO on PettingZoo": "rl_parallel"}
OTHERS = ("function", "chance")


def intake(seed: int, ticks: int, policies: Any = "random", **changes: Any) -> float:
    """Return a deer's energy intake per 100 ticks with a policy."""
    world = World.from_config(
        load(GRAZING, changes), seed=1000 + seed, policies=policies, training=True, learn=False
    )
    return round(rl_function.meals(world.run(ticks // 3), ticks), 4)


def built_in(config: dict[str, Any], seed: int, look: Any) -> Any:
    """Train with the world's training recipe."""
    world = World.from_config(
        load(GRAZING, {"species.deer.ppo": PPO}),
        seed=seed,
        policies="untrained",
        training=True,
        learn=True,
        record=False,
    )
    ticks = config["steps"] // 64
    for done in range(0, ticks, 64):
        look(done * 64, world.policy("deer"))
        world.run(64)
    look(ticks * 64, world.policy("deer"))
    return world.policy("deer")


def same_choices(module: Any, seed: int) -> int:
    """Return the number of observations, out of 1,000, for which the most probable choices in the world equal
    the module's."""
    from ecs_eco.learning.vector_env import act

    world = World.from_config(GRAZING, policies={"deer": module}, record=False)
    brain = world.tables["deer"].species.nerves.brain
    x = np.random.default_rng(seed).uniform(-1, 1, (1000, brain.n_observations)).astype(np.float32)
    with torch.no_grad():
        logits = module(torch.from_numpy(x))[:, : sum(brain.groups)]
    own = torch.stack([part.argmax(1) for part in logits.split(list(brain.groups), 1)], 1).numpy()
    return int((act(brain, x) == own).all(axis=1).sum())


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train one learner with one seed, and measure it at intervals."""
    arm, seed, ticks = case["arm"], case["seed"], config["ticks"]
    if arm == "chance":
        return {"curve": [[0, intake(seed, ticks)]]}
    if arm == "function":
        function = {"kind": "function", "function": rl_function.act}
        return {"curve": [[0, intake(seed, ticks, **{"species.deer.policy": function})]]}
    curve: list[list[float]] = []
    start, watching = time.process_time(), 0.0

    def look(done: int, module: Any) -> None:
        nonlocal watching
        if done >= len(curve) * config["steps"] / config["looks"]:
            before = time.process_time()
            curve.append([done, intake(seed, ticks, {"deer": module})])
            watching += time.process_time() - before

    torch.set_num_threads(1)
    if not LEARNERS[arm]:
        built_in(config, seed, look)
        same = 0
    else:
        train = import_module(f"examples.{LEARNERS[arm]}").train  # it has optional dependencies
        same = same_choices(from_torch(train(config["steps"], seed, look)), seed)
    seconds = time.process_time() - start - watching
    return {
        "curve": curve,
        "seconds": round(seconds, 1),
        "same_choices": same,
        "steps_per_s": round(curve[-1][0] / seconds),
    }


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Compare the intake at the end."""
    ends = {
        arm: [c["result"]["curve"][-1][1] for c in cases if c["case"]["arm"] == arm]
        for arm in (*LEARNERS, *OTHERS)
    }
    mean = {arm: statistics.fmean(values) for arm, values in ends.items() if values}
    rows, verdicts, reference = [], [], mean.get("built-in PPO")
    for arm, value in mean.items():
        runs = [c["result"] for c in cases if c["case"]["arm"] == arm]
        seconds = [r["seconds"] for r in runs if "seconds" in r]
        rows.append(
            [
                arm,
                len(runs),
                round(value, 3),
                f"{min(ends[arm]):.3f} to {max(ends[arm]):.3f}",
                statistics.median(seconds) if seconds else "",
            ]
        )
        if not LEARNERS.get(arm) or reference is None:
            continue
        ratio = round(value / reference, 3)
        verdicts.append(
            verdict(
                f"{arm}: mean intake at the end, relative to the built-in PPO", ratio, ">= 0.9", ratio >= 0.9
            )
        )
        least = min(r["same_choices"] for r in runs)
        verdicts.append(
            verdict(
                f"{arm}: fewest identical choices in the world, of 1,000 observations",
                least,
                "1000",
                least == 1000,
            )
        )
    gain = round(mean["function"] / mean["chance"], 2)
    verdicts.append(verdict("the function: mean intake, relative to random actions", gain, "reported", True))
    return {
        "verdicts": verdicts,
        "table": {
            "head": [
                "policy",
                "seeds",
                "intake per deer per 100 ticks",
                "range over seeds",
                "training time [s], median",
            ],
            "rows": rows,
        },
    }


STUDY = Study(
    name="outside",
    claim=str(__doc__).split("\n")[0],
    run=run,
    summarise=summarise,
    config={"steps": STEPS, "looks": LOOKS, "ticks": 300, "ppo": PPO},
    cases=[{"seed": seed, "arm": arm} for seed in range(5) for arm in (*LEARNERS, *OTHERS)],
    short_cases=[{"seed": 0, "arm": arm} for arm in ("built-in PPO", "function", "chance")],
    short_config={"steps": 4096, "looks": 1, "ticks": 30},
)

if __name__ == "__main__":
    STUDY.main()
