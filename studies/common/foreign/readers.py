"""Who reads a folder with a foreign file in it, and must refuse it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from studies.common.foreign.ground import TICKS, config

Read = Callable[[], Any]


def resuming(run: Path) -> Read:
    """Going on with a run."""
    from ecs_eco.record import resume

    return lambda: resume(run, TICKS + 5, report=False, complain=lambda text: None)


def reporting(run: Path) -> Read:
    """The report of a run."""
    from ecs_eco.analysis.report import write_report

    return lambda: write_report(run)


def repeating(run: Path) -> Read:
    """A run once more."""
    from ecs_eco.runs.repeat import repeat

    return lambda: repeat(run)


def comparing(run: Path, seed: int, **arm: Any) -> Read:
    """A comparison that looks for what is there already."""
    from ecs_eco.lab.arm import Arm
    from ecs_eco.lab.runs import has_run

    return lambda: has_run(run, TICKS, Arm("world", config(), **arm), seed)


def part(kind_: str, number: int = 0) -> str:
    """Name of a part in its run."""
    return f"{kind_}/part-{number:05d}.parquet"
