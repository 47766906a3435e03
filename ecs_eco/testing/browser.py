"""The viewer's page in a headless browser, for tests, screenshots and benchmarks.

Requires playwright, and Chromium on the path.
"""

from __future__ import annotations

import http.client
import json
import os
import re
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

from ecs_eco.engine.processes import python

COMMAND = python("from ecs_eco.cli import main; main()")
FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-gpu-rasterization",  # without a GPU, Chromium draws text, icons and charts on the processor;
    "--disable-accelerated-2d-canvas",  # as software WebGL, their shaders take seconds to compile
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def chromium() -> str | None:
    """Return the path of Chromium; None if it is not installed (Debian: apt-get install chromium)."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


@contextmanager
def launched() -> Iterator[Any]:
    """Yield playwright's Chromium with software rendering, so that pictures are the same on every machine."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=FLAGS, timeout=180_000)
        try:
            yield browser
        finally:
            browser.close()


class Served:
    """A running command that shows a world; each address that it prints admits one page."""

    def __init__(self, words: tuple[str, ...]) -> None:
        command, environment = [*COMMAND, *words, "--no-browser"], os.environ | {"OMP_NUM_THREADS": "1"}
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
        )

    def address(self) -> str:
        """Return the next printed address; a new one is printed when the last has been used."""
        assert self.process.stdout is not None
        lines = []
        for line in self.process.stdout:
            if match := re.search(r"http://127\.0\.0\.1:\d+/#code=\S+", line):
                return match[0]
            lines.append(line)
        raise RuntimeError(f"expected an address, got {''.join(lines)!r}{self.process.communicate()[1]}")


@contextmanager
def served(*words: str) -> Iterator[Served]:
    """Run `ecs-eco WORDS --no-browser`, and kill it at the end."""
    server = Served(words)
    try:
        yield server
    finally:
        server.process.kill()
        server.process.communicate()


def entered(address: str) -> tuple[str, str]:
    """Redeem a one-time address, as a page does; return the host with its port, and the credential."""
    place = urlsplit(address)
    connection = http.client.HTTPConnection(place.netloc, timeout=180)
    try:
        connection.request(
            "POST", "/enter", headers={"authorization": f"Code {place.fragment.removeprefix('code=')}"}
        )
        answer = connection.getresponse()
        body = answer.read().decode()
    finally:
        connection.close()
    if answer.status != 200:
        raise RuntimeError(f"{address}: {body}")
    return place.netloc, json.loads(body)["credential"]


def until(page: Any, condition: str, seconds: float = 180.0) -> None:
    """Wait until an expression of `ecs` (docs/reference/watching_page.md) is true on the page; raise
    TimeoutError after `seconds`.

    (playwright's `wait_for_function` needs eval, which the page forbids.)
    """
    end = time.monotonic() + seconds
    while not page.evaluate(f"() => Boolean(window.ecs && ({condition}))"):
        if time.monotonic() > end:
            raise TimeoutError(f"{condition}: still false after {seconds:g} s")
        time.sleep(0.03)
