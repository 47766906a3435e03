"""Organisms without parents, at the start and later: their positions and initial state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Biology, Metabolism, Position, Traits
from ecs_eco.engine import random
from ecs_eco.life import sizes
from ecs_eco.space.geometry import cells_of

if TYPE_CHECKING:
    from ecs_eco.config.models.species import Species
    from ecs_eco.config.models.surroundings import ObjectType
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

NERVOUS_SPREAD = 0.25  # hungry to well fed, so that founders do not all starve in the same tick
Values = dict[tuple[type, str], np.ndarray]


def future(world: SpatialWorld, table: Table, n: int) -> np.ndarray:
    """Return identities u64[n] for newcomers: future uids, which no draw has used yet."""
    return np.arange(n, dtype=np.uint64) + np.uint64(world.next_uid + table.waiting)


def newcomers(
    table: Table,
    world: SpatialWorld,
    kind: ObjectType | Species | None,
    identity: np.ndarray,
    within: Any = None,
    place: Sequence[float] | None = None,
) -> Values:
    """Return the columns of newcomers of a species or object type, drawn for `identity` u64[k]; plants
    without a site are left out.

    They all appear at `place` [m] if it is given; otherwise at random positions, in the region `within` if
    given.
    """
    values = scatter(table, world, identity, within)
    way = getattr(kind, "reproduction", None)
    if place is not None:
        for axis, at in zip("xyz", place, strict=False):
            values[Position, axis] = np.full(identity.size, at, np.float32)
    elif way is not None and way.kind == "spread":
        one_a_site(table, world, way.spacing, values, within)
    count = values[Position, "x"].size
    span = getattr(kind, "age", None)
    if span is not None:
        u = random.draw_many(world.key, identity[:count], random.SEX + (2 << 8) + ((table.place + 1) << 20))
        values[Biology, "age"] = (np.float32(span[0]) + np.float32(span[1] - span[0]) * u).astype(np.float32)
    if spread := energy_spread(table, kind):
        budget = kind.metabolism  # type: ignore[union-attr]  # objects have no spread
        u = random.draw_many(world.key, identity[:count], random.BIRTH + ((table.place + 1) << 20))
        values[Metabolism, "energy"] = (
            (np.float32(budget.energy) * (np.float32(1 - spread) + np.float32(2 * spread) * u))
            .clip(0, budget.energy_max)
            .astype(np.float32)
        )
    if (heredity := table.species.heredity) is not None:
        values |= heredity.founders(world, table, identity[:count])
        _keep_within_stores(table, values)
    return values | sizes.of_adults(table, values, count)


def energy_spread(table: Table, kind: ObjectType | Species | None) -> float:
    """Return the maximum deviation of founders' energy from `metabolism.energy`, as a share of
    `metabolism.energy`."""
    way = getattr(kind, "metabolism", None)  # objects with energy have no spread
    if Metabolism not in table or way is None:
        return 0.0
    given: float | None = way.energy_spread
    return (NERVOUS_SPREAD if table.species.nerves is not None else 0.0) if given is None else given


def _keep_within_stores(table: Table, values: Values) -> None:
    """Limit the initial energy to each organism's own storage capacity, if a gene codes for it."""
    at = table.species.traits.get("metabolism.energy_max")
    if at is not None and (Traits, "value") in values:
        most = values[Traits, "value"][:, at]
        begun = values.get((Metabolism, "energy"), table.defaults[Metabolism]["energy"])
        values[Metabolism, "energy"] = np.minimum(begun, most).astype(np.float32)


def scatter(table: Table, world: SpatialWorld, identity: np.ndarray, within: Any = None) -> Values:
    """Return random positions on open ground, headings and sexes for newcomers, drawn for `identity` u64[k]."""
    space, key = world.space, world.key
    salt = (table.place + 1) << 20

    def draw(axis: int, which: np.ndarray, attempt: int) -> np.ndarray:
        return random.draw_many(key, which, random.PLACE + (axis << 8) + salt + (attempt << 12))

    place = np.stack([draw(axis, identity, 0) * space.lengths[axis] for axis in range(3)], 1)
    if within is not None:
        place[:, :2] = within.places(draw(0, identity, 0), draw(1, identity, 0))
    for attempt in range(1, 64):
        blocked = (
            np.zeros(len(identity), bool)
            if world.terrain is None
            else ~world.terrain.free(place[:, 0], place[:, 1])
        )
        if not blocked.any():
            break
        for axis in range(2) if within is None else ():
            place[blocked, axis] = draw(axis, identity[blocked], attempt) * space.lengths[axis]
        if within is not None:
            place[blocked, :2] = within.places(
                draw(0, identity[blocked], attempt), draw(1, identity[blocked], attempt)
            )
    values: Values = {
        (Position, "x"): place[:, 0],
        (Position, "y"): place[:, 1],
        (Position, "z"): place[:, 2],
        (Position, "heading"): random.draw_many(key, identity, random.SEX + (1 << 8) + salt)
        * np.float32(6.2831855),
    }
    if Biology in table and table.species.sex == "random":
        values[Biology, "sex"] = np.where(
            random.draw_many(key, identity, random.SEX + salt) < 0.5, 1, 2
        ).astype(np.uint8)
    return values


def one_a_site(table: Table, world: SpatialWorld, spacing: float, values: Values, within: Any = None) -> None:
    """Move plants to free sites, drawn without replacement; plants without a site are dropped."""
    nx, ny = (max(1, round(s / spacing)) for s in world.space.size[:2])
    # distinct from the draws of Spread in the first tick and from those of other species
    key, salt = world.key, (table.place + 1) << 20
    order = np.argsort(
        random.draw_many(key, np.arange(nx * ny, dtype=np.uint64), random.SPREAD + salt), kind="stable"
    )
    x, y = _centres(order, nx, ny, world)
    open_ = ~_taken(table, world, nx, ny)[order]
    if world.terrain is not None:
        open_ &= world.terrain.free(x.astype(np.float32), y.astype(np.float32))
    if within is not None:
        open_ &= within.has(x, y)
    order = order[open_]
    site = np.sort(order[: values[Position, "x"].size])
    identity = site.astype(np.uint64)
    u, v = (
        random.draw_many(key, identity, random.PLACE + salt),
        random.draw_many(key, identity, random.PLACE + (1 << 8) + salt),
    )
    near = np.nextafter(world.space.lengths, np.float32(0))
    for axis, cells, fraction, n, i in (("x", site % nx, u, nx, 0), ("y", site // nx, v, ny, 1)):
        values[Position, axis] = np.minimum(
            (cells + fraction) * np.float32(world.space.size[i] / n), near[i]
        ).astype(np.float32)
    if world.terrain is not None:
        middle = (each.astype(np.float32) for each in _centres(site, nx, ny, world))
        values[Position, "x"], values[Position, "y"] = world.terrain.within_sites(
            values[Position, "x"], values[Position, "y"], *middle
        )
    for name in ("z", "heading"):
        values[Position, name] = values[Position, name][: site.size]
    for column in [k for k in values if k[0] is Biology]:
        values[column] = values[column][: site.size]


def _centres(site: np.ndarray, nx: int, ny: int, world: SpatialWorld) -> tuple[np.ndarray, np.ndarray]:
    """Return the centers of sites: x, y f64[k] [m]."""
    return ((site % nx) + 0.5) * world.space.size[0] / nx, ((site // nx) + 0.5) * world.space.size[1] / ny


def _taken(table: Table, world: SpatialWorld, nx: int, ny: int) -> np.ndarray:
    """Return which sites are occupied, or will be at the end of the tick: bool[ny · nx]."""
    p, rows, taken = table[Position], table.rows(), np.zeros(nx * ny, bool)
    requested = [values for _, _, values in table.births if (Position, "x") in values]
    inverse = np.array([nx / world.space.size[0], ny / world.space.size[1]], np.float32)
    for x, y in [(p.x[rows], p.y[rows]), *((v[Position, "x"], v[Position, "y"]) for v in requested)]:
        taken[cells_of(y, inverse[1], ny) * nx + cells_of(x, inverse[0], nx)] = True
    return taken
