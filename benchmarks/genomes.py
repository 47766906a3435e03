"""Measure the cost of genomes: worlds without genomes and with genomes whose genes are not read alternate
every few ticks.

    python benchmarks/genomes.py [--sizes 1000 10000] [--pairs 9]

Animals share a policy, do not learn, mate and die of old age; food is plentiful, and births replace dead
animals. The genes have no effect, so all worlds have the same animals, births and deaths; the script checks
this.
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

from ecs_eco import World
from ecs_eco.components import Biology

GOAL = 1.10
LOCI = 64
TRAITS: list[dict[str, Any]] = [
    {"name": "legs", "trait": "locomotion.pace", "letters": 4, "low": 0.5, "high": 2.0},
    {"name": "span", "trait": "life.age_max", "letters": 4, "low": 100.0, "high": 400.0},
    {"name": "ripe", "trait": "reproduction.energy_min", "letters": 4, "low": 0.2, "high": 0.6},
]
EYE = {"name": "eye", "trait": "sensors.plant.range", "letters": 4, "low": 1.0, "high": 6.0}
GENES = {
    "a marker": [{"name": "marker", "letters": 4, "low": 0.0, "high": 1.0}],
    "3 traits, neutral-drift": TRAITS,
    "3 traits and a sense, neutral-drift": [*TRAITS, EYE],  # individual ranges use a different code path
}


def meadow(animals: int, genes: list[dict[str, Any]] | None) -> dict[str, Any]:
    """Return the benchmarks' world without hunting and with sexual reproduction; if `genes` is None, animals
    have no genomes."""
    config = _bench.savanna(animals)
    for name in ("grazer", "hunter"):
        species = config["species"][name]
        species |= {
            "max_count": species["count"],
            "diet": [{"eats": "plant", "reach": 0.5, "gain": 0.8}],
            "lethal": [
                {"property": "energy", "min": 0.0, "cause_below": "starved"},
                {"property": "age", "max": 200.0, "cause_above": "too old"},
            ],
            "reproduction": {
                "kind": "sexual",
                "energy_min": 0.4,
                "energy_given": 0.1,
                "age_min": 20.0,
                "reach": 8.0,
                "consent": "none",
                "rest": 10.0,
                "place": "near",
            },
        }
        if genes is not None:
            species["genome"] = {"loci": LOCI, "genes": genes}
    return config


def build(animals: int, genes: str | None) -> World:
    """Return a world whose founders have all ages, shortly after its start."""
    controls = () if genes is None else ("neutral-drift",)
    config = meadow(animals, None if genes is None else GENES[genes])
    world = World.from_config(config, seed=1, policies="untrained", controls=controls)
    for name in ("grazer", "hunter"):
        table = world.tables[name]
        table[Biology].age[table.rows()] = table.uid[table.rows()] % 200
    return world.run(40)


def numbers(world: World) -> tuple[int, int]:
    """Return the numbers of living animals and births."""
    series = world.series().to_pydict()
    mine = [i for i, s in enumerate(series["species"]) if s != "plant"]
    return (
        sum(t.n for name, t in world.tables.items() if name != "plant"),
        sum(series["births"][i] for i in mine),
    )


def measure(animals: int, pairs: int, ticks: int) -> list[dict[str, Any]]:
    """Time worlds without and with genomes alternately; return the ratios of times for the same ticks."""
    worlds = {way: build(animals, way) for way in (None, *GENES)}
    times: dict[str | None, list[float]] = {way: [] for way in worlds}
    before = numbers(worlds[None])[1]
    for pair in range(pairs):
        for way in list(worlds)[:: 1 if pair % 2 else -1]:
            start = time.process_time()  # not wall-clock time: other work may share the core
            worlds[way].run(ticks)
            times[way].append((time.process_time() - start) / ticks)
    living, born = numbers(worlds[None])
    assert all(numbers(world) == (living, born) for world in worlds.values()), (
        "genomes without effect changed the world"
    )
    rows = []
    for way in GENES:
        ratio = np.array(times[way]) / np.array(times[None])
        low, middle, high = np.quantile(ratio, (0.25, 0.5, 0.75))
        rows.append(
            {
                "animals": living,
                "genome": f"{LOCI} loci, {way}",
                "births per tick": (born - before) / pairs / ticks,
                "ms per tick": float(np.median(times[way])) * 1e3,
                "without": float(np.median(times[None])) * 1e3,
                "ratio": float(middle),
                "quartiles": f"{low:.3f} … {high:.3f}",
                "pairs": pairs,
                "goal": f"≤ {GOAL}",
            }
        )
    return rows


def main() -> None:
    """Measure all sizes."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[1000, 10_000])
    parser.add_argument("--pairs", type=int, default=9)
    options = parser.parse_args()
    rows = [row for n in options.sizes for row in measure(n, options.pairs, max(20, 200_000 // n))]
    _bench.save(
        "genomes",
        "A tick with genomes against a tick without genomes, with a shared policy, on one core",
        rows,
    )


if __name__ == "__main__":
    main()
