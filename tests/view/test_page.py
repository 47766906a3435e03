"""The page in a real browser, against the real server: what is seen moves, and what is clicked happens."""

import numpy as np

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, facts, pause, play, scene, select

pytestmark = IN_A_BROWSER


def test_frames_arrive_and_animals_move_on_the_screen(page):
    pause(page)
    tick = page.evaluate("ecs.tick")
    page.locator("#step").click()  # what other tests asked for is done
    until(page, f"ecs.tick === {tick + 1} && ecs.still")
    before, frames, tick = scene(page), page.evaluate("ecs.frames"), page.evaluate("ecs.tick")
    places, animals = (page.evaluate("ecs.uids('deer').map(ecs.place)"),
                       page.evaluate("[ecs.counts.deer, ecs.counts.wolf]"))
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
    assert {"reflex", "policy", "happiness", "walk", "left", "eat", "energy"} <= set(words)
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
    until(page, "document.querySelector('#act .log "
                "li')?.textContent.includes('species.grass.reproduction.rate = 0.05')")
    page.get_by_label("Parameter").fill("species.deer.metabolism.energy_max")
    page.get_by_label("New value").fill("0.0001")
    page.get_by_role("button", name="Change").click()
    page.locator("#act .log li.error").wait_for()
