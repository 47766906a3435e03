"""World files: the models of every section, loading with overrides, checks across sections, and formulas.

`ecs_eco.ecosystem` builds a world from a configuration; `ecs_eco.systems` defines its behavior. This package
imports neither numba nor torch. Names are loaded when first used: `import ecs_eco.config` loads no models.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy, listing

if TYPE_CHECKING:
    from ecs_eco.config.features.feature import Feature
    from ecs_eco.config.formula import Formula, FormulaError, compile_formula
    from ecs_eco.config.loading import for_training, load
    from ecs_eco.config.models.world import WorldConfig
    from ecs_eco.inputs.section import (
        ANEW,
        FREE,
        Count,
        Name,
        NonNegative,
        Positive,
        Real,
        Section,
        Share,
        about,
        quantity,
    )

_HOME = {  # modules that define names not in ecs_eco.inputs.section
    "Feature": "ecs_eco.config.features.feature",
    **dict.fromkeys(("Formula", "FormulaError", "compile_formula"), "ecs_eco.config.formula"),
    **dict.fromkeys(("for_training", "load"), "ecs_eco.config.loading"),
    "WorldConfig": "ecs_eco.config.models.world",
}
__all__ = [
    "ANEW",
    "FREE",
    "Count",
    "Feature",
    "Formula",
    "FormulaError",
    "Name",
    "NonNegative",
    "Positive",
    "Real",
    "Section",
    "Share",
    "WorldConfig",
    "about",
    "compile_formula",
    "for_training",
    "load",
    "quantity",
]
__getattr__ = lazy(__name__, {name: _HOME.get(name, "ecs_eco.inputs.section") for name in __all__})
__dir__ = listing(globals(), __all__)
