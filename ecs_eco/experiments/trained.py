"""Policies of a configuration and a training seed: reused if they were trained before, else trained."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Any

from ecs_eco.config import WorldConfig
from ecs_eco.engine.errors import ForeignFile
from ecs_eco.experiments.treatments import species_with_policy
from ecs_eco.experiments.workers import finishing
from ecs_eco.learning.weights import hash_of


def train_or_find(
    folder: Path, config: WorldConfig, seed: int, ticks: int | None = None, *, verify: bool = True
) -> Path:
    """Return the folder, with <species>.safetensors and training.json: whole, or not there at all.

    Several processes may train the same at once: the first result is kept, the others are identical. Without
    `verify` any training in the folder is accepted, since the folder's name identifies it. Raises ForeignFile
    if it holds another training.
    """
    from ecs_eco.experiments.pretraining import pretrain

    if is_trained(folder, config, seed, ticks, verify=verify):
        return folder
    part = folder.with_name(f"{folder.name}.{os.getpid()}.part")
    shutil.rmtree(part, ignore_errors=True)
    with finishing():
        try:
            pretrain(config, seed=seed, ticks=ticks, out=part)
            if not is_trained(folder, config, seed, ticks, verify=verify):
                shutil.rmtree(folder, ignore_errors=True)  # the training there is incomplete
                _keep(part, folder)
        finally:
            shutil.rmtree(part, ignore_errors=True)
    return folder


def is_trained(
    folder: Path, config: WorldConfig, seed: int, ticks: int | None = None, *, verify: bool = True
) -> bool:
    """Return whether the policies of a training are in a folder. Raises ForeignFile for those of another."""
    path = folder / "training.json"
    if not verify:
        return path.is_file()
    wanted = {"config_hash": config.config_hash, "seed": seed} | ({} if ticks is None else {"ticks": ticks})
    try:
        training = json.loads(path.read_text(encoding="utf-8"))
        different = [key for key in wanted if training[key] != wanted[key]]
        weights = {name: hash_of(folder / f"{name}.safetensors") for name in species_with_policy(config)}
    except (OSError, ValueError, KeyError, TypeError):
        return False
    if different:
        there, here = (", ".join(_shown(values, different)) for values in (training, wanted))
        raise ForeignFile(f"{path}: belongs to another training: {there}, not {here}")
    for name, digest in weights.items():
        if training.get("weights", {}).get(name) != digest:
            raise ForeignFile(f"{folder / name}.safetensors: is not the policy that this training left")
    return True


def _shown(values: dict[str, Any], keys: list[str]) -> list[str]:
    return [f"{key} {values[key]}" for key in keys]


def _keep(part: Path, folder: Path) -> None:
    """Give a new training its place, unless another process was first."""
    try:
        part.rename(folder)
    except OSError:
        if not (folder / "training.json").is_file():
            raise
