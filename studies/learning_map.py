"""Where do grass, deer and wolves persist and cycle, by the rates at which deer and wolves learn, and by the size
of the ground?

Each pair of learning rates on the shipped ground and on a quarter of it, and the shipped rates on further
grounds, with the wolves of its registration. Policies are pre-trained as in `lifelong`. The hypotheses are in
registered/learning_map.toml.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from studies.common.moved import life
from studies.common.policies import trained, without_policies
from studies.common.predator_prey import SPARSE_WOLVES
from studies.common.registration import registration
from studies.common.seed_grid import record
from studies.common.study import Study, canonical, config_hash
from studies.common.training_seeds import interval
from studies.lifelong import LEARNERS, cycles, persists

REGISTERED = registration("learning_map")
RATES = REGISTERED.content["rates"]
PAIRS = [(deer, wolf) for deer in RATES["deer"] for wolf in RATES["wolf"]]
SHIPPED = (4e-3, 2e-3)
MAPS = ("quarter", "shipped")  # the grounds on which all pairs of rates are run
Entry = dict[str, Any]


def world(case: Mapping[str, Any]) -> Any:
    """Return a case's world."""
    from ecs_eco.config import load

    changes: dict[str, Any] = SPARSE_WOLVES | REGISTERED.arms[case["arm"]]
    for species in LEARNERS:
        if case[species]:
            changes[f"species.{species}.ppo.learning_rate"] = case[species]
        else:
            changes[f"species.{species}.policy.learn"] = False
    return load("predator-prey", changes)


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run a case's world with a training seed's policies; return its outcome and the policies' changes."""
    from ecs_eco.config import load

    folder = trained(load("predator-prey", SPARSE_WOLVES), case["training"], config["training ticks"])
    lived, moved = life(world(case), folder, case["seed"], config["ticks"], LEARNERS)
    return record(lived, lived.config) | {"moved": moved}


def cases() -> list[dict[str, Any]]:
    """Return all cases. The seeds vary slowest and the grounds fastest, so any beginning of the list is
    balanced."""
    seeds = REGISTERED.content["seeds"]
    of = [(arm, *pair) for pair in PAIRS for arm in (MAPS if pair != SHIPPED else REGISTERED.arms)]
    return [
        {"arm": arm, "deer": deer, "wolf": wolf, "training": training, "seed": seed}
        for training, seed in zip(seeds["training"], seeds["world"], strict=True)
        for arm, deer, wolf in of
    ]


def share(entries: Sequence[Entry], counts: Callable[[Any], bool] = persists, **wanted: Any) -> float:
    """Return the share of runs that count, among those whose case has the wanted values; NaN for none. A wanted
    value may be a sequence of allowed values."""
    allowed = {k: v if isinstance(v, list | tuple) else [v] for k, v in wanted.items()}
    kept = [e for e in entries if all(e["case"][k] in v for k, v in allowed.items())]
    return float(np.mean([counts(e["result"]) for e in kept])) if kept else float("nan")


def ground(entries: Sequence[Entry]) -> float:
    """Return the share of runs that persist on the shipped ground minus the share on a quarter of it."""
    large, small = (share([e for e in entries if e["case"]["arm"] == arm]) for arm in ("shipped", "quarter"))
    return large - small


def fast(entries: Sequence[Entry], species: str) -> float:
    """Return the share of runs that persist at a species' three slower rates minus the share at its three faster
    ones."""
    of = [e for e in entries if e["case"]["arm"] in MAPS]
    return share(of, **{species: RATES[species][:3]}) - share(of, **{species: RATES[species][3:]})


def at_shipped_rates(entries: Sequence[Entry]) -> int:
    """Return the number of runs that persist at the shipped rates on the shipped ground."""
    of = [
        e
        for e in entries
        if (e["case"]["arm"], e["case"]["deer"], e["case"]["wolf"]) == ("shipped", *SHIPPED)
    ]
    return sum(persists(e["result"]) for e in of)


def summarise(entries: list[Entry]) -> dict[str, Any]:
    """Return the registered verdicts, and a row for each ground and pair of rates."""
    by_seed = [
        [e for e in entries if e["case"]["training"] == seed]
        for seed in REGISTERED.content["seeds"]["training"]
    ]
    by_seed = [own for own in by_seed if own]
    lines = [
        REGISTERED.verdict(name, value, value[1] > 0)
        for name, value in {
            "ground": interval([ground(own) for own in by_seed]),
            "fast deer": interval([fast(own, "deer") for own in by_seed]),
            "fast wolves": interval([fast(own, "wolf") for own in by_seed]),
        }.items()
    ]
    alive = at_shipped_rates(entries)
    lines.append(REGISTERED.verdict("at the shipped rates", alive, alive >= 4))
    rows = [row([e for e in entries if key(e["case"]) == of], of) for of in dict.fromkeys(map(key, cases()))]
    return {"verdicts": lines, "table": {"head": HEAD, "rows": [r for r in rows if r[3]]}}


def key(case: Mapping[str, Any]) -> tuple[str, float, float]:
    """Return a case's ground and learning rates."""
    return case["arm"], case["deer"], case["wolf"]


def row(entries: Sequence[Entry], of: tuple[str, float, float]) -> list[Any]:
    """Return one row of the table."""
    results = [e["result"] for e in entries]
    gone = [r["extinct"] for r in results if r["extinct"]]
    moved = [[v for r in results for v in r["moved"].get(s, [])] for s in LEARNERS]
    return [
        *of,
        len(results),
        sum(map(persists, results)),
        sum(map(cycles, results)),
        ", ".join(f"{s} {gone.count(s)}" for s in dict.fromkeys(gone)) or "–",
        *(float(np.median(nats)) if nats else None for nats in moved),
        *(float(np.mean([r["numbers"][s]["mean"] for r in results])) if results else None for s in LEARNERS),
    ]


HEAD = [
    "ground",
    "learning rate of deer",
    "of wolves",
    "runs",
    "all persist",
    "cycle, in order",
    "first to die out",
    "change of the deer policy in 1,000 ticks [nats], median",
    "of the wolf policy",
    "mean deer",
    "mean wolves",
]
STUDY = Study(
    name="learning_map",
    claim=REGISTERED.content["claim"],
    config={
        "identity": {
            arm: config_hash(
                {"of": canonical(without_policies(world({"arm": arm, "deer": 4e-3, "wolf": 2e-3})))}
            )
            for arm in REGISTERED.arms
        },
        "ticks": REGISTERED.content["ticks"],
        "training ticks": None,
    },
    cases=cases(),
    run=run,
    summarise=summarise,
    short_cases=cases()[:2],
    short_config={"ticks": 500, "training ticks": 100},
    registered=REGISTERED,
)

if __name__ == "__main__":
    STUDY.main()
