"""How often do approximate Bayesian computation intervals contain a world's true parameters?

The study repeats `recovery` with forty worlds instead of ten and with new seeds; the hypotheses are in
registered/calibration.toml.
"""

from typing import Any

from studies import recovery
from studies.common.registration import registration
from studies.common.study import Study, verdict
from studies.recovery import CHANCE, RATE, posterior, run, split, within

REGISTERED = registration("calibration")


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Test the registered hypotheses; return the verdicts and a table of the trials."""
    candidates, truths = split(cases)
    found = [posterior(CONFIG, candidates, truth["statistics"])[0] for truth in truths]
    lines, rows = [], []
    for name, key in (("chance", CHANCE), ("rate", RATE)):
        hits = sum(within(of, truth["values"], key) for of, truth in zip(found, truths, strict=True))
        lines.append(REGISTERED.verdict(name, hits, hits >= 32))
    both = sum(
        all(within(of, truth["values"], key) for key in (CHANCE, RATE))
        for of, truth in zip(found, truths, strict=True)
    )
    lines.append(
        verdict(
            "tries in which both true values lie within their intervals",
            f"{both} of {len(truths)}",
            "reported",
            True,
        )
    )
    for number, (of, truth) in enumerate(zip(found, truths, strict=True), 1):
        row: list[Any] = [number]
        for key in (CHANCE, RATE):
            low, high = (of["numbers"][key][end] for end in ("low", "high"))
            row += [truth["values"][key], f"{low:.3g} … {high:.3g}", within(of, truth["values"], key)]
        rows.append(row)
    head = ["try"]
    for name in ("catch probability", "breeding rate"):
        head += [f"true {name}", "90% interval", "within the interval"]
    return {"verdicts": lines, "table": {"head": head, "rows": rows}}


SEEDS = REGISTERED.content["seeds"]
CONFIG = recovery.CONFIG | {"ticks": REGISTERED.content["ticks"]}
STUDY = Study(
    name="calibration",
    claim=REGISTERED.content["claim"],
    config=CONFIG,
    registered=REGISTERED,
    cases=[
        *({"arm": "prior", "block": b} for b in range(SEEDS["prior"]["candidates"] // CONFIG["block"])),
        *(
            {"arm": "truth", "seed": seed}
            for seed in range(SEEDS["truth"]["first"], SEEDS["truth"]["last"] + 1)
        ),
    ],
    run=run,
    summarise=summarise,
    short_config=recovery.STUDY.short_config,
    short_cases=[{"arm": "prior", "block": 0}, {"arm": "truth", "seed": 2301}],
)

if __name__ == "__main__":
    STUDY.main()
