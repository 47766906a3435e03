"""When does running from a wolf benefit deer, do they then learn to run, and how do the cycles change?

Wolf approaches are scripted: a wolf sees a deer 5 m away and runs at it; the deer walks or runs away as soon
as it sees the wolf. The benefit of running is mapped over its cost, the deer's range of sight and the wolves'
speed. Policies are then trained with the world's training recipe, in the shipped world and in a world where
running pays. A third arm moves deer trained where running is expensive into the second world, with that
world's wolves: the parameters are the same, but the deer walk. The hypotheses are in
registered/deer_that_flee.toml. Worlds have the shipped area, on half of which wolves died out in half of the
runs; training worlds have half of theirs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from studies.common.policies import trained, without_policies
from studies.common.predator_prey import frozen
from studies.common.pursuit import Pursuit, share
from studies.common.registration import registration
from studies.common.seed_grid import both_peaks, by_training, record
from studies.common.selection import mean_interval
from studies.common.study import Study, verdict
from studies.common.training_seeds import share_gap, share_of_lives

REGISTERED = registration("deer_that_flee")
Entries = list[dict[str, Any]]
DEER, WOLF = "species.deer.", "species.wolf."


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run a seed's approaches, or one of an arm's worlds."""
    return scripted(config, case["seed"]) if case["arm"] == "approaches" else lived(config, case)


def scripted(config: dict[str, Any], seed: int) -> dict[str, Any]:
    """Return survival and happiness after an approach for each response, in each grid cell and in both
    worlds."""
    from studies.common.hunts import approaches

    of = config["approaches"]

    def both(changes: Mapping[str, Any]) -> dict[str, dict[str, float]]:
        return {
            way: approaches(changes, f"{way}_away", seed, of["side"], of["ticks"]) for way in ("walk", "run")
        }

    grid = [
        {
            "cost": cost,
            "sight": sight,
            "speed": speed,
            **both(
                {
                    f"{DEER}locomotion.cost.run": cost,
                    f"{DEER}sensors.3.range": sight,
                    f"{WOLF}locomotion.speed.run": speed,
                }
            ),
        }
        for cost in of["cost"]
        for sight in of["sight"]
        for speed in of["speed"]
    ]
    return {"grid": grid, "worlds": {name: both(config["worlds"][name]) for name in config["worlds"]}}


def world(config: Mapping[str, Any], name: str) -> Any:
    """Return the named world, with a smaller ground in training."""
    from ecs_eco.config import load

    content = without_policies(frozen({**config["ground"], **config["worlds"][name]}))
    content["training"]["set"] |= config["small training"]
    return load(content)


def lived(config: Mapping[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run an arm's world with trained policies; return the outcome, and which animals ran when."""
    from ecs_eco import World

    arm = REGISTERED.arms[case["arm"]]
    learnt = {
        of: str(trained(world(config, arm[of]), case["training"], config["training ticks"]))
        for of in ("deer", "wolf")
    }
    living = world(config, arm["world"])
    made = World.from_config(living, seed=case["seed"], policies=learnt, learn=False)
    pursuit, (first, last, every) = Pursuit(made), config["looks"]
    while made.tick < config["ticks"] and made.tables["deer"].n and made.tables["wolf"].n:
        near = first <= made.tick < last
        made.run(min(every if near else 100, config["ticks"] - made.tick))
        if near:
            pursuit.look()
    kept = record(made, living)
    n = np.array([[float(v) for v in kept["series"][name].split()] for name in ("deer", "wolf")])
    swing = np.log10(n[:, n.shape[1] // 10 :] + 1).std(1)
    return {
        "persisted": kept["persisted"],
        "lived": kept["lived"],
        "extinct": kept["extinct"],
        "cycled": bool(kept["persisted"] and both_peaks(kept)),
        "period": kept["cycles"]["period"],
        "lag": kept["cycles"]["lags"].get("deer→wolf", {}).get("share"),
        "swing": dict(zip(("deer", "wolf"), swing, strict=True)),
        "numbers": {k: v["mean"] for k, v in kept["numbers"].items()},
        "deaths": kept["deaths"],
        "pursuit": pursuit.as_lists(),
        "series": kept["series"],
    }


# --- statistics -------------------------------------------------------------------------------------------


def gain(place: Mapping[str, Any], what: str = "happiness") -> float:
    """Return the gain from running instead of walking in an approach."""
    return float(place["run"][what] - place["walk"][what])


def running(
    entries: Entries, arm: str, who: str, low: float, high: float, column: str = "run"
) -> dict[int, float]:
    """Return, for each training seed, the share of animals running at distances from `low` to `high` [m] over
    all world seeds, or the mean of another column of studies.common.pursuit."""
    out = {}
    for seed, results in by_training(entries, arm).items():
        counts = np.sum([r["pursuit"][who] for r in results], axis=0)
        out[seed] = share(counts.tolist(), column, low, high)
    return out


def mean_of(entries: Entries, arm: str, what: str) -> dict[int, float]:
    """Return, for each training seed, a species' mean swing over the runs that persist, or the mean log2
    period over those that also cycle; training seeds without such runs are omitted."""
    out = {}
    for seed, results in by_training(entries, arm).items():
        values = (
            [np.log2(r["period"]) for r in results if r["cycled"]]
            if what == "period"
            else [r["swing"][what] for r in results if r["persisted"]]
        )
        if values:
            out[seed] = float(np.mean(values))
    return out


def persisting(entries: Entries, arm: str) -> dict[int, float]:
    """Return, for each training seed, the share of runs in which all species persist."""
    return {
        seed: float(np.mean([r["persisted"] for r in results]))
        for seed, results in by_training(entries, arm).items()
    }


def lives(entries: Entries, arm: str) -> list[dict[str, Any]]:
    """Return an arm's runs, each with its seeds."""
    return [e["case"] | e["result"] for e in entries if e["case"]["arm"] == arm]


def difference(one: Mapping[int, float], other: Mapping[int, float]) -> list[float]:
    """Return the mean difference over training seeds common to both arms, and its 95% interval (t)."""
    both = [one[k] - other[k] for k in one if k in other and np.isfinite(one[k] - other[k])]
    return mean_interval(both)


# --- conclusions ------------------------------------------------------------------------------------------


def summarise(entries: Entries) -> dict[str, Any]:
    """Test the registered hypotheses; return the verdicts, a line for each arm and the map of gains from
    running."""
    made = [e["result"] for e in entries if e["case"]["arm"] == "approaches"]
    if {e["case"]["arm"] for e in entries} < {
        "approaches",
        *REGISTERED.arms,
    }:  # the short form omits some arms
        return {"verdicts": [verdict("cases that ran", len(entries), "reported", True)]}
    lines = [*of_approaches(made), *of_learning(entries), *of_cycles(entries), *looked_at(entries)]
    head = [
        "cost of running [1/s]",
        "deer's range of sight [m]",
        "speed of running wolves [m/s]",
        "share of walking deer that survive",
        "share of running deer that survive",
        "happiness gained by running",
    ]
    rows = []
    for places in zip(*(m["grid"] for m in made), strict=True):
        first = places[0]
        rows.append(
            [
                first["cost"],
                first["sight"],
                first["speed"],
                *(float(np.mean([p[way]["survival"] for p in places])) for way in ("walk", "run")),
                float(np.mean([gain(p) for p in places])),
            ]
        )
    return {"verdicts": lines, "table": {"head": head, "rows": rows}, "notes": notes(entries)}


def of_approaches(made: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the lines that report approaches."""
    fleeing, shipped = ([gain(m["worlds"][name]) for m in made] for name in ("fleeing", "shipped"))
    pays = mean_interval(fleeing)
    more = mean_interval([a - b for a, b in zip(fleeing, shipped, strict=True)])
    close = [p for m in made for p in m["grid"] if p["sight"] == 3.0 and p["speed"] == 1.3]
    most = max(map(gain, close))
    lives = [
        float(np.mean([m["worlds"][name][way]["survival"] for m in made]))
        for name in ("shipped", "fleeing")
        for way in ("walk", "run")
    ]
    return [
        REGISTERED.verdict("pays", pays, pays[1] > 0),
        REGISTERED.verdict("more", more, more[1] > 0),
        REGISTERED.verdict("too late", most, most < 0),
        verdict(
            "share of deer that survive an approach: shipped, walking and running; fleeing, walking and running",
            ", ".join(f"{x:.2f}" for x in lives),
            "reported",
            True,
        ),
    ]


def of_learning(entries: Entries) -> list[dict[str, Any]]:
    """Return the lines that report which animals run, and when."""
    learnt = difference(running(entries, "fleeing", "deer", 0, 3), running(entries, "shipped", "deer", 0, 3))
    cue = difference(running(entries, "fleeing", "deer", 0, 3), running(entries, "fleeing", "deer", 8, 12))
    toward = running(entries, "fleeing", "deer", 0, 3, "toward, running")
    away = mean_interval([-v for v in toward.values()])
    hunt = difference(running(entries, "fleeing", "wolf", 0, 3), running(entries, "shipped", "wolf", 0, 3))
    return [
        REGISTERED.verdict(name, value, bool(value[1] > margin))
        for name, value, margin in (
            ("learnt", learnt, 0.1),
            ("cue", cue, 0.1),
            ("away", away, 0.3),
            ("pursuit", hunt, 0.0),
        )
    ]


def of_cycles(entries: Entries) -> list[dict[str, Any]]:
    """Return the lines that report persistence, periods and swings."""
    fleeing, walkers = lives(entries, "fleeing"), lives(entries, "walkers")
    kept = float(np.mean(list(persisting(entries, "fleeing").values())))
    lines = [REGISTERED.verdict("persists", share_of_lives(fleeing, "persisted"), kept >= 0.8)]
    for name, arm, what in (
        ("period", "shipped", "period"),
        ("swing-deer", "shipped", "deer"),
        ("swing-wolf", "shipped", "wolf"),
        ("flight-period", "walkers", "period"),
        ("flight-swing", "walkers", "deer"),
    ):
        gap = difference(mean_of(entries, "fleeing", what), mean_of(entries, arm, what))
        met = gap[2] < 0 or (gap[1] > 0 and name != "flight-swing")
        lines.append(REGISTERED.verdict(name, gap, bool(met)))
    lasts = share_gap(fleeing, walkers, "persisted")
    return [*lines, REGISTERED.verdict("flight-persists", lasts, lasts[1] > 0)]


def looked_at(entries: Entries) -> list[dict[str, Any]]:
    """Return lines added after we saw that worlds with walkers go extinct."""
    by = {arm: by_training(entries, arm) for arm in REGISTERED.arms}
    lasted, swings = (
        {
            arm: {seed: float(np.mean(list(map(value, results)))) for seed, results in of.items()}
            for arm, of in by.items()
        }
        for value in (lambda r: np.log10(r["lived"]), lambda r: r["swing"]["deer"])
    )
    lines = [
        (
            "log10 of ticks until the first extinction or the end of the run: fleeing minus walkers",
            difference(lasted["fleeing"], lasted["walkers"]),
        )
    ]
    lines += [
        (
            f"swing of deer while all species are alive, in all runs: fleeing minus {arm}",
            difference(swings["fleeing"], swings[arm]),
        )
        for arm in ("walkers", "shipped")
    ]
    return [verdict(f"explored: {words}", value, "reported", True) for words, value in lines]


def notes(entries: Entries) -> str:
    """Return a sentence for each arm."""
    out = []
    for arm in REGISTERED.arms:
        results = [r for of in by_training(entries, arm).values() for r in of]
        kept = [r for r in results if r["persisted"]]
        periods = [r["period"] for r in kept if r["period"]]
        gone = [r["extinct"] for r in results if r["extinct"]]
        deer, far, wolves = (
            np.nanmean(list(running(entries, arm, *of).values()))
            for of in (("deer", 0, 3), ("deer", 8, 12), ("wolf", 0, 3))
        )
        out.append(
            f"{arm}: {len(kept)} of {len(results)} runs persist, {sum(r['cycled'] for r in results)} "
            f"with spectral peaks of deer and wolves; "
            f"{f'median period {np.median(periods):.0f} ticks' if periods else 'no period'}; first to die out: "
            f"{', '.join(f'{s} {gone.count(s)}' for s in dict.fromkeys(gone)) or 'none'}; deer that "
            f"run within 3 m of a wolf {deer:.0%}, 8 to 12 m away {far:.0%}; wolves that run within "
            f"3 m of a deer {wolves:.0%}."
        )
    return "\n\n".join(out)


CONTENT = REGISTERED.content
SEEDS = CONTENT["seeds"]
STUDY = Study(
    name="deer_that_flee",
    claim=CONTENT["claim"],
    registered=REGISTERED,
    config={
        "ground": {},  # as shipped
        "small training": CONTENT["training"],
        "worlds": CONTENT["worlds"],
        "ticks": CONTENT["ticks"],
        "training ticks": None,
        "looks": CONTENT["looks"],
        "approaches": CONTENT["approaches"],
    },
    cases=[
        *({"arm": "approaches", "seed": seed} for seed in SEEDS["approaches"]),
        *(
            {"arm": arm, "training": training, "seed": seed}
            for seed in SEEDS["world"]
            for training in SEEDS["training"]
            for arm in REGISTERED.arms
        ),
    ],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": "approaches", "seed": 1}, {"arm": "walkers", "training": 1, "seed": 1}],
    short_config={
        "ticks": 60,
        "training ticks": 8,
        "looks": [20, 60, 20],
        "ground": {
            "space.size": [120.0, 120.0],  # where 120 wolves fit
            "species.grass.count": 1065,
            "species.deer.count": 120,
            "species.wolf.count": 40,
        },
        "small training": {
            "space.size": [60.0, 60.0],
            "species.grass.count": 200,
            "species.deer.count": 40,
            "species.wolf.count": 12,
        },
        "approaches": {"side": 4, "ticks": 20, "cost": [0.008], "sight": [6.0], "speed": [1.2]},
    },
)

if __name__ == "__main__":
    STUDY.main()
