"""Does `ecs-eco why` identify the change made to a world?

The study stages five kinds of disaster, as well as healthy worlds, each many times at random. A world's label
is the change made to it (studies/common/disasters.py). A world is redrawn if the intended event did not
happen: the target species of a disaster survived, or an animal species in a healthy world fell below 5
individuals. The limits in ecs_eco.analysis.why were chosen on variants with different seeds (1000 to 1007 and
2000 to 2007), and finally gave the right answer for all of them; test seeds were examined only after the
limits were fixed.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

from studies.common.disasters import CLASSES, web
from studies.common.study import Study, verdict

TEST = 50_000
DRAWS = 20  # maximum number of worlds drawn until the intended event happened


def staged(label: str, seed: int, ticks: int, out: Path) -> tuple[Any, dict[str, Any], int]:
    """Record the first world with this label and seed in which the intended event happened; return the case,
    its draws, and its number."""
    from ecs_eco.analysis.why import Case
    from ecs_eco.config import load
    from ecs_eco.record import run_to_folder

    for draw in range(DRAWS):
        number = 100 * seed + draw
        config, drawn = web(number, label)
        folder = out / str(draw)
        run_to_folder(
            load(config), number, ticks, folder, "random", report=False, snapshot_every=max(1, ticks // 50)
        )
        case = Case.read(folder)
        least = {
            s: int(n.min()) for s, n in zip(case.species, case.series.n.T, strict=True) if case.is_animal(s)
        }
        if min(least.values()) >= 5 if label == "healthy" else least[drawn["who"]] == 0:
            return case, drawn | {"lost": [s for s, n in least.items() if n == 0]}, draw
    raise RuntimeError(f"{label} did not happen in {DRAWS} worlds of seed {seed}")


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Stage one variant and have `why` explain it."""
    from ecs_eco.analysis.why import diagnose

    with tempfile.TemporaryDirectory(prefix="ecs-eco-why-") as folder:
        recorded, drawn, draw = staged(case["label"], case["seed"], config["ticks"], Path(folder))
    diagnosis = diagnose(recorded)
    return {
        "said": diagnosis["verdict"],
        "of": diagnosis["species"],
        "confidence": diagnosis["confidence"],
        "runner_up": diagnosis["runner_up"],
        "drawn": drawn,
        "draws": draw + 1,
    }


def confusion(cases: list[dict[str, Any]], which: str) -> tuple[list[list[Any]], int, int]:
    """Return the confusion matrix rows for one set of variants, the number of right answers, and the number
    of variants."""
    used = [c for c in cases if c["case"]["set"] == which]
    heard = list(dict.fromkeys([*CLASSES, *(c["result"]["said"] for c in used)]))
    rows = []
    for label in CLASSES:
        count = Counter(c["result"]["said"] for c in used if c["case"]["label"] == label)
        rows.append(
            [
                which,
                label,
                *(count.get(v, 0) for v in CLASSES),
                sum(count.get(v, 0) for v in heard[len(CLASSES) :]),
            ]
        )
    return rows, sum(c["result"]["said"] == c["case"]["label"] for c in used), len(used)


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return each set's confusion matrix and share of right answers."""
    from ecs_eco.analysis.survival import wilson

    rows, out = [], []
    for which in dict.fromkeys(c["case"]["set"] for c in cases):
        lines, right, total = confusion(cases, which)
        rows += lines
        share, low, high = wilson(right, total)
        share_in_words = f"{right} of {total} ({share:.0%}, {low:.0%} … {high:.0%})"
        out.append(
            verdict(
                f"verdicts that name the staged cause, {which} variants",
                share_in_words,
                "≥ 80%",
                share >= 0.8,
            )
        )
        used = [c for c in cases if c["case"]["set"] == which]
        named = sum(
            c["case"]["label"] in (c["result"]["said"], (c["result"]["runner_up"] or {}).get("verdict"))
            for c in used
        )
        out.append(
            verdict(
                f"verdicts or runners-up that name it, {which} variants",
                f"{named} of {total}",
                "≥ 80%",
                named >= 0.8 * total,
            )
        )
    drawn = [c["result"]["draws"] for c in cases]
    out.append(
        verdict(
            "mean number of worlds drawn until the staged cause occurred",
            f"{sum(drawn) / len(drawn):.2f}",
            "reported",
            True,
        )
    )
    return {
        "verdicts": out,
        "table": {
            "head": ["variants", "staged", *(f"verdict: {c}" for c in CLASSES), "another verdict"],
            "rows": rows,
        },
    }


CASES = [{"set": "test", "label": label, "seed": TEST + i} for label in CLASSES for i in range(10)]
STUDY = Study(
    name="why",
    claim="`ecs-eco why` names the cause that was staged in a world.",
    config={"ticks": 1000},
    cases=CASES,
    run=run,
    summarise=summarise,
    short_cases=[{"set": "test", "label": label, "seed": TEST + 10} for label in CLASSES],
)

if __name__ == "__main__":
    STUDY.main()
