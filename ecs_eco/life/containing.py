"""The columns, fields and ledgers needed to move substances and account for them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Chemistry, Matter, Shape
from ecs_eco.config import WorldConfig
from ecs_eco.config.features.chemistry import Emission
from ecs_eco.life.matter import Books
from ecs_eco.space.field import Field
from ecs_eco.space.geometry import cells_of

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld


def contain(world: SpatialWorld, config: WorldConfig) -> None:
    """Fill the substance fields."""
    for name, kind in config.fields.items():
        if kind.substance is not None:
            field = world.fields[name]
            initial = np.full(field.value.shape, kind.initial or 0.0)
            if kind.only is not None:
                initial[:, _lakes(world, field) != (kind.only == "lakes")] = 0.0
            field.contain(kind.substance, kind.depth or 1.0, initial, kind.renewal or 0.0)


def _lakes(world: SpatialWorld, field: Field) -> np.ndarray:
    """Return which columns of a field's cells are in a lake: bool[ny, nx]."""
    nx, ny = field.shape[:2]
    x, y = (np.arange(nx) + 0.5) / field.inverse[0], (np.arange(ny) + 0.5) / field.inverse[1]
    terrain = world.terrain
    if terrain is None:
        return np.zeros((ny, nx), np.bool_)
    j = cells_of(y, terrain.inverse[1], terrain.shape[0])
    return terrain.wet()[np.ix_(j, cells_of(x, terrain.inverse[0], terrain.shape[1]))]


def add_matter(world: SpatialWorld, config: WorldConfig) -> None:
    """Add `Matter` to tables whose substances move, by reactions, exchange, decomposition, smells, births or
    food that contains substances, and to tables of their remains."""
    kinds: dict[str, Any] = {**config.objects, **config.species}
    moves = [
        name
        for name, kind in kinds.items()
        if Chemistry in world.tables[name]
        and (
            kind.reactions
            or kind.exchange
            or getattr(kind, "decomposition", None) is not None
            or any(isinstance(way, Emission) and way.consume for way in kind.emits.values())
            or any(Chemistry in world.tables[food.eats] for food in getattr(kind, "diet", ()))
            or getattr(kind, "born_with", "declared") != "declared"
        )
    ]
    left = [left for name in moves if (left := getattr(kinds[name], "remains", None)) is not None]
    # the same amounts give a different concentration in remains whose shape differs from the body's
    left += [
        species.remains
        for name, species in config.species.items()
        if species.remains is not None
        and Chemistry in world.tables[name]
        and (Shape in world.tables[name]) != (Shape in world.tables[species.remains])
    ]
    for name in dict.fromkeys([*moves, *left]):
        world.tables[name].add_component(Matter)


def keep_books(world: SpatialWorld) -> None:
    """Start the ledger of matter for a world in which bodies or fields contain substances."""
    if any(Chemistry in table for table in world.tables.values()) or any(
        field.substance is not None for field in world.fields.values()
    ):
        world.matter = Books(world)
        world.matter.watch(world)
