"""Bad input: mutated world files, and damaged checkpoints and recordings.

The program must refuse each file with a clear error, or read it without harm. A world file is mutated as text
(bytes flipped; lines cut, duplicated or swapped; text truncated) or in its values (wrong types, extreme
numbers, keys renamed, moved or removed, gene layouts). An accepted world runs 5 ticks with few organisms. A
run's file is truncated, or has bits flipped, or bytes overwritten, lost or inserted; a file that loads must
have its original content.
"""

from typing import Any

from studies.common.study import Study, verdict

WORLDS = ("predator-prey", "reflexes", "lamb", "happiness", "menagerie", "herd")
RECORDED = ("herd", "menagerie", "lamb")
CLEAR = (
    "refused",
    "refused while building",
    "ran 5 ticks",
    "same content",
    "too little memory",
    "non-finite number, reported",
)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Test one chunk of files."""
    from studies.common.fuzz import files, worlds

    module = worlds if case["what"] in ("text", "values") else files
    return module.tried(case, config["files"])


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Count the outcomes of files by kind."""
    kinds = sorted(
        {kind for case in cases for kind in case["result"]["kinds"]},
        key=lambda kind: (kind not in CLEAR, kind),
    )
    ways = ("text", "values", "checkpoint", "recording")
    total = {way: _summed(cases, way, "kinds") for way in ways}
    rows = [[kind, *(total[way].get(kind, 0) for way in ways)] for kind in kinds]
    rows.append(["all", *(sum(total[way].values()) for way in ways)])
    rows += [
        ["problems reported: " + word, *(_summed(cases, way, "problems").get(word, 0) for way in ways)]
        for word in sorted({w for case in cases for w in case["result"]["problems"]})
    ]
    n = dict(zip(ways, rows[len(kinds)][1:], strict=True))
    worlds, files = n["text"] + n["values"], n["checkpoint"] + n["recording"]
    bad = {way: sum(k for kind, k in total[way].items() if kind not in CLEAR) for way in ways}
    wrong = sum(total[way].get("wrong load", 0) for way in ways)
    least = 10_000 if len(cases) > 10 else 1
    return {
        "verdicts": [
            verdict("mutated world files", worlds, f"≥ {least:,}", worlds >= least),
            verdict(
                "of these, files with changed values", n["values"], "at least half", 2 * n["values"] >= worlds
            ),
            verdict(
                "accepted files that ran 5 ticks",
                total["text"].get("ran 5 ticks", 0) + total["values"].get("ran 5 ticks", 0),
                "all accepted files",
                bad["text"] + bad["values"] == 0,
            ),
            verdict(
                "world files that cause a traceback, a hang, a warning or a non-finite number",
                bad["text"] + bad["values"],
                "0",
                bad["text"] + bad["values"] == 0,
            ),
            verdict("damaged checkpoints and recordings", files, f"≥ {least:,}", files >= least),
            verdict(
                "damaged files that cause a traceback, a hang, or an error without the file's name",
                bad["checkpoint"] + bad["recording"] - wrong,
                "0",
                bad["checkpoint"] + bad["recording"] == wrong,
            ),
            verdict("damaged files that load with different content", wrong, "0", wrong == 0),
        ],
        "table": {"head": ["outcome", *ways], "rows": rows},
    }


def _summed(cases: list[dict[str, Any]], way: str, what: str) -> dict[str, int]:
    counts: dict[str, int] = {}
    for case in cases:
        if case["case"]["what"] == way:
            for word, k in case["result"][what].items():
                counts[word] = counts.get(word, 0) + k
    return counts


STUDY = Study(
    name="fuzz",
    claim="Bad input never causes a traceback, a hang or a wrong load: it is refused with a clear error, "
    "or is harmless.",
    config={"files": 250},
    cases=[
        *({"what": "text", "source": world, "seed": seed} for world in WORLDS for seed in range(1, 4)),
        *({"what": "values", "source": world, "seed": seed} for world in WORLDS for seed in range(11, 16)),
        *(
            {"what": what, "source": world, "seed": seed}
            for what in ("checkpoint", "recording")
            for world in RECORDED
            for seed in range(21, 28)
        ),
    ],
    run=run,
    summarise=summarise,
    short_cases=[
        {"what": "text", "source": "herd", "seed": 1},
        {"what": "values", "source": "menagerie", "seed": 11},
        {"what": "checkpoint", "source": "herd", "seed": 21},
        {"what": "recording", "source": "menagerie", "seed": 21},
    ],
    short_config={"files": 40},
)

if __name__ == "__main__":
    STUDY.main()
