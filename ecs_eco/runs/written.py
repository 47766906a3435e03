"""Write a world that was recorded in memory as the folder of a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import RecordingError
from ecs_eco.engine.interruption import require_whole
from ecs_eco.record.claim import Claim
from ecs_eco.runs.begin import begun, keep_manifest, opened
from ecs_eco.runs.requests import asked_by_hand
from ecs_eco.runs.run import close, manifest_of
from ecs_eco.worlds.policies import weights_files


def to_folder(world: World, out: str | Path | Claim) -> dict[str, Any]:
    """Write a world and all that its recorder keeps in memory to a new folder, as `World.to_folder` describes."""
    require_whole(world, "to_folder")
    _require_records(world)
    recorder, origin = world.recorder, world.origin
    config = recorder.began  # interventions can have changed the world's own
    manifest = manifest_of(world, world.tick, origin["policies"], origin["learn"], origin["controls"]) | {
        "config": config.resolved(),
        "config_hash": config.config_hash,
        "asked": asked_by_hand(world),
        "snapshot_every": recorder.snapshot_every or max(1, world.tick - 1),
        "checkpoint_every": None,
        "keep": 1,
        "record": None,
        "until": [],
    }
    with begun(out) as claim:
        folder = opened(world, claim, manifest, weights_files(config, origin["policies"]))
        keep_manifest(folder, manifest | folder.written)
        with recorder.written_to(folder.sink):
            close(world, folder, manifest, finished=True, last=True)
    return manifest


def _require_records(world: World) -> None:
    """Raise RecordingError unless the world's recorder keeps everything since tick 0."""
    recorder, needed = world.recorder, "Recorder(world, keep_events=True), before its first tick"
    if world.config is None or "learn" not in world.origin:
        fault, needed = "was built by hand", "a world from World.from_config"
    elif recorder is None or not recorder.keeps:
        fault = "has no recorder that keeps events"
    elif recorder.sink is not None:
        fault, needed = "is already recorded in a folder or by a sink", "a recorder in memory"
    elif not np.array_equal(np.unique(recorder.since(-1)["tick"]), np.arange(world.tick)):
        fault = "was not recorded from its first tick on"
    else:
        return
    raise RecordingError(
        f"world {world.name!r}: {fault}, so it cannot be written to a folder; expected {needed}"
    )
