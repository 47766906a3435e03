"""The family tree in the panel of an organism: of a living world and of a replay, by mouse and keyboard."""

from itertools import count

import pytest

from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, opened, pause, violations
from tests.view.test_page_access import CONTRAST
from tests.view.test_tree import DEER, TWO

pytestmark = IN_A_BROWSER
KIDS = {
    "species.deer.reproduction.rate": 0.3,
    "species.deer.reproduction.energy_min": 0.02,
    "species.deer.reproduction.energy_given": 0.01,
    "species.deer.max_count": 350,
    "species.deer.lethal.1.max": 20.0,
}
FIRST = 1  # founders have uids in the order of names: the first deer
TICK = 24
COUNT = count()
NODES = """[...document.querySelectorAll('.tree-node')].map(node => {
  const box = node.querySelector('rect').getBoundingClientRect();
  return {key: node.dataset.key, name: node.getAttribute('aria-label'), left: box.left, right: box.right,
          top: box.top, bottom: box.bottom, kind: node.getAttribute('class')};
})"""


@pytest.fixture(scope="module")
def alive(browser):
    """Deer that clone themselves, alive, after thirty ticks."""
    changes = [word for key, value in (DEER | KIDS).items() for word in ("--set", f"{key}={value}")]
    with (
        served("watch", "predator-prey", *changes, "--policies", "random", "--seed", "4") as run,
        opened(browser, run.address()) as page,
    ):
        pause(page)
        while (tick := page.evaluate("ecs.tick")) < TICK:
            page.keyboard.press(".")
            until(page, f"ecs.tick > {tick}")
        page.evaluate(f"location.hash = 'tick={TICK}'")  # goes back, where it was too late
        until(page, f"ecs.tick === {TICK}")
        yield page


@pytest.fixture(scope="module")
def replay(browser, tmp_path_factory):
    """Deer of two parents, recorded."""
    path = tmp_path_factory.mktemp("tree") / "run"
    run_to_folder(
        load("predator-prey", DEER | TWO),
        ticks=45,
        out=path,
        seed=4,
        policies="random",
        learn=False,
        report=False,
    )
    with served("watch", str(path)) as run, opened(browser, run.address()) as page:
        pause(page)
        page.evaluate("location.hash = 'tick=44'")
        until(page, "ecs.tick === 44 && ecs.still")
        yield page


def show(page, uid):
    """Select one and open its tree; returns what is drawn, by key."""
    page.evaluate(f"location.hash = 'uid={uid}&at={next(COUNT)}'")  # another address than before
    until(page, f"ecs.selected === {uid} && document.querySelector('#organism .who')")
    page.evaluate("document.querySelector('.tree').open = true")
    until(page, f"document.querySelector('.tree-node.focal')?.dataset.key === '{uid}'")
    return drawn(page)


def step(page):
    tick = page.evaluate("ecs.tick")
    page.locator("#step").click()
    until(page, f"ecs.tick > {tick} && ecs.still")


def drawn(page):
    return {node["key"]: node for node in page.evaluate(NODES)}


def parents_of(page):
    return [int(text[1:]) for text in page.locator("#organism .kin").first.locator(".uid").all_inner_texts()]


def children_of(page):
    return page.locator("#organism .kin").nth(1).locator(".uid").count()


def clear_of_each_other(nodes):
    boxes = list(nodes.values())
    return all(
        a["right"] <= b["left"]
        or b["right"] <= a["left"]
        or a["bottom"] <= b["top"]
        or b["bottom"] <= a["top"]
        for i, a in enumerate(boxes)
        for b in boxes[:i]
    )


def test_nothing_is_asked_for_while_the_tree_is_closed(alive):
    uid = alive.evaluate("ecs.uids('deer')")[0]
    alive.evaluate(f"location.hash = 'uid={uid}&at={next(COUNT)}'")
    until(alive, f"ecs.selected === {uid} && document.querySelector('#organism .who')")
    alive.evaluate("document.querySelector('.tree').open = false")  # a test before may have left it open
    step(alive)  # what was asked for by then has been answered
    before = alive.evaluate("ecs.messages.tree ?? 0")
    step(alive)
    assert alive.evaluate("ecs.messages.tree ?? 0") == before
    assert alive.locator(".tree-node:visible").count() == 0
    alive.locator(".tree summary").click()
    until(alive, f"ecs.messages.tree > {before} && document.querySelector('.tree-node.focal')")
    name = alive.locator(".tree-drawing").get_attribute("aria-label")
    assert name.startswith(f"Family tree of deer #{uid}")


def test_parents_are_above_children_below_and_many_of_them_together(alive):
    uids = iter(sorted(alive.evaluate("ecs.uids('deer')")))
    show(alive, next(uids))
    while not children_of(alive) > 5:
        show(alive, next(uids))
    nodes = drawn(alive)
    focal = nodes[str(alive.evaluate("ecs.selected"))]
    rest = nodes[f"down {focal['key']}"]
    shown = [node for node in nodes.values() if node["kind"].split()[1] in ("alive", "dead")]
    assert int(rest["name"].split()[0]) == children_of(alive) - 4
    assert len(shown) >= 5
    parents = [node for node in shown if int(node["key"]) in parents_of(alive)]
    assert all(node["bottom"] < focal["top"] for node in parents)
    assert all(node["top"] > focal["bottom"] for node in shown if node is not focal and node not in parents)
    assert clear_of_each_other(nodes)
    alive.locator(f".tree-node[data-key='{rest['key']}']").click()
    more = drawn(alive)
    assert len(more) > len(nodes)
    assert rest["key"] not in more
    assert clear_of_each_other(more)


def test_a_click_selects_and_the_dead_have_a_cause_and_an_age(alive):
    young = max(alive.evaluate("ecs.uids('deer')"))
    nodes = show(alive, young)
    (parent,) = parents_of(alive)
    assert nodes[str(parent)]["bottom"] < nodes[str(young)]["top"]
    alive.locator(f".tree-node[data-key='{parent}']").click()
    until(alive, f"ecs.selected === {parent} && document.querySelector('.focal')?.dataset.key === '{parent}'")
    show(alive, FIRST)
    dead = alive.locator(".tree-node.focal")
    assert "too old at 19 s" in dead.get_attribute("aria-label")
    assert dead.locator("text").all_text_contents()[1:] == ["† too old", "19 s"]
    assert "past" not in alive.locator("#organism").get_attribute("class").split()


def test_the_keyboard_goes_from_one_to_the_next_and_selects(alive):
    young = max(alive.evaluate("ecs.uids('deer')"))
    show(alive, young)
    (parent,) = parents_of(alive)
    at = "document.activeElement.getAttribute('data-key')"
    alive.locator(".tree summary").focus()
    alive.keyboard.press("Tab")
    assert alive.evaluate(at) == str(young)
    assert alive.locator(".tree-node[tabindex='0']").count() == 1
    camera = alive.evaluate("ecs.camera")
    alive.keyboard.press("ArrowUp")
    assert alive.evaluate(at) == str(parent)
    alive.keyboard.press("ArrowDown")
    assert alive.evaluate(at) == str(young)
    alive.keyboard.press("ArrowUp")
    alive.keyboard.press("Enter")
    until(alive, f"ecs.selected === {parent} && {at} === '{parent}'")
    alive.keyboard.press(" ")
    assert not alive.evaluate("ecs.playing")
    assert alive.evaluate("ecs.camera") == pytest.approx(camera, abs=0.01)


def test_who_descends_from_the_tracked_one_has_a_dot_of_its_colour(alive):
    dotted = "[...document.querySelectorAll('.tree-node:has(.clade)')].map(node => node.dataset.key)"
    young = max(alive.evaluate("ecs.uids('deer')"))
    show(alive, young)
    assert alive.evaluate(dotted) == []
    (parent,) = parents_of(alive)
    alive.get_by_role("button", name="track descendants").click()
    until(alive, f"{dotted}.length > 0")
    assert alive.evaluate(dotted) == [str(young)]
    assert "its descendants are tracked" in drawn(alive)[str(young)]["name"]
    show(alive, parent)
    alive.get_by_role("button", name="track descendants").click()
    until(alive, f"{dotted}.length > 1")
    nodes = drawn(alive)  # of many children a few are there: the young one may not be
    below = {
        key
        for key, node in nodes.items()
        if node["kind"].split()[1] in ("alive", "dead") and node["top"] > nodes[str(parent)]["bottom"]
    }
    assert below
    assert set(alive.evaluate(dotted)) == below | {str(parent)}
    assert all(f"descends from #{parent}" in nodes[key]["name"] for key in below)
    alive.locator("#colour").select_option("species")
    until(alive, "!document.querySelector('.tree .clade')")


def test_an_open_tree_of_a_living_world_goes_on_with_time(alive):
    young = max(alive.evaluate("ecs.uids('deer')"))
    show(alive, young)
    count = alive.evaluate("ecs.messages.tree")
    alive.locator("#tab-act").click()
    alive.get_by_role("button", name="Remove the selected organism").click()
    until(alive, "document.querySelectorAll('#act .log li').length > 0")
    alive.locator("#tab-organism").click()
    alive.locator("#step").click()
    until(alive, f"ecs.messages.tree > {count} && document.querySelector('.tree-node.focal.dead')")
    assert "removed" in alive.locator(".tree-node.focal").get_attribute("aria-label")


def test_of_two_parents_both_are_there_and_time_moves_the_line_between_living_and_dead(replay):
    replay.evaluate("location.hash = 'tick=44'")  # another test may have gone to a tick with founders only
    until(replay, "ecs.tick === 44 && ecs.still")
    young = max(replay.evaluate("ecs.uids('deer')"))
    nodes = show(replay, young)
    assert len(parents_of(replay)) == 2
    assert {str(uid) for uid in parents_of(replay)} <= set(nodes)
    assert clear_of_each_other(nodes)
    assert all("unborn" not in node["kind"] for node in nodes.values())
    asked = replay.evaluate("ecs.messages.tree")
    replay.evaluate("location.hash = 'tick=1'")
    until(replay, "ecs.tick === 1 && document.querySelector('.tree-node.unborn')")
    assert "not yet born" in replay.locator(".tree-node.unborn").first.get_attribute("aria-label")
    assert replay.locator(".tree-node.dead").count() == 0
    assert replay.evaluate("ecs.messages.tree") == asked
    replay.evaluate("location.hash = 'tick=44'")
    until(replay, "ecs.tick === 44 && !document.querySelector('.tree-node.unborn')")


@pytest.mark.parametrize("shade", ["light", "dark"])
def test_an_open_tree_is_accessible_in_both_themes(alive, shade):
    if alive.evaluate("document.documentElement.dataset.shade") != shade:
        alive.locator("#theme").click()
    show(alive, FIRST)
    assert violations(alive) == []  # once colors have faded
    assert alive.evaluate(CONTRAST) == []


def test_causes_are_cut_between_words(alive):
    read = (
        "room => import('/tree.js').then(({fit}) => "
        "['† eaten by wolf', '† starved'].map(words => fit(words, room, 10)))"
    )
    assert alive.evaluate(read, 200) == ["† eaten by wolf", "† starved"]
    assert alive.evaluate(read, 52) == ["† eaten", "† starved"]
