"""Heredity: genomes as strings over a finite alphabet, the traits that they encode, and the operators of
inheritance.

The layout of a genome defines its meaning; `ecs_eco.systems` uses the traits. Names are loaded lazily:
`import ecs_eco.genomes` imports neither DEAP nor numba nor torch.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy, listing

if TYPE_CHECKING:
    from ecs_eco.genomes.alphabet import DNA, Alphabet
    from ecs_eco.genomes.batch import Operators, operators_of
    from ecs_eco.genomes.choices import CHOICES
    from ecs_eco.genomes.fit import Fitted, fit_network
    from ecs_eco.genomes.layout import Layout
    from ecs_eco.genomes.models import Gene
    from ecs_eco.genomes.operators import toolbox_of
    from ecs_eco.genomes.traits import Trait
    from ecs_eco.genomes.variable_layout import layout_of
    from ecs_eco.genomes.variety import diversity, frequencies, statistics

_HOME = {
    "Alphabet": "alphabet",
    "DNA": "alphabet",
    "CHOICES": "choices",
    "Gene": "models",
    "Layout": "layout",
    "Operators": "batch",
    "toolbox_of": "operators",
    "Trait": "traits",
    "diversity": "variety",
    "frequencies": "variety",
    "statistics": "variety",
    "Fitted": "fit",
    "fit_network": "fit",
    "layout_of": "variable_layout",
    "operators_of": "batch",
}
__all__ = [
    "CHOICES",
    "DNA",
    "Alphabet",
    "Fitted",
    "Gene",
    "Layout",
    "Operators",
    "Trait",
    "diversity",
    "fit_network",
    "frequencies",
    "layout_of",
    "operators_of",
    "statistics",
    "toolbox_of",
]
__getattr__ = lazy(__name__, {name: f"{__name__}.{module}" for name, module in _HOME.items()})
__dir__ = listing(globals(), __all__)
