"""A finished search, for its report."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ecs_eco.search.journal import Journal
from ecs_eco.search.plan import Plan
from ecs_eco.search.sampler import Sampler

BEST = 5  # worlds that are written
Runs = list[dict[str, Any]]  # entries of the journal, or runs in them


@dataclass(frozen=True)
class Outcome:
    """The plan and means of a search, and all its candidates, the best first."""

    plan: Plan
    journal: Journal
    ranked: Runs
    out: Path
    optimiser: str
    workers: int
    cpu: float  # CPU seconds of candidates
    sampler: Sampler | None = None  # of abc and abc-smc

    def evaluated(self) -> Runs:
        """The candidates whose numbers made a world, in their order."""
        return sorted(
            (e for e in self.journal.of("candidate") if "refused" not in e), key=lambda e: int(e["candidate"])
        )
