"""Does learning affect how long a world persists?

The study compares trained deer and wolves with random ones, at two costs of running. Mass action alone can
make populations cycle, so only this contrast shows the effect of learned policies. Arms are named deer/wolf;
a world's lifetime is the tick at which deer or wolves first go extinct, censored at the end of the run.
Policies are trained separately for each cost, with the training seed of the bundled policies.
"""

from typing import Any

from studies.common.policies import trained
from studies.common.predator_prey import first_extinction, frozen, identity, live, numbers
from studies.common.study import Study, verdict

LAWS = {
    "dear running": {},
    "cheap running": {
        "species.deer.locomotion.cost": {"still": 0.0, "walk": 0.004, "run": 0.004},
        "species.wolf.locomotion.cost": {"still": 0.0, "walk": 0.004, "run": 0.004},
    },
}
ARMS = ("random/random", "trained/random", "random/trained", "trained/trained")  # deer/wolf
SEEDS = tuple(range(3001, 3009))


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one arm at one cost; return how long both species survived, which species went extinct, and the
    causes of death."""
    from ecs_eco.analysis.cycles import cycle_statistics

    world = frozen(LAWS[case["law"]])
    folder = str(trained(world, config["training_seed"], config["training_ticks"]))
    policies = {
        s: folder if how == "trained" else "random"
        for s, how in zip(("deer", "wolf"), case["arm"].split("/"), strict=True)
    }
    lived = live(world, case["seed"], policies, config["ticks"])
    n = numbers(lived)
    when, who = first_extinction(n)
    series = {
        k: v
        for k, v in lived.series().to_pydict().items()
        if k in ("species", "n", "taken_in") or k.startswith("died: ")
    }
    rows = {s: [i for i, v in enumerate(series["species"]) if v == s] for s in ("deer", "wolf")}
    alive = {s: max(1, sum(series["n"][i] for i in r)) for s, r in rows.items()}
    killed = sum(series["died: eaten by wolf"][i] for i in rows["deer"])
    starved = {s: sum(series["died: starved"][i] for i in r) for s, r in rows.items()}
    cycles = cycle_statistics(lived.series(), n_boot=199)
    return {
        "lived": when,
        "extinct": who,
        "mean": n.mean(0).round(),
        "end": n[-1],
        "deer starved per deer per tick": starved["deer"] / alive["deer"],
        "wolves starved per wolf per tick": starved["wolf"] / alive["wolf"],
        "kills per wolf per tick": killed / alive["wolf"],
        "cycling": list(cycles.cycling()),
        "period": cycles.period,
    }


def lifetimes(cases: list[dict[str, Any]], law: str, arm: str) -> tuple[list[float], list[bool]]:
    """Return lifetimes and whether they ended in an extinction."""
    results = [e["result"] for e in cases if e["case"]["law"] == law and e["case"]["arm"] == arm]
    return [r["lived"] for r in results], [r["extinct"] is not None for r in results]


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return survival curves by arm, and compare every arm with trained/trained."""
    from ecs_eco.analysis.survival import bootstrap_difference, kaplan_meier, log_rank, wilson

    rows, out, curves = [], [], {}
    for law in LAWS:
        whole = lifetimes(cases, law, "trained/trained")
        for arm in ARMS:
            time, died = lifetimes(cases, law, arm)
            if not time:
                continue
            curve = kaplan_meier(time, died)
            curves[f"{law}, {arm}"] = {
                k: getattr(curve, k) for k in ("time", "at_risk", "survival", "low", "high")
            }
            results = [e["result"] for e in cases if e["case"]["law"] == law and e["case"]["arm"] == arm]
            first = [r["extinct"] for r in results]
            kept = wilson(len(died) - sum(died), len(died))
            rows.append(
                [
                    law,
                    arm,
                    len(died),
                    [kept.value, kept.low, kept.high],
                    curve.median,
                    curve.mean(max(time)),
                    f"{first.count('deer')}/{first.count('wolf')}",
                    sum({"deer", "wolf"} <= set(r["cycling"]) for r in results),
                ]
            )
            if arm == "trained/trained" or not whole[0]:
                continue
            gap = bootstrap_difference(whole[0], time)
            p = log_rank(whole, (time, died))[1]
            out.append(
                verdict(
                    f"{law}: mean lifetime of a world with trained/trained minus that with {arm} [ticks] "
                    f"(log-rank p {p:.2g})",
                    [gap.value, gap.low, gap.high],
                    "above 0" if law == "dear running" else "reported",
                    gap.low > 0,
                )
            )
    head = [
        "law",
        "deer/wolf",
        "runs",
        "share that persists",
        "median lifetime",
        "mean lifetime",
        "first to die out: deer/wolves",
        "runs in which both cycle",
    ]
    return {"verdicts": out, "table": {"head": head, "rows": rows}, "curves": curves}


STUDY = Study(
    name="contrast",
    claim="Worlds of trained deer and wolves outlive worlds in which either acts at random.",
    config={
        "world": "predator-prey",
        "identity": identity(policies=False),
        "ticks": 8000,
        "laws": LAWS,
        "training_seed": 1,
        "training_ticks": None,
    },
    cases=[{"law": law, "arm": arm, "seed": s} for law in LAWS for arm in ARMS for s in SEEDS],
    run=run,
    summarise=summarise,
    short_cases=[
        {"law": "dear running", "arm": arm, "seed": 3001} for arm in ("random/random", "trained/trained")
    ],
    short_config={"ticks": 1500, "training_ticks": 300},
)

if __name__ == "__main__":
    STUDY.main()
