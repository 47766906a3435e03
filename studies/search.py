"""Does `ecs-eco search` turn a world that goes extinct on nearly every seed into one that persists, and is it
better than random candidates?

Both methods have the same processor time (ten minutes for candidates, or five on two otherwise idle cores),
ranges, stages and seeds; each candidate trains its own policies. The measure is the share of runs in which
all species persist on fresh training seeds and world seeds. The searches were extended once, with 12
finalists instead of 3, after the best of 3 had persisted in 12 and 7 of 12 runs (Gaussian process) and in 11
and 12 (random). Searches keep their files in the temporary folder and resume from there if the study is
interrupted.
"""

import hashlib
import os
import tempfile
from pathlib import Path
from typing import Any

from studies.common.study import Study, canonical, verdict

WORLD = Path(__file__).parent.parent / "examples" / "dying_world.toml"


def identity() -> str:
    """Return the file's hash at the time of the study, because the world's keys were renamed later."""
    from ecs_eco.config import load

    same = load(WORLD).config_hash.startswith("450e51ddfa8a4f0b")
    return "2c8618f2eaf9f715" if same else hashlib.sha256(WORLD.read_bytes()).hexdigest()[:16]


def folder(config: dict[str, Any], case: dict[str, Any]) -> Path:
    """Return a search's folder; a search resumes only in the same world."""
    from ecs_eco.config import load

    asked = canonical(config) + load(WORLD).config_hash
    name = hashlib.sha256(asked.encode()).hexdigest()[:12]
    return Path(tempfile.gettempdir()) / f"ecs-eco-search-{name}" / f"{case['optimiser']}-{case['seed']}"


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one search; return its result and the machine's load."""
    from ecs_eco.lab import search

    before = os.getloadavg()[0]
    result = search(
        WORLD,
        folder(config, case),
        {**config["changes"], "search.seed": case["seed"]},
        cpu=config["cpu"],
        trials=config["trials"],
        workers=config["workers"],
        optimiser=case["optimiser"],
        report=config["trials"] is None,
    )
    kept = (
        "candidates",
        "by_stage",
        "seconds",
        "seconds_of_candidates",
        "cpu_of_candidates",
        "start",
        "best",
        "best_so_far",
        "confirmation",
        "importance",
    )
    return {k: result[k] for k in kept} | {"load": [before, os.getloadavg()[0]]}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the shares of runs that persist, by optimizer, over all repeats."""
    from ecs_eco.analysis.survival import wilson

    kinds = list(dict.fromkeys(c["case"]["optimiser"] for c in cases))
    of = {k: [c["result"] for c in cases if c["case"]["optimiser"] == k] for k in kinds}

    def share(results: list[dict[str, Any]], who: str) -> tuple[int, int]:
        return (
            sum(r["confirmation"][who]["persisted"] for r in results),
            sum(r["confirmation"][who]["runs"] for r in results),
        )

    rows = []
    for k, results in of.items():
        for r, seed in zip(
            results, [c["case"]["seed"] for c in cases if c["case"]["optimiser"] == k], strict=True
        ):
            c, s = r["confirmation"]["best"], r["confirmation"]["start"]
            rows.append(
                [
                    k,
                    seed,
                    r["candidates"],
                    *r["by_stage"][1:],
                    f"{r['cpu_of_candidates']:,.0f}",
                    f"{r['seconds'] / 60:.1f}",
                    f"{r['best'][0]['score']:.2f}",
                    f"{s['persisted']} of {s['runs']}",
                    f"{c['persisted']} of {c['runs']}",
                    f"{c['low']:.2f} … {c['high']:.2f}",
                    f"{r['load'][0]:.0f}–{r['load'][1]:.0f}",
                ]
            )
    head = [
        "optimizer",
        "seed",
        "candidates",
        "candidates at stage 2",
        "candidates run on all seeds",
        "processor seconds of candidates",
        "total minutes",
        "best score",
        "as written: runs in which all species persist",
        "best: runs in which all species persist",
        "95% interval",
        "load",
    ]
    k, n = share(of["gp"], "best")
    k0, n0 = share([c["result"] for c in cases], "start")
    low, high = wilson(k, n)[1:]
    longest = max(r["seconds"] for r in of["gp"]) / 60
    lines = [
        verdict(
            "as written: share of runs in which all species persist",
            f"{k0} of {n0}",
            "below 0.1",
            k0 < 0.1 * n0,
        ),
        verdict(
            "the search: share of runs on fresh seeds in which all species persist",
            f"{k} of {n} ({low:.2f} … {high:.2f})",
            "at least 0.8",
            k >= 0.8 * n,
        ),
        verdict(
            "the search: minutes from the first candidate to the end of the confirmation",
            f"{longest:.1f}",
            "under 30",
            longest < 30,
        ),
    ]
    if "random" in of:
        r, m = share(of["random"], "best")
        lines.append(
            verdict(
                "the same with random candidates, in the same time",
                f"{r} of {m}",
                "less than the search",
                r / m < k / n,
            )
        )
    return {"verdicts": lines, "table": {"head": head, "rows": rows}}


STUDY = Study(
    name="search",
    claim="A search turns a world that dies on nearly every seed into one that persists.",
    config={"world": identity(), "cpu": 600.0, "workers": 2, "trials": None, "changes": {}},
    cases=[{"optimiser": k, "seed": s} for s in (1, 2) for k in ("gp", "random")],
    run=run,
    summarise=summarise,
    short_cases=[{"optimiser": k, "seed": 1} for k in ("gp", "random")],
    short_config={
        "cpu": None,
        "trials": 2,
        "changes": {
            "search.ticks": 50,
            "search.training_ticks": 8,
            "search.training_seeds": 1,
            "search.confirm": {"world_seeds": 1, "training_seeds": 1, "ticks": 50},
        },
    },
)

if __name__ == "__main__":
    STUDY.main()
