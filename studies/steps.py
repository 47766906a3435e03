"""Which processes depend on the tick length? Each process runs with five tick lengths, in current and earlier
code.

`python tools/make_steps.py` writes the table to docs/explanation/steps.md.
"""

import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.study import Study, verdict

ROOT = Path(__file__).parents[1]
BEFORE = "3f8a42e4d81e629dc209c54d5505460a6e75557f"  # the commit that current code is compared with
STEPS = (2.0, 1.0, 0.5, 0.25, 0.1)  # [s]
EXACT = 0.02  # relative error, beyond random error, up to which a process counts as exact


def world(
    dt: float,
    seed: int,
    species: dict[str, Any],
    size: float = 50.0,
    options: Any = None,
    food: Any = None,
    **sections: Any,
) -> Any:
    """Return a world with one species, `one`, with small transparent bodies, and optionally a food
    species."""
    from ecs_eco import World

    one = {"count": 1, "body": {"radius": 0.1, "opaque": False}} | species
    config = {
        "format": 1,
        "name": "steps",
        "dt": dt,
        "space": {"size": [size, size]},
        "species": {"one": one} | (food or {}),
    } | sections
    return World.from_config(config, seed=seed, **(options or {}))


def lived(seconds: float, made: Any) -> Any:
    """Return the world after a given time [s]."""
    return made.run(round(seconds / made.dt))


def flow(made: Any, column: str, after: float = 0.0) -> float:
    """Return the sum of a series column from a given time [s] on."""
    series = made.series().to_pandas()
    return float(series.loc[series.tick >= after / made.dt, column].sum()) if column in series else 0.0


GO: dict[str, Any] = {"locomotion": {"speed": {"go": 1.0}}, "actions": {"speed": ["go"]}, "always_on": ["go"]}
FOOD: dict[str, Any] = {"count": 1600, "body": {"radius": 0.1, "opaque": False}, "renewal": 5.0}
RICH = {"energy": 0.0, "energy_max": 1e4}


def meals(dt: float, seed: int) -> float:
    """Return how many meals per second an animal eats while moving straight ahead."""
    diet = [{"eats": "food", "reach": 0.2, "gain": 1.0}]
    made = lived(
        60, world(dt, seed, GO | {"count": 30, "metabolism": RICH, "diet": diet}, objects={"food": FOOD})
    )
    return flow(made, "eaten: food", 20) / (30 * 40)


def at_the_table(
    dt: float, seed: int, seconds: float, digestion: float, chance: float = 1.0, toughness: float = 0.0
) -> float:
    """Return how many meals an animal surrounded by food eats in a given time."""
    small = {"radius": 0.1, "opaque": False}
    grass = {"count": 20_000, "body": small, "defence": {"toughness": toughness}}
    one = {
        "count": 300,
        "metabolism": RICH | {"handling_time": digestion},
        "diet": [{"eats": "grass", "reach": 3.0, "gain": 1.0, "chance": chance}],
    }
    made = lived(seconds, world(dt, seed, one, food={"grass": grass}))
    return flow(made, "eaten: grass") / 300


def births(dt: float, seed: int, fertility: float = 1.0, age_min: float = 500.0) -> tuple[Any, float]:
    """Return a world of well-fed parents after 8 s, and births per founder per second."""
    way = {"kind": "asexual", "rate": 0.25, "energy_min": 0.01, "energy_given": 0.001, "age_min": age_min}
    made = lived(
        8,
        world(
            dt,
            seed,
            {
                "count": 2000,
                "age": [1000.0, 1000.0],
                "fertility": fertility,
                "metabolism": {"photosynthesis": 100.0},
                "reproduction": way,
            },
            400.0,
        ),
    )
    return made, flow(made, "births") / 2000 / 8


def conceived(dt: float, seed: int) -> float:
    """Return the share of couples that conceive within 2 s."""
    from ecs_eco.components import Gestation
    from ecs_eco.testing import arrange

    way = {
        "kind": "sexual",
        "energy_min": 0.0,
        "energy_given": 0.0,
        "reach": 1.0,
        "chance": 0.6,
        "gestation": 100.0,
    }
    made, n = world(dt, seed, {"count": 1800, "fertility": 0.5, "reproduction": way}, 150.0), np.arange(1800)
    arrange(made, "one", x=5 * (n // 2 % 30) + 1 + n % 2, y=5 * (n // 60) + 1)
    table = lived(2, made).table("one")
    return float((table[Gestation].carrying[table.rows()] > 0).sum()) / 900


def smell(dt: float, seed: int) -> float:
    """Return the content of a field with one source, in equilibrium with decay."""
    made = lived(
        40,
        world(
            dt,
            seed,
            {"emits": {"scent": 1.0}},
            10.0,
            fields={"scent": {"cell": 1.0, "diffusion": 0.2, "decay": 0.5}},
        ),
    )
    return float(made.fields["scent"].value.sum())


def air(dt: float, seed: int) -> float:
    """Return the equilibrium concentration of a substance that decays and is replenished."""
    field = {"cell": 5.0, "decay": 0.5, "substance": "oxygen", "initial": 3.0, "renewal": 0.25}
    made = lived(40, world(dt, seed, {}, 10.0, substances={"oxygen": "dissolved"}, fields={"air": field}))
    return float(made.fields["air"].value.mean())


def spread(dt: float, seed: int) -> float:
    """Return the share of sites that plants occupy after 6 s, starting from a tenth."""
    way = {"kind": "spread", "rate": 0.3, "spacing": 1.0}
    made = lived(6, world(dt, seed, {"count": 1440, "reproduction": way}, 120.0))
    return float(made.table("one").n) / 14_400


def burnt_sugar(dt: float, seed: int) -> float:
    """Return the amount of a substance left by a Michaelis–Menten reaction after 8 s."""
    from ecs_eco.components import Chemistry

    reaction = {"from": {"sugar": 1.0}, "to": {}, "rate": 0.2, "half": {"sugar": 0.5}}
    made = lived(
        8,
        world(
            dt, seed, {"substances": {"sugar": 1.0}, "reactions": [reaction]}, substances={"sugar": "food"}
        ),
    )
    return float(made.table("one")[Chemistry].molarity[0, 0])


def walk(dt: float, seed: int) -> float:
    """Return the root-mean-square displacement [m] after 32 s of animals that move straight between random
    turns."""
    from ecs_eco.components import Position

    one = {
        "count": 400,
        "locomotion": {"speed": {"go": 1.0}, "turn": 1.0},
        "sensors": [{"kind": "own", "property": "energy"}],
        "actions": {"speed": ["go"], "turn": ["left", "none", "right"]},
        "always_on": ["go"],
        "happiness": {"formula": "energy", "minimum": -1.0},
        "policy": {"kind": "shared", "hidden": [4]},
    }
    made = world(dt, seed, one, 500.0, {"policies": "random"})
    p, rows = made.table("one")[Position], made.table("one").rows()
    x, y = p.x[rows].copy(), p.y[rows].copy()
    p = lived(32, made).table("one")[Position]
    away = [(now[rows] - then + 250) % 500 - 250 for now, then in ((p.x, x), (p.y, y))]
    return float(np.sqrt(np.mean(np.square(away).sum(0))))


def circle(dt: float, seed: int) -> float:
    """Return the diameter [m] of the circle traced by an animal that turns constantly."""
    from ecs_eco.components import Position

    made = world(
        dt,
        seed,
        {
            "locomotion": {"speed": {"go": 1.0}, "turn": 0.5},
            "actions": {"speed": ["go"], "turn": ["left"]},
            "always_on": ["go", "left"],
        },
    )
    places = []
    for _ in range(3):
        p = made.run(1).table("one")[Position]
        places.append(complex(p.x[0], p.y[0]))
    one, two = (
        complex((d.real + 25) % 50 - 25, (d.imag + 25) % 50 - 25)
        for d in (places[1] - places[0], places[2] - places[1])
    )
    return float(abs(one) / math.sin(abs(np.angle(two / one)) / 2))


def value(made: Any, component: str, field: str) -> float:
    """Return a field's value for the only organism."""
    from ecs_eco import components

    return float(made.table("one").field(getattr(components, component), field)[0])


def dragged(dt: float, seed: int) -> float:
    """Return the distance [m] that an animal covers in 2 s against drag."""
    made = world(dt, seed, GO | {"locomotion": {"speed": {"go": 1.0}, "drag": 1.0}})
    x, y = value(made, "Position", "x"), value(made, "Position", "y")
    lived(2, made)
    return math.hypot(
        (value(made, "Position", "x") - x + 25) % 50 - 25, (value(made, "Position", "y") - y + 25) % 50 - 25
    )


def cooled(dt: float, seed: int) -> float:
    """Return a body's temperature after 8 s, relative to its surroundings [K]."""
    one = {
        "body": {"radius": 0.1, "mass": 1.0},
        "properties": {"temperature": 310.0},
        "heat": {"specific_heat": 10.0, "conductance": 10.0},
    }
    return (
        value(lived(8, world(dt, seed, one, ambient={"temperature": 285.0})), "Physical", "temperature")
        - 285.0
    )


def grown(dt: float, seed: int) -> float:
    """Return a young animal's mass after 4 s of growth, as a share of adult mass."""
    from ecs_eco.components import Body

    made = world(dt, seed, {"body": {"radius": 0.1, "mass": 1.0}, "growth": {"rate": 0.2, "newborn": 0.05}})
    made.table("one")[Body].mass[0] = 0.05
    return value(lived(4, made), "Body", "mass")


def left_of(dt: float, seed: int, what: str) -> float:
    """Return the amount left after 4 s of rotting (carrion) or harvesting (fish)."""
    from ecs_eco.components import Metabolism

    if what == "carrion":
        made = lived(
            4,
            world(
                dt,
                seed,
                {},
                objects={
                    "meat": {"count": 1, "body": {"radius": 0.1}, "energy": {"initial": 1.0, "decay": 0.3}}
                },
            ),
        )
        return float(made.table("meat")[Metabolism].energy[0])
    use = {"kind": "harvest", "species": "one", "rate": 0.1}
    return float(lived(4, world(dt, seed, {"count": 4000}, land_use=[use])).table("one").n) / 4000


def planted(dt: float, seed: int) -> float:
    """Return the number of plants planted in ten 10 s years with a 4 s season, at one per second."""
    use = {"kind": "plant", "species": "one", "rate": 1.0, "period": 10.0, "season": [0.2, 0.6]}
    return flow(lived(100, world(dt, seed, {"count": 0}, land_use=[use])), "births")


def died_at(dt: float, seed: int) -> float:
    """Return the age [s] at which an animal with a maximum age of 10.3 s dies."""
    made = world(dt, seed, {"lethal": [{"property": "age", "max": 10.3}]})
    while made.run(1).table("one").n:
        pass
    return float(made.tick * dt)


def fasted(dt: float, seed: int) -> float:
    """Return the energy left after 8 s of fasting."""
    return value(lived(8, world(dt, seed, {"metabolism": {"basal": 0.05}})), "Metabolism", "energy")


def sugar_left() -> float:
    """Return the exact solution of `burnt_sugar`, computed in small steps."""
    c = 1.0
    for _ in range(80_000):
        c -= 1e-4 * 0.2 * c / (0.5 + c)
    return c


# name: its function, the expected value, and how it depends on dt
Measure = Callable[[float, int], float]
PROCESSES: dict[str, tuple[Measure, float | None, str]] = {
    "smell at equilibrium": (smell, 2.0, "amount exact; distribution first order"),
    "substance renewed and decaying": (air, 1.0, "exact without diffusion, else first order"),
    "share of sites taken (`spread`)": (
        spread,
        0.1 * math.e**1.8 / (1 + 0.1 * (math.e**1.8 - 1)),
        "exact where seeds fall anywhere on even ground, else first order",
    ),
    "births per parent per second": (
        lambda dt, seed: births(dt, seed)[1],
        0.25,
        "exact (Poisson), while parents stay fed",
    ),
    "births at a fertility of 0.5": (lambda dt, seed: births(dt, seed, 0.5)[1], 0.125, "exact (Poisson)"),
    "growth of a population that breeds from birth": (
        lambda dt, seed: births(dt, seed, age_min=0.0)[0].table("one").n / 2000,
        math.e**2,
        "first order",
    ),
    "couples that conceived, fertility 0.5": (conceived, 1 - 0.85**2, "exact"),
    "bites into tough food that succeeded": (
        lambda dt, seed: at_the_table(dt, seed, 2.0, 1e3, 0.5, 0.6),
        1 - 0.8**2,
        "exact in contact",
    ),
    "meals per second while searching": (meals, 0.512, "contacts at the end of ticks: see below"),
    "meals per second, digestion takes 3 s": (
        lambda dt, seed: at_the_table(dt, seed, 60.0, 3.0) / 60,
        1 / 3,
        "whole ticks, rounded up",
    ),
    "meals per second, digestion takes 0.5 s": (
        lambda dt, seed: at_the_table(dt, seed, 20.0, 0.5) / 20,
        2.0,
        "at most one meal per tick",
    ),
    "age at death, maximum age 10.3 s": (died_at, 10.3, "whole ticks, rounded up"),
    "plants planted in ten seasons of 4 s": (planted, 40.0, "whole ticks, the same in each year"),
    "fish left after a harvest": (lambda dt, seed: left_of(dt, seed, "fish"), math.exp(-0.4), "exact"),
    "carrion left after rotting": (lambda dt, seed: left_of(dt, seed, "carrion"), math.exp(-1.2), "exact"),
    "energy after fasting": (fasted, 0.6, "exact"),
    "mass of a growing animal": (grown, (1 - (1 - 0.05 ** (1 / 3)) * math.exp(-0.8)) ** 3, "exact"),
    "temperature of a cooling body": (cooled, 25 * math.exp(-8 * 4 * math.pi * 0.01 * 10 / 10), "exact"),
    "distance against drag": (dragged, 2 - (1 - math.exp(-2)), "exact"),
    "substance used up by a reaction": (burnt_sugar, sugar_left(), "first order"),
    "diameter of a circle": (circle, 4.0, "second order: turns, then goes straight"),
    "distance of a random walk": (walk, None, "decisions are per tick"),
}
SHORT = ("smell at equilibrium", "share of sites taken (`spread`)", "energy after fasting")


@lru_cache(1)
def former(commit: str) -> Path:
    """Return a folder with the package at a given commit, and the current studies."""
    place = Path(tempfile.mkdtemp(prefix="ecs-eco-steps-"))
    code = subprocess.run(["git", "archive", commit, "ecs_eco"], cwd=ROOT, check=True, capture_output=True)
    subprocess.run(["tar", "-x"], cwd=place, check=True, input=code.stdout)
    (place / "studies").symlink_to(ROOT / "studies")
    return place


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Measure one process at all tick lengths; earlier code runs in a separate process."""
    given = case["process"], config["steps"], config["seeds"]
    if case["code"] == "now":
        return measured(*given)
    text = f"import json; from studies.steps import measured; print(json.dumps(measured(*{given!r})))"
    done = subprocess.run(
        [sys.executable, "-c", text], cwd=former(config["before"]), check=True, capture_output=True, text=True
    )
    out: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return out


def measured(process: str, steps: list[float], seeds: list[int]) -> dict[str, Any]:
    """Return, for each tick length, the mean over seeds and its standard error."""
    out = {}
    for dt in steps:
        values = [PROCESSES[process][0](dt, seed) for seed in seeds]
        error = float(np.std(values, ddof=1) / math.sqrt(len(values))) if len(values) > 1 else 0.0
        out[f"{dt:g}"] = {"mean": float(np.mean(values)), "error": error}
    return out


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return a row for each process and code version, and whether processes labeled exact are exact."""
    found = {(c["case"]["process"], c["case"]["code"]): c["result"] for c in cases}
    rows, exact, met = [], 0, 0
    for name, (_, expected, order) in PROCESSES.items():
        for code in ("before", "now"):
            if (name, code) in found:
                here = [found[name, code].get(f"{dt:g}") for dt in STEPS]
                rows.append(
                    [
                        name,
                        code,
                        order if code == "now" else "",
                        None if expected is None else round(expected, 4),
                        *(None if r is None else float(f"{r['mean']:.4g}") for r in here),
                    ]
                )
                if code == "now" and order.startswith(("exact", "amount exact")) and expected is not None:
                    off = [abs(r["mean"] - expected) - 3 * r["error"] for r in here if r is not None]
                    exact, met = exact + 1, met + (max(off) <= EXACT * expected)
    return {
        "verdicts": [
            verdict(
                "processes described as exact that match the expected value at every tick length",
                f"{met} of {exact}",
                "all",
                met == exact,
            )
        ],
        "table": {
            "head": [
                "process",
                "version",
                "how it depends on dt",
                "expected",
                *(f"dt {dt:g}" for dt in STEPS),
            ],
            "rows": rows,
        },
    }


STUDY = Study(
    name="steps",
    claim="Exactly solved processes do not depend on the tick length; how the others depend on it is known.",
    config={"seeds": [1, 2, 3], "steps": list(STEPS), "before": BEFORE},
    cases=[{"process": name, "code": code} for code in ("before", "now") for name in PROCESSES],
    run=run,
    summarise=summarise,
    short_config={"seeds": [1, 2, 3, 4], "steps": [2.0, 1.0]},
    short_cases=[{"process": name, "code": "now"} for name in SHORT],
)

if __name__ == "__main__":
    STUDY.main()
