"""Does a run of a + b ticks give the same bytes as a run of a ticks that a new process resumes for b ticks,
for every shipped world?"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.runs import small, summary
from studies.common.study import Study, verdict

AGAIN = (
    "import sys\nfrom ecs_eco.record import resume\n"
    "resume(sys.argv[1], int(sys.argv[2]), threads=int(sys.argv[3]), report=False)\n"
)
WORLDS = [
    (world, brains)
    for world in ("predator-prey", "reflexes", "lamb", "happiness")
    for brains in ("shared", "individual")
]


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one world without interruption, then once for each split point, where a new process runs the second
    part; compare all results."""
    from ecs_eco.record import run_to_folder

    world = small(case["world"], config["share"], case["brains"])
    ticks = config["ticks"]
    splits = np.random.default_rng(case["seed"]).integers(1, ticks, config["splits"]).tolist()

    def go(out: Path, until: int, threads: int) -> None:
        run_to_folder(
            world,
            seed=case["seed"],
            ticks=until,
            out=out,
            policies="untrained",
            learn=True,
            threads=threads,
            snapshot_every=10,
            report=False,
        )

    with tempfile.TemporaryDirectory() as place:
        go(Path(place) / "whole", ticks, 1)
        whole, other = summary(Path(place) / "whole"), []
        for i, split in enumerate(splits):
            out, threads = Path(place) / f"{i}", 1 + i % 2
            go(out, split, 1 + (i // 2) % 2)
            subprocess.run([sys.executable, "-c", AGAIN, str(out), str(ticks), str(threads)], check=True)
            if summary(out) != whole:
                other.append(split)
        learnt = json.loads((Path(place) / "whole" / "manifest.json").read_text(encoding="utf-8"))["done"]
    return {"splits": splits, "different": other, "digest": whole["world"], "ticks": learnt}


def summarise(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Count the split points after which any result differs."""
    tried = sum(len(c["result"]["splits"]) for c in cases)
    wrong = sum(len(c["result"]["different"]) for c in cases)
    fewest = min(len(c["result"]["splits"]) for c in cases)
    names = ", ".join(f"{c['case']['world']} ({c['case']['brains']})" for c in cases)
    return [
        verdict(
            f"split points that change a bit in columns, weights, optimizers or the recording: {names}",
            f"{wrong} of {tried}",
            "0",
            wrong == 0,
        ),
        verdict(
            "split points tried for each world, in a new process, with 1 and 2 threads",
            fewest,
            "20 or more",
            fewest >= 20,
        ),
    ]


STUDY = Study(
    name="resume",
    claim="A run that is stopped, saved and resumed in a new process gives the same bytes as an "
    "uninterrupted run.",
    config={"ticks": 120, "splits": 20, "share": 0.2},
    cases=[{"world": world, "brains": brains, "seed": 11 + i} for i, (world, brains) in enumerate(WORLDS)],
    run=run,
    summarise=summarise,
    short_config={"ticks": 40, "splits": 1, "share": 0.1},
    short_cases=[
        {"world": "predator-prey", "brains": "shared", "seed": 11},
        {"world": "reflexes", "brains": "individual", "seed": 12},
    ],
)

if __name__ == "__main__":
    STUDY.main()
