"""From a world that dies on nearly every seed to one that lives: `ecs-eco search`, and the same with candidates at random.

Both have the same time, ranges, stages and seeds; each candidate trains its own policies. What counts is the share of runs in which
all species persist on training seeds and world seeds that no search ever saw. Searches leave their folders in the temporary
folder, and go on from there when the study is stopped.
"""

import hashlib
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from _study import Study, canonical, verdict

WORLD = Path(__file__).parent.parent / "examples" / "dying_world.toml"


def folder(config: dict[str, Any], case: dict[str, Any]) -> Path:
    """Where a search leaves what it found."""
    name = hashlib.sha256(canonical(config).encode()).hexdigest()[:12]
    return Path(tempfile.gettempdir()) / f"ecs-eco-search-{name}" / f"{case['optimiser']}-{case['seed']}"


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """One search; return what it found, and the load of the machine."""
    from ecs_eco.search import search

    before = os.getloadavg()[0]
    found = search(WORLD, folder(config, case), {**config["changes"], "search.seed": case["seed"]}, budget=config["minutes"],
                   trials=config["trials"], workers=config["workers"], optimiser=case["optimiser"], report=config["trials"] is None)  # fmt: skip
    kept = ("candidates", "by_stage", "seconds", "seconds_of_candidates", "start", "best", "best_so_far", "confirmation", "matters")
    return {k: found[k] for k in kept} | {"load": [before, os.getloadavg()[0]]}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Shares that persist, by optimiser, over all repeats."""
    from ecs_eco.analysis.survival import wilson

    kinds = list(dict.fromkeys(c["case"]["optimiser"] for c in cases))
    of = {k: [c["result"] for c in cases if c["case"]["optimiser"] == k] for k in kinds}

    def share(found: list[dict[str, Any]], who: str) -> tuple[int, int]:
        return sum(r["confirmation"][who]["persisted"] for r in found), sum(r["confirmation"][who]["runs"] for r in found)

    rows = []
    for k, found in of.items():
        for r, seed in zip(found, [c["case"]["seed"] for c in cases if c["case"]["optimiser"] == k], strict=True):
            c, s = r["confirmation"]["best"], r["confirmation"]["start"]
            rows.append([k, seed, r["candidates"], *r["by_stage"][1:], f"{r['seconds_of_candidates'] / 60:.1f}", f"{r['seconds'] / 60:.1f}",
                         f"{r['best'][0]['score']:.2f}", f"{s['persisted']} of {s['runs']}", f"{c['persisted']} of {c['runs']}",
                         f"{c['low']:.2f} … {c['high']:.2f}", f"{r['load'][0]:.0f}–{r['load'][1]:.0f}"])  # fmt: skip
    head = ["optimiser", "seed", "candidates", "at stage 2", "met all runs", "minutes of candidates", "minutes in all", "score of the best",
            "as written: all persist", "best: all persist", "95 %", "load"]  # fmt: skip
    k, n = share(of["tpe"], "best")
    k0, n0 = share(cases_of(cases), "start")
    low, high = wilson(k, n)[1:]
    longest = max(r["seconds"] for r in of["tpe"]) / 60
    lines = [verdict("as written: share of runs in which all persist", f"{k0} of {n0}", "below 0.1", k0 < 0.1 * n0),
             verdict("tpe: share of runs on fresh seeds in which all persist", f"{k} of {n} ({low:.2f} … {high:.2f})", "at least 0.8", k >= 0.8 * n),
             verdict("tpe: minutes from the first candidate to the end of the confirmation", f"{longest:.1f}", "under 30", longest < 30)]
    if "random" in of:
        r, m = share(of["random"], "best")
        lines.append(verdict("the same by chance", f"{r} of {m}", "less than tpe", r / m < k / n))
    return {"verdicts": lines, "table": {"head": head, "rows": rows}}


def cases_of(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The results alone."""
    return [c["result"] for c in cases]


STUDY = Study(
    name="search", claim="A search makes of a world that dies on nearly every seed one that lives, and is sooner there than chance.",
    config={"world": hashlib.sha256(WORLD.read_bytes()).hexdigest()[:16], "minutes": 16.0, "workers": 1, "trials": None, "changes": {}},
    cases=[{"optimiser": k, "seed": 1} for k in ("tpe", "random")], run=run, summarise=summarise,
    short_cases=[{"optimiser": k, "seed": 1} for k in ("tpe", "random")],
    short_config={"minutes": None, "trials": 2, "changes": {"search.ticks": 50, "search.training_ticks": 8, "search.training_seeds": 1,
                  "search.confirm": {"world_seeds": 1, "training_seeds": 1, "ticks": 50}}},
)  # fmt: skip

if __name__ == "__main__":
    STUDY.main()
