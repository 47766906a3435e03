"""Roads and areas of land use on the page, in a real browser."""

import numpy as np
from PIL import Image

from ecs_eco.testing.browser import launched, served, until
from tests.view.pages import IN_A_BROWSER, opened, pause, scene

pytestmark = IN_A_BROWSER
PARK = """
format = 1
name = "park"
space = {{ size = [20.0, 20.0], edges = "walls" }}
{more}
[species.oak]
count = 1
color = "#2244ee"
body = {{ radius = 0.1 }}
"""
GROUND = """[terrain]
cell = 1.0
"""
ROAD = (
    GROUND
    + """\
roads = [{ line = [[2.0, 10.0], [18.0, 10.0]], width = 4.0 }]
"""
)
AREA = """[[land_use]]
kind = "harvest"
species = "oak"
rate = 0.0
region = [2.0, 2.0, 18.0, 18.0]
"""


def _picture(tmp_path, browser, name, more):
    file = tmp_path / f"{name}.toml"
    file.write_text(PARK.format(more=more))
    with served("watch", str(file), "--seed", "1") as server, opened(browser, server.address()) as page:
        pause(page)
        until(page, "ecs.counts.oak === 1")
        picture = scene(page)
        Image.fromarray((np.clip(picture, 0, 1) * 255).astype(np.uint8)).save(tmp_path / f"{name}.png")
    return picture


def test_a_road_is_a_strip_of_its_width_and_an_area_has_a_red_border(tmp_path):
    with launched() as browser:
        bare, paved, used = (
            _picture(tmp_path, browser, name, more)
            for name, more in (("bare", GROUND), ("paved", ROAD), ("used", GROUND + AREA))
        )
    differs = np.abs(bare - paved).max(axis=-1) > 0.03
    ground = differs.mean()
    assert 0.01 < ground < 0.3  # 64 of 400 m², of a ground that fills a part of the scene
    r, g, b = (used[..., i] - bare[..., i] for i in range(3))
    red = (r - np.maximum(g, b) > 0.1).mean()
    assert 2e-4 < red < 0.02
