"""The elementary functions of the portable mode agree with those of the C library to some last places."""

import math

import numba
import numpy as np
import pytest

from ecs_eco.compiled import libm

RANGES = {
    "exp": (-40, 40),
    "exp2": (-40, 40),
    "expm1": (-5, 5),
    "log": (1e-9, 50),
    "log2": (1e-9, 50),
    "log10": (1e-9, 50),
    "log1p": (-0.9, 9),
    "sin": (-99, 99),
    "cos": (-99, 99),
    "tan": (-1.5, 1.5),
    "asin": (-1, 1),
    "acos": (-1, 1),
    "atan": (-9, 9),
    "sinh": (-30, 30),
    "cosh": (-30, 30),
    "tanh": (-9, 9),
}
ODD = (0.0, -0.0, 1.0, -1.0, 2.0, 0.5, math.inf, -math.inf, math.nan, 1e-310, 700.0, -740.0)


def same(a, b, places=4.0):
    """Equal, both not-a-number, or some last places apart."""
    return a == b or (a != a and b != b) or abs(a - b) <= places * np.spacing(abs(b))


@pytest.mark.parametrize("name", libm.ONE)
def test_a_function_of_one_number_agrees(name):
    function, numpys = (
        libm.ONE[name],
        getattr(np, {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}.get(name, name)),
    )
    with np.errstate(all="ignore"):
        for x in (*np.linspace(*RANGES[name], 301).tolist(), *ODD):
            ours, theirs = function(x), float(numpys(x))
            assert same(ours, theirs), (name, x, ours, theirs)


def test_powers_agree_and_whole_ones_are_products():
    x, y = np.meshgrid(np.linspace(0.1, 9, 40), np.linspace(-5, 5, 41))
    for a, b in zip(x.ravel().tolist(), y.ravel().tolist(), strict=True):
        assert same(libm.power(a, b), a**b, 4 + abs(b * math.log(a)))
    assert libm.power(1.1, 2.0) == 1.1 * 1.1
    assert libm.power(-2.0, 3.0) == -8.0
    assert math.isnan(libm.power(-2.0, 0.5))
    assert libm.power(0.0, 0.5) == 0.0
    assert libm.power(0.0, -1.0) == math.inf


def test_angles_and_lengths_agree_in_all_quarters_and_at_their_ends():
    some = (0.0, -0.0, 1.0, -1.0, 0.3, -2.5, 1e200, 1e-200, math.inf, -math.inf)
    for y in some:
        for x in some:
            assert same(libm.atan2(y, x), math.atan2(y, x)), (y, x)
            assert math.copysign(1, libm.atan2(y, x)) == math.copysign(1, math.atan2(y, x)), (y, x)
            assert same(libm.hypot(x, y), math.hypot(x, y)), (y, x)


def test_they_become_code_that_calls_no_library():
    from ecs_eco.compiled.linking import NAMES

    @numba.njit
    def all_of_them(x):
        return libm.exp(x) + libm.sin(x) + libm.log1p(x) + libm.power(x, x) + libm.atan2(x, x) + libm.tanh(x)

    all_of_them(0.5)
    (code,) = all_of_them.inspect_asm().values()
    called = {
        line.split("$")[1].split(",")[0] for line in code.splitlines() if "movabsq" in line and "$" in line
    }
    assert not called & NAMES
