"""Checks of fields, ground and ambient values, all of which users can set between ticks."""

import numpy as np

from ecs_eco.engine.rows import first_outside
from ecs_eco.space.environment import Surroundings
from ecs_eco.space.terrain import FENCE

ONE = np.ones(1, np.int64)
MOST = float(np.finfo(np.float32).max)
FINITE = np.array([-MOST], np.float32), np.array([MOST], np.float32)
CONCENTRATION = np.zeros(1), np.array([MOST])
GROUND = np.zeros(1, np.uint8), np.array([FENCE], np.uint8)
NUMBER = int, float, np.floating, np.integer
AMBIENT = ("temperature", "pressure", "light")


def check_surroundings(world: Surroundings) -> None:
    """Raise a ValueError that names a field, ground or ambient value that kernels cannot use."""
    for name, field in world.fields.items():
        finite = FINITE if field.substance is None else CONCENTRATION
        _check_form(f"field {name!r}: source", field.source, field.shape[::-1], finite[0].dtype)
        _check_map(
            f"field {name!r}: value",
            field.value,
            field.shape[::-1],
            finite,
            "finite numbers" if field.substance is None else "concentrations, 0 or more [mol/L]",
        )
    if world.terrain is not None:
        shape = world.terrain.shape
        _check_map("terrain: height", world.terrain.height, shape, FINITE, "finite numbers [m]")
        _check_map("terrain: ground", world.terrain.ground, shape, GROUND, "0 open, 1 water, 2 rock, 3 fence")
    for quantity, value in world.environment.ambient.items():
        if not isinstance(value, NUMBER) or not -MOST <= float(value) <= MOST:
            raise ValueError(f"ambient[{quantity!r}] is {value!r}; expected: finite numbers")
    for quantity in AMBIENT:
        if quantity not in world.environment.ambient:
            raise ValueError(f"ambient has no {quantity!r}; it needs {', '.join(AMBIENT)}")


def _check_map(
    name: str, values: np.ndarray, shape: tuple[int, ...], limits: tuple[np.ndarray, np.ndarray], allowed: str
) -> None:
    low, high = limits
    _check_form(name, values, shape, low.dtype)
    if first_outside((values.reshape(-1),), 0, values.size, ONE, low, high) >= 0:
        cell = tuple(int(i) for i in np.argwhere(~((values >= low[0]) & (values <= high[0])))[0])
        raise ValueError(f"{name} is {values[cell]} in cell {cell}; expected: {allowed}")


def _check_form(name: str, values: np.ndarray, shape: tuple[int, ...], dtype: np.dtype) -> None:
    if getattr(values, "dtype", None) != dtype or values.shape != shape or not values.flags.c_contiguous:
        given = f"{values.dtype}{list(values.shape)}" if isinstance(values, np.ndarray) else repr(values)
        raise ValueError(
            f"{name} is {given}; expected: {np.dtype(dtype)}{list(shape)} without gaps; assign in place: "
            "[...] = …"
        )
