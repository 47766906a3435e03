"""World files: the models of every section, loading with overrides, checks across sections, and formulas.

The contents of a file belong here; building a world from it belongs to `ecs_eco.worlds`, its behaviour to
`ecs_eco.systems`. Nothing here imports numba or torch. Names load when first used: `import ecs_eco.config`
loads no models.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy, listing

if TYPE_CHECKING:
    from ecs_eco.config.formula import Formula, FormulaError, compile_formula
    from ecs_eco.config.loading import for_training, load
    from ecs_eco.config.models.world import WorldConfig

__all__ = ["Formula", "FormulaError", "WorldConfig", "compile_formula", "for_training", "load"]

_HOME = {
    "Formula": "formula",
    "FormulaError": "formula",
    "WorldConfig": "models.world",
    "compile_formula": "formula",
    "for_training": "loading",
    "load": "loading",
}
__getattr__ = lazy(__name__, {name: f"{__name__}.{module}" for name, module in _HOME.items()})
__dir__ = listing(globals(), __all__)
