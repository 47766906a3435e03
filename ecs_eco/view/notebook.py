"""The viewer's page in an output cell of a notebook: the world lives between the cells, in their thread."""

from __future__ import annotations

import asyncio
import time
from html import escape
from typing import TYPE_CHECKING, Any

from ecs_eco.view.live import Live
from ecs_eco.view.player import USUAL
from ecs_eco.view.server import Server
from ecs_eco.view.watch import served

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World

SLICE = 0.04  # [s] that ticks may take before the notebook has its turn
FRAMES = ("http://localhost:*", "http://127.0.0.1:*")  # who may hold the page: notebooks on this machine


class Panel:
    """A page in an output cell. The world stands still until somebody presses play, and while a cell runs.

    `close()` ends it; a second `world.view()` of the same world ends the first.
    """

    def __init__(
        self, world: World, ticks: int | None, *, speed: float | None, playing: bool, height: int, port: int
    ) -> None:
        self.world, self.height = world, height
        self.player = served(Live(world, None if ticks is None else world.tick + ticks), speed, playing)
        self.server: Server | None = Server(self.player, port, FRAMES).start()
        self._loop = asyncio.get_running_loop()
        self._next = self._loop.call_soon(self._pump)

    def close(self) -> None:
        """Stop serving the page; the world stays as it is."""
        self._next.cancel()
        server, self.server = self.server, None
        if _PANELS.get(self.world) is self:
            del _PANELS[self.world]
        if server is not None:
            server.stop()

    def _pump(self) -> None:
        """Let ticks pass that are due, for a moment; then the notebook has its turn."""
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
            return "<p>This view is closed: <code>world.view()</code> opens another.</p>"
        style = "width: 100%; border: 1px solid #ccd; border-radius: 6px"
        return (
            f'<iframe src="{escape(self.server.address())}" title="{escape(self.world.name)}" '
            f'height="{self.height}" style="{style}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<view of {self.world!r}{'' if self.server else ', closed'}>"


_PANELS: dict[Any, Panel] = {}  # those that are open, by their world


def view(
    world: World,
    ticks: int | None = None,
    *,
    speed: float | None = USUAL,
    playing: bool = False,
    height: int = 640,
    port: int = 0,
) -> Panel | None:
    """Show a living world: in a notebook in the output cell, elsewhere in the browser until Ctrl-C.

    `ticks` from now on, or without end; `speed` [ticks/s], None for as fast as possible; `height` [px].
    The notebook must run on this machine: the page comes from 127.0.0.1.
    """
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        from ecs_eco.view.watch import watch

        last = None if ticks is None else world.tick + ticks
        watch(Live(world, last), port=port, speed=speed, browser=True)
        return None
    if (former := _PANELS.get(world)) is not None:
        former.close()
    panel = _PANELS[world] = Panel(world, ticks, speed=speed, playing=playing, height=height, port=port)
    return panel
