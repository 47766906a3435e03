"""Which seas reward migration, escape and the ability to smell krill?

Scripted copepods live in many seas; no policy is trained. A sea is worth training in only if following an
isolume (a surface of equal light) costs fewer lives, by a given factor, than staying at the surface, at
mid-depth or in deep water, and if fleeing and avoiding the smell of krill also pay. Each script lives for
some days in the world file's sea, with parameters drawn at random from the ranges below; population sizes are
held constant as in training. Deaths are per copepod per day, from krill and hunger combined. A script takes
about a second.
"""

from typing import Any

import numpy as np

from studies.common.study import Study, verdict

SCRIPTS = {  # depth; flees approaching krill; avoids their smell
    "isolume": ("isolume", True, True),
    "surface": ("surface", True, True),
    "middle": ("middle", True, True),
    "deep": ("deep", True, True),
    "bold": ("surface", False, False),
    "no escape": ("isolume", False, True),
    "no smell": ("isolume", True, False),
}
RANGES: dict[str, tuple[float, float]] = {
    "krill.count": (25, 60),
    "krill.sensors.1.sight": (10, 40),
    "krill.sensors.1.blind": (0.8, 2.5),
    "krill.locomotion.speed.wander": (0.25, 0.6),
    "krill.diet.0.chance": (0.3, 1.0),
    "krill.locomotion.speed.chase": (0.8, 1.3),
    "krill.diet.0.reach": (0.2, 0.6),
    "copepod.sensors.3.range": (1.2, 2.5),
    "copepod.metabolism.basal": (0.0015, 0.003),
}


class Script:
    """A copepod's behavior as a reflex, which maps observations to actions."""

    def __init__(
        self,
        channels: list[str],
        actions: list[str],
        where: str,
        flees: bool,
        smells: bool,
        bright: float = 0.6,
    ) -> None:
        self.at, self.to = {c: i for i, c in enumerate(channels)}, {a: i for i, a in enumerate(actions)}
        self.n_actions, self.where, self.flees, self.smells, self.bright = (
            len(actions),
            where,
            flees,
            smells,
            bright,
        )

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Decide: map f32[n, channels] to f32[n, actions], of which only the sign counts."""
        get = {name: x[:, i] for name, i in self.at.items()}
        depth = (get["pressure"] - 101_325.0) / (1025.0 * 9.81)
        up = np.where(get["food_near"] > 0, np.sign(get["food_up"]) * (np.abs(get["food_up"]) > 0.2), 0.0)
        left = np.where(
            get["food_near"] > 0,
            np.sign(get["food_left"]) * (np.abs(get["food_left"]) > 0.3),
            np.sign(get["whim_1"] - 0.5),
        )
        left = np.where(np.abs(get["whim_1"] - 0.5) < 0.35, np.where(get["food_near"] > 0, left, 0), left)
        if self.where == "isolume":
            up = np.where(get["light"] > self.bright, -1, np.where(get["light"] < 0.7 * self.bright, 1, up))
            fed = (depth < 6) & (get["food_near"] > 0) & (get["light"] <= self.bright)
            up = np.where(fed, np.sign(get["food_up"]) * (np.abs(get["food_up"]) > 0.2), up)
        else:
            low, high = {"surface": (0, 6), "middle": (12, 18), "deep": (24, 30)}[self.where]
            up = np.where(depth > high, 1, np.where(depth < low, -1, up))
        burst = np.zeros(len(x))
        if self.smells:
            smelt = get["krill_smell"] > 0.2
            up = np.where(smelt, -np.sign(get["krill_smell_gradient_up"]), up)
            left = np.where(
                smelt & (get["krill_smell_gradient_forward"] > 0),
                np.where(get["krill_smell_gradient_left"] > 0, -1, 1),
                left,
            )
        if self.flees:
            cue = get["krill_approach_closing"] > 0.2
            burst = cue.astype(float)
            up = np.where(cue, -np.sign(get["krill_approach_up"]), up)
            left = np.where(cue, np.where(get["krill_approach_left"] > 0, -1, 1), left)
        y = np.zeros((len(x), self.n_actions))
        y[:, self.to["up"]], y[:, self.to["down"]] = up > 0, up < 0
        y[:, self.to["left"]], y[:, self.to["right"]] = left > 0, left < 0
        y[:, self.to["burst"]], y[:, self.to["cruise"]] = burst, 1 - burst
        return y


def live(numbers: dict[str, float], script: str, seed: int, days: int) -> dict[str, float]:
    """Run scripted copepods in one sea; return deaths per copepod per day, and mean depths by night and by
    day."""
    from ecs_eco import World
    from ecs_eco.components import Position
    from ecs_eco.config import load

    data = load("diel-migration", {f"species.{k}": v for k, v in numbers.items()}).model_dump()
    data["training"]["set"], data["training"]["ramp"] = {}, []
    copepod = data["species"]["copepod"]
    copepod["sensors"] += [
        {"kind": "pressure", "name": "pressure"},
        {
            "kind": "custom",
            "name": "whim",
            "function": "ecs_eco.worlds.diel_migration.senses:whim",
            "width": 2,
        },
    ]
    copepod |= {"policy": {"kind": "none"}, "ppo": {}}
    names = load(data | {"training": {}}).species["copepod"]
    copepod["reflex"] = {
        "function": Script(list(names.channels(3)), [a for _, a in names.action_list()], *SCRIPTS[script])
    }
    world = World.from_config(data, seed=seed, training=True)
    day = round(data["sun"]["day"] / data["dt"])
    world.run(day)  # time for phytoplankton to settle at its depth
    table, depths = world.tables["copepod"], []
    for _ in range(days * 8):
        world.run(day // 8)
        depths.append(float(data["space"]["size"][2] - table[Position].z[table.rows()].mean()))
    series = world.series().to_pydict()
    each = len(world.recorder.names)
    mine = slice(day * each + world.recorder.names.index("copepod"), None, each)
    lives = table.n * days
    out = {kind: sum(series[f"died: {kind}"][mine]) / lives for kind in ("eaten by krill", "starved")}
    # the first sample is an eighth of a day after the start
    shape = np.array(depths).reshape(days, 8).mean(0)
    hour = (data["sun"]["start"] + (np.arange(8) + 1) / 8) % 1
    bright = abs(hour - 0.5) < 0.2
    return out | {
        "deaths": sum(out.values()),
        "day": float(shape[bright].mean()),
        "night": float(shape[abs(hour - 0.5) > 0.3].mean()),
        "food": float(world.tables["phytoplankton"].n),
    }


def drawn(candidate: int) -> dict[str, float]:
    """Return a sea's parameters, drawn log-uniformly from their ranges; candidate 0 is the shipped world."""
    generator = np.random.Generator(np.random.Philox(key=[2, candidate]))
    numbers = {k: float(np.round(np.exp(generator.uniform(*np.log(r))), 4)) for k, r in RANGES.items()}
    return numbers | {"krill.count": int(numbers["krill.count"])} if candidate else {}


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Return all scripts' results in one sea."""
    numbers = drawn(case["candidate"])
    return {
        "numbers": numbers,
        "found": {
            script: live(numbers, script, case["seed"], config["days"]) for script in config["scripts"]
        },
    }


def score(result: dict[str, Any]) -> float:
    """Return the deaths under the best other script, divided by those under the script that follows an
    isolume, flees and avoids the smell."""
    scripts = result["found"]
    return min(v["deaths"] for k, v in scripts.items() if k != "isolume") / max(
        scripts["isolume"]["deaths"], 0.02
    )


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Rank the seas, including the shipped sea."""
    ranked = sorted(cases, key=lambda c: -score(c["result"]))
    scripts = list(cases[0]["result"]["found"])
    rows = [
        [
            c["case"]["candidate"],
            *(round(c["result"]["found"][s]["deaths"], 2) for s in scripts),
            *(c["result"]["numbers"].get(k, "as shipped") for k in RANGES),
        ]
        for c in ranked[:20]
    ]
    shipped = next(c["result"]["found"] for c in cases if c["case"]["candidate"] == 0)
    own = max(shipped["isolume"]["deaths"], 0.02)
    verdicts = [
        verdict(
            f"deaths in the shipped sea: {script} over isolume",
            round(shipped[script]["deaths"] / own, 2),
            "above 1",
            shipped[script]["deaths"] > own,
        )
        for script in scripts
        if script != "isolume"
    ]
    return {"verdicts": verdicts, "table": {"head": ["sea", *scripts, *RANGES], "rows": rows}}


STUDY = Study(
    name="search_diel_migration",
    claim="In the shipped sea following an isolume, fleeing, "
    "and minding the smell of krill each save copepods' lives.",
    config={"days": 3, "scripts": list(SCRIPTS)},
    cases=[{"candidate": i, "seed": 1 + i} for i in range(48)],
    run=run,
    summarise=summarise,
    short_cases=[{"candidate": 0, "seed": 1}],
    short_config={"days": 1, "scripts": ["isolume", "surface"]},
)

if __name__ == "__main__":
    STUDY.main()
