"""A custom genome: letters, genes, one DEAP operator and one custom operator. A thousand births show their
effect."""

import random

import numpy as np
from deap import tools

from ecs_eco.genomes import Gene, Layout, Operators, diversity, frequencies, toolbox_of
from ecs_eco.testing import check_genome

layout = Layout(
    [
        # three of the four letters encode the same value, so most mutations are silent
        Gene(name="red", letters=1, values=[0, 0, 0, -1]),
        # adjacent sizes differ in one letter
        Gene(name="size", letters=4, low=0.2, high=0.6, code="gray"),
        # the three loci before it are neutral
        Gene(name="age", letters=6, low=600, high=6000, scale="log", at=8),
        # mutates more often than the others
        Gene(name="litter", letters=2, low=1, high=8, whole=True, mutation_rate=0.05),
    ],
    alphabet="RYKW",
    ploidy=2,
    expression="mean",
)


def repeat_letter(genome: list[int], indpb: float) -> tuple[list[int]]:
    """Replace each letter with a copy of its left neighbor with probability `indpb`. Python's random
    generator is seeded for each birth.
    """
    for i in range(1, len(genome)):
        if random.random() < indpb:
            genome[i] = genome[i - 1]
    return (genome,)


if __name__ == "__main__":
    print(layout)
    check_genome(layout)
    parents = layout.encode({"red": [0, -1], "size": [0.3, 0.5], "age": [1000, 3000], "litter": [2, 6]})
    print("first string of a parent:", [(piece.gene, piece.letters) for piece in layout.mark(parents[1])][:6])
    toolbox = toolbox_of(
        {"mate": {"operator": "cxTwoPoint"}, "mutate": {"operator": "mutUniformInt", "indpb": 0.01}}, layout
    )
    births = Operators(toolbox, layout)
    keys = np.arange(1000, dtype=np.uint64)  # a child depends only on its parents and its key
    mothers, fathers = np.repeat(parents[:1], 1000, axis=0), np.repeat(parents[1:], 1000, axis=0)
    children = births.offspring(mothers, fathers, keys)
    print("size of the children:", np.unique(layout.decode(children)["size"].round(2)).tolist()[:6], "…")
    print("alleles of red:", frequencies(layout, children)["red"])
    # registered operators take effect immediately, as in DEAP
    toolbox.register("mate", tools.cxUniform, indpb=0.5)
    toolbox.register("mutate", repeat_letter, indpb=0.01)
    children = births.offspring(mothers, fathers, keys)
    print(f"expected heterozygosity: {diversity(layout, children).mean():.2f}")
