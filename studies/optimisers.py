"""Which optimizer finds a food chain that persists?

The test uses a numerical food chain, which is thousands of times cheaper than a world: the three-level chain
of Rosenzweig and MacArthur (1963) with demographic noise. As in `ecs-eco search`, a run stops at an
extinction, and poor candidates are dropped after a short first stage; scores are therefore discontinuous and
differ between seeds. Eight parameters each vary by a factor of thirty; about one random chain in thirty
persists. An optimizer's best candidate is evaluated in 200 fresh runs.
"""

from typing import Any

import numpy as np

from ecs_eco.compiled.jit import njit
from studies.common.study import Study, verdict

# ruff: noqa: NPY002 (numba supports this generator, and each run seeds it)

NAMES = ("regrowth", "grazing", "handling", "yield", "hunting", "satiation", "gain", "mortality")
CENTRE = (0.04, 1.5e-4, 6.0, 0.15, 4e-4, 3.0, 0.12, 0.012)
STAGES, RUNS, KEPT = ((1000, 1), (2000, 2), (4000, 6)), 6, 0.4


@njit
def live(p, ticks, seed):
    """Return the number of ticks until a level goes extinct, and the smallest population reached, as a share
    of its level's mean."""
    np.random.seed(seed)
    g, d, w = 3000, 500, 60
    low, total = np.array([g, d, w]), np.zeros(3)
    for t in range(ticks):
        grazed = p[1] * g / (1 + p[1] * p[2] * g)
        caught = p[4] * d / (1 + p[4] * p[5] * d)
        eaten = min(g, np.random.poisson(grazed * d))
        killed = min(d, np.random.poisson(caught * w))
        g += np.random.poisson(max(0.0, p[0] * g * (1 - g / 5000) + 0.0004 * (5000 - g))) - eaten
        d += np.random.poisson(p[3] * eaten) - killed - np.random.binomial(d, 0.004)
        w += np.random.poisson(p[6] * killed) - np.random.binomial(w, p[7])
        g, d, w = max(g, 0), max(d, 0), max(w, 0)
        if d == 0 or w == 0:
            return t, 0.0
        for i, n in enumerate((g, d, w)):
            low[i], total[i] = min(low[i], n), total[i] + n
    worst = 1.0
    for i in range(1, 3):
        worst = min(worst, np.log(1 + low[i]) / np.log(1 + total[i] / ticks))
    return ticks, worst


def parameters() -> Any:
    from ecs_eco.lab.searching.plan import Parameter

    return [
        Parameter(n, c / 30**0.5, c * 30**0.5, log=True, whole=False, start=c)
        for n, c in zip(NAMES, CENTRE, strict=True)
    ]


def evaluate(values: dict[str, float], least: list[float]) -> dict[str, Any]:
    """Evaluate a candidate like ecs_eco.lab.searching.evaluate, with the chain instead of a world."""
    p, spent, scores = np.array([values[n] for n in NAMES]), 0, []
    for stage, (ticks, n) in enumerate(STAGES):
        runs = [live(p, ticks, seed) for seed in range(n)]
        spent += sum(t for t, _ in runs)
        scores.append(float(np.mean([t / ticks + rest for t, rest in runs])))
        lost = sum(t < ticks for t, _ in runs)
        if lost > 0.5 * n or (stage < len(least) and scores[-1] < least[stage]):
            break
    return {"stage": len(scores) - 1, "score": scores[-1], "scores": scores, "ticks": spent}


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Search for a chain with one optimizer; return the quality of its best candidate after different numbers
    of candidates."""
    import time

    from ecs_eco.lab.searching.optimise import Optimiser, merit

    optimiser, entries, asking, out = (
        Optimiser(parameters(), case["optimiser"], case["seed"]),
        [],
        0.0,
        {"share": {}, "merit": {}},
    )
    for candidate in range(config["candidates"]):
        begin = time.perf_counter()
        values = optimiser.ask(candidate)
        asking += time.perf_counter() - begin
        before = [[e["scores"][s] for e in entries if e["stage"] >= s] for s in range(len(STAGES) - 1)]
        entry = evaluate(
            values, [float(np.quantile(b, 1 - KEPT)) if len(b) >= 4 else -np.inf for b in before]
        ) | {"values": values}
        entries.append(entry)
        optimiser.tell(candidate, values, merit(entry))
        if candidate + 1 in config["judged"]:
            best = max(entries, key=merit)
            p = np.array([best["values"][n] for n in NAMES])
            out["share"][str(candidate + 1)] = float(
                np.mean([live(p, 8000, 10_000 + s)[0] == 8000 for s in range(config["runs"])])
            )
            out["merit"][str(candidate + 1)] = merit(best)
    return out | {
        "ticks": sum(e["ticks"] for e in entries),
        "asking": asking / config["candidates"],
        "whole": sum(e["stage"] == len(STAGES) - 1 for e in entries),
    }


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the share of chains that persist, by optimizer and number of candidates."""
    kinds = list(dict.fromkeys(c["case"]["optimiser"] for c in cases))
    of = {k: [c["result"] for c in cases if c["case"]["optimiser"] == k] for k in kinds}
    judged = list(of[kinds[0]][0]["share"])
    mean = {
        k: [float(np.mean([r["share"][n] for r in results])) for n in judged] for k, results in of.items()
    }
    rows = [
        [
            k,
            len(of[k]),
            *(f"{m:.2f}" for m in mean[k]),
            f"{np.mean([r['ticks'] for r in of[k]]) / 1e3:,.0f}",
            f"{np.mean([r['whole'] for r in of[k]]):.1f}",
            f"{1000 * np.mean([r['asking'] for r in of[k]]):.0f}",
        ]
        for k in kinds
    ]
    head = [
        "optimizer",
        "repeats",
        *(f"share that persists, best of {n}" for n in judged),
        "ticks [1,000]",
        "candidates run on all seeds",
        "ms per suggestion",
    ]
    lines = []
    for k in [k for k in kinds if k != "random"]:
        pairs = [
            (a["share"][n], b["share"][n])
            for a, b in zip(of[k], of["random"], strict=True)
            for n in judged[1:] or judged
        ]
        won, lost = sum(a > b for a, b in pairs), sum(a < b for a, b in pairs)
        value = (
            f"{mean[k][-1]:.2f} against {mean['random'][-1]:.2f}; better in {won}, "
            f"worse in {lost} of {len(pairs)} pairs"
        )
        lines.append(
            verdict(
                f"share of chains that persist, best of {judged[-1]}: {k} against random",
                value,
                "better",
                mean[k][-1] > mean["random"][-1],
            )
        )
    return {"verdicts": lines, "table": {"head": head, "rows": rows}}


STUDY = Study(
    name="optimisers",
    claim="Every optimizer finds food chains that persist with fewer candidates than random search.",
    config={"candidates": 80, "judged": [20, 40, 80], "runs": 200},
    cases=[{"optimiser": k, "seed": s} for s in range(1, 9) for k in ("tpe", "gp", "cmaes", "random")],
    run=run,
    summarise=summarise,
    short_cases=[{"optimiser": k, "seed": 1} for k in ("tpe", "random")],
    short_config={"candidates": 12, "judged": [12], "runs": 20},
)

if __name__ == "__main__":
    STUDY.main()
