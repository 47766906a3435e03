"""Which policies are bundled with the predator-prey world: chosen openly among four training seeds.

The rule, fixed before any of them was judged: most runs in which all persist; then most spectral peaks of deer and wolf
beyond AR(1); then the strongest peaks (lowest summed log p against red noise that relaxes, then highest ratio).
The world seeds judged on here are used by no other study. `python studies/select_policies.py --bundle` also copies the winner.
"""

import shutil
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from _predator_prey import SHIPPED, first_extinction, identity, live, numbers, trained
from _study import RESULTS, Study, verdict

TRAINING, WORLDS = (1, 2, 3, 4), (11, 12)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train a seed and judge its policies on one world."""
    from ecs_eco.analysis.cycles import cycle_statistics
    from ecs_eco.config import load

    world = load(config["world"])
    n = numbers(lived := live(world, case["seed"], str(trained(world, case["training"], config["training_ticks"])), config["ticks"]))
    when, who = first_extinction(n)
    cycles = cycle_statistics(lived.series())
    return {"lived": when, "extinct": who, "mean": n.mean(0).round(), "cycles": cycles.as_dict()}


def score(results: list[dict[str, Any]]) -> tuple[int, int, float, float]:
    """The rule, larger is better."""
    peaks = [r["cycles"]["peaks"][s] for r in results for s in ("deer", "wolf") if r["cycles"]["peaks"].get(s)]
    lenient = [r["cycles"]["p_ar1"].get(s) for r in results for s in ("deer", "wolf")]
    return (sum(r["extinct"] is None for r in results), sum(p is not None and p < 0.05 for p in lenient),
            -sum(float(np.log(p["p"])) for p in peaks), sum(p["ratio"] for p in peaks))  # fmt: skip


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Rank the training seeds."""
    by_seed: dict[int, list[dict[str, Any]]] = {}
    for entry in cases:
        by_seed.setdefault(entry["case"]["training"], []).append(entry["result"])
    ranked = sorted(by_seed, key=lambda s: score(by_seed[s]), reverse=True)
    rows = [[s, f"{score(by_seed[s])[0]} of {len(by_seed[s])}", f"{score(by_seed[s])[1]} of {2 * len(by_seed[s])}",
             score(by_seed[s])[2]] for s in ranked]  # fmt: skip
    kept = sum(score(r)[0] for r in by_seed.values())
    return {
        "winner": ranked[0],
        "table": {"head": ["training seed", "all persist", "peaks beyond AR(1)", "−Σ log p"], "rows": rows},
        "verdicts": [verdict("training seeds tried before one was bundled", len(ranked), "at most 8", len(ranked) <= 8),
                     verdict("runs over all of them in which grass, deer and wolves persist", f"{kept} of {len(cases)}", "all",
                             kept == len(cases))],
    }  # fmt: skip


STUDY = Study(
    name="select_policies", claim="The bundled predator-prey policies are chosen by a declared rule among four training seeds.",
    config={"world": "predator-prey", "identity": identity(policies=False), "ticks": 10_000, "training_ticks": None},
    cases=[{"training": t, "seed": w} for t in TRAINING for w in WORLDS], run=run, summarise=summarise,
    short_cases=[{"training": 1, "seed": 11}], short_config={"ticks": 1200, "training_ticks": 300},
)  # fmt: skip


def bundle() -> None:
    """Copy the winner's policies to the world's folder."""
    import json

    from ecs_eco.config import load

    winner = json.loads((RESULTS / "select_policies.json").read_text())["winner"]
    for name in ("deer", "wolf"):
        shutil.copy(trained(load("predator-prey"), winner) / f"{name}.safetensors", SHIPPED)
    print(f"bundled training seed {winner} in {SHIPPED}")


if __name__ == "__main__":
    if "--bundle" in sys.argv:
        bundle()
    else:
        STUDY.main()
