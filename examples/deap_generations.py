"""Generations with DEAP: a genome's fitness is the mean lifetime in a world. The genome encodes reflexes that
find grass.
"""

import random

import numpy as np
from deap import algorithms, base, creator, tools

from ecs_eco import World
from ecs_eco.genomes import Gene, Layout, toolbox_of

layout = Layout(
    [
        Gene(name="hungry", letters=4, low=0.0, high=1.0, code="gray"),  # hops below this energy
        # turns toward grass farther to the side than this
        Gene(name="aside", letters=4, low=-1.0, high=1.0, code="gray"),
        Gene(name="full", letters=4, low=0.0, high=1.0, code="gray"),  # eats below this energy
    ]
)


def rabbits(genes: dict[str, float]) -> dict:
    """Return a meadow with little grass and twenty rabbits whose reflexes have these thresholds.

    The world resembles the one in own_networks.py.
    """

    # x: energy, grass_forward, grass_left, grass_near; y: sit, hop, left, none, right, eat
    def reflex(x: np.ndarray) -> np.ndarray:
        energy, left = x[:, 0], x[:, 2]
        ways = np.abs(left) > genes["aside"]
        columns = [
            0 * left,
            energy < genes["hungry"],
            ways & (left > 0),
            0 * left,
            ways & (left < 0),
            energy < genes["full"],
        ]
        return np.stack(columns, axis=1)

    grass = {
        "count": 80,
        "body": {"radius": 0.4},
        "reproduction": {"kind": "spread", "rate": 0.0, "seed_rain": 0.0015, "spacing": 2.0},
    }
    rabbit = {
        "count": 20,
        "body": {"radius": 0.3},
        "metabolism": {"energy": 0.5, "basal": 0.015},
        "locomotion": {"speed": {"sit": 0.0, "hop": 1.0}, "cost": {"hop": 0.015}, "turn": 0.8},
        "diet": [{"eats": "grass", "reach": 0.3, "gain": 0.2}],
        "lethal": [{"property": "energy", "min": 0.0}],
        "sensors": [
            {"kind": "own", "property": "energy"},
            {"kind": "nearest", "target": "grass", "range": 5.0},
        ],
        "actions": {"speed": ["sit", "hop"], "turn": ["left", "none", "right"], "eat": ["eat"]},
        "reflex": {"function": reflex},
    }
    return {
        "format": 1,
        "name": "meadow",
        "space": {"size": [50.0, 50.0]},
        "species": {"grass": grass, "rabbit": rabbit},
    }


def lifetime(letters: list[int]) -> tuple[float]:
    """Return the rabbits' mean lifetime [s], capped at 300."""
    genes = {name: float(value[0]) for name, value in layout.decode(np.array([letters], np.uint8)).items()}
    series = World.from_config(rabbits(genes), seed=1).run(300).series()
    return (
        sum(
            n
            for n, s in zip(series["n"].to_pylist(), series["species"].to_pylist(), strict=True)
            if s == "rabbit"
        )
        / 20,
    )


if __name__ == "__main__":
    random.seed(1)
    creator.create("Lifetime", base.Fitness, weights=(1.0,))
    creator.create("Letters", list, fitness=creator.Lifetime)
    toolbox = toolbox_of(
        {"mate": {"operator": "cxTwoPoint"}, "mutate": {"operator": "mutUniformInt", "indpb": 0.1}}, layout
    )
    toolbox.register("evaluate", lifetime)
    toolbox.register("select", tools.selTournament, tournsize=3)
    statistics = tools.Statistics(lambda individual: individual.fitness.values[0])
    statistics.register("mean", np.mean)
    statistics.register("best", np.max)
    population = [creator.Letters(row.tolist()) for row in layout.random(np.arange(10, dtype=np.uint64))]
    best = tools.HallOfFame(1)
    algorithms.eaSimple(population, toolbox, cxpb=0.7, mutpb=0.5, ngen=5, stats=statistics, halloffame=best)
    print({name: round(float(v[0]), 2) for name, v in layout.decode(np.array(best, np.uint8)).items()})
