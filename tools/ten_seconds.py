"""Take the screenshots for the ten-second test, and write them to docs/img/ten_seconds.

    python -m tools.ten_seconds [NAME …]

Shows three worlds at ticks 50 and 500, and after an extinction; docs/explanation/ten_seconds.md asks ten
questions about each. Needs playwright and Chromium (Debian: apt-get install chromium).
"""

import argparse
import io
import sys
from pathlib import Path
from typing import Any, NamedTuple

from ecs_eco.testing.browser import launched, served, until
from tools.screenshots import advance, still

IMAGES = Path(__file__).parents[1] / "docs" / "img" / "ten_seconds"
SIZE = {"width": 1400, "height": 800}
PANELS = 710  # [px] size of the panels, with charts side by side
SHADES = 255
LAST = 6  # number of ticks before a picture, with a frame for each
LONGEST = 4000  # maximum number of ticks until an extinction


class Moment(NamedTuple):
    """A screenshot: the world and its options; the tick, or the species that goes extinct; the selected
    organism's species, and whether to zoom in; the open panel."""

    world: str
    tick: int
    words: tuple[str, ...] = ("--seed", "1")
    extinct: str = ""
    select: str = ""
    near: int = 0
    panel: str = "organism"


def without(*settings: str) -> tuple[str, ...]:
    """Return options that make a species' survival impossible."""
    return ("--seed", "1", *(word for setting in settings for word in ("--set", setting)))


MOMENTS = {
    "predator_prey_50": Moment("predator-prey", 50, select="wolf", near=2),
    "predator_prey_500": Moment("predator-prey", 500, select="deer"),
    "predator_prey_extinct": Moment(
        "predator-prey", 0, without("species.wolf.diet.0.gain=0.05"), "wolf", panel="why"
    ),
    "reflexes_50": Moment("reflexes", 50, select="goat", near=3),
    "reflexes_500": Moment("reflexes", 500, select="goat"),
    "reflexes_extinct": Moment(
        "reflexes",
        0,
        without(
            *(f"species.green.{key}=0" for key in ("count", "reproduction.rate", "reproduction.seed_rain"))
        ),
        "goat",
        panel="why",
    ),
    "sea_50": Moment("diel-migration", 50, select="krill", near=1),
    "sea_500": Moment("diel-migration", 500, select="copepod"),
    "sea_extinct": Moment(
        "diel-migration",
        0,
        without(
            "species.phytoplankton.metabolism.photosynthesis=0",
            "species.phytoplankton.reproduction.immigration=0",
        ),
        "copepod",
        panel="why",
    ),
}


def go_to(page: Any, tick: int) -> None:
    """Show this tick; go back if the world has passed it."""
    if page.evaluate("ecs.tick") > tick:
        page.get_by_label("Time, in ticks").evaluate(
            "(slider, tick) => { slider.value = tick; slider.dispatchEvent(new Event('input')); "
            "slider.dispatchEvent(new Event('change')) }",
            tick,
        )
        until(page, f"ecs.tick === {tick} && ecs.still", 600)
    left = tick - page.evaluate("ecs.tick")
    advance(page, max(0, left - LAST) // 10 * 10)
    while page.evaluate("ecs.tick") < tick:
        one(page)


def die_out(page: Any, name: str) -> None:
    """Run until shortly after a species goes extinct."""
    while page.evaluate(f"ecs.counts['{name}']"):
        if page.evaluate("ecs.tick") > LONGEST:
            raise RuntimeError(f"{name} did not go extinct")
        advance(page, 20)
    for _ in range(LAST):
        one(page)


def one(page: Any) -> None:
    """Run one tick with a separate frame, so that the marks show the latest ticks."""
    goal = page.evaluate("ecs.tick") + 1
    page.keyboard.press("Period")
    until(page, f"ecs.tick === {goal} && ecs.still", 600)


def choose(page: Any, kind: str, near: int) -> None:
    """Select an organism of the species that sees another organism, and zoom in."""
    for uid in page.evaluate(f"ecs.uids('{kind}', 60)"):
        page.evaluate(f"location.hash = 'uid={uid}&tab=organism'")
        until(page, f"ecs.selected === {uid} && ecs.still && ecs.messages.organism > 0")
        if page.evaluate("ecs.over.seen + ecs.over.rays") and page.locator("#organism .nerves").count():
            break  # newborns have no readings yet
    if near:
        page.locator("[data-eye=follow]").click()
        until(page, "ecs.still")
        page.locator("#canvas").focus()
        for _ in range(near):
            page.keyboard.press("i")
        until(page, "ecs.still")


def take(browser: Any, moment: Moment) -> bytes:
    """Take one picture."""
    with served("watch", moment.world, *moment.words) as run:
        context = browser.new_context(viewport=SIZE, color_scheme="light")
        context.set_default_timeout(600_000)
        context.add_init_script(
            'localStorage.setItem(\'ecs-eco-hints\', \'["select", "pause", "why"]\');'
            f"localStorage.setItem('ecs-eco-side', '{PANELS}')"
        )
        page = context.new_page()
        page.goto(run.address())
        until(page, "ecs.frames > 0 && ecs.connected && ecs.messages.state > 0", 600)
        still(page)
        die_out(page, moment.extinct) if moment.extinct else go_to(page, moment.tick)
        if moment.select:
            choose(page, moment.select, moment.near)
        page.locator(f"#tab-{moment.panel}").click()
        page.mouse.move(0, 0)
        page.evaluate("document.activeElement.blur()")
        if moment.panel == "why":
            until(page, "ecs.messages.why > 0 && document.querySelector('.account section')", 600)
        page.wait_for_timeout(1500)
        until(page, "ecs.still")
        png = page.screenshot()
        context.close()
    return small(png)


def small(png: bytes) -> bytes:
    """Return a picture with fewer colors."""
    from PIL import Image

    out = io.BytesIO()
    picture = Image.open(io.BytesIO(png)).convert("RGB")
    fewer = picture.quantize(SHADES, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    fewer.save(out, "PNG", optimize=True)
    return out.getvalue()


def main() -> int:
    """Take the requested screenshots, or all."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(MOMENTS))
    names = parser.parse_args().names or list(MOMENTS)
    if unknown := [name for name in names if name not in MOMENTS]:
        parser.error(f"{unknown[0]}: there is {', '.join(MOMENTS)}")
    IMAGES.mkdir(exist_ok=True)
    with launched() as browser:
        for name in names:
            path = IMAGES / f"{name}.png"
            path.write_bytes(take(browser, MOMENTS[name]))
            print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
