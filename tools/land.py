"""Take pictures of worlds: each species from nearby, the whole world from the side and from above.

    python -m tools.land FOLDER [WORLD …] [--sheet FILE]

Close pictures have no legend, so that a reader can be asked to name what they show. Whole worlds are shown in
both themes and at three window sizes. --sheet makes one image of a close picture of each kind in the folder, in
random order. Needs playwright and Chromium.
"""

import argparse
import math
import random
import sys
import tempfile
from pathlib import Path
from typing import Any

from ecs_eco.config import load
from ecs_eco.testing.browser import launched, served, until
from tools.screenshots import advance, still

TICK = 100
SIZES = {"1440": (1440, 900), "1920": (1920, 1080), "phone": (390, 844)}
BARE = """for (const one of document.querySelectorAll("#legend, .topright, #knobs, #notice, #dial"))
  one.style.visibility = "hidden";"""
FAR, LOW = 11.0, 0.42  # radii of the body from the eye; height of the eye as a share of that distance
ANIMAL = """
body = {{ radius = {radius} }}
metabolism = {{ energy = 0.7, energy_max = 1.0, basal = 0.001 }}
locomotion = {{ speed = {{ still = 0.0, walk = 0.4 }}, cost = {{ walk = 0.0 }}, turn = 0.8 }}
sensors = [{{ kind = "own", property = "energy" }}]
actions = {{ speed = ["walk", "still"], turn = ["left", "none", "right"] }}
default_action = {{ speed = "walk", turn = "none" }}
diet = [{{ eats = "{food}", gain = 0.2 }}]
"""
PLANT = "metabolism = {{ energy = 0.2, energy_max = 0.2 }}\nbody = {{ radius = {radius}, opaque = false }}\n"
SIX = {
    "clover": (300, 0.3, ""),
    "heather": (60, 0.6, ""),
    "hare": (60, 0.3, "clover"),
    "sheep": (30, 0.7, "clover"),
    "beetle": (80, 0.12, "heather"),
    "crow": (30, 0.3, "beetle"),
}


def six() -> str:
    """Return a world file with six species."""
    head = (
        'format = 1\nname = "six"\ntitle = "Six species"\nticks = 200\n'
        '[space]\nsize = [60.0, 60.0]\nedges = "torus"\n'
    )
    return head + "".join(
        f"[species.{name}]\ncount = {n}\n{(ANIMAL if food else PLANT).format(radius=radius, food=food)}"
        for name, (n, radius, food) in SIX.items()
    )


def near(page: Any, folder: Path, world: Path | str) -> None:
    """Take pictures of up to three living organisms of each species from nearby."""
    page.evaluate(BARE)
    page.emulate_media(color_scheme="light")
    for name, kind in load(world).species.items():
        for nth, uid in enumerate(page.evaluate(f"ecs.uids('{name}', 40)")[3:30:13]):
            x, y, z = page.evaluate(f"ecs.place({uid})")
            d = FAR * kind.body.radius
            eye = [x + 0.25 * d, y - 0.9 * d * math.cos(math.asin(LOW)), z + LOW * d, x, y, z, 0, 0]
            page.evaluate("eye => { location.hash = `eye=${eye.join()}&n=${Math.random()}` }", eye)
            page.wait_for_timeout(400)
            shot(page, folder / f"{Path(world).stem}-near-{name}-{nth + 1}.png")


def shot(page: Any, path: Path) -> None:
    """Save a picture of the scene."""
    until(page, "ecs.still", 600)
    page.mouse.move(0, 0)
    page.locator("#canvas").screenshot(path=path)
    print(path.name, flush=True)


def whole(page: Any, folder: Path, world: str) -> None:
    """Take pictures of the whole world from the side and from above, in both themes, at each size."""
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        for shade in ("light", "dark"):
            page.emulate_media(color_scheme=shade, reduced_motion="reduce")
            for eye in ("side", "top"):
                page.locator(f"[data-eye={eye}]").click()
                page.wait_for_timeout(400)
                shot(page, folder / f"{world}-{eye}-{shade}-{size}.png")


def sheet(folder: Path, file: Path, wide: int = 5, size: tuple[int, int] = (320, 200)) -> None:
    """Write one image with a close picture of each kind, in random order; print the kinds in this order."""
    from PIL import Image

    files = {path.stem.rpartition("-")[0]: path for path in sorted(folder.glob("*-near-*.png"))}
    kinds = random.Random(1).sample(sorted(files), len(files))
    image = Image.new("RGB", (wide * size[0], -(-len(kinds) // wide) * size[1]))
    for k, kind in enumerate(kinds):
        with Image.open(files[kind]) as one:
            image.paste(one.convert("RGB").resize(size), (k % wide * size[0], k // wide * size[1]))
    image.save(file)
    print(*(f"{k}: {kind.replace('-near-', ': ')}" for k, kind in enumerate(kinds, 1)), sep="\n")


def main() -> int:
    """Take the pictures of the requested worlds, or of seven, or make a sheet of those in a folder."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("worlds", nargs="*", metavar="WORLD")
    parser.add_argument("--sheet", type=Path, metavar="FILE")
    words = parser.parse_args()
    if words.sheet:
        sheet(words.folder, words.sheet)
        return 0
    words.folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as made, launched() as browser:
        own = Path(made) / "six.toml"
        own.write_text(six())
        shipped = ("predator-prey", "reflexes", "island", "diel-migration", "lamb", "examples/meadow.toml")
        for world in words.worlds or (*shipped, own):
            with served("watch", str(world), "--seed", "1") as run:
                page = browser.new_page(viewport=dict(zip(("width", "height"), SIZES["1440"], strict=True)))
                page.set_default_timeout(600_000)
                page.add_init_script(
                    """localStorage.setItem("ecs-eco-hints", '["select", "pause", "why"]')"""
                )
                page.goto(run.address())
                until(page, "ecs.frames > 0 && ecs.connected && ecs.messages.state > 0", 600)
                still(page)
                advance(page, TICK)
                whole(page, words.folder, Path(world).stem)
                page.set_viewport_size(dict(zip(("width", "height"), SIZES["1440"], strict=True)))
                near(page, words.folder, world)
                page.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
