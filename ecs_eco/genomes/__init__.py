"""Heredity: genomes as strings over a finite alphabet, the traits that they encode, and the operators of
inheritance.

The layout of a genome defines its meaning; `ecs_eco.systems` uses the traits. Names are loaded lazily:
`import ecs_eco.genomes` imports neither DEAP nor numba nor torch.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy

if TYPE_CHECKING:
    from ecs_eco.genomes.alphabet import DNA as DNA, Alphabet as Alphabet
    from ecs_eco.genomes.batch import Operators as Operators, operators_of as operators_of
    from ecs_eco.genomes.choices import CHOICES as CHOICES
    from ecs_eco.genomes.fit import Fitted as Fitted, fit_network as fit_network
    from ecs_eco.genomes.layout import Layout as Layout
    from ecs_eco.genomes.models import Gene as Gene
    from ecs_eco.genomes.operators import toolbox_of as toolbox_of
    from ecs_eco.genomes.traits import Trait as Trait
    from ecs_eco.genomes.variable_layout import layout_of as layout_of
    from ecs_eco.genomes.variety import (
        diversity as diversity,
        frequencies as frequencies,
        statistics as statistics,
    )

__getattr__ = lazy(
    __name__,
    {
        ".alphabet": "Alphabet DNA",
        ".batch": "Operators operators_of",
        ".choices": "CHOICES",
        ".fit": "Fitted fit_network",
        ".layout": "Layout",
        ".models": "Gene",
        ".operators": "toolbox_of",
        ".traits": "Trait",
        ".variable_layout": "layout_of",
        ".variety": "diversity frequencies statistics",
    },
)
