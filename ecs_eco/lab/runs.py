"""One run of an arm: reused if it is done, resumed if it was stopped, otherwise started."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ecs_eco.compiled import portable
from ecs_eco.engine.errors import ForeignFile
from ecs_eco.lab.arm import Arm
from ecs_eco.lab.pool import finishing
from ecs_eco.learning.weights import hash_of
from ecs_eco.record.seal import read_manifest
from ecs_eco.worlds.policies import weights_files

EVERY = 2_000  # minimum number of ticks between the checkpoints of a run


def run_arm(
    arm: Arm,
    seed: int,
    ticks: int,
    folder: Path,
    every: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    until: Sequence[str] = (),
) -> dict[str, Any]:
    """Run an arm in a folder, with a checkpoint every `every` ticks, until a condition is true or all ticks are
    done; return its manifest. A stopped run resumes from its checkpoint, or restarts without one; nothing is
    removed. Raises FolderInUse, ForeignFile if the folder contains another run's files, and RecordingError or
    CheckpointError for a damaged file."""
    from ecs_eco.runs.run import resume, run_to_folder

    if every is None and ticks > EVERY:
        every = max(EVERY, ticks // 20)
    with finishing():
        arm.config._code.pass_on()
        if (folder / "manifest.json").is_file():
            check_run(folder, read_manifest(folder), arm, seed)
            return resume(folder, ticks, progress, report=False, complain=lambda _: None)
        return run_to_folder(
            arm.config,
            seed=seed,
            ticks=ticks,
            out=folder,
            policies=arm.policies,
            learn=arm.learn,
            controls=arm.controls,
            progress=progress,
            report=False,
            checkpoint_every=every,
            keep=1,
            until=until,
        )


def has_run(arm: Arm, seed: int, ticks: int, folder: Path) -> bool:
    """Return whether a folder contains a run of this length, or one that a condition ended. Raises errors as
    `check_run` does, and RecordingError if its manifest is damaged."""
    try:
        manifest = read_manifest(folder)
    except FileNotFoundError:
        return False
    check_run(folder, manifest, arm, seed)
    return bool(manifest.get("finished") and (manifest.get("ended") or manifest.get("done", 0) >= ticks))


def check_run(folder: Path, manifest: dict[str, Any], arm: Arm, seed: int) -> None:
    """Raise ForeignFile if the run in a folder belongs to another arm, seed or mode, or is a fork."""
    from ecs_eco.runs.begin import policies_as_json

    weights = {name: hash_of(file) for name, file in weights_files(arm.config, arm.policies).items()}
    wanted = {
        "config_hash": arm.config.config_hash,
        "seed": seed,
        "learn": arm.learn,
        "controls": list(arm.controls),
        "weights": weights,
    }
    if not weights:  # the folder may have been moved
        wanted["policies"] = policies_as_json(arm.policies)
    different = [key for key, value in wanted.items() if manifest.get(key) != value]
    if "forked" in manifest:
        different.append("forked")
    if different:
        shown = ", ".join(f"{key} {manifest.get(key)}" if key == "seed" else key for key in different)
        raise ForeignFile(
            f"{folder / 'manifest.json'}: belongs to another run ({shown}), not to {arm.name}, seed {seed}; "
            "remove the folder, or choose another with --out"
        )
    if why := portable.other_mode(manifest):
        raise ForeignFile(f"{folder / 'manifest.json'}: {why}")
