"""Pages of single islands for the map of an archipelago: each island is replayed in a process of its own."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path

from ecs_eco.engine.processes import python

MOST = 6  # islands that are open at a time; the one that was asked for longest ago is closed
SERVE = "from ecs_eco.view.island_server import serve; serve(sys.argv[1])"

Tell = Callable[[str | None, str], None]


class Opened:
    """The islands that are open; `ask` answers from a thread of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._lock = threading.Lock()
        self._open: OrderedDict[tuple[str, int], subprocess.Popen[str]] = OrderedDict()

    def ask(self, name: str, tick: int, tell: Tell) -> None:
        """Open an island as it was recorded up to a tick, or find it open; call `tell(address, "")` with an
        address that admits one page, or `tell(None, why)`."""
        threading.Thread(target=self._ask, args=(name, tick, tell), daemon=True).start()

    def close(self) -> None:
        """Close all."""
        with self._lock:
            for process in self._open.values():
                _end(process)
            self._open.clear()

    def _ask(self, name: str, tick: int, tell: Tell) -> None:
        with self._lock:  # one starts at a time
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
    """Ask a process for another address; None where it has ended."""
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
    """Replay a recorded run; print an address for each line of standard input, and end when that ends."""
    from ecs_eco.view.player import Player
    from ecs_eco.view.replay import Replay
    from ecs_eco.view.server import Server

    source = Replay(folder)
    player = Player(source)
    with Server(player) as server:

        def answer() -> None:
            for _ in sys.stdin:
                print(server.address(), flush=True)
            player.close()

        threading.Thread(target=answer, daemon=True).start()
        source.run(player.turn)
