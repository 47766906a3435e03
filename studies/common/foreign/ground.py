"""The sources of foreign files: runs, a fork, a comparison, training runs and searches."""

from __future__ import annotations

from pathlib import Path
from typing import Any

TICKS = 30
LIVES = {
    "species.grass.count": 60,
    "species.deer.count": 12,
    "species.wolf.count": 3,
    "space.size": [60.0, 60.0],
}
POLICIES = ("deer", "wolf")


def make(place: Path) -> None:
    """Create the sources of foreign files: runs, a fork, a comparison, training runs and searches."""
    from ecs_eco.config import load
    from ecs_eco.lab.pretraining import pretrain
    from ecs_eco.lab.searching.journal import Journal
    from ecs_eco.record import fork, run_to_folder

    config = load("predator-prey", LIVES)

    def run(name: str, seed: int, **more: Any) -> None:
        run_to_folder(
            config, seed, TICKS, place / name, report=False, checkpoint_every=10, snapshot_every=5, **more
        )

    run("a", 1, record="focal=2")
    run("b", 2, record="focal=2")
    run("asked", 1, record="focal=2", prepare=_ask)
    run_to_folder(config, 1, TICKS // 2, place / "half", report=False, checkpoint_every=10, snapshot_every=5)
    fork(place / "a", place / "fork", from_tick=10, report=False)
    short = load(config, {"training.ticks": 3})
    for seed in (1, 2):
        pretrain(short, seed, out=place / "trained" / f"seed-{seed}")
        journal = Journal(place / f"search-{seed}", {"world": "fell", "format": 1})
        for number in range(4):
            journal.add(
                "candidate",
                candidate=number,
                score=seed / (number + 1),
                stage=0,
                stages=[],
                values={},
                at=1.0,
                seconds=1.0,
            )


def _ask(world: Any) -> None:
    """Submit a manual request between two ticks."""

    def between() -> None:
        if world.tick == 5:
            world.intervene({"kind": "cull", "species": "deer", "count": 2})

    world.before_tick.append(between)


def config() -> Any:
    """Return the world used by all runs."""
    from ecs_eco.config import load

    return load("predator-prey", LIVES)
