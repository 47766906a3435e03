"""Measure births per second with genomes of variable length: unequal crossover; duplicated and deleted genes;
inserted, deleted and changed letters; all at once, or one by one through functions with DEAP's signature.

    python benchmarks/variable_births.py [--births 50000]

Parents come from 30 generations of random mating, so that their strings differ in length and gene copies.
These births alternate with births whose genomes have the same genes on strings of fixed length.
"""

import argparse
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numpy as np
from deap import tools

from ecs_eco.genomes import layout_of, operators_of
from ecs_eco.genomes.models import GenomeSection
from ecs_eco.genomes.unequal import UnequalCrossover

GOAL = 300_000  # births per second, all at once
RATES = {"insertion": 0.001, "deletion": 0.001, "duplication": 0.02, "loss": 0.002}
MUTATE = {"operator": "mutUniformInt", "indpb": 0.001}
LETTERS = 4  # probabilities per codon, one for each gene


def section(letters: int, ploidy: int, variable: bool) -> GenomeSection:
    """Return a genome with as many genes as fit in this number of letters, with promoters of 4 or 5
    letters."""
    genes = [{"name": f"g{i}", "letters": LETTERS, "low": 0.0, "high": 1.0} for i in range(letters // 10)]
    if not variable:
        return GenomeSection(genes=genes, loci=letters, ploidy=ploidy, mutate=MUTATE)
    return GenomeSection(
        genes=genes, loci=letters, longest=2 * letters, ploidy=ploidy, mutate=MUTATE, **RATES
    )


def parents(operators: Any, n: int, seed: int) -> np.ndarray:
    """Return n genomes produced by 30 generations of random mating."""
    keys, rng = np.arange(n, dtype=np.uint64), np.random.default_rng(seed)
    loci = operators.layout.random(keys + np.uint64(seed * n))
    for generation in range(30 if operators.layout.longest is not None else 0):
        salt = np.uint64((1 + generation + 100 * seed) * n)
        loci = operators.offspring(loci, loci[rng.permutation(n)], keys + salt)
    return loci


def timed(operators: Any, mothers: np.ndarray, fathers: np.ndarray, keys: np.ndarray) -> float:
    """Return the processor seconds of one call; wall-clock time would include other work on the core."""
    start = time.process_time()
    operators.offspring(mothers, fathers, keys)
    return time.process_time() - start


def at_once(letters: int, ploidy: int, n: int, turns: int) -> list[dict[str, Any]]:
    """Measure strings of variable and fixed length alternately."""
    made = {}
    for variable in (True, False):
        of = section(letters, ploidy, variable)
        operators = operators_of(of, layout_of(of))
        made[variable] = operators, parents(operators, n, 1), parents(operators, n, 2)
    keys = np.arange(n, dtype=np.uint64)
    seconds: dict[bool, list[float]] = {True: [], False: []}
    for _ in range(turns):
        for variable, (operators, mothers, fathers) in made.items():
            seconds[variable].append(timed(operators, mothers, fathers, keys))
    lengths = made[True][0].layout.lengths(made[True][1])
    name = f"{lengths.mean():.0f} letters on average ({lengths.min()} to {lengths.max()})"
    return [
        {
            "strings": name if variable else f"{letters} letters, fixed",
            "ploidy": ploidy,
            "births": "at once",
            "births/s": n / min(seconds[variable]),
            "goal": GOAL if variable and ploidy == 1 else "",
        }
        for variable in (True, False)
    ]


def one_by_one(letters: int, n: int) -> dict[str, Any]:
    """Measure the same births through a function with DEAP's signature, and through DEAP's own mutation."""
    of = section(letters, 1, True)
    operators = operators_of(of, layout_of(of))
    crossing = UnequalCrossover(operators.layout)
    operators.toolbox.register("mate", lambda a, b: crossing(a, b))
    operators.toolbox.register("mutate", lambda a, indpb: tools.mutUniformInt(a, 0, 3, indpb), indpb=0.001)
    mothers, fathers, keys = parents(operators, n, 1), parents(operators, n, 2), np.arange(n, dtype=np.uint64)
    seconds = min(timed(operators, mothers, fathers, keys) for _ in range(3))
    mean = operators.layout.lengths(mothers).mean()
    return {
        "strings": f"{mean:.0f} letters on average",
        "ploidy": 1,
        "births": "one by one",
        "births/s": n / seconds,
        "goal": "",
    }


def main() -> None:
    """Measure two lengths, each with one and with two strings."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--births", type=int, default=50_000)
    n = parser.parse_args().births
    rows = [row for letters in (64, 128) for ploidy in (1, 2) for row in at_once(letters, ploidy, n, 7)]
    rows.append(one_by_one(64, max(n // 50, 10)))
    _bench.save(
        "variable_births",
        "Births with strings of variable length, with unequal crossover and five mutations, on one core",
        rows,
    )


if __name__ == "__main__":
    main()
