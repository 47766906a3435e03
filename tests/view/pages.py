"""What tests of the page do in a browser: open it, let time pass, select, read."""

import io
from contextlib import contextmanager
from importlib.util import find_spec

import pytest

from ecs_eco.testing.browser import chromium, until

IN_A_BROWSER = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("playwright") is None, reason='no playwright here: pip install -e ".[dev]"'),
    pytest.mark.skipif(chromium() is None, reason="no Chromium here (Debian: apt-get install chromium)"),
]
PARK = {
    "space.size": "[60, 60]",
    "species.grass.count": 300,
    "species.deer.count": 80,
    "species.wolf.count": 12,
    "species.wolf.diet.0.chance": 0,
}
for animal in ("deer", "wolf"):  # nobody is eaten, starves or is born: tests may take their time
    zero = ("metabolism.basal", "locomotion.cost.walk", "locomotion.cost.run", "reproduction.rate")
    PARK |= {f"species.{animal}.{key}": 0 for key in zero} | {f"species.{animal}.lethal.1.max": 1e9}
SMALL = [
    *(word for key, value in PARK.items() for word in ("--set", f"{key}={value}")),
    "--policies",
    "random",
    "--seed",
    "3",
]
FORGET_THEME = """() => {
  localStorage.removeItem("ecs-eco-theme");
  delete document.documentElement.dataset.theme;
  document.documentElement.dispatchEvent(new Event("themechange"));
}"""
OF_RUN = """([hello, series, range, away]) => Promise.all([import('/flows.js'), import('/series.js')]).then(
    ([{ Flows }, { grouped }]) => new Flows({ hello, ticks: series.tick, range: () => range ?? [-1, 1e9],
      away: new Set(away ?? []), shared: false, colourOf: () => "#123456",
      lines: { causes: {}, flows: {}, ...grouped(series) } }).found())"""
WIDE, PHONE = {"width": 1000, "height": 640}, {"width": 390, "height": 844}
LOCAL = ("data:", "blob:")


@contextmanager
def opened(browser, address):
    """A page that shows the world; at its end, nothing was complained of and nothing left the machine."""
    context = browser.new_context(viewport=WIDE, has_touch=True)
    context.set_default_timeout(180_000)
    page, problems, asked = context.new_page(), [], []
    page.on(
        "console",
        lambda message: problems.append(message.text) if message.type in ("error", "warning") else None,
    )
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda socket: asked.append(socket.url))
    try:
        page.goto(address)
        until(page, "ecs.frames > 0 && ecs.renders > 0 && ecs.connected && ecs.messages.state > 0")
        yield page
        assert len(asked) > 10
        assert [
            url for url in asked if not url.startswith(LOCAL) and url.split("/")[2] != address.split("/")[2]
        ] == []
        # software rendering says so of screenshots
        assert [text for text in problems if "GPU stall" not in text] == []
    finally:
        context.close()


def pause(page):
    """Stop, and wait until the scene shows the last tick that was."""
    if page.evaluate("ecs.playing"):
        page.locator("#play").click()
    until(page, "!ecs.playing && ecs.still")


def passed(page):
    """One tick on: what was asked for holds."""
    tick = page.evaluate("ecs.tick")
    page.locator("#step").click()
    until(page, f"ecs.tick === {tick + 1} && ecs.still")


def play(page):
    if not page.evaluate("ecs.playing"):
        page.locator("#play").click()
    until(page, "ecs.playing")


def scene(page, left=180, right=200):
    """The pixels of the scene without what lies over it and without margins [px]: f32[height, width, 3]."""
    from matplotlib.image import imread

    box = page.locator("#canvas").bounding_box()
    alone = "body * { visibility: hidden !important } #canvas { visibility: visible !important }"
    clip = box | {"x": box["x"] + left, "width": box["width"] - left - right}
    return imread(io.BytesIO(page.screenshot(clip=clip, style=alone)))[..., :3]


def in_sight(page, kind):
    """An organism that nothing covers, and where it is on the screen; the page is to look from above."""
    for uid in page.evaluate(f"ecs.uids('{kind}')"):
        at = page.evaluate(f"ecs.screen({uid})")
        if (
            at
            and page.evaluate("([x, y]) => document.elementFromPoint(x, y)?.id", [at["x"], at["y"]])
            == "canvas"
        ):
            return uid, at["x"], at["y"]
    raise AssertionError(f"no {kind} in sight")


def select(page, kind):
    """Click one of a kind; returns whom the page has selected then (a neighbour, it may be)."""
    page.locator("[data-eye=top]").click()
    until(page, "ecs.still")
    _, x, y = in_sight(page, kind)
    page.mouse.click(x, y)
    until(page, "ecs.selected !== null")
    page.locator("#organism .who").wait_for()
    return page.evaluate("ecs.selected")


def facts(panel):
    return dict(
        zip(panel.locator("dt").all_inner_texts(), panel.locator("dd").all_inner_texts(), strict=True)
    )


SETTLED = """async () => { // colors that fade have their last value, unless they take more than ten seconds
  for (let frame = 0; frame < 2; frame += 1) await new Promise(requestAnimationFrame);
  const ends = (one) => one.effect.getComputedTiming().endTime !== Infinity;
  const ended = Promise.allSettled(document.getAnimations().filter(ends).map((one) => one.finished));
  await Promise.race([ended, new Promise((done) => setTimeout(done, 10_000))]);
}"""


def violations(page):
    """Return the rules of axe that a page breaks, each with the first elements that break it."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe-playwright-python here")
    page.evaluate(SETTLED)
    found = axe.Axe().run(page).response["violations"]
    return [(one["id"], [node["html"][:90] for node in one["nodes"][:3]]) for one in found]
