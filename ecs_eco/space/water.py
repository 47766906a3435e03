"""A column of water: its light, temperature and pressure by depth, and its currents.

The surface is at z = height.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.space.geometry import Extent, Places, cell_of, into

GRAVITY = 9.81  # [m/s^2]


class Water:
    """Profiles over depth.

    `optical` f64[layers + 1] is the optical depth at the boundaries of the layers, from the surface down.
    """

    def __init__(
        self,
        size: Sequence[float],
        attenuation: float = 0.0,
        layer: float = 1.0,
        density: float = 1025.0,
        deep_temperature: float | None = None,
        thermocline: float = 0.0,
        thermocline_width: float = 1.0,
        current: Iterable[tuple[float, float, float]] = (),
    ) -> None:
        self.area, self.height = float(size[0] * size[1]), float(size[2])
        self.n = max(1, round(self.height / layer))
        self.layer = self.height / self.n
        self.attenuation, self.density = attenuation, density
        self.deep_temperature, self.thermocline, self.width = deep_temperature, thermocline, thermocline_width
        self.current = np.array(list(current), np.float32).reshape(-1, 3)  # depth [m], u, v [m/s]
        self.optical = attenuation * self.layer * np.arange(self.n + 1)

    def shade(self, shadows: Iterable[tuple[np.ndarray, np.ndarray, float]]) -> None:
        """Shade the water below bodies; each kind of body is given as (alive bool[n], z f32[n] [m], shaded
        area per body [m^2]).

        The optical depth of a layer is attenuation × thickness + bodies × shade / area of the water
        (Beer-Lambert).
        """
        added = np.zeros(self.n)
        for alive, z, shade in shadows:
            counts = np.zeros(self.n, np.int64)
            count(alive, z, np.float32(self.height), np.float32(1 / self.layer), counts)
            added += counts * shade / self.area
        self.optical[1:] = np.cumsum(self.attenuation * self.layer + added)

    def light(self, surface: float, z: np.ndarray) -> np.ndarray:
        """Return the light at heights z f32[n] [m] under `surface` light: f32[n]."""
        out = np.empty(z.size, np.float32)
        dim(np.float32(surface), z, np.float32(self.height), self.optical, np.float32(1 / self.layer), out)
        return out

    def temperature(self, surface: float, z: np.ndarray) -> np.ndarray:
        """Return the temperature [K] at heights z f32[n] [m]: a tanh curve from the surface temperature to
        the deep temperature."""
        if self.deep_temperature is None:
            return np.full(z.size, surface, np.float32)
        share = 0.5 * (1 + arrays.tanh((np.float32(self.height) - z - self.thermocline) / self.width))
        return (surface + (self.deep_temperature - surface) * share).astype(np.float32)

    def pressure(self, surface: float, z: np.ndarray) -> np.ndarray:
        """Return the hydrostatic pressure [Pa] at heights z f32[n] [m]."""
        return (surface + self.density * GRAVITY * (np.float32(self.height) - z)).astype(np.float32)


@njit
def count(alive, z, height, inverse, counts):
    """Count the living bodies in each layer, from the surface down."""
    for row in range(alive.size):
        if alive[row]:
            counts[cell_of((height - z[row]) * inverse, counts.size)] += 1


@njit
def dim(surface, z, height, optical, inverse, out):
    """Write surface × exp(−optical depth) at each height; the optical depth is linear within a layer."""
    last = optical.size - 2
    for i in range(z.size):
        place = max(height - z[i], np.float32(0.0)) * inverse
        k = cell_of(place, last + 1)
        tau = optical[k] + (place - k) * (optical[k + 1] - optical[k])
        out[i] = surface * np.exp(-tau)


@njit
def drift(
    first: int,
    last: int,
    alive: np.ndarray,
    current: np.ndarray,
    sinking: Number,
    dt: np.float32,
    space: Extent,
    places: Places,
) -> None:
    """Move living bodies with a current f32[k, 3] of (depth, u, v), and let them sink or rise between the
    surface and the bottom."""
    (x, y, z), lengths, torus = places, space.lengths, space.torus
    height = lengths[2]
    for row in range(first, last):
        if not alive[row]:
            continue
        if current.shape[0]:
            depth, k = height - z[row], 0
            while k < current.shape[0] and current[k, 0] <= depth:
                k += 1
            low, high = max(k - 1, 0), min(k, current.shape[0] - 1)
            span = current[high, 0] - current[low, 0]
            share = (depth - current[low, 0]) / span if span > 0 else np.float32(0.0)
            u = current[low, 1] + share * (current[high, 1] - current[low, 1])
            v = current[low, 2] + share * (current[high, 2] - current[low, 2])
            x[row], y[row] = (
                into(x[row] + u * dt, lengths[0], torus),
                into(y[row] + v * dt, lengths[1], torus),
            )
        if space.volume:
            z[row] = into(z[row] - of_row(sinking, row) * dt, lengths[2], False)


@njit
def carry(
    alive: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    w: np.ndarray,
    dt: np.float32,
    space: Extent,
    places: Places,
) -> None:
    """Move living bodies at individual velocities u, v, w f32[n]."""
    (x, y, z), lengths, torus = places, space.lengths, space.torus
    for row in range(alive.size):
        if alive[row]:
            x[row], y[row] = (
                into(x[row] + u[row] * dt, lengths[0], torus),
                into(y[row] + v[row] * dt, lengths[1], torus),
            )
            z[row] = into(z[row] + w[row] * dt, lengths[2], False)
