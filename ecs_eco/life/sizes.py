"""The sizes and masses of newborns and founders that differ within a species, and the consequences of these
differences."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.elementary import power
from ecs_eco.components import Body, Stature, Traits
from ecs_eco.genomes.own_values import own_value

if TYPE_CHECKING:
    from ecs_eco.config.models.species import Species
    from ecs_eco.engine.table import Table

Values = dict[tuple[type, str], np.ndarray]
TINY = np.float32(1e-30)  # [kg]


def of_newborn(table: Table, values: Values, n: int) -> Values:
    """Return the masses and radii of `n` newborns whose other columns are `values`, omitting columns that
    keep the species' values or those in `values`."""
    way, at = table.species.growth, table.species.traits.get("growth.newborn")
    own = None if at is None else values.get((Traits, "value"))  # none if genes are neutral
    share = 1.0 if way is None else way.newborn if own is None else own[:, at]
    return _bodies(table, values, n, share)


def of_adults(table: Table, values: Values, n: int) -> Values:
    """Return the masses and radii of `n` adults whose other columns are `values`, omitting columns that keep
    the species' values or those in `values`."""
    return _bodies(table, values, n, 1.0)


def masses_differ(species: Species) -> bool:
    """Return whether the members of a species, a section of the world file, may have different masses,
    because they grow or genes code for mass or for the radius of a body with a density."""
    genome, coded = species.genome, set()
    if genome is not None:
        coded = {gene.trait for gene in genome.genes} | {one.trait for one in genome.derived.values()}
    return (
        species.growth is not None
        or "body.mass" in coded
        or ("body.radius" in coded and species.body.density is not None)
    )


def radii_differ(table: Table) -> bool:
    """Return whether the bodies of a species may have different radii, because they grow or a gene codes for
    the radius."""
    heredity = table.species.heredity
    return table.species.growth is not None or (
        heredity is not None and any(target[:2] == (Body, "radius") for target in heredity.targets.values())
    )


def upkeep(table: Table) -> np.ndarray:
    """Return the factor of each body's basal rate, (mass/standard mass)^0.75 (Kleiber 1932), for a species whose
    members may have different masses: f32[high]."""
    assert table.species.standard_mass is not None
    relative = table[Body].mass[: table.high] / np.float32(table.species.standard_mass)
    scale: np.ndarray = power(relative, np.float32(0.75)).astype(np.float32)
    return scale


def share_of_adult(table: Table) -> np.ndarray:
    """Return each body's mass as a share of its adult mass, at most 1: f32[high]."""
    share = table[Body].mass[: table.high] / np.maximum(table[Stature].mass[: table.high], TINY)
    least: np.ndarray = np.minimum(share, np.float32(1))
    return least


def of_size(table: Table, store: Any) -> Any:
    """Return the maximum energy of a species' bodies if adults can store `store`, a number or an array
    [high]: `store` itself or, if the young store less, an array [high] of its type."""
    way = table.species.growth
    if way is None:
        return store
    exponent = own_value(table, "growth.store", np.float32(way.store))
    if not isinstance(exponent, np.ndarray) and exponent == 0:
        return store
    return np.asarray(store * power(share_of_adult(table), exponent), getattr(store, "dtype", np.float64))


def _bodies(table: Table, values: Values, n: int, share: Any) -> Values:
    """Return bodies shaped like adults but with a share of their mass. Adult mass is density × volume if the
    radius is heritable and the mass is not."""
    grows = table.species.growth is not None
    adult: type = Stature if grows else Body
    out: Values = {}
    radius = None
    if table.species.body.density is not None:
        radius = values.get((adult, "radius"))
    if radius is not None and (adult, "mass") not in values:
        body = table.species.body
        larger = power(radius.astype(np.float64) / body.radius, 3)
        out[adult, "mass"] = (body.mass * larger).astype(np.float32)
    if not grows:
        return out
    known = values | out
    mass, radius = (
        np.broadcast_to(known.get((Stature, f), table.defaults[Stature][f]), n) for f in ("mass", "radius")
    )
    share = np.asarray(share, np.float64)
    return out | {
        (Body, "mass"): mass * share.astype(np.float32),
        (Body, "radius"): radius * power(share, 1 / 3).astype(np.float32),
    }
