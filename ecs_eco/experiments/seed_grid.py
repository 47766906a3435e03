"""compare with training seeds: which policies an arm runs with, what is trained for it, and what is there already."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ecs_eco.cli.folders import results
from ecs_eco.cli.terminal import refuse
from ecs_eco.config import WorldConfig
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.experiments.variants import MATTERS_TO_LEARNING
from ecs_eco.record.claim import Claim
from ecs_eco.record.seal import read_manifest

if TYPE_CHECKING:
    from ecs_eco.experiments.comparison import Arm

PLAN = "plan.json"  # what the comparison in a folder is: the same command goes on with it


def thinkers(config: WorldConfig) -> list[str]:
    """Species that have a policy network."""
    return [name for name, species in config.species.items() if species.policy.kind != "none"]


def learnt(arm: Arm) -> list[str]:
    """Species of an arm that run with trained policies: only these depend on the training seed."""
    chosen = arm.policies if isinstance(arm.policies, dict) else dict.fromkeys(thinkers(arm.config), arm.policies)
    return [name for name in thinkers(arm.config) if chosen.get(name, "trained") == "trained"]


def with_policies(arm: Arm, folder: Path) -> Arm:
    """The arm with the trained policies of a folder."""
    if arm.policies == "trained":
        return replace(arm, policies=str(folder))
    return replace(arm, policies={name: arm.policies.get(name, str(folder)) for name in thinkers(arm.config)})


def check_training(arms: list[Arm], controls: list[str], training_seeds: int | None, retrain: bool) -> None:
    """Refuses what cannot be meant; raises ConfigError."""
    changed = [control for control, arm in zip(controls, arms[1:], strict=True) if "=" in control or arm.variant]
    for control, arm in zip(controls, arms[1:], strict=True):
        if control in MATTERS_TO_LEARNING and not retrain and not _learns(arm):
            refuse("--control", "changes what is learnt alone, and here nobody learns", control, "--retrain --training-seeds N with it")
    if retrain and training_seeds is None:
        refuse("--retrain", "nothing is trained", "", "--retrain with --training-seeds N")
    if training_seeds is None:
        return
    if not thinkers(arms[0].config):
        refuse("--training-seeds", "no species has a policy to train", training_seeds, 'a world with policy.kind = "shared"')
    if retrain and not changed:
        refuse("--retrain", "no control changes a value", "", "--retrain with a --control that changes one, such as KEY=VALUE")
    for control in changed:
        if not retrain and control.strip().startswith("training."):
            refuse("--control", "changes the training alone, and all arms run with the same policies", control, "--retrain with it")


def _learns(arm: Arm) -> bool:
    """Whether policies go on learning in the runs of an arm."""
    return any(s.policy.learn for s in arm.config.species.values() if s.policy.kind != "none") if arm.learn is None else arm.learn


def policies_folder(out: Path, arm: Arm, arms: list[Arm], retrain: bool) -> Path:
    """Where the policies of an arm are: the world's own, or those trained under the values of the arm."""
    if retrain and arm.config.config_hash != arms[0].config.config_hash:
        return out / "policies" / arm.name
    return out / "policies" / arms[0].name


def told(arm: Arm, arms: list[Arm], training_seeds: int, retrain: bool) -> str:
    """In words, what policies an arm runs with."""
    who = learnt(arm)
    if not who:
        return "policies that are not trained: it has no training seed"
    some = "" if len(who) == len(thinkers(arm.config)) else f" of {', '.join(who)}"
    own = retrain and arm.config.config_hash != arms[0].config.config_hash
    how = "trained anew under its own values" if own else "trained in the world as it is"
    same = "" if own or arm is arms[0] else ", the same as the first arm"
    return f"policies{some} {how}{same}, from {training_seeds} training seed{'s' * (training_seeds != 1)}"


def told_bundled(arm: Arm, arms: list[Arm]) -> str:
    """In words, what policies an arm runs with where none are trained for the comparison."""
    who = learnt(arm)
    if not who:
        return "policies that are not trained"
    some = "" if len(who) == len(thinkers(arm.config)) else f" of {', '.join(who)}"
    return f"the policies{some} that the world comes with" + ("" if arm is arms[0] else ", the same as the first arm")


def hash_of(path: Path) -> str:
    """The SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def trained_already(folder: Path, config: WorldConfig, seed: int) -> bool:
    """Whether the policies of a configuration and a training seed are in a folder; refuses those of another seed or configuration."""
    try:
        found = json.loads((folder / "training.json").read_text(encoding="utf-8"))
        wanted = {"config_hash": config.config_hash, "seed": seed}
        other = [key for key in wanted if found[key] != wanted[key]]
        weights = {name: hash_of(folder / f"{name}.safetensors") for name in thinkers(config)}
    except (OSError, ValueError, KeyError, TypeError):
        return False
    if other:
        raise ForeignFile(f"{folder / 'training.json'}: belongs to another training: {', '.join(f'{k} {found[k]}' for k in other)}, "
                          f"not {', '.join(str(wanted[k]) for k in other)}")  # fmt: skip
    for name, own in weights.items():
        if found.get("weights", {}).get(name) != own:
            raise ForeignFile(f"{folder / name}.safetensors: is not the policy that this training left")
    return True


def train_one(config: WorldConfig, seed: int, folder: Path) -> Path:
    """Train the policies of one seed into a folder, which is whole or not there."""
    from ecs_eco.experiments.pretraining import pretrain

    part = folder.with_name(f"{folder.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    pretrain(config, seed=seed, out=part)
    shutil.rmtree(folder, ignore_errors=True)
    os.replace(part, folder)
    return folder


def ran_already(folder: Path, ticks: int, arm: Arm | None = None, seed: int | None = None) -> bool:
    """Whether a run of so many ticks is in a folder; ForeignFile where it is one of another arm or seed."""
    try:
        manifest = read_manifest(folder)
    except (FileNotFoundError, RecordingError):
        return False
    if arm is not None:
        check_run(folder, manifest, arm, seed)
    return bool(manifest.get("finished") and manifest.get("done", 0) >= ticks)


def check_run(folder: Path, manifest: dict[str, Any], arm: Arm, seed: int | None) -> None:
    """Raise ForeignFile where the run in a folder is not that of an arm with this seed, or is a fork."""
    from ecs_eco.runs.begin import said_policies
    from ecs_eco.worlds.build import weights_files

    weights = {name: hash_of(file) for name, file in weights_files(arm.config, arm.policies).items()}
    wanted = {"config_hash": arm.config.config_hash, "seed": seed, "learn": arm.learn, "controls": list(arm.controls), "weights": weights}
    if not weights:  # else they may lie elsewhere now
        wanted["policies"] = said_policies(arm.policies)
    other = [key for key, value in wanted.items() if manifest.get(key) != value]
    if "forked" in manifest:
        other.append("forked")
    if other:
        told = ", ".join(f"{key} {manifest.get(key)}" if key == "seed" else key for key in other)
        raise ForeignFile(f"{folder / 'manifest.json'}: is of another run ({told}) than {arm.name}, seed {seed}; remove the folder, "
                          "or name another with --out")  # fmt: skip


def folder_of(out: Path | None, default: str, plan: dict[str, Any]) -> Claim:
    """Claim the folder of a comparison: new, or one that the same comparison has begun; ConfigError where another one is in it.

    Raises FolderInUse where a process writes there.
    """
    if out is None or not os.path.isfile(out / PLAN):
        return results(out, default)
    try:
        before = json.loads((out / PLAN).read_text(encoding="utf-8"))
        other = [key for key in plan if key != "arms" and plan[key] != before.get(key)]
        other += [f"the arm {name}" for name, arm in plan["arms"].items() if before["arms"].get(name, arm) != arm]
    except (ValueError, KeyError, AttributeError):
        other = [PLAN]
    if other:
        refuse("--out", f"holds another comparison: {', '.join(other)} differ{'s' * (len(other) == 1)}", str(out), "a folder, new or empty")
    return Claim(out)


def plan_of(arms: list[Arm], ticks: int, crossed: bool, retrain: bool) -> dict[str, Any]:
    """What makes a comparison the same; the numbers of seeds are not in it, so that more can be added."""
    about = {
        arm.name: {"config_hash": arm.config.config_hash, "policies": arm.policies, "learn": arm.learn, "controls": list(arm.controls)}
        for arm in arms
    }
    return {"format": 1, "world": arms[0].config.name, "ticks": ticks, "training seeds": crossed, "retrain": retrain, "arms": about}


def write_plan(out: Path, plan: dict[str, Any]) -> None:
    """Write what the comparison in a folder is, with the arms that were there before."""
    from ecs_eco.engine.files import write_json

    out.mkdir(parents=True, exist_ok=True)
    if os.path.isfile(out / PLAN):
        plan = plan | {"arms": json.loads((out / PLAN).read_text(encoding="utf-8"))["arms"] | plan["arms"]}
    write_json(out / PLAN, plan)
