"""The land of a run, stored in its folder for figures and resuming: relief, ground and real elevations."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.engine import files
from ecs_eco.engine.errors import CheckpointError, ConfigError
from ecs_eco.record.claim import LAND

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld


def keep_land(world: SpatialWorld, folder: Path) -> str | None:
    """Write a world's land to the folder of its run; return the hash of its real elevations, if any."""
    terrain, land = world.terrain, getattr(world.config, "_land", None)
    if terrain is None or getattr(world.config, "terrain", None) is None:
        return None
    arrays: dict[str, Any] = {"height": terrain.height, "ground": terrain.ground}
    if terrain.land is not None and terrain.land.wet is not None:
        arrays["wet"] = terrain.land.wet
    if land is not None:
        arrays |= land.arrays()
    with files.writing(folder / LAND) as beside, open(beside, "wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
    return None if land is None else str(land.sha256)


def folder_of_land(config: Mapping[str, Any], run: Path, otherwise: Path) -> Path:
    """Return the folder that contains a world's land: the run's folder if the land is stored there."""
    real = (config.get("terrain") or {}).get("raster")
    return run if real and (run / LAND).is_file() else otherwise


def take_land(config: Any, meta: Mapping[str, Any], where: str) -> None:
    """Load a checkpoint's land into its configuration; raise CheckpointError if the land has changed."""
    config._source = where
    config._folder = folder_of_land(meta["config"], Path(where).parent.parent, Path(meta["folder"]))
    if config.terrain is None or config.terrain.raster is None:
        return
    from ecs_eco.config.land.land import read_land

    try:
        land = read_land(config.terrain, config.space.size, config.folder)
    except ConfigError as error:
        raise CheckpointError(f"{where}: its land is unavailable: {error}") from None
    if meta.get("land") != land.sha256:
        raise CheckpointError(f"{where}: the land in {config.folder} has changed since it was saved")
    config._land = land
