"""Figures in pages follow the theme of the page: colours, letters, ids; and a browser agrees."""

import re
import runpy
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

import ecs_eco
from ecs_eco.analysis import depth_figures, figures
from ecs_eco.analysis.cycles import cycle_statistics
from ecs_eco.analysis.page import drawn as written, page, table
from ecs_eco.analysis.palette import BAND, GRID, INK, NIGHT, ON_DARK, SOFT
from ecs_eco.analysis.report import write_report
from ecs_eco.analysis.runs import load_series
from ecs_eco.analysis.style import panels, save_svg
from ecs_eco.analysis.survival import kaplan_meier
from ecs_eco.analysis.svg import DENSE, DIM, themed
from ecs_eco.testing.browser import chromium, launched

chains = SimpleNamespace(**runpy.run_path(str(Path(__file__).with_name("chains.py"))))
contrast = runpy.run_path(str(Path(__file__).with_name("test_palette.py")))["contrast"]
GROUND = "#ffffff", "#12181b"
PACKAGE = Path(ecs_eco.__file__).parent
BEHIND = {BAND, GRID, GROUND[0], NIGHT, "none"}
"""Colours of what lies behind curves."""
PAIRS = [("grass", "deer"), ("deer", "wolf")]


def svg(drawn, folder: Path, name: str = "x") -> str:
    return save_svg(drawn, folder / f"{name}.svg").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The figures of reports, by name."""
    numbers = chains.chain(1200)
    numbers[1000:, 2] = 0
    series = load_series(chains.series_table(numbers))
    series.manifest["colors"] = {"grass": "#4d9221", "deer": "#b8860b", "wolf": "#67001f"}
    series.manifest["intervened"] = [[100, {"kind": "cull", "species": "wolf", "share": 0.5}]]
    found = cycle_statistics(series, n_boot=49)
    at = {"deer": np.array([[1.0, 2, 3], [4, 5, 6]]), "wolf": np.array([[7.0, 8, 9]])}
    lived = {"a": kaplan_meier([3, 5], [True, False]), "b": kaplan_meier([2], [True])}
    hours = {"deer": np.random.default_rng(1).random((10, depth_figures.HOURS))}
    shown = {
        "populations": figures.populations(series),
        "phase": figures.phase(series, PAIRS),
        "spectra": figures.spectra(found.peaks),
        "lags": figures.lags(series, PAIRS, found.period),
        "deaths": figures.deaths(series),
        "energy": figures.energy(series),
        "positions": figures.positions(at, [10, 10], figures.colors(["deer", "wolf"])),
        "survival": figures.survival(lived, 5),
        "arms": figures.arms({"a": [series], "b": [series]}),
        "hours": depth_figures.by_hour(hours, 10.0, np.ones(50)),
    }
    folder = tmp_path_factory.mktemp("drawn")
    return {name: svg(figure, folder, name) for name, figure in shown.items()}


def test_curves_and_words_stand_out_from_both_grounds(drawn: dict[str, str]) -> None:
    for name, text in drawn.items():
        for part in ElementTree.fromstring(text).iter():
            word = part.tag.endswith("text")
            for colour in {part.get("fill"), part.get("stroke")} - BEHIND - {None}:
                if colour.startswith("url") or float(part.get("opacity", 1)) == 0:
                    continue
                for ground, hue in zip(GROUND, (colour, ON_DARK[colour]), strict=True):
                    least = 4.5 if word and colour in (INK, SOFT) else 3
                    assert contrast(hue, ground) >= least, (name, part.tag, part.text, colour, ground)


def test_each_colour_that_is_used_has_a_rule_for_dark_pages(drawn: dict[str, str]) -> None:
    for text in drawn.values():
        style, inside = text.split("</style>")
        for what, colour in re.findall(r' (fill|stroke)="(#[0-9a-f]{6})"', inside):
            assert f'[{what}="{colour}"]{{{what}:{ON_DARK[colour]}}}' in style
        assert "prefers-color-scheme:dark" in style
        assert not re.search(r"<style>[^<]*(\*|^)\{", text)  # matplotlib's own would hold for the whole page


def test_ids_of_figures_in_one_page_are_unique_and_lead_somewhere(drawn: dict[str, str]) -> None:
    text = "".join(drawn.values())
    ids = re.findall(r' id="([^"]+)"', text)
    assert len(ids) == len(set(ids)) > 10
    assert {*re.findall(r'href="#([^"]+)"', text), *re.findall(r"url\(#([^)]+)\)", text)} == set(ids)


def test_the_words_of_a_figure_are_words_and_its_powers_can_be_read(drawn: dict[str, str]) -> None:
    assert "number of deer, wolf</text>" in drawn["populations"]
    assert ">10⁻" in drawn["spectra"]
    assert "mathdefault" not in "".join(drawn.values())


def test_only_maps_of_colours_are_images(drawn: dict[str, str]) -> None:
    assert {name for name, text in drawn.items() if "<image" in text} == {"hours"}


def test_the_same_figure_has_the_same_bytes(tmp_path: Path) -> None:
    series = load_series(chains.series_table(chains.chain(300)))
    assert svg(figures.deaths(series), tmp_path / "a") == svg(figures.deaths(series), tmp_path / "b")


@pytest.mark.slow
def test_a_run_report_holds_no_picture_on_white_and_a_caption_with_each_figure(tmp_path: Path) -> None:
    text = write_report(chains.write_run(tmp_path / "run", chains.chain(400))).read_text(encoding="utf-8")
    assert "<img" not in text
    assert "image/png" not in text
    assert 'class="under"' not in text  # the ground of the files, which the page has itself
    heard = re.findall(r'<svg role="img" aria-label="([^"]+)"', text)
    assert len(heard) == len(re.findall('class="plot', text)) >= 5
    assert all(f"<figcaption>{caption}</figcaption>" in text for caption in heard)


def test_many_dots_are_one_path_through_all_their_places(tmp_path: Path) -> None:
    x = np.arange(DENSE) % 20
    y = np.arange(DENSE) // 20
    few, many = panels(1, 1, 4, 4)[0], panels(1, 1, 4, 4)[0]
    few.axes[0].scatter(x[:-1], y[:-1], s=4, color=INK, clip_on=False)
    many.axes[0].scatter(x, y, s=4, color=INK, clip_on=False)
    assert svg(few, tmp_path).count("<use") > DENSE - 2
    text = svg(many, tmp_path)
    path = re.search(r'd="([^"]*h0[^"]*)"', text)[1]
    assert text.count("<use") < 40
    assert path.count("h0") == DENSE
    steps = np.array(re.findall(r"m(-?\d+) ?(-?\d+)h0", path), int)
    at = steps.cumsum(axis=0)  # tenths of a unit
    assert len({tuple(place) for place in at.tolist()}) == DENSE
    x, y = at[:20].T  # the upper row is the last of those that were drawn
    assert np.abs(np.diff(x) - np.diff(x)[0]).max() <= 1
    assert np.ptp(y) == 0


def test_a_long_line_goes_where_it_went() -> None:
    rng = np.random.default_rng(3)
    at = rng.uniform(-5, 400, (300, 2)).cumsum(0) % 397.3
    line = "M " + " L ".join(f"{x:.6f} {y:.6f}" for x, y in at) + " z M 1 2 L 3 4"
    frame = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 400"><path d="{}"/></svg>'
    short = re.search(r' d="([^"]+)"', themed(frame.format(line), "x"))[1]
    words = re.findall(r"[mlz]|-?(?:\d+\.?\d*|\.\d+)", short)
    numbers = [float(word) for word in words if word not in "mlz"]
    steps = np.array(numbers[:600]).reshape(-1, 2).cumsum(0)
    assert np.abs(steps - at).max() < 0.0501
    assert [*at[0].round(1) + numbers[600:602]] == pytest.approx([1, 2])  # from where z went back to
    assert len(short) < 0.6 * len(line)


def test_a_table_has_words_at_the_left_and_no_empty_head() -> None:
    text = page("x", table(["", "cause", "deaths"], [["deer", "starved", "1,000"], ["wolf", "–", 3]]))
    assert text.count("<main>") == text.count("</main>") == 1
    assert "<tr><td></td><th class='words'>cause</th><th>deaths</th></tr>" in text
    assert "<td class='words'>starved</td><td>1,000</td>" in text
    assert "<td class='words'>–</td><td>3</td>" in text


@pytest.mark.slow
@pytest.mark.skipif(chromium() is None, reason="needs Chromium")
def test_a_browser_shows_a_figure_in_the_theme_of_its_page_and_readable_on_a_phone(tmp_path: Path) -> None:
    pytest.importorskip("playwright")
    series = load_series(chains.series_table(chains.chain(300)))
    figure = figures.populations(series)
    figure.set_gid(DIM)
    file = tmp_path / "page.html"
    file.write_text(page("x", written(figure, tmp_path / "x.svg", "Numbers")), encoding="utf-8")
    seen = {}
    with launched() as browser:
        for theme in ("light", "dark"):
            shown = browser.new_page(color_scheme=theme, viewport={"width": 390, "height": 800})
            shown.goto(file.as_uri())
            seen[theme] = shown.evaluate("""() => {
                const words = [...document.querySelectorAll('.plot text')]
                const of = name => words.find(t => t.textContent.startsWith(name))
                return {label: getComputedStyle(of('tick')).fill,
                        grid: getComputedStyle(document.querySelector('.plot [stroke="#e6eaee"]')).stroke,
                        wide: document.documentElement.scrollWidth,
                        letter: of('tick').getBoundingClientRect().height}}""")
    assert (seen["light"]["label"], seen["light"]["grid"]) == ("rgb(27, 31, 35)", "rgb(230, 234, 238)")
    assert (seen["dark"]["label"], seen["dark"]["grid"]) == ("rgb(228, 234, 234)", "rgb(40, 49, 54)")
    assert seen["dark"]["wide"] == 390  # figures are scrolled, not the page
    assert seen["dark"]["letter"] >= 9


def test_figures_with_up_to_five_columns_fit_on_the_page_of_a_report_and_their_text_has_12_px() -> None:
    for columns, wide in ((1, 9.0), (5, 20.0), (8, 20.0)):
        figure, _ = panels(1, columns, wide, 3)
        assert figure.get_figwidth() == pytest.approx({1: 9.0, 5: 9.9, 8: 15.84}[columns])
    sources = [path for folder in ("analysis", "lab", "explain") for path in (PACKAGE / folder).rglob("*.py")]
    sizes = [
        (path.name, float(size))
        for path in sources
        for size in re.findall(r"""fontsize"?[=:] ?([\d.]+)""", path.read_text(encoding="utf-8"))
    ]
    assert len(sizes) > 10
    assert [(name, size) for name, size in sizes if size < 9] == []  # 9 pt are 12 px


@pytest.mark.slow
@pytest.mark.skipif(chromium() is None, reason="needs Chromium")
def test_printing_loses_no_column(tmp_path: Path) -> None:
    pytest.importorskip("playwright")
    head = ["world", *(f"a column with a long name, {i}" for i in range(11))]
    rows = [["with more wolves", *(["1,234.5 (1,000.5 … 2,345.6)"] * 11)]]
    file = tmp_path / "page.html"
    wide = written(panels(1, 12, 40, 3)[0], tmp_path / "wide.svg", "Wide")
    file.write_text(page("x", table(head, rows), wide), encoding="utf-8")
    with launched() as browser:
        shown = browser.new_page(viewport={"width": 718, "height": 1000})  # A4 with margins of 1 cm
        shown.goto(file.as_uri())
        shown.emulate_media(media="print")
        right, hidden = shown.evaluate("""() => [
            Math.max(...[...document.querySelectorAll('td, th, .plot')].map(x => x.getBoundingClientRect().right)),
            getComputedStyle(document.querySelector('.wide')).overflowX]""")
    assert right <= 718
    assert hidden == "visible"
