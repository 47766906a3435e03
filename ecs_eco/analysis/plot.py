"""A living world's series as a figure, for notebooks."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ecs_eco.analysis.figures import interventions, mark, populations
from ecs_eco.analysis.runs import Series, load_series
from ecs_eco.analysis.style import Figure, colors_of, panels, styled
from ecs_eco.engine.errors import unknown_name


def plot(world: Any, column: str = "n", species: Sequence[str] | None = None) -> Figure:
    """Return a column of a world's series over time, with one line per species; notebooks display it.

    Raises RuntimeError if nothing is recorded, KeyError for an unknown column or species.
    """
    series = load_series(world.series(), species)
    colours = {name: table.species.color for name, table in world.tables.items() if table.species.color}
    series = replace(series, manifest={"colors": colours, "dt": world.dt, "intervened": world.intervened})
    if column not in series.columns:
        raise KeyError(unknown_name("the series", "column", column, [*series.columns]))
    return populations(series) if column == "n" else over_time(series, column)


@styled
def over_time(series: Series, column: str) -> Figure:
    """Draw a column over time, with one line for each species that has it."""
    figure, ((ax,),) = panels(1, 1, 9, 3.6)
    hue = colors_of(series)
    for name in series.species:
        values = series.of(name, column)
        if np.any(np.nan_to_num(values)):
            ax.plot(series.ticks, values, color=hue[name], label=name)
    ax.set(xlabel="tick", ylabel=column)
    if ax.get_lines():
        figure.legend(loc="outside upper left", ncols=len(series.species))
    ax.margins(x=0)
    mark(ax, interventions(series))
    return figure
