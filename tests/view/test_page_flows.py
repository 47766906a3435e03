"""The diagram of who eats how much of whom, in the stretch of ticks that is shown; and as a table."""

import re
from xml.etree import ElementTree

import pytest

from ecs_eco.analysis.figures import FLOWS
from ecs_eco.analysis.flows import Meal, flows
from ecs_eco.analysis.report.write import energy
from ecs_eco.analysis.runs import load_series
from ecs_eco.analysis.why import Case, explain
from ecs_eco.analysis.why.page import energy as said_of
from ecs_eco.config import WorldConfig, load
from ecs_eco.record import run_to_folder
from ecs_eco.testing.browser import served, until
from ecs_eco.view.replay import Replay
from ecs_eco.view.story import foods_of
from tests.view.pages import IN_A_BROWSER, OF_RUN, opened, pause, play
from tests.view.parks import SMALL as PARK

pytestmark = IN_A_BROWSER
PICTURE = "#charts .flow-picture"
FOUND = """([hello, ticks, range, lines]) => import('/flows.js').then(({ Flows }) => new Flows({
    hello, ticks, range: () => range, away: new Set(), shared: false, colourOf: () => "#123456",
    lines: { causes: {}, flows: {}, ...lines } }).found())"""
HELLO = {
    "species": [{"name": "grass"}, {"name": "deer", "moves": True}],
    "foods": {"deer": ["grass"]},
    "size": [9, 9],
}
PASTURE = {
    "format": 1,
    "name": "pasture",
    "space": {"size": [20.0, 20.0]},
    "species": {
        "grass": {"count": 4, "body": {"radius": 0.25}, "metabolism": {"energy": 0.5, "energy_spread": 0}},
        "deer": {
            "count": 1,
            "body": {"radius": 0.5},
            "metabolism": {"energy": 0.5, "energy_spread": 0, "energy_max": 4.0, "basal": 0.25},
            "locomotion": {"speed": {"walk": 0.0}, "turn": 0.5},
            "diet": [{"eats": "grass", "reach": 20.0, "gain": 0.375}],
            "sensors": [{"kind": "own", "property": "energy"}],
            "actions": {"speed": ["walk"], "turn": ["left", "none", "right"]},
            "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
        },
    },
}


def found(page, ticks, stretch, **lines):
    return page.evaluate(FOUND, [HELLO, ticks, stretch, lines])


def test_means_are_of_the_stretch_that_is_shown_and_weighed_by_its_ticks(page):
    lines = {
        "deer: eaten: grass": [None, 4.0, 1.0, 7.0],
        "deer: taken in": [None, 5.0, 2.0, 8.0],
        "deer: burnt": [None, 2.0, None, 2.0],
        "deer: lost": [None, 0.5, 0.5, 0.5],
        "grass: taken in": [None, 6.0, 6.0, 6.0],
        "grass: lost": [None, 3.0, 3.0, 3.0],
    }
    causes = {"grass: eaten by deer": [None, 8.0, 2.0, 9.0], "deer: starved": [None, 0.0, 4.0, 0.0]}
    said = found(page, [0, 10, 40, 50], [0, 40], flows=lines, causes=causes)
    # 10 ticks of 4 and 30 of 1 are 1.75 a tick
    assert said["meals"] == [{"from": "grass", "to": "deer", "energy": 1.75, "meals": 3.5}]
    grass, deer = said["nodes"]
    assert [grass[k] for k in ("light", "other", "dead")] == [6.0, 0, 1.25]  # less what the deer gained by it
    # what was unknown before the first event was 0
    assert [deer[k] for k in ("light", "other", "burnt", "dead", "died")] == [0, 1.0, 0.5, 0.5, 3.0]
    assert deer["level"] == grass["level"] + 1


@pytest.fixture(scope="module")
def pasture(tmp_path_factory):
    """A deer eats a tuft of 0.5 energy in each of the first four ticks, and starves in the ninth of ten."""
    out = tmp_path_factory.mktemp("pasture") / "run"
    run_to_folder(WorldConfig(**PASTURE), seed=1, ticks=10, out=out, policies="random", report=False)
    return out


def test_page_and_report_have_the_flows_that_were_counted_by_hand(page, pasture):
    replay, report = Replay(pasture), flows(load_series(pasture))
    hello, series = replay.hello(), replay.series(-1)
    said = page.evaluate(OF_RUN, [hello, series])
    # four meals of 0.375 in ten ticks; 0.125 of each tuft is left over
    assert report.meals == (Meal("grass", "deer", pytest.approx(0.15), pytest.approx(0.4)),)
    assert [pytest.approx(meal) for meal in said["meals"]] == [
        {"from": "grass", "to": "deer", "energy": 0.15, "meals": 0.4}
    ]
    # the deer cannot burn more than the 0.5 + 4 · 0.375 that it had, and leaves nothing
    for name, burnt, dead in (("grass", 0, 0.05), ("deer", 0.2, 0)):
        (node,) = [node for node in said["nodes"] if node["name"] == name]
        budget = report.budgets[name]
        assert (node["burnt"], node["dead"]) == pytest.approx((burnt, dead), abs=1e-7)
        assert (budget.burnt, budget.dead) == pytest.approx((burnt, dead), abs=1e-7)
    of = {name: values.sum(axis=0) for name, values in load_series(pasture).columns.items()}
    assert (of["lost"].tolist(), of["burnt"].tolist()) == ([2.0, 0.0], [0.0, 2.0])
    # of ticks 2 to 5, two have a meal; a hidden species changes no flow of the others
    (meal,) = page.evaluate(OF_RUN, [hello, series, [2, 5]])["meals"]
    assert (meal["energy"], meal["meals"]) == pytest.approx((0.1875, 0.5))
    (grass,) = page.evaluate(OF_RUN, [hello, series, None, ["deer"]])["nodes"]
    assert grass["dead"] == pytest.approx(0.05)


def test_the_energy_held_at_death_has_one_name_and_is_not_negative(pasture):
    assert {name: word for name, word, _ in FLOWS}["lost"] == "held at death"
    assert "<th>held at death" in re.sub(r"<th[^>]*>", "<th>", energy(load_series(pasture)))
    told = explain(Case.read(pasture))["energy"]["deer"]
    assert told["lost"] == 0
    assert "0% held at death" in said_of("deer", told)


def test_the_world_tab_shows_all_that_is_eaten_and_what_harms(page):
    config = load("reflexes").model_dump()
    hello = HELLO | {"foods": foods_of(config), "eats": foods_of(config, harmful=True), "dt": 1}
    hello |= {"species": [{"name": name} for name in ("red", "yellow", "green", "goat")]}
    web = page.evaluate(
        """(hello) => import('/world.js').then((it) => {
          const place = document.querySelector("#world"), before = [...place.children];
          it.world(hello, () => "#123456", ["green: eaten by goat"]);
          const meals = [...place.querySelectorAll("[data-meal]")];
          place.replaceChildren(...before);
          return Object.fromEntries(meals.map((one) => [one.dataset.meal, one.getAttribute("class")]));
        })""",
        hello,
    )
    assert web == {"red goat": "meal harms", "yellow goat": "meal harms", "green goat": "meal"}


def test_all_that_is_eaten_is_one_list_for_all_webs_and_hunters_are_told_by_what_feeds_them(page):
    hello = HELLO | {
        "eats": {"deer": ["grass", "wolf"]},
        "species": [*HELLO["species"], {"name": "wolf", "moves": True}],
    }
    eats = "([hello, causes]) => import('/world.js').then((it) => it.eats(hello, causes))"
    assert page.evaluate(eats, [hello, ["deer: eaten by wolf", "deer: starved"]]) == {
        "deer": ["grass", "wolf"],
        "wolf": ["deer"],
    }
    kinds = page.evaluate("(hello) => import('/marks.js').then((it) => it.kindsOf(hello))", hello)
    assert [kind["hunts"] for kind in kinds] == [False, False, False]


def test_names_of_narrow_drawings_do_not_lie_over_each_other(page):
    lapping = """async () => {
      const { Flows } = await import('/flows.js');
      const names = ["phytoplankton", "copepods of the deep", "krill"], lines = {};
      for (const [i, name] of names.entries()) lines[`${name}: taken in`] = [null, 3.55];
      for (const [i, name] of names.slice(1).entries()) lines[`${name}: eaten: ${names[i]}`] = [null, 2.55];
      const flows = new Flows({ hello: { species: names.map((name) => ({ name, moves: true })), size: [9, 9],
        foods: { [names[1]]: [names[0]], [names[2]]: [names[1]] } }, ticks: [0, 9], range: () => [0, 9],
        away: new Set(), shared: false, colourOf: () => "#123456", lines: { causes: {}, flows: lines } });
      const place = document.createElement("div");
      place.style.width = "400px";
      document.getElementById("charts").append(place);
      place.append(flows.root);
      flows.rebuild(true);
      const boxes = [...place.querySelectorAll(".flow-name")].map((one) => one.getBoundingClientRect());
      place.remove();
      return boxes.slice(1).map((box, i) => box.left - boxes[i].right);
    }"""
    gaps = page.evaluate(lapping)
    assert len(gaps) == 2
    assert min(gaps) > 0


def test_what_harms_and_what_it_was_not_known_to_eat_is_there_too(page):
    flows = {"deer: eaten: deer": [None, -0.5], "deer: taken in": [None, -0.5]}
    said = found(page, [0, 10], [0, 10], flows=flows, causes={"deer: eaten by deer": [None, 1.0]})
    assert {(meal["from"], meal["to"]): meal["energy"] for meal in said["meals"]} == {
        ("grass", "deer"): 0,
        ("deer", "deer"): -0.5,
    }


@pytest.fixture
def eating(page):
    """The page, standing still after some ticks, and the diagram as at first afterwards."""
    play(page)
    until(page, f"document.querySelector('{PICTURE} [data-meal=\"grass deer\"]')?.dataset.size > 0")
    pause(page)
    page.wait_for_timeout(600)  # the drawing keeps a pace
    yield page
    page.get_by_label("Width of bands").select_option("energy")


def test_deer_eat_grass_and_wolves_that_eat_nobody_have_a_dashed_line(eating):
    page = eating
    grass, deer = (page.locator(f"{PICTURE} [data-meal='{meal}']") for meal in ("grass deer", "deer wolf"))
    assert grass.get_attribute("stroke-dasharray") is None
    assert float(grass.get_attribute("stroke-width")) > 10
    assert deer.get_attribute("stroke-dasharray")
    assert deer.get_attribute("data-size") == "0"
    label = page.locator(PICTURE).get_attribute("aria-label")
    assert re.search(r"deer eats [\d.]+ grass and gains [\d.]+ energy per tick", label)
    assert "wolf" not in label  # who ate nobody, in words


def test_bands_are_energy_or_numbers_and_the_choice_is_kept(eating):
    page = eating
    band = page.locator(f"{PICTURE} [data-meal='grass deer']")
    energy = float(band.get_attribute("data-size"))
    page.get_by_label("Width of bands").select_option("meals")
    assert float(band.get_attribute("data-size")) > 2 * energy  # a tuft gives less than one
    assert page.evaluate("localStorage.getItem('ecs-eco-flows')") == "meals"


def test_it_is_drawn_anew_where_the_panel_is_narrower(eating):
    page = eating
    wide = "document.querySelector('#charts .flow-picture').viewBox.baseVal.width"
    room = "document.querySelector('#charts .flows').clientWidth"
    before = page.evaluate(wide)
    page.locator("#splitter").focus()
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
    until(page, f"{wide} > {before + 40} && {wide} === {room}")
    page.locator("#splitter").dblclick()
    until(page, f"{wide} === {before}")


def test_the_table_says_what_the_drawing_shows(eating):
    page = eating
    page.locator(".flows ~ details summary").press("Enter")
    rows = page.locator(".flows ~ details tbody tr")
    cells = [row.locator("th, td").all_inner_texts() for row in rows.all()]
    (meal,) = [cell for cell in cells if cell[:2] == ["grass", "deer"]]
    size = float(page.locator(f"{PICTURE} [data-meal='grass deer']").get_attribute("data-size"))
    assert float(meal[2]) == pytest.approx(size, rel=0.01)
    assert [cell[:2] for cell in cells if cell[1] == "burned"] == []  # in this park nobody burns anything
    page.locator(".flows ~ details summary").press("Enter")


def test_it_is_saved_as_numbers_and_as_a_drawing(eating):
    page = eating
    with page.expect_download() as waiting:
        page.get_by_label("Save the numbers: Who eats whom").click()
    head, *rows = waiting.value.path().read_text().splitlines()
    assert head == "from,to,energy per tick,organisms per tick"
    assert any(row.startswith("grass,deer,") for row in rows)
    with page.expect_download() as waiting:
        page.get_by_label("Save the drawing: Who eats whom").click()
    assert waiting.value.suggested_filename == "who-eats-whom.svg"
    drawn = ElementTree.fromstring(waiting.value.path().read_text())
    assert drawn.tag.endswith("svg")
    assert "deer" in " ".join(drawn.itertext())


def test_who_is_hidden_is_not_in_it_and_it_is_hidden_itself_on_wish(eating):
    page = eating
    page.get_by_label("Show only deer, or all kinds again").click()
    until(page, f"!document.querySelector('{PICTURE} [data-node=wolf]')")
    page.get_by_label("Show only deer, or all kinds again").click()
    until(page, f"document.querySelector('{PICTURE} [data-node=wolf]')")
    button = page.locator("#charts .tools .toggle", has_text="Who eats whom")
    button.click()
    assert page.locator(PICTURE).count() == 0
    assert "flows" in page.evaluate("localStorage.getItem('ecs-eco-charts-2')")
    button.click()
    page.locator(PICTURE).wait_for()


def test_a_record_shows_all_of_its_ticks_or_those_that_are_chosen(browser, tmp_path):
    run_to_folder(
        load("predator-prey", PARK), seed=5, ticks=30, out=tmp_path / "run", policies="random", report=False
    )
    with served("watch", str(tmp_path / "run")) as run, opened(browser, run.address()) as page:
        page.locator(PICTURE).wait_for()
        assert "Means of ticks 0 to 29" in page.locator(".flows + .about").inner_text()
        page.locator(".flows ~ details summary").click()
        cells = [
            row.locator("th, td").all_inner_texts() for row in page.locator(".flows ~ details tbody tr").all()
        ]
        series = load_series(tmp_path / "run")
        for food, eater in (("grass", "deer"), ("deer", "wolf")):
            (said,) = [cell[2:] for cell in cells if cell[:2] == [food, eater]]
            means = [
                series.of(*of).mean() for of in ((eater, f"eaten: {food}"), (food, f"died: eaten by {eater}"))
            ]
            assert [float(number) for number in said] == pytest.approx(means, rel=0.01)
