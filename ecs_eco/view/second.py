"""The second of two worlds, a branch of the first or an unrelated one; it follows the first world's clock."""

import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from ecs_eco.config.models.interventions import describe
from ecs_eco.ecosystem import World
from ecs_eco.runs.requests import repeat_requests, waiting
from ecs_eco.view import branch
from ecs_eco.view.families import asked
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from ecs_eco.view.source import Message
from ecs_eco.view.versus import Side, differences, side

Ask = Callable[[World], None]
APART = 100  # [ticks] between points without a recorder


class Second:
    """A source next to the source `of`. `told` contains the data that pages need about it: names, the tick and
    change of the branch, and the command that reproduces it.

    Its own clock begins at `begins`; `start`, `first` and `tick` are on the clock of `of`. Before each tick
    of a live world, `ask` requests the interventions of the other world, and `refused` collects errors for
    interventions that this world rejects. `change` is the intervention that makes the worlds diverge, or a
    function that changes this world, or None. Organisms with uids below `common` were born before the worlds
    diverged."""

    def __init__(
        self,
        of: Live | Replay,
        source: Live | Replay,
        begins: int,
        told: Message,
        ask: Ask | None = None,
        change: Message | Ask | None = None,
    ) -> None:
        self.of, self.source, self.begins, self.told = of, source, begins, told
        # a live world's tick is the next tick; a recording's tick is the last tick
        self.shift = source.ahead - of.ahead
        self.refused, self.common, self._ask, self._change = list[str](), 0, ask, change
        self._sent, self._fated = -1, -1
        source.ranges = of.ranges  # colors have the same meaning in both worlds
        if isinstance(source, Live):
            self.common, source.ring.used = int(source.world.next_uid), True
            source.curves.first = begins
            source.world.before_tick.append(self._before)

    @property
    def start(self) -> int:
        """The first tick of this world."""
        return self.begins - self.shift

    @property
    def first(self) -> int:
        """The earliest tick to which this world can go back."""
        return max(self.begins, self.source.earliest) - self.shift

    @property
    def tick(self) -> int:
        """The current tick of this world."""
        return self.source.tick - self.shift

    @property
    def forked(self) -> bool:
        """Whether this is a branch of the first world."""
        return self.told["at"] is not None

    @property
    def mark(self) -> Message | None:
        """The entry in the log of interventions: the tick of the branch and its change."""
        return {"tick": self.start, "text": f"what if: {self.told['change']}"} if self.forked else None

    @property
    def comes(self) -> bool:
        """Whether this world is not at the tick of the first world, but can get there."""
        target = self.target
        return target >= self.start and (self.tick < target or self.first <= target < self.tick)

    @property
    def there(self) -> bool:
        """Whether this world has a state at the current tick of the first world."""
        return self.tick == self.target and self.of.tick >= self.start

    @property
    def target(self) -> int:
        """The tick of the first world, or the last tick that this world can show."""
        if isinstance(self.source, Replay):
            return min(self.of.tick, self.source.recording.last - self.shift)
        return self.of.tick

    def follow(self, seconds: float) -> None:
        """Run toward the tick of the first world for about `seconds` at most, or go back to it."""
        if self.comes and self.tick > self.target:
            self.back_to(self.target)
        elif self.comes:
            self.run_to(self.target, seconds)

    def run_to(self, tick: int, seconds: float) -> bool:
        """Run or show ticks up to a later tick, for about `seconds` at most; return whether it was reached."""
        if isinstance(self.source, Replay):
            self._seek(tick)
            return True
        until, of, world = time.monotonic() + seconds, self.of, self.source.world
        known = of.curves.ticks if isinstance(of, Live) else of.recording.curves["tick"]
        while self.tick < tick:
            # a recorder has the points of the last ticks
            if self.tick in known if world.recorder is None else self.tick % APART == 0:
                self._sample()
            world.run(1)
            if time.monotonic() > until:
                break
        return self.tick >= tick

    def back_to(self, tick: int) -> None:
        """Go back to a tick, but not before the start; raise ValueError if this is impossible."""
        if self.tick > max(tick, self.start):
            self._seek(max(tick, self.start))
        self._sent, self._fated = min(self._sent, self.source.tick - 1), -1

    def _seek(self, tick: int) -> None:
        self.source.handle({"kind": "seek", "tick": tick + self.shift})

    def _before(self) -> None:
        """Prepare the next tick of a live world."""
        assert isinstance(self.source, Live)
        world, ring = self.source.world, self.source.ring
        if not ring.busy:
            ring.look()
        self.source.passed()
        if world.tick <= self.begins:
            self.common = int(world.next_uid)
        try:
            if self._ask is not None:
                self._ask(world)
        except (ValueError, RuntimeError) as error:
            self.refused.append(str(error))
        if self._change is not None and world.tick == self.begins:
            self._change(world) if callable(self._change) else world.intervene(self._change)

    def frame(self, number: int, colour: str) -> bytes:
        """Return the frame of this world."""
        known, of = self.source.hello()["colours"], asked(colour)
        shown = colour in known if of is None else self.shares(of)
        return self.source.frame(number, colour if shown else "species")

    def sample(self) -> None:
        """Add points to the curves of a live world if both worlds are at the same tick."""
        if self.there:
            self._sample()

    def _sample(self) -> None:
        if isinstance(self.source, Live) and max(self.source.curves.last, self.begins - 1) < self.source.tick:
            self.source.sample()

    def greeting(self) -> list[Message]:
        """Return the messages that a new page needs."""
        hello = {"kind": "beside", "hello": self.source.hello(), **self.told}
        return [hello, *self._points(-1), {"kind": "beside", "marks": self.source.marks()}]

    def news(self) -> list[Message]:
        """Return new curve points, marks and deaths."""
        out = [
            {"kind": "beside", "marks": message} if message["kind"] == "marks" else self.passed_on(message)
            for message in self.source.news()
            if message["kind"] in ("marks", "said", "organism")
        ]
        points = self._points(self._sent)
        if points:
            self._sent = points[0]["series"]["tick"][-1] + self.shift
        if self.there and self._fated != self.source.tick:
            fates = self.source.fates(self._fated if self._fated < self.source.tick else -1)
            self._fated = self.source.tick
            out += [{"kind": "beside", "fates": fates}] if fates else []
        return [*out, *points]

    def _points(self, after: int) -> list[Message]:
        series = self.source.series(after)
        if series is None:
            return []
        ticks = [tick - self.shift for tick in series["tick"]]
        return [{"kind": "beside", "series": series | {"tick": ticks}}]

    def organism(self, uid: int) -> Message:
        """Return an organism of this world, living or dead; raise KeyError if it is unknown."""
        return self.labelled(self.source.organism(uid), second=True)

    def passed_on(self, message: Message) -> Message:
        """Return a message of this world in the form that pages expect."""
        return self.labelled(message, second=True) if message["kind"] in ("organism", "tree") else message

    def labelled(self, message: Message, second: bool) -> Message:
        """Add to an organism's message its world's name, whether that is the second, and whether both have it."""
        both = {"both": self.shares(message["uid"])} if self.forked else {}
        return message | {"world": self.told["names"][second], "second": second} | both

    def shares(self, uid: int) -> bool:
        """Return whether an organism was born before the worlds diverged."""
        return self.forked and uid < self.common

    def refusals(self) -> list[str]:
        """Return the first world's interventions that this world has refused since the last call."""
        out, self.refused = self.refused, []
        return out

    def sentence(self) -> Message:
        """Return population sizes and a sentence about the current differences."""
        tick, n = self.of.tick, self.source.counts()
        if self.there:
            since = self.start if self.forked else None
            kinds = sorted(self.of.hello()["species"], key=lambda kind: not kind["moves"])
            names = [kind["name"] for kind in kinds]
            told = differences(names, _side(self.of), _side(self.source), since, tick)
        else:
            text = f"It starts at tick {self.first:,}; earlier ticks are no longer stored."
            if tick < self.start:
                text = f"It diverges from the original at tick {self.start:,}."
            elif self.comes:
                text = f"Catching up: tick {self.tick:,} of {tick:,}."
            told = {"text": text, "clauses": {}}
        return {"kind": "beside", "state": {"tick": self.tick, "there": self.there, "n": n, **told}}


def beside(first: Live | Replay, second: Live | Replay, names: tuple[str, str]) -> Second:
    """Return another world next to the first. If both worlds are live, interventions apply to both."""
    told = {"at": None, "change": "", "names": list(names), "recipe": None}
    if isinstance(second, Replay):
        return Second(first, second, second.recording.first, told)
    ask = partial(branch.as_done_to, first) if isinstance(first, Live) else None
    return Second(first, second, second.tick, told, ask)


def _side(source: Live | Replay) -> Side:
    kinds = {kind["name"] for kind in source.hello()["species"]}
    counts = {name: n for name, n in source.counts().items() if name in kinds}
    return side(counts, source.story.entries, source.tick)


class Swept(NamedTuple):
    """A sweep: its entry in the story and, if all carriers can lose its allele, words and a function for this."""

    entry: Message
    words: str = ""
    edit: Ask | None = None


def fork(
    first: Live | Replay,
    tick: int | None,
    change: Message | None,
    start: branch.Start | None = None,
    swept: Swept | None = None,
) -> Second:
    """Return a branch of the displayed world from a tick (None: the displayed tick), with a change: an
    intervention as in a world file (None: no change), or without the allele of a sweep in a recorded run.

    A recorded run branches at the end of the displayed tick. Raises ValueError or ConfigError for a tick that
    is no longer stored and for an invalid change, and CheckpointError or RecordingError for a world that
    cannot be copied or run here."""
    change, tick = change or None, first.tick if tick is None else tick
    ask: Ask
    if isinstance(first, Live):
        begins, live = tick, branch.of_living(first, tick, change)
        done = branch.by_hand(first.world, 0, tick)
        done += waiting(first.world) if tick == first.tick else []
        again = branch.of_world(start, done, tick, change)
        ask = partial(branch.as_done_to, first)
    else:
        if tick != first.tick:
            raise ValueError(
                f"what if: tick = {tick}; expected {first.tick:,}, the displayed tick "
                f"of this recorded run: go to tick {tick} first"
            )
        begins, live = tick + 1, branch.of_recorded(first, change)
        manifest = first.recording.manifest
        code = bool(manifest["config"].get("code"))
        again = branch.of_run(str(first.recording.path), code, begins, change)
        ask = partial(repeat_requests, manifest=manifest)
    words = "nothing changed" if change is None else describe(change)
    words = words if swept is None else swept.words
    recipe = again if swept is None else None  # no command does this
    told = {
        "at": begins - 1 + first.ahead,
        "change": words,
        "names": ["original", "what if"],
        "recipe": recipe,
    }
    return Second(first, live, begins, told, ask, change if swept is None else swept.edit)
