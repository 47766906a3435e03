"""Training seed × world seed: for each arm of a protocol, every policy in the grid lives in every world in
the grid.

    STUDY = crossed_study("persistence", "…", arms={"shipped": {}, "in life": {"life": {…}, "learn": True}},
                          training=range(11, 17), worlds=range(4001, 4006), ticks=20_000)

    if __name__ == "__main__":
        STUDY.main()

`python -m studies.persistence --workers 2` trains each policy once, runs the missing cells, and resumes where
it stopped. A cell's key contains its arm, seeds and length and a hash of the arm's content, so adding an arm
leaves the results of other arms valid. An arm may have these keys, all optional:

    set        changes to the world, in training and in life: {"species.deer.count": 500}
    train      changes in training only
    life       changes in life only
    learn      whether policies continue to learn in life, at a constant rate; default: as in the world file
    training_ticks    length of training; default: the world's own
    policies   "random", "untrained" or a folder instead of trained policies;
               the training seed is then only a replicate
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.moved import Policies, rates
from studies.common.policies import trained, without_policies
from studies.common.predator_prey import frozen
from studies.common.study import Study, canonical, verdict

BLOCK = 40  # [ticks] averaged into each stored mean
CHUNK = 250  # [ticks] between checks for extinctions
SAYS = ("set", "train", "life", "learn", "training_ticks", "policies")
LAGS = {"deer→wolf": (0.20, 0.35), "grass→deer": (0.28, 0.50)}
Entry = dict[str, Any]


# --- the grid -----------------------------------------------------------------------------------------------


def crossed_study(
    name: str,
    claim: str,
    arms: Mapping[str, Mapping[str, Any]],
    training: Iterable[int],
    worlds: Iterable[int],
    *,
    world: str = "predator-prey",
    ticks: int = 20_000,
    judged: Sequence[str] = (),
    also: Sequence[Mapping[str, Any]] = (),
    goal: float = 0.8,
    short: Mapping[str, Any] | None = None,
) -> Study:
    """Return a study of all cells; at least a share `goal` of the runs must persist in each arm in `judged`
    (by default the first).

    `also` contains further cases without a goal, such as one long run: {"arm": …, "training": …, "seed": …,
    "ticks": 60_000}.
    """
    training, worlds = list(training), list(worlds)
    for arm, says in arms.items():
        if odd := sorted(set(says) - set(SAYS)):
            raise ValueError(f"arm {arm!r}: unknown key {odd[0]!r}; expected {', '.join(SAYS)}")
    judged = list(judged) or [next(iter(arms))]
    config = {
        "world": world,
        "identity": _hash(without_policies(_load(world, {}))),
        "ticks": ticks,
        "block": BLOCK,
        "arms": {k: dict(v) for k, v in arms.items()},
        "judged": judged,
        "goal": goal,
        "training seeds": training,
        "world seeds": worlds,
    }
    few = [{"arm": arm, "training": training[0], "seed": worlds[0]} for arm in list(arms)[:2]]
    return Study(
        name=name,
        claim=claim,
        config=config,
        cases=[*cells(arms, training, worlds), *also],
        run=cell,
        depends=depends,
        summarise=lambda entries: summarise(entries, judged, goal),
        short_cases=few,
        short_config={"ticks": 1000, "short training": 100, **(short or {})},
    )


def cells(arms: Iterable[str], training: Sequence[int], worlds: Sequence[int]) -> list[dict[str, Any]]:
    """Return all cells, ordered by world seed, so that two workers never train the same policy and partial
    results are balanced."""
    return [{"arm": arm, "training": t, "seed": w} for w in worlds for arm in arms for t in training]


def depends(config: Mapping[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the configuration entries that a cell depends on."""
    kept = {k: config.get(k) for k in ("world", "identity", "block", "short training")}
    return kept | {"ticks": case.get("ticks", config["ticks"]), "arm": config["arms"][case["arm"]]}


# --- one cell -----------------------------------------------------------------------------------------------


def cell(config: Mapping[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Train or reuse a cell's policies, run its world, and return every species' outcome. Species that learn
    in life have a constant learning rate."""
    from ecs_eco.config.loading import changed

    says = config["arms"][case["arm"]]
    living = _load(config["world"], says.get("set", {}) | says.get("life", {}))
    if says.get("learn"):
        constant = {
            f"species.{name}.ppo.anneal": 0 for name, of in living.species.items() if of.policy.thinks
        }
        living = changed(living, constant)
    ticks = case.get("ticks", config["ticks"])
    policies = says.get("policies") or str(policies_of(config, says, case["training"]))
    began: list[Policies] = []
    world = live(
        living, case["seed"], policies, ticks, says.get("learn"), lambda world: began.append(Policies(world))
    )
    moved = {"moved": rates(began[0].moved(), world.tick)} if says.get("learn") else {}
    return record(world, living) | moved


def policies_of(config: Mapping[str, Any], says: Mapping[str, Any], seed: int) -> Path:
    """Return a folder with the policies of one training seed under an arm's protocol: newly trained, or
    stored earlier."""
    world = _load(config["world"], says.get("set", {}) | says.get("train", {}))
    return trained(world, seed, config.get("short training") or says.get("training_ticks"))


def live(
    config: Any,
    seed: int,
    policies: Any,
    ticks: int,
    learn: bool | None,
    begin: Callable[[Any], object] = lambda world: None,
) -> Any:
    """Run a world for `ticks` ticks or until a consumer goes extinct for good, which is checked every CHUNK
    ticks. `begin` is called with the world before its first tick."""
    from ecs_eco import World
    from ecs_eco.analysis.cycles import consumers

    world = World.from_config(config, seed=seed, policies=policies, learn=learn)
    begin(world)
    mortal = [s for s in consumers(config.resolved()) if world.tables[s].n]
    while world.tick < ticks and all(world.tables[s].n for s in mortal):
        world.run(min(CHUNK, ticks - world.tick))
    return world


def record(world: Any, config: Any) -> dict[str, Any]:
    """Return a cell's stored result: which species persisted, when and why the other species went extinct,
    population sizes, deaths, and cycles."""
    from dataclasses import asdict

    from ecs_eco.analysis.cycles import consumers, cycle_statistics
    from ecs_eco.analysis.extinction import declines, lifetime
    from ecs_eco.analysis.runs import load_series

    series = load_series(world.series())
    lost, lived = declines(series), lifetime(series)[0]
    statistics = cycle_statistics(series, period_of=consumers(config.resolved())).as_dict()
    n, names = series.n, series.species
    died = {s: {c: int(k) for c in series.causes if (k := series.of(s, f"died: {c}").sum())} for s in names}
    return {
        "persisted": series.persisted,
        "lived": lived if lost else float(len(series.ticks)),
        "extinct": lost[0].species if lost else None,
        "ends": [asdict(d) for d in lost],
        "deaths": died,
        "numbers": {
            s: {
                "mean": n[:, i].mean(),
                "mean log": np.log1p(n[:, i]).mean(),
                "least": n[:, i].min(),
                "most": n[:, i].max(),
                "end": n[-1, i],
            }
            for i, s in enumerate(names)
        },
        "cycles": statistics,
        "periods": statistics["ticks"] / statistics["period"] if statistics["period"] else 0.0,
        "series": packed(n, names),
    }


def packed(n: np.ndarray, names: Sequence[str]) -> dict[str, str]:
    """Return means over blocks of ticks as text, one line of JSON per species."""
    kept = n[: len(n) // BLOCK * BLOCK].reshape(-1, BLOCK, n.shape[1]).mean(1)
    return {name: " ".join(f"{v:.0f}" for v in kept[:, i]) for i, name in enumerate(names)}


# --- statistics of the cells ---------------------------------------------------------------------------------


def summarise(
    entries: Sequence[Entry],
    judged: Sequence[str],
    goal: float,
    lags: Mapping[str, tuple[float, float]] = LAGS,
) -> dict[str, Any]:
    """Return the verdicts on the judged arms, and a table of all arms."""
    of: dict[str, list[Entry]] = {}
    for e in entries:
        if "ticks" not in e["case"]:
            of.setdefault(e["case"]["arm"], []).append(e)
    out = [line for arm in judged if arm in of for line in verdicts(arm, of[arm], goal, lags)]
    for e in entries:
        if "ticks" in e["case"]:
            r, case = e["result"], e["case"]
            out.append(
                verdict(
                    f"{case['arm']}, training seed {case['training']}, world seed {case['seed']}: "
                    f"periods in one run of {case['ticks']:,} ticks",
                    r["periods"],
                    "at least 50, and all species persist",
                    r["persisted"] and r["periods"] >= 50,
                )
            )
    head = [
        "arm",
        "runs",
        "share that persists (95%, both seeds as replicates)",
        "runs that persist, by training seed",
        "first to die out",
        "runs with peaks of all consumers beyond AR(1), of those that persist",
        "median period [ticks]",
        *lags,
    ]
    return {
        "verdicts": out,
        "table": {"head": head, "rows": [row(arm, results, lags) for arm, results in of.items()]},
        "variance": {arm: variance(results) for arm, results in of.items()},
        "notes": "\n\n".join(map(variance_sentence, of.values())),
    }


def both_peaks(result: Mapping[str, Any], level: float = 0.05) -> bool:
    """Return whether deer and wolves (all consumers) have a spectral peak beyond AR(1)."""
    p = [result["cycles"]["p_ar1"].get(s) for s in result["cycles"]["period_of"]]
    return bool(p) and all(v is not None and v < level for v in p)


def verdicts(
    arm: str, entries: Sequence[Entry], goal: float, lags: Mapping[str, tuple[float, float]]
) -> list[dict[str, Any]]:
    """Return verdicts on persistence over the grid, and on peaks and lags in runs in which all species
    persist."""
    from ecs_eco.analysis.cycles import median_lag_interval
    from ecs_eco.analysis.seed_grid import share_interval

    results = [e["result"] for e in entries]
    kept = [r for r in results if r["persisted"]]
    share, cycling = len(kept) / len(results), sum(map(both_peaks, kept))
    table = grid(entries, lambda r: r["persisted"])
    ends = share_interval(table) if np.isfinite(table).all() else None
    between = f", {ends.low:.0%} to {ends.high:.0%}" if ends else ""
    out = [
        verdict(
            f"{arm}: runs in which all species persist",
            f"{len(kept)} of {len(results)} ({share:.0%}{between})",
            f"at least {goal:.0%}",
            share >= goal,
        ),
        verdict(
            f"{arm}: of these, runs with peaks of all consumers beyond AR(1), p < 0.05",
            f"{cycling} of {len(kept)}",
            f"at least {goal:.0%}",
            bool(kept) and cycling >= goal * len(kept),
        ),
    ]
    for pair, (low, high) in lags.items():
        m = median_lag_interval(
            [r["cycles"]["lags"][pair]["share"] for r in kept if pair in r["cycles"]["lags"]]
        )
        out.append(
            verdict(
                f"{arm}: median lag {pair}, as a share of the period",
                [m["median"], m["low"], m["high"]],
                f"{low} to {high}",
                bool(m["n"]) and low <= m["median"] <= high,
            )
        )
    moved = [r["moved"] for r in results if r.get("moved")]
    for name in dict.fromkeys(name for one in moved for name in one):
        nats = [one[name] for one in moved if one.get(name) is not None]
        out.append(
            verdict(
                f"{arm}: change of the {name} policy in 1,000 ticks [nats], median of runs "
                "(KL divergence of the first policy from the last)",
                float(np.median(nats)) if nats else None,
                "reported",
                True,
            )
        )
    return out


def grid(entries: Sequence[Entry], value: Any) -> np.ndarray:
    """Return a value for every cell of an arm, f64[training seeds, world seeds]; NaN for a missing cell."""
    rows, columns = (sorted({e["case"][key] for e in entries}) for key in ("training", "seed"))
    out = np.full((len(rows), len(columns)), np.nan)
    for e in entries:
        outcome = value(e["result"])
        out[rows.index(e["case"]["training"]), columns.index(e["case"]["seed"])] = (
            np.nan if outcome is None else outcome
        )
    return out


def variance(entries: Sequence[Entry]) -> dict[str, Any]:
    """Return the shares of variance in an arm's outcomes due to training seed, world seed and residual:
    [value, low, high] each."""
    from ecs_eco.analysis.seed_grid import EFFECTS, variance_shares

    names = list(entries[0]["result"]["numbers"])
    tables = {
        "persisted": grid(entries, lambda r: r["persisted"]),
        "log time to first extinction": grid(entries, lambda r: np.log(max(r["lived"], 1))),
        "log period": grid(
            entries,
            lambda r: np.log(r["cycles"]["period"]) if r["persisted"] and r["cycles"]["period"] else None,
        ),
        **{
            f"mean log number of {s}": grid(entries, lambda r, s=s: r["numbers"][s]["mean log"])
            for s in names
        },
    }
    out = {}
    for name, table in tables.items():
        if min(table.shape) > 1 and np.isfinite(table).sum() > max(table.shape):
            shares = variance_shares(table)
            out[name] = {
                "n": shares.n,
                "mean": shares.mean,
                **{k: list(v) for k, v in zip(EFFECTS, shares.share, strict=True)},
            }
    return out


def variance_sentence(entries: Sequence[Entry]) -> str:
    """Return a sentence on the sources of one arm's variance."""
    arm, shares = entries[0]["case"]["arm"], variance(entries)
    parts = [
        f"{name}: training seed {x['training seed'][0]:.0%}, world seed {x['world seed'][0]:.0%}, "
        f"rest {x['rest'][0]:.0%}"
        for name, x in shares.items()
        if np.isfinite(x["rest"][0])
    ]
    words = "; ".join(parts) or "no outcome varies, or there are too few seeds"
    return f"{arm}, shares of variance (persistence as 0 and 1): {words}."


def row(arm: str, entries: Sequence[Entry], lags: Mapping[str, Any]) -> list[Any]:
    """Return one row of the table."""
    from ecs_eco.analysis.cycles import median_lag_interval
    from ecs_eco.analysis.seed_grid import share_interval

    results = [e["result"] for e in entries]
    kept = [r for r in results if r["persisted"]]
    table = grid(entries, lambda r: r["persisted"])
    share = list(share_interval(table)) if np.isfinite(table).all() else None
    each = ", ".join(f"{np.nansum(line):.0f}/{np.isfinite(line).sum()}" for line in table)
    gone = [r["extinct"] for r in results if r["extinct"]]
    who = ", ".join(f"{s} {gone.count(s)}" for s in dict.fromkeys(gone)) or "–"
    periods = [r["cycles"]["period"] for r in kept if r["cycles"]["period"]]
    m = [
        median_lag_interval([r["cycles"]["lags"][pair]["share"] for r in kept if pair in r["cycles"]["lags"]])
        for pair in lags
    ]
    return [
        arm,
        len(results),
        share,
        each,
        who,
        f"{sum(map(both_peaks, kept))} of {len(kept)}",
        float(np.median(periods)) if periods else None,
        *([v["median"], v["low"], v["high"]] if v["n"] else None for v in m),
    ]


# --- keys of stored cells -------------------------------------------------------------------------------------


def _load(world: str, changes: Mapping[str, Any]) -> Any:
    from ecs_eco.config import load

    return frozen(changes) if world == "predator-prey" else load(world, dict(changes) or None)


def _hash(x: Any) -> str:
    return hashlib.sha256(canonical(x).encode()).hexdigest()[:24]


def by_training(entries: list[dict[str, Any]], arm: str) -> dict[int, list[dict[str, Any]]]:
    """Return an arm's results by training seed."""
    out: dict[int, list[dict[str, Any]]] = {}
    for e in entries:
        if e["case"]["arm"] == arm:
            out.setdefault(e["case"]["training"], []).append(e["result"])
    return out
