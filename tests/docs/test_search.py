"""What readers type into the search of the site leads to the page that answers it."""

import json
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import quote_plus

import pytest

from ecs_eco.testing.browser import chromium, launched

ROOT = Path(__file__).parents[2]
FOUND = Path(__file__).with_name("searches.json")
"""Words → the page that the search must list first."""


class Quiet(SimpleHTTPRequestHandler):
    """A server of files that prints nothing."""

    def log_message(self, *_: object) -> None:
        """Print nothing."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Build the site, serve it, and return its address."""
    out = tmp_path_factory.mktemp("site")
    command = [sys.executable, "tools/build_site.py", "--no-notebooks", "--out", str(out)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(out)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


def first_hit(page, site: str, words: str) -> str:
    """Return the page that the search lists first."""
    page.goto(f"{site}/search.html?q={quote_plus(words)}")
    link = page.wait_for_selector("#search-results li a", timeout=120_000)
    return link.get_attribute("href").partition("#")[0].partition("?")[0]


@pytest.mark.slow
@pytest.mark.skipif(chromium() is None, reason="needs Chromium")
def test_each_search_finds_first_the_page_that_answers_it(site: str) -> None:
    pytest.importorskip("playwright")
    wanted = json.loads(FOUND.read_text(encoding="utf-8"))
    with launched() as browser:
        page = browser.new_page()
        assert {words: first_hit(page, site, words) for words in wanted} == wanted
