"""plan.json: the comparison that a folder holds; the same command continues it, another one is refused."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field

from ecs_eco.inputs.section import Section
from ecs_eco.lab.arm import Arm
from ecs_eco.record import container
from ecs_eco.record.container import Container
from ecs_eco.record.manifest import Filename, Sha, Tick


class PlannedArm(Section):
    """What decides an arm."""

    config_hash: Sha
    policies: str | dict[str, str]
    learn: bool | dict[str, bool] | None
    controls: list[str]


class Planned(Container):
    """The manifest of a comparison; not the numbers of seeds, so that more can be added, as can arms."""

    FILE: ClassVar = "plan.json"
    KIND: ClassVar = "comparison"
    COMMAND: ClassVar = "compare"
    OTHER: ClassVar = "holds another comparison"
    DECIDES: ClassVar = ("world", "ticks", "training seeds", "retrain")
    GROWS: ClassVar = True

    kind: Literal["comparison"]
    world: str
    ticks: Tick
    trains: bool = Field(alias="training seeds")
    retrain: bool
    arms: dict[Filename, PlannedArm]

    @classmethod
    def settings(cls, content: Mapping[str, Any]) -> dict[str, Any]:
        """Return the settings of a comparison, those of each arm by themselves."""
        return super().settings(content) | {f"the arm {name}": arm for name, arm in content["arms"].items()}


def plan_of(arms: Sequence[Arm], ticks: int, trains: bool, retrain: bool) -> dict[str, Any]:
    """Return the settings that identify a comparison."""
    by_name = {
        arm.name: {
            "config_hash": arm.config.config_hash,
            "policies": arm.policies,
            "learn": arm.learn,
            "controls": list(arm.controls),
        }
        for arm in arms
    }
    return {
        "world": arms[0].config.name,
        "ticks": ticks,
        "training seeds": trains,
        "retrain": retrain,
        "arms": by_name,
    }


def write_plan(folder: Path, plan: dict[str, Any]) -> None:
    """Write the settings of the comparison in a folder, with the arms that were there before.

    Raises ForeignFile where the folder holds another comparison, or one of the other mode.
    """
    there = container.begin(folder, Planned, plan)
    if plan["arms"].keys() - there["arms"].keys():
        container.write(folder, Planned, there | {"arms": there["arms"] | plan["arms"]})
