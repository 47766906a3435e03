"""A recorded run as one file: it opens from disk, without a network, and shows what was recorded."""

import gzip
import json
import re
from base64 import b64decode
from contextlib import contextmanager
from shutil import copytree, rmtree

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.config import load
from ecs_eco.engine.errors import RecordingError
from ecs_eco.lab import Archipelago
from ecs_eco.testing.browser import served, until
from ecs_eco.view import export
from ecs_eco.view.replay import Replay
from tests.lab.newts import written
from tests.view.pages import IN_A_BROWSER, LOCAL, WIDE, facts, opened, pause, violations
from tests.view.replays import TICKS

SHELL = 450_000  # [bytes] of a page without a run, at most


def in_a_browser(test):
    for mark in IN_A_BROWSER:
        test = mark(test)
    return test


def head(html):
    """What a page contains besides columns."""
    part = re.search(r"data-part>([^<]+)<", html)[1]
    return json.loads(gzip.decompress(b64decode(part)))


def test_the_page_loads_nothing_from_elsewhere_and_is_the_same_each_time(plain):
    html = export.page(plain)
    assert html == export.page(plain)
    assert len(html) < 2 * SHELL
    assert "default-src 'none'" in html
    assert re.findall(r'<(?:script|link|img|iframe)[^>]*(?:src|href)="(?!data:)', html) == []


def test_a_page_that_would_be_too_large_has_fewer_organisms_and_says_so(plain):
    whole = export.page(plain)
    html = export.page(plain, len(whole) - 1)
    assert len(html) < len(whole)
    every = {kind["name"]: kind["every"] for kind in head(html)["hello"]["species"]}
    thinned = [name for name, of in every.items() if of > 1]
    assert len(thinned) == 1
    assert f"The file contains 1 in 2 {thinned[0]};" in " ".join(head(html)["hello"]["file"])
    assert {kind["every"] for kind in head(whole)["hello"]["species"]} == {1}
    with pytest.raises(RecordingError, match="does not fit into 0"):
        export.page(plain, 100_000)


@pytest.mark.parametrize(
    "words", ["{run} --html {run}/manifest.json", "{run} --html {old}", "{run}/series", "{islands}"]
)
def test_what_cannot_be_exported_is_refused_with_the_reason(words, folders, tmp_path):
    (tmp_path / "old.html").write_text("old")
    (tmp_path / "islands").mkdir()
    (tmp_path / "islands" / "archipelago.json").write_text("{}")
    words = words.format(run=folders / "plain", old=tmp_path / "old.html", islands=tmp_path / "islands")
    result = CliRunner().invoke(app, ["export", *words.split()])
    assert result.exit_code == 2
    assert any(
        part in result.output
        for part in ("unsupported format", "already exists", "no manifest.json", "archipelago")
    )
    assert (tmp_path / "old.html").read_text() == "old"


def test_a_run_without_snapshots_is_refused(folders, tmp_path):
    copytree(folders / "plain", tmp_path / "run")
    rmtree(tmp_path / "run" / "snapshots")
    result = CliRunner().invoke(app, ["export", str(tmp_path / "run")])
    assert result.exit_code == 2
    assert "3 of 3 parts of snapshots are missing" in result.output


@pytest.fixture(scope="module")
def shared(folders, tmp_path_factory):
    """The file of the run, written by the command."""
    path = tmp_path_factory.mktemp("shared") / "run.html"
    result = CliRunner().invoke(app, ["export", str(folders / "plain"), "--html", str(path), "--quiet"])
    assert result.exit_code == 0, result.output
    return path


@contextmanager
def from_disk(browser, path, shade="light"):
    """A page opened from disk without a network; at its end, nothing was complained of or asked for."""
    context = browser.new_context(viewport=WIDE, offline=True, color_scheme=shade)
    context.set_default_timeout(180_000)
    page, problems, asked = context.new_page(), [], []
    page.on("console", lambda message: problems.append(message.text))
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    try:
        page.goto(path.as_uri())
        until(page, "ecs.frames > 0 && ecs.renders > 0 && ecs.connected && ecs.messages.state > 0")
        yield page
        assert {url for url in asked if not url.startswith(LOCAL)} == {path.as_uri()}
        assert [text for text in problems if "GPU stall" not in text] == []
    finally:
        context.close()


def go(page, tick):
    page.get_by_label("Time, in ticks").evaluate(
        f"slider => {{ slider.value = {tick}; slider.dispatchEvent(new Event('input')) }}"
    )
    until(page, f"ecs.tick === {tick} && ecs.still")


def figure(text):
    return float(text.replace("\u202f", "").replace("−", "-"))


@in_a_browser
def test_each_tick_of_the_file_shows_what_was_recorded(browser, shared, plain):
    series = plain.series(-1)
    with from_disk(browser, shared) as page:
        assert page.evaluate("[ecs.mode, ecs.playing, ecs.tick]") == ["replay", False, 0]
        for tick in (0, 5, 17, 30, TICKS - 1):
            go(page, tick)
            plain.handle({"kind": "seek", "tick": tick})
            assert page.evaluate("ecs.counts") == plain.counts()
            for name in (*plain.species, *plain.objects):
                crowd = plain.crowd(name)
                assert page.evaluate(f"ecs.uids('{name}', 10000)") == crowd.uid.tolist()
                for row in range(0, crowd.uid.size, 5):
                    place = page.evaluate(f"ecs.place({crowd.uid[row]})")
                    assert place[:2] == pytest.approx([crowd.x[row], crowd.y[row]], abs=0.01)
            chart = page.locator("#charts .chart", has_text="Populations").first
            shown = chart.locator(".key").all_inner_texts()
            values = {name: int(value) for name, value in (words.split() for words in shown)}
            at = series["tick"].index(tick)
            assert values == {name: series["n"][name][at] for name in plain.species}
        page.locator("#play").click()
        until(page, f"!ecs.playing && ecs.tick === {TICKS - 1}")  # from the beginning to the end
        assert page.evaluate("ecs.messages.fates") > 0


@in_a_browser
def test_the_legend_of_a_thinned_file_counts_all_organisms(browser, plain, tmp_path):
    path = tmp_path / "thin.html"
    path.write_text(export.page(plain, len(export.page(plain)) - 1), encoding="utf-8")
    plain.handle({"kind": "seek", "tick": 20})
    with from_disk(browser, path) as page:
        go(page, 20)
        page.locator(
            "#legend .legend-row", has_text="1 in 2 shown"
        ).wait_for()  # rates are written at intervals
        legend = dict(zip(plain.species, page.locator("#legend .legend-row").all_inner_texts(), strict=False))
        thinned = [name for name, words in legend.items() if "1 in 2 shown" in words]
        assert len(thinned) == 1
        counts = plain.counts()
        assert page.evaluate("ecs.counts")[thinned[0]] < counts[thinned[0]]
        assert all(str(counts[name]) in words.split() for name, words in legend.items())


@in_a_browser
def test_migrants_and_their_uids_are_in_the_file_of_an_island(browser, tmp_path):
    islands = Archipelago.from_config(load(str(written(tmp_path))), seed=2, out=tmp_path / "run")
    islands.run(until=8, report=False)
    folder = islands.folder / "islands" / "east"
    replay, path = Replay(folder), tmp_path / "east.html"
    path.write_text(export.page(replay), encoding="utf-8")
    with from_disk(browser, path) as page:
        for tick in (0, 4, 7):  # migrants arrive and leave at tick 4
            go(page, tick)
            replay.handle({"kind": "seek", "tick": tick})
            assert page.evaluate("ecs.uids('newt', 1000)") == replay.crowd("newt").uid.tolist()
    assert replay.crowd("newt").uid[0] < 2**32 < replay.crowd("newt").uid[-1]


@in_a_browser
def test_an_organism_of_the_file_has_its_panel_and_what_is_missing_is_named(browser, shared, plain):
    with from_disk(browser, shared) as page:
        go(page, 12)
        plain.handle({"kind": "seek", "tick": 12})
        page.locator("#colour").select_option("energy")
        page.locator("#canvas").focus()
        page.keyboard.press("n")
        page.locator("#organism .who").wait_for()
        uid = page.evaluate("ecs.selected")
        told, shown = plain.organism(uid), facts(page.locator("#organism"))
        assert told["species"] in page.locator("#organism .who").inner_text()
        assert figure(shown["age"].split()[0]) == pytest.approx(told["age"], rel=0.005)
        assert figure(shown["energy"].split()[0]) == pytest.approx(told["energy"], rel=0.005)
        assert [float(part) for part in shown["position [m]"].split(",")] == pytest.approx(
            told["place"][:2], abs=0.06
        )
        assert page.locator("#organism .kin .uid").count() == len(told["parents"]) + len(told["children"])
        page.locator("#organism summary", has_text="Family tree").click()
        until(page, "document.querySelector('#organism .tree').textContent.includes('not in this file')")
        assert not page.locator("#tab-all").is_visible()
        page.locator("#tab-why").click()
        page.locator("#why .account section").first.wait_for()
        page.locator("#tab-world").click()
        assert "needs no server" in page.locator("#world").inner_text()
        page.reload()  # it returns to the tick and the organism
        until(page, f"ecs.tick === 12 && ecs.selected === {uid} && ecs.still")


@in_a_browser
@pytest.mark.parametrize("shade", ["light", "dark"])
def test_axe_finds_nothing_in_the_file(browser, shared, shade):
    with from_disk(browser, shared, shade) as page:
        assert page.evaluate("document.documentElement.dataset.shade") == shade
        page.locator("#canvas").focus()
        page.keyboard.press("n")
        page.locator("#organism .who").wait_for()
        for panel in page.locator("[role=tab]:not([hidden])").all():
            panel.click()
            assert violations(page) == [], panel


@in_a_browser
def test_the_page_of_a_replay_saves_it_as_a_file(browser, folders, plain):
    with served("watch", str(folders / "plain")) as run, opened(browser, run.address()) as page:
        pause(page)
        with page.expect_download() as download:
            page.get_by_role("button", name="Page", exact=True).click()
        assert download.value.suggested_filename.endswith(".html")
        assert download.value.path().read_text(encoding="utf-8") == export.page(plain)
        page.get_by_role("button", name="Page", exact=True).wait_for()
