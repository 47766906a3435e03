"""The second of two worlds, a branch of the first or an unrelated world, which follows the first's clock."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ecs_eco.config.knobs import offered
from ecs_eco.config.models.interventions import describe
from ecs_eco.runs.requests import waiting
from ecs_eco.view import branch as branches
from ecs_eco.view.branch import Branch, Start, as_done_to, by_hand, kept, of_living, of_recorded
from ecs_eco.view.families import asked
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from ecs_eco.view.source import Message, Source
from ecs_eco.view.versus import Side, differences, side
from ecs_eco.view.watched import Watched


class Shown:
    """A recorded run that follows a clock."""

    def __init__(self, replay: Replay) -> None:
        self.replay, self.refused, self.common = replay, list[str](), 0
        self.start = self.first = replay.recording.first

    @property
    def tick(self) -> int:
        """The displayed tick."""
        return self.replay.tick

    def follow(self, tick: int, seconds: float, sampled: Callable[[int], bool]) -> bool:
        """Show a tick, or the last one."""
        self.back(tick)
        return True

    def back(self, tick: int) -> None:
        """Show a tick."""
        self.replay.handle({"kind": "seek", "tick": tick})

    def sample(self) -> None:
        """Do nothing: the series were recorded."""


class Second:
    """A source next to the `first` one. `told` is the data about it that pages need: names, tick and change
    of the branch, and the command that reproduces it. All ticks count on the first world's clock."""

    def __init__(self, first: Source, source: Source, follower: Branch | Shown, told: Message) -> None:
        self.of, self.source, self.follower, self.told = first, source, follower, told
        # a living world's tick is the next one, a recording's the last one
        self.shift = _ahead(source) - _ahead(first)
        self._sent, self._fated = -1, -1
        if isinstance(first, Watched) and isinstance(source, Watched):
            source.ranges = first.ranges  # a color has the same meaning in both

    @property
    def start(self) -> int:
        """Its first tick on the first world's clock."""
        return self.follower.start - self.shift

    @property
    def first(self) -> int:
        """The earliest tick on that clock to which it can go back."""
        return self.follower.first - self.shift

    @property
    def tick(self) -> int:
        """Its present tick on that clock."""
        return self.follower.tick - self.shift

    @property
    def forked(self) -> bool:
        """True if it is a branch of the first world."""
        return self.told["at"] is not None

    @property
    def mark(self) -> Message | None:
        """The entry in the log of interventions: the tick of the branch and its change."""
        if not self.forked:
            return None
        return {"tick": self.start, "text": f"what if: {self.told['change']}"}

    @property
    def comes(self) -> bool:
        """True if it is not at the tick of the first world, but can get there."""
        target = self._target()
        back = self.follower.first <= target < self.follower.tick
        return self.of.tick >= self.start and (self.follower.tick < target or back)

    @property
    def there(self) -> bool:
        """True if it has a state at the present tick of the first world."""
        return self.follower.tick == self._target() and self.of.tick >= self.start

    def _target(self) -> int:
        tick = self.of.tick + self.shift
        return min(tick, self.source.recording.last) if isinstance(self.source, Replay) else tick

    def follow(self, seconds: float) -> None:
        """Run toward the tick of the first world for at most about `seconds`, or go back to it."""
        if self.comes and self.follower.tick > self._target():
            self.back()
        elif self.comes:
            self.follower.follow(self._target(), seconds, self._sampled)

    def back(self) -> None:
        """Go back to the tick of the first world, as far as possible."""
        self.follower.back(max(self._target(), self.follower.start))
        self._sent = min(self._sent, self.follower.tick - 1)
        self._fated = -1

    def _sampled(self, tick: int) -> bool:
        """Return whether the first world's curves have a point at this tick of the second."""
        if isinstance(self.of, Live):
            return tick in self.of.curves.ticks
        return isinstance(self.of, Replay) and tick - self.shift in self.of.recording.curves["tick"]

    def frame(self, number: int, colour: str) -> bytes:
        """Return its frame."""
        known, of = self.source.hello()["colours"], asked(colour)
        shown = colour in known if of is None else self.shares(of)
        return self.source.frame(number, colour if shown else "species")

    def sample(self) -> None:
        """Add a point to its curves if the two worlds are at the same tick."""
        if self.there:
            self.follower.sample()

    def greeting(self) -> list[Message]:
        """Return the messages that a new page needs."""
        hello = self.source.hello()
        marks = [message for message in self.source.greeting() if message["kind"] == "marks"]
        return [{"kind": "beside", "hello": hello, **self.told}, *self._points(-1), *map(_wrapped, marks)]

    def news(self) -> list[Message]:
        """Return new points of its curves, marks, and deaths."""
        out = [
            _wrapped(message) if message["kind"] == "marks" else self.passed_on(message)
            for message in self.source.news()
            if message["kind"] in ("marks", "said", "organism")
        ]
        points = self._points(self._sent)
        if points:
            self._sent = points[0]["series"]["tick"][-1] + self.shift
        if self.there and self._fated != self.follower.tick:
            fates = self.source.fates(self._fated if self._fated < self.follower.tick else -1)
            self._fated = self.follower.tick
            out += [{"kind": "beside", "fates": fates}] if fates else []
        return [*out, *points]

    def _points(self, after: int) -> list[Message]:
        series = self.source.series(after)
        if series is None:
            return []
        ticks = [tick - self.shift for tick in series["tick"]]
        return [{"kind": "beside", "series": series | {"tick": ticks}}]

    def organism(self, uid: int) -> Message:
        """Return one of its organisms, living or dead; raise KeyError for an unknown one."""
        return self.labelled(self.source.organism(uid), second=True)

    def tell(self, request: Message) -> list[Message]:
        """Answer a request: `fill` at its displayed tick, or `tree`."""
        return [self.passed_on(message) for message in self.source.handle(request)]

    def passed_on(self, message: Message) -> Message:
        """Return one of its messages in the form that pages expect."""
        return self.labelled(message, second=True) if message["kind"] in ("organism", "tree") else message

    def labelled(self, message: Message, second: bool) -> Message:
        """Return a message about an organism with the name of its world, whether that is the second one, and
        whether both worlds have the organism because it was born before they parted."""
        both = {"both": self.shares(message["uid"])} if self.forked else {}
        return message | {"world": self.told["names"][second], "second": second} | both

    def shares(self, uid: int) -> bool:
        """Return whether an organism was born before the worlds parted."""
        return self.forked and uid < self.follower.common

    def refusals(self) -> list[str]:
        """Return the interventions of the first world that it has refused since the last call."""
        out, self.follower.refused = self.follower.refused, []
        return out

    def sentence(self) -> Message:
        """Return population sizes and a sentence on the present differences."""
        tick = self.of.tick
        n = self.source.counts()
        if self.there:
            since = self.start if self.forked else None
            kinds = sorted(self.of.hello()["species"], key=lambda kind: not kind["moves"])
            told = differences(
                [kind["name"] for kind in kinds], _side(self.of), _side(self.source), since, tick
            )
        elif tick < self.start:
            told = {"text": f"It parts from the original at tick {self.start:,}.", "clauses": {}}
        elif self.comes:
            told = {"text": f"Catching up: tick {self.tick:,} of {tick:,}.", "clauses": {}}
        else:
            told = {
                "text": f"It starts at tick {self.first:,}; earlier ticks are no longer stored.",
                "clauses": {},
            }
        return {"kind": "beside", "state": {"tick": self.tick, "there": self.there, "n": n, **told}}


def beside(first: Source, second: Source, names: tuple[str, str]) -> Second:
    """Return another world next to the first. If both are living, interventions apply to both."""
    told = {"at": None, "change": "", "names": list(names), "recipe": None}
    if isinstance(second, Live):
        ask = partial(as_done_to, first) if isinstance(first, Live) else lambda _: None
        return Second(first, second, Branch(second, second.tick, None, ask), told)
    assert isinstance(second, Replay)
    return Second(first, second, Shown(second), told)


def _ahead(source: Source) -> int:
    return source.ahead if isinstance(source, Watched) else 0


def _side(source: Source) -> Side:
    entries = source.story.entries if isinstance(source, Watched) else []
    kinds = {kind["name"] for kind in source.hello()["species"]}
    return side({name: n for name, n in source.counts().items() if name in kinds}, entries, source.tick)


def _wrapped(message: Message) -> Message:
    return {"kind": "beside", "marks": message}


NAMES = ("original", "what if")


def fork(first: Source, tick: int | None, change: Message | None, start: Start | None = None) -> Second:
    """Return a branch of the displayed world, from a tick (None: the displayed one) and with a change, an
    intervention in the form of a world file (None: no change).

    A recorded run is branched at the end of the displayed tick. Raises ValueError or ConfigError for a tick
    that is no longer stored and for a change that does not fit, CheckpointError or RecordingError for a world
    that cannot be copied or run here.
    """
    change = change or None
    if isinstance(first, Live):
        branch = of_living(first, first.tick if tick is None else tick, change)
        done = by_hand(first.world, 0, branch.start)
        done += waiting(first.world) if branch.start == first.tick else []
        again = branches.of_world(start, done, branch.start, change)
    elif isinstance(first, Replay):
        if tick is not None and tick != first.tick:
            raise ValueError(
                f"what if: tick = {tick}; expected {first.tick:,}, the displayed tick "
                f"of this recorded run: go to tick {tick} first"
            )
        branch = of_recorded(first, change)
        code = bool(first.recording.manifest["config"].get("code"))
        again = branches.of_run(str(first.recording.path), code, branch.start, change)
    else:
        raise ValueError("what if: this page shows nothing that can be branched")
    words = "nothing changed" if change is None else describe(change)
    told = {"at": branch.start - 1 + _ahead(first), "change": words, "names": list(NAMES), "recipe": again}
    return Second(first, branch.live, branch, told)


def forks(first: Source) -> bool:
    """Return whether the displayed world can be branched. A world built in Python cannot, nor can a recorded
    run whose world cannot be built here."""
    if isinstance(first, Live):
        return first.world.config is not None
    return isinstance(first, Replay) and first.recording.scene is not None


def choices(first: Source) -> Message:
    """Return the message "params": values that a change may set, and the first and last tick of a branch."""
    if isinstance(first, Live):
        config, ticks = first.world.config, (kept(first), first.tick)
    elif isinstance(first, Replay):
        scene = first.recording.scene
        config, ticks = None if scene is None else scene.config, (first.tick, first.tick)
    else:
        return {"kind": "params", **offered(None)}
    return {"kind": "params", **offered(config), "forks": list(ticks)}
