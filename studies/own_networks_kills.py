"""Does a run with torch modules as brains end with the same bytes after being killed repeatedly?"""

from typing import Any

from studies import kills
from studies.common.study import Study, verdict

NETWORKS = ("ByAutograd", "Remembering")


def summarise(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Count kills, and runs that ended differently."""
    results = [c["result"] for c in cases]
    n, wrong = sum(r["kills"] for r in results), sum(not r["same"] for r in results)
    left = sum(r["left behind"] for r in results)
    return [
        verdict("kills (SIGKILL) after which the run continued", n, "20 or more", n >= 20),
        verdict(
            "runs whose world or recording differs from an uninterrupted run",
            f"{wrong} of {len(results)}",
            "0",
            wrong == 0,
        ),
        verdict("half-written files left behind at the end", left, "0", left == 0),
    ]


STUDY = Study(
    name="own_networks_kills",
    claim="A run with torch modules, shared or individual, with or without memory, can be killed at any "
    "moment and resumed, and ends with the same bytes.",
    config={"ticks": 60, "checkpoint_every": 1, "share": 0.02, "kills": 6, "longest": 4.0},
    cases=[
        {
            "world": "predator-prey",
            "brains": brains,
            "network": f"studies.common.networks:{network}",
            "seed": 31 + 2 * i + j,
        }
        for i, brains in enumerate(("shared", "individual"))
        for j, network in enumerate(NETWORKS)
    ],
    run=kills.run,
    summarise=summarise,
    short_config={"ticks": 20, "kills": 1, "longest": 1.0},
    short_cases=[
        {
            "world": "predator-prey",
            "brains": "shared",
            "network": "studies.common.networks:Remembering",
            "seed": 31,
        }
    ],
)

if __name__ == "__main__":
    STUDY.main()
