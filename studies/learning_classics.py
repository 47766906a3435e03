"""What does learning in life change in four classic experiments?

The worlds of rapid_evolution, fishing_for_size, prudence and swarms run again with animals that learn: all members
of a species train one network by PPO while they live, breed and die. The network is not inherited.

  one clone, four clones   rotifers learn to choose the algae that they swim to
  fished, not fished       fish learn to avoid a net, in place of the yearly catches of the largest
  local, global            grazers learn when to eat
  confusion, none          prey learn how to turn from deaths alone; in the third arm, death costs nothing

Arms without `learn` have the same seeds. Swarms that evolve are in swarms. What animals see, the arms and the
hypotheses are in registered/learning_classics.toml, whose claim expected that cycles do not change.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from studies import fishing_for_size, prudence, rapid_evolution, swarms
from studies.common.registration import registration
from studies.common.study import Study, verdict
from studies.common.training_seeds import interval

if TYPE_CHECKING:
    from ecs_eco.config import WorldConfig

REGISTERED = registration("learning_classics")
ARMS, SEEDS = REGISTERED.arms, REGISTERED.content["seeds"]["world"]
WORLDS = {
    of.STUDY.name: of.STUDY.config["world"] for of in (rapid_evolution, fishing_for_size, prudence, swarms)
}
LAST = fishing_for_size.AFTER
LATE = 4  # the last quarter of samples
SCATTERED = 400 / 60**2 * np.pi * swarms.NEAR**2  # expected number of neighbors of prey at random positions
BySeed = dict[int, float]


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run one arm by its study's own function, in the world with that arm's changes."""
    (world, arm), study = world_of(case["arm"]), ARMS[case["arm"]]["study"]
    own = {"world": world, "ticks": config["ticks"][study]}
    return import_module(f"studies.{study}").run(own, {"arm": arm, "seed": case["seed"]})


def world_of(name: str) -> tuple[WorldConfig, str]:
    """Return the world of an arm, and the arm of its study that it belongs to."""
    from ecs_eco.config import load

    changes = dict(ARMS[name])
    study, arm, learn = (changes.pop(key) for key in ("study", "arm", "learn"))
    learners = REGISTERED.content["learners"][study] if learn else {}
    return load(WORLDS[study], REGISTERED.content["worlds"][study] | learners | changes), arm


def of(cases: list[dict[str, Any]], arm: str, name: str) -> dict[int, Any]:
    """Return a measure of an arm's runs, by seed: a number, or the values f64[n] of a series."""
    own = {e["case"]["seed"]: e["result"][name] for e in cases if e["case"]["arm"] == arm}
    known = {seed: value for seed, value in own.items() if value is not None}
    return {s: np.array(v.split(), float) if isinstance(v, str) else float(v) for s, v in known.items()}


def end(cases: list[dict[str, Any]], arm: str, name: str) -> BySeed:
    """Return the mean of a series over its last quarter, by seed."""
    return {seed: float(x[-(len(x) // LATE or 1) :].mean()) for seed, x in of(cases, arm, name).items()}


def ratio(one: BySeed, other: BySeed) -> list[float]:
    """Return the ratio of two positive quantities, paired by seed, and its 95% interval."""
    logs = [np.log(one[seed] / other[seed]) for seed in sorted(one.keys() & other.keys())]
    return [float(round(np.exp(x), 3)) for x in interval(logs)]


def gap(one: BySeed, other: BySeed) -> list[float]:
    """Return the mean difference of two quantities, paired by seed, and its 95% interval."""
    return interval([one[seed] - other[seed] for seed in sorted(one.keys() & other.keys())])


def intake(cases: list[dict[str, Any]], arm: str) -> BySeed:
    """Return inherited intake times the share of ticks in which grazers eat, at the end, by seed."""
    eats = end(cases, arm, "eats")
    return {seed: value * eats[seed] for seed, value in end(cases, arm, "intake").items()}


def swing(cases: list[dict[str, Any]], arm: str) -> BySeed:
    """Return the standard deviation of log10 of the number of rotifers, by seed."""
    return {e["case"]["seed"]: e["result"]["swings"][1] for e in cases if e["case"]["arm"] == arm}


def catch(cases: list[dict[str, Any]], arm: str) -> BySeed:
    """Return the catch of the fishery's last three years [g], at least 1 g, by seed."""
    return {s: max(1.0, float(x[LAST - 3 : LAST].sum())) for s, x in of(cases, arm, "yield").items()}


def weight(cases: list[dict[str, Any]], arm: str) -> BySeed:
    """Return the weight of the stock after the fishery [g], by seed."""
    return {seed: float(x[LAST]) for seed, x in of(cases, arm, "weight").items()}


def doubled(cases: list[dict[str, Any]], arm: str) -> list[int]:
    """Return the ticks after which neighbors had doubled, for the runs of an arm in which they did."""
    ticks = [np.flatnonzero(x > 2 * SCATTERED) for x in of(cases, arm, "near").values()]
    return [int(1 + at[0]) * swarms.EVERY for at in ticks if at.size]


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the registered hypotheses, and a table of the arms."""
    period = {arm: of(cases, arm, "period") for arm in ("one clone", "four clones")}
    period |= {f"{arm}, learn": of(cases, f"{arm}, learn", "period") for arm in list(period)}
    near = {arm: end(cases, arm, "near") for arm, told in ARMS.items() if told["study"] == "swarms"}
    swarm = near["confusion, learn"]
    chosen = [of(cases, arm, "choice") for arm in ("four clones, learn", "four clones")]
    eats = [end(cases, f"{arm}, learn", "eats") for arm in ("local", "global")]
    choice, restraint = gap(*chosen), gap(*eats)
    alone = ratio(period["one clone, learn"], period["one clone"])
    evolution = ratio(period["four clones, learn"], period["one clone, learn"])
    longer = ratio(period["four clones, learn"], period["four clones"])
    caught = ratio(catch(cases, "fished, learn"), catch(cases, "fished"))
    weights, unfished = (
        ratio(weight(cases, f"{arm}, learn"), weight(cases, arm)) for arm in ("fished", "not fished")
    )
    prudent = ratio(intake(cases, "local, learn"), intake(cases, "global, learn"))
    grows = ratio(swarm, dict.fromkeys(swarm, SCATTERED))
    cause, reward = (ratio(swarm, near[arm]) for arm in ("none, learn", "confusion, no reward"))
    verdicts = [
        REGISTERED.verdict("choice", choice, choice[2] < 0),
        REGISTERED.verdict("alone", alone, alone[1] > 0.8 and alone[2] < 1.25),
        REGISTERED.verdict("evolution", evolution, evolution[1] > 1.5),
        REGISTERED.verdict("longer", longer, longer[1] > 1),
        REGISTERED.verdict("catch", caught, caught[2] < 0.5),
        REGISTERED.verdict("weight", weights, weights[1] > 1),
        REGISTERED.verdict("unfished", unfished, unfished[1] > 0.9 and unfished[2] < 1.1),
        REGISTERED.verdict("prudent", prudent, prudent[2] < 0.8),
        REGISTERED.verdict("restraint", restraint, restraint[1] > -0.15),
        REGISTERED.verdict("swarms", grows, grows[1] > 2),
        REGISTERED.verdict("cause", cause, cause[1] > 2),
        REGISTERED.verdict("reward", reward, reward[1] > 2),
    ]
    ticks = doubled(cases, "confusion, learn")
    reported: dict[str, Any] = {
        **{
            f"{arm}: runs whose rotifers cycle": int(sum(of(cases, arm, "cycles").values()))
            for arm in ("four clones", "four clones, learn")
        },
        "four clones: swing of rotifers [log10], learn minus not": gap(
            swing(cases, "four clones, learn"), swing(cases, "four clones")
        ),
        "four clones: lag of rotifers [periods], learn minus not": gap(
            of(cases, "four clones, learn", "lag"), of(cases, "four clones", "lag")
        ),
        "grazers that do not learn: ratio of intake, local to global": ratio(
            intake(cases, "local"), intake(cases, "global")
        ),
        "local: ratio of intake, learn to not": ratio(intake(cases, "local, learn"), intake(cases, "local")),
        "confusion, learn: runs in which neighbors double": len(ticks),
        "median tick at which they double": float(np.median(ticks)) if ticks else None,
    }
    verdicts += [verdict(says, value, "reported", True) for says, value in reported.items()]
    return {"verdicts": verdicts, "table": table(cases)}


def table(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the means of each arm's measures."""
    measures: dict[str, dict[str, Any]] = {
        "rapid_evolution": {"median period [ticks]": "period", "choice": "choice"},
        "fishing_for_size": {"weight after the fishery [g]": weight, "last three catches [g]": catch},
        "prudence": {"intake": intake, "share of ticks in which they eat": "eats"},
        "swarms": {"neighbors within 3 m": "near"},
    }
    rows = []
    for arm, told in ARMS.items():
        for says, name in measures[told["study"]].items():
            if callable(name):
                values = name(cases, arm)
            else:
                values = of(cases, arm, name) if name in ("period", "choice") else end(cases, arm, name)
            middle = np.median if name == "period" else np.mean
            rows.append([told["study"], arm, says, float(middle(list(values.values()) or [np.nan]))])
    return {"head": ["study", "arm", "measure", "value"], "rows": rows}


STUDY = Study(
    name="learning_classics",
    claim="Learning in life makes prey swarm and empties nets in a few lifetimes, does not make grazers prudent, "
    "and weakens the cycles of algae and rotifers.",
    config={"worlds": WORLDS, "ticks": REGISTERED.content["ticks"]},
    registered=REGISTERED,
    cases=[{"arm": arm, "seed": seed} for seed in SEEDS for arm in ARMS],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": arm, "seed": 1} for arm in ARMS],
    short_config={
        "ticks": {"rapid_evolution": 60, "fishing_for_size": 228, "prudence": 200, "swarms": 2 * swarms.EVERY}
    },
)

if __name__ == "__main__":
    STUDY.main()
