"""The built site in a browser: header, search, code, contrast, height of pages, recorded runs.

`python tools/build_site.py` builds the site; without it, these tests are skipped.
"""

import re
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from ecs_eco.testing.browser import chromium, launched
from tests.view.pages import violations

SITE = Path(__file__).parents[2] / "ecs_eco" / "_site"
PAGES = [path for path in SITE.rglob("*.html") if not {"source", "_static"} & {*path.relative_to(SITE).parts}]
TALLEST = 80_000  # [px]
WIDTHS = (390, 800, 960, 1024, 1100, 1280, 1440)
HEADER = """() => {
  const boxes = (selector) => [...document.querySelectorAll(`.bd-header ${selector}`)]
    .map((e) => e.getBoundingClientRect()).filter((box) => box.width > 0 && box.height > 0);
  const middles = [...boxes(".nav-link"), ...boxes(".navbar-brand"), ...boxes("button")]
    .map((box) => (box.top + box.bottom) / 2);
  const row = Math.max(...middles) - Math.min(...middles) < 8;
  return {row, logos: boxes("img").length, search: boxes("button[class*=search-button]").length};
}"""
CUT = """() => [...document.querySelectorAll("pre")]
  .filter((pre) => pre.scrollWidth > pre.clientWidth + 1).length"""
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(chromium() is None, reason="needs Chromium"),
    pytest.mark.skipif(
        not (SITE / "_static" / "replays").is_dir(), reason="needs the site: python tools/build_site.py"
    ),
]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    pytest.importorskip("playwright")
    with launched() as one:
        yield one


@pytest.fixture
def page(browser: Any) -> Iterator[Any]:
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    context.set_default_timeout(120_000)
    yield context.new_page()
    context.close()


def longest_line(path: Path) -> int:
    """Return the number of columns of the longest line of code on a page."""
    blocks = re.findall(r"<pre[^>]*>(.*?)</pre>", path.read_text(encoding="utf-8"), re.DOTALL)
    lines = (line for block in blocks for line in unescape(re.sub("<[^>]+>", "", block)).split("\n"))
    return max(map(len, lines), default=0)


def test_every_page_has_one_header_row_with_one_logo_and_the_search(page: Any) -> None:
    wanted = {"row": True, "logos": 1, "search": 1}
    for name in ("index.html", "how-to/watching.html"):
        page.goto((SITE / name).as_uri())
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 900})
            assert (width, page.evaluate(HEADER)) == (width, wanted), name


def test_search_opens_on_a_phone(page: Any) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto((SITE / "how-to" / "watching.html").as_uri())
    page.locator(".bd-header [class*=search-button]:visible").first.click()
    page.get_by_role("searchbox").first.fill("rewind")
    assert page.get_by_role("searchbox").first.is_visible()


def test_no_page_is_too_tall(page: Any) -> None:
    largest = sorted(PAGES, key=lambda path: path.stat().st_size)[-6:]
    tall = {}
    for path in largest:
        page.goto(path.as_uri())
        tall[path.name] = page.evaluate("document.documentElement.scrollHeight")
    assert {name: height for name, height in tall.items() if height > TALLEST} == {}


def test_code_is_not_cut_at_1440_pixels(page: Any) -> None:
    longest = sorted(PAGES, key=longest_line)[-8:]
    assert longest_line(longest[0]) > 110
    cut = {}
    for path in longest:
        page.goto(path.as_uri())
        cut[path.name] = page.evaluate(CUT)
    assert {name: n for name, n in cut.items() if n} == {}


@pytest.mark.parametrize("shade", ["light", "dark"])
def test_axe_finds_nothing(browser: Any, shade: str) -> None:
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme=shade)
    for name in ("index", "gallery", "tutorials/meadow", "reference/world/index", "reference/api/rl"):
        page.goto((SITE / f"{name}.html").as_uri())
        assert violations(page) == [], name
    page.close()


def test_a_recorded_run_starts_in_the_place_of_its_picture_and_not_before(page: Any) -> None:
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto((SITE / "index.html").as_uri())
    assert [url for url in asked if "replays" in url] == []
    page.goto((SITE / "gallery.html").as_uri())
    page.locator("a.living[href*=lamb]").click()
    frame = page.frame_locator(".replay iframe")
    frame.locator("#play").wait_for()
    frame.locator("#legend", has_text="ewe").wait_for()
    assert page.locator("a.living").count() == 7
    assert page.locator(".replay iframe").bounding_box()["width"] > 600
