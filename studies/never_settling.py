"""Do the policies of deer and wolves that never stop learning settle, circle or drift?

Each run of predator-prey, with the wolves of its registration, lasts 100,000 ticks. Every 10,000 ticks, the study
stores both policies and what some living animals perceive. Afterward, each stored policy is compared with each
other one on all stored observations, and wolves of each time hunt deer of each time in the training world, where
policies are frozen and respawn holds numbers constant. K[i, j] is the logarithm of the deer that a wolf of time i
catches per second among deer of time j.

A policy that settles hardly changes between two times; one that drifts is the farther from an earlier one, the more
time has passed; one that circles, or wanders in a bounded region, is not. The hypotheses are in
registered/never_settling.toml.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from studies.arms_race import contemporary, slope
from studies.common.moved import log_chances
from studies.common.policies import trained, without_policies
from studies.common.predator_prey import SPARSE_WOLVES
from studies.common.registration import registration
from studies.common.study import Study, canonical, config_hash
from studies.common.training_seeds import by_training, interval
from studies.full_rate import LEARNERS, put, state

REGISTERED = registration("never_settling")
Result = dict[str, Any]
Weights = dict[str, np.ndarray]


def world() -> Any:
    """Return the world with the wolves of its registration."""
    from ecs_eco.config import load

    return load("predator-prey", SPARSE_WOLVES)


def run(config: dict[str, Any], case: Mapping[str, Any]) -> Result:
    """Run a world; return the distances between the policies of all times, and the catches of all pairs."""
    from ecs_eco import World

    folder = trained(world(), case["training"], config["training ticks"])
    living = World.from_config(world(), seed=case["seed"], policies=str(folder))
    times: list[dict[str, Weights]] = []
    seen: dict[str, list[np.ndarray]] = {name: [] for name in LEARNERS}
    while all(living.tables[name].n for name in LEARNERS):
        if living.tick % config["every"] == 0 and living.tick:
            times.append({name: state(living, name) for name in LEARNERS})
            for name in LEARNERS:
                seen[name].append(perceived(living, name, config["observations"]))
        if living.tick >= config["ticks"]:
            break
        living.run(min(50, config["ticks"] - living.tick))
    lived = living.tick >= config["ticks"] and len(times) == config["ticks"] // config["every"]
    return {
        "persisted": lived,
        "lived": living.tick,
        "distances": {s: distances(living, s, times, np.concatenate(seen[s])) for s in LEARNERS}
        if lived
        else None,
        "tests": catches(config, case, times) if lived else None,
    }


def perceived(living: Any, name: str, most: int) -> np.ndarray:
    """Return the readings of up to `most` living animals, evenly spaced by uid."""
    from ecs_eco.components import Sensor

    table = living.tables[name]
    readings = table[Sensor].readings[table.by_uid()]
    readings = readings[np.isfinite(readings).all(1)]  # newborns have not sensed yet
    return readings[np.linspace(0, len(readings) - 1, min(most, len(readings))).astype(int)].copy()


def distances(
    living: Any, name: str, times: Sequence[Mapping[str, Weights]], seen: np.ndarray
) -> list[list[float]]:
    """Return the mean of KL(i ‖ j) and KL(j ‖ i) [nats] between a species' policies of all pairs of times."""
    import torch

    brain = living.tables[name].species.nerves.brain
    chances = []
    for weights in times:
        brain.load(dict(weights[name]))
        with torch.no_grad():
            chances.append(log_chances(living.policy(name)(torch.from_numpy(seen))[0].numpy(), brain.groups))
    return [
        [0.5 * float(((np.exp(p) - np.exp(q)) * (p - q)).sum(1).mean()) for q in chances] for p in chances
    ]


def catches(
    config: Mapping[str, Any], case: Mapping[str, Any], times: Sequence[Mapping[str, Weights]]
) -> list[list[float]]:
    """Return K, with a row for each time of wolves and a column for each time of deer."""
    return [
        [caught(config, case["seed"], {"deer": of["deer"], "wolf": by["wolf"]}) for of in times]
        for by in times
    ]


def caught(config: Mapping[str, Any], seed: int, policies: Mapping[str, Weights]) -> float:
    """Return the logarithm of the deer that a wolf catches per second in the training world."""
    from ecs_eco import World
    from ecs_eco.config import for_training

    arena = World.from_config(
        for_training(world()), seed=seed, policies="untrained", training=True, learn=False
    )
    put(arena, policies).run(config["arena"])
    names, table = arena.recorder.names, arena.series().select(["n", "died: eaten by wolf"]).to_pydict()
    n, eaten = (np.asarray(v, float).reshape(-1, len(names))[config["arena"] // 4 :] for v in table.values())
    return float(np.log((eaten[:, names.index("deer")].sum() + 0.5) / n[:, names.index("wolf")].sum()))


# --- statistics ---------------------------------------------------------------------------------------------


def apart(matrix: list[list[float]], low: int, high: int) -> float:
    """Return the mean distance of policies that are from `low` to `high` stored times apart."""
    d = np.array(matrix)
    return float(np.mean([np.diag(d, lag).mean() for lag in range(low, high + 1)]))


def change(result: Result, name: str) -> float | None:
    """Return the mean distance of a policy from that of the next stored time [nats]."""
    return apart(result["distances"][name], 1, 1) if result["persisted"] else None


def growth(result: Result, name: str) -> float | None:
    """Return the logarithm of the ratio of mean distances, at least half of the run apart to one stored time apart;
    for a random walk over ten stored times it is ln(7)."""
    if not result["persisted"]:
        return None
    half = len(result["distances"][name]) // 2
    far = apart(result["distances"][name], half, len(result["distances"][name]) - 1)
    return float(np.log(far / apart(result["distances"][name], 1, 1)))


def trend_of(result: Result, whose: str) -> float | None:
    """Return the slope of K by the time of the hunters or of the prey, per 10,000 ticks."""
    if not result["tests"]:
        return None
    return 10 * slope(result["tests"], whose, REGISTERED.content["ticks"] - STUDY.config["every"])


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the registered verdicts, and a row for each training seed."""
    of, lines = REGISTERED.hypotheses, []
    tagged = [{"case": c["case"] | {"arm": "shipped"}, "result": c["result"]} for c in cases]

    def seeds(value: Any) -> list[float]:
        return interval(values) if (values := by_training(tagged, "shipped", value)) else [float("nan")] * 3

    for name in LEARNERS:
        moved = seeds(lambda r, s=name: change(r, s))
        lines.append(REGISTERED.verdict(f"{name}-moves", moved, moved[1] > of[f"{name}-moves"]["margin"]))
    for name in LEARNERS:
        grown = [float(np.exp(v)) for v in seeds(lambda r, s=name: growth(r, s))]
        lines.append(REGISTERED.verdict(f"{name}-bounded", grown, grown[2] < of[f"{name}-bounded"]["margin"]))
    for name, whose in (("wolf", "hunters"), ("deer", "prey")):
        trend = seeds(lambda r, w=whose: trend_of(r, w))
        most = of[f"{name}-trend"]["margin"]
        lines.append(REGISTERED.verdict(f"{name}-trend", trend, max(-trend[1], trend[2]) < most))
    same = seeds(lambda r: contemporary(r["tests"]) if r["tests"] else None)
    lines.append(REGISTERED.verdict("contemporary", same, same[1] > 0 or same[2] < 0))
    rows = [row(c) for c in cases]
    return {"verdicts": lines, "table": {"head": HEAD, "rows": rows}}


def row(case: dict[str, Any]) -> list[Any]:
    """Return one row of the table."""
    r = case["result"]
    numbers = [f(r, s) for f in (change, growth) for s in LEARNERS]
    return [
        case["case"]["training"],
        case["case"]["seed"],
        r["lived"],
        *numbers[:2],
        *(None if v is None else float(np.exp(v)) for v in numbers[2:]),
        trend_of(r, "hunters"),
        trend_of(r, "prey"),
        None if not r["tests"] else contemporary(r["tests"]),
    ]


HEAD = [
    "training seed",
    "world seed",
    "lived [ticks]",
    "deer: distance in 10,000 ticks [nats]",
    "wolves",
    "deer: ratio of distances, half a run to 10,000 ticks",
    "wolves",
    "K per 10,000 ticks of wolves' time",
    "of deer's time",
    "contemporaries",
]
SEEDS = REGISTERED.content["seeds"]
STUDY = Study(
    name="never_settling",
    claim=REGISTERED.content["claim"],
    config={
        "identity": config_hash({"of": canonical(without_policies(world()))}),
        "ticks": REGISTERED.content["ticks"],
        "every": 10_000,
        "observations": 200,
        "arena": 200,
        "training ticks": None,
    },
    cases=[
        {"training": training, "seed": seed}
        for training, seed in zip(SEEDS["training"], SEEDS["world"], strict=True)
    ],
    run=run,
    summarise=summarise,
    short_cases=[{"training": SEEDS["training"][0], "seed": SEEDS["world"][0]}],
    short_config={"ticks": 200, "every": 50, "observations": 20, "arena": 20, "training ticks": 100},
    registered=REGISTERED,
)

if __name__ == "__main__":
    STUDY.main()
