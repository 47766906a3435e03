"""Branches: worlds that diverge from another world at some tick, and commands that reproduce them."""

import json
import shlex
from bisect import bisect_left
from collections.abc import Sequence
from operator import itemgetter
from typing import Any, NamedTuple

from ecs_eco.compiled import portable
from ecs_eco.config import WorldConfig
from ecs_eco.config.edit import literal
from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.inputs.section import Use, function_name
from ecs_eco.record import freeze as frozen
from ecs_eco.runs.requests import asked_by_hand, waiting, without
from ecs_eco.runs.run import near
from ecs_eco.systems.intervene import checked
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from ecs_eco.view.source import Message


class Start(NamedTuple):
    """The words after `ecs-eco` in the command that started the original, and the interventions planned in its
    world file, which an assignment on the command line would replace."""

    words: Sequence[str]
    planned: Sequence[Message] = ()


SAFE = (
    "--seed",
    "--ticks",
    "--out",
    "--policies",
    "--set",
    "--learn",
    "--no-learn",
)  # run no code of a world


def of_run(folder: str, code: bool, tick: int, change: Message | None) -> Message:
    """Return {"toml", "command"} for a branch of a recorded run at a tick; `code` allows the world's own code."""
    done = [] if change is None else [dated(change, tick)]
    words = ["ecs-eco", *portable.option().split(), "resume", folder, "--from-tick", str(tick)]
    words += ["--trust"] if code else []
    if change is not None and change["kind"] == "set":
        for key, value in change["set"].items():
            words += ["--set", f"{key}={literal(value)}"]
    elif change is not None:
        words += ["--set", f"interventions={literal(done)}"]
    return {"toml": tables(done), "command": shlex.join([*words, "--out", "NEW"])}


def of_world(start: Start | None, acts: Sequence[Message], tick: int, change: Message | None) -> Message:
    """Return {"toml", "command"} for a branch of a live world with manual interventions `acts`; the command is
    empty if the one that started the world is unknown."""
    done = [dated(what, what["at"]) for what in acts] + ([] if change is None else [dated(change, tick)])
    if start is None:
        return {"toml": tables(done), "command": ""}
    words = ["ecs-eco", *start.words]
    if done:
        words += ["--set", planned_and(start, done)]
    return {"toml": tables(done), "command": shlex.join([*words, "--out", "NEW"])}


def planned_and(start: Start, done: Sequence[Message]) -> str:
    """Return the assignment of a world's planned interventions and more."""
    return f"interventions={literal([*start.planned, *done])}"


def start_of(manifest: Message) -> Start | None:
    """Return how a recorded run was started; None if that is unknown, if it was changed by hand, or if its
    command has other options than SAFE. A stranger wrote the command, perhaps with --trust."""
    words = shlex.split(manifest.get("command") or "")[1:]
    planned = manifest["config"].get("interventions", [])
    safe = words[:1] == ["run"] and all(word in SAFE for word in words if word.startswith("-"))
    return Start(words, planned) if safe and not manifest.get("asked") else None


def dated(what: Message, tick: int) -> Message:
    """Return an intervention in the form used in world files, with its tick first."""
    return {"at": tick} | {key: value for key, value in what.items() if key != "at" and value is not None}


def tables(done: Sequence[Message]) -> str:
    """Return interventions as TOML, one table per intervention."""
    return "\n".join(
        "\n".join(["[[interventions]]", *(f"{key} = {literal(value)}" for key, value in what.items()), ""])
        for what in done
    )


def of_living(live: Live, tick: int, change: Message | None) -> Live:
    """Return a copy of a live world at the current tick, or at the last stored tick up to an earlier tick. Raises
    ValueError for another tick or an invalid change, and CheckpointError if the world cannot be copied."""
    world, now = live.world, live.world.tick
    if world.config is None:
        raise CheckpointError(
            "what if: only a world from a world file can be copied; this one was built in Python"
        )
    if tick > now:
        raise ValueError(f"what if: tick = {tick}; expected at most {now}, the current tick")
    check(world, change)
    if tick == now:
        meta, arrays = frozen.freeze(world, recording=False)
        return _made(world, world.config, json.dumps(meta), {n: array.copy() for n, array in arrays.items()})
    points = [] if live.ring.why else [point for point in live.ring.points if point.tick <= tick]
    if not points:
        raise ValueError(
            f"what if: tick = {tick:,}; expected {live.earliest:,} to {live.tick:,}, the stored ticks"
        )
    return _made(world, points[-1].config, points[-1].meta, points[-1].arrays)


def of_recorded(replay: Replay, change: Message | None) -> Live:
    """Return a live world in the state of a recorded run at the end of the displayed tick or of an earlier
    tick. Raises CheckpointError, RecordingError or ConfigError for a run that cannot continue here."""
    if replay.done:
        raise ValueError("what if: a recorded run cannot be branched at its last tick; go to an earlier one")
    world = near(replay.recording.path, replay.recording.manifest, replay.tick + 1)
    check(world, change)
    return Live(world)


def check(world: World, change: Message | None) -> None:
    """Raise ConfigError or ValueError for a change that this world rejects."""
    if change is not None:
        if not isinstance(change, dict):
            raise ValueError("what if: `what` is not an intervention; see [[interventions]] in world files")
        checked(world, change, waiting(world))


def _made(world: World, config: WorldConfig, state: str, arrays: dict[str, Any]) -> Live:
    """Return a second world that starts from a frozen state of this world."""
    if handed := [s for s in config.systems if not isinstance(s, str | type | Use)]:
        raise CheckpointError(
            f"what if: the system {function_name(handed[0])} was passed to this world as "
            "an instance, which cannot serve a second world; pass the class instead"
        )
    where, meta = f"what if of the world {world.name!r}", json.loads(state)
    made = frozen.thaw(type(world), meta, world.threads, config, (), where)
    made.reporters = {**world.reporters, **made.reporters}
    frozen.load(made, meta, arrays, where)
    return Live(made)


def as_done_to(live: Live, world: World) -> None:
    """Repeat on `world` the interventions by hand that the live world, a tick ahead, received in this tick."""
    done = live.world.intervened
    begin = bisect_left(done, world.tick, key=itemgetter(0))
    if begin == len(done) or done[begin][0] != world.tick:
        return
    for what in without(by_hand(live.world, world.tick, world.tick + 1), waiting(world)):
        world.intervene({key: value for key, value in what.items() if key != "at"})


def by_hand(world: World, first: int, end: int) -> list[Message]:
    """Return the interventions in ticks `first` to `end` - 1 that were not planned, in world-file form."""
    plan = [] if world.config is None else world.config.interventions
    return [what for _, what in asked_by_hand(world, plan, first, end)]
