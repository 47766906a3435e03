"""The viewer's page in a browser without windows: for tests, screenshots and benchmarks. Wants playwright, and Chromium on the path."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

COMMAND = [sys.executable, "-c", "from ecs_eco.cli import main; main()"]
FLAGS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
         "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"]  # fmt: skip


def chromium() -> str | None:
    """Return where Chromium is; None where there is none (Debian: apt-get install chromium)."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


@contextmanager
def launched() -> Iterator[Any]:
    """A Chromium that draws in software, so that pictures are the same everywhere: a Browser of playwright."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=chromium(), args=FLAGS, timeout=180_000)
        try:
            yield found
        finally:
            found.close()


@contextmanager
def served(*words: str) -> Iterator[SimpleNamespace]:
    """`ecs-eco WORDS --no-browser`, killed at the end: its `process`, and the `address` that it said."""
    command, environment = [*COMMAND, *words, "--no-browser"], os.environ | {"OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", line)
        if found is None:
            raise RuntimeError(f"{' '.join(words)}: no address, but {line!r}{process.communicate()[1]}")
        yield SimpleNamespace(process=process, address=found[0])
    finally:
        process.kill()
        process.communicate()


def until(page: Any, condition: str, seconds: float = 180.0) -> None:
    """Wait until something is true on the page, an expression of `ecs` (docs/watching_page.md); TimeoutError after so long.

    (`wait_for_function` of playwright would want eval, which the page forbids.)
    """
    end = time.monotonic() + seconds
    while not page.evaluate(f"() => Boolean(window.ecs && ({condition}))"):
        if time.monotonic() > end:
            raise TimeoutError(f"{condition}: not so after {seconds:g} s")
        time.sleep(0.03)
