"""Branches: worlds that part from another world at some tick, and the command that reproduces one."""

from __future__ import annotations

import json
import shlex
import time
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from operator import itemgetter
from typing import Any, NamedTuple

from ecs_eco.compiled import portable
from ecs_eco.config import WorldConfig
from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.inputs.section import Use, function_name
from ecs_eco.record import freeze as frozen
from ecs_eco.runs.requests import repeat_requests, waiting, without
from ecs_eco.systems.intervene import checked
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from ecs_eco.view.rerun import near
from ecs_eco.view.rewind import Point
from ecs_eco.view.source import Message


class Start(NamedTuple):
    """The command that started the original, as its words after `ecs-eco`: ("run", "lamb", "--seed", "1").

    `planned` are the interventions of its world file. An assignment on the command line replaces them.
    """

    words: Sequence[str]
    planned: Sequence[Message] = ()


def of_run(folder: str, code: bool, tick: int, change: Message | None) -> Message:
    """Return {"toml", "command"} for a branch of a recorded run from the start of a tick. `code` allows the
    world's own Python code."""
    done = [] if change is None else [dated(change, tick)]
    words = ["ecs-eco", *portable.option().split(), "resume", folder, "--from-tick", str(tick)]
    words += ["--trust"] if code else []
    if change is not None and change["kind"] == "set":
        for key, value in change["set"].items():
            words += ["--set", f"{key}={inline(value)}"]
    elif change is not None:
        words += ["--set", f"interventions={inline(done)}"]
    return {"toml": tables(done), "command": shlex.join([*words, "--out", "NEW"])}


def of_world(start: Start | None, acts: Sequence[Message], tick: int, change: Message | None) -> Message:
    """Return {"toml", "command"} for a branch of a living world. `acts` are the interventions made by hand,
    each with its tick. The command is empty if the world's own start command is unknown."""
    done = [dated(what, what["at"]) for what in acts] + ([] if change is None else [dated(change, tick)])
    if start is None:
        return {"toml": tables(done), "command": ""}
    words = ["ecs-eco", *start.words]
    if done:
        words += ["--set", f"interventions={inline([*start.planned, *done])}"]
    return {"toml": tables(done), "command": shlex.join([*words, "--out", "NEW"])}


def dated(what: Message, tick: int) -> Message:
    """Return an intervention in the form of a world file, with its tick first."""
    return {"at": tick} | {key: value for key, value in what.items() if key != "at" and value is not None}


def tables(done: Sequence[Message]) -> str:
    """Return interventions as TOML, one table each."""
    return "\n".join(
        "\n".join(
            ["[[interventions]]", *(f"{_key(key)} = {inline(value)}" for key, value in what.items()), ""]
        )
        for what in done
    )


def inline(value: object) -> str:
    """Return a JSON value as TOML on one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(key)} = {inline(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(inline, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


def _key(key: str) -> str:
    return key if key.replace("_", "").replace("-", "").isalnum() and key.isascii() else json.dumps(key)


Ask = Callable[["World"], None]


class Branch:
    """A world that follows the clock of another one, from which it parts at tick `start`.

    Before each tick, `ask` requests the interventions of the other world. `change` is the intervention that
    makes the difference, or None. `refused` collects the errors of interventions that this world rejects.
    Organisms with uids below `common` were born before the worlds parted.
    """

    def __init__(self, live: Live, start: int, change: Message | None, ask: Ask) -> None:
        self.live, self.start, self.change, self._ask = live, start, change, ask
        self.refused, self.common = list[str](), int(live.world.next_uid)
        live.ring.used = True
        live.world.before_tick.append(self._before)

    @property
    def tick(self) -> int:
        """The next tick of its world."""
        return self.live.world.tick

    @property
    def first(self) -> int:
        """The earliest tick to which it can go back."""
        first = self.live.ring.first
        return self.tick if self.live.ring.why or first is None else max(self.start, first)

    def follow(self, tick: int, seconds: float, sampled: Callable[[int], bool] = lambda tick: False) -> bool:
        """Run up to `tick`, for at most about `seconds`; return whether it got there.

        `sampled(tick)` returns whether the curves need a point at a tick after the start.
        """
        until, world = time.monotonic() + seconds, self.live.world
        while world.tick < tick:
            if sampled(world.tick):
                self.sample()
            world.run(1)
            if time.monotonic() > until:
                break
        return world.tick >= tick

    def back(self, tick: int) -> None:
        """Go back to a tick, but not before the start; raise ValueError if this is impossible."""
        if self.tick > (tick := max(tick, self.start)):
            self.live.handle({"kind": "seek", "tick": tick})

    def sample(self) -> None:
        """Add a point to the curves: at most one per tick, and none before the start."""
        ticks = self.live.curves.ticks
        if self.tick >= self.start and (not ticks or ticks[-1] < self.tick):
            self.live.sample()

    def _before(self) -> None:
        world = self.live.world
        if not self.live.ring.busy:
            self.live.ring.look()
        self.live.passed()
        if world.tick <= self.start:
            self.common = int(world.next_uid)
        try:
            self._ask(world)
        except (ValueError, RuntimeError) as error:
            self.refused.append(str(error))
        if self.change is not None and world.tick == self.start:
            world.intervene(self.change)


def of_living(live: Live, tick: int, change: Message | None) -> Branch:
    """Return a branch of a living world from the present tick or an earlier one that is still stored.

    The living world does not change. Raises ValueError for any other tick and for a change that does not fit,
    and CheckpointError for a world that cannot be copied.
    """
    world, now = live.world, live.world.tick
    if world.config is None:
        raise CheckpointError(
            "what if: only a world from a world file can be copied; this one was built in Python"
        )
    if tick > now:
        raise ValueError(f"what if: tick = {tick}; expected at most {now}, the present tick")
    check(world, change)
    if tick == now:
        meta, arrays = frozen.freeze(world, recording=False)
        made = _made(world, world.config, meta, {name: array.copy() for name, array in arrays.items()})
    else:
        point = _nearest(live, tick)
        made = _made(world, point.config, point.meta, point.arrays)
    return Branch(Live(made), tick, change, partial(as_done_to, live))


def of_recorded(replay: Replay, change: Message | None) -> Branch:
    """Return a branch of a recorded run from the end of the displayed tick. The run may have to be rerun up
    to there. Raises CheckpointError, RecordingError or ConfigError for a run that cannot be run here."""
    manifest, start = replay.recording.manifest, replay.tick + 1
    if replay.done:
        raise ValueError("what if: a recorded run cannot be branched at its last tick; go to an earlier one")
    world = near(replay.recording.path, manifest, start)
    check(world, change)
    return Branch(Live(world), start, change, partial(repeat_requests, manifest=manifest))


def check(world: World, change: Message | None) -> None:
    """Raise ConfigError or ValueError for a change that this world rejects."""
    if change is not None:
        if not isinstance(change, dict):
            raise ValueError("what if: `what` is not an intervention; see [[interventions]] of a world file")
        checked(world, change, waiting(world))


def kept(live: Live) -> int:
    """Return the earliest tick at which a living world can be branched."""
    first = live.ring.first
    return live.tick if live.ring.why or first is None else first


def _nearest(live: Live, tick: int) -> Point:
    points = [] if live.ring.why else [point for point in live.ring.points if point.tick <= tick]
    if not points:
        raise ValueError(
            f"what if: tick = {tick:,}; expected {kept(live):,} to {live.tick:,}, the stored ticks"
        )
    return points[-1]


def _made(world: World, config: WorldConfig, meta: dict[str, Any], arrays: dict[str, Any]) -> Any:
    """Return a second world in a frozen state of this one."""
    if handed := [s for s in config.systems if not isinstance(s, str | type | Use)]:
        raise CheckpointError(
            f"what if: the system {function_name(handed[0])} was passed to this world as "
            "an instance, which cannot serve a second world; pass the class instead"
        )
    where, meta = f"what if of the world {world.name!r}", json.loads(json.dumps(meta))
    made = frozen.thaw(type(world), meta, world.threads, config, (), where)
    made.reporters = {**world.reporters, **made.reporters}
    frozen.load(made, meta, arrays, where)
    return made


def as_done_to(live: Live, world: World) -> None:
    """Repeat on `world` the interventions made by hand on the living world in the next tick, unless they are
    already pending. The living world has passed that tick."""
    done = live.world.intervened
    begin = bisect_left(done, world.tick, key=itemgetter(0))
    if begin == len(done) or done[begin][0] != world.tick:
        return
    for what in without(by_hand(live.world, world.tick, world.tick + 1), waiting(world)):
        world.intervene({key: value for key, value in what.items() if key != "at"})


def by_hand(world: World, first: int, end: int) -> list[Message]:
    """Return the interventions carried out in ticks `first` to `end` - 1 that the world file does not plan,
    in the form of a world file."""
    plan = () if world.config is None else world.config.interventions
    out: list[Message] = []
    for tick in dict.fromkeys(tick for tick, _ in world.intervened if first <= tick < end):
        done = [what for when, what in world.intervened if when == tick]
        out += without(done, [one.once(tick) for one in plan if one.due(tick)])
    return out
