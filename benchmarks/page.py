"""Measure the cost of a frame in the viewer's page (50,000 organisms, the real server, Chromium with software
rendering), the time from opening the page to its first frame, and the memory use of the page and the server.

    python benchmarks/page.py [--organisms 50000] [--frames 150] [--only frames|first|memory] [--minutes 30]

Needs playwright and Chromium (Debian: apt-get install chromium).
"""

import argparse
import os
import statistics
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numpy as np

from ecs_eco import World
from ecs_eco.components import Biology, Position, Velocity
from ecs_eco.engine.system import System
from ecs_eco.testing.browser import launched, served, until
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player
from ecs_eco.view.server import Server

ANIMALS = 0.2  # share of organisms that move between frames; plants do not move
GOAL = 1.5  # [ms] for decoding and rendering together
SOON = 2.0  # [s] for the first frame
# The page keeps running means with a weight of 1/10 for the latest frame, so two consecutive means give the
# duration of one frame.
LISTEN = """() => {
  window.times = {decode: [], render: []};
  let [frames, renders, decode, render] = [ecs.frames, ecs.renders, ecs.decodeMs, ecs.renderMs];
  const look = () => {
    if (ecs.frames === frames + 1) times.decode.push(Math.max(0, decode + (ecs.decodeMs - decode) * 10));
    if (ecs.renders === renders + 1) times.render.push(Math.max(0, render + (ecs.renderMs - render) * 10));
    [frames, renders, decode, render] = [ecs.frames, ecs.renders, ecs.decodeMs, ecs.renderMs];
    requestAnimationFrame(look);
  };
  look();
}"""


class Wander(System):
    """Makes animals walk straight ahead on a torus, so that a tick costs almost nothing."""

    needs = Position, Velocity
    phase = "move"

    def update(self, table: Any, world: Any) -> None:
        x, high = table[Position].x, table.high
        x[:high] = (x[:high] + np.float32(0.3)) % np.float32(world.space.size[0])


def made(organisms: int) -> World:
    """Return a world of stationary plants and moving animals."""
    side, rng = float(np.sqrt(organisms)), np.random.default_rng(1)
    world = World([side, side], seed=1)
    animals = round(organisms * ANIMALS)
    for name, n, parts in (
        ("plant", organisms - animals, (Position, Biology)),
        ("animal", animals, (Position, Velocity, Biology)),
    ):
        table = world.add_table(name, *parts)
        table.species.color, table.species.radius = "#1a9641" if name == "plant" else "#d95f02", 0.3
        table.request(
            np.zeros(n, np.uint64),
            {(Position, axis): (rng.random(n) * side).astype(np.float32) for axis in "xy"},
        )
    world.flush()
    world.add_system(Wander())
    return world


@contextmanager
def watched(organisms: int) -> Iterator[Server]:
    """Yield the page's server and its world; the world runs in a separate thread at 20 ticks per second."""
    ready, started = threading.Event(), []

    def live() -> None:
        source = Live(made(organisms))
        started.append(Player(source, 20.0))
        with Server(started[0]) as server:
            started.append(server)
            ready.set()
            source.run(started[0].turn)

    thread = threading.Thread(target=live)
    thread.start()
    try:
        while not ready.wait(0.1):
            if not thread.is_alive():
                raise RuntimeError("the world did not start")
        yield started[1]
    finally:
        started[0].close()
        thread.join()


def measure(page: Any, colour: str, frames: int) -> dict[str, list[float]]:
    """Return the durations [ms] of decoding and drawing some frames, colored by a variable."""
    page.locator("#colour").select_option(colour)
    page.evaluate(LISTEN)
    until(page, f"Math.min(times.decode.length, times.render.length) >= {frames}", 1800)
    return page.evaluate("times")


def frames(organisms: int, n: int) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Measure the cost of a frame."""
    rows: list[dict[str, Any]] = []
    with watched(organisms) as server, launched() as browser:
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(server.address())
        until(page, "ecs.frames > 20 && ecs.renders > 20", 600)
        for colour in ("species", "age"):
            measured = measure(page, colour, n)
            middle, best = (
                {what: of(times) for what, times in measured.items()} for of in (statistics.median, min)
            )
            rows += [
                {
                    "organisms": organisms,
                    "color": colour,
                    "what": words,
                    "ms per frame, median": middle.get(what, sum(middle.values())),
                    "best": best.get(what, sum(best.values())),
                    "goal": GOAL,
                }
                for what, words in (("decode", "decoding"), ("render", "render call"), ("both", "both"))
            ]
        return rows, {
            "browser": f"Chromium {browser.version}",
            "frames of each color, at least": n,
            "drawn by": "software (SwiftShader), in a separate process",
        }


def first(browsers: int = 7, pages: int = 3) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Measure the time from opening the page to its first drawn frame, in new browsers and on their later
    pages, each in a new context."""
    rows: list[dict[str, Any]] = []
    for world in ("predator-prey", "diel-migration"):
        seconds: list[list[float]] = [[] for _ in range(pages)]
        with served("watch", world, "--seed", "1") as run:
            for _ in range(browsers):
                with launched() as browser:
                    for took in seconds:
                        with browser.new_context(viewport={"width": 1440, "height": 900}) as context:
                            page = context.new_page()
                            page.wait_for_timeout(1000)  # the browser has started, and closed earlier pages
                            page.goto(run.address(), wait_until="commit")
                            until(page, "window.ecs && ecs.frames > 0 && ecs.renders > 0")
                            took.append(page.evaluate("performance.now()") / 1e3)
        later = [took for some in seconds[1:] for took in some]
        rows.append(
            {
                "world": world,
                "first page of a browser, median [s]": statistics.median(seconds[0]),
                "best": min(seconds[0]),
                "later pages, median [s]": statistics.median(later),
                "slowest": max(later),
                "goal": SOON,
            }
        )
    drawn = (
        "software (SwiftShader), in a separate process; text and charts on the processor, as without a GPU"
    )
    return rows, {"browsers": browsers, "pages of each": pages, "drawn by": drawn}


def memory(minutes: float, looks: int = 10) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Watch predator-prey at 20 ticks per second with an animal selected; return page and server memory [MB]
    at regular intervals."""
    rows: list[dict[str, Any]] = []
    with served("watch", "predator-prey", "--seed", "1") as run, launched() as browser:
        page = browser.new_page(viewport={"width": 1000, "height": 640})
        page.goto(run.address())
        until(page, "ecs.frames > 0")
        page.locator("#play").click()
        page.keyboard.press("n")
        page.keyboard.press("+")
        cdp = page.context.new_cdp_session(page)
        begin = time.monotonic()
        for k in range(looks + 1):
            while time.monotonic() - begin < 60 * minutes * k / looks:
                page.wait_for_timeout(500)
            cdp.send("HeapProfiler.collectGarbage")
            heap = page.evaluate("performance.memory.usedJSHeapSize") / 1e6
            words = Path(f"/proc/{run.process.pid}/statm").read_text().split()
            rows.append(
                {
                    "minutes": (time.monotonic() - begin) / 60,
                    "tick": page.evaluate("ecs.tick"),
                    "frames": page.evaluate("ecs.frames"),
                    "page [MB]": heap,
                    "server [MB]": int(words[1]) * os.sysconf("SC_PAGESIZE") / 1e6,
                }
            )
    return rows, {
        "world": "predator-prey, seed 1, at 20 ticks per second",
        "page": "after garbage collection",
    }


def main() -> None:
    """Measure and store the results."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--organisms", type=int, default=50_000)
    parser.add_argument("--frames", type=int, default=150)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--only", choices=("frames", "first", "memory"))
    asked = parser.parse_args()
    if asked.only in (None, "frames"):
        _bench.save(
            "page",
            "The cost of a frame in the page: decoding and drawing",
            *frames(asked.organisms, asked.frames),
        )
    if asked.only in (None, "first"):
        _bench.save("page_first", "The time from opening the page to its first frame", *first())
    if asked.only in (None, "memory"):
        _bench.save("page_memory", "Page and server memory over time", *memory(asked.minutes))


if __name__ == "__main__":
    main()
