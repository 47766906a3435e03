"""Interventions requested by hand during a run. They are recorded in its manifest before they are carried
out, and repeated when ticks are rerun."""

from typing import Any

from ecs_eco.ecosystem import World
from ecs_eco.systems.intervene import Intervene


def waiting(world: World) -> list[dict[str, Any]]:
    """Return the interventions requested for the next tick, in the form used in world files."""
    system = next((s for s in world.systems if isinstance(s, Intervene)), None)
    return [] if system is None else [intervention.once(world.tick) for intervention in system.requests]


def forget(world: World) -> None:
    """Drop pending requests."""
    for system in world.systems:
        if isinstance(system, Intervene):
            system.requests = []


def repeat_requests(world: World, manifest: dict[str, Any]) -> None:
    """Request the interventions that the manifest lists for the next tick, unless they are pending."""
    for request in without(
        [request for tick, request in manifest.get("asked", []) if tick == world.tick], waiting(world)
    ):
        world.intervene({key: value for key, value in request.items() if key != "at"})


def note_requests(world: World, manifest: dict[str, Any]) -> bool:
    """Repeat the manifest's requests that are not pending; add new ones; return whether there were any."""
    repeat_requests(world, manifest)
    known = manifest.get("asked", [])
    new = without(waiting(world), [request for tick, request in known if tick == world.tick])
    if new:
        manifest["asked"] = [*known, *([world.tick, request] for request in new)]
    return bool(new)


def asked_by_hand(world: World, plan: list[Any], first: int = 0, end: int = 2**63) -> list[list[Any]]:
    """Return interventions by hand, not in `plan`, of ticks `first` to `end` - 1, as [tick, intervention]."""
    done = world.intervened
    return [
        [tick, request]
        for tick in dict.fromkeys(tick for tick, _ in done if first <= tick < end)
        for request in without(
            [what for at, what in done if at == tick], [each.once(tick) for each in plan if each.due(tick)]
        )
    ]


def without(some: list[Any], others: list[Any]) -> list[Any]:
    """Return `some` without the items in `others`: each removes only one equal item."""
    remaining, out = list(others), []
    for x in some:
        if x in remaining:
            remaining.remove(x)
        else:
            out.append(x)
    return out
