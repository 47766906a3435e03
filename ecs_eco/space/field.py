"""A scalar field that is emitted, diffuses and decays, such as a smell or a dissolved substance."""

import math
from typing import Any

import numpy as np

from ecs_eco.compiled.elementary import power, scalars
from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.space.geometry import BLOCK, Places, Space, cells_at, floor_between

NOWHERE = np.empty(0, np.float32)
NOBODY = NOWHERE, NOWHERE, NOWHERE, np.float32(0)  # emits nothing


class Field:
    """A quantity with one value per cell of a lattice, which diffuses and decays.

    Parameters
    ----------
    space : Space
    cell : float
        Side of the cells [m].
    diffusion : float, default 0.0
        Diffusion coefficient [m²/s].
    decay : float, default 0.0
        Share lost per second [1/s].

    Attributes
    ----------
    value : array of float32, shape (nz, ny, nx)
        Amount per cell; for a substance, concentrations [mol/L] as float64.

    Notes
    -----
    Fick's second law with decay: dc/dt = D ∇²c − decay c + source.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.space import Field, Space
    >>> scent = Field(Space((10.0, 10.0)), cell=1.0, diffusion=0.1)
    >>> place = np.array([5.5], np.float32)
    >>> scent.emit(place, place, np.zeros(1, np.float32), np.float32(2.0))
    >>> scent.pass_time(1.0)
    >>> round(float(scent.value.sum()), 3)
    2.0
    >>> smelled = np.zeros(1, np.float32)
    >>> scent.sample(place, place, np.zeros(1, np.float32), smelled)
    >>> bool(smelled[0] > 0.5)
    True
    """

    def __init__(self, space: Space, cell: float, diffusion: float = 0.0, decay: float = 0.0) -> None:
        self.space = space
        n = [max(1, round(s / cell)) for s in space.size]
        self.shape = (n[0], n[1], n[2] if space.volume else 1)
        self.diffusion, self.decay = diffusion, decay
        self.substance: str | None = None  # the substance whose concentrations [mol/L] it holds
        self.litres = 0.0  # volume of a cell, if the field holds a substance
        self.initial: np.ndarray | None = None  # [mol/L], if it holds a substance
        self.renewal = 0.0  # [1/s]
        self.value = np.zeros(self.shape[::-1], np.float32)
        self.source = np.zeros_like(self.value)
        self._next = np.zeros_like(self.value)
        self._steps: tuple[Any, ...] = ((), 0, (), 0.0, 0.0)
        self.band: Any = None  # advances only one process's rows if the world is divided
        self.inverse = np.array(
            [n[i] / space.size[i] if i < len(space.size) else 0.0 for i in range(3)], np.float32
        )

    def emit(self, x: np.ndarray, y: np.ndarray, z: np.ndarray, amount: np.ndarray | np.float32) -> None:
        """Add amounts to the cells at given positions during the next `pass_time`.

        Parameters
        ----------
        x, y, z : array of float32, shape (n,)
            Coordinates [m].
        amount : float32 or array of float32, shape (n,)
        """
        _deposit(self.source, Places(x, y, z), amount, self.inverse)

    def contain(self, substance: str, depth: float, initial: np.ndarray, renewal: float) -> None:
        """Make the field hold concentrations [mol/L] of a substance, initially `initial` f64[nz, ny, nx];
        they are float64 so that rounding loses nothing. A plane counts as a layer with this `depth` [m]."""
        size = [*self.space.size[:2], depth] if len(self.space.size) == 2 else self.space.size
        self.litres = 1000 * math.prod(size) / math.prod(self.shape)
        self.substance, self.initial, self.renewal = substance, initial, renewal
        self.value = np.array(initial, np.float64)
        self.source, self._next = np.zeros_like(self.value), np.zeros_like(self.value)

    def give(self, x: np.ndarray, y: np.ndarray, z: np.ndarray, amount: np.ndarray) -> None:
        """Add amounts of the field's substance to the cells at given positions immediately.

        Parameters
        ----------
        x, y, z : array of float32, shape (n,)
            Coordinates [m].
        amount : array of float64, shape (n,)
            [mol]

        Examples
        --------
        >>> import numpy as np
        >>> from ecs_eco.space import Field, Space
        >>> soil = Field(Space((10.0, 10.0)), cell=1.0)
        >>> soil.contain("N", depth=0.1, initial=np.zeros((1, 10, 10)), renewal=0.0)
        >>> place = np.array([5.5], np.float32)
        >>> soil.give(place, place, np.zeros(1, np.float32), np.array([2.0]))
        >>> round(soil.held(), 6)
        2.0
        """
        _deposit(self.value, Places(x, y, z), amount / self.litres, self.inverse)

    def held(self) -> float:
        """Return how much of its substance the field contains.

        Returns
        -------
        float
            [mol]

        Examples
        --------
        >>> import numpy as np
        >>> from ecs_eco.space import Field, Space
        >>> soil = Field(Space((10.0, 10.0)), cell=1.0)
        >>> soil.contain("N", depth=0.1, initial=np.zeros((1, 10, 10)), renewal=0.0)
        >>> place = np.array([5.5], np.float32)
        >>> soil.give(place, place, np.zeros(1, np.float32), np.array([2.0]))
        >>> round(soil.held(), 6)
        2.0
        """
        return float(self.value.sum(dtype=np.float64) + self.source.sum(dtype=np.float64)) * self.litres

    def pass_time(self, dt: float, *emitted: Any) -> None:
        """Advance the field by `dt` seconds: emissions are added evenly over this time, while the field
        diffuses, decays and is renewed. You can also pass the arguments of `emit` here.

        Diffusion takes as many explicit steps as stability requires. Amounts follow dc/dt = source − decay c
        + renewal (initial − c), solved exactly.
        """
        if self.band is not None:
            self.band.pass_time(dt, *emitted)
            return
        made_from = dt, self.diffusion, self.decay, self.renewal
        if self._steps[0] != made_from:
            self._steps = made_from, *self._plan(dt)
        _, steps, a, left, arrives = self._steps
        x, y, z, amount = emitted or NOBODY
        _flow(
            self.value,
            self.source,
            self._next,
            Places(x, y, z),
            amount,
            self.inverse,
            steps,
            a,
            left,
            arrives,
            self.space.torus,
        )
        if steps % 2:
            self.value, self._next = self._next, self.value
        if self.initial is not None and self.renewal:
            self.value += self.initial * (self.renewal * dt * float(arrives))

    def _plan(self, dt: float) -> tuple[int, tuple[np.float32, ...], Any, Any]:
        """Return the number of steps in `dt` seconds, the flow along each axis per step, and the shares of
        the initial content and of the inflow that are left after `dt`."""
        rates = [self.diffusion * power(float(i), 2) for i in self.inverse]
        steps, lost = max(1, math.ceil(dt * sum(rates) * 2 / 0.9)), (self.decay + self.renewal) * dt
        a = np.array([dt * r / steps for r in rates], np.float32)
        kind = self.value.dtype.type
        left, arrives = scalars.exp(-lost), -scalars.expm1(-lost) / lost if lost else 1.0
        return steps, (a[0], a[1], a[2]), kind(left), kind(arrives)

    def sample(self, x: np.ndarray, y: np.ndarray, z: np.ndarray, out: np.ndarray) -> None:
        """Write the field at given positions, interpolated linearly between cell centers.

        Parameters
        ----------
        x, y, z : array of float32, shape (n,)
            Coordinates [m].
        out : array of float32, shape (n,)
            Receives the values.
        """
        sample(self.value, Places(x, y, z), self.inverse, self.space.torus, out)


@lone_njit
def _deposit(source: np.ndarray, places: Places, amount: Number, inverse: np.ndarray) -> None:
    flat, cell = source.reshape(-1), np.empty(BLOCK, np.int32)
    for first in range(0, places.x.size, BLOCK):
        size = min(BLOCK, places.x.size - first)
        cells_at(first, size, places, source.shape, inverse, cell)
        for k in range(size):
            flat[np.uint32(cell[k])] += of_row(amount, first + k)


@njit
def _flow(
    value: np.ndarray,
    source: np.ndarray,
    other: np.ndarray,
    places: Places,
    amount: Number,
    inverse: np.ndarray,
    steps: int,
    a: tuple[np.float32, ...],
    left: np.floating,
    arrives: np.floating,
    torus: bool,
) -> None:
    """Add amounts to the source, scale the source and the field by their remaining shares, and diffuse the
    sum in steps that alternate between two arrays. After an odd number of steps, the result is in `other`."""
    _deposit(source, places, amount, inverse)
    for k in range(value.shape[0]):
        for j in range(value.shape[1]):
            for i in range(value.shape[2]):
                value[k, j, i] = left * value[k, j, i] + arrives * source[k, j, i]
                source[k, j, i] = 0
    for step in range(steps):
        if step % 2 == 0:
            _diffuse(value, other, a, torus)
        else:
            _diffuse(other, value, a, torus)


@njit
def _diffuse(now, new, a, torus):
    (nz, ny, nx), (ax, ay, az) = now.shape, a
    for k in range(nz):
        below, above = max(k - 1, 0), min(k + 1, nz - 1)
        for j in range(ny):
            south = j - 1 if j > 0 else (ny - 1 if torus else 0)
            north = j + 1 if j < ny - 1 else (0 if torus else ny - 1)
            lower, upper, row, front, back, out = (
                now[below, j],
                now[above, j],
                now[k, j],
                now[k, south],
                now[k, north],
                new[k, j],
            )
            for i in range(1, nx - 1):  # branch-free, so that it vectorizes
                c = row[i]
                flow = ax * (row[i - 1] + row[i + 1] - c - c) + ay * (front[i] + back[i] - c - c)
                flow += az * (lower[i] + upper[i] - c - c)
                out[i] = c + flow
            for i in (0, nx - 1):
                west = i - 1 if i > 0 else (nx - 1 if torus else 0)
                east = i + 1 if i < nx - 1 else (0 if torus else nx - 1)
                c = row[i]
                flow = ax * (row[west] + row[east] - c - c) + ay * (front[i] + back[i] - c - c)
                flow += az * (lower[i] + upper[i] - c - c)
                out[i] = c + flow


@njit
def at(value, x, y, z, inverse, torus):
    """Return the field at one position, interpolated linearly between cell centers."""
    nz, ny, nx = value.shape
    gx, gy, gz = (
        x * inverse[0] - np.float32(0.5),
        y * inverse[1] - np.float32(0.5),
        z * inverse[2] - np.float32(0.5),
    )
    i0, j0 = floor_between(gx, -1, nx - 1), floor_between(gy, -1, ny - 1)
    fx, fy = gx - np.float32(i0), gy - np.float32(j0)
    i1, j1 = i0 + 1, j0 + 1
    if torus:
        i0, i1 = (i0 + nx if i0 < 0 else i0), (i1 - nx if i1 >= nx else i1)
        j0, j1 = (j0 + ny if j0 < 0 else j0), (j1 - ny if j1 >= ny else j1)
    else:
        i0, i1, j0, j1 = (
            min(max(i0, 0), nx - 1),
            min(max(i1, 0), nx - 1),
            min(max(j0, 0), ny - 1),
            min(max(j1, 0), ny - 1),
        )
    one = np.float32(1.0)
    if nz == 1:
        return _plane(value[0], i0, i1, j0, j1, fx, fy)
    k0 = floor_between(gz, -1, nz - 1)
    fz = gz - np.float32(k0)
    low, high = min(max(k0, 0), nz - 1), min(max(k0 + 1, 0), nz - 1)
    return (one - fz) * _plane(value[low], i0, i1, j0, j1, fx, fy) + fz * _plane(
        value[high], i0, i1, j0, j1, fx, fy
    )


@njit
def _plane(v, i0, i1, j0, j1, fx, fy):
    one = np.float32(1.0)
    return (one - fy) * ((one - fx) * v[j0, i0] + fx * v[j0, i1]) + fy * (
        (one - fx) * v[j1, i0] + fx * v[j1, i1]
    )


@njit
def sample(value: np.ndarray, places: Places, inverse: np.ndarray, torus: bool, out: np.ndarray) -> None:
    """Write the field at each position to `out`."""
    x, y, z = places
    for i in range(x.size):
        out[i] = at(value, x[i], y[i], z[i], inverse, torus)
