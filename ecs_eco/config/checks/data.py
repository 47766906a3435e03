"""Checks of [data]: what its columns are compared with is there."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest


def check_measurements(config: WorldConfig) -> list[Problem]:
    """The problems of the file of [data], as `ecs_eco.config.measurements` finds them."""
    if config.data is None:
        return []
    from ecs_eco.config.measurements import measured

    try:
        measured(config)
    except ConfigError as error:
        return list(error.problems)
    return []


def check_data(config: WorldConfig) -> Iterator[Problem]:
    """The problems of names."""
    if config.data is None:
        return
    known, taken = [*config.species, *config.reporters], set()
    for column, name in config.data.columns.items():
        key = ("data", "columns", column)
        if name not in known:
            yield Problem(key, "no such species or reporter", name, listed(known), nearest(name, known))
        elif name in taken:
            yield Problem(key, "another column is compared with it, too", name, "a column for each")
        taken.add(name)
