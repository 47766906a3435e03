"""Elementary functions for the portable mode, in float64, built from sums, products, quotients and square
roots.

The C library's functions differ between processors and versions. These return the same bits on every machine
with IEEE 754 numbers and without contraction. Coefficients and reductions are from fdlibm (Sun Microsystems
1993, THIRD_PARTY.md). Errors are below 3 units in the last place (below 3 + |y ln x| for `power`; for sines,
up to |x| = 10^6).
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numba
import numpy as np

_plain: Any = partial(
    numba.njit, error_model="numpy", nogil=True
)  # used within other kernels, so not cached on disk
_f64, _i64 = np.float64, np.int64
_LN2, _LN2_HIGH, _LN2_LOW = 0.6931471805599453, 6.93147180369123816490e-01, 1.90821492927058770002e-10
_PI, _PI_LOW = 3.141592653589793, 1.2246467991473532e-16
_LOG10_E, _LOG10_2_HIGH, _LOG10_2_LOW = 0.4342944819032518, 0.30102999566361177, 3.694239077158931e-13
_ROOT_HALF = 0.7071067811865476
# arc tangents of 0.5, 1, 1.5 and infinity
_ATAN_HIGH = np.array([0.4636476090008061, 0.7853981633974483, 0.982793723247329, 1.5707963267948966])
_ATAN_LOW = np.array(
    [2.2698777452961687e-17, 3.061616997868383e-17, 1.3903311031230998e-17, 6.123233995736766e-17]
)


@_plain
def _power_of_2(n):
    """Return 2.0**n for -1022 <= n <= 1023."""
    return _i64((n + _i64(1023)) << _i64(52)).view(np.float64)


@_plain
def exp(x):
    """Return e**x."""
    if not x < 709.782712893384:
        return x if x != x else np.inf
    if x < -745.2:
        return 0.0
    n = np.floor(x * 1.44269504088896338700 + 0.5)
    high, low = x - n * _LN2_HIGH, n * _LN2_LOW
    r = high - low
    t = r * r
    p = 6.61375632143793436117e-05 + t * (-1.65339022054652515390e-06 + t * 4.13813679705723846039e-08)
    c = r - t * (1.66666666666666019037e-01 + t * (-2.77777777770155933842e-03 + t * p))
    y = 1.0 - ((low - (r * c) / (2.0 - c)) - high)
    k = _i64(n)
    half = k // 2
    return y * _power_of_2(half) * _power_of_2(k - half)


@_plain
def expm1(x):
    """Return e**x - 1."""
    if not abs(x) < 38.0:
        return exp(x) - 1.0
    n = np.floor(x * 1.44269504088896338700 + 0.5) if abs(x) > 0.34657359027997264 else 0.0
    high, low = x - n * _LN2_HIGH, n * _LN2_LOW
    r = high - low
    c = (high - r) - low
    half = 0.5 * r
    s = r * half
    p = -7.93650757867487942473e-05 + s * (4.00821782732936239552e-06 + s * -2.01099218183624371326e-07)
    q = 1.0 + s * (-3.33333333333331316428e-02 + s * (1.58730158725481460165e-03 + s * p))
    t = 3.0 - q * half
    e = s * ((q - t) / (6.0 - r * t))
    p = r - ((r * (e - c) - c) - s)
    if n == 0.0:
        return p
    scale = _power_of_2(_i64(n))
    return scale * p + (scale - 1.0)


@_plain
def _parts(x):
    """Return m from 0.7 to 1.4 and an integer k such that x = m 2**k, for finite x > 0."""
    k = _i64(0)
    if x < 2.2250738585072014e-308:
        x, k = x * 18014398509481984.0, _i64(-54)
    bits = _f64(x).view(np.int64)
    k += (bits >> _i64(52)) - _i64(1023)
    m = _i64((bits & _i64(0x000FFFFFFFFFFFFF)) | _i64(0x3FF0000000000000)).view(np.float64)
    if m > 2.0 * _ROOT_HALF:
        m, k = m * 0.5, k + _i64(1)
    return m, _f64(k)


@_plain
def _log_of(m, k):
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    r = 1.818357216161805012e-01 + z * (1.531383769920937332e-01 + z * 1.479819860511658591e-01)
    r = 2.857142874366239149e-01 + z * (2.222219843214978396e-01 + z * r)
    r = z * (6.666666666666735130e-01 + z * (3.999999999940941908e-01 + z * r))
    square = 0.5 * f * f
    return k * _LN2_HIGH - ((square - (s * (square + r) + k * _LN2_LOW)) - f)


@_plain
def log(x):
    """Return ln(x)."""
    if not (0.0 < x < np.inf):
        return -np.inf if x == 0.0 else (np.inf if x > 0.0 else np.nan)
    m, k = _parts(x)
    return _log_of(m, k)


@_plain
def log1p(x):
    """Return ln(1 + x)."""
    u = 1.0 + x
    if u == 1.0 or not (-1.0 < x < np.inf):
        return x if u == 1.0 or x == np.inf else log(u)
    return log(u) + (x - (u - 1.0)) / u


@_plain
def log10(x):
    """Return the base-10 logarithm of x."""
    if not (0.0 < x < np.inf):
        return log(x)
    m, k = _parts(x)
    return k * _LOG10_2_HIGH + (k * _LOG10_2_LOW + _LOG10_E * _log_of(m, 0.0))


@_plain
def log2(x):
    """Return the base-2 logarithm of x."""
    if not (0.0 < x < np.inf):
        return log(x)
    m, k = _parts(x)
    return k + _log_of(m, 0.0) / _LN2


@_plain
def exp2(x):
    """Return 2**x."""
    if not abs(x) < 1022.0:
        return power(2.0, x)
    n = np.floor(x + 0.5)
    return exp((x - n) * _LN2) * _power_of_2(_i64(n))


@_plain
def power(x, y):
    """Return x**y."""
    if y == 0.0 or x == 1.0:
        return 1.0
    if x != x or y != y:
        return x + y
    whole = np.floor(y) == y
    if whole and abs(y) <= 1024.0:
        return _whole_power(x, _i64(y))
    if y == 0.5 and x >= 0.0:
        return np.sqrt(x + 0.0)
    if x < 0.0 and not whole and x > -np.inf:
        return np.nan
    size = exp(y * log(abs(x))) if abs(x) != 1.0 else 1.0
    return -size if x < 0.0 and whole and abs(y) < 9007199254740992.0 and _i64(y) & _i64(1) else size


@_plain
def _whole_power(x, n):
    out, base, left = 1.0, x, abs(n)
    while left:
        if left & 1:
            out *= base
        left >>= 1
        if left:
            base *= base
    return out if n > 0 else 1.0 / out


@_plain
def _quadrant(x):
    """Return y, the remainder, and n modulo 4, where x = n pi/2 + y + remainder."""
    if abs(x) > 1.0e6:
        x = np.fmod(x, 2.0 * _PI)
    n = np.floor(x * 6.36619772367581382433e-01 + 0.5)
    t = x - n * 1.57079632673412561417e00
    w = n * 6.07710050630396597660e-11
    r = t - w
    w = n * 2.02226624879595063154e-21 - ((t - r) - w)
    y = r - w
    return y, (r - y) - w, _i64(n) & _i64(3)


@_plain
def _sin_of(x, rest):
    z = x * x
    v = z * x
    r = 2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)
    r = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * r)
    return x - ((z * (0.5 * rest - v * r) - rest) - v * -1.66666666666666324348e-01)


@_plain
def _cos_of(x, rest):
    z = x * x
    r = -2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    r = -1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * r)
    r = z * (4.16666666666666019037e-02 + z * r)
    half = 0.5 * z
    w = 1.0 - half
    return w + (((1.0 - w) - half) + (z * r - x * rest))


@_plain
def _wave(x, shift):
    if not abs(x) < np.inf:
        return np.nan
    y, rest, n = _quadrant(x)
    n = (n + shift) & _i64(3)
    value = _cos_of(y, rest) if n & _i64(1) else _sin_of(y, rest)
    return -value if n & _i64(2) else value


@_plain
def sin(x):
    """Return the sine of x [rad]."""
    return x if abs(x) < 1e-8 else _wave(x, _i64(0))


@_plain
def cos(x):
    """Return the cosine of x [rad]."""
    return _wave(x, _i64(1))


@_plain
def tan(x):
    """Return the tangent of x [rad]."""
    return sin(x) / cos(x)


@_plain
def atan(x):
    """Return the arc tangent [rad]."""
    if x != x:
        return x
    size, part = abs(x), -1
    if size >= 2.4375:
        part, t = 3, -1.0 / size
    elif size >= 1.1875:
        part, t = 2, (size - 1.5) / (1.0 + 1.5 * size)
    elif size >= 0.6875:
        part, t = 1, (size - 1.0) / (size + 1.0)
    elif size >= 0.4375:
        part, t = 0, (2.0 * size - 1.0) / (2.0 + size)
    else:
        t = size
    z = t * t
    w = z * z
    s = 6.66107313738753120669e-02 + w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)
    s = z * (
        3.33333333333329318027e-01
        + w * (1.42857142725034663711e-01 + w * (9.09088713343650656196e-02 + w * s))
    )
    r = -7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02)
    s += w * (-1.99999999998764832476e-01 + w * (-1.11111104054623557880e-01 + w * r))
    value = t - t * s if part < 0 else _ATAN_HIGH[part] - ((t * s - _ATAN_LOW[part]) - t)
    return np.copysign(value, x)


@_plain
def atan2(y, x):
    """Return the angle to the point (x, y) [rad]."""
    if x != x or y != y:
        return x + y
    left = np.copysign(1.0, x) < 0.0
    if y == 0.0:
        angle = _PI if left else 0.0
    elif x == 0.0:
        angle = _PI / 2
    elif abs(x) == np.inf and abs(y) == np.inf:
        angle = 0.75 * _PI if left else 0.25 * _PI
    else:
        angle = atan(abs(y / x))
        if left:
            angle = _PI - (angle - _PI_LOW)
    return np.copysign(angle, y)


@_plain
def asin(x):
    """Return the arc sine [rad]."""
    return atan2(x, np.sqrt((1.0 - x) * (1.0 + x)))


@_plain
def acos(x):
    """Return the arc cosine [rad]."""
    return atan2(np.sqrt((1.0 - x) * (1.0 + x)), x)


@_plain
def tanh(x):
    """Return the hyperbolic tangent."""
    size = abs(x)
    if not size < 22.0:
        return x if x != x else np.copysign(1.0, x)
    if size < 1e-9:
        return x
    if size >= 1.0:
        value = 1.0 - 2.0 / (expm1(2.0 * size) + 2.0)
    else:
        t = expm1(-2.0 * size)
        value = -t / (t + 2.0)
    return np.copysign(value, x)


@_plain
def sinh(x):
    """Return the hyperbolic sine."""
    if abs(x) < 22.0:
        t = expm1(abs(x))
        return np.copysign(0.5 * (t + t / (t + 1.0)), x)
    half = exp(0.5 * abs(x))
    return np.copysign(0.5 * half * half, x)


@_plain
def cosh(x):
    """Return the hyperbolic cosine."""
    half = exp(0.5 * abs(x))
    return 0.5 * half * half + 0.5 / half / half


@_plain
def hypot(x, y):
    """Return the length of (x, y)."""
    x, y = abs(x), abs(y)
    if x == np.inf or y == np.inf:
        return np.inf
    if x != x or y != y:
        return x + y
    most = max(x, y)
    if most > 1e150 or most < 1e-140:
        if most == 0.0:
            return 0.0
        return most * np.sqrt((x / most) * (x / most) + (y / most) * (y / most))
    return np.sqrt(x * x + y * y)


_ONE = exp, exp2, expm1, log, log2, log10, log1p, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh
ONE: dict[str, Any] = {function.__name__: function for function in _ONE}  # of one argument, by C names
TWO = {"pow": power, "atan2": atan2, "hypot": hypot}  # and of two
