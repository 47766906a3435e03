"""Write a world recorded in memory to a folder, as a run."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import Halted, RecordingError
from ecs_eco.engine.interruption import require_whole
from ecs_eco.record.claim import Claim
from ecs_eco.record.recorder import Recorder
from ecs_eco.runs.begin import begun, opened
from ecs_eco.runs.requests import asked_by_hand, waiting
from ecs_eco.runs.run import close, manifest_of
from ecs_eco.worlds.policies import weights_files


def to_folder(world: World, out: str | Path | Claim) -> dict[str, Any]:
    """Write a world and its recording in memory to a new folder, as `World.to_folder` describes."""
    require_whole(world, "to_folder")
    start = _start(world)
    recorder, config = world.recorder, world.recorder.began  # interventions may have changed world.config
    manifest = manifest_of(world, world.tick, **start) | {
        "config": config.resolved(),
        "config_hash": config.config_hash,
        "asked": asked_by_hand(world, config.interventions),
        "snapshot_every": recorder.snapshot_every or max(1, world.tick - 1),
        "checkpoint_every": None,
        "keep": 1,
        "record": None,
        "until": [],
    }
    if len(words := set(start["policies"].values())) == 1:
        manifest["policies"] = words.pop()
    with begun(out) as claim:
        folder = opened(world, claim, manifest, weights_files(config, start["policies"]))
        try:
            with recorder.written_to(folder.sink):
                close(world, folder, manifest, finished=True, last=True)
        except BaseException as error:
            (claim.path / "manifest.json").unlink(missing_ok=True)
            for kind in folder.parts:
                shutil.rmtree(claim.path / kind, ignore_errors=True)
            if isinstance(error, Halted) and error.__cause__ is not None:
                raise error.__cause__ from None
            raise
    return manifest


def _start(world: World) -> dict[str, Any]:
    """Return the arguments that built a world; raise RecordingError if it cannot be written as a run."""
    recorder, start = world.recorder, world.start
    needed = "World.from_config(…, record=False) and Recorder(world, keep_events=True) before the first tick"
    if start is None:
        fault = "was built by hand, built for training, restored or copied"
    elif recorder is None or recorder.sink is not None or not recorder.keeps:
        fault = "has no recorder that keeps events in memory"
    elif sum(isinstance(system, Recorder) for system in world.systems) > 1:
        fault = "has more than one recorder"
    elif not np.array_equal(np.unique(recorder.since(-1)["tick"]), np.arange(world.tick)):
        fault = "was not recorded from its first tick on"
    elif waiting(world):
        fault, needed = (
            "has interventions waiting for its next tick",
            "a call after that tick: run one more first",
        )
    else:
        return start
    raise RecordingError(
        f"world {world.name!r} {fault}, so it cannot be written to a folder; expected {needed}"
    )
