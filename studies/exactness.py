"""Does the same seed give the same bytes for 1 and 2 threads with learning on, between repeated runs, and for
any row order at tick 0?"""

from typing import Any

import numpy as np

from ecs_eco.record.ledger import imbalance
from studies.common.study import Study, verdict

TICKS = 200


def large(times: int) -> dict[str, Any]:
    """Return the predator-prey world with `times` times the area and the number of animals, so that every
    part of a tick uses all threads."""
    from ecs_eco.config import load

    config = load("predator-prey").resolved()
    config["space"]["size"] = [s * times**0.5 for s in config["space"]["size"]]
    for species in config["species"].values():
        species["count"] *= times
        species["policy"]["file"] = None
    return config


def gap(world: Any) -> float:
    """Return the energy ledger's largest gap in any tick, as a share of the stock."""
    s = {
        name: np.asarray(column, float)
        for name, column in world.series().to_pydict().items()
        if name not in ("species",)
    }
    left = imbalance(s)
    return float((np.abs(left) / np.maximum(1.0, np.abs(s["stock_before"]))).max())


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one seed several times under conditions that must not affect the result; return the digests."""
    from ecs_eco import World

    def world(threads: int, learn: bool) -> Any:
        return World.from_config(
            large(config["times"]), seed=case["seed"], policies="untrained", threads=threads, learn=learn
        )

    learning = [world(threads, True).run(config["ticks"]) for threads in (1, 2, 1)]
    frozen = [world(threads, False).run(config["ticks"]) for threads in (1, 2)]
    shuffled = world(1, False)
    generator = np.random.default_rng(case["seed"])
    for table in shuffled.tables.values():
        table.reorder(generator.permutation(table.rows()))
    shuffled.run(config["ticks"])
    deer = learning[0].tables["deer"].species.nerves.learner
    return {
        "learning, threads 1, 2, 1": [w.digest() for w in learning],
        "learning off, threads 1, 2": [w.digest() for w in frozen],
        "learning off, rows shuffled": shuffled.digest(),
        "updates of the deer's policy": deer.updates,
        "animals at the end": int(learning[0].tables["deer"].n + learning[0].tables["wolf"].n),
        "ledger gap, as a share of the stock": max(gap(w) for w in (*learning, *frozen, shuffled)),
    }


def summarise(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Report which digests are equal."""
    results = [c["result"] for c in cases]
    n = len(results)
    threads = sum(
        len(set(r["learning, threads 1, 2, 1"])) == 1 and r["updates of the deer's policy"] >= 2
        for r in results
    )
    frozen = sum(len(set(r["learning off, threads 1, 2"])) == 1 for r in results)
    rows = sum(r["learning off, rows shuffled"] == r["learning off, threads 1, 2"][0] for r in results)
    worst = max(r["ledger gap, as a share of the stock"] for r in results)
    return [
        verdict(
            "learning on: runs with the same hash of columns, weights and optimizer state on 1, 2 and again "
            "1 thread",
            f"{threads} of {n}",
            "all",
            threads == n,
        ),
        verdict(
            "learning off: runs with the same hash on 1 and 2 threads", f"{frozen} of {n}", "all", frozen == n
        ),
        verdict(
            "learning off: runs in which every organism has the same fate if rows are shuffled at tick 0",
            f"{rows} of {n}",
            "all",
            rows == n,
        ),
        verdict(
            "largest gap in the energy ledger in a tick, as a share of the stock",
            worst,
            "< 1e-6",
            worst < 1e-6,
        ),
    ]


STUDY = Study(
    name="exactness",
    claim="The same seed gives the same bytes for any number of threads and any order of rows, and energy "
    "is accounted for.",
    config={"ticks": TICKS, "times": 4},
    cases=[{"seed": s} for s in (101, 102, 103)],
    run=run,
    summarise=summarise,
    short_cases=[{"seed": 101}],
    short_config={"ticks": 140},
)

if __name__ == "__main__":
    STUDY.main()
