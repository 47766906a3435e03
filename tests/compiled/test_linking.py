"""Names of the C library lead to functions of our own, and object code says which names it asks for."""

import json
import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from ecs_eco.compiled import portable
from ecs_eco.compiled.elf import undefined
from ecs_eco.compiled.linking import EXACT, NAMES

CHILD = """
import json, math
import ecs_eco
import numpy as np
from ecs_eco.compiled import libm
@ecs_eco.njit
def double(x): return np.sin(x), np.cos(x), x ** 1.5, np.hypot(x, x)
@ecs_eco.njit
def single(x): return np.sin(x), np.cos(x), np.exp(x), np.arctan2(x, x)
print(json.dumps([[float(v) for v in double(3e22)], [libm.sin(3e22), libm.cos(3e22), libm.power(3e22, 1.5),
                                                     libm.hypot(3e22, 3e22)],
                  [float(v) for v in single(np.float32(0.7))], np.float32([math.sin(np.float32(0.7)),
                   math.cos(np.float32(0.7)), math.exp(np.float32(0.7)), math.pi / 4]).tolist()]))
"""


@pytest.mark.slow  # where no cache has them they are compiled
def test_names_lead_to_functions_of_our_own():
    done = subprocess.run(
        [sys.executable, "-c", CHILD],
        env={**os.environ, portable.VARIABLE: "1"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    doubles, ours, singles, theirs = json.loads(done.stdout)
    assert doubles == ours  # beyond 10^6 ours is another number than the library's
    assert singles == pytest.approx(theirs, rel=2e-7)


def test_object_code_says_what_it_calls():
    @numba.njit
    def wave(x):
        return np.sin(x) + np.exp(x)

    wave(1.0)
    (library,) = (overload.library for overload in wave.overloads.values())
    called = undefined(library._get_compiled_object())
    assert {"sin", "exp"} <= called
    assert {"sin", "exp"} <= NAMES
    assert not NAMES & EXACT
