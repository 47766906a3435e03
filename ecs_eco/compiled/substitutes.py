"""`libm` functions for numbers and arrays: the `elementary` functions of the portable mode."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ecs_eco.compiled import libm
from ecs_eco.compiled.jit import njit

_NUMPYS = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "pow": "power"}
_CODES = {name: code for code, name in enumerate((*libm.ONE, *libm.TWO))}
_exp, _exp2, _expm1, _log, _log2, _log10, _log1p = tuple(libm.ONE.values())[:7]
_sin, _cos, _tan, _asin, _acos, _atan, _sinh, _cosh, _tanh = tuple(libm.ONE.values())[7:]
_pow, _atan2, _hypot = libm.TWO.values()


@njit
def _value(which, x, y):
    if which < 7:
        return (
            _exp(x)
            if which == 0
            else _exp2(x)
            if which == 1
            else _expm1(x)
            if which == 2
            else _log(x)
            if which == 3
            else _log2(x)
            if which == 4
            else _log10(x)
            if which == 5
            else _log1p(x)
        )
    if which < 13:
        return (
            _sin(x)
            if which == 7
            else _cos(x)
            if which == 8
            else _tan(x)
            if which == 9
            else _asin(x)
            if which == 10
            else _acos(x)
            if which == 11
            else _atan(x)
        )
    if which < 16:
        return _sinh(x) if which == 13 else _cosh(x) if which == 14 else _tanh(x)
    return _pow(x, y) if which == 16 else _atan2(x, y) if which == 17 else _hypot(x, y)


@njit
def _each(which, x, y, out):
    """Apply a function to each x f64[n], or to x and y; write the results to `out` f64[n]."""
    for i in range(len(out)):
        out[i] = _value(which, x[i], y[i])


def _of_scalars(name: str) -> Any:
    code = _CODES[name]

    def function(x: float, y: float = 0.0) -> float:
        return float(_value(code, float(x), float(y)))

    return function


def _of_arrays(name: str) -> Any:
    """Return a function with numpy's result types: float32 for float32, even combined with Python numbers."""
    code = _CODES[name]

    def function(*given: ArrayLike) -> Any:
        kind = np.result_type(*given)
        wide = np.broadcast_arrays(*(np.asarray(x, float) for x in given))
        flat = [np.ascontiguousarray(x).reshape(-1) for x in wide]
        out = np.empty(wide[0].size)
        _each(code, flat[0], flat[-1], out)
        return out.astype(kind if kind.kind == "f" else float).reshape(wide[0].shape)[()]

    return function


scalars = SimpleNamespace(**{name: _of_scalars(name) for name in _CODES})
arrays = SimpleNamespace(**{_NUMPYS.get(name, name): _of_arrays(name) for name in _CODES})


def power(x: ArrayLike, y: ArrayLike) -> Any:
    """Return x ** y for numbers or arrays."""
    numbers = all(isinstance(value, float | int) and not isinstance(value, np.generic) for value in (x, y))
    return scalars.pow(x, y) if numbers else arrays.power(x, y)
