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

from ecs_eco._lazy import find_former_names, lazy
from ecs_eco.compiled.portable import begin as _begin_portable

if TYPE_CHECKING:
    from ecs_eco import (
        analysis as analysis,
        components as components,
        config as config,
        genomes as genomes,
        lab as lab,
        learning as learning,
        record as record,
        rl as rl,
        runs as runs,
        space as space,
        systems as systems,
        testing as testing,
        view as view,
        worlds as worlds,
    )
    from ecs_eco.compiled.jit import njit as njit
    from ecs_eco.ecosystem import World as World
    from ecs_eco.engine.phases import PHASES as PHASES
    from ecs_eco.engine.random import draw as draw
    from ecs_eco.engine.schema import (
        boolean as boolean,
        column as column,
        component as component,
        f32 as f32,
        f64 as f64,
        i8 as i8,
        i16 as i16,
        i32 as i32,
        i64 as i64,
        u8 as u8,
        u16 as u16,
        u32 as u32,
        u64 as u64,
    )
    from ecs_eco.engine.system import System as System
    from ecs_eco.engine.table import Table as Table

__getattr__ = lazy(
    __name__,
    {
        ".ecosystem": "World",
        ".engine.system": "System",
        ".engine.phases": "PHASES",
        ".engine.table": "Table",
        ".compiled.jit": "njit",
        ".engine.random": "draw",
        ".engine.schema": "column component boolean f32 f64 i8 i16 i32 i64 u8 u16 u32 u64",
    },
    "analysis components config genomes lab learning record rl runs space systems testing view worlds",
)
find_former_names()
_begin_portable()  # if ECS_ECO_PORTABLE is set; must precede any import of numpy
__version__ = "0.2.0"
