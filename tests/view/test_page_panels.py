"""Panels as the user arranges them, and panels of the user's own."""

import threading
from types import SimpleNamespace

import pytest

from ecs_eco import World
from ecs_eco.components import Position, Velocity
from ecs_eco.testing.browser import until
from ecs_eco.view.live import Live
from ecs_eco.view.server import Server
from ecs_eco.view.watch import served as player_of
from tests.view.pages import IN_A_BROWSER, opened, violations

pytestmark = IN_A_BROWSER
TABS = "[...document.querySelectorAll('[role=tab]:not([hidden])')].map(tab => tab.innerText).join()"
SPITEFUL = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 30 10" onload="parent.spite = 1">'
    '<script>parent.spite = 1</script><image href="http://127.0.0.1:9/"/><rect width="30" height="10"/></svg>'
)


def mites(made, ready):
    def count(world):
        made.threads.add(threading.current_thread())
        return world.table("mite").n

    def figure(world):
        from matplotlib.figure import Figure

        drawn = Figure()
        drawn.subplots().set_title("mites")
        return drawn

    def broken(world):
        raise KeyError("lice")

    world = World([100.0, 100.0], name="mites")
    world.add_table("mite", Position, Velocity)
    world.spawn("mite", n=20)
    panels = {"Mites": count, "Figure": figure, "Spite": lambda world: SPITEFUL, "Broken": broken}
    made.player = player_of(Live(world), playing=False, panels=panels)
    with Server(made.player) as server:
        made.server = server
        ready.set()
        made.player.source.run(made.player.turn)


@pytest.fixture(scope="module")
def made():
    made, ready = SimpleNamespace(threads=set()), threading.Event()
    thread = threading.Thread(target=mites, args=(made, ready))
    thread.start()
    assert ready.wait(60)
    made.thread = thread
    yield made
    made.player.close()
    thread.join()


@pytest.fixture
def mine(made, browser):
    with opened(browser, made.server.address()) as page:
        yield page


def tab(page, name):
    page.get_by_role("tab", name=name, exact=True).click()
    return page.get_by_role("tabpanel", name=name, exact=True)


def test_a_number_a_figure_and_an_error_are_shown_while_the_world_lives(mine, made):
    number = tab(mine, "Mites").locator(".figure")
    number.wait_for()
    assert number.inner_text() == "20"
    assert made.threads == {made.thread}
    picture = tab(mine, "Figure").locator("img")
    picture.wait_for()
    assert picture.get_attribute("src").startswith("blob:")
    until(mine, "document.querySelector('#own1 img').naturalWidth > 100")
    problem = tab(mine, "Broken").locator(".problem")
    problem.wait_for()
    assert problem.inner_text() == "Broken: KeyError: 'lice'"
    tick = mine.evaluate("ecs.tick")
    mine.locator("#step").click()
    until(mine, f"document.querySelector('#own3 .unit').textContent === 'tick {tick + 1}'")


def test_an_svg_never_becomes_part_of_the_page(mine):
    tab(mine, "Spite").locator("img").wait_for()
    until(mine, "document.querySelector('#own2 img').naturalWidth > 0")
    assert mine.evaluate("window.spite") is None
    assert mine.locator("#own2 svg, #own2 script").count() == 0


def test_only_displayed_panels_are_made_and_a_pinned_one_is(mine, made):
    mine.set_viewport_size({"width": 1400, "height": 800})
    tab(mine, "Mites").locator(".figure").wait_for()
    mine.locator("#pin").click()
    charts = tab(mine, "Charts")
    tick = mine.evaluate("ecs.tick")
    mine.locator("#step").click()
    until(mine, f"document.querySelector('#own0 .unit').textContent === 'tick {tick + 1}'")
    above, below = mine.locator("#own0").bounding_box(), charts.bounding_box()
    assert above["y"] + above["height"] <= below["y"] + 1
    mine.reload()
    until(mine, "ecs.frames > 0 && document.querySelector('#own0 .figure')")
    assert mine.locator("#own0").is_visible()
    assert mine.locator("#charts").is_visible()
    tab(mine, "Mites")
    mine.locator("#pin").click()
    tab(mine, "Charts")
    assert not mine.locator("#own0").is_visible()


def test_tabs_are_moved_by_dragging_and_by_keys_and_stay_there(mine):
    assert mine.evaluate(TABS) == "Charts,World,Why,Organism,All,Act,Mites,Figure,Spite,Broken"
    tab(mine, "Mites")
    for _ in range(5):
        mine.keyboard.press("Shift+ArrowLeft")
    assert mine.evaluate(TABS) == "Charts,Mites,World,Why,Organism,All,Act,Figure,Spite,Broken"
    assert mine.evaluate("document.activeElement.innerText") == "Mites"
    why, charts = (mine.locator(f"#tab-{name}").bounding_box() for name in ("why", "charts"))
    mine.mouse.move(why["x"] + 10, why["y"] + 10)
    mine.mouse.down()
    mine.mouse.move(charts["x"] + 4, charts["y"] + 12, steps=8)
    mine.mouse.up()
    assert mine.evaluate(TABS) == "Why,Charts,Mites,World,Organism,All,Act,Figure,Spite,Broken"
    assert mine.locator("#tab-why").get_attribute("aria-selected") == "false"  # it was moved, not opened
    mine.locator("#tab-why").click()
    assert mine.locator("#why").is_visible()
    mine.reload()
    until(mine, f"ecs.frames > 0 && {TABS} === 'Why,Charts,Mites,World,Organism,All,Act,Figure,Spite,Broken'")
    mine.evaluate("localStorage.removeItem('ecs-eco-panels')")


def test_the_width_of_the_panels_is_kept(mine):
    mine.locator("#splitter").focus()
    before = mine.locator("#side").bounding_box()["width"]
    mine.keyboard.press("ArrowRight")
    assert mine.locator("#side").bounding_box()["width"] == before - 40
    mine.reload()
    until(mine, "ecs.frames > 0")
    assert mine.locator("#side").bounding_box()["width"] == before - 40


@pytest.mark.parametrize("shade", ["light", "dark"])
def test_axe_finds_nothing_in_own_panels(mine, shade):
    mine.emulate_media(color_scheme=shade)
    for name in ("Mites", "Figure", "Broken"):
        tab(mine, name).locator("img, .figure, .problem").first.wait_for()
        assert violations(mine) == [], name
