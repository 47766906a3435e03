"""The site: links that leave docs/ lead to pages of their own, no page asks anything of the network, and a
search leads to the page that answers it."""

import importlib.util
import json
import re
import subprocess
import sys
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import quote_plus

import pytest

from ecs_eco.testing.browser import chromium, launched

ROOT = Path(__file__).parents[2]
SEARCHES = ROOT / "tests" / "docs" / "searches.json"
"""Words → the page that the search must list first."""
ASSET = re.compile(r"<(?:script|img|iframe|source|video|audio|embed)\b[^>]*\ssrc=\"([^\"]*)\"|<link\b[^>]*>")
FROM_CSS = re.compile(r"url\(\s*['\"]?(?!data:)([^)'\"]+)")
ASKS = {"preload", "stylesheet", "icon", "preconnect", "dns-prefetch", "prefetch", "modulepreload"}


@pytest.fixture
def tool(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    spec = importlib.util.spec_from_file_location("build_site", ROOT / "tools" / "build_site.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def asked_of_the_network(page: Path) -> list[str]:
    """Addresses beyond the site that a browser asks for when it opens a page."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".css":
        return [target for target in FROM_CSS.findall(text) if "//" in target]
    found = [match[1] for match in ASSET.finditer(text) if match[1]]
    for link in re.findall(r"<link\b[^>]*>", text):
        if ASKS.intersection(re.findall(r'rel="([^"]*)"', link)[0].split()):
            found += re.findall(r'href="([^"]*)"', link)
    return [target for target in found if "//" in target and not target.startswith("data:")]


@pytest.mark.parametrize(
    ("target", "becomes"),
    [
        ("[a kernel](../../ecs_eco/systems/feed.py)", "[a kernel](../source/ecs_eco/systems/feed.py.md)"),
        ("[a room](../../ecs_eco/systems)", "[a room](../source/ecs_eco/systems.md)"),
        ("[goats](../../ecs_eco/worlds/reflexes/README.md#x)", "[goats](../reference/shipped/reflexes.md#x)"),
        ("[results.md](../results.md#why)", "[](../results.md#why)"),
        ("[how](running.md)", "[how](running.md)"),
        ("[out](https://example.org/a.md)", "[out](https://example.org/a.md)"),
        ("```\n[in a block](../../ecs_eco)\n```", "```\n[in a block](../../ecs_eco)\n```"),
    ],
)
def test_links_that_leave_the_docs_lead_to_pages_of_the_site(target, becomes, tool, tmp_path):
    stage = tool.Stage(tmp_path)
    stage.add("how-to/page.md", target, ROOT / "docs" / "how-to")
    assert (tmp_path / "how-to" / "page.md").read_text(encoding="utf-8") == becomes


def test_every_shipped_world_has_a_recorded_run_and_a_picture_that_starts_it(tool):
    from gallery import TICKS

    names = {world.replace("-", "_") for world in TICKS}
    assert {path.parent.name for path in tool.shipped_worlds()} == names
    home, gallery = (
        (ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("index.md", "gallery.md")
    )
    assert tool.PICTURE.findall(home) == ["predator_prey"]
    assert sorted(tool.PICTURE.findall(gallery)) == sorted(names)
    pictures = [ROOT / "docs" / "img" / "gallery" / f"{name}.webp" for name in names]
    assert [path.name for path in pictures if path.stat().st_size > 150_000] == []


def test_a_picture_becomes_a_link_to_its_recorded_run(tool, tmp_path, monkeypatch):
    monkeypatch.setattr("gallery.TICKS", {"lamb": 3})
    for name in ("index.md", "gallery.md"):
        (tmp_path / name).write_text("![A lamb](img/gallery/lamb.webp) ![](img/why.png)", encoding="utf-8")
    tool.replays(tmp_path)
    assert (tmp_path / "gallery.md").read_text(encoding="utf-8") == (
        '<a class="living" href="_static/replays/lamb.html">![A lamb](img/gallery/lamb.webp)</a> ![](img/why.png)'
    )
    assert "Lambs and ewes" in (tmp_path / "_static" / "replays" / "lamb.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("html", "mended"),
    [
        (
            '<summary><span class="toctree-toggle"></span></summary><summary>A</summary>',
            '<summary aria-label="Pages of this section"><span class="toctree-toggle"></span></summary>'
            "<summary>A</summary>",
        ),
        ('<th class="head"><p></p></th><th></th><th>a</th>', '<td class="head"></td><td></td><th>a</th>'),
        (
            '<dl>\n<dd><em class="sig-param">a</em>,</dd>\n</dl><dl>\n<dt>b</dt><dd>c</dd>\n</dl>',
            '<span class="sig-params">\n<span><em class="sig-param">a</em>,</span>\n</span>'
            "<dl>\n<dt>b</dt><dd>c</dd>\n</dl>",
        ),
    ],
)
def test_faults_of_the_generated_pages_are_mended(html, mended, tool):
    assert tool.accessible(html) == mended


def test_site_and_viewer_have_the_same_logo():
    logo, viewer = (
        (ROOT / path).read_text(encoding="utf-8")
        for path in ("docs/_static/logo.svg", "ecs_eco/view/static/index.html")
    )
    mark = re.search(r'<svg class="mark".*?</svg>', viewer)
    assert mark
    assert re.findall(r' d="[^"]*" fill="[^"]*"', logo) == re.findall(r' d="[^"]*" fill="[^"]*"', mark[0])


def test_every_component_and_command_is_in_the_reference(tool):
    import ecs_eco.components
    from ecs_eco.cli.app import COMMANDS

    pages = tool.generated()
    assert all(f"## {name}\n" in pages["reference/api/components.md"] for name in ecs_eco.components.__all__)
    assert "| `energy` | `f32` | `1.0` | [energy] energy held |" in pages["reference/api/components.md"]
    commands = pages["reference/commands.md"]
    assert [name for name in COMMANDS if f"\n## {name}\n" not in commands] == []
    within = ("sweep run", "sweep status", "sweep resume", "sweep collect", "cache warm", "world from-raster")
    assert [name for name in within if f"\n### {name}\n\n`ecs-eco {name}" not in commands] == []
    assert "| `--portable` |" in commands


def test_every_row_of_a_table_of_commands_has_three_cells(tool):
    rows = [line for line in tool.generated()["reference/commands.md"].split("\n") if line.startswith("| ")]
    assert any("local\\|slurm\\|ray" in row for row in rows)
    assert [row for row in rows if row.replace("\\|", "").count("|") != 4] == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('<script src="https://cdn.example/x.js"></script>', ["https://cdn.example/x.js"]),
        ('<link href="//fonts.example/f.css" rel="preload stylesheet">', ["//fonts.example/f.css"]),
        ('<link rel="next" href="https://example.org"><a href="https://example.org">out</a>', []),
        ('<img alt="a" src="../img/a.png">', []),
    ],
)
def test_what_asks_the_network_is_found(text, found, tmp_path):
    page = tmp_path / "page.html"
    page.write_text(text, encoding="utf-8")
    assert asked_of_the_network(page) == found


class Quiet(SimpleHTTPRequestHandler):
    """A server of files that prints nothing."""

    def log_message(self, *_: object) -> None:
        """Print nothing."""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Build the site once for the tests below; return its folder and what the builder printed as errors."""
    out = tmp_path_factory.mktemp("site")
    command = [sys.executable, "tools/build_site.py", "--no-notebooks", "--out", str(out)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out, done.stderr


@pytest.mark.slow
def test_the_site_builds_without_a_warning_and_asks_nothing_of_the_network(built):
    folder, errors = built
    assert errors == ""
    pages = [*folder.rglob("*.html"), *folder.rglob("*.css")]
    assert len(pages) > 100
    assert {page.name: asked for page in pages if (asked := asked_of_the_network(page))} == {}


def first_hit(page, site: str, words: str) -> str:
    """Return the page that the search lists first."""
    page.goto(f"{site}/search.html?q={quote_plus(words)}")
    link = page.wait_for_selector("#search-results li a", timeout=120_000)
    return link.get_attribute("href").partition("#")[0].partition("?")[0]


@pytest.mark.slow
@pytest.mark.skipif(chromium() is None, reason="needs Chromium")
def test_each_search_finds_first_the_page_that_answers_it(built):
    pytest.importorskip("playwright")
    wanted = json.loads(SEARCHES.read_text(encoding="utf-8"))
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(built[0])))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        with launched() as browser:
            page = browser.new_page()
            address = f"http://127.0.0.1:{server.server_port}"
            assert {words: first_hit(page, address, words) for words in wanted} == wanted
    finally:
        server.shutdown()
        server.server_close()
