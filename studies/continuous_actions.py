"""PPO learns a continuous action in as few steps as Stable-Baselines3 (Pendulum-v1).

    python -m studies.continuous_actions [--short]

These hypotheses were written before the final run. The task counts as learned if the mean return of the last
100 episodes is at least −250. The two programs alternate in one thread, with the same settings, environments
and seeds (rewards are divided by 10, which does not affect the policy; returns are reported undivided).
1. PPO as shipped learns the task within 100,000 steps for at least 9 of 10 seeds.
2. Its median number of steps over seeds is at most that of Stable-Baselines3's PPO.

The settings were tuned for Stable-Baselines3 (rl-baselines3-zoo) and omit its state-dependent exploration;
results for seed 100 were already known. Cases with Stable-Baselines3 require stable-baselines3.
"""

import os
import statistics
import time
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
from ecs_eco.learning import PPO, Training, train
from studies.common.settings import as_hashed, from_hashed
from studies.common.stable_baselines import learn, settings
from studies.common.study import Study, verdict

STEPS, N_ENVS, LEARNT, NEVER, DIVISOR = 100_000, 4, -250.0, 10**9, 10.0
SETTINGS = PPO(
    horizon=1024,
    learning_rate=1e-3,
    discount=0.9,
    gae_lambda=0.95,
    epochs=10,
    minibatch_size=256,
    entropy_coef=0.0,
)


def environments(seed: int | None = None) -> Any:
    """Return Pendulum-v1 with rewards divided by ten: for Stable-Baselines3 if a seed is given, otherwise for
    our PPO."""
    import gymnasium

    def scaled(env: Any) -> Any:
        return gymnasium.wrappers.TransformReward(env, lambda reward: reward / DIVISOR)

    if seed is None:
        return gymnasium.make_vec("Pendulum-v1", N_ENVS, vectorization_mode="sync", wrappers=[scaled])
    from stable_baselines3.common.env_util import make_vec_env

    return make_vec_env("Pendulum-v1", N_ENVS, seed=seed, wrapper_class=scaled)


def ours(seed: int, steps: int, ppo: PPO) -> dict[str, Any]:
    """Train until the task is learned, for at most `steps` steps."""
    start = time.process_time()
    training = train(
        environments(),
        ppo,
        steps,
        seed,
        trunk="separate",
        stop=lambda so_far: so_far.steps_to(LEARNT / DIVISOR) is not None,
    )
    return _report(
        training, len(training.reports) * ppo.horizon * N_ENVS, DIVISOR, time.process_time() - start
    )


def stable_baselines(seed: int, steps: int, ppo: PPO) -> dict[str, Any]:
    """Train the same task with Stable-Baselines3."""
    from stable_baselines3 import PPO as StableBaselinesPPO

    start = time.process_time()
    model = StableBaselinesPPO(
        "MlpPolicy", environments(seed), seed=seed, device="cpu", **settings(ppo, anneal=False)
    )
    return _report(learn(model, steps, LEARNT), model.num_timesteps, 1.0, time.process_time() - start)


def _report(training: Training, n_steps: int, unit: float, seconds: float) -> dict[str, Any]:
    last = training.returns[-100:]
    return {
        "steps_to_learn": training.steps_to(LEARNT / unit),
        "steps": n_steps,
        "mean_return": round(statistics.fmean(last) * unit, 1) if last else None,
        "steps_per_s": round(n_steps / seconds, 1),
    }


ARMS = {"ecs-eco": ours, "stable-baselines3": stable_baselines}


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train one arm with one seed."""
    return ARMS[case["arm"]](case["seed"], config["steps"], from_hashed(config["settings"]))


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Report how many steps each arm took to learn the task, and its speed."""
    rows, medians, verdicts = [], {}, []
    for arm in ARMS:
        runs = [c["result"] for c in cases if c["case"]["arm"] == arm]
        if not runs:
            continue
        took = [r["steps_to_learn"] or NEVER for r in runs]
        medians[arm], within = statistics.median(took), sum(t <= STEPS for t in took)
        rows.append(
            [
                arm,
                f"{within} of {len(runs)}",
                medians[arm] if medians[arm] < NEVER else "never",
                statistics.median(r["mean_return"] for r in runs if r["mean_return"] is not None),
                statistics.median(r["steps_per_s"] for r in runs),
            ]
        )
        if arm == "ecs-eco":
            verdicts.append(
                verdict(
                    "runs that reach a mean return of -250 within 100,000 steps",
                    f"{within} of {len(runs)}",
                    ">= 9 of 10",
                    within >= 0.9 * len(runs),
                )
            )
    if len(medians) == len(ARMS):
        ratio = medians["ecs-eco"] / medians["stable-baselines3"]
        verdicts.append(
            verdict("median steps, relative to Stable-Baselines3", round(ratio, 3), "<= 1", ratio <= 1)
        )
    return {
        "verdicts": verdicts,
        "table": {
            "head": [
                "arm",
                "learned within 100,000 steps",
                "median steps",
                "median of the final mean return",
                "steps per second",
            ],
            "rows": rows,
        },
    }


STUDY = Study(
    name="continuous_actions",
    claim=str(__doc__).split("\n")[0],
    run=run,
    summarise=summarise,
    config={
        "settings": as_hashed(SETTINGS),
        "steps": STEPS,
        "environments": N_ENVS,
        "learnt": LEARNT,
        "divisor": DIVISOR,
    },
    cases=[{"seed": seed, "arm": arm} for seed in range(10) for arm in ARMS],
    short_cases=[{"seed": 0, "arm": "ecs-eco"}],
    short_config={"steps": 12_000},
)

if __name__ == "__main__":
    STUDY.main()
