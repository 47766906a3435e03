"""Show two worlds as one source (the page's world, and a branch or another world), or start a new world.

The first world provides the page's clock, charts and organisms. The second follows that clock in the same
thread. Pages receive the second frame after the first, and messages "beside"."""

import math
import time
from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Any

from ecs_eco.config.knobs import offered
from ecs_eco.config.shipped import titles
from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError, listed, nearest
from ecs_eco.view.branch import Start
from ecs_eco.view.export import page
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player
from ecs_eco.view.replay import Replay
from ecs_eco.view.replicates import Replicates, begin
from ecs_eco.view.second import Second, Swept, beside, fork
from ecs_eco.view.source import Message, Source, is_whole, said, short

SEEDS = 2**53  # from here on, JavaScript numbers are no longer exact


class Picker:
    """The worlds that a page can start: the shipped ones and the displayed one. `build(world, seed)` returns a
    `Pair` or raises any error; seed None selects the seed in the world file."""

    def __init__(self, world: str, title: str, build: Callable[[str, int | None], Any]) -> None:
        name = world.replace("_", "-")
        known = titles()
        self.world = self.first = name if name in known else world
        self.titles = known if self.world in known else {world: title, **known}
        self.build = build
        self.wanted: tuple[str, int | None] | None = None  # the world to start once the tick is over
        self.begun = 0  # number of worlds started by this server so far

    def offered(self) -> Message:
        """Return the data that a page needs to offer the choice."""
        worlds = [{"name": name, "title": title} for name, title in self.titles.items()]
        return {"worlds": worlds, "world": self.world, "begun": self.begun}

    def ask(self, request: Message) -> Message:
        """Store the world to start, {"world", "seed"}; raise ValueError if it is not offered."""
        world, seed = request.get("world", self.world), request.get("seed")
        if not isinstance(world, str) or world not in self.titles:
            raise ValueError(
                f"begin: world = {short(world)}; expected {listed(self.titles)}; "
                f"did you mean {nearest(str(world), list(self.titles))!r}?"
            )
        if seed is not None and not is_whole(seed, 0, SEEDS):
            raise ValueError(
                f"begin: seed = {short(seed)}; expected a whole number from 0 to {SEEDS - 1}, "
                "or null for the seed in the world file"
            )
        self.wanted = world, seed
        return said("info", f"starting {self.titles[world] or world} …", "begin")

    def begin(self) -> Any:
        """Return the source of the requested world, or an explanation of why it cannot be started."""
        assert self.wanted is not None
        (world, seed), self.wanted = self.wanted, None
        try:
            made = self.build(world, seed)
        except Exception as error:  # no failure stops the displayed world
            return f"{world} cannot be started: {error}"
        self.world, self.begun, made.picker = world, self.begun + 1, self
        return made


def reason(first: Live | Replay, second: Live | Replay | None) -> str:
    """Return why the displayed world cannot be replaced."""
    if second is not None:
        return "Two worlds are shown side by side."
    if not isinstance(first, Live):
        return "This is a recorded run."
    return "The program that runs this world decides which world to start."


SLICE = 0.05  # [s] maximum time for the second world to catch up before pages are served again
ALONE = 0.2  # [s] the same while the first world is paused
WORDS = 0.25  # [s] between sentences
LOOK = 1.0  # [s] between reports on the progress of replicates


class Pair(Source):
    """A source, optionally with a second source next to it. A frame shows both worlds, one after the other, or
    only the first while the second has no state at this tick.

    `start` is the command that started a live world, used in the command that reproduces its branches;
    `picker` offers the worlds that can replace it; `sweeps` are those of a recorded run. Call
    `attend(player)` before `run`."""

    def __init__(
        self,
        first: Live | Replay,
        second: Live | Replay | None = None,
        names: tuple[str, str] = ("", ""),
        start: Start | None = None,
        picker: Picker | None = None,
        sweeps: Sequence[Swept] = (),
    ) -> None:
        self.first, self.begun, self.picker, self.sweeps = first, start, picker, sweeps
        self._why = reason(first, second)
        self.player: Player | None = None
        self.second: Second | None = None if second is None else beside(first, second, names)
        self.replicates: Replicates | None = None
        self._looked_at, self._told = -math.inf, list[Message]()  # messages for all pages
        self._said_at, self._said_tick = -math.inf, -1

    def attend(self, player: Player) -> Player:
        """Store and return the player, which serves pages while the second world catches up."""
        self.player = player
        return player

    @property
    def tick(self) -> int:
        return self.first.tick

    @property
    def done(self) -> bool:
        return self.first.done

    def counts(self) -> dict[str, int]:
        return self.first.counts()

    def fates(self, after: int) -> Sequence[Sequence[float]]:
        return self.first.fates(after)

    def field(self, name: str) -> Message:
        return self.first.field(name)

    def scales(self, colour: str) -> dict[str, tuple[float, float]]:
        return self.first.scales(colour)

    def series(self, after: int) -> Message | None:
        return self.first.series(after)

    def organism(self, uid: int) -> Message:
        state = self.first.organism(uid)
        return state if self.second is None else self.second.labelled(state, second=False)

    def run(self, turn: Callable[[], bool]) -> None:

        def both() -> bool:
            go = turn()
            while go and self._behind():  # the next tick waits for the second world
                self._come_up()
                go = self.player is None or self.player.attend()
            return go

        self.first.run(both)

    def hello(self) -> Message:
        begins = {"why": self._why} if self.picker is None else self.picker.offered()
        return self.first.hello() | {
            "forks": self.first.config is not None,
            "begins": begins,
            "saves": isinstance(self.first, Replay),
        }

    def greeting(self) -> list[Message]:
        own = [self._marked(message) for message in self.first.greeting()]
        return own if self.second is None else [*own, *self.second.greeting(), self._sentence()]

    def news(self) -> list[Message]:
        if self._behind():
            self._come_up(ALONE)
        out = [self._marked(message) for message in self.first.news()]
        out += self._progress()
        out, self._told = [*self._told, *out], []
        if self.second is None:
            return out
        out += self.second.news()
        now = time.monotonic()
        if self.second.tick != self._said_tick and now >= self._said_at + WORDS:
            out.append(self._sentence())
        return out

    def passed(self) -> None:
        self.first.passed()
        if self.second is not None:
            self._come_up()

    def frame(self, number: int, colour: str) -> bytes:
        frame = self.first.frame(number, colour)
        if self.second is None or not self.second.there:
            return frame
        return frame + self.second.frame(number, colour)

    def sample(self) -> None:
        self.first.sample()
        if self.second is not None:
            self.second.sample()

    def handle(self, request: Message) -> list[Message]:
        if request["kind"] in REQUESTS:
            return REQUESTS[request["kind"]](self, request)
        if self.second is not None and request["kind"] in ("fill", "tree") and request.get("second"):
            return [self.second.passed_on(message) for message in self.second.source.handle(request)]
        if self.second is None or not isinstance(self.first, Live):
            return self.first.handle(request)
        if request["kind"] == "act" and self.second.forked and self.tick < self.second.start:
            raise ValueError(
                f"act: the worlds diverge at tick {self.second.start:,}; "
                "to change an earlier tick, go to that tick or first close the second world"
            )
        return self._seek(request) if request["kind"] == "seek" else self.first.handle(request)

    def _begin(self, request: Message) -> list[Message]:
        if self.picker is None:
            raise ValueError(f"begin: {self._why}")
        return [self.picker.ask(request)]

    def _params(self, request: Message) -> list[Message]:
        first = self.first.earliest if isinstance(self.first, Live) else self.tick
        return [{"kind": "params", **offered(self.first.config), "forks": [first, self.tick]}]

    def _file(self, request: Message) -> list[Message]:
        """Return the recorded run as a page in one file."""
        if not isinstance(self.first, Replay):
            raise ValueError(
                "export: this world is live; record it with `ecs-eco run`, then export its folder"
            )
        name = f"{self.first.recording.manifest['world']}.html"
        return [{"kind": "file", "name": name, "html": page(self.first)}]

    def _whatif(self, request: Message) -> list[Message]:
        if request.get("close"):
            return self._close("The second world is closed; the original continues.")
        tick, change = request.get("tick"), request.get("what")
        if tick is not None and not is_whole(tick, -(2**63)):
            raise ValueError(f"what if: tick = {str(tick)[:60]}; expected a whole number")
        swept, number = None, request.get("sweep")
        if number is not None:
            if not is_whole(number, 0, len(self.sweeps)) or self.sweeps[number].edit is None:
                raise ValueError(
                    f"what if: sweep = {short(number)}; expected a sweep with effects of its allele"
                )
            swept = self.sweeps[number]
        try:
            made = fork(self.first, tick, change, self.begun, swept)
        except (CheckpointError, ConfigError, RecordingError, ValueError, RuntimeError, OSError) as error:
            problems = error.problems if isinstance(error, ConfigError) else []
            field = ".".join(map(str, problems[0].key)) if problems else ""
            return [said("error", str(error), "whatif") | ({"at": field} if field else {})]
        self._close("")
        self.second = made
        self._show([*made.greeting(), self._sentence(), self._marked(self.first.marks())])
        return [said("info", f"branched at tick {made.start:,}: {made.told['change']}", "whatif")]

    def _pairs(self, request: Message) -> list[Message]:
        """Begin to run pairs of worlds with the same seeds, without and with a change; or stop."""
        if self.replicates is not None:
            self.replicates.close()
            self.replicates = None
        if request.get("stop"):
            return [{"kind": "pairs", "stopped": True}]
        self.replicates = begin(self.first, self.begun, request)
        self._looked_at = -math.inf
        return self._progress()

    def _progress(self) -> list[Message]:
        """Return the progress of replicates at most once a second, and their outcome once."""
        now = time.monotonic()
        if self.replicates is None or now < self._looked_at + LOOK:
            return []
        self._looked_at, state = now, self.replicates.state()
        if "html" in state or "problem" in state:
            self.replicates.close()
            self.replicates = None
        return [state]

    def _close(self, why: str) -> list[Message]:
        if self.second is None:
            return []
        self.second = None
        self._show([{"kind": "beside", "closed": why}, self._marked(self.first.marks())])
        return [said("info", why, "whatif")] if why else []

    def _show(self, messages: list[Message]) -> None:
        """Send messages to all pages, and resend this tick's frame."""
        self._told += messages
        if self.player is not None:
            self.player.again()

    def _seek(self, request: Message) -> list[Message]:
        """Go back in both worlds, but no further than both can go."""
        assert self.second is not None
        tick = request.get("tick")
        if isinstance(tick, int | float) and math.isfinite(tick) and tick > self.second.start:
            request = request | {"tick": max(round(tick), self.second.first)}
        answers = self.first.handle(request)
        self.second.back_to(self.second.target)
        self._said_tick = -1
        return answers

    def _behind(self) -> bool:
        return self.second is not None and not self.second.there and self.second.comes

    def _come_up(self, seconds: float = SLICE) -> None:
        """Run the second world briefly, at most to the tick of the first world; close it if it fails."""
        second = self.second
        if second is None:
            return
        was = second.there
        try:
            second.follow(seconds)
        except Exception as error:
            self._close("")
            self._told.append(said("error", f"the second world stopped: {error}", "whatif"))
            return
        self._told += [said("warning", f"the second world: {text}", "act") for text in second.refusals()]
        if second.there and not was and self.player is not None:
            self.player.again()

    def _sentence(self) -> Message:
        assert self.second is not None
        self._said_at, self._said_tick = time.monotonic(), self.second.tick
        return self.second.sentence()

    def _marked(self, message: Message) -> Message:
        """Return the message, with the branch's tick and change added to marks, and sweeps to the story."""
        if message["kind"] == "story" and self.sweeps:
            own = [
                one.entry | ({"sweep": i} if one.edit is not None else {})
                for i, one in enumerate(self.sweeps)
            ]
            return message | {"entries": sorted([*message["entries"], *own], key=itemgetter("tick"))}
        if message["kind"] != "marks" or self.second is None or self.second.mark is None:
            return message
        return message | {"interventions": [*message["interventions"], self.second.mark]}


REQUESTS: dict[str, Callable[[Pair, Message], list[Message]]] = {
    "whatif": Pair._whatif,
    "pairs": Pair._pairs,
    "export": Pair._file,
    "begin": Pair._begin,
    "params": Pair._params,
}
