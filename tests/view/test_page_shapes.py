"""Capsules and boxes on the page, in a real browser."""

import numpy as np
from PIL import Image

from ecs_eco.testing.browser import launched, served, until
from tests.view.pages import IN_A_BROWSER, opened, pause, scene

pytestmark = IN_A_BROWSER
YARD = """
format = 1
name = "yard"
space = {{ size = [20.0, 20.0], edges = "walls" }}
[objects.fence]
color = "#ee2211"
{fences}
body = {{ shape = "box", size = [1.0, 1.0, 0.5], solid = true }}
[species.eel]
count = 3
color = "#2244ee"
body = {{ shape = "capsule", radius = 0.5, length = 5.0 }}
locomotion = {{ speed = {{ rest = 0.0 }} }}
actions = {{ speed = ["rest"] }}
automatic = ["rest"]
"""


def _red(tmp_path, browser, name, fences):
    """Return what share of the scene is as red as a fence, shone on or not."""
    file = tmp_path / f"{name}.toml"
    file.write_text(YARD.format(fences=fences))
    with served("watch", str(file), "--seed", "1") as server, opened(browser, server.address()) as page:
        pause(page)
        page.locator("[data-eye=top]").click()  # all is equally far, and no eel stands before a fence
        until(page, "ecs.counts.fence > 0 && ecs.counts.eel === 3 && ecs.still")
        picture = scene(page)
        Image.fromarray((np.clip(picture, 0, 1) * 255).astype(np.uint8)).save(tmp_path / f"{name}.png")
    r, g, b = picture[..., 0], picture[..., 1], picture[..., 2]
    return float(((r > 0.45) & (r > 2 * g) & (r > 2 * b)).mean())


def test_a_fence_is_drawn_as_long_as_it_is(tmp_path):
    with launched() as browser:
        short = _red(tmp_path, browser, "short", "between = [[9.0, 10.0, 11.0, 10.0]]")
        both = _red(tmp_path, browser, "both", "between = [[2.0, 6.0, 18.0, 6.0], [9.0, 10.0, 11.0, 10.0]]")
    assert short > 5e-4
    assert 8 < both / short < 10.5  # 2 m, and 2 + 16 m, of which an eel covers a part
