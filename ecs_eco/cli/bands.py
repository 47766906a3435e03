"""The options --bands and --divided of run and resume: one world in all processes that mpiexec started."""

from __future__ import annotations

from collections.abc import Callable

from ecs_eco.bands.run import together
from ecs_eco.cli.terminal import refuse, say
from ecs_eco.ecosystem import World


def run_in_bands(
    lead: Callable[[Callable[[World], None]], None],
    build: Callable[[], World],
    ticks: int | None,
    watched: bool,
    divided: bool,
) -> None:
    """Run a world in all processes: process 0 leads, records and prints statistics of the exchange; the
    other processes build it. With `divided`, each process holds a part of it."""
    if watched:
        refuse(
            "--watch",
            "is not possible with --bands: actions on a page reach only one process",
            "",
            "one of the two options; or watch the folder afterwards",
        )
    led = together(lead, build, ticks, state=divided)
    if led is not None:
        bands = led[1]
        many, held = (
            (bands.processes, "each with its own part of the world")
            if divided
            else (bands.size, "each with the whole world")
        )
        say(
            f"  {many} processes, {held}; process 0 received "
            f"{bands.traffic.received / 1e6:.1f} MB, and spent {bands.traffic.seconds:.1f} s exchanging and "
            "waiting"
        )
