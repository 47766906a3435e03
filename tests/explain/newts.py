"""Newts whose lives are known by hand: they burn energy and, if fertile, bear one young per tick on average."""

from ecs_eco.record import run_to_folder

# a newt burns 1/8 or, with an allele B, 1/4 of its store in each tick, and eats nothing; its young have no
# energy and die in their first tick
GENES = [
    {"name": "hunger", "trait": "metabolism.basal", "letters": 1, "values": [0.125, 0.25]},
    {"name": "fertile", "trait": "reproduction.rate", "letters": 1, "values": [0.0, 1.0]},
    {"name": "blue", "letters": 1, "values": [0, 1]},
]
NEWT = {
    "count": 60,
    "body": {"radius": 0.1, "mass": 0.1},
    "metabolism": {"energy": 1.0, "energy_max": 1.0, "basal": 0.125},
    "reproduction": {
        "kind": "asexual",
        "rate": 0.0,
        "energy_min": 0.01,
        "energy_given": 0.0,
        "place": "anywhere",
    },
    "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
    "genome": {"alphabet": "AB", "ploidy": 2, "expression": "greater", "genes": GENES},
}
WORLD = {"format": 1, "name": "newts", "space": {"size": [20.0, 20.0]}, "species": {"newt": NEWT}}
# with genomes of variable length: each copy of a gene adds 1/16 to what a newt burns
VARIABLE = {
    "alphabet": "ACGT",
    "max_length": 60,
    "mutate": {"operator": "mutUniformInt", "indpb": 0.0},
    "copy_rule": "sum",
    "genes": [
        {
            "name": "hunger",
            "trait": "metabolism.basal",
            "letters": 1,
            "values": [0.0625, 0.0625, 0.0625, 0.25],
            "copies": 3,
        }
    ],
}


def recorded(out, ticks=2, world=WORLD, **options):
    """Record a run of newts; return its folder."""
    run_to_folder(world, seed=1, ticks=ticks, out=out, report=False, **options)
    return out
