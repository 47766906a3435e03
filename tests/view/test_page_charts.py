"""Legend and charts: what each kind does, chosen stretches, numbers as files, charts beside the organism."""

from csv import reader
from io import StringIO

import pytest

from ecs_eco.analysis.palette import SAFE, safe
from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, pause, play, select

pytestmark = IN_A_BROWSER
KEYS = "[...document.querySelectorAll('#charts .chart:first-child .key')].map(key => key.textContent).join()"

TOGGLES = "[...document.querySelectorAll('#charts .tools .toggle')]"


@pytest.fixture
def curves(page):
    """The page, standing still, once curves have a few points; the charts that are shown are those of before
    afterwards."""
    play(page)
    until(page, "ecs.tick > 5 && document.querySelectorAll('.spark polyline[points]').length >= 3")
    pause(page)
    shown = page.evaluate(f"{TOGGLES}.map(one => one.ariaPressed)")
    yield page
    page.evaluate(
        f"shown => {TOGGLES}.forEach((one, i) => one.ariaPressed === shown[i] || one.click())", shown
    )


def test_the_legend_has_a_line_a_trend_and_births_and_deaths_of_each_species(curves):
    rows = curves.locator(".legend-line").all_inner_texts()
    assert [row.split()[0] for row in rows] == ["grass", "deer", "wolf"]
    assert all("per tick" in row and any(arrow in row for arrow in "→↗↘") for row in rows)
    assert "+0 −0 per tick" in rows[2]  # in this park no wolf is born or dies


def test_the_arrow_shows_the_change_in_the_ticks_of_births_and_deaths(page):
    brief = """([ticks, n]) => import('/charts.js').then(({ Charts }) => {
      const charts = Object.create(Charts.prototype);
      const lines = {n: {deer: n}, births: {deer: [0, 4, 1, 0]}, causes: {"deer: starved": [0, 0, 2, 3]}};
      const { change, births, deaths } = Object.assign(charts, {tick: 100, ticks, lines}).brief("deer");
      return [change, births, deaths];
    })"""
    # since tick 40: 30 births and 120 deaths
    change, births, deaths = page.evaluate(brief, [[0, 40, 70, 100], [40, 200, 170, 80]])
    assert change == pytest.approx(-0.6)
    assert 60 * (births - deaths) == pytest.approx(200 * change)
    assert page.evaluate(brief, [[97, 98, 99, 100], [0, 0, 0, 0]])[0] == 0
    assert page.evaluate(brief, [[97, 98, 99, 100], [0, 4, 3, 1]])[0] == 1


def test_the_legend_names_what_most_die_of(page):
    said = "causes => import('/legend.js').then(({ whereof }) => whereof(causes))"
    assert page.evaluate(said, [["eaten by wolf", 3.4], ["starved", 0.2]]) == ["94% eaten by wolf"]
    assert page.evaluate(said, [["too old", 0.6], ["starved", 0.4]]) == ["60% too old", "40% starved"]
    three = [["too old", 5.2], ["starved", 2.8], ["poisoned by red", 2.0]]
    assert page.evaluate(said, three) == ["52% too old", "28% starved", "20% poisoned by red"]
    assert page.evaluate(said, [["eaten by deer", 35.0]]) == ["all eaten by deer"]
    assert page.evaluate(said, []) == []


def test_deaths_a_tick_are_means_over_ticks_and_a_cause_counts_for_nothing_before_its_first(page):
    told = page.evaluate("""() => import('/charts.js').then(({ Charts }) => {
      const charts = Object.create(Charts.prototype);
      const causes = {"deer: starved": [9, 1, 1, 1, 1], "deer: too old": [null, null, null, null, 40],
                      "wolf: starved": [7, 7, 7, 7, 7]};
      const lines = {n: {}, births: {deer: [0, 0, 0, 0, 2]}, causes};
      Object.assign(charts, {tick: 20, ticks: [0, 10, 14, 19, 20], lines});
      const { causes: shares, births, deaths } = charts.brief("deer");
      return { shares, births, deaths };
    })""")
    # over ticks 0 to 20: 2 births and 69 deaths
    assert told["shares"] == [["too old", pytest.approx(40 / 21)], ["starved", pytest.approx((9 + 20) / 21)]]
    assert (told["births"], told["deaths"]) == pytest.approx((2 / 21, 69 / 21))


def test_sparklines_are_even_in_time_and_end_at_the_tick_shown(page):
    line = """tick => import('/charts.js').then(({ Charts }) => {
      const charts = Object.create(Charts.prototype);
      const ticks = [0, ...Array.from({length: 91}, (_, i) => 300 + i), 600];
      const lines = {n: {deer: ticks.map(t => 1000 - t)}, births: {}, causes: {}};
      return Object.assign(charts, {tick, ticks, lines}).brief("deer").line;
    })"""
    falls = page.evaluate(line, 600)
    assert len(falls) == 40
    assert falls[0] == 1000
    assert falls[-1] == 400
    assert falls[:20] == [1000] * 20  # no point before tick 300, half of the time
    assert page.evaluate(line, 300)[-1] == 700  # going back, nothing later shows
    assert page.evaluate(line, 0) == [1000]


def test_nights_are_shaded_between_ticks_at_which_the_light_is_known(page):
    shaded = page.evaluate("""async () => {
      const {nights} = await import('/series.js');
      const light = [null, null, 0, 0, null, null, 1, null, 0, null], found = [];
      const ctx = {save() {}, restore() {}, fillRect(x, y, w) { found.push([x / 10, w / 10, this.globalAlpha]); }};
      const u = {bbox: {left: 0, top: 0, width: 100, height: 9}, valToPos: (tick) => 10 * tick, ctx};
      nights(u, light.map((_, tick) => tick), light);
      return found;
    }""")
    dark = {start for start, ticks, alpha in shaded if alpha > 0 and ticks == 1}
    assert dark == {0, 1, 2, 6, 7}  # 3 to 6 is as light as at 6; after the last known tick, it is unknown
    assert {alpha for *_, alpha in shaded} == {0, 0.4}


def test_lanes_show_deaths_in_the_ticks_up_to_their_point(page):
    lane = """([ticks, rates, scale]) => import('/lanes.js').then(({ byPixel }) =>
      [...byPixel(ticks, rates, t => t * scale, 0, 10)])"""
    # six wolves die in ticks 3 to 5, before the point at tick 6; then nothing happens
    assert page.evaluate(lane, [[0, 3, 6, 9], [None, 0, 2, 0], 1]) == [0, 0, 0, 2, 2, 2, 0, 0, 0, 0]
    # several points in a pixel: a mean over ticks
    assert page.evaluate(lane, [[0, 10, 20, 40], [None, 1, 3, 5], 0.01]) == [3.5, *[0] * 9]


def test_one_kind_is_shown_alone_and_all_again(curves):
    page = curves
    alone = page.get_by_label("Show only deer, or all kinds again")
    alone.click()
    pressed = "[...document.querySelectorAll('.legend-row')].map(row => row.ariaPressed).join()"
    until(page, f"{pressed} === 'false,true,false' && !{KEYS}.includes('wolf')")
    alone.click()
    until(page, f"{pressed} === 'true,true,true' && {KEYS}.includes('wolf')")


def test_one_of_a_kind_is_found(curves):
    page = curves
    page.get_by_label("Select one wolf").click()
    until(page, "ecs.uids('wolf').includes(ecs.selected) && ecs.still")
    at, box = page.evaluate("ecs.screen(ecs.selected)"), page.locator("#canvas").bounding_box()
    assert abs(at["x"] - box["x"] - box["width"] / 2) < 0.2 * box["width"]


def test_a_stretch_of_ticks_is_chosen_by_dragging(curves):
    page, over = curves, curves.locator("#charts .u-over").first
    wide = over.bounding_box()["width"]
    over.hover(position={"x": 0.2 * wide, "y": 20})  # other tests may have scrolled the panel
    until(page, "document.querySelector('.pointed').textContent.startsWith('tick ')")
    box = over.bounding_box()
    page.mouse.down()
    page.mouse.move(box["x"] + 0.4 * wide, box["y"] + 20, steps=4)
    page.mouse.up()
    back = page.get_by_role("button", name="zoom out")
    back.wait_for()
    back.click()
    assert not back.is_visible()


def test_the_numbers_of_a_chart_are_saved(curves):
    with curves.expect_download() as waiting:
        curves.get_by_label("Save the numbers: Populations").click()
    assert waiting.value.suggested_filename == "populations.csv"
    head, *rows = waiting.value.path().read_text().splitlines()
    assert head == "tick,grass [organisms],deer [organisms],wolf [organisms]"
    assert rows[0].endswith(",80,12")


def test_files_name_units_and_a_file_with_gaps_is_called_thinned(page):
    heads = page.evaluate("""async () => {
      const {Charts} = await import('/charts.js'), charts = Object.create(Charts.prototype), found = [];
      charts.hello = {species: [{name: "vole", units: {poison: "energy", bold: "1"}}]};
      for (const ticks of [[0, 1, 2], [0, 1, 4]]) {
        charts.ticks = ticks;
        const of = (key, title, name, heading) => charts.heading(key, title, name, heading);
        found.push([charts.thinned(), of("births", "Births", "vole", "per tick"),
          of("genes", "Genes", "vole.poison"), of("genes", "Genes", "vole.bold"),
          of("report ratio", "ratio", ""), of("", "mean depth [m]", "vole")]);
      }
      return found;
    }""")
    same = ["mean, energy", "mean", "ratio", "m"]
    assert heads == [[False, "per tick", *same], [True, "per tick since the previous row", *same]]


def test_files_quote_names_and_leave_missing_values_empty(page):
    csv = "rows => import('/series.js').then(({ csv }) => csv(rows))"
    text = page.evaluate(csv, [["food, fresh", 'the "old" one'], [0, None], [1.5, "a\nb"]])
    assert list(reader(StringIO(text))) == [["food, fresh", 'the "old" one'], ["0", ""], ["1.5", "a\nb"]]


def test_grid_lines_are_at_round_values_and_say_exactly_these(page):
    values = "ends => import('/axes.js').then(({ roundValues }) => roundValues(ends))"
    assert page.evaluate(values, [0, 274]) == [[v, str(v)] for v in (0, 50, 100, 150, 200, 250)]
    assert page.evaluate(values, [10.2, 10.31])[:3] == [[10.2, "10.2"], [10.22, "10.22"], [10.24, "10.24"]]
    assert page.evaluate(values, [-0.3, 0.3])[0] == [-0.3, "−0.3"]
    assert page.evaluate(values, [1000, 1003])[:2] == [[1000, "1\u202f000"], [1000.5, "1\u202f000.5"]]


def test_wide_panels_show_charts_beside_the_organism(curves):
    page = curves
    page.set_viewport_size({"width": 1500, "height": 700})
    page.locator("#splitter").focus()
    for _ in range(9):
        page.keyboard.press("ArrowLeft")
    assert page.locator("#side").bounding_box()["width"] > 720
    select(page, "deer")
    charts, organism = (page.locator(panel).bounding_box() for panel in ("#charts", "#organism"))
    assert charts["x"] + charts["width"] <= organism["x"] + 1
    page.locator("#splitter").dblclick()
    assert not page.locator("#charts").is_visible()


KINDS = [{"grass": "#4d9221", "deer": "#b8860b", "wolf": "#67001f"}, {f"s{i}": "#d7191c" for i in range(9)}]


def test_the_phase_plane_shows_two_species_against_each_other_and_is_kept(curves):
    page = curves
    assert page.locator(".figure").count() == 0
    page.get_by_role("button", name="Phase plane", exact=True).click()
    counts = page.evaluate("ecs.counts")
    now = page.locator("[data-now]")
    assert now.get_attribute("data-now") == f"{counts['deer']},{counts['wolf']}"
    page.get_by_label("Species on the vertical axis").select_option("grass")
    assert now.get_attribute("data-now").startswith(f"{counts['deer']},")
    assert page.evaluate("localStorage.getItem('ecs-eco-plane')") == '["deer","grass"]'
    assert "plane" not in page.evaluate("localStorage.getItem('ecs-eco-charts-2')")
    page.get_by_role("button", name="Phase plane", exact=True).click()
    assert page.locator(".figure").count() == 0


def test_the_distribution_of_a_value_counts_those_who_have_it(curves):
    page = curves
    page.get_by_role("button", name="Distribution", exact=True).click()
    page.get_by_label("Value of the distribution").select_option("energy")
    assert page.locator("#colour").input_value() == "energy"
    until(page, "document.querySelector('[data-kind=wolf]')?.dataset.n === '12'")
    until(page, "document.querySelector('[data-kind=deer]')?.dataset.n === '80'")
    page.locator("#colour").select_option("species")
    until(page, "!document.querySelector('[data-kind]')")
    page.get_by_role("button", name="Distribution", exact=True).click()


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("kinds", KINDS, ids=["three", "nine"])
def test_the_page_has_the_colours_of_pictures_and_reports(page, kinds, dark):
    things = {"stone": "#888888", "box": "#b8860b"}
    named = [{"name": name, "color": colour} for name, colour in kinds.items()]
    named += [{"name": name, "color": colour, "inanimate": True} for name, colour in things.items()]
    chosen = page.evaluate(
        "([kinds, dark, palette]) => import('/colours.js').then(it => it.safe(kinds, dark, palette))",
        [named, dark, SAFE],
    )
    assert chosen == list(safe(kinds, things, dark).values())


def test_hunters_grazers_and_plants_have_signs_of_their_own(page):
    signs = page.locator(".legend-row > svg:first-child").evaluate_all(
        "all => all.map(svg => svg.firstChild.tagName + (svg.firstChild.getAttribute('points') ?? ''))"
    )
    assert len(set(signs)) == 3
    assert signs[0] == "ellipse"


def shown(page, name):
    """Show a chart that is hidden at first."""
    button = page.locator("#charts .tools .toggle", has_text=name)
    if button.get_attribute("aria-pressed") == "false":
        button.click()


def test_energy_taken_in_and_burnt_is_a_chart(curves):
    shown(curves, "Energy")
    chart = curves.locator("#charts .chart", has=curves.locator("h2", has_text="Energy"))
    keys = chart.locator(".key").all_inner_texts()
    names = ["deer: taken in", "deer: burnt", "wolf: taken in", "wolf: burnt"]
    assert len(keys) == len(names)
    assert all(key.strip().startswith(name) for key, name in zip(keys, names, strict=True))


def test_two_values_of_organisms_are_points_and_a_click_selects_one(curves):
    page = curves
    shown(page, "Organisms")
    page.get_by_label("Value on the vertical axis").select_option("x")
    place = "#charts svg[aria-label^='x against age'] g[data-kind=deer]"
    until(page, f'document.querySelector("{place} circle")')
    points = page.locator(place)
    assert int(points.get_attribute("data-n")) == page.evaluate("ecs.counts.deer")
    first = points.locator("circle").first
    uid = int(first.get_attribute("data-uid"))
    first.dispatch_event("click")
    until(page, f"ecs.selected === {uid}")
