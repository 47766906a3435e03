"""Compare Mesa 3.5's WolfSheep with the same rules in ecs-eco: speed, and whether populations agree.

    python benchmarks/wolf_sheep.py [--seeds 20] [--short]

The two models take turns in one process, with data collection enabled; the ecs-eco model is
wolf_sheep_model.py. Times are processor times, which are less affected by other work on the machine. The
script needs Python 3.12 and Mesa: pip install -e '.[bench]'.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numpy as np
import wolf_sheep_model as model
from scipy import stats

from ecs_eco import Table, World

COEXISTING = {
    "sheep_reproduce": 0.2,
    "wolf_reproduce": 0.05,
    "sheep_gain": 4.0,
    "wolf_gain": 5.0,
    "regrowth": 10,
}
# by tick 60, nearly all animals are dead in Mesa's default model
REGIMES = {"default": model.DEFAULT, "coexisting": COEXISTING}
SIZES = {20: (60, 10), 100: (60, 1), 300: (10, 1)}  # width: ticks, and factor for the number of seeds
WRONG = {
    "regrowth is one tick early": ("regrowth", lambda v: v - 1),
    "sheep bear 10% more often": ("sheep_reproduce", lambda v: 1.1 * v),
    "wolves gain 10% more": ("wolf_gain", lambda v: 1.1 * v),
}
COUNTED = ("sheep", "wolves", "grass")


def mesa(width, ticks, seed, p):
    """Return Mesa's counts, i64[ticks + 1, 3], and the ticks' duration [s]."""
    try:
        from mesa.examples.advanced.wolf_sheep.model import WolfSheep, WolfSheepScenario
    except ImportError:
        sys.exit("this benchmark also runs Mesa 3.5: pip install -e '.[bench]', on Python 3.12 or newer")
    world = WolfSheep(
        WolfSheepScenario(
            height=width,
            width=width,
            initial_sheep=width * width // 4,
            initial_wolves=width * width // 8,
            rng=seed,
            sheep_reproduce=p["sheep_reproduce"],
            wolf_reproduce=p["wolf_reproduce"],
            wolf_gain_from_food=p["wolf_gain"],
            sheep_gain_from_food=p["sheep_gain"],
            grass_regrowth_time=p["regrowth"],
        )
    )
    start = time.process_time()
    for _ in range(ticks):
        world.step()
    seconds = time.process_time() - start
    return world.datacollector.get_model_vars_dataframe()[["Sheep", "Wolves", "Grass"]].to_numpy(), seconds


def ours(width, ticks, seed, p, enough=0.0):
    """Return ecs-eco's counts and the mean duration [s] of identical runs, repeated until they take `enough`
    seconds."""
    spent, runs = 0.0, 0
    while runs == 0 or spent < enough:
        world, collect = model.build(width, seed, p)
        world.flush()  # initial animals count as newborns, because Mesa's exist when its clock starts
        start = time.process_time()
        world.run(ticks)
        spent, runs = spent + time.process_time() - start, runs + 1
    return np.array(collect.series), spent / runs


def compare(a, b, ticks):
    """Return the smallest Holm-corrected KS p for counts [seeds, ticks + 1, 3], and bounds on differences
    between means.

    The bounds are the extreme ends of the 90% intervals (equivalence by two one-sided tests at 0.05), in
    standard deviations between seeds and, if Mesa's mean is at least 100, as shares of that mean.
    """
    p, in_sd, in_share = [], [0.0], [0.0]
    for t in [t for t in (1, 2, 5, 10, 20, 40, 60) if t <= ticks]:
        for i in range(3):
            x, y = a[:, t, i].astype(float), b[:, t, i].astype(float)
            p.append(stats.ks_2samp(x, y).pvalue)
            sd = np.sqrt((x.var(ddof=1) + y.var(ddof=1)) / 2)
            error = sd * np.sqrt(1 / len(x) + 1 / len(y))
            edge = abs(x.mean() - y.mean()) + stats.t.ppf(0.95, len(x) + len(y) - 2) * error
            if sd > 0:
                in_sd.append(edge / sd)
            if x.mean() >= 100:
                in_share.append(edge / x.mean())
    holm = np.maximum.accumulate(np.sort(p) * np.arange(len(p), 0, -1))
    return {
        "tests": len(p),
        "smallest p (Holm)": min(1.0, float(holm[0])),
        "means within, SD": float(max(in_sd)),
        "means within, %": 100 * float(max(in_share)),
    }


def case(regime, width, ticks, seeds):
    """Run both models alternately, seed by seed; return the rows of the two tables."""
    p = REGIMES[regime]
    ours(width, ticks, 0, p)  # compile
    pairs = []
    for seed in range(1, seeds + 1):
        theirs = mesa(width, ticks, seed, p)
        pairs.append((*theirs, *ours(width, ticks, seed + 10_000, p, min(theirs[1], 1.0))))
    a, b = np.array([x[0] for x in pairs]), np.array([x[2] for x in pairs])
    t, u = np.array([x[1] for x in pairs]), np.array([x[3] for x in pairs])
    n, m = a[:, :-1, :2].sum((1, 2)), b[:, :-1, :2].sum((1, 2))  # organism-steps
    ratio = (t / n) / (u / m)
    low, middle, high = np.quantile(ratio, (0.25, 0.5, 0.75))
    where = {"regime": regime, "cells": f"{width}²", "ticks": ticks, "seeds": seeds}
    speed = where | {
        "animals": float(n.mean() / ticks),
        "Mesa, µs per tick": float(np.median(t) / ticks * 1e6),
        "ecs-eco, µs per tick": float(np.median(u) / ticks * 1e6),
        "ratio by tick": float(np.median(t / u)),
        "ratio by organism-step": float(middle),
        "quartiles": f"{low:.0f}-{high:.0f}",
    }
    same = where | compare(a, b, ticks)
    for name, (key, change) in WRONG.items():
        wrong = p | {key: change(p[key])}
        c = np.array([ours(width, ticks, seed + 20_000, wrong)[0] for seed in range(1, seeds + 1)])
        same |= {f"p if {name}": compare(a, c, ticks)["smallest p (Holm)"]}
    print(speed, same, flush=True)
    return speed, same


def profile(regime, width=20, ticks=60, repeats=40):
    """Return the time of each part of a tick: the shortest of identical calls in identical runs, minus the
    clock's overhead."""
    clock = time.perf_counter
    own = min(-(clock() - clock()) for _ in range(1000))

    def measure(holder, name):
        part, calls = getattr(holder, name), []

        def timed(*arguments, **options):
            start = clock()
            result = part(*arguments, **options)
            calls.append(clock() - start - own)
            return result

        setattr(holder, name, timed)
        for _ in range(repeats):
            world, _collect = model.build(width, 1, REGIMES[regime])
            world.flush()
            world_calls = len(calls)
            world.run(ticks)
            runs.append(calls[world_calls:])
        setattr(holder, name, part)
        best = np.min(runs, axis=0)
        runs.clear()
        return {"calls per tick": len(best) / ticks, "µs per tick": float(best.sum() / ticks * 1e6)}

    runs: list[list[float]] = []
    parts = {
        "all": (World, "run"),
        "Live.process": (model.Live, "process"),
        "  the kernel": (model, "live"),
        "  Table.request": (Table, "request"),
        "World.flush_deaths": (World, "_flush_deaths"),
        "World.flush_births": (World, "_flush_births"),
        "  Table.occupy": (Table, "occupy"),
        "Collect.process": (model.Collect, "process"),
    }
    return [{"regime": regime, "part": part} | measure(*where) for part, where in parts.items()]


def main() -> None:
    """Measure all sizes in both regimes."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--short", action="store_true", help="only 20² cells and 3 seeds; write no results")
    options = parser.parse_args()
    sizes, seeds = ({20: (10, 1)}, 3) if options.short else (SIZES, options.seeds)
    cases = [case(r, width, ticks, seeds * more) for width, (ticks, more) in sizes.items() for r in REGIMES]
    if options.short:
        _bench.RESULTS = Path(tempfile.mkdtemp())
    speed, same = zip(*cases, strict=True)
    missed = [f"{r['regime']} {r['cells']}" for r in speed if r["ratio by organism-step"] < 100]
    _bench.save(
        "wolf_sheep",
        "Mesa 3.5's WolfSheep and the same rules in ecs-eco",
        list(speed),
        {"less than 100 times as fast": missed},
    )
    _bench.save("wolf_sheep_same", "Populations of WolfSheep in Mesa and in ecs-eco", list(same))
    _bench.save(
        "wolf_sheep_profile",
        "Parts of a tick of WolfSheep at 20² cells",
        [row for regime in REGIMES for row in profile(regime)],
    )


if __name__ == "__main__":
    main()
