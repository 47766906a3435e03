"""Do deer and wolves with random weights learn to survive within a minute on one core?

For each training seed, the study records intake, deaths and happiness during training. It then compares
trained animals with random ones at constant population sizes (respawn, no births): deer against trained
wolves, and wolves against trained deer at high, medium and low prey density. If prey is plentiful, a wolf can
feed by standing still, so skill shows only if prey is scarce.
"""

import json
import time
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.policies import trained
from studies.common.predator_prey import frozen, identity
from studies.common.study import Study, verdict

SEEDS = (1, 2, 3, 4, 5, 6, 7)  # the first seven
DEER = (700, 200, 60)  # number of prey in the whole world
MEASURES = {
    "deer intake": 1,
    "deer starved": -1,
    "deer killed": -1,
    "wolf intake": 1,
    "wolf starved": -1,
    "kills per wolf": 1,
}


def evaluate(config: Any, policies: dict[str, str], deer: int, ticks: int, seed: int) -> dict[str, float]:
    """Run animals at constant population sizes; return rates per animal per tick after the first 100 ticks,
    and the deer's lifetime."""
    from ecs_eco import World
    from ecs_eco.config import load

    data = config.resolved()
    data["training"]["set"] = {}
    for species, n in (("deer", deer), ("wolf", 100)):
        data["species"][species]["count"] = n
        data["species"][species]["policy"]["file"] = None
    world = World.from_config(load(data), seed=seed, policies=policies, training=True, learn=False)
    series = world.run(ticks + 100).series().to_pandas()
    total = series[series.tick >= 100].groupby("species").sum()
    deer, wolf = total.loc["deer"], total.loc["wolf"]
    killed = deer["died: eaten by wolf"]
    return {
        "deer intake": deer.taken_in / deer.n,
        "deer starved": deer["died: starved"] / deer.n,
        "deer killed": killed / deer.n,
        "deer lifetime": deer.n / max(1.0, deer.deaths),
        "wolf intake": wolf.taken_in / wolf.n,
        "wolf starved": wolf["died: starved"] / wolf.n,
        "kills per wolf": killed / wolf.n,
    }


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train one seed from random weights and evaluate it."""
    from ecs_eco.lab.pretraining import pretrain

    world = frozen()
    start, cpu = time.perf_counter(), time.process_time()
    curves = pretrain(world, seed=case["training"], ticks=config["training_ticks"])["curves"]
    wall, cpu = time.perf_counter() - start, time.process_time() - cpu
    folder = str(trained(world, case["training"], config["training_ticks"]))
    out: dict[str, Any] = {
        "wall seconds": wall,
        "cpu seconds": cpu,
        "ticks": json.loads((Path(folder) / "training.json").read_text())["ticks"],
        "curves": {s: {k: np.round(v, 6) for k, v in c.items()} for s, c in curves.items() if s != "grass"},
    }
    for name, deer, wolf in (
        ("trained/trained", folder, folder),
        ("trained/random", folder, "random"),
        ("random/trained", "random", folder),
    ):
        out[name] = {
            str(n): evaluate(world, {"deer": deer, "wolf": wolf}, n, config["evaluation_ticks"], 4001)
            for n in config["deer"]
        }
    return out


def gain(results: list[dict[str, Any]], one: str, other: str, deer: int, measure: str) -> list[float]:
    """Return a measure's mean difference between two arms over training seeds, with its 95% interval."""
    from ecs_eco.analysis.survival import bootstrap_difference

    a, b = ([r[arm][str(deer)][measure] for r in results] for arm in (one, other))
    return list(bootstrap_difference(a, b, paired=True))


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Compare trained animals with random ones over training seeds."""
    results = [entry["result"] for entry in cases]
    densities = [int(n) for n in results[0]["trained/trained"]]
    slowest = max(r["cpu seconds"] for r in results)
    out = [verdict("longest training from random weights [s on one core]", slowest, "< 60", slowest < 60)]
    arms = (
        ("deer", "trained/trained", "random/trained", ("deer lifetime",), densities[:1]),
        ("wolf", "trained/trained", "trained/random", ("kills per wolf",), densities),
    )
    for species, one, other, measures, at in arms:
        for measure in measures:
            for n in at:
                d = gain(results, one, other, n, measure)
                out.append(
                    verdict(
                        f"{measure} at {n} deer, trained minus random {species} (over training seeds)",
                        d,
                        "above 0",
                        d[1] > 0,
                    )
                )
    rows = []
    for arm in ("trained/trained", "trained/random", "random/trained"):
        for n in densities:
            rows.append(
                [
                    arm,
                    n,
                    *(
                        float(np.mean([r[arm][str(n)][m] for r in results]))
                        for m in ("deer lifetime", *MEASURES)
                    ),
                ]
            )
    curves = []
    for species in ("deer", "wolf"):
        for k in ("intake", "deaths", "happiness"):
            first, last = (
                [float(np.mean(r["curves"][species][k][part])) for r in results]
                for part in (slice(0, 2), slice(-4, None))
            )
            curves.append([f"{species}, {k} while training", "", float(np.mean(first)), float(np.mean(last))])
    return {
        "verdicts": out,
        "table": {"head": ["deer/wolf", "deer", "deer lifetime", *MEASURES], "rows": rows},
        "learning": {"head": ["curve", "", "start", "end"], "rows": curves},
    }


STUDY = Study(
    name="from_scratch",
    claim="Deer and wolves learn to live from random weights in under a minute on one core.",
    config={
        "world": "predator-prey",
        "identity": identity(policies=False),
        "training_ticks": None,
        "evaluation_ticks": 400,
        "deer": list(DEER),
    },
    cases=[{"training": s} for s in SEEDS],
    run=run,
    summarise=summarise,
    short_cases=[{"training": 1}, {"training": 2}],
    short_config={"training_ticks": 640, "evaluation_ticks": 150, "deer": [700, 60]},
)

if __name__ == "__main__":
    STUDY.main()
