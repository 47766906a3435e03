"""Do grass, deer and wolves persist if each deer and each wolf has its own network?

In predator-prey, all deer share one network, and all wolves another. Here each animal has its own, learns with
it alone, and passes the weights that it has learned on to its young. In a second arm, the young start from random
weights; in the third, networks are shared.
The hypotheses are in registered/individual_brains.toml.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from studies.common.moved import divergence
from studies.common.policies import trained, without_policies
from studies.common.registration import registration
from studies.common.seed_grid import cells, record
from studies.common.study import Study, canonical, config_hash
from studies.common.training_seeds import by_training, interval, share_of_lives

REGISTERED = registration("individual_brains")
LEARNERS = ("deer", "wolf")
BEGIN = 2000  # [ticks] before the numbers count
EVERY, SPAN, MOST = (
    1000,
    100,
    40,
)  # every so many ticks, the change of so many animals' policies in a span of ticks
Result = dict[str, Any]


def world(arm: str) -> Any:
    """Return an arm's world."""
    from ecs_eco.config import load

    return load("predator-prey", REGISTERED.arms[arm])


def run(config: dict[str, Any], case: Mapping[str, Any]) -> Result:
    """Run a world with a training seed's policies until deer or wolves die out; return its outcome, its speed
    and how much living animals learned."""
    from ecs_eco import World

    folder = trained(world(case["arm"]), case["training"], config["training ticks"])
    living = World.from_config(world(case["arm"]), seed=case["seed"], policies=str(folder))
    living.run(min(SPAN, config["ticks"]))  # compiles
    learnt: dict[str, list[float]] = {name: [] for name in LEARNERS}
    spent = 0.0
    before: dict[str, dict[int, Any]] = {}
    while living.tick < config["ticks"] and all(living.tables[name].n for name in LEARNERS):
        begin = time.process_time()
        living.run(min(SPAN, config["ticks"] - living.tick))
        spent += time.process_time() - begin
        for name, networks in before.items():
            learnt[name] += changes(living, name, networks)
        noted = case["arm"] != "shared" and living.tick % EVERY == 0
        before = {name: networks_of(living, name) for name in LEARNERS} if noted else {}
    numbers = living.recorder.since(min(BEGIN, living.tick // 2))["n"].astype(float)
    variation = numbers.std(0) / np.maximum(numbers.mean(0), 1e-9) if len(numbers) else np.zeros(0)
    return record(living, living.config) | {
        "variation": dict(zip(living.recorder.names, variation.tolist(), strict=False)),
        "learnt": {name: float(np.mean(values)) if values else None for name, values in learnt.items()},
        "ticks per second": (living.tick - SPAN) / spent if spent else None,
    }


def networks_of(living: Any, name: str) -> dict[int, Any]:
    """Return the networks of up to `MOST` animals, by uid."""
    uids = np.sort(living.tables[name].uid[living.tables[name].rows()])
    picked = uids[np.linspace(0, len(uids) - 1, min(MOST, len(uids))).astype(int)].tolist()
    return {uid: living.policy(name, uid) for uid in picked}


def changes(living: Any, name: str, before: Mapping[int, Any]) -> list[float]:
    """Return KL(then ‖ now) [nats] of the networks of those animals that still live, on the observations of all
    living animals."""
    import torch

    from ecs_eco.components import Sensor

    table = living.tables[name]
    rows = table.rows()
    seen = torch.from_numpy(table[Sensor].readings[rows][np.isfinite(table[Sensor].readings[rows]).all(1)])
    groups = table.species.nerves.individuals.groups
    with torch.no_grad():
        return [
            divergence(network(seen)[0].numpy(), living.policy(name, uid)(seen)[0].numpy(), groups)
            for uid, network in before.items()
            if uid in set(table.uid[rows].tolist())
        ]


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the registered verdicts, and a row for each arm."""
    margin = {name: of["margin"] for name, of in REGISTERED.hypotheses.items()}
    kept, lost = persisted(cases, "individual"), persisted(cases, "not inherited")
    steadier, changed, slowest = ratio(cases), learnt(cases), speed(cases)
    lines = [
        REGISTERED.verdict("persists", kept, kept[0] >= margin["persists"]),
        REGISTERED.verdict("inherited", lost, lost[0] <= margin["inherited"]),
        REGISTERED.verdict("steadier", steadier, steadier[2] < margin["steadier"]),
        REGISTERED.verdict("learn", changed, changed[1] > margin["learn"]),
        REGISTERED.verdict("speed", slowest, slowest >= margin["speed"]),
    ]
    rows = [row(arm, [c["result"] for c in cases if c["case"]["arm"] == arm]) for arm in REGISTERED.arms]
    return {"verdicts": lines, "table": {"head": HEAD, "rows": [r for r in rows if r]}}


def persisted(cases: list[dict[str, Any]], arm: str) -> list[float]:
    """Return the share of an arm's runs in which all species persist, with its 95% interval."""
    lives = [c["case"] | {"counts": c["result"]["persisted"]} for c in cases if c["case"]["arm"] == arm]
    return share_of_lives(lives, "counts")


def ratio(cases: list[dict[str, Any]]) -> list[float]:
    """Return the ratio of deer's coefficients of variation, individual to shared, as a geometric mean over
    training seeds with its 95% interval."""
    arms = [
        by_training(cases, arm, lambda result: np.log(result["variation"]["deer"]))
        for arm in ("individual", "shared")
    ]
    return [float(np.exp(v)) for v in interval([a - b for a, b in zip(*arms, strict=True)])]


def learnt(cases: list[dict[str, Any]]) -> list[float]:
    """Return how much the policies of individual animals changed [nats], the smaller of deer and wolves, as a mean
    over training seeds with its 95% interval."""
    species = [by_training(cases, "individual", lambda result, s=s: result["learnt"][s]) for s in LEARNERS]
    least = [min(of_seed) for of_seed in zip(*species, strict=True)]
    return interval(least) if least else [float("nan")] * 3


def speed(cases: list[dict[str, Any]]) -> float:
    """Return the ticks per second of processor time of the slowest run with individual networks."""
    return float(min(c["result"]["ticks per second"] for c in cases if c["case"]["arm"] == "individual"))


def row(arm: str, results: list[Result]) -> list[Any]:
    """Return one row of the table, or [] if there are no runs."""
    if not results:
        return []
    gone = [r["extinct"] for r in results if r["extinct"]]
    speeds = [r["ticks per second"] for r in results if r["ticks per second"]]
    return [
        arm,
        len(results),
        sum(r["persisted"] for r in results),
        ", ".join(f"{s} {gone.count(s)}" for s in dict.fromkeys(gone)) or "–",
        float(np.median([r["lived"] for r in results])),
        *(float(np.mean([r["numbers"][s]["mean"] for r in results])) for s in ("grass", *LEARNERS)),
        *(float(np.median([r["variation"].get(s, np.nan) for r in results])) for s in LEARNERS),
        *(mean_of([r["learnt"][s] for r in results if r["learnt"][s] is not None]) for s in LEARNERS),
        float(np.median(speeds)) if speeds else None,
    ]


def mean_of(values: list[float]) -> float | None:
    """Return the mean, or None of no values."""
    return float(np.mean(values)) if values else None


HEAD = [
    "arm",
    "runs",
    "all persist",
    "first to die out",
    "median lifetime [ticks]",
    "mean grass",
    "mean deer",
    "mean wolves",
    "variation of deer",
    "of wolves",
    f"change of a deer's policy in {SPAN} ticks [nats]",
    "of a wolf's",
    "ticks per second of processor time, median",
]
SEEDS = REGISTERED.content["seeds"]
STUDY = Study(
    name="individual_brains",
    claim=REGISTERED.content["claim"],
    config={
        "identity": {
            arm: config_hash({"of": canonical(without_policies(world(arm)))}) for arm in REGISTERED.arms
        },
        "ticks": REGISTERED.content["ticks"],
        "training ticks": None,
    },
    cases=cells(REGISTERED.arms, SEEDS["training"], SEEDS["world"]),
    run=run,
    summarise=summarise,
    short_cases=[
        {"arm": arm, "training": SEEDS["training"][0], "seed": SEEDS["world"][0]} for arm in REGISTERED.arms
    ],
    short_config={"ticks": 400, "training ticks": 100},
    registered=REGISTERED,
)

if __name__ == "__main__":
    STUDY.main()
