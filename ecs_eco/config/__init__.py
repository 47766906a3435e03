"""World files: the models of every section, loading with overrides, checks across sections, and formulas.

What a world is belongs here; what happens in it does not. Nothing here imports numba or torch.
Names load when first used: `import ecs_eco.config` loads no models.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ecs_eco.config.formula import Formula, FormulaError, compile_formula
    from ecs_eco.config.loading import load
    from ecs_eco.config.world import WorldConfig

__all__ = ["Formula", "FormulaError", "WorldConfig", "compile_formula", "load"]

_HOME = {
    "Formula": "formula",
    "FormulaError": "formula",
    "WorldConfig": "world",
    "compile_formula": "formula",
    "load": "loading",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"ecs_eco.config has no {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
