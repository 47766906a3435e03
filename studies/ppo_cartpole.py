"""PPO as shipped solves CartPole-v1 in as few steps as Stable-Baselines3 with tuned settings, in less time.

    python -m studies.ppo_cartpole [--short]

The task counts as solved if the mean return of the last 100 episodes is at least 475. The two programs
alternate in one thread, with the same kind of environment and the same seeds; each learns both with its own
settings and with the other program's. Speed is environment steps per second of processor time, for training
and environments together. Cases with Stable-Baselines3 require stable-baselines3.
"""

import os
import statistics
import time
from dataclasses import replace
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
from ecs_eco.learning import PPO, Training, train
from studies.common.settings import as_hashed
from studies.common.stable_baselines import learn, settings
from studies.common.study import Study, verdict

STEPS, N_ENVS, SOLVED, NEVER = 100_000, 8, 475.0, 10**9

# Stable-Baselines3's tuned settings for CartPole-v1 (rl-baselines3-zoo), under our names.
THEIRS = PPO(
    horizon=32,
    learning_rate=1e-3,
    discount=0.98,
    gae_lambda=0.8,
    epochs=20,
    minibatch_size=256,
    clip=0.2,
    entropy_coef=0.0,
    anneal=STEPS // N_ENVS,
)
# Smaller minibatches, fewer epochs, and a longer horizon: the most reliable of 20 variants on seeds 100-109,
# which are not among the seeds below.
OURS = replace(THEIRS, minibatch_size=64, epochs=10, gae_lambda=0.9)


def ours(seed: int, steps: int, ppo: PPO) -> dict[str, Any]:
    """Train until solved, for at most `steps` steps."""
    import gymnasium

    envs, start = gymnasium.make_vec("CartPole-v1", N_ENVS, vectorization_mode="sync"), time.process_time()
    training = train(envs, ppo, steps, seed, stop=lambda so_far: so_far.steps_to(SOLVED) is not None)
    return _report(training, len(training.reports) * ppo.horizon * N_ENVS, time.process_time() - start)


def stable_baselines(seed: int, steps: int, ppo: PPO) -> dict[str, Any]:
    """Train the same task with Stable-Baselines3."""
    from stable_baselines3 import PPO as StableBaselinesPPO
    from stable_baselines3.common.env_util import make_vec_env

    start = time.process_time()
    model = StableBaselinesPPO(
        "MlpPolicy",
        make_vec_env("CartPole-v1", N_ENVS, seed=seed),
        seed=seed,
        device="cpu",
        **settings(ppo, anneal=True),
    )
    return _report(learn(model, steps, SOLVED), model.num_timesteps, time.process_time() - start)


def _report(training: Training, n_steps: int, seconds: float) -> dict[str, Any]:
    return {
        "steps_to_solve": training.steps_to(SOLVED),
        "steps": n_steps,
        "steps_per_s": round(n_steps / seconds, 1),
    }


ARMS = {
    "ecs-eco": (ours, OURS),
    "ecs-eco, their settings": (ours, THEIRS),
    "stable-baselines3": (stable_baselines, THEIRS),
    "stable-baselines3, our settings": (stable_baselines, OURS),
}
_warm: set[str] = set()


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train one arm with one seed; an unmeasured first training run compiles kernels and imports modules."""
    work, ppo = ARMS[case["arm"]]
    if case["arm"] not in _warm:
        work(10_000, 1_000, ppo)
        _warm.add(case["arm"])
    return work(case["seed"], config["steps"], ppo)


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Report how many steps each arm took to solve the task, and its speed."""
    arms = {arm: {c["case"]["seed"]: c["result"] for c in cases if c["case"]["arm"] == arm} for arm in ARMS}
    rows, took = [], {}
    for arm, runs in arms.items():
        if runs:
            took[arm] = sorted(r["steps_to_solve"] or NEVER for r in runs.values())
            worst = took[arm][-1] if took[arm][-1] < NEVER else "never"
            within = f"{sum(t <= STEPS for t in took[arm])} of {len(runs)}"
            rows.append(
                [
                    arm,
                    statistics.median(took[arm]),
                    worst,
                    within,
                    statistics.median(r["steps_per_s"] for r in runs.values()),
                ]
            )
    mine = took["ecs-eco"]
    verdicts = [
        verdict(
            "median steps to solve the task",
            statistics.median(mine),
            "<= 75,000",
            statistics.median(mine) <= 75_000,
        ),
        verdict(
            "solved within 100,000 steps",
            f"{sum(t <= STEPS for t in mine)} of {len(mine)}",
            "9 of 10",
            sum(t <= STEPS for t in mine) >= 0.9 * len(mine),
        ),
    ]
    for arm, peer in (
        ("ecs-eco", "stable-baselines3, our settings"),
        ("ecs-eco, their settings", "stable-baselines3"),
    ):
        ratios = [
            arms[arm][seed]["steps_per_s"] / r["steps_per_s"]
            for seed, r in arms[peer].items()
            if seed in arms[arm]
        ]
        if ratios:
            ratio = round(statistics.median(ratios), 2)
            verdicts.append(
                verdict(f"steps/s of {arm}, relative to {peer} (median of pairs)", ratio, ">= 1", ratio >= 1)
            )
    return {
        "verdicts": verdicts,
        "table": {
            "head": [
                "arm",
                "median steps to solve",
                "most steps to solve",
                "solved within 100,000 steps",
                "steps per second",
            ],
            "rows": rows,
        },
    }


STUDY = Study(
    name="ppo_cartpole",
    claim=str(__doc__).split("\n")[0],
    config={
        "ours": as_hashed(OURS),
        "theirs": as_hashed(THEIRS),
        "steps": STEPS,
        "environments": N_ENVS,
        "solved": SOLVED,
    },
    cases=[{"seed": seed, "arm": arm} for seed in range(10) for arm in ARMS],
    run=run,
    summarise=summarise,
    short_cases=[{"seed": 0, "arm": "ecs-eco"}],
)

if __name__ == "__main__":
    STUDY.main()
