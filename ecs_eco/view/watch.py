"""Watching: a source, its player and its server together, for the command line and for notebooks."""

from __future__ import annotations

import os
import sys
import time
import webbrowser
from collections.abc import Callable
from typing import Any

from ecs_eco.view.player import USUAL, Player
from ecs_eco.view.server import Server
from ecs_eco.view.source import Source

Announce = Callable[[str], None]


def watch(source: Source, announce: Announce = print, *, port: int = 0, speed: float | None = USUAL, playing: bool = True) -> None:
    """Serve a source until Ctrl-C; `announce` hears the address. Called in the thread that made the source.

    Raises OSError where the port is taken.
    """
    player = Player(source, speed, playing)
    with Server(player, port) as server:
        announce(server.address)
        try:
            source.run(player.turn)
        except Exception as error:
            player.tell("error", f"the world stopped: {error}")
            time.sleep(0.2)
            raise


class Window:
    """A view of a world that something else runs: `open` is called with it before its first tick, `close` after the last.

    The world waits between ticks while a page has paused it. Runs as fast as it can unless a page asks for less.
    """

    def __init__(self, ticks: int, announce: Announce = print, *, port: int = 0) -> None:
        self.ticks, self.announce, self.port = ticks, announce, port
        self.world: Any = None
        self.player: Player | None = None
        self.server: Server | None = None

    def open(self, world: Any) -> None:
        """Begin to serve this world; OSError where the port is taken."""
        from ecs_eco.view.live import Live

        self.world = world
        player = self.player = Player(Live(world, self.ticks), None, halted=lambda: world.stopping)
        self.server = Server(player, self.port).start()
        world.between = player.turn
        self.announce(self.server.address)

    def close(self) -> None:
        """Show how the world ended, and serve it no longer."""
        if self.server is None or self.player is None:
            return
        self.world.between = None
        self.player.show()
        time.sleep(0.2)  # for the last messages: they go out in the server's thread
        self.server.stop()

    def __enter__(self) -> Window:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def open_browser(address: str) -> bool:
    """Open the address in a browser with windows; say whether there is one."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False  # a browser for terminals would take this one
    try:
        return webbrowser.open(address)
    except (webbrowser.Error, OSError):
        return False
