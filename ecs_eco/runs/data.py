"""The outside series of a world, in the folder of its run, where its report finds it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ecs_eco.engine import files


def keep_data(config: Any, folder: Path) -> None:
    """Copy the file that [data] names into the folder of a run; none where the world has none, or is one of
    a record whose file is not at hand.

    Raises ConfigError where the file of a world file cannot be used.
    """
    if getattr(config, "data", None) is None:
        return
    from ecs_eco.analysis.against import KEPT
    from ecs_eco.config.measurements import measured

    if measured(config, config._source) is not None:
        files.write(folder / KEPT, config.file(config.data.file).read_bytes())
