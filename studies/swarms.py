"""Does confusion of predators make prey swarm (Olson et al. 2013, J. R. Soc. Interface 10: 20130305)?

Prey of the world data/swarms.toml turn by a linear network whose weights are their genes. Its inputs are the
numbers of prey on the left and on the right, and the mean heading of neighbors. A predator turns to the nearest
prey in view, and a little to the side with more prey. If prey confuse it, the probability of a catch is 1/n with n
prey in view, as in Olson et al.; otherwise, it is 0.2, which gives about as many catches while prey are scattered.

Arms, with the same seeds:
  confusion, none               catches that depend on the number of prey in view, or do not
  drawn                         confusion, but the genes of each newborn prey are drawn at random: not inherited
  no predators                  as many prey die, at random
  confusion view, none view     as the first two, but predators inherit their field of view

In the experiment, groups were clones and competed with other groups. Here each animal competes with all others, and
newborns appear anywhere, so prey are not selected for the good of relatives.
The hypotheses are in registered/swarms.toml.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.registration import registration
from studies.common.study import Study, verdict
from studies.common.training_seeds import interval

REGISTERED = registration("swarms")
WORLD = Path(__file__).parent / "data" / "swarms.toml"
EVERY = 250  # ticks between looks
WINDOW = 4  # looks at the start and at the end of a run that are averaged
NEAR = 3.0  # [m]
MEASURES = ("near", "spacing", "attraction", "alignment", "neutral", "view", "caught")


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run one arm; return its measures at each look, and by how much prey that are eaten differ."""
    from ecs_eco import World
    from ecs_eco.components import Policy, Traits
    from ecs_eco.config import load

    built = load(config["world"], REGISTERED.arms[case["arm"]])
    world = World.from_config(built, seed=case["seed"], record=False)
    prey, predator = world.table("prey"), world.table("predator")
    differences, caught = list[float](), 0

    def note(table: Any, rows: np.ndarray) -> None:
        nonlocal caught
        eaten = [int(row) for row in rows if world.causes[table.cause[row] - 1] == "eaten by predator"]
        if eaten:
            caught += len(eaten)
            if Policy in prey:
                all_of = turning(prey[Policy].weights[prey.rows()])[0].mean()
                differences.extend(turning(prey[Policy].weights[np.array(eaten)])[0] - all_of)

    world.on_death.append(note)
    looks = list[list[float]]()
    for _ in range(config["ticks"] // EVERY):
        world.run(EVERY)
        hunters = predator.rows()
        view = float(predator[Traits].value[hunters, 0].mean()) if hunters.size else 0.0
        weights = (
            prey[Policy].weights[prey.rows()] if Policy in prey else np.zeros((1, 16))
        )  # one network for all
        genes = [float(x.mean()) for x in turning(weights)]
        looks.append([*aggregation(world, prey), *genes, view, caught])
        caught = 0
    columns = zip(*looks, strict=True)
    series = {name: " ".join(f"{x:.3f}" for x in of) for name, of in zip(MEASURES, columns, strict=True)}
    third = len(differences) // 3
    parts = [np.mean(part) if len(part) else 0.0 for part in (differences, differences[:third])]
    return {**series, "prey": prey.n, "predators": predator.n, "eaten differ": parts}


def turning(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return how strongly prey turn to the side with more prey and to the heading of neighbors, and the same
    difference of weights that have no effect: f64[n] each."""
    of = np.asarray(weights, float)[:, :16].reshape(-1, 4, 4)  # inputs; left, none, right, value
    turns = of[:, :, 0] - of[:, :, 2]
    return (turns[:, 0] - turns[:, 1]) / 2, turns[:, 3], of[:, 0, 3] - of[:, 1, 3]


def aggregation(world: Any, prey: Any) -> tuple[float, float]:
    """Return the mean number of prey within 3 m of each, and the ratio by Clark & Evans (1954): the mean distance
    to the nearest neighbor, divided by its expectation for random positions."""
    from ecs_eco.components import Position

    rows, sides = prey.rows(), np.array(world.space.size[:2], float)
    at = np.stack([prey[Position].x[rows], prey[Position].y[rows]], 1).astype(float)
    away = at[:, None] - at
    distance = np.hypot(*np.moveaxis(away - sides * np.round(away / sides), -1, 0))
    np.fill_diagonal(distance, np.inf)
    density = rows.size / sides.prod()
    return float((distance < NEAR).sum(1).mean()), float(2 * distance.min(1).mean() * np.sqrt(density))


def ends(cases: list[dict[str, Any]], arm: str, name: str) -> dict[int, tuple[float, float]]:
    """Return the mean of a measure in the first and in the last looks of an arm's runs, by seed."""
    own = {e["case"]["seed"]: e["result"][name] for e in cases if e["case"]["arm"] == arm}
    looks = {seed: np.array(line.split(), float) for seed, line in own.items()}
    return {seed: (float(x[:WINDOW].mean()), float(x[-WINDOW:].mean())) for seed, x in looks.items()}


def growth(cases: list[dict[str, Any]], arm: str) -> list[float]:
    """Return the ratio of neighbors within 3 m, end to start, and its 95% interval."""
    logs = [np.log(last / first) for first, last in ends(cases, arm, "near").values()]
    return [float(round(np.exp(x), 2)) for x in interval(logs)]


def ratio(cases: list[dict[str, Any]], one: str, other: str) -> list[float]:
    """Return the ratio of neighbors within 3 m at the end of two arms, paired by seed, and its 95% interval."""
    a, b = ends(cases, one, "near"), ends(cases, other, "near")
    return [float(round(np.exp(x), 2)) for x in interval([np.log(a[s][1] / b[s][1]) for s in sorted(a)])]


def gap(cases: list[dict[str, Any]], name: str, one: str, other: str) -> list[float]:
    """Return the difference of a measure at the end between two arms, paired by seed, and its 95% interval."""
    a, b = ends(cases, one, name), ends(cases, other, name)
    return interval([a[seed][1] - b[seed][1] for seed in sorted(a)])


def selection(cases: list[dict[str, Any]], arm: str, part: int) -> list[float]:
    """Return the attraction of eaten prey minus that of all prey (0: in the whole run, 1: in the first third of
    catches), and its 95% interval."""
    return interval([e["result"]["eaten differ"][part] for e in cases if e["case"]["arm"] == arm])


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the registered hypotheses, and a table of the arms."""
    swarm, alone = growth(cases, "confusion"), growth(cases, "none")
    cause, heredity = ratio(cases, "confusion", "none"), ratio(cases, "confusion", "drawn")
    predators, drawn = ratio(cases, "confusion", "no predators"), growth(cases, "drawn")
    gene = gap(cases, "attraction", "confusion", "none")
    spacing = gap(cases, "spacing", "confusion", "none")
    eaten, eaten_none = selection(cases, "confusion", 1), selection(cases, "none", 1)
    course = gap(cases, "alignment", "confusion", "none")
    view, against = (
        gap(cases, "view", "confusion view", "none view"),
        ratio(cases, "confusion view", "none view"),
    )
    verdicts = [
        REGISTERED.verdict("swarms", swarm, swarm[1] > 2),
        REGISTERED.verdict("cause", cause, cause[1] > 2),
        REGISTERED.verdict("alone", alone, alone[2] < 1.25),
        REGISTERED.verdict("heredity", heredity, heredity[1] > 2),
        REGISTERED.verdict("drawn", drawn, drawn[1] > 0.8 and drawn[2] < 1.25),
        REGISTERED.verdict("predators", predators, predators[1] > 2),
        REGISTERED.verdict("spacing", spacing, spacing[2] < -0.2),
        REGISTERED.verdict("gene", gene, gene[1] > 1),
        REGISTERED.verdict("selection", eaten, eaten[2] < 0),
        REGISTERED.verdict("alignment", course, course[1] > 0),
        REGISTERED.verdict("view", view, view[2] < 0),
        REGISTERED.verdict("view-swarms", against, against[1] > 2),
        verdict("none: attraction of eaten prey minus all prey, first third", eaten_none, "reported", True),
        verdict(
            "end, confusion: ratio of neighbors within 3 m, inherited to constant field of view",
            ratio(cases, "confusion view", "confusion"),
            "reported",
            True,
        ),
    ]
    doubled = {a: sum(y > 2 * x for x, y in ends(cases, a, "near").values()) for a in REGISTERED.arms}
    for arm in ("confusion", "confusion view"):
        says = f"{arm}: runs in which neighbors within 3 m at least double, of 10"
        verdicts.append(verdict(says, doubled[arm], "reported", True))
    rows = []
    for arm in REGISTERED.arms:
        own = {name: np.array(list(ends(cases, arm, name).values())).mean(0) for name in MEASURES}
        values = [*own["near"], *own["spacing"], own["attraction"][1], own["alignment"][1], own["neutral"][1]]
        rows.append([arm, doubled[arm], *values, *(own["caught"] / EVERY), own["view"][1]])
    head = ["arm", "runs in which neighbors double", "neighbors within 3 m, start", "end"]
    head += ["Clark-Evans ratio, start", "end", "attraction, end", "alignment, end"]
    head += ["neutral weights, end", "catches per second, start", "end", "field of view, end [rad]"]
    return {"verdicts": verdicts, "table": {"head": head, "rows": rows}}


STUDY = Study(
    name="swarms",
    claim=REGISTERED.content["claim"],
    config={"world": tomllib.loads(WORLD.read_text(encoding="utf-8")), "ticks": REGISTERED.content["ticks"]},
    registered=REGISTERED,
    cases=[
        {"arm": arm, "seed": seed} for seed in REGISTERED.content["seeds"]["world"] for arm in REGISTERED.arms
    ],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": arm, "seed": 1} for arm in REGISTERED.arms],
    short_config={"ticks": 2 * EVERY},
)

if __name__ == "__main__":
    STUDY.main()
