"""World files: the models of every section, loading with overrides, checks across sections, and formulas.

`ecs_eco.ecosystem` builds a world from a configuration; `ecs_eco.systems` defines its behavior. This package
imports neither numba nor torch. Names are loaded when first used: `import ecs_eco.config` loads no models.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy

if TYPE_CHECKING:
    from ecs_eco.config.features.feature import Feature as Feature
    from ecs_eco.config.formula import Formula as Formula
    from ecs_eco.config.formula import FormulaError as FormulaError
    from ecs_eco.config.formula import compile_formula as compile_formula
    from ecs_eco.config.loading import for_training as for_training
    from ecs_eco.config.loading import load as load
    from ecs_eco.config.models.world import WorldConfig as WorldConfig
    from ecs_eco.inputs.section import ANEW as ANEW
    from ecs_eco.inputs.section import FREE as FREE
    from ecs_eco.inputs.section import Count as Count
    from ecs_eco.inputs.section import Name as Name
    from ecs_eco.inputs.section import NonNegative as NonNegative
    from ecs_eco.inputs.section import Positive as Positive
    from ecs_eco.inputs.section import Real as Real
    from ecs_eco.inputs.section import Section as Section
    from ecs_eco.inputs.section import Share as Share
    from ecs_eco.inputs.section import about as about
    from ecs_eco.inputs.section import quantity as quantity

__getattr__ = lazy(
    __name__,
    {
        "ecs_eco.inputs.section": "ANEW Count FREE Name NonNegative Positive Real Section Share about quantity",
        ".features.feature": "Feature",
        ".formula": "Formula FormulaError compile_formula",
        ".loading": "for_training load",
        ".models.world": "WorldConfig",
    },
)
