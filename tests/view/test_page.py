"""The page in a real browser, against the real server: what is seen moves, and what is clicked happens."""

import io
import os
import re
import shutil
import subprocess
import sys
import time
from contextlib import contextmanager
from types import SimpleNamespace

import pytest

api = pytest.importorskip("playwright.sync_api", reason='playwright is not installed: pip install -e ".[dev]"')
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here (Debian: apt-get install chromium)")]

MAIN = "from ecs_eco.cli import main; main()"
PARK = {"space.size": "[60, 60]", "species.grass.count": 300, "species.deer.count": 80, "species.wolf.count": 12,
        "species.wolf.diet.0.chance": 0}  # fmt: skip
for animal in ("deer", "wolf"):  # nobody is eaten, starves or is born: tests may take their time
    zero = ("metabolism.basal", "locomotion.cost.walk", "locomotion.cost.run", "reproduction.rate")
    PARK |= {f"species.{animal}.{key}": 0 for key in zero} | {f"species.{animal}.lethal.1.max": 1e9}
SMALL = [word for key, value in PARK.items() for word in ("--set", f"{key}={value}")]
FLAGS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
         "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"]  # fmt: skip


@contextmanager
def watched(*words):
    """`ecs-eco watch …`: the process, and the address that it said."""
    command, environment = [sys.executable, "-c", MAIN, "watch", *words, "--no-browser"], os.environ | {"OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment)
    try:
        assert process.stdout is not None
        found = re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", process.stdout.readline())
        assert found
        yield SimpleNamespace(process=process, address=found[0])
    finally:
        process.kill()
        process.communicate()


@pytest.fixture(scope="module")
def browser():
    with api.sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield found
        found.close()


@pytest.fixture(scope="module")
def park():
    """Grass, deer and wolves, alive in a process of their own."""
    with watched("predator-prey", *SMALL, "--policies", "random", "--seed", "3") as found:
        yield found


@contextmanager
def opened(browser, address, width=1280, height=800, **more):
    """A page that shows the world; at its end, nothing was complained of and nothing left the machine."""
    context = browser.new_context(viewport={"width": width, "height": height}, **more)
    page, problems, asked = context.new_page(), [], []
    page.on("console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda socket: asked.append(socket.url))
    try:
        page.goto(address)
        until(page, "ecs.frames > 0 && ecs.renders > 0 && ecs.connected")  # one frame, where the world stands still
        yield page
        host = address.split("/")[2]
        assert [url for url in asked if not url.startswith("data:") and url.split("/")[2] != host] == []
        assert [text for text in problems if "GPU stall" not in text] == []  # software rendering says so of screenshots
    finally:
        context.close()


def until(page, condition, seconds=60):
    """Wait for something to be true on the page. (`wait_for_function` would want eval, which the page forbids.)"""
    end = time.monotonic() + seconds
    while not page.evaluate(f"() => Boolean(window.ecs && ({condition}))"):
        assert time.monotonic() < end, f"{condition}: not so after {seconds} s"
        time.sleep(0.05)


def scene(page):
    """The pixels of the scene: f32[height, width, 3]."""
    from matplotlib.image import imread

    box = page.locator("#canvas").bounding_box()
    return imread(io.BytesIO(page.screenshot(clip=box | {"x": box["x"] + 200, "width": box["width"] - 420})))[..., :3]


def pause(page):
    """Stop, and wait until the scene shows the last tick that was."""
    if page.evaluate("ecs.playing"):
        page.locator("#play").click()
    until(page, "!ecs.playing")
    time.sleep(0.5)


def play(page):
    if not page.evaluate("ecs.playing"):
        page.locator("#play").click()
    until(page, "ecs.playing")


def select(page, kind):
    """Click the first one of a kind that nothing covers; returns whom the page has selected then."""
    page.locator("[data-eye=top]").click()
    time.sleep(1)  # the camera flies
    for uid in page.evaluate(f"ecs.uids('{kind}')"):
        at = page.evaluate(f"ecs.screen({uid})")
        if at and page.evaluate("([x, y]) => document.elementFromPoint(x, y)?.id", [at["x"], at["y"]]) == "canvas":
            page.mouse.click(at["x"], at["y"])
            until(page, "ecs.selected !== null")
            return page.evaluate("ecs.selected")
    raise AssertionError(f"no {kind} in sight")


def test_frames_arrive_and_animals_move_on_the_screen(browser, park):
    with opened(browser, park.address) as page:
        play(page)
        before, frames, tick = scene(page), page.evaluate("ecs.frames"), page.evaluate("ecs.tick")
        until(page, f"ecs.frames > {frames + 5} && ecs.tick > {tick + 5}")
        moved = (abs(scene(page) - before).max(2) > 0.1).mean()
        assert moved > 0.002
        counts = page.evaluate("ecs.counts")
        assert list(counts) == ["grass", "deer", "wolf"]
        assert min(counts.values()) > 0
        assert page.title().startswith("Grass, deer and wolves")
        until(page, "document.querySelectorAll('#charts canvas').length >= 2")


def test_a_paused_world_stands_still_and_a_step_is_one_tick(browser, park):
    with opened(browser, park.address) as page:
        pause(page)
        tick, before = page.evaluate("ecs.tick"), scene(page)
        time.sleep(0.5)
        assert page.evaluate("ecs.tick") == tick
        assert (abs(scene(page) - before) > 0.05).mean() == 0
        page.locator("#step").click()
        until(page, f"ecs.tick === {tick + 1}")
        page.locator("#canvas").focus()
        page.keyboard.press(".")
        until(page, f"ecs.tick === {tick + 2}")
        page.keyboard.press("Space")
        until(page, f"ecs.playing && ecs.tick > {tick + 3}")


def test_a_clicked_animal_shows_its_life_and_its_nervous_system(browser, park):
    with opened(browser, park.address) as page:
        pause(page)
        uid = select(page, "deer")
        panel = page.locator("#organism")
        panel.locator(".who").wait_for()
        assert f"#{uid}" in panel.locator(".who").inner_text()
        facts = dict(zip(panel.locator("dt").all_inner_texts(), panel.locator("dd").all_inner_texts(), strict=True))
        assert {"age", "energy", "happiness", "sex", "born", "reward"} <= set(facts)
        assert facts["energy"].endswith("/ 1")
        words = panel.locator(".nerves text").all_text_contents()
        assert {"reflex", "policy", "happiness", "walk", "left", "eat", "energy"} <= set(words)
        assert panel.locator(".nerves").get_attribute("aria-label") == "Nervous system: 14 sensors, 7 actions"
        page.keyboard.press("n")
        until(page, f"ecs.selected !== {uid} && ecs.messages.organism > 1")
        page.keyboard.press("Escape")
        until(page, "ecs.selected === null")


def test_what_is_done_to_the_world_happens_and_is_noted(browser, park):
    with opened(browser, park.address) as page:
        pause(page)
        page.locator("#tab-act").click()
        deer = page.evaluate("ecs.counts.deer")
        page.get_by_label("Kind to place").select_option("deer")
        page.get_by_label("How many").fill("500")
        page.get_by_role("button", name="At random places").click()
        page.locator("#act .log li.info").wait_for()
        assert page.locator("#act .log li").first.inner_text().endswith("add 500 deer")
        page.locator("#step").click()
        until(page, f"ecs.counts.deer > {deer + 350}")

        uid = select(page, "deer")
        page.locator("#organism .who").wait_for()
        page.locator("#tab-act").click()
        page.get_by_role("button", name="Remove the selected one").click()
        until(page, "document.querySelectorAll('#act .log li').length === 2")
        tick = page.evaluate("ecs.tick")
        page.locator("#step").click()
        until(page, f"ecs.tick === {tick + 1} && document.querySelector('#organism .died')?.textContent.includes('removed')")
        assert uid not in page.evaluate("ecs.uids('deer', 10000)")

        page.get_by_label("Parameter").fill("species.wolf.reproduction.rate")
        page.get_by_label("New value").fill("-1")
        page.get_by_role("button", name="Change").click()
        time.sleep(0.5)
        assert page.evaluate("ecs.acts") == 2  # the browser itself refuses what is below the bound
        page.get_by_label("New value").fill("0.5")
        page.get_by_role("button", name="Change").click()
        until(page, "document.querySelector('#act .log li').textContent.includes('species.wolf.reproduction.rate = 0.5')")


def test_colours_themes_and_help_by_keyboard_on_a_phone(browser, park):
    with opened(browser, park.address, 390, 844, color_scheme="dark", has_touch=True) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        assert page.evaluate("document.documentElement.dataset.shade") == "dark"
        ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
        page.locator("#canvas").focus()
        page.keyboard.press("t")
        assert page.evaluate("document.documentElement.dataset.shade") == "light"
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") != ground
        page.keyboard.press("c")
        assert page.locator("#colour").input_value() == "energy"
        play(page)
        until(page, "/deer/.test(document.querySelector('#ramp').textContent)")
        page.keyboard.press("?")
        assert page.locator("#help").is_visible()
        assert "play or pause" in page.locator("#help").inner_text()
        page.keyboard.press("Escape")
        assert not page.locator("#help").is_visible()
        for button in page.locator("button:visible").all():
            assert button.inner_text().strip() or button.get_attribute("aria-label")


def test_the_page_says_when_the_run_has_ended(browser):
    with watched("predator-prey", *SMALL, "--policies", "random", "--ticks", "30") as run, opened(browser, run.address) as page:
        until(page, "ecs.tick === 30 && !document.querySelector('#notice').hidden")
        assert "has ended" in page.locator("#notice").inner_text()
        run.process.terminate()
        until(page, "ecs.ended")


def test_a_recorded_run_is_scrubbed_and_what_was_not_recorded_is_filled_in(browser, tmp_path):
    words = ["run", "predator-prey", *SMALL, "--policies", "random", "--ticks", "60", "--out", str(tmp_path / "run"), "--quiet"]
    subprocess.run([sys.executable, "-c", MAIN, *words], check=True, capture_output=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
    with watched(str(tmp_path / "run")) as run, opened(browser, run.address) as page:
        assert page.evaluate("ecs.mode") == "replay"
        assert not page.locator("#tab-act").is_visible()
        pause(page)
        for tick in (43, 7):
            page.get_by_label("Time, in ticks").evaluate(f"slider => {{ slider.value = {tick}; slider.dispatchEvent(new Event('input')) }}")
            until(page, f"ecs.tick === {tick} && document.querySelector('#tick').textContent === '{tick}'")
        uid = select(page, "deer")
        panel = page.locator("#organism")
        panel.locator(".note").wait_for()
        assert f"#{uid}" in panel.locator(".who").inner_text()
        assert panel.locator(".nerves").count() == 0
        panel.get_by_role("button", name="Fill in").click()
        panel.locator(".nerves").wait_for(timeout=60_000)
