"""ecs-eco: artificial ecosystems whose organisms live, learn, breed and die, with no selection except
survival and reproduction.

A world stores its entities in columns; systems act on them, and brains learn while their owners live. This
module only lists the public names: `from ecs_eco import World, System, component, f32`. They load on first
use, so importing the package is cheap. docs/explanation/architecture.md describes the packages.
"""

import sys

if (
    sys.argv[:1] == ["-m"]
    and not sys.flags.safe_path
    and sys.orig_argv[-len(sys.argv)].removeprefix("-m").removesuffix(".__main__") == __name__
):
    # under `python -m ecs_eco`, before other imports: modules in the current folder must not shadow them
    _here = sys.path.pop(0)
    if __path__ == [f"{_here}/{__name__}"]:  # keep an uninstalled checkout: subprocesses need it, too
        sys.path.append(_here)
from typing import TYPE_CHECKING

from ecs_eco._lazy import find_former_names, lazy, listing
from ecs_eco.compiled.portable import begin as _begin_portable

if TYPE_CHECKING:
    from ecs_eco import (
        analysis,
        components,
        config,
        genomes,
        lab,
        learning,
        record,
        rl,
        runs,
        space,
        systems,
        testing,
        view,
        worlds,
    )
    from ecs_eco.compiled.jit import njit
    from ecs_eco.ecosystem import World
    from ecs_eco.engine.phases import PHASES
    from ecs_eco.engine.random import draw
    from ecs_eco.engine.schema import (
        boolean,
        column,
        component,
        f32,
        f64,
        i8,
        i16,
        i32,
        i64,
        u8,
        u16,
        u32,
        u64,
    )
    from ecs_eco.engine.system import System
    from ecs_eco.engine.table import Table

__all__ = [
    "PHASES",
    "System",
    "Table",
    "World",
    "analysis",
    "boolean",
    "column",
    "component",
    "components",
    "config",
    "draw",
    "f32",
    "f64",
    "genomes",
    "i8",
    "i16",
    "i32",
    "i64",
    "lab",
    "learning",
    "njit",
    "record",
    "rl",
    "runs",
    "space",
    "systems",
    "testing",
    "u8",
    "u16",
    "u32",
    "u64",
    "view",
    "worlds",
]
_HOME = {
    "World": "ecosystem",
    "System": "engine.system",
    "PHASES": "engine.phases",
    "Table": "engine.table",
    "njit": "compiled.jit",
    "draw": "engine.random",
}
_TYPES = (
    "column",
    "component",
    "boolean",
    "f32",
    "f64",
    "i8",
    "i16",
    "i32",
    "i64",
    "u8",
    "u16",
    "u32",
    "u64",
)
_HOME |= dict.fromkeys(_TYPES, "engine.schema")
_ROOMS = [name for name in __all__ if name not in _HOME]
__getattr__ = lazy(__name__, {name: f"ecs_eco.{module}" for name, module in _HOME.items()}, _ROOMS)
__dir__ = listing(globals(), __all__)
find_former_names()
_begin_portable()  # if ECS_ECO_PORTABLE is set; must precede any import of numpy
__version__ = "0.2.0"
