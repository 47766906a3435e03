"""Claim: PPO as shipped solves CartPole-v1 in as few steps as Stable-Baselines3 with its tuned settings, and sooner.

    python studies/ppo_cartpole.py [--short]

Solved: the mean return of the last 100 episodes is at least 475. Each learns with its own and with the other's settings
from the same kind of environments, the same seeds in turn, in one thread; speed is environment steps per second of
processor time, training and environments together. Seeds that are in the results already are not repeated. Without
stable-baselines3 only ours is measured.
"""

from __future__ import annotations

import hashlib
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ecs_eco.learning import PPO, Training, train

RESULT = Path(__file__).parent / "results" / "ppo_cartpole.json"
SEEDS, STEPS, N_ENVS, SOLVED = range(10), 100_000, 8, 475.0
WITHIN_MEDIAN, WITHIN_MOST, NEVER = 75_000, 100_000, 10**9

# Stable-Baselines3's tuned settings for CartPole-v1 (rl-baselines3-zoo), in our words.
THEIRS = PPO(
    horizon=32,
    learning_rate=1e-3,
    discount=0.98,
    gae_lambda=0.8,
    epochs=20,
    minibatch=256,
    clip=0.2,
    entropy=0.0,
    anneal=STEPS // N_ENVS,
)
# Smaller minibatches, used less often, and a longer view: the surest of 20 variants on seeds 100-109, none of which is
# among those below.
OURS = replace(THEIRS, minibatch=64, epochs=10, gae_lambda=0.9)


def ours(seed: int, steps: int, ppo: PPO) -> dict[str, Any]:
    """Train until solved or `steps` are over."""
    import gymnasium

    envs, start = gymnasium.make_vec("CartPole-v1", N_ENVS, vectorization_mode="sync"), time.process_time()
    training = train(envs, ppo, steps, seed, stop=lambda so_far: so_far.steps_to(SOLVED) is not None)
    return _report(training, len(training.reports) * ppo.horizon * N_ENVS, time.process_time() - start)


def stable_baselines(seed: int, steps: int, ppo: PPO) -> dict[str, Any]:
    """The same with Stable-Baselines3."""
    import torch
    from stable_baselines3 import PPO as StableBaselinesPPO
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.env_util import make_vec_env

    class Episodes(BaseCallback):
        """Note each episode's return and the steps at its end; stop after the rollout that solves the task."""

        def __init__(self) -> None:
            super().__init__()
            self.training = Training(brain=None)  # type: ignore[arg-type]
            self.solved = False

        def _on_step(self) -> bool:
            ended = [info["episode"]["r"] for info in self.locals["infos"] if "episode" in info]
            self.training.returns += ended
            self.training.steps += [self.num_timesteps] * len(ended)
            return not self.solved

        def _on_rollout_end(self) -> None:
            self.solved = self.training.steps_to(SOLVED) is not None

    torch.set_num_threads(1)
    episodes, start = Episodes(), time.process_time()
    model = StableBaselinesPPO(
        "MlpPolicy",
        make_vec_env("CartPole-v1", N_ENVS, seed=seed),
        n_steps=ppo.horizon,
        batch_size=ppo.minibatch,
        n_epochs=ppo.epochs,
        gamma=ppo.discount,
        gae_lambda=ppo.gae_lambda,
        ent_coef=ppo.entropy,
        learning_rate=lambda left: left * ppo.learning_rate,
        clip_range=lambda left: left * ppo.clip,
        seed=seed,
        device="cpu",
    )
    model.learn(steps, callback=episodes)
    return _report(episodes.training, model.num_timesteps, time.process_time() - start)


def main(short: bool = False) -> dict[str, Any]:
    """Run the seeds that are missing, write the results after each, and return them; `short` writes nothing."""
    arms: dict[str, tuple[Callable[[int, int, PPO], dict[str, Any]], PPO]] = {
        "ecs-eco": (ours, OURS),
        "ecs-eco, their settings": (ours, THEIRS),
    }
    if _version("stable-baselines3"):
        arms["stable-baselines3"] = stable_baselines, THEIRS
        arms["stable-baselines3, our settings"] = stable_baselines, OURS
    for work, ppo in arms.values():
        work(10_000, 1_000, ppo)  # compile and import, unmeasured
    about = _about()
    result = _earlier(about) if not short else about | {"runs": {}}
    for seed in SEEDS[: 1 if short else None]:
        runs = result["runs"].setdefault(str(seed), {})
        for name in [name for name in arms if name not in runs]:
            work, ppo = arms[name]
            runs[name] = work(seed, STEPS, ppo)
            print(f"seed {seed}: {name}: {runs[name]}", flush=True)
        result["summary"] = _summary(result["runs"])
        if not short:
            _write(result)
    print(json.dumps(result["summary"], indent=1))
    return result


def _report(training: Training, n_steps: int, seconds: float) -> dict[str, Any]:
    return {"steps_to_solve": training.steps_to(SOLVED), "steps": n_steps, "steps_per_s": round(n_steps / seconds, 1)}


def _summary(runs: dict[str, dict[str, dict[str, Any]]]) -> dict[str, Any]:
    """Return per arm how many seeds solved the task within the limits, their median, and the speed."""
    summary: dict[str, Any] = {}
    for arm in sorted({arm for run in runs.values() for arm in run}):
        took = sorted(run[arm]["steps_to_solve"] or NEVER for run in runs.values() if arm in run)
        summary[arm] = {
            "seeds": len(took),
            "median_steps_to_solve": statistics.median(took),
            "most_steps_to_solve": took[-1] if took[-1] < NEVER else None,
            "solved_within_100000": sum(steps <= WITHIN_MOST for steps in took),
            "steps_per_s": statistics.median(run[arm]["steps_per_s"] for run in runs.values() if arm in run),
        }
    for arm, peer in (("ecs-eco", "stable-baselines3, our settings"), ("ecs-eco, their settings", "stable-baselines3")):
        ratios = [run[arm]["steps_per_s"] / run[peer]["steps_per_s"] for run in runs.values() if peer in run]
        if ratios:
            summary[arm][f"times_the_speed_of {peer}"] = round(statistics.median(ratios), 2)
    first = summary["ecs-eco"]
    first["holds"] = first["median_steps_to_solve"] <= WITHIN_MEDIAN and first["solved_within_100000"] >= 0.9 * first["seeds"]
    return summary


def _about() -> dict[str, Any]:
    """Return what was measured, and with what."""
    config = {"ours": asdict(OURS), "theirs": asdict(THEIRS), "steps": STEPS, "environments": N_ENVS, "solved": SOLVED}
    config_hash = hashlib.sha256(json.dumps(config, sort_keys=True).encode()).hexdigest()[:16]
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=Path(__file__).parent, capture_output=True, text=True, check=False)
    packages = ("numpy", "numba", "torch", "gymnasium", "stable-baselines3")
    return {
        "claim": __doc__.split("\n")[0].removeprefix("Claim: "),
        "commit": commit.stdout.strip() or None,
        "config": config,
        "config_hash": config_hash,
        "versions": {package: _version(package) for package in packages},
    }


def _earlier(about: dict[str, Any]) -> dict[str, Any]:
    """Return the results so far if they are of the same configuration, or none."""
    if RESULT.exists() and (earlier := json.loads(RESULT.read_text()))["config_hash"] == about["config_hash"]:
        return about | {"runs": earlier["runs"]}
    return about | {"runs": {}}


def _write(result: dict[str, Any]) -> None:
    RESULT.parent.mkdir(exist_ok=True)
    part = RESULT.with_suffix(".part")
    part.write_text(json.dumps(result, indent=1) + "\n")
    os.replace(part, RESULT)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


if __name__ == "__main__":
    main(short="--short" in sys.argv[1:])
