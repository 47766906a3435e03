"""What was asked of a run by hand: noted in its manifest before it is carried out, and asked for again where ticks are run again."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ecs_eco.systems.intervene import Intervene

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World


def waiting(world: World) -> list[dict[str, Any]]:
    """Return what was asked for and is to be carried out in the tick that comes, as a world file would say it."""
    found = next((s for s in world.systems if isinstance(s, Intervene)), None)
    return [] if found is None else [what.once(world.tick) for what in found.asked]


def forget(world: World) -> None:
    """Drop what was asked for and waits."""
    for system in world.systems:
        if isinstance(system, Intervene):
            system.asked = []


def ask_again(world: World, manifest: dict[str, Any]) -> None:
    """Ask for what was asked for in the tick that comes and does not wait already: a checkpoint holds what waits."""
    for what in _without([what for tick, what in manifest.get("asked", []) if tick == world.tick], waiting(world)):
        world.intervene({key: value for key, value in what.items() if key != "at"})


class Asked:
    """Looks before a tick, after all others who do, at what is asked for, and has `note()` write the manifest."""

    def __init__(self, world: World, manifest: dict[str, Any], note: Callable[[], None]) -> None:
        self.world, self.manifest, self.note = world, manifest, note

    def look(self) -> None:
        """Ask again for what is in the manifest and nobody asked for by now, and write what is new."""
        ask_again(self.world, self.manifest)
        known = self.manifest.get("asked", [])
        new = _without(waiting(self.world), [what for tick, what in known if tick == self.world.tick])
        if new:
            self.manifest["asked"] = [*known, *([self.world.tick, what] for what in new)]
            self.note()


def _without(some: list[Any], others: list[Any]) -> list[Any]:
    """Return some without others, each of these once."""
    left, out = list(others), []
    for x in some:
        if x in left:
            left.remove(x)
        else:
            out.append(x)
    return out
