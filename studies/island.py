"""Do grass, deer, wolves and ravens persist on an island where animals can die of thirst, cold and
exhaustion, and what are the effects of hills, scavengers and thirst?

Policies are trained from random weights, one set per training seed, without selection. Each arm except the
first removes one factor after training; its policies are those of the first arm:
  island         as shipped
  no hills       hills are flat and hide no animal
  no scavengers  there are no ravens
  no thirst      deer and wolves lose no water

These hypotheses were written before the final run. World seeds and training seeds were new; the world's
parameters were tuned by hand on training seeds 1 to 3.
  1. Training takes at most 5 minutes of processor time on one core.
  2. Over 20,000 ticks, all of trees, grass, deer, wolves and ravens persist in at least 8 of 10 world seeds,
     for at least 3 of 4 training seeds.
  3. Without hills, wolves catch more: they eat more deer per wolf per second in ticks 1,000 to 4,000.
  4. Without scavengers, carcasses contain more of the nitrogen outside the soil at tick 4,000.
  5. Without thirst, deer live farther from the lake: their mean distance to its shore is greater in ticks
     1,000 to 4,000.
The differences in hypotheses 3 to 5 are paired by training seed and world seed; the 95% intervals of their
means treat training seeds and world seeds as replicates.
"""

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from studies.common.policies import trained, without_policies
from studies.common.study import Study, config_hash, verdict

TRAINING, WORLDS, FEWER = range(81, 85), range(8101, 8111), range(8101, 8104)
ARMS: dict[str, dict[str, Any]] = {
    "island": {},
    "no hills": {"terrain.hides": False, "terrain.hills.amplitude": 0.0},
    "no scavengers": {"species.raven.count": 0},
    "no thirst": {"species.deer.exchange.2.rate": 1e-9, "species.wolf.exchange.2.rate": 1e-9},
}
MORTAL = ("deer", "wolf", "raven")  # their extinction is final
CHUNK = 100  # [ticks] between checks


def world_of(changes: Mapping[str, Any]) -> Any:
    """Return the island with changes given as dotted keys."""
    from ecs_eco.config import load

    return load("island", dict(changes) or None)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train or reuse a cell's policies, run the world, and return numbers and measures."""
    from ecs_eco import World

    began = time.process_time()
    policies = trained(world_of({}), case["training"], config.get("training ticks"))
    seconds = time.process_time() - began
    living = world_of(config["arms"][case["arm"]])
    world = World.from_config(living, seed=case["seed"], policies=str(policies))
    mortal = [s for s in MORTAL if world.tables[s].n]
    ticks = case.get("ticks", config["window"][1])
    lake, looks = living.terrain.lakes[0], [(0, np.nan, np.nan)]
    while world.tick < ticks and all(world.tables[s].n for s in mortal):
        world.run(min(CHUNK, ticks - world.tick))
        looks.append((world.tick, distance(world, lake), locked(world)))
    series = world.series().to_pydict()
    columns = {name: np.array(series[name], float) for name in ("tick", "n", "died: eaten by wolf")}
    of = {s: np.array(series["species"]) == s for s in world.tables if s in set(series["species"])}
    first, last = config["window"]
    seen = np.array([x for x in looks if first <= x[0] <= last]) if world.tick >= last else None
    within = (columns["tick"] >= first) & (columns["tick"] < last)
    wolves = columns["n"][of["wolf"] & within].sum()
    return {
        "training seconds": seconds,
        "lived": world.tick,
        "persisted": world.tick >= ticks and all(world.tables[s].n for s in (*mortal, "tree", "grass")),
        "catch": None if seen is None else columns["died: eaten by wolf"][of["deer"] & within].sum() / wolves,
        "distance": None if seen is None else float(seen[:, 1].mean()),
        "locked": None if seen is None else float(seen[-1, 2]),
        "numbers": {
            s: {
                "mean": columns["n"][rows].mean(),
                "least": columns["n"][rows].min(),
                "most": columns["n"][rows].max(),
                "end": columns["n"][rows][-1],
            }
            for s, rows in of.items()
        },
        "deaths": {
            s: {
                c.removeprefix("died: "): int(k)
                for c in series
                if c.startswith("died: ") and (k := np.array(series[c], float)[rows].sum())
            }
            for s, rows in of.items()
        },
    }


def distance(world: Any, lake: Any) -> float:
    """Return the deer's mean distance from the shore [m]."""
    from ecs_eco.components import Position

    deer = world.tables["deer"]
    rows, p = deer.rows(), deer[Position]
    if not rows.size:
        return float("nan")
    return float((np.hypot(p.x[rows] - lake.at[0], p.y[rows] - lake.at[1]) - lake.radius).mean())


def locked(world: Any) -> float:
    """Return the share of nitrogen outside the soil that is in carcasses."""
    from ecs_eco.life.matter import stocks

    books, nitrogen = world.matter, world.substances.index("nitrogen")
    held = dict(zip(books.names, stocks(world, books)[:, nitrogen], strict=True))
    return float(held["carcass"] / (sum(held.values()) - held["soil"]))


def summarise(entries: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return verdicts on the hypotheses, and a line for each cell."""
    from ecs_eco.analysis.seed_grid import mean_interval

    by = {(e["case"]["arm"], e["case"]["training"], e["case"]["seed"]): e["result"] for e in entries}
    training = sorted({t for _, t, _ in by})
    whole = {
        t: [r["persisted"] for (arm, of, _), r in by.items() if arm == "island" and of == t] for t in training
    }
    slowest = max(r["training seconds"] for r in by.values())
    good = sum(np.mean(kept) >= 0.8 for kept in whole.values())
    out = [
        verdict("longest training [s of processor time]", slowest, "at most 300", slowest <= 300),
        verdict(
            "training seeds for which at least 8 of 10 worlds persist",
            f"{good} of {len(training)} ({', '.join(f'{sum(k)}/{len(k)}' for k in whole.values())})",
            "at least 3 of 4",
            good >= 0.75 * len(training),
        ),
    ]
    for arm, measure, what in (
        ("no hills", "catch", "deer eaten per wolf per second"),
        ("no scavengers", "locked", "share of the nitrogen outside the soil that is in carcasses"),
        ("no thirst", "distance", "distance of deer from the shore [m]"),
    ):
        pairs = {
            (t, s): (by["island", t, s][measure], r[measure])
            for (of, t, s), r in by.items()
            if of == arm and ("island", t, s) in by
        }
        whole_pairs = {k: v for k, v in pairs.items() if None not in v}
        out.append(_difference(arm, what, pairs, whole_pairs, mean_interval))
    head = [
        "arm",
        "training seed",
        "world seed",
        "lifetime [ticks]",
        "deer",
        "wolves",
        "ravens",
        "deer eaten per wolf per second",
        "distance of deer from the shore [m]",
        "share of nitrogen in carcasses",
    ]
    rows = [
        [
            *key,
            r["lived"],
            *(f"{r['numbers'][s]['least']:.0f} … {r['numbers'][s]['most']:.0f}" for s in MORTAL),
            r["catch"],
            r["distance"],
            r["locked"],
        ]
        for key, r in by.items()
    ]
    return {"verdicts": out, "table": {"head": head, "rows": rows}}


def _difference(
    arm: str, what: str, pairs: Mapping[Any, Any], whole: Mapping[Any, Any], mean_interval: Any
) -> dict[str, Any]:
    """Return the verdict on one arm: its difference from the island, over training seeds whose pairs all
    survived the time window."""
    seeds = sorted({t for t, _ in pairs})
    kept = [t for t in seeds if all(k in whole for k in pairs if k[0] == t)]
    if not kept:
        return verdict(
            f"{arm}: {what}",
            "no training seed whose worlds all survived long enough",
            "more than on the island",
            False,
        )
    worlds = sorted({s for _, s in pairs})
    table = np.array([[whole[t, s][1] - whole[t, s][0] for s in worlds] for t in kept])
    mean = mean_interval(table)
    island = np.mean([whole[t, s][0] for t in kept for s in worlds])
    return verdict(
        f"{arm}: {what}, difference from {island:.4g} on the island ({len(kept)} of {len(seeds)} "
        "training seeds)",
        list(mean),
        "above 0, and its interval",
        mean[1] > 0,
    )


CASES = [
    {"arm": arm, "training": t, "seed": s, **({"ticks": 20_000} if arm == "island" else {})}
    for s in WORLDS
    for arm in ARMS
    for t in TRAINING
    if arm == "island" or s in FEWER
]
CONFIG = {"identity": config_hash(without_policies(world_of({}))), "arms": ARMS, "window": [1000, 4000]}
STUDY = Study(
    name="island",
    claim="An island on which animals can die of thirst, cold and exhaustion persists; scavengers and "
    "thirst have their expected effects, hills do not.",
    config=CONFIG,
    cases=CASES,
    run=run,
    summarise=summarise,
    short_config={"training ticks": 100, "window": [40, 120]},
    short_cases=[{"arm": arm, "training": 81, "seed": 8101} for arm in ARMS],
)

if __name__ == "__main__":
    STUDY.main()
