"""ecs-eco: organisms live, learn, breed and die, and nothing selects them but that.

A world is made of entities in columns; systems act on them; brains learn while their owners live.
Names load when first used, so importing the package is cheap: `from ecs_eco import World, System, component, f32`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ecs_eco.schema import boolean, component, f32, f64, i8, i16, i32, i64, u8, u16, u32, u64
    from ecs_eco.system import System
    from ecs_eco.table import Table
    from ecs_eco.world import World

_HOME = {"World": "world", "System": "system", "PHASES": "system", "Table": "table", "njit": "_numba", "draw": "random"}
_HOME |= dict.fromkeys(("component", "f32", "f64", "i8", "i16", "i32", "i64", "u8", "u16", "u32", "u64", "boolean"), "schema")
__all__ = [*_HOME]
__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"ecs_eco has no {name!r}; it has {', '.join(_HOME)}")
    return getattr(import_module(f"ecs_eco.{_HOME[name]}"), name)
