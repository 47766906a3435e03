"""Do grass, deer and wolves persist and cycle while deer and wolves never stop learning, as in the paper?

The study runs the shipped world, in which both species learn at a constant rate, with fresh training and
world seeds, and repeats the runs with frozen policies for comparison. The hypotheses are in
registered/lifelong.toml.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from studies.common.moved import WINDOW, life
from studies.common.policies import trained, without_policies
from studies.common.registration import registration
from studies.common.seed_grid import LAGS, both_peaks, cells, record
from studies.common.study import Study, canonical, config_hash
from studies.common.training_seeds import share_of_lives

REGISTERED = registration("lifelong")
LEARNERS = ("deer", "wolf")
QUARTERS = 4
Result = dict[str, Any]


def world(arm: str) -> Any:
    """Return an arm's world."""
    from ecs_eco.config import load

    return load("predator-prey", REGISTERED.arms[arm])


def run(config: dict[str, Any], case: Mapping[str, Any]) -> Result:
    """Run a world with a training seed's policies; return its outcome and the policies' changes."""
    folder = trained(world(case["arm"]), case["training"], config["training ticks"])
    lived, moved = life(world(case["arm"]), folder, case["seed"], config["ticks"], LEARNERS)
    return record(lived, lived.config) | {"moved": moved}


def persists(result: Result) -> bool:
    """Return whether grass, deer and wolves persisted."""
    return bool(result["persisted"])


def cycles(result: Result) -> bool:
    """Return whether all persisted, deer and wolves have a spectral peak beyond AR(1), and the 95% intervals
    of both lags overlap the ranges of `cycles`."""
    lags = result["cycles"]["lags"]
    in_order = all(
        pair in lags and lags[pair]["low"] <= high and lags[pair]["high"] >= low
        for pair, (low, high) in LAGS.items()
    )
    return persists(result) and both_peaks(result) and in_order


def moves(result: Result, nats: float = 0.05) -> bool:
    """Return whether all persisted and both policies moved at least `nats` per 1,000 ticks in each quarter of
    the run."""
    return persists(result) and all(min(by_quarter(result["moved"].get(s, []))) >= nats for s in LEARNERS)


def by_quarter(moved: Sequence[float]) -> list[float]:
    """Return the mean of the windows in each quarter of a run [nats]; 0 for a quarter without a window."""
    return [float(np.mean(part)) if len(part) else 0.0 for part in np.array_split(np.array(moved), QUARTERS)]


COUNTED: dict[str, Callable[[Result], bool]] = {"persists": persists, "cycles": cycles, "moves": moves}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the registered verdicts, and a row for each arm and training seed."""
    from ecs_eco.analysis.cycles import median_lag_interval

    learning = [c for c in cases if c["case"]["arm"] == "learning"]
    lines = []
    for name, counts in COUNTED.items():
        lives = [c["case"] | {"counts": counts(c["result"])} for c in learning]
        value, least = share_of_lives(lives, "counts"), REGISTERED.hypotheses[name]["margin"]
        lines.append(REGISTERED.verdict(name, value, value[0] >= least))
    for pair, (low, high) in LAGS.items():
        of = [r["cycles"]["lags"] for c in learning if persists(r := c["result"])]
        lag = median_lag_interval([lags[pair]["share"] for lags in of if pair in lags])
        value = [lag["median"], lag["low"], lag["high"]]
        lines.append(REGISTERED.verdict(pair, value, bool(lag["n"]) and low <= lag["median"] <= high))
    rows = [
        row(arm, training, [c["result"] for c in cases if (c["case"]["arm"], c["case"]["training"]) == of])
        for of in dict.fromkeys((c["case"]["arm"], c["case"]["training"]) for c in cases)
        for arm, training in [of]
    ]
    return {"verdicts": lines, "table": {"head": HEAD, "rows": rows}}


def row(arm: str, training: int, results: Sequence[Result]) -> list[Any]:
    """Return one row of the table."""
    gone = [r["extinct"] for r in results if r["extinct"]]
    windows = [[v for r in results for v in r["moved"].get(s, [])] for s in LEARNERS]
    periods = [r["cycles"]["period"] for r in results if r["persisted"] and r["cycles"]["period"]]
    return [
        arm,
        training,
        len(results),
        *(sum(map(counts, results)) for counts in COUNTED.values()),
        ", ".join(f"{s} {gone.count(s)}" for s in dict.fromkeys(gone)) or "–",
        *(float(np.median(nats)) if nats else None for nats in windows),
        float(np.median(periods)) if periods else None,
        *(float(np.mean([r["numbers"][s]["mean"] for r in results])) for s in ("grass", *LEARNERS)),
    ]


HEAD = [
    "arm",
    "training seed",
    "runs",
    "all persist",
    "cycle, in order",
    "both policies move in each quarter",
    "first to die out",
    f"change of the deer policy in {WINDOW:,} ticks [nats], median",
    "of the wolf policy",
    "median period [ticks]",
    "mean grass",
    "mean deer",
    "mean wolves",
]
SEEDS = REGISTERED.content["seeds"]
STUDY = Study(
    name="lifelong",
    claim=REGISTERED.content["claim"],
    config={
        "identity": {
            arm: config_hash({"of": canonical(without_policies(world(arm)))}) for arm in REGISTERED.arms
        },
        "ticks": REGISTERED.content["ticks"],
        "training ticks": None,
    },
    cases=[case for arm in REGISTERED.arms for case in cells([arm], SEEDS["training"], SEEDS["world"])],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": "learning", "training": SEEDS["training"][0], "seed": SEEDS["world"][0]}],
    short_config={"ticks": 1000, "training ticks": 100},
    registered=REGISTERED,
)

if __name__ == "__main__":
    STUDY.main()
