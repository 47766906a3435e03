"""Take pictures of worlds in two versions of the viewer, and put them side by side on one sheet per world.

    python -m tools.picture_sheet FOLDER --before TREE [WORLD …]

Both versions show the same seed, tick and camera. TREE is a checkout of the earlier version. Pictures go to FOLDER
and are kept there; sheets go to docs/img/before. Needs playwright and Chromium.
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from ecs_eco.config import load
from ecs_eco.config.shipped import shipped
from ecs_eco.testing.browser import launched, served, until
from tools.land import SIZES, six
from tools.ten_seconds import go_to, still

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "img" / "before"
SEED = "1"
TICKS = {  # with light, where there are days
    "predator-prey": 100,
    "reflexes": 100,
    "island": 75,
    "diel-migration": 75,
    "lamb": 100,
    "examples/meadow.toml": 100,
    "six": 100,
}
VIEWS = {  # camera, theme, size of the window
    "near": ("near", "light", "1440"),
    "dark": ("near", "dark", "1440"),
    "far": ("side", "light", "1440"),
    "top": ("top", "light", "1440"),
    "wide": ("side", "light", "1920"),
    "phone": ("side", "light", "phone"),
}
APART = 1.5  # smallest distance between two bodies across the view, in sums of their radii
NEAREST, ASIDE = 9.0, 1.9  # distance of the eye in radii of the largest body, and in distances between bodies
HIGH = 0.35  # height of the eye as a share of that distance
ROWS = (("near", "dark"), ("far", "top"), ("wide", "phone"))
CARDS = """([hidden, phone]) => {
  const knobs = document.getElementById("knobs");
  if (knobs) knobs.open = !phone;  // as a page of this size opens
  for (const one of document.querySelectorAll("#legend, .topright, #knobs, #notice, #dial"))
    one.style.visibility = hidden ? "hidden" : "";
}"""
SMALL = {"width": 870, "height": 530}  # [px] of the window while time passes, which is quicker
WIDE, TALL, GAP, HEAD = 1740, 2000, 6, 20  # [px] of a sheet and at most, between pictures, of a caption
QUALITY = 60


def group(places: dict[str, np.ndarray], radii: dict[str, float]) -> list[float]:
    """Return a camera position and its target that show one organism of each species, close to each other but
    apart."""
    order = sorted(places, key=lambda name: len(places[name]))
    best, near = np.inf, np.zeros((1, 3))
    for first in places[order[0]]:
        chosen, sizes = [first], [radii[order[0]]]
        for name in order[1:]:
            far = np.linalg.norm(places[name] - first, axis=1)
            for one, r in zip(chosen, sizes, strict=True):
                apart = np.abs(places[name][:, 0] - one[0]) > APART * (r + radii[name])
                far = np.where(apart, far, np.inf)
            chosen.append(places[name][np.argmin(far)])
            sizes.append(radii[name])
            if far.min() >= best:
                break
        else:
            best, near = np.linalg.norm(chosen - first, axis=1).max(), np.array(chosen)
    target = (near.max(0) + near.min(0)) / 2
    d = max(NEAREST * max(radii.values()), ASIDE * best)
    x, y, z = target.tolist()
    return [x, y - d, z + HIGH * d, x, y, z, 0, 0]


def places_of(page: Any, names: list[str]) -> dict[str, np.ndarray]:
    """Return the positions of up to 2,000 organisms of each living species."""
    code = "name => ecs.uids(name, 2000).map((uid) => ecs.place(uid))"
    found = {name: np.array(page.evaluate(code, name)) for name in names}
    return {name: places for name, places in found.items() if len(places)}


def look(page: Any, camera: str, eye: list[float]) -> None:
    """Move the camera, and wait for the picture."""
    if camera == "near":
        page.evaluate("eye => { location.hash = `eye=${eye.join()}&n=${Math.random()}` }", eye)
    else:
        page.locator(f"[data-eye={camera}]").click()
    page.wait_for_timeout(1000)
    page.mouse.move(0, 0)
    page.evaluate("document.activeElement.blur()")
    until(page, "ecs.still", 600)


def opened(browser: Any, address: str) -> Any:
    """Return the small page of a world, without hints and without flights of the camera."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, reduced_motion="reduce")
    page.set_default_timeout(600_000)
    page.add_init_script("""localStorage.setItem("ecs-eco-hints", '["select", "pause", "why"]')""")
    page.goto(address)
    until(page, "ecs.frames > 0 && ecs.connected && ecs.messages.state > 0", 600)
    still(page)
    page.set_viewport_size(SMALL)
    return page


def take(browser: Any, tree: Path, world: str, path: Path, folder: Path) -> None:
    """Save all pictures of a world in one version, and the positions that they show."""
    folder.mkdir(parents=True, exist_ok=True)
    kinds = load(path).species
    with patch.dict(os.environ, PYTHONPATH=str(tree)), served("watch", str(path), "--seed", SEED) as run:
        page = opened(browser, run.address())
        go_to(page, TICKS[world])
        show(page, kinds, folder)
        page.close()


def show(page: Any, kinds: dict[str, Any], folder: Path) -> None:
    """Save all pictures of the tick shown, the close ones without cards, and the positions in x and y."""
    places = places_of(page, list(kinds))
    eye = group(places, {name: kinds[name].body.radius for name in places})
    for view, (camera, theme, size) in VIEWS.items():
        page.set_viewport_size(dict(zip(("width", "height"), SIZES[size], strict=True)))
        page.emulate_media(color_scheme=theme)
        page.evaluate(CARDS, [camera == "near", size == "phone"])
        look(page, camera, eye)
        (page.locator("#canvas") if size == "1440" else page).screenshot(path=folder / f"{view}.png")
        print(folder.parent.name, folder.name, view, flush=True)
    state = {name: np.round(places[name][:, :2], 3).tolist() for name in places}
    (folder / "state.json").write_text(json.dumps(state))


def sheet(world: str, before: Path, now: Path, file: Path) -> None:
    """Write one image with each view in both versions, and with captions."""
    from PIL import Image, ImageDraw, ImageFont

    font, image = ImageFont.load_default(13), Image.new("RGB", (WIDE, TALL), "white")
    draw, y = ImageDraw.Draw(image), 0
    for row in ROWS:
        folders = {"before": before, "now": now}
        files = {f"{view}, {word}": folders[word] / f"{view}.png" for view in row for word in folders}
        pictures = {words: Image.open(path).convert("RGB") for words, path in files.items()}
        tall = int((WIDE - 3 * GAP) / sum(one.width / one.height for one in pictures.values()))
        x, y = 0, y + HEAD
        for words, one in pictures.items():
            draw.text((x, y - HEAD + 2), words, "black", font)
            small = one.resize((int(tall * one.width / one.height), tall))
            image.paste(small, (x, y))
            x += small.width + GAP
        y += tall + GAP
    image = image.crop((0, 0, WIDE, y - GAP))
    image.save(file, quality=QUALITY, method=6)
    same = (before / "state.json").read_text() == (now / "state.json").read_text()
    state = "the same positions" if same else "other positions"
    print(f"{file.name}: tick {TICKS[world]}, {state}, {file.stat().st_size / 1000:.0f} kB", flush=True)


def main() -> int:
    """Take the missing pictures of the requested worlds, or of all, and write their sheets."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("worlds", nargs="*", metavar="WORLD")
    parser.add_argument("--before", type=Path, required=True, metavar="TREE")
    words = parser.parse_args()
    IMAGES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as made, launched() as browser:
        own = Path(made) / "six.toml"
        own.write_text(six())
        for world in words.worlds or TICKS:
            path = own if world == "six" else shipped().get(world, ROOT / world)  # one file for both versions
            before, now = (words.folder / version / path.stem for version in ("before", "now"))
            for folder, tree in ((before, words.before.resolve()), (now, ROOT)):
                if not (folder / "state.json").exists():
                    take(browser, tree, world, path, folder)
            sheet(world, before, now, IMAGES / f"{path.stem.replace('-', '_')}.webp")
    return 0


if __name__ == "__main__":
    sys.exit(main())
