"""Combine a source, its player and its server, for the command line and notebooks."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing
from html import escape
from typing import Any

from ecs_eco.ecosystem import World
from ecs_eco.engine.hooks import listening
from ecs_eco.view.entrance import Entrance
from ecs_eco.view.live import Live
from ecs_eco.view.pair import Pair
from ecs_eco.view.panels import Function
from ecs_eco.view.player import USUAL, Player
from ecs_eco.view.replay import Replay
from ecs_eco.view.server import Server

Announce = Callable[[str], None]


def watch(
    source: Live | Replay | Pair,
    announce: Announce = print,
    *,
    port: int = 0,
    speed: float | None = USUAL,
    playing: bool = False,
    browser: bool = False,
    panels: Mapping[str, Function] | None = None,
) -> None:
    """Serve a source, and any world that pages start in its place, until Ctrl-C.

    Call this in the thread that created the source.

    Parameters
    ----------
    source : Live or Replay or Pair
        A live world, a recorded run, or two of them side by side.
    announce : callable
        Receives the page's address, and a new one after each use.
    port : int, default 0
        Any free port if 0.
    speed : float or None
        [ticks/s]; None for as fast as possible.
    playing : bool, default False
        Start at once, without waiting for a page to play it.
    browser : bool, default False
        Also open the page in the browser.
    panels : mapping of str to callable, optional
        Your own panels on the page, by name. Each function receives the `World`, or the `Replay` of a recorded
        run, and returns a number, a matplotlib figure or an SVG text.

    Raises
    ------
    OSError
        If the port is taken.

    Examples
    --------
    >>> from ecs_eco.view.replay import Replay
    >>> from ecs_eco.view.watch import watch
    >>> panels = {"Oldest deer": lambda run: run.tick - run.listed("deer")["born"].min()}
    >>> watch(Replay("my-run"), panels=panels)  # doctest: +SKIP
    """
    player = served(source, speed, playing, panels=panels)
    with Server(player, port) as server, closing(Entrance(server, announce, browser)):
        try:
            player.source.run(player.turn)
            while (after := _begun(player)) is not None:
                if after is not player:
                    server.show(after)
                player = after
                player.source.run(player.turn)
        except Exception as error:
            player.tell("error", f"the world stopped: {error}")
            time.sleep(0.2)
            raise


def served(source: Live | Replay | Pair, *how: Any, **more: Any) -> Player:
    """Return a player for a source that lets pages create branches. The arguments are those of `Player`."""
    pair = source if isinstance(source, Pair) else Pair(source)
    if pair.picker is not None:
        more = {"halted": lambda: pair.picker.wanted is not None, **more}
    return pair.attend(Player(pair, *how, **more))


def _begun(player: Player) -> Player | None:
    """Return the player of the world that pages want to start, the same if that fails, None if none is wanted."""
    picker = getattr(player.source, "picker", None)
    if picker is None or picker.wanted is None:
        return None
    made = picker.begin()
    if isinstance(made, str):
        player.tell("error", made)
        return player
    return served(made, player.speed, panels=player.panels.functions)


class Window(ExitStack):
    """A view of a world that other code runs, at full speed unless a page slows or pauses it. Call `open` before
    the first tick; `close` shows the end of the world."""

    def __init__(
        self, ticks: int, announce: Announce = print, *, port: int = 0, browser: bool = False
    ) -> None:
        super().__init__()
        self.ticks, self.announce, self.port, self.browser = ticks, announce, port, browser
        self.player: Player | None = None

    def open(self, world: World) -> None:
        """Start serving this world; raise OSError if the port is taken."""
        player = self.player = served(Live(world, self.ticks), None, halted=lambda: world.stopping)
        server = self.enter_context(Server(player, self.port))
        self.callback(time.sleep, 0.2)  # time for the server's thread to send the last messages
        self.callback(player.show)
        self.enter_context(listening(world.before_tick, player.turn))
        self.enter_context(closing(Entrance(server, self.announce, self.browser)))


SLICE = 0.04  # [s] time for ticks before control returns to the notebook
FRAMES = ("http://localhost:*", "http://127.0.0.1:*")  # notebooks on this machine may embed the page


class Panel:
    """A page in an output cell, until `close()` or another `world.view()` of the same world. The world is paused
    until you press play, and while a cell runs."""

    def __init__(
        self,
        live: Live,
        *,
        speed: float | None,
        playing: bool,
        height: int,
        port: int,
        panels: Mapping[str, Function] | None = None,
    ) -> None:
        self.world, self.height = live.world, height
        self.player = served(live, speed, playing, panels=panels)
        self.server: Server | None = Server(self.player, port, FRAMES).start()
        self._loop = asyncio.get_running_loop()
        self._next = self._loop.call_soon(self._pump)

    def close(self) -> None:
        """Stop serving the page; the world does not change."""
        self._next.cancel()
        server, self.server = self.server, None
        if _PANELS.get(self.world) is self:
            del _PANELS[self.world]
        if server is not None:
            server.stop()

    def _pump(self) -> None:
        """Briefly run the ticks that are due, then return control to the notebook."""
        until, wait = time.monotonic() + SLICE, 0.0
        while time.monotonic() < until:
            due, wait = self.player.poll()
            if not due:
                break
            try:
                self.world.run(1)
            except Exception as error:
                self.player.playing = False
                self.player.tell("error", f"the world stopped: {error}")
        self._next = self._loop.call_later(min(max(wait, 0.001), SLICE), self._pump)

    def _repr_html_(self) -> str:
        if self.server is None:
            return "<p>This view is closed. Open a new one with <code>world.view()</code>.</p>"
        style = "width: 100%; border: 1px solid #ccd; border-radius: 6px"
        return (
            f'<iframe src="{escape(self.server.address())}" title="{escape(self.world.name)}" '
            f'height="{self.height}" style="{style}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<view of {self.world!r}{'' if self.server else ', closed'}>"


_PANELS: dict[Any, Panel] = {}  # open panels by world


def view(
    world: World,
    ticks: int | None = None,
    *,
    speed: float | None = USUAL,
    playing: bool = False,
    height: int = 640,
    port: int = 0,
    panels: Mapping[str, Function] | None = None,
) -> Panel | None:
    """Show a live world in the output cell of a notebook or, outside a notebook, in the browser until Ctrl-C.

    The world runs for `ticks` more ticks (None: indefinitely). `speed` is in ticks/s (None: full speed),
    `height` in px, and `panels` are as in `watch`. The notebook must run on this machine, because the page is
    served from 127.0.0.1.
    """
    last = None if ticks is None else world.tick + ticks
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        watch(Live(world, last), port=port, speed=speed, playing=playing, browser=True, panels=panels)
        return None
    if (former := _PANELS.get(world)) is not None:
        former.close()
    panel = _PANELS[world] = Panel(
        Live(world, last), speed=speed, playing=playing, height=height, port=port, panels=panels
    )
    return panel
