"""How much do two reflexes help a newborn, and what does it learn?

The arms vary whether lambs have each reflex and whether they learn. Every lamb has its own brain, which is
untrained at birth. An arm turns off the sucking reflex, the diving reflex, learning, or the smell of sheep in
happiness. Survival and causes of death show the value of each factor; breathing and turning, by thirds of
childhood, show what survivors have learned. The replicates are worlds, not lambs.
"""

import ast
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco import System
from ecs_eco.components import Nervous, Position, Velocity
from studies.common.study import Study, verdict

# weights of udder → suck, water → inhale
REFLEXES = {"both": (1, -1), "sucking": (1, 0), "diving": (0, -1), "none": (0, 0)}
ARMS = [
    *((reflexes, how) for reflexes in REFLEXES for how in ("learning", "fixed")),
    ("both", "learning, no sheep"),
]
SEEDS = tuple(range(1, 6))
PARTS = 3  # parts of the run over which behavior is averaged
FEWEST = 10  # minimum number of ticks that a lamb must spend in a state to count in a contrast of states


class Watch(System):
    """An observer that records every lamb's behavior in each third of a run: the sum and the number of cases,
    f64[third, measure, 2, lamb]."""

    needs = (Nervous, Velocity)
    phase = "move"
    measures = ("breathes_short", "breathes_well", "at_udder", "distance", "approach", "turns_right_way")

    def __init__(self, ticks: int, lambs: int) -> None:
        self.ticks, self.sums = ticks, np.zeros((PARTS, len(self.measures), 2, lambs))
        self.first = 0  # uid of the first lamb

    def update(self, table: Any, world: Any) -> None:
        """Count the lambs' actions in one tick; `x` contains what they sensed before they decided and
        moved."""
        nerves, rows = table.species.nerves, table.species.nerves.rows
        if not rows.size:
            return
        self.first = self.first or int(table.uid[rows].min())
        x = {name: nerves.x[:, i] for i, name in enumerate(nerves.channels)}
        does = {a: nerves.doing(table, a)[rows] for a in ("inhale", "left", "right")}
        distance, approach = nearest_ewe(table, world, rows)
        dry, oxygen = x["touch_water"] == 0, x["oxygen"]
        side = x["milk_smell_left"] - x["milk_smell_right"]
        every = np.ones(rows.size, bool)
        value = (
            does["inhale"],
            does["inhale"],
            x["touch_udder"],
            distance,
            approach,
            (side > 0) == does["left"],
        )
        # 0.9 m is contact
        counts = (
            dry & (oxygen < 0.9),
            dry & (oxygen > 1.05),
            every,
            every,
            distance > 1.1,
            (does["left"] | does["right"]) & (np.abs(side) > 0.01),
        )
        part, who = (
            min(world.tick * PARTS // self.ticks, PARTS - 1),
            (table.uid[rows] - np.uint64(self.first)).astype(int),
        )
        self.sums[part][:, 0, who] += np.array(value, float) * counts
        self.sums[part][:, 1, who] += counts

    def means(self) -> dict[str, list[float]]:
        """Return means over all cases by third; `contrast` (breathes_short − breathes_well) and `nearing`
        (approach speed) are means over lambs.

        A lamb that finds its mother is seldom away from the ewes, so stray lambs would dominate a mean over
        all approaches.
        """
        with np.errstate(invalid="ignore"):
            total, own = (
                self.sums.sum(axis=-1),
                self.sums[:, :, 0] / np.where(self.sums[:, :, 1] < FEWEST, np.nan, self.sums[:, :, 1]),
            )
            of_all = total[..., 0] / total[..., 1]
        by_lamb = {"contrast": own[:, 0] - own[:, 1], "nearing": own[:, self.measures.index("approach")]}
        means = {
            name: [v[np.isfinite(v)].mean() if np.isfinite(v).any() else np.nan for v in values]
            for name, values in by_lamb.items()
        }
        return {name: of_all[:, i] for i, name in enumerate(self.measures)} | means


def nearest_ewe(table: Any, world: Any, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return each lamb's distance [m] to the nearest ewe before its step, and the speed at which the step
    approached that ewe [m/s]."""
    ewes, size, at = world.table("ewe"), world.space.size, table[Position]
    speed, heading, living = table[Velocity].speed[rows], at.heading[rows], ewes.rows()
    ways = zip(
        (at.x, at.y),
        (ewes[Position].x, ewes[Position].y),
        (np.cos(heading), np.sin(heading)),
        size,
        strict=False,
    )
    dx, dy = (
        (there[living] - (here[rows] - speed * world.dt * way)[:, None] + s / 2) % s - s / 2
        for here, there, way, s in ways
    )
    near = np.hypot(dx, dy).argmin(axis=1)
    dx, dy = (d[np.arange(rows.size), near] for d in (dx, dy))
    distance = np.hypot(dx, dy)
    return distance, speed * (dx * np.cos(heading) + dy * np.sin(heading)) / np.maximum(distance, 1e-6)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one world; return how many lambs survive to the end, when and why the other lambs died, and the
    lambs' behavior."""
    from ecs_eco import World
    from ecs_eco.config import load

    sucking, diving = REFLEXES[case["reflexes"]]
    connections = [
        {"sensor": "touch_udder", "above": 0.5, "action": "suck", "weight": sucking},
        {"sensor": "touch_water", "above": 0.5, "action": "inhale", "weight": diving},
    ]
    changed = {"species.lamb.reflex.connections": connections, "species.lamb.count": config["lambs"]}
    if "no sheep" in case["how"]:
        changed["species.lamb.happiness.formula"] = config["without_sheep"]
    watch = Watch(config["ticks"], config["lambs"])
    world = World.from_config(
        load("lamb", changed), seed=case["seed"], learn=case["how"] != "fixed", systems=[watch], record=False
    )
    lambs, deaths = world.table("lamb"), []

    def died(table: Any, rows: np.ndarray) -> None:
        deaths.extend((world.causes[c - 1], world.tick) for c in table.cause[rows])

    world.on_death.append(died)
    while world.tick < config["ticks"] and lambs.n:
        world.run(100)
    count = {cause: sum(c == cause for c, _ in deaths) for cause in ("drowned", "suffocated", "starved")}
    return {
        "lambs": config["lambs"],
        "alive": lambs.n,
        **count,
        "died_at": [tick for _, tick in deaths],
        **watch.means(),
    }


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return shares of survivors and causes of death by arm, and differences between arms, with confidence
    intervals over worlds."""
    from ecs_eco.analysis.survival import bootstrap_difference

    def values(arm: tuple[str, str], of: Any) -> list[float]:
        numbers = [of(e["result"]) for e in cases if (e["case"]["reflexes"], e["case"]["how"]) == arm]
        return [v for v in numbers if v is not None and np.isfinite(v)]

    def line(text: str, goal: str, a: list[float], b: list[float]) -> None:
        if len(a) > 1 and len(b) > 1:
            gap = bootstrap_difference(a, b)
            out.append(verdict(text, [gap.value, gap.low, gap.high], goal, gap.low > 0))

    def share(what: str) -> Any:
        return lambda r: r[what] / r["lambs"]

    def late(r: dict[str, Any]) -> float:
        return r["contrast"][-1]

    out: list[dict[str, Any]] = []
    whole, fixed, lonely = ("both", "learning"), ("both", "fixed"), ("both", "learning, no sheep")
    zero = [0.0] * len(SEEDS)
    line(
        "share that survives to the end, both reflexes − no sucking reflex",
        "above 0",
        values(whole, share("alive")),
        values(("diving", "learning"), share("alive")),
    )
    line(
        "share that starves without the sucking reflex, learning − one half",
        "above 0",
        [v - 0.5 for v in values(("diving", "learning"), share("starved"))],
        zero,
    )
    line(
        "share that drowns, no diving reflex − both reflexes",
        "above 0",
        values(("sucking", "learning"), share("drowned")),
        values(whole, share("drowned")),
    )
    line(
        "share that survives to the end, both reflexes − no diving reflex",
        "above 0",
        values(whole, share("alive")),
        values(("sucking", "learning"), share("alive")),
    )
    line(
        "share that survives to the end, learning − not learning",
        "above 0",
        values(whole, share("alive")),
        values(fixed, share("alive")),
    )
    line(
        "probability of inhaling when short of oxygen − otherwise, last third, learning − not learning",
        "above 0",
        values(whole, late),
        values(fixed, late),
    )
    line(
        "the same for lambs that learn, last third − first third",
        "above 0",
        values(whole, late),
        values(whole, lambda r: r["contrast"][0]),
    )
    line(
        "share of turns toward the stronger smell of milk, last third, learning − not learning",
        "above 0",
        values(whole, lambda r: r["turns_right_way"][-1]),
        values(fixed, lambda r: r["turns_right_way"][-1]),
    )
    line(
        "speed of approach to the nearest ewe [m/s], mean over lambs, last third, learning − not learning",
        "above 0",
        values(whole, lambda r: r["nearing"][-1]),
        values(fixed, lambda r: r["nearing"][-1]),
    )
    line(
        "the same for lambs that learn, last third − first third",
        "above 0",
        values(whole, lambda r: r["nearing"][-1]),
        values(whole, lambda r: r["nearing"][0]),
    )
    line(
        "distance to the nearest ewe [m], last third, without − with the smell of sheep in happiness",
        "above 0",
        values(lonely, lambda r: r["distance"][-1]),
        values(whole, lambda r: r["distance"][-1]),
    )
    return {
        "verdicts": out,
        "table": {"head": HEAD, "rows": [_row(arm, values) for arm in ARMS if values(arm, share("alive"))]},
    }


HEAD = [
    "reflexes",
    "",
    "lambs",
    "survive to the end",
    "drowned",
    "suffocated",
    "starved",
    "at the udder, by thirds",
    "inhaling when short of oxygen − otherwise, by thirds",
    "turns toward the stronger smell of milk, by thirds",
    "approach [mm/s], by thirds",
    "distance to the nearest ewe [m], by thirds",
]


def _row(arm: tuple[str, str], values: Any) -> list[Any]:
    def mean(of: Any) -> float | None:
        numbers = values(arm, of)
        return sum(numbers) / len(numbers) if numbers else None

    def thirds(of: Any, places: int) -> str:
        return " ".join(
            "–" if (m := mean(lambda r, p=p: of(r, p))) is None else f"{m:.{places}f}" for p in range(PARTS)
        )

    def scaled(name: str, factor: float = 1.0) -> Any:
        return lambda r, p: None if r[name][p] is None else r[name][p] * factor

    n = int(sum(values(arm, lambda r: r["lambs"])))
    shares = [mean(lambda r, k=k: r[k] / r["lambs"]) for k in ("alive", "drowned", "suffocated", "starved")]
    return [
        *arm,
        n,
        *shares,
        thirds(scaled("at_udder"), 2),
        thirds(scaled("contrast"), 2),
        thirds(scaled("turns_right_way"), 2),
        thirds(scaled("nearing", 1000), 1),
        thirds(scaled("distance"), 2),
    ]


def _is_submodel(part: ast.stmt) -> bool:
    """Return whether a statement in a class body defines its `submodel`."""
    return isinstance(part, ast.Assign) and ast.unparse(part.targets[0]) == "submodel"


def identity() -> dict[str, str]:
    """Return a hash of the world and its systems that ignores imports and formatting, so that changing the
    world invalidates the results."""
    import hashlib

    from ecs_eco.config import load
    from ecs_eco.worlds.lamb import systems

    tree = ast.parse(Path(systems.__file__).read_bytes())
    tree.body = [part for part in tree.body if isinstance(part, ast.FunctionDef | ast.ClassDef | ast.Assign)]
    for part in tree.body:  # `ecs-eco describe` texts do not affect results
        if isinstance(part, ast.ClassDef):
            part.body = [one for one in part.body if not _is_submodel(one)]
    return {
        "world": load("lamb").config_hash[:16],
        "systems": hashlib.sha256(ast.dump(tree).encode()).hexdigest()[:16],
    }


STUDY = Study(
    name="lamb",
    claim="Two reflexes keep newborn lambs alive while each lamb learns to breathe and to find milk.",
    config={
        "world": "lamb",
        "identity": identity(),
        "ticks": 3000,
        "lambs": 24,
        "without_sheep": "-4 * (1 - oxygen)**2 - 3 * (1 - glucose)**2",
    },
    cases=[{"reflexes": r, "how": h, "seed": s} for r, h in ARMS for s in SEEDS],
    run=run,
    summarise=summarise,
    short_cases=[{"reflexes": "both", "how": h, "seed": s} for h in ("learning", "fixed") for s in (1, 2)],
    short_config={"ticks": 300, "lambs": 8},
)

if __name__ == "__main__":
    STUDY.main()
