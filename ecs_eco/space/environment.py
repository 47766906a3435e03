"""Surroundings of organisms: light, temperature, pressure, sun, water, and functions of position."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ecs_eco.engine.living import LivingWorld
from ecs_eco.space.sun import Sun
from ecs_eco.space.water import Water
from ecs_eco.space.year import Year

if TYPE_CHECKING:
    from ecs_eco.space.field import Field
    from ecs_eco.space.geometry import Space
    from ecs_eco.space.terrain import Terrain

Quantity = Callable[..., np.ndarray]
"""f(world, x, y, z), with coordinates f32[n] [m], returns one number per position or one for all."""


class Environment(dict[str, Quantity]):
    """Functions of position by quantity ("light", "temperature" [K], "pressure" [Pa]); each replaces a
    constant in `ambient`.

    The sun, the water and the year provide such functions; functions set by the user take precedence.
    """

    def __init__(self) -> None:
        super().__init__()
        self.ambient: dict[str, float] = {"temperature": 285.0, "pressure": 101_325.0, "light": 1.0}
        self.sun: Sun | None = None  # a sun that rises and sets
        self.water: Water | None = None  # water that fills a volume
        self.year: Year | None = None  # a year with seasons

    def set_climate(self, sun: Sun | None, water: Water | None, year: Year | None = None) -> None:
        """Replace the sun, the water and the year."""
        for quantity in ("light", "temperature", "pressure"):
            if getattr(self.get(quantity), "of_climate", False):
                del self[quantity]
        self.sun, self.water, self.year = sun, water, year
        warms = year is not None and year.temperature != 0

        def light(world: LivingWorld, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
            surface = self.ambient["light"] * (1.0 if sun is None else sun.light(world.time))
            return np.full(x.size, surface, np.float32) if water is None else water.light(surface, z)

        def temperature(world: LivingWorld, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
            surface = self.ambient["temperature"] + (0.0 if year is None else year.warming(world.time))
            surface = max(surface, 0.0)
            return np.full(x.size, surface, np.float32) if water is None else water.temperature(surface, z)

        def pressure(world: LivingWorld, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
            return water.pressure(self.ambient["pressure"], z)  # type: ignore[union-attr]

        for function in (light, temperature, pressure):
            if (
                water is not None
                or (sun is not None and function is light)
                or (warms and function is temperature)
            ):
                function.of_climate = True  # type: ignore[attr-defined]
                self[function.__name__] = function


class Surroundings(LivingWorld, Protocol):
    """The attributes that this module uses in a world with positions; `ecs_eco.space.world` implements them."""

    space: Space
    environment: Environment
    fields: dict[str, Field]
    terrain: Terrain | None
