"""Take the screenshots of the viewer, of README and of the gallery, and write them to docs/img.

    python -m tools.screenshots [NAME …]

Needs playwright and Chromium (Debian: apt-get install chromium). A live world stops near the requested tick,
because the page's delay in stopping it varies.
"""

import argparse
import io
import sys
import tempfile
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from ecs_eco.config.shipped import shipped
from ecs_eco.testing.browser import launched, served, until
from ecs_eco.view.export import MOST
from tools.gallery import TICKS, save

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "img"
SIZE = {"width": 1280, "height": 800}
LARGEST = 300_000  # [bytes]
STILL, NEARER = (960, 600), 900  # [px] of a picture in the gallery; [px] of the wheel
NOON = {"island": 375}  # a tick with light, if the middle of the run is at night
STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; box-sizing: border-box; width: 1012px; margin: 0 auto; padding: 32px; }
h1 { margin: 0 0 16px; border-bottom: 1px solid #d1d9e0; } p { margin: 0 0 16px; } img { max-width: 100%; }
pre { padding: 16px; background: #f6f8fa; overflow: auto; } code { font-size: 85%; }
"""


class Shot(NamedTuple):
    """A screenshot: the world, the tick, the coloring, and the actions before it is taken."""

    world: str
    tick: int
    pose: Callable[[Any], None]
    words: tuple[str, ...] = ()
    dark: bool = False
    run: tuple[str, ...] = ()  # record a run first, with these options, then show the recording
    map: bool = False  # whether it shows an archipelago


def select(page: Any, kind: str, nth: int = 0) -> None:
    """Click a visible organism, and run until its curves take shape."""
    clear = "([x, y]) => document.elementFromPoint(x, y)?.id === 'canvas'"
    seen = [
        at for uid in page.evaluate(f"ecs.uids('{kind}', 400)") if (at := page.evaluate(f"ecs.screen({uid})"))
    ]
    seen = [at for at in seen if page.evaluate(clear, [at["x"], at["y"]])]
    at = min(seen[:60], key=lambda at: abs(at["x"] - 430) + abs(at["y"] - 380)) if nth == 0 else seen[nth]
    page.mouse.click(at["x"], at["y"])
    until(page, "ecs.selected !== null && ecs.messages.organism > 0")


def advance(page: Any, ticks: int) -> None:
    """Run ten times this many ticks, then stop."""
    still(page)
    goal = page.evaluate("ecs.tick") + ticks
    page.locator("#canvas").focus()
    for _ in range(ticks // 10):
        page.keyboard.press("Shift+Period")  # ten ticks
    until(page, f"ecs.tick === {goal} && ecs.still", 1800)


def survivor(page: Any, kind: str, ticks: int = 40) -> None:
    """Select an organism that lives for a given number of ticks, and show its curves."""
    for nth in range(20):
        select(page, kind, nth)
        for _ in range(ticks // 10):
            advance(page, 10)
        if page.locator("#organism .state:not(.dead)").count():
            return
        page.keyboard.press("Escape")
    raise RuntimeError(f"no {kind} lived for {ticks} ticks")


def still(page: Any) -> None:
    """Stop, and wait until the picture is stable."""
    if page.evaluate("ecs.playing"):
        page.locator("#play").click()
    until(page, "!ecs.playing && ecs.still")


def deer(page: Any) -> None:
    """Follow a deer that sees a wolf, with its path."""
    for nth in range(40):
        select(page, "deer", nth)
        advance(page, 10)
        if (
            "(an enemy)" in page.locator("#organism").inner_text()
            and page.locator(".state:not(.dead)").count()
        ):
            break
        page.keyboard.press("Escape")
    else:
        raise RuntimeError("none of 40 deer saw a wolf and lived on")
    page.keyboard.press("f")
    page.wait_for_timeout(1500)  # [ms] of the flight
    until(page, "ecs.still")


def family(page: Any) -> None:
    """Show the family tree of a deer that is not a founder."""
    for nth in range(40):
        select(page, "deer", nth)
        tree = page.locator("#organism .tree")
        tree.evaluate("tree => { tree.open = true }")
        until(page, "document.querySelector('.tree-node.focal')?.dataset.key === String(ecs.selected)")
        if page.locator(".tree-node").count() > 4:
            break
        page.keyboard.press("Escape")
    tree.evaluate("tree => tree.scrollIntoView({block: 'center'})")
    until(page, "ecs.still")


def genes(page: Any) -> None:
    """Show goats colored by a gene."""
    colours = page.locator("#colour option").evaluate_all("all => all.map(option => option.value)")
    page.locator("#colour").select_option(next(name for name in colours if name.startswith("gene:")))
    page.locator("[data-eye=top]").click()
    until(page, "ecs.still")


def lamb(page: Any) -> None:
    """Show a lamb's nervous system."""
    survivor(page, "lamb")


def sea(page: Any) -> None:
    """Show the water at night, with the curves of the preceding days."""
    until(page, "ecs.still")


def what_if(page: Any) -> None:
    """Show, side by side, the same world without wolves from this tick on."""
    page.locator("#whatif").click()
    page.get_by_role("button", name="without wolf").click()
    until(page, "ecs.second && ecs.second.frames > 0", 600)
    advance(page, 140)
    until(page, "ecs.still && ecs.second.still && ecs.second.tick === ecs.tick", 600)


def replayed(page: Any) -> None:
    """Show a wolf's focal sample in a recorded run at a chosen tick."""
    page.get_by_label("Time, in ticks").evaluate(
        "slider => { slider.value = 420; slider.dispatchEvent(new Event('input')) }"
    )
    until(page, "ecs.tick === 420 && ecs.still")
    for nth in range(40):
        select(page, "wolf", nth)
        until(page, "document.querySelector('#organism .who')?.textContent.includes(`#${ecs.selected}`)")
        if not page.get_by_role("button", name="Fill in").count():
            break
        page.keyboard.press("Escape")
        until(page, "ecs.selected === null")
    until(page, "ecs.still")


SHOTS = {
    "page_predator_prey": Shot("predator-prey", 400, deer),
    "page_family_tree": Shot("predator-prey", 600, family),
    "page_reflexes": Shot("reflexes", 300, genes, dark=True),
    "page_lamb": Shot("lamb", 200, lamb),
    "page_diel_migration": Shot("diel-migration", 530, sea),
    "page_replay": Shot(
        "predator-prey",
        0,
        replayed,
        dark=True,
        run=("--ticks", "600", "--record", "focal=50", "--no-report", "--quiet"),
    ),
    "page_what_if": Shot("predator-prey", 60, what_if),
    "page_islands": Shot(
        "examples/islands.toml",
        0,
        lambda page: None,
        map=True,
        run=("--ticks", "400", "--no-report", "--quiet"),
    ),
}


@contextmanager
def page_of(browser: Any, shot: Shot, address: str) -> Any:
    """Yield a world's page, stopped at its tick."""
    context = browser.new_context(viewport=SIZE, color_scheme="dark" if shot.dark else "light")
    context.set_default_timeout(600_000)
    context.add_init_script("""localStorage.setItem("ecs-eco-hints", '["select", "pause", "why"]')""")
    page = context.new_page()
    try:
        page.goto(address)
        if shot.map:
            until(page, "ecs.maps > 0 && ecs.connected")
            yield page
            return
        until(page, "ecs.frames > 0 && ecs.connected && ecs.messages.state > 0", 600)
        still(page)
        advance(page, max(0, shot.tick - page.evaluate("ecs.tick")) // 10 * 10)
        yield page
    finally:
        context.close()


def take(browser: Any, name: str, shot: Shot) -> Path:
    """Take one screenshot; return its path."""
    with tempfile.TemporaryDirectory() as folder:
        what = shot.world
        if shot.run:
            what = f"{folder}/run"
            _run(shot, what)
        with served("watch", what, *shot.words) as run, page_of(browser, shot, run.address()) as page:
            shot.pose(page)
            page.mouse.move(0, 0)
            page.evaluate("document.activeElement.blur()")
            path = IMAGES / f"{name}.png"
            path.write_bytes(small(page.screenshot()))
    return path


def of_gallery(browser: Any, world: str) -> Path:
    """Take the gallery's picture of a world, about halfway through its recorded run; return its path."""
    from PIL import Image

    path = IMAGES / "gallery" / f"{world.replace('-', '_')}.webp"
    path.parent.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
        tick = NOON.get(world, TICKS[world] // 2)
        page.goto(f"{save(world, Path(folder), MOST).as_uri()}#tick={tick}")
        until(page, f"ecs.tick === {tick} && ecs.frames > 0 && ecs.still", 600)
        page.add_style_tag(content="#cameras, #legend, #tip, #scale, #dial { visibility: hidden }")
        page.mouse.move(430, 400)
        page.mouse.wheel(0, -NEARER)
        page.wait_for_timeout(1500)  # [ms] of the movement
        until(page, "ecs.still")
        png = page.locator("#stage").screenshot()
        page.close()
    picture = Image.open(io.BytesIO(png)).convert("RGB")
    width = min(picture.width, picture.height * STILL[0] // STILL[1])
    height, left = width * STILL[1] // STILL[0], (picture.width - width) // 2
    top = (picture.height - height) // 2
    picture.crop((left, top, left + width, top + height)).resize(STILL, Image.Resampling.LANCZOS).save(
        path, quality=80, method=6
    )
    return path


def readme(browser: Any) -> Path:
    """Take a picture of the first screen of README, as wide as GitHub shows it; return its path."""
    from markdown_it import MarkdownIt

    text = MarkdownIt("commonmark").enable("table").render((ROOT / "README.md").read_text(encoding="utf-8"))
    page, path = browser.new_page(viewport={"width": 1440, "height": 900}), IMAGES / "readme.png"
    with tempfile.TemporaryDirectory() as folder:
        (file := Path(folder) / "readme.html").write_text(
            f"<meta charset=utf-8><base href='{ROOT.as_uri()}/'><style>{STYLE}</style>{text}",
            encoding="utf-8",
        )
        page.goto(file.as_uri())
        page.wait_for_timeout(3000)  # [ms] of the moving picture
        path.write_bytes(small(page.screenshot()))
    return path


def _run(shot: Shot, out: str) -> None:
    import subprocess

    from ecs_eco.testing.browser import COMMAND

    subprocess.run([*COMMAND, "run", shot.world, *shot.run, "--out", out], check=True)


def small(png: bytes) -> bytes:
    """Return a picture of at most about `LARGEST` bytes, reduced to 255 colors if it would be larger in full
    color."""
    from PIL import Image

    picture, out = Image.open(io.BytesIO(png)).convert("RGB"), io.BytesIO()
    picture.save(out, "PNG", optimize=True)
    if out.tell() > LARGEST:
        out = io.BytesIO()
        fewer = picture.quantize(255, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        fewer.save(out, "PNG", optimize=True)
    return out.getvalue()


def main() -> int:
    """Take the requested screenshots, or all whose worlds are available."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=", ".join(known := ["readme", *SHOTS, *TICKS])
    )
    there = ["readme", *(name for name, shot in SHOTS.items() if shot.map or shot.world in shipped()), *TICKS]
    names = parser.parse_args().names or there
    if unknown := [name for name in names if name not in known]:
        parser.error(f"{unknown[0]}: there is {', '.join(known)}")
    with launched() as browser:
        for name in names:
            if name in TICKS:
                path = of_gallery(browser, name)
            else:
                path = readme(browser) if name == "readme" else take(browser, name, SHOTS[name])
            print(
                f"{path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path}: "
                f"{path.stat().st_size / 1000:.0f} kB"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
