"""Does memory remain intact whatever numbers a world contains? Every kernel runs with bounds checks.

In a small version of each world, some numbers are replaced by extreme values (NaN, infinities, denormals,
1e38, −0, positions far outside the world, unknown codes, equal and descending rows): in columns between
ticks, in spawned organisms, by a system within a tick, behind the validation gate, and in sealed checkpoints.
The world then runs for 2 ticks, and kernels that ticks never call are called with its numbers. Compiled with
NUMBA_BOUNDSCHECK=1, a kernel raises an error before it accesses memory outside an array.
"""

import os
from typing import Any

if __name__ == "__main__":
    os.environ["NUMBA_BOUNDSCHECK"] = "1"  # before kernels are compiled; worker processes inherit it

from studies.common import kernels, wild
from studies.common.study import Study, verdict

WORLDS = (
    "predator-prey",
    "reflexes",
    "lamb",
    "happiness",
    "learning-krill",
    "diel-migration",
    "menagerie",
    "herd",
    "flock",
    "choosy-flock",
)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Test one chunk of states."""
    import numba

    if not numba.config.BOUNDSCHECK:  # type: ignore[attr-defined]
        raise RuntimeError("the kernels of this process have no bounds checks: set NUMBA_BOUNDSCHECK=1")
    return wild.tried(dict(case), config["states"])


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Count the outcomes, by the path that the numbers took."""
    total: dict[str, dict[str, int]] = {way: {} for way in wild.WAYS}
    for case in cases:
        for way, kinds in case["result"]["kinds"].items():
            for kind, n in kinds.items():
                total[way][kind] = total[way].get(kind, 0) + n
    kinds = sorted(
        {kind for counts in total.values() for kind in counts}, key=lambda kind: (kind in wild.FAILURES, kind)
    )
    states = sum(case["result"]["states"] for case in cases)

    def of(*names: str, ways: tuple[str, ...] = wild.WAYS) -> int:
        return sum(total[way].get(name, 0) for way in ways for name in names)

    missed = sorted(set(kernels.kernels()).difference(*(case["result"]["kernels"] for case in cases)))
    gates, least = ("columns", "spawn", "checkpoint"), 10_000 if len(cases) > 10 else 1
    return {
        "verdicts": [
            verdict("wild states under bounds checks", states, f"≥ {least:,}", states >= least),
            verdict(
                "processes that crashed or did not respond",
                of("crash", "hang"),
                "0",
                of("crash", "hang") == 0,
            ),
            verdict(
                "kernels that would have accessed memory outside an array",
                of("out of bounds"),
                "0",
                of("out of bounds") == 0,
            ),
            verdict(
                f"kernels of {len(kernels.kernels())} that did not run",
                missed,
                "none",
                not missed or len(cases) <= 10,
            ),
            verdict(
                "states refused at the gate without naming organism or file, field and limits, or stopped "
                "by another error",
                of("refused without a location", "traceback", ways=gates),
                "0",
                of("refused without a location", "traceback", ways=gates) == 0,
            ),
            verdict(
                "errors of an unknown kind, behind the gate",
                of("traceback", ways=("within a tick",)),
                "0",
                of("traceback", ways=("within a tick",)) == 0,
            ),
        ],
        "table": {
            "head": ["outcome", *wild.WAYS],
            "rows": [[kind, *(total[way].get(kind, 0) for way in wild.WAYS)] for kind in kinds],
        },
    }


STUDY = Study(
    name="wild_states",
    claim="Whatever its values, a world is refused or runs: no kernel accesses memory outside its arrays.",
    config={"states": 200},
    cases=[{"source": source, "seed": seed} for source in WORLDS for seed in range(1, 6)],
    run=run,
    summarise=summarise,
    short_cases=[{"source": source, "seed": 1} for source in ("herd", "menagerie")],
    short_config={"states": 40},
)

if __name__ == "__main__":
    STUDY.main()
