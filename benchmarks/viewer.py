"""Measure the cost of a viewer during a run, the time to encode a frame, the cost of a stalled page, and the
time and size of a recorded run saved as one file.

python benchmarks/viewer.py [--organisms 11000] [--pairs 40] [--processes 5] [--minutes 0.33]
                            [--only cost|frames|stall|rewind|export] [--ticks 10000]
"""

import argparse
import json
import os
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from ecs_eco import World
from ecs_eco.testing.browser import COMMAND
from ecs_eco.view.guard import SUBPROTOCOL
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player
from ecs_eco.view.server import Server

PLANTS = 0.8  # plants per animal: about as many as remain when plants are eaten as fast as they grow


def made(organisms: int, record: bool = True) -> World:
    """Return a world of about this many organisms; animals that die are replaced at once."""
    config = _bench.savanna(round(organisms / (1 + PLANTS)), PLANTS)
    return World.from_config(config, seed=1, policies="untrained", training=True, record=record).run(20)


def read_all(port: int, credential: str) -> None:
    """Act as a page in a separate process: read and acknowledge every frame, and report the number of frames
    at the end."""
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    frames = size = 0
    with connect(
        f"ws://127.0.0.1:{port}/ws",
        origin=f"http://127.0.0.1:{port}",
        subprotocols=[SUBPROTOCOL, credential],
        compression=None,
        max_size=None,
    ) as ws:
        try:
            while True:
                message = ws.recv()
                if isinstance(message, bytes):
                    ws.send(json.dumps({"kind": "ack", "frame": struct.unpack_from("<I", message, 4)[0]}))
                    frames, size = frames + 1, size + len(message)
        except (ConnectionClosed, KeyboardInterrupt):
            print(json.dumps({"frames": frames, "bytes": size}))


@contextmanager
def page(server: Server) -> Any:
    """Open a page that watches from another process."""
    words = [sys.executable, __file__, "--page", str(server.port), server.credentials.credential]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    while not server.clients:
        if process.poll() is not None:
            raise RuntimeError(
                f"the page process ended with status {process.returncode}: {process.stdout.read()}"
            )
        time.sleep(0.01)
    try:
        yield process
    finally:
        process.kill() if process.poll() is None else None
        process.wait()


def run(world: World, ticks: int) -> tuple[float, float]:
    """Run the world for some ticks; return the wall-clock time and the process's processor time [s]."""
    wall, work = time.perf_counter(), time.process_time()
    world.run(ticks)
    return time.perf_counter() - wall, time.process_time() - work


def cost(organisms: int, pairs: int) -> tuple[dict[str, float], dict[str, Any]]:
    """Run two copies of a world, alternating every 0.4 s: one on its own, the other with a server and a page
    that reads all frames.

    A loaded machine exaggerates the ratios, because frames arrive 20 times per second regardless of the
    world's share of the core. The viewer's share of a core does not depend on the load.
    """
    alone, seen = made(organisms), made(organisms)
    player, spent = Player(Live(seen), None), [0.0]

    def turn() -> None:
        begin = time.thread_time()
        player.turn()
        spent[0] += time.thread_time() - begin

    wall, work, watched = [], [], 0.0
    with Server(player) as server, page(server):
        seen.before_tick.append(turn)
        seconds = run(alone, 50)[0] / 50
        run(seen, 50)
        clock = time.pthread_getcpuclockid(server._thread.ident)  # type: ignore[arg-type]
        ticks, frames, spent[0], served = (
            max(10, round(0.4 / seconds)),
            player.frames,
            0.0,
            time.clock_gettime(clock),
        )
        for i in range(pairs):
            took = {world is seen: run(world, ticks) for world in ((alone, seen), (seen, alone))[i % 2]}
            wall.append(took[True][0] / took[False][0] - 1)
            work.append(took[True][1] / took[False][1] - 1)
            watched += took[True][0]
        share = (spent[0] + time.clock_gettime(clock) - served) / watched
        seen.before_tick.remove(turn)
    n = sum(t.n for t in seen.tables.values())
    shares = {
        "the run's wall time": statistics.median(wall),
        "the processor's time, all threads": statistics.median(work),
        "one core, for turns and the server's thread": share,
    }
    notes = {
        "organisms": n,
        "ticks per measurement": ticks,
        "ms per tick": 1e3 * seconds,
        "frames per second": (player.frames - frames) / watched,
        "same digest": alone.digest() == seen.digest(),
    }
    return shares, notes


def costs(organisms: int, pairs: int, processes: int) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Measure the cost in several processes one after another, because a process's memory layout can shift a
    ratio by 1%."""
    words = [sys.executable, __file__, "--cost", str(organisms), str(pairs)]
    done = [
        json.loads(subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True).stdout)
        for _ in range(processes)
    ]
    rows = []
    for what in done[0][0]:
        shares = [each[0][what] for each in done]
        rows.append(
            {
                "cost of a page, as a share of": what,
                "median": statistics.median(shares),
                "from": min(shares),
                "to": max(shares),
                "goal": 0.05,
            }
        )
    notes = {
        name: statistics.median(each[1][name] for each in done)
        for name in ("organisms", "ticks per measurement", "ms per tick", "frames per second")
    }
    same = all(each[1]["same digest"] for each in done)
    return rows, {"processes": processes, "pairs per process": pairs, **notes, "same digest": same}


def encoding(sizes: list[int]) -> list[dict[str, Any]]:
    """Measure the time to encode one frame, for each coloring."""
    rows = []
    for organisms in sizes:
        live = Live(made(organisms))
        for colour in ("species", "energy", "happiness", "age"):
            live.frame(1, colour)
            times = []
            for number in range(200):
                begin = time.perf_counter()
                frame = live.frame(number, colour)
                times.append(time.perf_counter() - begin)
            n = sum(live.counts().values())
            rows.append(
                {
                    "organisms": n,
                    "color": colour,
                    "ms per frame, median": 1e3 * statistics.median(times),
                    "best": 1e3 * min(times),
                    "bytes per organism": len(frame) / n,
                    "goal": 3.0,
                }
            )
    return rows


def resident() -> float:
    """Return this process's memory [MB]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE") / 1e6


def deaf(server: Server) -> socket.socket:
    """Open a page that reads only the reply to its connection."""
    raw = socket.socket()
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    raw.connect(("127.0.0.1", server.port))
    raw.sendall(
        (
            f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nUpgrade: websocket\r\n"
            f"Sec-WebSocket-Protocol: {SUBPROTOCOL}, {server.credentials.credential}\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            "Sec-WebSocket-Version: 13\r\n"
            f"Origin: http://127.0.0.1:{server.port}\r\n\r\n"
        ).encode()
    )
    raw.recv(12)
    return raw


def frozen(server: Server, until: threading.Event) -> None:
    """Act as a page whose browser answers pings while its script is stalled: the page reads but never
    acknowledges."""
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    with connect(
        f"ws://127.0.0.1:{server.port}/ws",
        origin=f"http://127.0.0.1:{server.port}",
        compression=None,
        max_size=None,
        subprotocols=[SUBPROTOCOL, server.credentials.credential],
    ) as ws:
        while not until.is_set():
            try:
                ws.recv(0.5)
            except TimeoutError:
                continue
            except ConnectionClosed:
                return


def stalls(organisms: int, minutes: float) -> list[dict[str, Any]]:
    """Run a world without a page, then with a page that does not read and with a page that does not
    acknowledge; measure speed and memory."""
    world, rows, end = made(organisms, record=False), [], threading.Event()
    live = Live(world)
    # the life history has a size limit, which must be reached first
    for kept in (live.journal.births, live.journal.deaths):
        kept.most = 100_000
    player = Player(live, None)
    with Server(player) as server:
        world.before_tick.append(player.turn)
        while world.next_uid < 400_000:
            world.run(50)
        rows.append(standing(world, player, server, "no page", minutes / 4, []))
        threading.Thread(target=frozen, args=(server, end), daemon=True).start()
        rows.append(
            standing(
                world,
                player,
                server,
                "one page that does not read, and one that does not acknowledge",
                minutes,
                [deaf(server)],
            )
        )
        end.set()
        world.before_tick.clear()
    return rows


def standing(
    world: World, player: Player, server: Server, what: str, minutes: float, raw: list[socket.socket]
) -> dict[str, Any]:
    """Run a world with stalled pages; a page that is disconnected because it does not answer pings
    reconnects."""
    world.run(100)
    before, frames, begin, ticks, most, again = resident(), player.frames, time.perf_counter(), 0, 0.0, 0
    while (spent := time.perf_counter() - begin) < 60 * minutes:
        world.run(20)
        ticks, most = ticks + 20, max(most, resident())
        if raw and len(server.clients) < 2:
            raw[0].close()
            raw[0], again = deaf(server), again + 1
    waiting = max((len(client._waiting) for client in server.clients), default=0)
    for page_ in raw:
        page_.close()
    return {
        "with": what,
        "minutes": spent / 60,
        "ticks/s": ticks / spent,
        "memory before [MB]": before,
        "after": resident(),
        "most": most,
        "frames made": player.frames - frames,
        "messages waiting": waiting,
        "disconnected and reconnected": again,
    }


def rewinds(times: int = 5) -> list[dict[str, Any]]:
    """Rewind a live predator-prey world by a thousand ticks, using its checkpoints."""
    live = Live(World.from_config("predator-prey", seed=1))
    took, digests = [], {}

    def until(tick: int) -> None:
        def turn() -> bool:
            live.passed()
            return live.tick < tick

        live.run(turn)

    until(1500)
    for i in range(times):
        until(1500 + 137 * i)
        digests[live.tick] = live.world.digest()
        until(2500 + 137 * i)
        begin = time.perf_counter()
        live.handle({"kind": "seek", "tick": 1500 + 137 * i})
        took.append(time.perf_counter() - begin)
        assert live.world.digest() == digests[live.tick]
    return [
        {
            "rewind by 1,000 ticks": "s",
            "median": statistics.median(took),
            "most": max(took),
            "goal": 1.0,
            "checkpoints kept": len(live.ring.points),
            "MB per checkpoint": live.ring.points[-1].size / 1e6,
        }
    ]


def exports(ticks: int) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Record predator-prey and save it as one file, each by its command in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        run, html = str(Path(folder) / "run"), Path(folder) / "run.html"
        words = ("run", "predator-prey", "--seed", "1", "--ticks", str(ticks), "--out", run)
        subprocess.run([*COMMAND, *words], check=True, stdout=subprocess.DEVNULL)
        wall, spent = time.perf_counter(), os.times()
        words = ("export", run, "--html", str(html))
        subprocess.run([*COMMAND, *words], check=True, stdout=subprocess.DEVNULL)
        wall, after, size = time.perf_counter() - wall, os.times(), html.stat().st_size
    work = sum(after[2:4]) - sum(spent[2:4])
    rows = [
        {"one file": "wall time [s]", "measured": wall, "goal": 20.0},
        {"one file": "processor time [s]", "measured": work, "goal": None},
        {"one file": "size [MB]", "measured": size / 1e6, "goal": 10.0},
    ]
    return rows, {
        "run": f"predator-prey, seed 1, {ticks:,} ticks",
        "command": "ecs-eco export RUN --html FILE",
    }


def main() -> None:
    """Measure the cases that the options select."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--organisms", type=int, default=11_000)
    parser.add_argument("--pairs", type=int, default=40)
    parser.add_argument("--processes", type=int, default=5)
    parser.add_argument("--minutes", type=float, default=1 / 3)
    parser.add_argument("--only", choices=("cost", "frames", "stall", "rewind", "export"))
    parser.add_argument("--ticks", type=int, default=10_000)
    parser.add_argument("--page", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--cost", nargs=2, type=int, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.page:
        read_all(int(asked.page[0]), asked.page[1])
        return
    if asked.cost:
        print(json.dumps(cost(*asked.cost)))
        return
    if asked.only in (None, "cost"):
        rows, notes = costs(asked.organisms, asked.pairs, asked.processes)
        _bench.save("viewer_cost", "The cost of one viewer page in a run at full speed", rows, notes)
    if asked.only in (None, "frames"):
        _bench.save("viewer_frames", "Encoding one frame, on one core", encoding([asked.organisms, 55_000]))
    if asked.only in (None, "rewind"):
        _bench.save("viewer_rewind", "Rewinding a live predator-prey to its earlier digest", rewinds())
    if asked.only in (None, "export"):
        question = "A recorded run saved as one file"
        _bench.save("viewer_export", question, *exports(asked.ticks))
    if asked.only in (None, "stall"):
        _bench.save(
            "viewer_stall",
            "A stalled page: the run's speed and the server's memory",
            stalls(asked.organisms, asked.minutes),
        )


if __name__ == "__main__":
    main()
