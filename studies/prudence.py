"""Does a slower intake evolve where young settle near their parents (Kerr et al. 2006, Nature 442: 75-78)?

Grazers of the world data/commons.toml inherit an intake: the probability of eating a plant within reach in a tick.
Plants spread to neighboring sites, so grazers that eat fast exhaust their surroundings and starve. In the
experiment, viruses that moved between neighboring populations of bacteria evolved to be prudent; viruses that moved
anywhere evolved to be rapacious.

Arms, with the same seeds; all founders eat fast:
  local                      young settle near their parent
  global                     young settle anywhere
  shuffled                   as local, but a tick's newborns exchange places at random: neighbors are not kin
  local drawn, global drawn  the intake of each newborn is drawn at random: not inherited

The world is one space, not an archipelago: 25 islands of the same area take 60 times as long, because they write
checkpoints whenever they exchange migrants. A patch is a square of 5 m, used only to count.

Grazers do not learn here; learning_classics.py runs this world with grazers that do.
The hypotheses are in registered/prudence.toml.
"""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.registration import registration
from studies.common.study import Study
from studies.common.training_seeds import interval

REGISTERED = registration("prudence")
WORLD = tomllib.loads((Path(__file__).parent / "data" / "commons.toml").read_text(encoding="utf-8"))
FOUNDERS = WORLD["species"]["grazer"]["diet"][0]["chance"]  # their intake
EVERY, LATER = 100, 30  # ticks: between samples, and from a sample to the count of young and of patches left
PATCH = 5.0  # m
SAMPLED = ("intake", "grazers", "plants", "empty", "bare", "lost", "eats")


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run one arm; return what is `SAMPLED` over time, selection, and the final mean intake of each patch."""
    from ecs_eco import World
    from ecs_eco.components import Traits
    from ecs_eco.config import load

    built = load(config["world"], REGISTERED.arms[case["arm"]])
    world = World.from_config(built, seed=case["seed"], record=False)
    grazers, plants, side = world.table("grazer"), world.table("plant"), round(built.space.size[0] / PATCH)
    mothers = list[int]()
    world.on_birth.append(settle(grazers, mothers, case["seed"] if case["arm"] == "shuffled" else None))
    samples, parts, last = [], [], np.zeros(side**2)
    for _ in range(config["ticks"] // EVERY):
        world.run(EVERY - LATER)
        if not grazers.n:
            break
        rows, where = grazers.rows(), patches(grazers, side)
        intake, uids = np.log(grazers[Traits].value[rows, 0].astype(float)), grazers.uid[rows].tolist()
        n, last = np.bincount(where, minlength=side**2), np.bincount(where, np.exp(intake), side**2)
        mothers.clear()
        world.run(LATER)
        young, after = Counter(mothers), np.bincount(patches(grazers, side), minlength=side**2)
        parts.append(selection(intake, np.array([young[uid] for uid in uids]), where, after))
        food = np.bincount(patches(plants, side), minlength=side**2)
        nerves, now = grazers.species.nerves, grazers.rows()
        eats = float(nerves.doing(grazers, "eat")[now].mean()) if nerves and now.size else 1.0
        shares = [np.mean(after == 0), np.mean(food == 0), np.mean(after[n > 0] == 0), eats]
        samples.append((np.exp(intake.mean()), grazers.n / side**2, plants.n / side**2, *shares))
        last /= np.maximum(n, 1)
    own, spread, growth, apart, total = np.sum(parts, axis=0) if parts else np.full(5, np.nan)
    return {
        "alive": grazers.n,
        **{
            name: line(x, 4)
            for name, x in zip(SAMPLED, np.reshape(samples, (-1, len(SAMPLED))).T, strict=True)
        },
        "within": own / spread,
        "among": growth / apart,
        "between": 1 - spread / total,
        "map": line(last, 2),
    }


def patches(table: Any, side: int) -> np.ndarray:
    """Return the number of the patch of each living organism, by row, for side × side patches."""
    from ecs_eco.components import Position

    p, rows = table[Position], table.rows()
    return (p.x[rows] // PATCH).astype(int) * side + (p.y[rows] // PATCH).astype(int)


def settle(grazers: Any, mothers: list[int], seed: int | None) -> Callable[..., None]:
    """Return a listener that notes the mothers of newborn grazers and, with a seed, exchanges the newborns'
    places at random."""
    from ecs_eco.components import Position

    def listen(table: Any, rows: np.ndarray, first: np.ndarray, _: Any) -> None:
        if table is grazers:
            mothers.extend(first.tolist())
            if rng is not None:
                p, others = table[Position], rng.permutation(rows)
                p.x[rows], p.y[rows] = p.x[others], p.y[others]
                table.version += 1

    rng = None if seed is None else np.random.default_rng(seed)
    return listen


def selection(intake: np.ndarray, young: np.ndarray, where: np.ndarray, after: np.ndarray) -> list[float]:
    """Return sums over one sample for three measures of selection on log intake.

    Given each grazer's log intake, number of young and patch, and the later number of grazers by patch:
    within patches, the slope of young on intake is item 0 divided by item 1; among patches with grazers, the
    slope of growth, the change in ln(1 + grazers), on mean intake is item 2 divided by item 3; and item 1
    divided by item 4 is the share of the variance of intake that is within patches.
    """
    n = np.bincount(where, minlength=after.size)
    mean = np.bincount(where, intake, after.size) / np.maximum(n, 1)
    own, occupied = intake - mean[where], n > 0
    patch, growth = mean[occupied] - mean[occupied].mean(), np.log((1 + after) / (1 + n))[occupied]
    total = intake - intake.mean()
    return [own @ young, own @ own, patch @ growth, patch @ patch, total @ total]


def line(values: np.ndarray, digits: int) -> str:
    """Return numbers as one line of text, with this many significant digits."""
    return " ".join(f"{value:.{digits}g}" for value in values)


def late(cases: list[dict[str, Any]], arm: str, name: str = "intake", part: int = 4) -> np.ndarray:
    """Return, for each of an arm's runs by seed, the log of a mean over the last 1/part of all samples."""
    runs = (np.array(text.split(), float) for text in measured(cases, arm, name))
    return np.array([np.log(x[len(x) * (part - 1) // part :].mean()) for x in runs])


def measured(cases: list[dict[str, Any]], arm: str, name: str) -> np.ndarray:
    """Return a value from each of an arm's runs, by seed."""
    of = {e["case"]["seed"]: e["result"][name] for e in cases if e["case"]["arm"] == arm}
    return np.array([of[seed] for seed in sorted(of)])


def ratio(logs: np.ndarray) -> list[float]:
    """Return the geometric mean of ratios given as logs, one per seed, and its 95% interval."""
    return [float(round(np.exp(x), 3)) for x in interval(logs.tolist())]


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the registered hypotheses, and a table of the arms."""
    of = {arm: late(cases, arm) for arm in REGISTERED.arms}
    alive = {arm: measured(cases, arm, "alive") > 0 for arm in of}
    effect, drawn = of["local"] - of["global"], of["local drawn"] - of["global drawn"]
    evolves, prudence = ratio(of["local"] - np.log(FOUNDERS)), ratio(effect)
    kin, heredity, cause = ratio(of["shuffled"] - of["global"]), ratio(drawn), ratio(effect - drawn)
    within, among = (interval(measured(cases, "local drawn", name).tolist()) for name in ("within", "among"))
    between = interval(
        (measured(cases, "local", "between") - measured(cases, "shuffled", "between")).tolist()
    )
    lost, fed = (
        ratio(late(cases, "local", name, 2) - late(cases, "shuffled", name, 2))
        for name in ("lost", "grazers")
    )
    persist = int(sum(map(sum, alive.values())))
    verdicts = [
        REGISTERED.verdict("persist", persist, persist >= 48),
        REGISTERED.verdict("evolves", evolves, evolves[2] < 0.6),
        REGISTERED.verdict("prudence", prudence, prudence[2] < 0.75),
        REGISTERED.verdict("kin", kin, kin[1] > prudence[2]),
        REGISTERED.verdict("heredity", heredity, heredity[1] > 0.9 and heredity[2] < 1.1),
        REGISTERED.verdict("cause", cause, cause[2] < 0.75),
        REGISTERED.verdict("within", within, within[1] > 0),
        REGISTERED.verdict("among", among, among[2] < 0),
        REGISTERED.verdict("between", between, between[1] > 0.3),
        REGISTERED.verdict("lost", lost, lost[2] < 1),
        REGISTERED.verdict("grazers", fed, fed[1] > 1),
    ]
    rows = []
    for arm, logs in of.items():
        means = [float(np.exp(late(cases, arm, name, 2).mean())) for name in SAMPLED[1:]]
        means += [float(measured(cases, arm, name).mean()) for name in ("between", "within", "among")]
        rows.append([arm, f"{sum(alive[arm])} of {logs.size}", float(np.exp(logs.mean())), *means])
    head = ["arm", "grazers persist", "intake at the end", "grazers per patch", "plants per patch"]
    head += ["patches without grazers", "without plants", "with grazers that are gone after 30 ticks"]
    head += ["variance of intake between patches", "selection within patches", "among patches"]
    return {"verdicts": verdicts, "table": {"head": head, "rows": rows}}


STUDY = Study(
    name="prudence",
    claim=REGISTERED.content["claim"],
    config={"world": WORLD, "ticks": REGISTERED.content["ticks"]},
    registered=REGISTERED,
    cases=[
        {"arm": arm, "seed": seed} for seed in REGISTERED.content["seeds"]["world"] for arm in REGISTERED.arms
    ],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": arm, "seed": 1} for arm in REGISTERED.arms],
    short_config={"ticks": 200},
)

if __name__ == "__main__":
    STUDY.main()
