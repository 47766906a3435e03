"""The readers that must reject a folder that contains another run's file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from studies.common.foreign.ground import TICKS, config

Read = Callable[[], Any]


def resuming(run: Path) -> Read:
    """Resume a run."""
    from ecs_eco.record import resume

    return lambda: resume(run, TICKS + 5, report=False, complain=lambda text: None)


def reporting(run: Path) -> Read:
    """Report on a run."""
    from ecs_eco.analysis.report import write_report

    return lambda: write_report(run)


def repeating(run: Path) -> Read:
    """Repeat a run."""
    from ecs_eco.runs.repeat import repeat

    return lambda: repeat(run)


def comparing(run: Path, seed: int, **arm: Any) -> Read:
    """Run a comparison that reuses existing results."""
    from ecs_eco.lab.jobs import has_run
    from ecs_eco.lab.treatments import Arm

    return lambda: has_run(Arm("world", config(), **arm), seed, TICKS, run)


def part(kind_: str, number: int = 0) -> str:
    """Return a part's name within its run."""
    return f"{kind_}/part-{number:05d}.parquet"
