"""Wandering: animals that do not decide to turn perform a correlated random walk."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import model_validator

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.engine.errors import Problem, listed, unknown
from ecs_eco.inputs.section import FREE, SHAPE, NonNegative, Section, about, quantity


class Wander(Section, change=FREE, own=True):
    """A correlated random walk (Kareiva & Shigesada 1983): in each tick, the heading changes by a normally
    distributed angle with standard deviation `turn` times the square root of `dt`, unless the animal turns
    left or right.

    With `gait`, undecided animals walk. The gait is the default action if `actions` has the group `speed`;
    otherwise, it is the only `speed` action and is always on.
    """

    turn: NonNegative = quantity("standard deviation of the change in heading", "rad/√s")
    gait: str | None = about("gait of undecided animals; default: their default action", None, change=SHAPE)


class Wandering(Feature, after="locomotion"):
    """Undecided animals wander: system `Wander`."""

    wander: Wander | None = about(
        "random walk of undecided animals; absent: they keep their heading", omit=True, change=SHAPE
    )

    @model_validator(mode="before")
    @classmethod
    def _walk(cls, data: Any) -> Any:
        """Make the gait an action that is always on, or the default action."""
        wander = data.get("wander") if isinstance(data, dict) else None
        gait = wander.get("gait") if isinstance(wander, dict) else None
        kinds = {"actions": dict, "always_on": list, "default_action": dict}
        given = {key: data.get(key, kind()) for key, kind in kinds.items()} if gait is not None else {}
        if not given or not all(isinstance(given[key], kind) for key, kind in kinds.items()):
            return data
        if gait in given["always_on"]:  # already resolved
            return data
        if "speed" in given["actions"]:
            return data | {"default_action": {"speed": gait} | given["default_action"]}
        actions = given["actions"] | {"speed": [gait]}
        return data | {"actions": actions, "always_on": [*given["always_on"], gait]}

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        if species.wander is None:
            return
        gaits = () if species.locomotion is None else species.locomotion.speed
        if species.locomotion is None:
            yield Problem((*key, "locomotion"), "is missing, but it wanders", allowed="speed = { walk = … }")
        elif species.wander.gait is not None and species.wander.gait not in gaits:
            yield unknown((*key, "wander", "gait"), "gait in locomotion.speed", species.wander.gait, gaits)
        elif "speed" not in species.actions:
            yield Problem(
                (*key, "wander", "gait"), "is missing, and there are no speed actions", allowed=listed(gaits)
            )
        if "turn" in species.ranges():
            fault = "actions.turn is continuous: it turns in every tick"
            yield Problem(
                (*key, "wander"),
                fault,
                allowed='turn = ["left", "none", "right"], or remove this action group',
            )
