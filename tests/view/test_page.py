"""The page in a real browser, against the real server: what is seen moves, and what is clicked happens."""

import numpy as np
import pytest

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, facts, pause, play, scene, select

pytestmark = IN_A_BROWSER


def test_frames_arrive_and_animals_move_on_the_screen(page):
    pause(page)
    tick = page.evaluate("ecs.tick")
    page.locator("#step").click()  # what other tests asked for is done
    until(page, f"ecs.tick === {tick + 1} && ecs.still")
    before, frames, tick = scene(page), page.evaluate("ecs.frames"), page.evaluate("ecs.tick")
    places, animals = (
        page.evaluate("ecs.uids('deer').map(ecs.place)"),
        page.evaluate("[ecs.counts.deer, ecs.counts.wolf]"),
    )
    play(page)
    until(page, f"ecs.frames > {frames + 5} && ecs.tick > {tick + 5}")
    pause(page)
    moved = np.linalg.norm(np.array(page.evaluate("ecs.uids('deer').map(ecs.place)")) - places, axis=1)
    assert (moved > 0.5).mean() > 0.3  # a third of the deer, by half a metre
    assert (abs(scene(page) - before).max(2) > 0.1).mean() > 0.002
    counts = page.evaluate("ecs.counts")
    assert list(counts) == ["grass", "deer", "wolf"]
    assert [counts["deer"], counts["wolf"]] == animals
    assert page.title().startswith("Grass, deer and wolves")
    until(page, "document.querySelectorAll('#charts canvas').length >= 2")


def test_a_paused_world_stands_still_and_a_step_is_one_tick(page):
    play(page)
    pause(page)
    tick, before = page.evaluate("ecs.tick"), scene(page)
    states = page.evaluate("ecs.messages.state")
    page.keyboard.press("+")  # the answer to this is a state: time has passed, had it not stood still
    until(page, f"ecs.messages.state > {states}")
    assert page.evaluate("ecs.tick") == tick
    assert (abs(scene(page) - before) > 0.05).mean() == 0
    page.locator("#step").click()
    until(page, f"ecs.tick === {tick + 1}")
    page.locator("#canvas").focus()
    page.keyboard.press(".")
    until(page, f"ecs.tick === {tick + 2}")
    page.keyboard.press("Space")
    until(page, f"ecs.playing && ecs.tick > {tick + 3}")


def test_a_clicked_animal_shows_its_life_and_its_nervous_system(page):
    pause(page)
    page.locator("#step").click()  # who has never decided has no decisions to show
    until(page, "ecs.tick > 0 && ecs.still")
    uid, panel = select(page, "deer"), page.locator("#organism")
    assert f"#{uid}" in panel.locator(".who").inner_text()
    assert {"age", "energy", "happiness", "sex", "born", "reward"} <= set(facts(panel))
    assert facts(panel)["energy"].endswith("/ 1")
    words = panel.locator(".nerves text").all_text_contents()
    assert {"no reflex", "policy", "happiness", "walk", "left", "eat", "energy"} <= set(words)
    assert panel.locator(".nerves").get_attribute("aria-label") == "Nervous system: 14 sensors, 7 actions"
    page.keyboard.press("n")
    until(page, f"ecs.selected !== {uid} && ecs.messages.organism > 1")
    page.keyboard.press("Escape")
    until(page, "ecs.selected === null")


def test_what_a_colour_means_is_said_while_the_world_stands_still(page):
    pause(page)
    page.locator("#colour").select_option("energy")
    until(page, "/0\\s*deer\\s*1/.test(document.querySelector('#ramp').innerText)")
    page.locator("#colour").select_option("species")
    assert not page.locator("#ramp").is_visible()


def test_what_cannot_be_done_is_refused_by_the_browser_or_in_words(page):
    pause(page)
    page.locator("#tab-act").click()
    acts = page.evaluate("ecs.acts")
    page.get_by_label("Parameter").fill("species.grass.reproduction.rate")
    page.get_by_label("New value").fill("-1")
    page.get_by_role("button", name="Change").click()
    assert page.evaluate("ecs.acts") == acts  # below the bound: not even sent
    page.get_by_label("New value").fill("0.05")
    page.get_by_role("button", name="Change").click()
    until(
        page,
        "document.querySelector('#act .log "
        "li')?.textContent.includes('species.grass.reproduction.rate = 0.05')",
    )
    page.get_by_label("Parameter").fill("species.deer.metabolism.energy_max")
    page.get_by_label("New value").fill("0.0001")
    page.get_by_role("button", name="Change").click()
    page.locator("#act .log li.error").wait_for()


def test_a_hidden_kind_has_no_curve(page):
    pause(page)
    shown = "[...document.querySelectorAll('#charts .chart:first-child .key')].map(key => key.textContent)"
    wolf = page.locator("#legend").get_by_title("Show or hide wolf")
    until(page, f"{shown}.some(text => text.includes('wolf'))")
    wolf.click()
    until(page, f"!{shown}.some(text => text.includes('wolf'))")
    until(page, f"{shown}.some(text => text.includes('deer'))")
    wolf.click()
    until(page, f"{shown}.some(text => text.includes('wolf'))")


def test_a_slider_keeps_the_keys_that_move_it(page):
    pause(page)
    uid = page.evaluate("ecs.uids('deer')[0]")
    where = page.evaluate(f"ecs.screen({uid})")
    page.locator("#speed").focus()
    for key in ("PageUp", "Home", "ArrowRight"):
        page.keyboard.press(key)
    until(page, "ecs.still && document.querySelector('#speed').value === '1'")
    page.locator("#speed").evaluate("it => { it.value = 3; it.dispatchEvent(new Event('input')) }")
    assert page.evaluate(f"ecs.screen({uid})") == pytest.approx(where)


LATE_ANSWERS = """async () => {
  const { showSpeed, speedAt } = await import("./speed.js"), slider = document.querySelector("#speed");
  const slots = [];
  for (const asked of [5, 1]) speedAt(asked);
  for (const told of [20, 50, 2, 1]) { // ticks/s: of before, of both requests, of another page
    showSpeed(told);
    slots.push(slider.value);
  }
  return slots;
}"""


def test_late_answers_to_earlier_requests_do_not_move_the_slider(page):
    pause(page)
    assert page.evaluate(LATE_ANSWERS) == ["1", "1", "1", "0"]


def test_one_that_is_selected_while_time_stands_still_has_a_point_in_its_chart(page):
    pause(page)
    page.locator("#step").click()
    until(page, "ecs.tick > 0 && ecs.still")
    select(page, "wolf")
    until(page, "document.querySelector('#organism .uplot canvas')")
    assert page.evaluate(INK) > 5


INK = """() => {
  const canvas = document.querySelector("#organism .uplot canvas"), pen = canvas.getContext("2d");
  const { data } = pen.getImageData(0, 0, canvas.width, canvas.height);
  let n = 0; // pixels that are no grey: of the points, not of axes
  for (let i = 0; i < data.length; i += 4) n += data[i + 3] > 200 && Math.max(data[i], data[i + 1], data[i + 2]) - Math.min(data[i], data[i + 1], data[i + 2]) > 60;
  return n;
}"""  # noqa: E501


def test_no_name_in_the_nervous_system_is_cut(page):
    pause(page)
    page.locator("#step").click()
    until(page, "ecs.tick > 0 && ecs.still")
    select(page, "deer")
    assert not [text for text in page.locator(".nerves text").all_text_contents() if "…" in text]
    outside = """[...document.querySelectorAll(".nerves text")].filter((text) => {
      const box = text.getBBox(), view = text.ownerSVGElement.viewBox.baseVal;
      return box.x < view.x || box.x + box.width > view.x + view.width;
    }).map((text) => text.textContent)"""
    assert page.evaluate(outside) == []


def test_wide_letters_of_what_is_done_are_not_cut_either(page):
    cut = """names => import("/nerves.js").then(({ drawNerves }) => {
      const action = { group: "g", reflex: 1, decision: 1, chosen: 1, probability: 1 };
      const { root } = drawNerves({ sensors: names.map((name) => ({ value: 1, name })),
        actions: names.map((name) => ({ ...action, name })), happiness: 1, reward: 0 });
      document.getElementById("charts").append(root);
      const view = root.viewBox.baseVal;
      const texts = [...root.querySelectorAll("text")].map((one) => one.getBBox());
      root.remove();
      return texts.filter(({ x, width }) => x < view.x || x + width > view.x + view.width).length;
    })"""
    assert page.evaluate(cut, ["wander", "swim", "mmmmmmmmmmmm"]) == 0


def test_readings_are_joined_to_the_networks_that_use_them(page):
    drawn = """() => import("/nerves.js").then(({ drawNerves, wired }) => {
      const nerves = { sensors: ["a", "b"].map((name) => ({ name, value: 1 })), happiness: 1, reward: null,
        actions: [{ group: "feed", name: "eat", reflex: 1, decision: 1, chosen: 0, probability: null }] };
      const wiring = { reflexes: [[[0], 0, "+1 if a > 0.5"]], function: "", policy: "none",
        happiness: "2 * b", felt: [1], all: { reflex: false, policy: false, happiness: false } };
      const { root } = drawNerves(nerves, wiring), words = [...root.querySelectorAll("text")];
      return [[...root.querySelectorAll("[data-wire]")].map((wire) => wire.dataset.wire),
        words.map((one) => one.textContent), wired(nerves, wiring)];
    })"""
    wires, words, told = page.evaluate(drawn)
    assert wires == ["a reflex", "b happiness"]
    assert {"no policy", "reflex", "feed"} <= set(words)
    assert told == [["happiness =", "2 * b"], ["reflexes", "eat: +1 if a > 0.5"], ["policy", "none"]]


TALLER = """() => {
  const lines = document.createElement("p");
  lines.innerHTML = "<br>".repeat(5);
  document.getElementById("legend").append(lines);
  window.shorter = () => lines.remove();
}"""


@pytest.mark.parametrize("eye", ["top", "side"])
def test_all_of_the_world_is_clear_of_what_lies_over_the_scene(page, eye):
    pause(page)
    page.locator(f"[data-eye={eye}]").click()
    until(page, "ecs.still")
    covered = "([x, y]) => document.elementFromPoint(x, y)?.id !== 'canvas'"
    corners = page.evaluate("ecs.corners()")
    assert len(corners) >= 4
    assert [corner for corner in corners if page.evaluate(covered, corner)] == []
    page.evaluate(TALLER)  # much of a small scene is covered, so the camera has to go far away
    try:
        page.locator(f"[data-eye={eye}]").click()
        until(page, "ecs.still")
        assert [corner for corner in page.evaluate("ecs.corners()") if page.evaluate(covered, corner)] == []
    finally:
        page.evaluate("shorter()")


def test_the_dead_are_not_followed(page):
    pause(page)
    uid = select(page, "deer")
    assert page.locator("[data-eye=follow]").is_enabled()
    page.locator("#tab-act").click()
    page.get_by_role("button", name="Remove the selected organism").click()
    page.locator("#step").click()
    until(page, f"ecs.still && !ecs.place({uid}) && document.querySelector('[data-eye=follow]').disabled")
    page.locator("#tab-organism").click()
    until(page, "document.querySelector('#organism .who .button').disabled")
