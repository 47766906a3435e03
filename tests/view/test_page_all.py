"""The table of all organisms, colours of families, descendants, and links to what is shown."""

import time

import pytest

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, pause, play, select

pytestmark = IN_A_BROWSER


@pytest.fixture
def table(page):
    """The table of all deer, of a world that stands still."""
    pause(page)
    page.locator("#tab-all").click()
    page.get_by_label("Species in the table").select_option("deer")
    filtered(page, "uid > 0")
    until(page, "document.querySelector('#all [role=status]').textContent.includes(' deer')")
    yield page
    filtered(page, "")


def filtered(page, where):
    page.locator("#tab-all").click()
    before = page.evaluate("(ecs.messages.table ?? 0) + (ecs.messages.said ?? 0)")
    page.get_by_label("Filter: show only organisms that match").fill(where)
    page.get_by_label("Filter: show only organisms that match").press("Enter")
    until(page, f"(ecs.messages.table ?? 0) + (ecs.messages.said ?? 0) > {before}")


def column(page, name):
    """The cells of a column, as numbers."""
    at = page.locator("#all th button").evaluate_all("all => all.map(one => one.dataset.column)").index(name)
    cells = page.locator(f"#all tbody td:nth-child({at + 1})").all_inner_texts()
    return [float(cell.lstrip("#").replace("\u202f", "").replace("−", "-")) for cell in cells]


def sort(page, name, descending):
    """Click on a head, and wait until rows are sorted: an answer to what was asked before may come first."""
    page.locator(f"#all th button[data-column={name}]").click()
    end = time.monotonic() + 120
    while (found := column(page, name)) != sorted(found, reverse=descending):
        assert time.monotonic() < end, found
        time.sleep(0.05)
    return found


def test_all_of_a_species_are_listed_sorted_and_a_click_selects_one(table):
    page = table
    number = page.evaluate("ecs.counts.deer")
    assert len(column(page, "uid")) == min(number, 100)
    assert len(set(column(page, "energy"))) > 1
    sort(page, "energy", descending=True)
    assert page.locator("#all th[aria-sort=descending]").inner_text() == "energy ↓"
    sort(page, "energy", descending=False)
    uid = int(column(page, "uid")[0])
    page.locator("#all tbody .uid").first.click()
    until(page, f"ecs.selected === {uid}")
    assert page.locator("#organism").is_visible()


def test_comparisons_filter_and_what_is_not_known_is_refused(table):
    page = table
    uid = column(page, "uid")
    middle = int(sorted(uid)[len(uid) // 2])
    filtered(page, f"uid < {middle}")
    less = sum(one < middle for one in uid)
    until(page, f"document.querySelectorAll('#all tbody tr').length === {less}")
    assert max(column(page, "uid")) < middle
    filtered(page, "enrgy < 1")
    until(page, "document.querySelector('#all [role=status]').textContent.includes(\"'energy'\")")
    assert page.locator("#all input").get_attribute("aria-invalid") == "true"


def test_families_and_descendants_have_colours(page):
    pause(page)
    page.locator("#colour").select_option("family")
    until(page, "ecs.still")
    assert "twelve largest" in page.locator("#ramp").inner_text()
    select(page, "wolf")
    uid = page.evaluate("ecs.selected")
    page.get_by_role("button", name="track descendants").click()
    until(page, f"document.querySelector('#ramp').textContent === 'descendants of #{uid}: 1 alive'")  # itself
    assert page.locator("#colour").input_value() == f"kin:{uid}"
    page.locator("#colour").select_option("species")
    assert not page.locator("#ramp").is_visible()


def test_a_reloaded_page_shows_the_same_tick_camera_selection_and_panel(page):
    play(page)
    until(page, "ecs.tick > 0")
    pause(page)
    select(page, "deer")
    page.locator("#canvas").focus()
    page.keyboard.press("i")
    page.keyboard.press("ArrowLeft")
    page.locator("#tab-why").click()
    until(page, "ecs.still")
    before = page.evaluate("[ecs.tick, ecs.selected, ecs.camera]")
    page.reload()
    until(page, "ecs.frames > 0 && ecs.connected && ecs.selected !== null && ecs.still")
    after = page.evaluate("[ecs.tick, ecs.selected, ecs.camera]")
    assert after[:2] == before[:2]
    assert after[2] == pytest.approx(before[2], rel=1e-3)
    assert page.locator("#tab-why").get_attribute("aria-selected") == "true"


def test_a_link_brings_tick_camera_selection_panel_colour_and_field_back(page):
    play(page)
    until(page, "ecs.tick >= 30")
    pause(page)
    select(page, "deer")
    uid, tick = page.evaluate("ecs.selected"), page.evaluate("ecs.tick")
    page.locator("#colour").select_option("age")
    page.locator("#field").select_option("deer_smell")
    page.locator("#canvas").focus()
    page.keyboard.press("i")
    page.keyboard.press("ArrowLeft")
    page.locator("#tab-why").click()
    until(page, "ecs.still")
    at = page.evaluate(f"ecs.screen({uid})")
    page.locator("#share").click()
    until(page, "location.hash.length > 20")
    link = page.evaluate("location.href")
    assert "code" not in link
    page.locator("#canvas").focus()
    page.keyboard.press("Period")
    page.keyboard.press("Home")
    page.keyboard.press("Escape")
    page.locator("#colour").select_option("species")
    page.locator("#field").select_option("")
    until(page, f"ecs.tick === {tick + 1} && ecs.still && ecs.selected === null")
    page.goto("about:blank")
    page.goto(link)
    until(page, f"ecs.tick === {tick} && ecs.selected === {uid} && ecs.still && ecs.connected")
    assert page.locator("#why").is_visible()
    assert page.locator("#colour").input_value() == "age"
    assert page.locator("#field").input_value() == "deer_smell"
    until(page, f"ecs.screen({uid}) !== null")
    again = page.evaluate(f"ecs.screen({uid})")
    assert (again["x"], again["y"]) == pytest.approx((at["x"], at["y"]), abs=3)
    page.locator("#colour").select_option("species")
    page.locator("#field").select_option("")
    page.evaluate("history.replaceState(null, '', location.pathname)")


def test_what_a_link_cannot_have_is_left_out(page):
    read = "hash => import('/link.js').then(({read}) => read(hash))"
    assert page.evaluate(read, "#code=abc") is None
    assert page.evaluate(read, "#tick=-4&uid=x&eye=1,2,3&tab=") is None
    assert page.evaluate(read, "#tick=12&tab=why&eye=1,2,3,4,5,6.5") == {
        "tick": 12,
        "tab": "why",
        "eye": [1, 2, 3, 4, 5, 6.5],
    }
