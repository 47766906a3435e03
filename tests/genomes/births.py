"""Many births at once, for tests of what operators do: layouts, operators, and samples that are compared."""

from collections.abc import Callable

import numpy as np
from deap import tools

from ecs_eco.genomes import Gene, Layout, Operators, toolbox_of

N = 6000
KEYS = np.arange(N, dtype=np.uint64) * np.uint64(7919)
ALPHA = 1e-4  # of a test with fixed seeds


def layout_of(loci: int = 10, letters: str = "ACGT", **arguments) -> Layout:
    return Layout([Gene(name="g", letters=2, low=0, high=1, **arguments)], letters, loci=loci)


def operators(
    layout: Layout,
    mate: tuple | None = None,
    mutate: tuple | None = None,
    twins: bool = True,
    chance: float = 1.0,
) -> Operators:
    """Operators with functions of DEAP; without `twins` hidden in functions that no kernel stands for."""
    toolbox = toolbox_of({"mutate": {"operator": "mutUniformInt", "indpb": 0.0}}, layout)
    for word, given in (("mate", mate), ("mutate", mutate)):
        if given is not None:
            function, arguments = given
            toolbox.register(word, function if twins else hidden(function, word), **arguments)
    return Operators(toolbox, layout, chance)


def hidden(function: Callable, word: str) -> Callable:
    if word == "mate":
        return (
            (lambda a, b, indpb: function(a, b, indpb))
            if function is tools.cxUniform
            else lambda a, b: function(a, b)
        )
    if function is tools.mutUniformInt:
        return lambda a, low, up, indpb: function(a, low, up, indpb)
    return lambda a, indpb: function(a, indpb)
