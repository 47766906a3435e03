"""Genes show in the bodies on the page, and the camera enters none, in a real browser."""

from functools import partial

import numpy as np
import pytest

from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, opened, pause, scene

pytestmark = IN_A_BROWSER
YARD = """
format = 1
name = "yard"
space = {{ size = {size}, edges = "walls" }}
[species.goat]
count = 12
color = "#ee2211"
body = {{ radius = 0.5 }}
locomotion = {{ speed = {{ rest = 0.0 }} }}
actions = {{ speed = ["rest"] }}
automatic = ["rest"]
{genome}
"""
GENE = """[species.goat.genome]
alphabet = "ACGT"
genes = [{{ name = "{name}", trait = "{trait}", letters = 1, values = {values} }}]"""


def red(page):
    r, g, b = (scene(page)[..., i] for i in range(3))
    return float((r > np.maximum(g, b) + 0.2).mean())


@pytest.fixture
def yard(tmp_path, browser):
    """Show goats with a gene; return what a function of the page returns."""

    def show(look, size=(20.0, 20.0), more="", **gene):
        file = tmp_path / "yard.toml"
        file.write_text(YARD.format(size=list(size), genome=GENE.format(**gene) if gene else more))
        with served("watch", str(file), "--seed", "1") as run, opened(browser, run.address()) as page:
            pause(page)
            page.locator("[data-eye=top]").click()
            until(page, "ecs.counts.goat === 12 && ecs.still")
            return look(page)

    return show


@pytest.mark.parametrize("size", [(20.0, 20.0), (20.0, 20.0, 5.0)])
def test_size_and_stripes_follow_genes_and_the_legend_names_them(yard, size):
    def seen(page):
        return red(page), page.locator("#legend").inner_text()

    yard = partial(yard, size=size)
    plain, words = yard(seen)
    assert plain > 5e-4
    assert "gene" not in words
    large, words = yard(seen, name="girth", trait="body.radius", values=[1.0, 1.0, 1.0, 1.001])
    assert "size: gene girth" in words
    assert 3 < large / plain < 5  # twice as long
    striped, words = yard(seen, name="pace", trait="locomotion.pace", values=[2.0, 2.0, 2.0, 1.0])
    assert "stripes: gene pace (none at 1, widest at 2)" in words
    assert 0.35 < striped / plain < 0.85


def test_the_camera_is_above_the_ground_and_in_no_body(yard):
    def look(page):
        x, y, z = page.evaluate("ecs.place(ecs.uids('goat')[0])")

        def stand(away, height):  # looks past the goat
            eye = [x + away, y, height, x + away - 4, y, height - 0.5, 0, 0]
            page.evaluate("eye => { location.hash = `eye=${eye}` }", eye)
            until(page, f"Math.abs(ecs.camera[0] - {eye[0]}) < 0.01 && ecs.still")
            return page.evaluate("ecs.camera[2]"), red(page)

        return stand(3.5, 1.0), stand(0.6, z), stand(3.0, -2.0)

    (_, away), (_, inside), (height, _) = yard(look)
    assert away > 0.01
    assert inside < away
    assert height > 0


@pytest.mark.parametrize("far", [0, 2**32])
def test_a_page_that_is_a_file_has_the_genes_in_place_of_z_or_after_the_uids(page, far):
    frames = page.evaluate(
        """async (far) => {
      const [{ Shelf }, { decode, uidOf }] = await Promise.all([import('/shelf.js'), import('/frame.js')]);
      const columns = { 'gene:girth': [3, 9], 'gene:red': [255, 1] };
      const lives = { columns, size: 'gene:girth', stripes: 'gene:red', n: 2, uid: [7, 8 + far],
        alive: () => [0, 1], state: () => [10, 20, 30, 5], colour: () => 0 };
      const clock = { objects: new Uint32Array([1, 0, 0, 5]) }; // one object
      return [[9, 9], [9, 9, 9]].map((size) => {
        const head = { hello: { first: 0, objects: [{}], size } };
        const shelf = { tick: 0, by: 'species', number: 0, head, clock, lives: [lives] };
        const [block, object] = decode(Shelf.prototype.frame.call(shelf)).blocks, { words } = block;
        const [own, none] = [block, object].map(({ genes }) => genes && [...genes]);
        return [words[2], words[8], own, uidOf(block, 1), uidOf(object, 0), none];
      });
    }""",
        far,
    )
    genes = [3 + 256 * 255, 9 + 256]
    assert frames == [[*genes, None, 8 + far, 5, None], [30, 30, genes, 8 + far, 5, [0]]]


def test_the_young_are_drawn_smaller(yard):
    limit = 'age = [{age}, {age}]\nlethal = [{{ property = "age", max = {max}, cause_above = "too old" }}]'
    plain, adult, young = (
        yard(red, (12.0, 12.0), more=more)  # larger than the minimum on the screen
        for more in ("", limit.format(age=50.0, max=400.0), limit.format(age=0.0, max=1e6))
    )
    assert adult == pytest.approx(plain, rel=0.05)
    assert 0.3 < young / plain < 0.45  # 0.6 as long
