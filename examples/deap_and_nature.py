"""One genome and one set of operators under two kinds of selection: DEAP selects individual animals by their
lifetime in an arena; births and deaths select in a meadow."""

import random
from functools import cache

import numpy as np
from deap import algorithms, base, creator, tools

from ecs_eco import World
from ecs_eco.components import Genome, Position

GENES = [  # thresholds for the reflexes below, from the lowest to the highest reading
    {"name": name, "trait": f"reflex.{name}.threshold", "letters": 4, "low": low, "high": 1.0, "code": "gray"}
    for name, low in (("hungry", 0.0), ("left", -1.0), ("right", -1.0), ("full", 0.0))
]
GRASS = {
    "count": 80,
    "body": {"radius": 0.4},
    "reproduction": {"kind": "spread", "rate": 0.0, "seed_rain": 0.002, "spacing": 2.0},
}
RABBIT = {
    "body": {"radius": 0.3},
    "metabolism": {"energy": 0.5, "basal": 0.015},
    "locomotion": {"speed": {"sit": 0.0, "hop": 1.0}, "cost": {"hop": 0.015}, "turn": 0.8},
    "diet": [{"eats": "grass", "reach": 0.3, "gain": 0.2}],
    "lethal": [{"property": "energy", "min": 0.0}, {"property": "age", "max": 300.0}],
    "sensors": [{"kind": "own", "property": "energy"}, {"kind": "nearest", "target": "grass", "range": 5.0}],
    "actions": {"speed": ["sit", "hop"], "turn": ["left", "none", "right"], "eat": ["eat"]},
    "always_on": ["eat"],
    "default_action": {"speed": "sit", "turn": "none"},
    "reflex": {
        "connections": [
            {"name": "hungry", "sensor": "energy", "below": 0.5, "action": "hop", "weight": 1},
            {"name": "left", "sensor": "grass_left", "above": 0.0, "action": "left", "weight": 1},
            {"name": "right", "sensor": "grass_left", "below": 0.0, "action": "right", "weight": 1},
            {"name": "full", "sensor": "energy", "above": 0.5, "action": "eat", "weight": -1},
        ]
    },
    "genome": {
        "genes": GENES,
        "mate": {"operator": "cxUniform", "indpb": 0.5},
        "mutate": {"operator": "mutUniformInt", "indpb": 0.05},
    },
}


def meadow(side: float, rabbits: int, seed: int, **more) -> World:
    """Return a square world of grass and rabbits; `more` adds keys to the rabbit species."""
    grass, rabbit = GRASS | {"count": int(0.03 * side**2)}, RABBIT | {"count": rabbits} | more
    config = {
        "format": 1,
        "name": "meadow",
        "space": {"size": [side, side]},
        "species": {"grass": grass, "rabbit": rabbit},
    }
    return World.from_config(config, seed=seed, record=False)


@cache
def lifetime(letters: tuple[int, ...]) -> float:
    """Return the lifetime [s] of a single rabbit with this genome in a fixed arena, capped at 300."""
    world = meadow(20.0, 0, seed=1)
    rabbits, loci = world.table("rabbit"), np.array([letters], np.uint8)
    born = {(Position, "x"): np.full(1, 10.0), (Position, "y"): np.full(1, 10.0), (Genome, "loci"): loci}
    rabbits.request(np.zeros(1, np.uint64), born | rabbits.species.heredity.express(rabbits, loci))
    world.before_tick.append(lambda: world.tick > 1 and rabbits.n == 0 and world.stop())
    return world.run(301).time


if __name__ == "__main__":
    random.seed(1)
    young = {"kind": "asexual", "rate": 0.02, "energy_min": 0.6, "energy_given": 0.3, "age_min": 20}
    nature = meadow(80.0, 150, seed=1, reproduction=young | {"dispersal": 3.0})
    heredity = nature.table("rabbit").species.heredity
    drawn = heredity.layout.random(np.arange(12, dtype=np.uint64)).tolist()

    toolbox = heredity.operators.toolbox  # with mate and mutate from the world's configuration
    if not hasattr(creator, "ArenaGenome"):  # DEAP creates classes once per process
        creator.create("ArenaLife", base.Fitness, weights=(1.0,))
        creator.create("ArenaGenome", list, fitness=creator.ArenaLife)
    toolbox.register("evaluate", lambda letters: (lifetime(tuple(letters)),))
    toolbox.register("select", tools.selTournament, tournsize=3)
    population = [creator.ArenaGenome(letters) for letters in drawn]
    chosen, _ = algorithms.eaMuPlusLambda(population, toolbox, 12, 12, 0.5, 0.5, ngen=6, verbose=False)

    nature.run(3000)
    grown = nature.table("rabbit")[Genome].loci[nature.table("rabbit").by_uid()[-12:]].tolist()
    for name, genomes in (("random", drawn), ("selected by DEAP", chosen), ("evolved in the meadow", grown)):
        life = np.mean([lifetime(tuple(letters)) for letters in genomes])
        genes = heredity.layout.decode(np.array(genomes, np.uint8))
        print(
            f"{name}: {life:3.0f} s in the arena;",
            ", ".join(f"{gene} {np.median(v):.2f}" for gene, v in genes.items()),
        )
