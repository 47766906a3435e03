"""Why do wolves go extinct if deer and wolves keep learning at the pre-training rate, and under which
conditions do they survive?

The hypotheses are in registered/full_rate.toml. Arms define which species learn, in the shipped world and in
a world with different wolf parameters, both at a quarter of the area. If both learn, all four pairs of
initial and final policies then run frozen and are measured in the arena: the pre-training world, where
respawn holds population sizes constant. There, wolves also keep learning against the frozen final deer.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.moved import life
from studies.common.policies import trained
from studies.common.predator_prey import frozen
from studies.common.registration import registration
from studies.common.seed_grid import both_peaks, record
from studies.common.selection import pooled
from studies.common.study import Study, verdict
from studies.common.training_seeds import share_of_lives

REGISTERED = registration("full_rate")
QUARTER = {
    "space.size": [120.0, 120.0],
    "species.grass.count": 1075,
    "species.deer.count": 175,
    "species.wolf.count": 62,
}
LEARNERS = ("deer", "wolf")
ENDS = ("first", "last")  # a run's initial and final policies
Result = dict[str, Any]


# --- one run, and the measurements after it -------------------------------------------------------------------


def run(config: dict[str, Any], case: Mapping[str, Any]) -> Result:
    """Run a world in which a training seed's policies live and learn as the arm defines; return the outcome
    and, if the arm requests it, the outcomes of their frozen pairs."""

    says = config["arms"][case["arm"]]
    shipped = frozen(config["small"])
    folder = trained(shipped, case["training"], config["training ticks"])
    wanted = {**config["small"], **(candidate(case["seed"]) if case["arm"] == "search" else says["set"])}
    wanted |= {f"species.{s}.policy.learn": s in says["learn"] for s in LEARNERS}
    wanted |= {f"species.{s}.ppo.anneal": 0 for s in LEARNERS}
    living = frozen(wanted)
    world, moved = life(living, folder, case["seed"], config["ticks"], LEARNERS)
    out = brief(record(world, living)) | {"moved": moved}
    if case["arm"] == "both" and case["seed"] == config["swap seed"]:
        out |= swapped(
            config, shipped, case, {"first": first_of(folder), "last": {s: state(world, s) for s in LEARNERS}}
        )
    return out


def candidate(seed: int) -> dict[str, float]:
    """Draw world and learning parameters log-uniformly from the ranges. A parameter with a species prefix
    applies to that species; the prefix "both" applies to both deer and wolves."""
    rng = np.random.default_rng(seed)
    drawn: dict[str, float] = {}
    for key, (low, high) in REGISTERED.content["search"]["ranges"].items():
        value: float = float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.3g}")
        if isinstance(low, int):
            value = round(value)
        drawn |= {key.replace("both", s): value for s in (LEARNERS if "both" in key else ("",))}
    return drawn


def state(world: Any, species: str) -> dict[str, np.ndarray]:
    """Return a copy of a shared policy's weights."""
    weights: dict[str, np.ndarray] = world.tables[species].species.nerves.brain.state()
    return {k: np.array(v) for k, v in weights.items()}


def first_of(folder: Path) -> dict[str, dict[str, np.ndarray]]:
    """Return the weights at the end of training."""
    from safetensors.numpy import load_file

    return {s: load_file(folder / f"{s}.safetensors") for s in LEARNERS}


def put(world: Any, policies: Mapping[str, Mapping[str, np.ndarray]]) -> Any:
    """Assign these policies to the species of a new world."""
    for s, weights in policies.items():
        world.tables[s].species.nerves.brain.load(dict(weights))
    return world


def swapped(
    config: dict[str, Any], shipped: Any, case: Mapping[str, Any], of: Mapping[str, Mapping[str, Any]]
) -> Result:
    """Run frozen pairs of initial and final policies, and measure them in the arena."""
    from ecs_eco import World

    lived, arenas = {}, {}
    for deer, wolf in itertools.product(ENDS, ENDS):
        pair = {"deer": of[deer]["deer"], "wolf": of[wolf]["wolf"]}
        world = put(World.from_config(shipped, seed=case["seed"], policies="untrained", learn=False), pair)
        while world.tick < config["swap ticks"] and all(world.tables[s].n for s in LEARNERS):
            world.run(min(50, config["swap ticks"] - world.tick))
        lived[f"{deer} deer, {wolf} wolves"] = world.tick
        arenas[f"{deer} deer, {wolf} wolves"] = counted(
            put(arena(case["seed"], False), pair), 0, config["arena ticks"]
        )
    answer = put(arena(case["seed"], True), {"deer": of["last"]["deer"], "wolf": of["last"]["wolf"]})
    return {
        "swaps": lived,
        "arena": arenas,
        "answer": counted(answer, config["answer ticks"], config["arena ticks"]),
    }


def arena(seed: int, learn: bool) -> Any:
    """Return the pre-training world, in which wolves or no species learn."""
    from ecs_eco import World
    from ecs_eco.config import for_training

    changes = {
        "species.deer.policy.learn": False,
        "species.wolf.policy.learn": learn,
        "species.wolf.ppo.anneal": 0,
    }
    config = for_training(frozen(changes))
    return World.from_config(config, seed=seed, policies="untrained", training=True)


def counted(world: Any, before: int, ticks: int) -> dict[str, float]:
    """Continue the run and measure its last `ticks`: deer caught per wolf per 100 ticks, and a deer's grass
    intake per 100 ticks [1/100 s]."""
    world.run(before + ticks)
    names = world.recorder.names
    table = world.series().select(["n", "taken_in", "died: eaten by wolf"]).to_pydict()
    n, taken, eaten = (np.asarray(v, float).reshape(-1, len(names))[-ticks:] for v in table.values())
    deer, wolf = names.index("deer"), names.index("wolf")
    return {
        "caught": float(100 * eaten[:, deer].sum() / n[:, wolf].sum()),
        "grazed": float(100 * taken[:, deer].sum() / n[:, deer].sum()),
    }


def brief(of: Result) -> Result:
    """Return a run's stored summary."""
    return {
        "persisted": of["persisted"],
        "lived": of["lived"],
        "extinct": of["extinct"],
        "cycled": bool(of["persisted"] and both_peaks(of)),
        "period": of["cycles"]["period"],
        "numbers": {
            s: {k: round(float(n[k]), 1) for k in ("mean", "least", "most")} for s, n in of["numbers"].items()
        },
        "series": of["series"],
    }


# --- statistics of the runs ---------------------------------------------------------------------------------


def persisted(results: Sequence[Result]) -> float:
    """Return the share of runs in which grass, deer and wolves persisted."""
    return float(np.mean([r["persisted"] for r in results]))


def fewest(result: Result) -> float:
    """Return ln(1 + the smallest number of wolves in a run)."""
    return float(np.log1p(result["numbers"]["wolf"]["least"]))


def pace(result: Result, species: str) -> float:
    """Return how many nats a policy moved per 1,000 ticks: the mean over all complete windows except the
    first, in which the policy leaves the averaged weights of training; NaN if there are no such windows."""
    later = result["moved"].get(species, [])[1:]
    return float(np.mean(later)) if later else float("nan")


def both_move(results: Sequence[Result], least: float) -> float:
    """Return the share of runs in which all species persisted and both policies moved at least `least`
    nats."""
    return float(np.mean([r["persisted"] and all(pace(r, s) >= least for s in LEARNERS) for r in results]))


def interval(cases: Sequence[Result], arm: str, share: Callable[[Sequence[Result]], float]) -> list[float]:
    """Return a share of an arm's runs and its 95% interval, with training seeds as replicates."""
    lives = [c["case"] | {"counts": share([c["result"]])} for c in cases if c["case"]["arm"] == arm]
    return share_of_lives(lives, "counts")


def gap(one: Sequence[float], other: Sequence[float]) -> list[float]:
    """Return the mean difference over pairs of training seeds, and its 95% interval (t)."""
    estimate = pooled([a - b for a, b in zip(one, other, strict=True)])
    return [estimate.mean, *estimate.interval95]


def by_training(cases: Sequence[Result], arm: str, value: Any) -> list[float]:
    """Return the mean of a value over world seeds, for each training seed."""
    of: dict[int, list[float]] = {}
    for c in cases:
        if c["case"]["arm"] == arm:
            of.setdefault(c["case"]["training"], []).append(float(value(c["result"])))
    return [float(np.mean(v)) for _, v in sorted(of.items())]


def caught(pair: str) -> Any:
    """Return a pair's catch per wolf in the arena; "answer" selects wolves that kept learning there."""
    return lambda r: (r["answer"] if pair == "answer" else r["arena"][pair])["caught"]


def lived(pair: str) -> Any:
    """Return a frozen pair's lifetime [ticks]."""
    return lambda r: r["swaps"][pair]


def summarise(cases: list[Result]) -> dict[str, Any]:
    """Return the registered comparisons, and a row for each arm."""
    arms = {arm: [c["result"] for c in cases if c["case"]["arm"] == arm] for arm in REGISTERED.arms}
    if not all(arms.values()):  # the short form omits some arms
        return {"verdicts": [verdict("arms that ran", sum(map(bool, arms.values())), "reported", True)]}
    return {
        "verdicts": judged(cases, arms) + told(arms),
        "table": {"head": HEAD, "rows": [row(arm, of) for arm, of in arms.items()]},
    }


def judged(cases: list[Result], arms: Mapping[str, list[Result]]) -> list[dict[str, Any]]:
    """Test the registered hypotheses."""

    def least(arm: str) -> list[float]:
        return by_training(cases, arm, fewest)

    def both(value: Any) -> list[float]:
        return by_training([c for c in cases if "swaps" in c["result"]], "both", value)

    fresh = both(caught("first deer, first wolves"))
    below = {
        "both": gap(least("both"), least("neither")),
        "deer": gap(least("deer"), least("neither")),
        "evasion": gap(both(caught("last deer, first wolves")), fresh),
        "forgetting": gap(both(caught("first deer, last wolves")), fresh),
        "swap": gap(both(lived("last deer, first wolves")), both(lived("first deer, last wolves"))),
    }
    lines = [REGISTERED.verdict(name, value, value[2] < 0) for name, value in below.items()]
    wolves, answer = persisted(arms["wolves"]), float(np.mean(both(caught("answer"))) / np.mean(fresh))
    moving = partial(both_move, least=CONFIG["nats"])
    regime, own = moving(arms["regime"]), persisted(arms["individual"])
    return lines + [
        REGISTERED.verdict("wolves", interval(cases, "wolves", persisted), wolves >= 0.8),
        REGISTERED.verdict("answer", answer, answer >= 0.8),
        REGISTERED.verdict("individual", interval(cases, "individual", persisted), own >= 0.8),
        REGISTERED.verdict("regime", interval(cases, "regime", moving), regime >= 0.8),
    ]


def told(arms: Mapping[str, list[Result]]) -> list[dict[str, Any]]:
    """Return the results without a goal, which come from the arena, the swaps and the search."""
    of = [r for r in arms["both"] if "swaps" in r]
    lines = [
        verdict(
            f"deer that a wolf catches in 100 ticks of the arena: {pair}",
            float(np.mean([caught(pair)(r) for r in of])),
            "reported",
            True,
        )
        for pair in PAIRS
    ]
    lines += [
        verdict(
            "the same: wolves that continued learning, against the last deer",
            float(np.mean([caught("answer")(r) for r in of])),
            "reported",
            True,
        )
    ]
    lines += [
        verdict(
            f"ticks that a frozen pair survives, of {CONFIG['swap ticks']:,}: {pair}",
            float(np.mean([lived(pair)(r) for r in of])),
            "reported",
            True,
        )
        for pair in PAIRS
    ]
    drawn = arms["search"]
    fit = sum(both_move([r], CONFIG["nats"]) for r in drawn)
    return [
        *lines,
        verdict(
            "candidates drawn from the ranges in which all species persist and both policies move as "
            "required, in one run each",
            f"{fit:.0f} of {len(drawn)}",
            "reported",
            True,
        ),
    ]


def row(arm: str, results: Sequence[Result]) -> list[Any]:
    """Return one row of the table."""
    gone = [r["extinct"] for r in results if r["extinct"]]
    paces = [[pace(r, s) for r in results if np.isfinite(pace(r, s))] for s in LEARNERS]
    return [
        arm,
        len(results),
        persisted(results),
        float(np.mean([r["cycled"] for r in results])),
        ", ".join(f"{s} {gone.count(s)}" for s in dict.fromkeys(gone)) or "–",
        float(np.median([r["lived"] for r in results])),
        *(float(np.median(nats)) if nats else None for nats in paces),
        *(float(np.mean([r["numbers"][s]["mean"] for r in results])) for s in ("grass", *LEARNERS)),
    ]


HEAD = [
    "arm",
    "runs",
    "share that persists",
    "share that also cycles",
    "first to die out",
    "median lifetime [ticks]",
    "change of the deer policy in 1,000 ticks [nats], median",
    "change of the wolf policy in 1,000 ticks [nats], median",
    "mean grass",
    "mean deer",
    "mean wolves",
]
PAIRS = [f"{deer} deer, {wolf} wolves" for deer, wolf in itertools.product(ENDS, ENDS)]


def all_cases() -> list[dict[str, Any]]:
    """Return every arm with its training and world seeds; each search candidate has its own seed."""
    seeds, out = REGISTERED.content["seeds"], []
    for arm, says in REGISTERED.arms.items():
        if arm == "search":
            out += [
                {"arm": arm, "training": seeds["training"][k % 5], "seed": seed}
                for k, seed in enumerate(seeds["search"])
            ]
        else:
            out += [
                {"arm": arm, "training": t, "seed": w}
                for w in seeds["world"][: says["worlds"]]
                for t in seeds["training"]
            ]
    return out


CONFIG = {
    "small": QUARTER,
    "ticks": REGISTERED.content["ticks"],
    "nats": 0.05,
    "training ticks": None,
    "arms": REGISTERED.arms,
    "swap seed": REGISTERED.content["seeds"]["world"][0],
    "search": REGISTERED.content["search"],
    **REGISTERED.content["after"],
}
STUDY = Study(
    name="full_rate",
    claim=REGISTERED.content["claim"],
    registered=REGISTERED,
    config=CONFIG,
    cases=all_cases(),
    run=run,
    summarise=summarise,
    short_cases=[{"arm": "both", "training": 1, "seed": 1}, {"arm": "search", "training": 1, "seed": 1}],
    short_config={
        "swap seed": 1,
        "ticks": 100,
        "training ticks": 8,
        "swap ticks": 30,
        "arena ticks": 30,
        "answer ticks": 30,
        "small": {
            "space.size": [60.0, 60.0],
            "species.grass.count": 270,
            "species.deer.count": 44,
            "species.wolf.count": 12,
        },
    },
)

if __name__ == "__main__":
    STUDY.main()
