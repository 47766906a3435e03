"""Policies for a configuration and a training seed: reused if they exist, otherwise trained."""

import os
from pathlib import Path

from ecs_eco.config import WorldConfig
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.lab.pool import finishing
from ecs_eco.lab.treatments import species_with_policy
from ecs_eco.learning.weights import hash_of
from ecs_eco.record.container import remove
from ecs_eco.record.seal import read_manifest

FILE = "training.json"
WRITTEN = (FILE, "*.safetensors")


def train_or_find(
    folder: Path, config: WorldConfig, seed: int, ticks: int | None = None, *, verify: bool = True
) -> Path:
    """Return the folder with <species>.safetensors and training.json, after training if necessary. It appears
    only when complete. Of several processes that train the same policies at once, the first keeps its result;
    all are identical. Without `verify`, any training run is accepted, because the folder's name identifies
    it. Raises ForeignFile if the folder contains another training run, RecordingError if it is damaged or
    contains other files; only leftovers of a killed training run are removed."""
    from ecs_eco.lab.pretraining import pretrain

    if is_trained(folder, config, seed, ticks, verify=verify):
        return folder
    part = folder.with_name(f"{folder.name}.{os.getpid()}.part")
    remove(part, WRITTEN)
    with finishing():
        try:
            pretrain(config, seed=seed, ticks=ticks, out=part)
            if not is_trained(folder, config, seed, ticks, verify=verify):
                if not remove(folder, WRITTEN):
                    raise RecordingError(
                        f"{folder}: has no {FILE}, but contains files that no training run writes; move them "
                        "away, or choose another folder"
                    )
                _keep(part, folder)
        finally:
            remove(part, WRITTEN)
    return folder


def is_trained(
    folder: Path, config: WorldConfig, seed: int, ticks: int | None = None, *, verify: bool = True
) -> bool:
    """Return whether a folder contains this training run. Raises ForeignFile if it contains another training
    run, RecordingError if it is damaged."""
    path = folder / FILE
    if not verify or not path.is_file():
        return path.is_file()
    wanted = {"config_hash": config.config_hash, "seed": seed} | ({} if ticks is None else {"ticks": ticks})
    training = read_manifest(folder, FILE)
    different = [key for key in wanted if training.get(key) != wanted[key]]
    if different:
        there, here = (
            ", ".join(f"{key} {values.get(key)}" for key in different) for values in (training, wanted)
        )
        raise ForeignFile(f"{path}: belongs to another training run: {there}, not {here}")
    hashes = training.get("weights")
    for name in species_with_policy(config):
        file = folder / f"{name}.safetensors"
        if not file.is_file():
            raise RecordingError(f"{file}: is missing; remove its folder to train again")
        if not isinstance(hashes, dict) or hashes.get(name) != hash_of(file):
            raise ForeignFile(f"{file}: is not the policy written by this training run")
    return True


def _keep(part: Path, folder: Path) -> None:
    """Move a new training run to its folder, unless another process was faster."""
    try:
        part.rename(folder)
    except OSError:
        if not (folder / FILE).is_file():
            raise


def forget_trained(folder: Path) -> None:
    """Remove all training runs in a folder, and the folder if nothing else is left."""
    for place in folder.glob("training-*"):
        remove(place, WRITTEN)
    remove(folder, ())
