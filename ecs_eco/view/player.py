"""The player, which advances time at the speed requested by pages and sends them the data that they display.

It runs in the world's thread. Requests from pages arrive in `inbox` from the server's thread and are read
between ticks. Frames are never queued: the next frame is made from the current state once the page has
acknowledged the last."""

import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from ecs_eco.engine.errors import nearest
from ecs_eco.view.families import asked
from ecs_eco.view.listing import one_of
from ecs_eco.view.panels import Function, Panels
from ecs_eco.view.shown import Inbox, Log, Page, View, beside, choose, panel
from ecs_eco.view.source import Message, Source, is_whole, said, short, text

USUAL = 10.0  # ticks per second, shown as 1×
FASTEST_FRAMES = 0.05  # [s] between frames
BUSY_FRAMES = 0.25  # [s] between frames of a world running at full speed; the page interpolates motion
PATIENCE = 0.25  # [s] between states, and maximum wait
SHARE = 0.03  # maximum share of a running world's time spent on frames, charts and panels
SPEEDS = (0.01, 100_000.0)
ELSEWHERE = (
    "act",
    "params",
    "seek",
    "fill",
    "why",
    "table",
    "tree",
    "scatter",
    "whatif",
    "pairs",
    "begin",
    "export",
)


class Player(Inbox):
    """Plays a source at `speed` [ticks/s] (None: full speed) for any number of pages until `halted()`; `panels`
    are functions of the world whose results pages show, by name."""

    def __init__(
        self,
        source: Source,
        speed: float | None = USUAL,
        playing: bool = True,
        halted: Callable[[], bool] = lambda: False,
        panels: Mapping[str, Function] | None = None,
    ) -> None:
        self.source, self.speed, self.playing, self.halted = source, speed, playing, halted
        super().__init__()
        self.panels = Panels(source, panels)
        self.frames = 0  # frames made so far
        self._views: dict[Page, View] = {}
        self._steps = 0
        self._next = time.monotonic()  # when the next tick is due
        self._looks = -math.inf, -math.inf  # next time to serve if the tick stays the same, and if it changes
        self._passed = -1  # the last tick reported to the source
        self._served = -1  # the tick at which pages were last served
        # the last frame for each color: tick, number, bytes
        self._made: dict[str, tuple[int, int, bytes]] = {}
        self._cost = {"frame": 0.0, "sample": 0.0}  # [s] each
        self._sampled, self._sample_at, self._state_at = -1, -math.inf, -math.inf
        self._ticked, self._rate = (time.monotonic(), source.tick), 0.0
        hello = source.hello()
        self._colours: list[str] = hello["colours"]
        self._log = Log(self._views, bool(hello.get("acts")))

    def turn(self) -> bool:
        """Serve the pages until the next tick is due; return False when it is time to end."""
        while True:
            self._wake.clear()
            due, wait = self.poll()
            if self.closing or self.halted():
                return False
            if due:
                return True
            self._wake.wait(wait)

    def poll(self) -> tuple[bool, float]:
        """Serve the pages; return whether a tick is due and, if not, the time until the next call [s]."""
        if self.source.tick != self._passed:
            self._passed = self.source.tick
            self.source.passed()
        for _ in range(len(self.inbox)):  # later messages wait for the next call, so that ticks continue
            page, request = self.inbox.popleft()
            self._answer(page, request)
            soonest = -math.inf
            if request.get("kind") == "ack" and page in self._views:
                soonest = self._views[page].frame_at + self._period()
            self._looks = min(self._looks[0], soonest), min(self._looks[1], soonest)
        now = time.monotonic()
        if now >= self._looks[self.source.tick != self._served]:
            self._serve(now)
        if self.closing or self.halted():
            return False, 0.0
        due = self._due(now)
        if due <= now:
            return True, 0.0
        return False, max(0.0, min(due, self._looks[self.source.tick != self._served]) - now)

    def attend(self) -> bool:
        """Serve the pages, whether or not a tick is due; return False when it is time to end."""
        self.poll()
        return not (self.closing or self.halted())

    def again(self) -> None:
        """Resend this tick's frame if it was sent, because a second world has appeared or disappeared."""
        if all(tick != self.source.tick for tick, _, _ in self._made.values()):
            return  # it will be made when pages are ready for it
        self._made.clear()
        self._looks = -math.inf, -math.inf
        for view in self._views.values():
            view.seen, view.panel, view.news = None, None, True

    def tell(self, level: str, words: str) -> None:
        """Send a text message to all pages."""
        message = said(level, words)
        for page in self._views:
            page.send([text(message)])
        self._log.told(self.source.tick, [message])

    def show(self) -> None:
        """Send the final state and frame to all pages that are ready for them."""
        for view in self._views.values():
            view.frame_at, view.news = -math.inf, True
        self._serve(time.monotonic())

    def _due(self, now: float) -> float:
        """Return when the next tick is due, and count it if it is due now."""
        if self._steps and not self.source.done:
            self._steps -= 1
            return now
        if not self.playing or self.source.done:
            self._steps = 0
            if self.playing:  # playing ends here; going back does not resume it
                self.playing = False
                self._refresh_all()
            return math.inf
        if self.speed is None:
            return now
        due = self._next
        if due <= now:
            self._next = max(due + 1.0 / self.speed, now - PATIENCE)  # lost time is made up within limits
        return due

    def _serve(self, now: float) -> None:
        """Send each page the data that is due, and set when to serve next."""
        tick = self._served = self.source.tick
        if tick != self._sampled and now >= self._sample_at:
            self._sampled = tick
            self._sample_at = now + max(2 * self._period(), self._timed("sample", self.source.sample) / SHARE)
        state = now >= self._state_at and self.playing
        if state or any(view.news for view in self._views.values()):
            self._state_at = now + PATIENCE
            before, was = self._ticked
            if now - before > 0.2:
                self._rate, self._ticked = max(0.0, (tick - was) / (now - before)), (now, tick)
        news = [text(message) for message in self._log.told(tick, self.source.news())]
        # curve points wait for the next frame, because waking the server's thread is the largest cost
        ready = any(view.awaits is None for view in self._views.values())
        same, new = now + PATIENCE, now + PATIENCE if ready else min(now + PATIENCE, self._sample_at)
        for page, view in self._views.items():
            out: list[str | bytes] = [*news]
            stood = not self.playing and view.sent_tick != tick  # after a single step by the user
            due, shown = view.news or ((state or stood) and view.awaits is None), view.seen
            if view.awaits is None:
                self.panels.add(view, tick, out)
                self._timed("frame", partial(self._show, view, out, now))
                new = min(new, view.frame_at + self._period())
                if view.awaits is None and not view.whole(tick):
                    same = min(same, max(now, min(view.frame_at, view.panel_at) + FASTEST_FRAMES))
            # after the frame, which sets the range of a new color
            if due or (shown or ("", ""))[1] != (view.seen or ("", ""))[1]:
                view.news, view.sent_tick = False, tick
                out.append(self._state(view))
            if out:
                page.send(out)
        self._looks = (min(same, self._sample_at) if tick != self._sampled else same), new

    def _period(self) -> float:
        """Return the time between frames [s], increased if frames take too much time from a running world."""
        busy = self.playing and self.speed is None
        return (
            max(BUSY_FRAMES, self._cost["frame"] * max(1, len(self._views)) / SHARE)
            if busy
            else FASTEST_FRAMES
        )

    def _timed(self, part: str, work: Callable[[], Any]) -> float:
        """Do some work and return its typical time [s], in which slow calls, such as the first, count little."""
        begin = time.perf_counter()
        if work() is not False:
            spent, usual = time.perf_counter() - begin, self._cost[part]
            self._cost[part] = (
                min(spent, max(1.5 * usual, 0.0005)) if spent > usual else 0.5 * (spent + usual)
            )
        return self._cost[part]

    def _show(self, view: View, out: list[str | bytes], now: float) -> bool:
        """Add the series points, panel and frame that a page lacks; return whether there are any."""
        tick, n = self.source.tick, len(out)
        series = self.source.series(view.series)
        if series is not None:
            view.series = series["tick"][-1]
            out.append(text(series))
        if (
            view.selected is not None
            and view.panel != (tick, view.selected)
            and now >= view.panel_at + 2 * FASTEST_FRAMES
        ):
            panel(self.source, view, now, out)
        if view.seen != (tick, view.colour) and now >= view.frame_at + self._period():
            if self._made.get(view.colour, (-1,))[0] != tick:
                self.frames += 1
                self._made[view.colour] = tick, self.frames, self.source.frame(self.frames, view.colour)
            _, view.awaits, frame = self._made[view.colour]
            view.seen, view.frame_at = (tick, view.colour), now
            out.append(frame)
        beside(self.source, view, now, out)
        return len(out) > n

    def _state(self, view: View) -> str:
        source = self.source
        rate = round(self._rate, 2) if self.playing and not source.done else 0.0
        return text(
            {
                "kind": "state",
                "playing": self.playing,
                "speed": self.speed,
                "tick": source.tick,
                "rate": rate,
                "done": source.done,
                "n": source.counts(),
                "scales": source.scales(view.colour),
                "pages": len(self._views),
            }
        )

    def _answer(self, page: Page, request: Message) -> None:
        kind = request.get("kind")
        if kind == "join":
            new = self._views[page] = View()
            hello = self.source.hello() | {"panels": list(self.panels.functions)}
            greeting = hello, *self.source.greeting(), *self._log.came(new)
            page.send([text(message) for message in greeting])
            return
        if (view := self._views.get(page)) is None:
            return
        if kind == "leave":
            del self._views[page]
            return
        try:
            if kind in ELSEWHERE:
                self._ask(page, view, request)
            elif kind in REQUESTS:
                REQUESTS[kind](self, view, request)
            else:
                raise ValueError(
                    f"unknown request {str(kind)[:40]!r}; "
                    f"did you mean {nearest(kind, [*REQUESTS, *ELSEWHERE])!r}?"
                )
        except Exception as error:  # a page's message must never end the run; a ConfigError is a ValueError
            words = str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
            refusal = said("error", words, str(kind)[:40])
            page.send([text(refusal)])
            self._log.answered(self.source.tick, view, request, [refusal])

    def _ask(self, page: Page, view: View, request: Message) -> None:
        before = self.source.tick
        answers = self.source.handle(request)
        if request["kind"] == "seek":
            self._made.clear()
            if self.source.hello()["mode"] == "live" and self.source.tick <= before:
                self._go_back()
        if answers:
            page.send([text(answer) for answer in answers])
            self._log.answered(before, view, request, answers)
        if request["kind"] == "fill":
            for view in self._views.values():
                view.panel = None
        self._refresh_all()

    def _go_back(self) -> None:
        """Discard the data already sent for ticks that a live world will run again."""
        tick = self._passed = self.source.tick
        self._sampled, self._sample_at, self._ticked = -1, -math.inf, (time.monotonic(), tick)
        self._next = time.monotonic()
        self.panels.made.clear()
        for view in self._views.values():
            view.back(tick)

    def _refresh_all(self) -> None:
        for view in self._views.values():
            view.news = True

    def _ack(self, view: View, request: Message) -> None:
        if view.awaits is not None and request.get("frame") == view.awaits:
            view.awaits = None

    def _play(self, view: View, request: Message) -> None:
        self.playing, self._steps = request["kind"] == "play", 0
        self._next = time.monotonic()
        self._refresh_all()

    def _step(self, view: View, request: Message) -> None:
        ticks = request.get("ticks", 1)
        if not is_whole(ticks, 1, 100_001):
            raise ValueError(f"step: ticks = {short(ticks)}; expected a whole number from 1 to 100000")
        self.playing = False
        self._steps += ticks
        self._refresh_all()

    def _speed(self, view: View, request: Message) -> None:
        value = request.get("value")
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if value is not None and not (number and SPEEDS[0] <= value <= SPEEDS[1]):
            raise ValueError(
                f"speed: value = {short(value)}; expected "
                f"{SPEEDS[0]:g} to {SPEEDS[1]:g} ticks per second, or null"
            )
        self.speed = None if value is None else float(value)
        self._next = time.monotonic()
        self._refresh_all()

    def _colour(self, view: View, request: Message) -> None:
        by = request.get("by")
        view.colour = one_of("colour: by", by, self._colours) if asked(by) is None else str(by)
        view.news = True


REQUESTS: dict[str, Callable[[Player, View, Message], None]] = {
    "ack": Player._ack,
    "play": Player._play,
    "pause": Player._play,
    "step": Player._step,
    "speed": Player._speed,
    "select": lambda player, view, request: choose(player.source, view, request),
    "colour": Player._colour,
    "field": lambda player, view, request: view.lay(player.source, request),
    "panels": lambda player, view, request: player.panels.ask(view, request),
}
