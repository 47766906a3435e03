"""The commands watch, and run --watch."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ecs_eco.cli.terminal import refuse, say


def watch_it(
    what: str,
    changes: list[str],
    ticks: int | None,
    seed: int | None,
    threads: int,
    learn: bool | None,
    policies: str,
    port: int,
    browser: bool,
) -> None:
    """Show a living world, or a recorded run, until Ctrl-C."""
    from ecs_eco.record.archipelago import is_archipelago

    islands = is_archipelago(what)
    recorded = os.path.isfile(Path(what) / "manifest.json") or islands
    if recorded and (changes or ticks or seed is not None or learn is not None):
        allowed = ("a world; a recording is shown as it is, "
                   "and `resume --from-tick T --set … --out NEW` forks it")
        refuse("WORLD", "is a recorded run, which no option changes", what, allowed)
    if islands:
        _map(Path(what), port, browser)
        return
    with _port(port):
        from ecs_eco.view.watch import watch

        source = _replay(Path(what)) if recorded else _live(what, changes, ticks, seed, threads,
                                                            learn, policies)
        try:
            watch(source, _Announcer(source.hello()["title"]), port=port, browser=browser)
        except KeyboardInterrupt:
            say("")


def _map(folder: Path, port: int, browser: bool) -> None:
    from ecs_eco.record.archipelago import read
    from ecs_eco.view.islands import watch_islands

    manifest = read(folder)
    with _port(port):
        try:
            watch_islands(folder, _Announcer(manifest.get("title") or manifest["world"]), port=port,
                          browser=browser)
        except KeyboardInterrupt:
            say("")


@contextmanager
def window(ticks: int, title: str, port: int, browser: bool) -> Iterator[Any]:
    """A window on a world that is run and recorded: pass its `open` to the run."""
    from ecs_eco.view.watch import Window

    with _port(port), Window(ticks, _Announcer(title), port=port, browser=browser) as opened:
        yield opened


def _live(world: str, changes: list[str], ticks: int | None, seed: int | None, threads: int,
          learn: bool | None, policies: str) -> Any:
    from ecs_eco.cli.folders import known_policies
    from ecs_eco.config import load
    from ecs_eco.ecosystem import World
    from ecs_eco.view.live import Live

    config = load(world, changes)
    known_policies(policies, config)
    return Live(World.from_config(config, seed=seed, policies=policies, threads=threads,
                                  learn=learn),
                ticks)


def _replay(folder: Path) -> Any:
    from ecs_eco.view.replay import Replay

    return Replay(folder)


class _Announcer:
    """Prints the address of a viewer, and the next one each time an address was used."""

    def __init__(self, title: str) -> None:
        self.title, self.first = title, True

    def __call__(self, address: str) -> None:
        if not self.first:
            say(f"For another page: {address}")
            return
        self.first = False
        say(f"{self.title}: {address}")
        say("It admits one page, on this machine, within ten minutes, which can see and change the world; "
            "then another is printed here.")
        say("Ctrl-C ends it.")


@contextmanager
def _port(port: int) -> Iterator[None]:
    """Refuse a port that is not available."""
    import socket

    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind(("127.0.0.1", port))
        except OSError as error:
            refuse("--port", f"is not available: {error.strerror or error}", port,
                   "a free one, from 1024 to 65535, or 0 for any")
    yield
