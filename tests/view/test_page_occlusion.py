"""What stands between the camera and the organism that is followed fades around it, in a real browser."""

from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, opened, pause, scene

pytestmark = IN_A_BROWSER
YARD = """
format = 1
name = "yard"
space = { size = [20.0, 20.0], edges = "walls" }
[objects.fence]
color = "#ee2211"
at = [[10.0, 1.0], [10.0, 4.0], [10.0, 7.0], [10.0, 10.0], [10.0, 13.0], [10.0, 16.0]]
body = { shape = "box", size = [20.0, 0.2, 9.0], solid = false }
[species.eel]
count = 3
color = "#2244ee"
body = { radius = 0.5 }
locomotion = { speed = { rest = 0.0 } }
actions = { speed = ["rest"] }
always_on = ["rest"]
"""


def seen(page, uid, reach=6):
    """The share of what is not fence around an organism, in the picture of the scene."""
    at, box = page.evaluate(f"ecs.screen({uid})"), page.locator("#canvas").bounding_box()
    x, y = round(at["x"] - box["x"]), round(at["y"] - box["y"])
    around = scene(page, 0, 0)[y - reach : y + reach, x - reach : x + reach]
    return float((around[..., 0] < around[..., 2] + 0.3).mean())  # fences are orange


def test_what_hides_the_followed_organism_fades_around_it(browser, tmp_path):
    (tmp_path / "yard.toml").write_text(YARD)
    with (
        served("watch", str(tmp_path / "yard.toml"), "--seed", "1") as server,
        opened(browser, server.address()) as page,
    ):
        pause(page)
        page.locator("[data-eye=side]").click()
        page.locator("#canvas").focus()
        page.keyboard.press("n")
        until(page, "ecs.selected !== null && ecs.still")
        uid = page.evaluate("ecs.selected")
        assert seen(page, uid) < 0.05  # behind a fence
        page.locator("[data-eye=follow]").click()
        until(page, "document.querySelector('[data-eye=follow]').ariaPressed === 'true' && ecs.still")
        assert seen(page, uid) > 0.5
        page.locator("[data-eye=side]").click()
        until(page, "document.querySelector('[data-eye=side]').ariaPressed === 'true' && ecs.still")
        assert seen(page, uid) < 0.05
