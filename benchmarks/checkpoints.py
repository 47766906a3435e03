"""Measure the time and size of a checkpoint, and the cost of checkpoints and recording in a run.

python benchmarks/checkpoints.py [--animals 100000] [--pairs 5]
"""

import argparse
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from ecs_eco import World
from ecs_eco.record import Recorder
from ecs_eco.record.folder import Folder


def timed(work: Any) -> float:
    """Return a call's duration [s]."""
    os.sync()
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def one(world: World, what: str, place: Path) -> dict[str, Any]:
    """Save a world three times and restore it once."""
    path = place / "world.safetensors"
    seconds = min(timed(lambda: world.save(path)) for _ in range(3))
    size = path.stat().st_size
    back = timed(lambda: World.restore(path))
    n = sum(t.n for name, t in world.tables.items() if name != "plant")
    path.unlink()
    return {
        "animals": n,
        "learning": what,
        "save [s]": seconds,
        "size [MB]": size / 1e6,
        "MB/s": size / 1e6 / seconds,
        "restore [s]": back,
    }


def sizes(animals: int, place: Path) -> list[dict[str, Any]]:
    """Measure checkpoints of a large world with learning off, and with an empty, a half-full and a full
    rollout."""
    config = _bench.savanna(animals, plants_per_animal=0.1)
    rows = [one(World.from_config(config, seed=1, policies="untrained", training=True).run(3), "off", place)]
    world = World.from_config(config, seed=1, policies="untrained", training=True, learn=True)
    horizon = world.tables["grazer"].species.nerves.learner.ppo.horizon
    rows.append(one(world, "on, rollout empty", place))
    rows.append(one(world.run(horizon // 2), "on, rollout half full", place))
    rows.append(one(world.run(horizon - horizon // 2), "on, rollout full", place))
    return rows


def overheads(pairs: int, place: Path) -> list[dict[str, Any]]:
    """Run the same world alternately: plain, with recording to disk, and with both recording and checkpoints;
    return median ratios."""

    def run(record: bool, every: int, ticks: int) -> float:
        world = World.from_config("predator-prey", seed=3, learn=False, record=not record)
        if record:
            folder = Folder(place / f"run-{time.monotonic_ns()}", world)
            folder.path.mkdir()
            Recorder(world, folder.sink, snapshot_every=100)
        world.run(50)

        def go() -> None:
            for done in range(0, ticks, every or ticks):
                world.run(min(every or ticks, ticks - done))
                if every:
                    world.save(place / "world.safetensors")

        return timed(go)

    ticks, bare, disk, kept = 3000, [], [], []
    for _ in range(pairs):
        bare.append(run(False, 0, ticks))
        disk.append(run(True, 0, ticks))
        kept.append(run(True, 1000, ticks))
    recording = [d / b - 1 for b, d in zip(bare, disk, strict=True)]
    saving = [k / d - 1 for d, k in zip(disk, kept, strict=True)]
    return [
        {
            "what": "recording every birth and death to disk, with a snapshot every 100 ticks",
            "cost to a run, median": statistics.median(recording),
            "from": min(recording),
            "to": max(recording),
            "goal": 0.10,
        },
        {
            "what": "a checkpoint every 1,000 ticks",
            "cost to a run, median": statistics.median(saving),
            "from": min(saving),
            "to": max(saving),
            "goal": 0.03,
        },
    ]


def main() -> None:
    """Measure sizes and times, then overhead."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--animals", type=int, default=100_000)
    parser.add_argument("--pairs", type=int, default=5)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        rows = sizes(asked.animals, Path(place))
        _bench.save(
            "checkpoints", "A checkpoint of a large world (goal: 0.5 s and 100 MB with learning off)", rows
        )
        rows = overheads(asked.pairs, Path(place))
        notes = {
            "run": f"predator-prey, 3,000 ticks, {asked.pairs} rounds, one after the other in one process"
        }
        _bench.save(
            "checkpoints_cost", "The cost of recording and checkpoints in a run of predator-prey", rows, notes
        )


if __name__ == "__main__":
    main()
