"""The scene: what the selected organism sees, marks of births and deaths, fields, meadows, silhouettes."""

import math
from typing import get_args

import numpy as np
import pytest

from ecs_eco.analysis.palette import SAFE
from ecs_eco.config.models.species import Look
from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, opened, passed, pause, scene, select

pytestmark = IN_A_BROWSER
SIDE = 60.0  # of the park [m]
FAKE = """() => ({hello: {size: [100, 100], edges: 'torus'}, shared: {alpha: {value: 1}},
  spot: (layer, row, at) => at.set(...layer.places[row], 0)})"""


def within(page, uid, kind, reach):
    """Whether the nearest of a kind is within reach [m]."""
    x, y, _ = page.evaluate(f"ecs.place({uid})")
    others = f"ecs.uids('{kind}', 1000).filter(uid => uid !== {uid})"
    places = page.evaluate(f"{others}.map(uid => ecs.place(uid))")
    ways = np.array(places)[:, :2] - (x, y)
    return bool(np.hypot(*(ways - SIDE * np.round(ways / SIDE)).T).min() < reach)


def test_whom_the_selected_one_sees_has_a_line_to_it(page):
    pause(page)
    uid = select(page, "wolf")  # sees deer up to 5 m, where no other is in between, and wolves up to 12 m
    until(page, "ecs.still && ecs.messages.organism > 0")
    certain = within(page, uid, "wolf", 11)
    possible = within(page, uid, "wolf", 12.5) + within(page, uid, "deer", 5.5)
    assert certain <= page.evaluate("ecs.over.seen") <= possible
    assert "sees\ndeer up to 5 m; wolf up to 12 m" in page.locator("#organism").inner_text()
    page.keyboard.press("Escape")
    until(page, "ecs.over.seen === 0")


def test_the_nearest_is_found_around_a_torus_and_within_the_field_of_view(page):
    find = f"""async (fov, heading) => {{
      const [{{nearest}}, fake] = [await import('/sight.js'), ({FAKE})()];
      const me = {{layer: {{places: [[2, 50]], block: {{n: 1}}}}, row: 0}};
      const others = {{places: [[96, 50], [12, 50], [2, 58]], block: {{n: 3}}}};
      const found = nearest(fake, me, others, {{reach: 9, fov}}, heading);
      return found && [found.row, found.d.x, found.d.y];
    }}"""
    look = f"([fov, heading]) => ({find})(fov, heading)"
    assert page.evaluate(look, [2 * math.pi, 0]) == [0, -6, 0]  # the short way, over the edge
    assert page.evaluate(look, [2.0, math.pi / 2]) == [2, 0, 8]  # ahead
    assert page.evaluate(look, [1.0, 0]) is None  # 10 m ahead is beyond its reach


def test_what_a_circle_is_for_is_said_where_no_card_lies_over_it(page):
    highest = """([points, cards]) => import('/sight.js').then(({ highest }) =>
      highest(points.map(([x, y]) => ({ x, y })), 60, cards, [400, 300]))"""
    circle, card = [[200, 50], [250, 70], [280, 120], [150, 60]], [100, 0, 230, 90]
    assert page.evaluate(highest, [circle, []]) == {"x": 200, "y": 50}
    assert page.evaluate(highest, [circle, [card]]) == {"x": 280, "y": 120}  # at 250 the words begin at 220
    assert page.evaluate(highest, [[[10, 40], [200, 5]], []]) == {"x": 200, "y": 5}  # no room anywhere


def test_births_and_deaths_are_marked_and_the_marks_go(page):
    page.locator("#tab-act").click()
    page.get_by_label("Kind to cull").select_option("deer")
    page.get_by_role("button", name="Cull").click()
    until(page, "ecs.acts > 0")
    page.locator("#canvas").focus()
    page.keyboard.press("Period")
    until(page, "ecs.over.marks.death > 0 && ecs.still")
    assert page.evaluate("ecs.over.drawn") > 0
    key = page.locator(".legend-marks")
    drawn, all_marks = page.evaluate(
        "[ecs.over.drawn, Object.values(ecs.over.marks).reduce((a, b) => a + b)]"
    )
    assert key.inner_text().split("\n") == ["born", "died", "killed", f"{drawn} of {all_marks} in view"]
    for _ in range(12):
        page.keyboard.press("PageUp")  # closer: most are outside the picture then
    until(page, f"ecs.over.drawn < {drawn} && ecs.still")
    assert key.inner_text().split("\n")[-1] == f"{page.evaluate('ecs.over.drawn')} of {all_marks} in view"
    page.keyboard.press("Home")
    until(page, f"ecs.over.drawn === {drawn}")
    key.click()
    until(page, "ecs.over.drawn === 0")
    key.click()
    until(page, "ecs.over.drawn > 0")
    page.locator("#canvas").focus()
    page.keyboard.press("Shift+Period")
    until(page, "ecs.over.marks.death === 0")


def test_those_born_long_before_a_late_frame_are_not_marked_as_just_born(page):
    marked = """async ([before, now]) => {
      const { Over } = await import('/over.js');
      const layer = { kind: { moves: true }, own: { radius: { value: 1 } }, before: [0, 0, 0, 256],
        block: { n: 1, words: new Uint16Array(8) } };
      const hello = { size: [9, 9] };
      const stage = { hello, relief: { at: () => 0 }, layers: [layer], colours: ['#123456'] };
      const over = Object.assign(Object.create(Over.prototype), { stage, marks: [], last: before });
      over.take(now, false);
      return over.marks.length;
    }"""
    assert page.evaluate(marked, [40, 41]) == 1
    assert page.evaluate(marked, [40, 60]) == 0


def test_a_field_lies_over_the_ground_and_food_does_too(page):
    pause(page)
    page.locator("[data-eye=top]").click()
    until(page, "ecs.still")
    bare = scene(page)
    names = page.locator("#field option").all_inner_texts()
    assert names == ["none", "deer smell", "grass smell", "wolf smell", "food of deer", "food of wolf"]
    seen = {}
    for name in ("wolf_smell", "food of deer"):
        before = page.evaluate("ecs.messages.field ?? 0")
        page.locator("#field").select_option(name)
        page.locator("#fieldRamp i").wait_for()
        until(page, "ecs.still")
        assert page.evaluate("ecs.messages.field ?? 0") == before + (name == "wolf_smell")
        seen[name] = scene(page)
        changed = np.abs(seen[name] - bare).max(axis=2) > 0.01  # low values are near the ground's color
        assert changed.mean() > 0.4  # the ground is half of the picture
    assert np.abs(seen["wolf_smell"] - seen["food of deer"]).mean() > 0.01
    page.locator("#field").select_option("")
    assert not page.locator("#fieldRamp").is_visible()
    until(page, "ecs.still")
    assert np.abs(scene(page) - bare).mean() < 0.01


def test_the_ground_is_greener_where_grass_grows(page):
    pause(page)
    page.locator("[data-eye=top]").click()
    until(page, "ecs.still")
    grass = page.get_by_role("button", name="grass").first

    def ground():
        until(page, "ecs.still")
        return np.median(scene(page)[200:-200, 100:-100].reshape(-1, 3), axis=0)  # most of it is ground

    grown = ground()
    grass.click()
    bare = ground()
    grass.click()
    r, g, _ = bare - grown
    assert r > g + 0.01  # grass takes away more of the red than of the green
    assert r > 0.02


ISLE = """
format = 1
name = "isle"
space = { size = [120.0, 120.0], edges = "walls" }
terrain = { cell = 4.0, hills = { seed = 4, amplitude = 1.0, scale = 50.0 } }
interventions = [
  { at = 0, kind = "add", species = "tree", count = 160, region = [0.0, 0.0, 40.0, 120.0] },
  { at = 0, kind = "add", species = "grass", count = 900, region = [0.0, 0.0, 80.0, 120.0] },
]
[species.tree]
count = 0
color = "#00441b"
body = { radius = 0.5 }
reproduction = { kind = "spread", rate = 0.0, spacing = 3.0 }
[species.grass]
count = 0
color = "#4d9221"
body = { radius = 0.3 }
reproduction = { kind = "spread", rate = 0.0, spacing = 3.0 }
"""


def test_wood_meadow_and_bare_ground_differ_from_above(browser, tmp_path):
    (tmp_path / "isle.toml").write_text(ISLE)
    with served("watch", str(tmp_path / "isle.toml")) as run, opened(browser, run.address()) as page:
        pause(page)
        passed(page)
        page.locator("[data-eye=top]").click()
        for theme in ("light", "dark"):
            page.emulate_media(color_scheme=theme)
            until(page, "ecs.still")
            box, picture = page.locator("#canvas").bounding_box(), scene(page, 0, 0)
            x, y = (np.array(page.evaluate("ecs.corners()")) - (box["x"], box["y"])).T
            rows = slice(int(y.min() + 0.15 * np.ptp(y)), int(y.max() - 0.15 * np.ptp(y)))
            ends = [[int(x.min() + share / 30 * np.ptp(x)) for share in (k + 2, k + 8)] for k in (0, 10, 20)]
            parts = [np.median(picture[rows, a:b].reshape(-1, 3), axis=0) for a, b in ends]  # most is ground
            wood, meadow, bare = _lab(255 * np.array(parts))
            assert min(math.dist(*pair) for pair in ((wood, meadow), (meadow, bare), (wood, bare))) > 15
            assert max(wood[1], meadow[1]) < bare[1] - 5  # greener


def test_who_lies_still_is_an_animal_and_no_tuft(page):
    drawn = page.evaluate("""async () => {
      const {kindsOf, sign} = await import('/marks.js');
      const still = ['ewe', 'old oak'].map((name) => ({name, sessile: false}));
      const species = [{name: 'grass', sessile: true}, ...still, {name: 'deer', moves: true}];
      const kinds = kindsOf({size: [9, 9], foods: {deer: ['grass']}, species});
      return kinds.map((kind) => [Boolean(kind.rests), kind.build, sign(kind, '#123456').firstChild.tagName]);
    }""")
    assert drawn == [
        [False, None, "ellipse"],
        [True, "sheep", "polygon"],
        [False, "tree", "polygon"],
        [False, "deer", "polygon"],
    ]


def test_shapes_follow_names_or_diet_place_and_size_and_differ(page):
    made = page.evaluate("""async () => {
      const {kindsOf} = await import('/marks.js');
      const animals = ['muncher', 'nibbler', 'stalker', 'picker'].map((name) => ({name, radius: 0.5, moves: true}));
      animals.push({name: 'midge', radius: 0.01, moves: true});
      animals.push({name: 'red foxes', moves: true}, {name: 'Raven', moves: true});
      const foods = {muncher: ['grass'], nibbler: ['grass'], stalker: ['nibbler'], picker: ['carcass']};
      animals.push({name: 'deer', moves: true, look: 'fish'});
      const plants = [{name: 'grass', sessile: true}, {name: 'young oak', sessile: true}];
      const species = [...plants, ...animals], objects = [{name: 'carcass'}];
      const found = (size) => kindsOf({size, foods, species, objects});
      const told = ({build, variant}) => [build ?? null, variant ?? null];
      return [[9, 9], [9, 9, 9]].map((size) => found(size).map(told));
    }""")
    land, water = made
    named = [["wolf", 0], ["bird", 0], ["fish", 0]]
    assert land[:2] == water[:2] == [[None, 0], ["tree", 0]]
    assert land[2:-1] == [["deer", 0], ["deer", 1], ["wolf", 0], ["bird", 0], ["insect", 0], *named]
    assert water[2:-1] == [["copepod", 0], ["copepod", 1], ["fish", 0], ["krill", 0], ["copepod", 2], *named]
    forms = page.evaluate(
        """async (kinds) => {
      const {animal, outline} = await import('/body.js');
      return kinds.map((kind) => {
        const {corners, normals, tones} = animal(...kind);
        const left = [corners.length - normals.length, corners.length - 3 * tones.length];
        return [[...corners].join(), JSON.stringify(outline(...kind)), ...left];
      });
    }""",
        land[2:7] + water[2:7],
    )
    assert len({corners for corners, *_ in forms}) == len({sign for _, sign, *_ in forms}) == 10
    assert {(left, other) for *_, left, other in forms} == {(0, 0)}
    assert page.locator("#legend .legend-row svg:first-child polygon").count() >= 4


def test_the_legend_shows_every_kind_as_the_scene_does(page):
    drawn = page.evaluate(
        """async (looks) => {
      const {kindsOf, sign} = await import('/marks.js'), {Layer} = await import('/layer.js');
      const species = looks.map((look) => ({name: look, look, moves: true}));
      species.push({name: 'eel', look: 'worm', shape: 'capsule', size: [5, 1, 1], moves: true});
      species.push({name: 'grass', sessile: true});
      const fence = {name: 'fence', shape: 'box', size: [1, 1, 1]};
      const objects = [fence, {name: 'dead', remains: true}, {name: 'carcass'}, {name: 'hay'}];
      objects.push({name: 'stone', solid: true});
      const shared = {size: {value: {z: 0}}}, group = {add() {}, remove() {}};
      const block = {n: 1, words: new Uint16Array(6), longs: new Uint32Array(3), upper: null, genes: null};
      return kindsOf({size: [9, 9], foods: {}, species, objects}).map((kind) => {
        const layer = new Layer(kind, group, shared), icon = sign(kind, '#123456');
        layer.take(block, 1, true);
        const corners = layer.form.darts ? [...layer.form.geometry.getAttribute('corner').array] : null;
        const points = [...icon.querySelectorAll('polygon')].flatMap((p) => p.getAttribute('points').split(' '));
        const [rx, ry] = ['rx', 'ry'].map((key) => Number(icon.firstChild.getAttribute(key)));
        const {lying} = layer.own;
        return {name: kind.name, corners, lying: lying.value, tag: icon.firstChild.tagName, flat: ry < rx,
          points: points.map((point) => point.split(',').map(Number))};
      });
    }""",
        list(get_args(Look)),
    )
    flat = {}
    for kind in drawn:
        if kind["points"]:  # the silhouette from the right: its length and height are those of the body
            corners, points = np.array(kind["corners"]).reshape(-1, 3), np.array(kind["points"])
            length, _, height = np.ptp(corners, axis=0)
            assert np.ptp(points, axis=0) / 3.6 == pytest.approx([length, height], abs=0.35), kind["name"]
        else:
            flat[kind["name"]] = kind["tag"], kind["flat"], kind["lying"], kind["corners"] is not None
    assert flat == {
        "eel": ("ellipse", True, 0, True),
        "grass": ("ellipse", False, 0, False),
        "fence": ("rect", False, 0, True),
        "hay": ("ellipse", True, 1, False),
        "stone": ("ellipse", False, 0, False),
    }


def test_the_shapes_of_the_page_are_those_of_world_files(page):
    drawn = page.evaluate(
        """async (shapes) => {
      const {animal, outline} = await import('/body.js');
      return shapes.filter((shape) => animal(shape).corners.length > 30 && outline(shape).length);
    }""",
        list(get_args(Look)),
    )
    assert drawn == list(get_args(Look))


def test_facets_share_corners_and_face_outward(page):
    shapes = page.evaluate("""async () => {
      const {animal} = await import('/body.js');
      return ['deer', 'tree', 'fish', 'clover'].map((shape) => {
        const {corners, normals, facets} = animal(shape);
        return {corners: [...corners], normals: [...normals], facets};
      });
    }""")
    for shape in shapes:
        corners, normals = (np.reshape(shape[part], (-1, 3)) for part in ("corners", "normals"))
        facets = np.reshape(shape["facets"], (-1, 3))
        assert set(facets.flat) == set(range(len(corners)))  # no corner is left over
        assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-5)
        a, b, c = (corners[facets[:, k]] for k in range(3))
        flat = np.cross(b - a, c - a)
        leaning = (flat[:, None] * normals[facets]).sum(2)
        assert (leaning > 0).mean() > 0.98  # corners face as their facets do, except in sharp bends
    corners, normals = (np.reshape(shapes[2][part], (-1, 3)) for part in ("corners", "normals"))
    body = corners[:35, 1:]  # five rings around the axis of a fish
    assert ((body * normals[:35, 1:]).sum(1) > 0).all()  # outward, so that light from above falls on its back
    corners, facets = (np.reshape(shapes[0][part], (-1, 3)) for part in ("corners", "facets"))
    # by hand: a deer's tubes of 10, 3, 4 × 3, 2 × 3 and 2 × 2 rings, and its ears
    assert (len(facets), len(corners)) == (452, 251)


def test_heights_of_light_are_those_where_it_has_fallen(page):
    levels = page.evaluate("""async () => {
      const {FieldMap} = await import('/meadow.js');
      const bytes = Array.from({length: 64}, (_, row) => Math.round(255 * Math.exp(-(63 - row) / 10)));
      const message = {nx: 1, ny: 64, low: 0, high: 1, values: btoa(String.fromCharCode(...bytes))};
      const map = {name: 'light', message, stage: {hello: {size: [1, 1, 64]}}};
      return FieldMap.prototype.levels.call(map);
    }""")
    assert [words.split()[0] for _, words in levels] == ["50%", "10%", "1%"]
    for (height, _), share in zip(levels, (0.5, 0.1, 0.01), strict=True):
        assert height == pytest.approx(63.5 + 10 * math.log(share), abs=2.0)


def _lab(colors):
    """Return colors f64[n, 3] of sRGB, 0 to 255, as L*, a* and b* (CIE 1976, D65)."""
    c = np.asarray(colors, float) / 255
    c = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    xyz = c @ np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]).T
    f = np.cbrt(xyz / (0.9505, 1, 1.089))
    f = np.where(f > 6 / 29, f, (f**3) * 7.787 + 16 / 116)
    x, y, z = f.T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


@pytest.mark.parametrize("dark", [False, True])
def test_fields_have_colors_of_their_own_in_an_order_that_shows_on_any_ground(page, dark):
    ramp, ground, species, sequential, label = page.evaluate(
        """async ([dark, palette]) => {
      const colours = await import('/colours.js');
      const {FieldMap} = await import('/meadow.js'), {Ground} = await import('/ground.js');
      let sheet;
      const map = {stage: {dark}, sheet: {paint: (pixels) => (sheet = pixels)}};
      FieldMap.prototype.paint.call(map, Uint8Array.from({length: 256}, (_, k) => k), 256, 1);
      const uniforms = new Ground({size: [9, 9]}, {nx: 0}, 1);
      uniforms.tint(dark, 1);
      const {grassy, bare} = uniforms.flat.uniforms;
      const kinds = Array.from({length: 7}, (_, k) => ({name: String(k), color: '#4477aa'}));
      const between = (name) => Array.from({length: 256}, (_, k) => colours.rampColour(name, k / 255));
      return [Array.from({length: 256}, (_, k) => [...sheet.slice(4 * k, 4 * k + 4)]),
        [grassy.value, bare.value].map(({r, g, b}) => [255 * r, 255 * g, 255 * b]),
        colours.safe(kinds, dark, palette).map(colours.rgb), between('sequential'),
        colours.gradient(colours.fieldRamp(dark)).match(/#\\w+/g)
          .filter((_, k, all) => !k || k === all.length - 1).map(colours.rgb)];
    }""",
        [dark, SAFE],
    )
    ramp = np.array(ramp)
    assert ramp[[0, -1], :3] == pytest.approx(np.array(label), abs=1)
    share = ramp[:, 3:] / 255
    for below in ground:
        seen = _lab(share * ramp[:, :3] + (1 - share) * np.array(below))
        steps = np.diff(seen[::5, 0]) * (1 if dark else -1)
        assert steps.min() > 0.3  # lightness rises in the dark and falls in the light
        low, high = np.linalg.norm(seen[[0, -1]] - _lab([below]), axis=1)
        assert low < 25
        assert high > 50
    own = _lab(ramp[:, :3])
    others = _lab(species)
    assert np.linalg.norm(own[:, None] - others, axis=2).min() > 20
    assert np.linalg.norm(own[64:, None] - _lab(sequential), axis=2).min() > 20
