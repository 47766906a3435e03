"""The command watch, and run's option --watch."""

import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.options import Learn, NoBrowser, Policies, Port, Seed, Set, Threads, Trust, number, words
from ecs_eco.cli.terminal import exits, refuse, say
from ecs_eco.cli.trust import allow
from ecs_eco.compiled import portable
from ecs_eco.config import load
from ecs_eco.ecosystem import World
from ecs_eco.explain.viewed import sweeps_in
from ecs_eco.lab.treatments import check_policies
from ecs_eco.record.archipelago import is_archipelago, read
from ecs_eco.view.branch import Start
from ecs_eco.view.islands import watch_islands
from ecs_eco.view.live import Live
from ecs_eco.view.pair import Pair, Picker
from ecs_eco.view.replay import Replay
from ecs_eco.view.watch import Window, watch as serve
from ecs_eco.worlds.policies import POLICIES


@exits
def watch(
    world: Annotated[
        str,
        typer.Argument(
            metavar="WORLD|DIR",
            help="A shipped world, a TOML file, or a folder written by `run`; an archipelago is shown as a "
            "map.",
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
    """Watch a live world or a recorded run in the browser, or two of them side by side."""
    allow(trust, world, set_)
    if other is not None:
        allow(trust, other, set_)

    changes, shown = set_ or [], [world] if other is None else [world, other]
    if other is not None and (maps := [one for one in shown if is_archipelago(one)]):
        refuse(
            "WORLD",
            "is an archipelago, which cannot be shown next to another world",
            maps[0],
            "worlds, or folders of single runs",
        )
    islands = is_archipelago(world)
    recorded = all(os.path.isfile(Path(one) / "manifest.json") for one in shown) or islands
    if recorded and (changes or ticks or seed is not None or learn is not None):
        allowed = "a world; to fork a recorded run with changes: `resume --from-tick T --set … --out NEW`"
        refuse("WORLD", "is a recorded run, which these options cannot change", world, allowed)
    browser = not no_browser
    if islands:
        manifest = read(Path(world))
        with _port(port):
            _show(watch_islands, Path(world), manifest.get("title") or manifest["world"], port, browser)
        return
    options = Options(changes, ticks, threads, learn, policies)
    with _port(port):
        first, *others = [
            Replay(one) if os.path.isfile(Path(one) / "manifest.json") else options.live(one, seed)
            for one in shown
        ]
        if others:
            source = Pair(first, others[0], _names(shown, [first, others[0]]))
        elif isinstance(first, Live):
            source = options.pair(first, world, options.picker(first, world))
        else:
            source = Pair(first, sweeps=sweeps_in(world))
        _show(serve, source, source.hello()["title"], port, browser)


def _show(serve: Callable[..., None], what: Pair | Path, title: str, port: int, browser: bool) -> None:
    try:
        serve(what, _Announcer(title), port=port, browser=browser)
    except KeyboardInterrupt:
        say("")


@contextmanager
def window(ticks: int, title: str, port: int, browser: bool) -> Iterator[Window]:
    """Open a viewer for a world that is being run and recorded; pass the viewer's `open` to the run."""
    with _port(port), Window(ticks, _Announcer(title), port=port, browser=browser) as opened:
        yield opened


def _names(shown: list[str], sources: list[Live | Replay]) -> tuple[str, str]:
    """Return names for two worlds: their titles or, if these are equal, their names on the command line."""
    titles = [str(source.hello()["title"]) for source in sources]
    names = next(
        (both for both in (titles, shown) if both[0] != both[1]),
        [f"{shown[0]}, {place}" for place in ("the first", "the second")],
    )
    return names[0], names[1]


@dataclass(frozen=True)
class Options:
    """The options used to build live worlds."""

    changes: list[str]
    ticks: int | None
    threads: int
    learn: bool | None
    policies: str

    def live(self, world: str, seed: int | None) -> Live:
        """Return a live world at tick 0."""
        config = load(world, self.changes)
        check_policies(self.policies, config)
        built = World.from_config(
            config, seed=seed, policies=self.policies, threads=self.threads, learn=self.learn
        )
        return Live(built, self.ticks)

    def pair(self, live: Live, world: str, picker: Picker | None = None) -> Pair:
        """Return a live world for the viewer, with the arguments of the equivalent `run` command."""
        config = live.world.config
        options = words(
            seed=live.world.seed,
            trust=config is not None and bool(config.code),
            ticks=self.ticks,
            learn=self.learn,
            no_learn=self.learn is False,
            policies=None if self.policies == "trained" else self.policies,
            set=self.changes,
        )
        planned = [] if config is None else config.interventions
        command = [*portable.option().split(), "run", world, *options]
        start = Start(command, [x.model_dump(mode="json", exclude_none=True) for x in planned])
        return Pair(live, start=start, picker=picker)

    def picker(self, live: Live, what: str) -> Picker:
        """Return the worlds that the viewer can start; --set and custom policies apply only to the world `what`."""

        def build(world: str, seed: int | None) -> Pair:
            policies = self.policies if self.policies in POLICIES else "trained"
            own = self if world == picker.first else replace(self, changes=[], policies=policies)
            return own.pair(own.live(world, seed), world)

        picker = Picker(what, live.hello()["title"], build)
        return picker


class _Announcer:
    """Prints the viewer's address, and a new one each time an address has been used."""

    def __init__(self, title: str) -> None:
        self.title, self.first = title, True

    def __call__(self, address: str) -> None:
        if not self.first:
            say(f"Link for another page: {address}")
            return
        self.first = False
        say(f"{self.title}: {address}")
        say(
            "This link works once, on this machine, within ten minutes; the page can show and change the "
            "world. A new link is then printed here."
        )
        say("Press Ctrl-C to stop.")


@contextmanager
def _port(port: int) -> Iterator[None]:
    """Reject a port that is not available."""
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
