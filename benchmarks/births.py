"""Measure births per second: crossover and mutation of many genomes at once, or one by one through DEAP's
functions.

    python benchmarks/births.py [--births 100000]
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numpy as np
from deap import tools

from ecs_eco.genomes import Gene, Layout, Operators, toolbox_of

OPERATORS = {"mate": {"operator": "cxTwoPoint"}, "mutate": {"operator": "mutUniformInt", "indpb": 0.005}}
GOAL = {"at once": 50_000, "one by one": 5_000}


def births_per_second(loci: int, n: int, at_once: bool, repeats: int) -> float:
    """Return births per second of wall-clock time, with this many loci per genome and n births per call."""
    layout = Layout([Gene(name="trait", letters=4, low=0.0, high=1.0)], loci=loci)
    toolbox = toolbox_of(OPERATORS, layout)
    if not at_once:  # mutations that DEAP lacks cannot be compared
        toolbox.register("mate", lambda a, b: tools.cxTwoPoint(a, b))
        toolbox.register("mutate", lambda a, indpb: tools.mutUniformInt(a, 0, 3, indpb), indpb=0.005)
    operators = Operators(toolbox, layout)
    keys = np.arange(n, dtype=np.uint64)
    mothers, fathers = layout.random(keys), layout.random(keys + np.uint64(n))
    operators.offspring(mothers[:2], fathers[:2], keys[:2])  # compiles
    return n / _bench.best_of(lambda: operators.offspring(mothers, fathers, keys), repeats)


def main() -> None:
    """Measure both methods at two genome lengths."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--births", type=int, default=100_000)
    n = parser.parse_args().births
    rows = []
    for loci in (64, 512):
        for way in GOAL:
            at_once = way == "at once"
            rate = births_per_second(loci, n if at_once else max(n // 50, 10), at_once, 5 if at_once else 3)
            rows.append({"loci": loci, "births": way, "births/s": rate, "goal": GOAL[way]})
    _bench.save(
        "births",
        "Births with two-point crossover and mutation (4 letters, 0.005 per locus), on one core",
        rows,
    )


if __name__ == "__main__":
    main()
