"""A page with the map of an archipelago. It shows population sizes and migrants; a click opens an island.

The map of a run in progress is updated at each barrier. Each opened island is replayed in its own process.
"""

import subprocess
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np

from ecs_eco.analysis.archipelago import Islands, load_islands, places
from ecs_eco.analysis.palette import SAFE
from ecs_eco.analysis.style import own_colors
from ecs_eco.config.models.archipelago import Archipelago
from ecs_eco.engine.errors import ConfigError, RecordingError, nearest
from ecs_eco.engine.processes import python
from ecs_eco.record.archipelago import FILE, ISLANDS, read
from ecs_eco.runs.run import read_manifest
from ecs_eco.view.entrance import Entrance
from ecs_eco.view.player import Player
from ecs_eco.view.replay import Replay
from ecs_eco.view.server import Server
from ecs_eco.view.shown import Inbox, Page
from ecs_eco.view.source import Message, said, text

PAGE = "islands.html"
POINTS = 400  # maximum number of points in population curves
LOOK = 0.5  # [s] between checks of the manifest


def describe(folder: Path) -> Message:
    """Return the contents of the map. `n` is indexed as [island][species][point]; each item of `moves` is
    [point, species, from, to, number]. Before the first barrier, there are no points. Raises RecordingError
    if there is no intact archipelago."""
    manifest = read(folder)
    config = manifest["config"]
    plan = Archipelago.model_validate(config["archipelago"])
    at = places(plan)
    island = folder / ISLANDS / plan.names[0]
    colours = own_colors(
        read_manifest(island).get("colors") if (island / "manifest.json").is_file() else None
    )
    message: Message = {
        "kind": "islands",
        "title": manifest.get("title") or manifest["world"],
        "seed": manifest["seed"],
        "tick": manifest["tick"],
        "ticks": manifest["ticks"],
        "finished": manifest["finished"],
        "every": plan.migration_interval,
        "graph": plan.graph,
        "palette": SAFE,
        "species": [
            {
                "name": name,
                "color": colours.get(name, values.get("color") or "#888888"),
                "wanders": name in plan.migration_probability,
                "moves": bool(values.get("locomotion")),
            }
            for name, values in config["species"].items()
        ],
        "islands": [
            {
                "name": name,
                "at": at[i].round(4).tolist(),
                "own": ", ".join(f"{key} = {value}" for key, value in plan.islands[name].items()),
            }
            for i, name in enumerate(plan.names)
        ],
        "ways": [[i, j] for i, targets in enumerate(plan.neighbours()) for j in targets],
        "points": [],
        "n": [],
        "moves": [],
    }
    if manifest["tick"]:
        message |= _record(load_islands(folder), int(manifest["tick"]), [*config["species"]])
    return message


def _record(islands: Islands, end: int, names: list[str]) -> Message:
    """Return population sizes and migrants before tick `end`, with species numbered as in `names`."""
    ticks = next(iter(islands.series.values())).ticks
    rows = np.unique(np.linspace(0, np.searchsorted(ticks, end) - 1, POINTS).astype(np.int64))
    n = [
        [np.asarray(series.of(name))[rows].astype(int).tolist() for name in names]
        for series in islands.series.values()
    ]
    moves = islands.moves[islands.moves[:, 0] < end].copy()
    moves[:, 0] = np.searchsorted(ticks[rows], moves[:, 0])
    moves[:, 1] = np.array([names.index(name) for name in islands.species])[moves[:, 1]]
    found, where = np.unique(moves[:, :4], axis=0, return_inverse=True)
    number = np.bincount(where.ravel(), moves[:, 4], len(found)).astype(np.int64)
    return {
        "points": ticks[rows].tolist(),
        "n": n,
        "moves": np.column_stack([found, number]).tolist() if len(found) else [],
    }


class Map(Inbox):
    """The map of one folder, served to any number of pages; raises RecordingError without an archipelago."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.folder = Path(folder)
        self.islands = Opened(self.folder / ISLANDS)
        self._pages = list[Page]()
        self._seen = self._stamp()
        self.message = describe(self.folder)

    def run(self) -> None:
        """Serve pages until `close`."""
        with closing(self.islands):
            while not self.closing:
                for _ in range(len(self.inbox)):
                    self._answer(*self.inbox.popleft())
                self._look()
                self._wake.wait(LOOK)
                self._wake.clear()

    def _stamp(self) -> tuple[int, int]:
        try:
            status = (self.folder / FILE).stat()
        except OSError:  # the file is being replaced or has been removed
            return 0, 0
        return status.st_mtime_ns, status.st_ino

    def _look(self) -> None:
        """Send the map again if the run has reached another barrier."""
        stamp = self._stamp()
        if stamp in (self._seen, (0, 0)):
            return
        try:
            message = describe(self.folder)
        except (RecordingError, ConfigError, FileNotFoundError):  # the files are being written
            return
        self._seen = stamp
        if message != self.message:
            self.message = message
            for page in self._pages:
                _send(page, message)

    def _answer(self, page: Page, request: Message) -> None:
        kind = request.get("kind")
        if kind == "join":
            self._pages.append(page)
            _send(page, self.message)
        elif page in self._pages and kind == "leave":
            self._pages.remove(page)
        elif page in self._pages and kind == "open":
            self._open(page, request.get("island"))
        elif page in self._pages:
            _send(page, said("error", f"unknown request {str(kind)[:40]!r}; expected 'open'", "kind"))

    def _open(self, page: Page, name: object) -> None:
        known = [island["name"] for island in self.message["islands"]]

        def tell(address: str | None, why: str) -> None:
            opened = {"kind": "opened", "island": name, "address": address}
            _send(page, said("error", why, "open") if address is None else opened)

        if name not in known:
            expected = f"expected {', '.join(known)}; did you mean {nearest(str(name), known)!r}?"
            tell(None, f"open: island = {str(name)[:60]!r}; {expected}")
        elif not self.message["tick"]:
            tell(None, f"{name} has not reached its first barrier yet")
        else:
            self.islands.ask(str(name), int(self.message["tick"]), tell)


def watch_islands(
    folder: Path, announce: Callable[[str], None] = print, *, port: int = 0, browser: bool = False
) -> None:
    """Serve the map of an archipelago until Ctrl-C. `announce` receives an address, and a new one after each
    use. Raises RecordingError for a folder without an archipelago, and OSError if the port is taken."""
    shown = Map(folder)
    with Server(shown, port, page=PAGE) as server, closing(Entrance(server, announce, browser)):
        shown.run()


def _send(page: Page, message: Message) -> None:
    page.send([text(message)])


MOST = 6  # open islands; beyond that, the least recently requested island is closed
SERVE = "from ecs_eco.view.islands import serve; serve(sys.argv[1])"

Tell = Callable[[str | None, str], None]


class Opened:
    """The open islands; `ask` responds from a separate thread."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._lock = threading.Lock()
        self._open: OrderedDict[tuple[str, int], subprocess.Popen[str]] = OrderedDict()

    def ask(self, name: str, tick: int, tell: Tell) -> None:
        """Open an island as recorded up to a tick; call `tell(address for one page, "")` or `tell(None, why)`."""
        threading.Thread(target=self._ask, args=(name, tick, tell), daemon=True).start()

    def close(self) -> None:
        """Close all islands."""
        with self._lock:
            for process in self._open.values():
                _end(process)
            self._open.clear()

    def _ask(self, name: str, tick: int, tell: Tell) -> None:
        with self._lock:  # islands start one at a time
            process = self._open.pop((name, tick), None)
            if process is None or process.poll() is not None:
                process = subprocess.Popen(
                    python(SERVE, str(self.folder / name)),
                    text=True,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE,
                )
            address = _address(process)
            if address is None:
                lines = process.communicate()[1].strip().splitlines()
                tell(None, f"{name} cannot be opened: {lines[-1] if lines else 'its process ended'}")
                return
            self._open[name, tick] = process
            while len(self._open) > MOST:
                _end(self._open.popitem(last=False)[1])
        tell(address, "")


def _address(process: subprocess.Popen[str]) -> str | None:
    """Request another address from a process; return None if the process has ended."""
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        process.stdin.write("\n")
        process.stdin.flush()
    except OSError:
        return None
    return process.stdout.readline().strip() or None


def _end(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.communicate()


def serve(folder: str) -> None:
    """Replay a recorded run; print an address for each line of standard input until it ends."""
    source = Replay(folder)
    player = Player(source, playing=False)
    with Server(player) as server:

        def answer() -> None:
            for _ in sys.stdin:
                print(server.address(), flush=True)
            player.close()

        threading.Thread(target=answer, daemon=True).start()
        source.run(player.turn)
