"""Heredity: genomes as strings over a finite alphabet, what they say, and what makes new ones of them.

What a genome says of a body or a brain belongs to its layout; how an organism with it lives belongs to `systems`.
Names load when first used: `import ecs_eco.genomes` loads neither DEAP nor numba nor torch.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ecs_eco.config.genome import Gene
    from ecs_eco.genomes.alphabet import DNA, Alphabet
    from ecs_eco.genomes.batch import Operators
    from ecs_eco.genomes.choices import CHOICES
    from ecs_eco.genomes.fit import Fitted, fit_network
    from ecs_eco.genomes.layout import Layout
    from ecs_eco.genomes.operators import toolbox_of
    from ecs_eco.genomes.traits import Trait, policy_shapes, traits_of
    from ecs_eco.genomes.variety import diversity, frequencies, statistics

_HOME = {
    "Alphabet": "alphabet", "DNA": "alphabet", "CHOICES": "choices", "Layout": "layout", "Operators": "batch", "toolbox_of": "operators",
    "Trait": "traits", "traits_of": "traits", "policy_shapes": "traits", "diversity": "variety", "frequencies": "variety",
    "statistics": "variety", "Fitted": "fit", "fit_network": "fit",
}  # fmt: skip
__all__ = [
    "CHOICES", "DNA", "Alphabet", "Fitted", "Gene", "Layout", "Operators", "Trait", "diversity", "fit_network", "frequencies",
    "policy_shapes", "statistics", "toolbox_of", "traits_of",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name == "Gene":
        return import_module("ecs_eco.config.genome").Gene
    if name not in _HOME:
        raise AttributeError(f"ecs_eco.genomes has no {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(f"ecs_eco.genomes.{_HOME[name]}"), name)
