"""Watching: a source, its player and its server together, for the command line and for notebooks."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing
from typing import TYPE_CHECKING, Any

from ecs_eco.view.entrance import Entrance
from ecs_eco.view.pair import Pair
from ecs_eco.view.player import USUAL, Player
from ecs_eco.view.server import Server
from ecs_eco.view.source import Source

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World

Announce = Callable[[str], None]


def watch(
    source: Source,
    announce: Announce = print,
    *,
    port: int = 0,
    speed: float | None = USUAL,
    playing: bool = True,
    browser: bool = False,
) -> None:
    """Serve a source until Ctrl-C, in the thread that made it, and what pages begin in its place; `announce`
    gets an address, and another one after each use.

    Raises OSError if the port is taken.
    """
    player = served(source, speed, playing)
    with Server(player, port) as server, closing(Entrance(server, announce)) as entrance:
        if browser:
            entrance.open_browser()
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


def served(source: Source, *how: Any, **more: Any) -> Player:
    """Return a player of a source that lets pages ask what would be if; arguments as of `Player`."""
    pair = source if isinstance(source, Pair) else Pair(source)
    if pair.picker is not None:
        more = {"halted": lambda: pair.picker.wanted is not None, **more}
    return pair.attend(Player(pair, *how, **more))


def _begun(player: Player) -> Player | None:
    """Return the player of what pages want to begin, the same one where that cannot be; None where they want
    nothing."""
    picker = getattr(player.source, "picker", None)
    if picker is None or picker.wanted is None:
        return None
    made = picker.begin()
    if isinstance(made, str):
        player.tell("error", made)
        return player
    return served(made, player.speed)


class Window:
    """A view of a world that other code runs: `open` is called with it before its first tick,
    `close` after the last.

    The world waits between ticks while a page has paused it. It runs at full speed unless a page sets a lower
    one.
    """

    def __init__(
        self, ticks: int, announce: Announce = print, *, port: int = 0, browser: bool = False
    ) -> None:
        self.ticks, self.announce, self.port, self.browser = ticks, announce, port, browser
        self.world: Any = None
        self.player: Player | None = None
        self.server: Server | None = None
        self._entrance: Entrance | None = None

    def open(self, world: World) -> None:
        """Begin to serve this world; OSError if the port is taken."""
        from ecs_eco.view.live import Live

        self.world = world
        player = self.player = served(Live(world, self.ticks), None, halted=lambda: world.stopping)
        self.server = Server(player, self.port).start()
        world.before_tick.append(player.turn)
        self._entrance = Entrance(self.server, self.announce)
        if self.browser:
            self._entrance.open_browser()

    def close(self) -> None:
        """Show the end of the world, and stop serving it."""
        if self.server is None or self.player is None:
            return
        if self._entrance is not None:
            self._entrance.close()
        self.world.before_tick.remove(self.player.turn)
        self.player.show()
        time.sleep(0.2)  # time for the last messages, which the server's thread sends
        self.server.stop()

    def __enter__(self) -> Window:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
