"""plan.json: the comparison that a folder holds; the same command continues it, another one is refused."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ecs_eco.engine.files import write_json
from ecs_eco.experiments.arm import Arm
from ecs_eco.experiments.treatments import refusal

PLAN = "plan.json"


def plan_of(arms: Sequence[Arm], ticks: int, trains: bool, retrain: bool) -> dict[str, Any]:
    """Return the settings that identify a comparison; not the numbers of seeds, so that more can be added."""
    by_name = {
        arm.name: {
            "config_hash": arm.config.config_hash, "policies": arm.policies, "learn": arm.learn,
            "controls": list(arm.controls),
        }
        for arm in arms
    }  # fmt: skip
    return {
        "format": 1, "world": arms[0].config.name, "ticks": ticks, "training seeds": trains,
        "retrain": retrain, "arms": by_name,
    }  # fmt: skip


def has_plan(folder: Path) -> bool:
    """Return whether a comparison was begun in a folder."""
    return os.path.isfile(folder / PLAN)


def check_plan(folder: Path, plan: dict[str, Any]) -> None:
    """Raise ConfigError where a folder holds another comparison; further arms may be added to one."""
    try:
        before = json.loads((folder / PLAN).read_text(encoding="utf-8"))
        different = [key for key in plan if key != "arms" and plan[key] != before.get(key)]
        different += [
            f"the arm {name}" for name, arm in plan["arms"].items() if before["arms"].get(name, arm) != arm
        ]
    except (ValueError, KeyError, AttributeError):
        different = [PLAN]
    if different:
        fault = f"holds another comparison: {', '.join(different)} differ{'s' * (len(different) == 1)}"
        raise refusal(fault, str(folder), "a folder, new or empty", source="--out")


def write_plan(folder: Path, plan: dict[str, Any]) -> None:
    """Write the settings of the comparison in a folder, with the arms that were there before."""
    folder.mkdir(parents=True, exist_ok=True)
    if has_plan(folder):
        before = json.loads((folder / PLAN).read_text(encoding="utf-8"))
        plan = plan | {"arms": before["arms"] | plan["arms"]}
    write_json(folder / PLAN, plan)
