"""Do the ledgers of energy and every substance balance in every tick, in random worlds and in shipped worlds?

The study compares two numbers with the stock: a world's largest ledger imbalance, and the sum of flows
between bodies, objects and fields, which must be zero.
"""

from typing import Any

from ecs_eco import World
from ecs_eco.config.shipped import shipped
from studies.common.ledgers import drawn, furthest_off
from studies.common.study import Study, verdict

CHUNK = 10  # worlds per case


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one chunk of worlds, or one shipped world, and return their ledger errors."""
    if "world" in case:
        world = World.from_config(case["world"], policies="random").run(config["shipped_ticks"])
        return {"worlds": 1, **furthest_off(world)}
    worst: dict[str, float] = {"energy": 0.0, "matter": 0.0, "between": 0.0}
    for seed in range(case["first"], case["first"] + config["chunk"]):
        world = World.from_config(drawn(seed), policies="random").run(config["ticks"])
        worst = {name: max(worst[name], off) for name, off in furthest_off(world).items()}
    return {"worlds": config["chunk"], **worst}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the largest errors over all worlds."""
    results = [case["result"] for case in cases]
    rows = [
        [
            case["case"].get("world", "random"),
            case["result"]["worlds"],
            *(f"{case['result'].get(name, 0):.1e}" for name in ("energy", "matter", "between")),
        ]
        for case in cases
    ]
    worlds = sum(r["worlds"] for r in results)
    words = {
        "energy": "energy: largest imbalance in a tick, as a share of the stock",
        "matter": "matter: the same, for every substance and holder",
        "between": "matter unaccounted for in transfers between holders, as a share of the stock",
    }
    verdicts = [
        verdict(
            "worlds", worlds, f"≥ {200 if len(cases) > 3 else 1}", worlds >= (200 if len(cases) > 3 else 1)
        )
    ]
    for name, statement in words.items():
        worst = max(r.get(name, 0.0) for r in results)
        verdicts.append(verdict(statement, worst, "< 1e-6", worst < 1e-6))
    return {
        "verdicts": verdicts,
        "table": {"head": ["world", "worlds", "energy", "matter", "transfers"], "rows": rows},
    }


STUDY = Study(
    name="ledgers",
    claim="The ledgers of energy and of every substance close to 1e-6 of the stock in every tick.",
    config={"chunk": CHUNK, "ticks": 60, "shipped_ticks": 200},
    cases=[*({"first": first} for first in range(0, 200, CHUNK)), *({"world": name} for name in shipped())],
    run=run,
    summarise=summarise,
    short_cases=[{"first": 0}, {"world": "lamb"}],
    short_config={"chunk": 3, "ticks": 20, "shipped_ticks": 10},
)

if __name__ == "__main__":
    STUDY.main()
