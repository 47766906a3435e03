"""The command watch, and the option --watch of run."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.folders import POLICIES, known_policies
from ecs_eco.cli.options import Learn, NoBrowser, Policies, Port, Seed, Set, Threads, Trust, number
from ecs_eco.cli.terminal import exits, refuse, say
from ecs_eco.cli.trust import allow
from ecs_eco.compiled import portable
from ecs_eco.config import load
from ecs_eco.ecosystem import World
from ecs_eco.record.archipelago import is_archipelago, read
from ecs_eco.view.branch import Start
from ecs_eco.view.islands import watch_islands
from ecs_eco.view.live import Live
from ecs_eco.view.pair import Pair, Picker
from ecs_eco.view.replay import Replay
from ecs_eco.view.watch import Window
from ecs_eco.view.watch import watch as serve


@exits
def watch(
    world: Annotated[
        str,
        typer.Argument(
            metavar="WORLD|DIR",
            help="A shipped world, a TOML file, or a folder written by `run`; for an archipelago, its map "
            "is shown.",
        ),
    ],
    other: Annotated[
        str | None,
        typer.Argument(
            metavar="[WORLD|DIR]", help="Another world or folder, shown side by side on the same page."
        ),
    ] = None,
    ticks: Annotated[int | None, number("Last tick. Default: no end.")] = None,
    seed: Seed = None,
    set_: Set = None,
    threads: Threads = 1,
    learn: Learn = None,
    policies: Policies = "trained",
    port: Port = 0,
    no_browser: NoBrowser = False,
    trust: Trust = False,
) -> None:
    """Watch a living world or a recorded run in the browser, or two side by side."""
    allow(trust, world, set_)
    if other is not None:
        allow(trust, other, set_)

    changes, shown = set_ or [], [world] if other is None else [world, other]
    if other is not None and (maps := [one for one in shown if is_archipelago(one)]):
        refuse(
            "WORLD",
            "is an archipelago, whose map cannot be shown next to another world",
            maps[0],
            "worlds and folders of single runs",
        )
    islands = is_archipelago(world)
    recorded = all(os.path.isfile(Path(one) / "manifest.json") for one in shown) or islands
    if recorded and (changes or ticks or seed is not None or learn is not None):
        allowed = (
            "a world; a recording cannot be changed, but `resume --from-tick T --set … --out NEW` forks it"
        )
        refuse("WORLD", "is a recorded run, which options cannot change", world, allowed)
    if islands:
        _map(Path(world), port, not no_browser)
        return
    with _port(port):
        first, *others = [
            Replay(one)
            if os.path.isfile(Path(one) / "manifest.json")
            else _live(one, changes, ticks, seed, threads, learn, policies)
            for one in shown
        ]
        source = (
            Pair(first, others[0], _names(shown, [first, others[0]]))
            if others
            else Pair(
                first,
                start=_start(first, world, changes, ticks, learn, policies),
                picker=_picker(first, world, changes, ticks, threads, learn, policies),
            )
        )
        try:
            serve(source, _Announcer(source.hello()["title"]), port=port, browser=not no_browser)
        except KeyboardInterrupt:
            say("")


def _map(folder: Path, port: int, browser: bool) -> None:
    manifest = read(folder)
    with _port(port):
        try:
            watch_islands(
                folder, _Announcer(manifest.get("title") or manifest["world"]), port=port, browser=browser
            )
        except KeyboardInterrupt:
            say("")


@contextmanager
def window(ticks: int, title: str, port: int, browser: bool) -> Iterator[Window]:
    """Open a viewer for a world that is run and recorded; pass its `open` to the run."""
    with _port(port), Window(ticks, _Announcer(title), port=port, browser=browser) as opened:
        yield opened


def _names(shown: list[str], sources: list[Live | Replay]) -> tuple[str, str]:
    """Return names for two worlds: their titles, or if these are equal, the names on the command line."""
    titles = [str(source.hello()["title"]) for source in sources]
    names = next(
        (both for both in (titles, shown) if both[0] != both[1]),
        [f"{shown[0]}, {place}" for place in ("the first", "the second")],
    )
    return names[0], names[1]


def _start(
    source: Live | Replay,
    world: str,
    changes: list[str],
    ticks: int | None,
    learn: bool | None,
    policies: str,
) -> Start | None:
    """Return the arguments of `run` with which a living world began; None for a recorded run."""
    if not isinstance(source, Live):
        return None
    config = source.world.config
    words = [*portable.option().split(), "run", world, "--seed", str(source.world.seed)]
    words += ["--trust"] if config is not None and config.code else []
    words += [] if ticks is None else ["--ticks", str(ticks)]
    words += [] if learn is None else ["--learn" if learn else "--no-learn"]
    words += [] if policies == "trained" else ["--policies", policies]
    words += [word for change in changes for word in ("--set", change)]
    planned = [] if config is None else config.interventions
    return Start(words, [x.model_dump(mode="json", exclude_none=True) for x in planned])


def _picker(
    source: Live | Replay,
    what: str,
    changes: list[str],
    ticks: int | None,
    threads: int,
    learn: bool | None,
    policies: str,
) -> Picker | None:
    """Return the worlds that the viewer can start instead; --set and custom policies apply only to the
    named world."""
    if not isinstance(source, Live):
        return None

    def build(world: str, seed: int | None) -> Pair:
        own = world == picker.first
        set_, brains = changes if own else [], policies if own or policies in POLICIES else "trained"
        live = _live(world, set_, ticks, seed, threads, learn, brains)
        return Pair(live, start=_start(live, world, set_, ticks, learn, brains))

    picker = Picker(what, source.hello()["title"], build)
    return picker


def _live(
    world: str,
    changes: list[str],
    ticks: int | None,
    seed: int | None,
    threads: int,
    learn: bool | None,
    policies: str,
) -> Live:
    config = load(world, changes)
    known_policies(policies, config)
    return Live(World.from_config(config, seed=seed, policies=policies, threads=threads, learn=learn), ticks)


class _Announcer:
    """Prints the address of a viewer, and a new address each time one was used."""

    def __init__(self, title: str) -> None:
        self.title, self.first = title, True

    def __call__(self, address: str) -> None:
        if not self.first:
            say(f"Link for another page: {address}")
            return
        self.first = False
        say(f"{self.title}: {address}")
        say(
            "This link works once, on this machine, within ten minutes; the page can see and change the "
            "world. Then a new link is printed here."
        )
        say("Ctrl-C ends it.")


@contextmanager
def _port(port: int) -> Iterator[None]:
    """Refuse a port that is not available."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind(("127.0.0.1", port))
        except OSError as error:
            refuse(
                "--port",
                f"is not available: {error.strerror or error}",
                port,
                "a free port from 1024 to 65535, or 0 for any",
            )
    yield
