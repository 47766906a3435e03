"""Do krill learn to hunt, and do copepods still migrate among krill that have learned, both with frozen
policies and while both species continue to learn?

In the world learning-krill, both species are trained at the same time from random weights, each responding to
the other; training seeds are the replicates.

    hunt      krill among untrained copepods, with population sizes held constant: their catch,
              the energy they use, and when they chase
    life      20 days after the first: cosinor of the copepods' mean depth

`learned` arms use the trained policies, `untrained` arms use random weights, and `reflex` arms use the krill
of the world diel-migration, for which speed costs less. Training takes about a minute of CPU time, and the
trained policies are stored; a case takes 3 to 20 s.
"""

from typing import Any

import numpy as np

from studies.common.study import Study, verdict
from studies.common.training_seeds import by_training, contrast, in_words, interval, none, swing

WORLD = "learning-krill"
HELD = {'training.set."species.krill.count"': 40, 'training.set."species.krill.max_count"': 40}
ARMS: dict[str, dict[str, Any]] = {
    "hunt: learned": {"krill": "learned"},
    "hunt: untrained": {"krill": "untrained"},
    "hunt: reflex": {"krill": "reflex"},
    "life": {"learn": False},
    "life: both go on learning": {"learn": True},
}
TRAINING_SEEDS, SEEDS = tuple(range(1, 7)), (301, 302)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train or reuse the policies, run one world, and measure."""
    from ecs_eco import World
    from ecs_eco.config import load
    from studies.common.sea import life, policies_of

    arm, name, seed = ARMS[case["arm"]], WORLD, case["seed"]
    policies: Any = {"copepod": "untrained"}
    if arm.get("krill") == "reflex":
        name, held = "diel-migration", {k: v for k, v in HELD.items() if "max" not in k}
    else:
        held = HELD
        folder = str(
            policies_of(
                {"world": WORLD, "short training": config["training_ticks"]},
                {"set": config["set"]},
                case["training"],
            )
        )
        policies = (
            folder
            if "learn" in arm
            else policies | {"krill": folder if arm["krill"] == "learned" else "untrained"}
        )
    if "learn" in arm:
        return life(
            World.from_config(load(name, config["set"]), seed=seed, policies=policies, learn=arm["learn"]),
            config["days"],
        )
    seed += 1000 * case["training"]  # the world seed determines the untrained networks
    return hunts(
        World.from_config(
            load(name, config["set"] | held), seed=seed, policies=policies, learn=False, training=True
        ),
        config["days of hunting"],
    )


def hunts(world: Any, days: int) -> dict[str, Any]:
    """Return the krill's catch and energy use per day, and how often they swim fast with and without a
    copepod in sight."""
    from ecs_eco.components import Nervous
    from ecs_eco.nervous.thoughts import thinkers

    krill, day = world.tables["krill"], round(world.config.sun.day / world.dt)
    nerves = krill.species.nerves
    near, fast = list(nerves.channels).index("copepod_near"), nerves.actions.index(("speed", "chase"))
    chases, ticks = np.zeros(2), np.zeros(2)
    for _ in range(days * day):
        world.step()
        rows, at = thinkers(krill)
        sees, chasing = nerves.x[at, near] > 0, krill[Nervous].decision[rows, fast] > 0
        for seen in (0, 1):
            chases[seen] += chasing[sees == seen].sum()
            ticks[seen] += (sees == seen).sum()
    from ecs_eco.analysis.runs import load_series

    series = load_series(world.series())
    caught, per = float(series.of("copepod", "died: eaten by krill").sum()), float(krill.n * days)
    share = chases / np.maximum(ticks, 1)
    return {
        "caught": caught / per,
        "burnt": float(series.of("krill", "burnt").sum()) / per,
        "chase, sees none": share[0],
        "chase, sees one": share[1],
    }


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return verdicts on hunting and migration, and a table of krill behavior."""
    there = {c["case"]["arm"] for c in cases}
    out = []
    words = {
        "caught": "catches per krill per day",
        "per energy": "catches per unit of energy burned",
        "choice": "share of ticks spent chasing, with a copepod in sight minus without",
    }
    of = {
        "caught": lambda r: r["caught"],
        "per energy": lambda r: r["caught"] / r["burnt"] if r["burnt"] else None,
        "choice": lambda r: r["chase, sees one"] - r["chase, sees none"],
    }
    if {"hunt: learned", "hunt: untrained"} <= there:
        for key, value in of.items():
            learned, untrained = (
                by_training(cases, arm, value) for arm in ("hunt: learned", "hunt: untrained")
            )
            gap, _ = contrast(learned, untrained)
            means = f"{np.mean(learned):.3f} and {np.mean(untrained):.3f}: {in_words(gap, len(learned))}"
            out.append(verdict(f"{words[key]}, learned minus untrained (95%)", means, "above 0", gap[1] > 0))
    for arm in ("life", "life: both go on learning"):
        cycles = [c["result"]["cycle"] for c in cases if c["case"]["arm"] == arm]
        if cycles:
            n = len(cycles)
            amplitude = float(np.median([0.0 if c is None else c["amplitude"] for c in cycles]))
            steady = sum(c is not None and c["r"] is not None and c["r"] >= 0.6 for c in cycles)
            deeper = sum(c is not None and c["vector"][0] > 0 for c in cycles)
            each = by_training(cases, arm, swing)
            along = interval(each) if each else [float("nan")] * 3
            out += [
                verdict(
                    f"{arm}: amplitude of copepods in phase with daylight (95%)",
                    in_words(along, len(each)),
                    "above 0",
                    along[1] > 0,
                )
                if each
                else none(arm),
                verdict(
                    f"{arm}: amplitude, median of runs",
                    round(amplitude, 3),
                    "at least 0.25",
                    amplitude >= 0.25,
                ),
                verdict(
                    f"{arm}: runs in which copepods are deeper by day", f"{deeper} of {n}", "all", deeper == n
                ),
                verdict(
                    f"{arm}: runs in which mean depth correlates with light by at least 0.6",
                    f"{steady} of {n}",
                    "at least 90%",
                    steady >= 0.9 * n,
                ),
            ]
    rows = [
        [
            arm,
            *(
                in_words(interval(v), len(v))
                for v in (
                    by_training(cases, arm, lambda r, k=k: r[k])
                    for k in ("caught", "burnt", "chase, sees one", "chase, sees none")
                )
            ),
        ]
        for arm in ARMS
        if arm in there and "krill" in ARMS[arm]
    ]
    head = [
        "arm",
        "catches per krill per day (95%)",
        "energy burned per krill per day",
        "share of ticks spent chasing, with a copepod in sight",
        "share without a copepod in sight",
    ]
    return {"verdicts": out, "table": {"head": head, "rows": rows}}


def depends(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Return the configuration entries that a case depends on: its arm and both worlds."""
    from ecs_eco.config import load

    return {
        "arm": ARMS[case["arm"]],
        "worlds": [load(w).config_hash for w in (WORLD, "diel-migration")],
        **config,
    }


STUDY = Study(
    name="learning_krill",
    claim="Krill learn to chase what they see while copepods learn to hide, and copepods migrate among "
    "them, whether policies are frozen or continue to learn.",
    config={"set": {}, "days": 20, "days of hunting": 3, "training_ticks": None},
    cases=[{"arm": arm, "training": t, "seed": s} for s in SEEDS for arm in ARMS for t in TRAINING_SEEDS],
    run=run,
    summarise=summarise,
    depends=depends,
    short_cases=[{"arm": arm, "training": 1, "seed": 301} for arm in ARMS],
    short_config={
        "days": 2,
        "days of hunting": 1,
        "training_ticks": 20,
        "set": {
            "sun.day": 60.0,
            "species.copepod.count": 40,
            "species.phytoplankton.count": 200,
            "species.copepod.ppo.horizon": 10,
        },
    },
)

if __name__ == "__main__":
    STUDY.main()
