"""Elementary functions for what decides a world's future outside of kernels.

`scalars` stands for the module math, `arrays` for numpy, `power(x, y)` for x ** y of numbers or arrays. In
the portable mode they are `substitutes`, for those of the C library and of numpy depend on the processor.
Kernels need no word about it: see `linking`. What is exact everywhere (sqrt, floor, …) is called by its own
name.
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
