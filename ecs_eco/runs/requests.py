"""Interventions requested by hand during a run: noted in its manifest before they are carried out, and
repeated when ticks are rerun."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ecs_eco.ecosystem import World
from ecs_eco.systems.intervene import Intervene


def waiting(world: World) -> list[dict[str, Any]]:
    """Return the interventions requested for the next tick, in the form of a world file."""
    system = next((s for s in world.systems if isinstance(s, Intervene)), None)
    return [] if system is None else [intervention.once(world.tick) for intervention in system.requests]


def forget(world: World) -> None:
    """Drop pending requests."""
    for system in world.systems:
        if isinstance(system, Intervene):
            system.requests = []


def repeat_requests(world: World, manifest: dict[str, Any]) -> None:
    """Request the interventions that the manifest notes for the next tick, except pending ones from a
    checkpoint."""
    for request in without(
        [request for tick, request in manifest.get("asked", []) if tick == world.tick], waiting(world)
    ):
        world.intervene({key: value for key, value in request.items() if key != "at"})


class RequestLog:
    """Notes new requests before each tick, after all other hooks; `note()` writes the manifest."""

    def __init__(self, world: World, manifest: dict[str, Any], note: Callable[[], None]) -> None:
        self.world, self.manifest, self.note = world, manifest, note

    def look(self) -> None:
        """Repeat requests of the manifest that are not pending, and note the new ones."""
        repeat_requests(self.world, self.manifest)
        known = self.manifest.get("asked", [])
        new = without(waiting(self.world), [request for tick, request in known if tick == self.world.tick])
        if new:
            self.manifest["asked"] = [*known, *([self.world.tick, request] for request in new)]
            self.note()


def without(some: list[Any], others: list[Any]) -> list[Any]:
    """Return the list `some` without the items of `others`; each of those removes one item."""
    remaining, out = list(others), []
    for x in some:
        if x in remaining:
            remaining.remove(x)
        else:
            out.append(x)
    return out
