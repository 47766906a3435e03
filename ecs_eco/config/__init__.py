"""World files: the models of every section, loading with overrides, checks across sections, and formulas.

`ecs_eco.ecosystem` builds a world from a configuration; `ecs_eco.systems` defines its behavior. This package
imports neither numba nor torch. Names are loaded when first used: `import ecs_eco.config` loads no models.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy

if TYPE_CHECKING:
    from ecs_eco.config.features.feature import Feature as Feature
    from ecs_eco.config.formula import (
        Formula as Formula,
        FormulaError as FormulaError,
        compile_formula as compile_formula,
    )
    from ecs_eco.config.loading import for_training as for_training, load as load
    from ecs_eco.config.models.world import WorldConfig as WorldConfig
    from ecs_eco.inputs.section import (
        ANEW as ANEW,
        FREE as FREE,
        Count as Count,
        Name as Name,
        NonNegative as NonNegative,
        Positive as Positive,
        Real as Real,
        Section as Section,
        Share as Share,
        about as about,
        quantity as quantity,
    )

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
