"""Elementary functions for results outside kernels that affect a world's future.

`scalars` replaces the module math, `arrays` replaces numpy, and `power(x, y)` replaces x ** y for numbers or
arrays. In the portable mode they come from `substitutes`, because functions of the C library and of numpy
depend on the processor. Kernels do not need these replacements (see `linking`). Functions that are exact
everywhere (sqrt, floor, …) are called directly.
"""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np

from ecs_eco.compiled import portable

scalars: Any = math
arrays: Any = np
power: Any = operator.pow

if portable.on():
    from ecs_eco.compiled.substitutes import arrays, power, scalars

__all__ = ["arrays", "power", "scalars"]
