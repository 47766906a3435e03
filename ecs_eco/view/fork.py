"""What if: a branch of the world that pages show, as they ask for it."""

from __future__ import annotations

from typing import Any

from ecs_eco.config.knobs import offered
from ecs_eco.config.models.interventions import describe
from ecs_eco.runs.requests import waiting
from ecs_eco.view import recipe
from ecs_eco.view.branch import by_hand, kept, of_living, of_recorded
from ecs_eco.view.live import Live
from ecs_eco.view.recipe import Start
from ecs_eco.view.replay import Replay
from ecs_eco.view.second import Second
from ecs_eco.view.source import Message, Source

NAMES = ("as it was", "what if")


def fork(first: Source, tick: int | None, change: Any, start: Start | None = None) -> Second:
    """Return a branch of what pages show, from a tick (None: the one that is shown) and with a change, an
    intervention as in a world file (None: nothing is changed).

    A recorded run is branched at the end of the tick that it shows. Raises ValueError or ConfigError for a
    tick that is not kept and for a change that does not fit, CheckpointError or RecordingError for a world
    that cannot be copied or run here.
    """
    change = change or None
    if isinstance(first, Live):
        branch = of_living(first, first.tick if tick is None else tick, change)
        done = by_hand(first.world, 0, branch.start)
        done += waiting(first.world) if branch.start == first.tick else []
        again = recipe.of_world(start, done, branch.start, change)
    elif isinstance(first, Replay):
        if tick is not None and tick != first.tick:
            raise ValueError(
                f"what if: tick = {tick}; a recorded run is forked at the tick that it shows, "
                f"{first.tick:,}: go there first"
            )
        branch = of_recorded(first, change)
        code = bool(first.recording.manifest["config"].get("code"))
        again = recipe.of_run(str(first.recording.path), code, branch.start, change)
    else:
        raise ValueError("what if: nothing that can be forked is shown")
    words = "nothing changed" if change is None else describe(change)
    told = {
        "at": branch.start - int(isinstance(first, Replay)),
        "change": words,
        "names": list(NAMES),
        "recipe": again,
    }
    return Second(first, branch.live, branch, told)


def forks(first: Source) -> bool:
    """Whether what pages show can be forked: not a world that was made by hand, nor a recorded one that
    cannot be built here."""
    if isinstance(first, Live):
        return first.world.config is not None
    return isinstance(first, Replay) and first.recording.scene is not None


def choices(first: Source) -> Message:
    """Return the values that a change may set, and the first and last tick of a fork: "params"."""
    if isinstance(first, Live):
        config, ticks = first.world.config, (kept(first), first.tick)
    elif isinstance(first, Replay):
        scene = first.recording.scene
        config, ticks = None if scene is None else scene.config, (first.tick, first.tick)
    else:
        return {"kind": "params", **offered(None)}
    return {"kind": "params", **offered(config), "forks": list(ticks)}
