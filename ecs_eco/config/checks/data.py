"""Checks of [data]: what its columns are compared with is there."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import Problem, listed, nearest


def check_data(config: WorldConfig) -> Iterator[Problem]:
    """The problems of names; the file is read where it is used."""
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
