"""Curves, CSV, story, report, account and Parquet of a run say the same numbers.

The truth is counted one by one from births and deaths. CSV files are those that a page saves.
"""

import re
from collections import Counter
from html.parser import HTMLParser

import numpy as np
import pyarrow.parquet as pq
import pytest

from ecs_eco.analysis.extinction import declines
from ecs_eco.analysis.flows import flows
from ecs_eco.analysis.page import number
from ecs_eco.analysis.report import write_report
from ecs_eco.analysis.runs import DIED, Series, load_series
from ecs_eco.analysis.why import Case, diagnose, write_why
from ecs_eco.analysis.why.page import happened
from ecs_eco.record import run_to_folder
from ecs_eco.record.parquet import read_parts
from ecs_eco.testing.browser import served
from ecs_eco.view.replay import Replay
from ecs_eco.view.story import NAMED, Story
from tests.view.pages import IN_A_BROWSER, OF_RUN, opened
from tests.view.ten_worlds import SLOW, WORLDS, small

TICKS = 120
HALF = "the last with at least half of the peak"
WINDOW = r"Deaths since tick ([\d,]+) \((.*?)\): ([\d,]+) \((.*?)\)\."


@pytest.fixture(
    scope="module", params=[pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in WORLDS]
)
def run(request, tmp_path_factory):
    """A recorded run of a small world."""
    out = tmp_path_factory.mktemp("agree") / "run"
    run_to_folder(
        small(request.param), seed=8, ticks=TICKS, out=out, policies="random", report=False, snapshot_every=5
    )
    return out


@pytest.fixture(scope="module")
def truth(run):
    """By tick and species: living, born, dead, and dead by cause; founders are born before the first tick."""
    born, died, by_cause = Counter(), Counter(), Counter()
    for event in read_parts(run / "births").to_pylist():
        born[event["tick"], event["species"]] += 1
    for event in read_parts(run / "deaths").to_pylist():
        died[event["tick"], event["species"]] += 1
        by_cause[event["tick"], event["species"], event["cause"]] += 1
    return born, died, by_cause


@pytest.fixture(scope="module")
def series(run):
    return load_series(run)


def total(events, *kind):
    """The events of all ticks of this species, or species and cause."""
    return sum(n for (_, *of), n in events.items() if tuple(of) == kind)


def test_the_series_counts_every_birth_and_death(series, truth):
    born, died, by_cause = truth
    for i, s in enumerate(series.species):
        living = int(series.n[0, i] - series.of(s, "births")[0] + series.of(s, "deaths")[0])
        for row, tick in enumerate(series.ticks.tolist()):
            deaths = series.of(s, "deaths")[row]
            assert deaths == died[tick, s] == sum(series.of(s, DIED + c)[row] for c in series.causes)
            for cause in series.causes:
                assert series.of(s, DIED + cause)[row] == by_cause[tick, s, cause]
            if row:
                assert series.of(s, "births")[row] == born[tick, s]
            living += int(series.of(s, "births")[row] - deaths)
            assert series.n[row, i] == living


def test_curves_of_the_page_have_the_numbers_of_the_series(run, series):
    replay = Replay(run)
    replay.handle({"kind": "seek", "tick": TICKS - 1})
    message = replay.series(-1)
    rows = np.searchsorted(series.ticks, message["tick"])
    assert rows.tolist() == list(range(len(series.ticks)))
    for s in series.species:
        assert message["n"][s] == series.of(s).tolist()
        for curve, column in (("births", "births"), ("deaths", "deaths")):
            rates = message[curve][s]
            assert [x for x in rates if x is not None] == pytest.approx(
                series.of(s, column)[[x is not None for x in rates]]
            )
        curves, of = (
            message.get("causes", {}).get(s, {}),
            {c for c in series.causes if series.of(s, DIED + c).any()},
        )
        assert {cause for cause, rates in curves.items() if any(rates)} == of
        for cause in of:
            known = [x is not None for x in curves[cause]]
            assert [x for x in curves[cause] if x is not None] == series.of(s, DIED + cause)[known].tolist()


class Cells(HTMLParser):
    """The rows of all tables of a page, as lists of texts."""

    def __init__(self, text):
        super().__init__()
        self.rows, self.inside = [], False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
        self.inside = tag in ("td", "th") or (self.inside and tag == "span")

    def handle_data(self, data):
        if self.inside and self.rows and self.rows[-1]:
            self.rows[-1][-1] += data


def test_tables_of_the_report_have_the_numbers_of_the_series(run, series, truth):
    rows = Cells(write_report(run).read_text(encoding="utf-8")).rows
    for s in series.species:
        first, mean, least, most, last, births, refused, deaths = next(
            row[1:9] for row in rows if row and row[0] == s and len(row) == 11
        )
        n = series.of(s)
        assert [first, mean, least, most, last] == [
            number(round(x)) for x in (n[0], n.mean(), n.min(), n.max(), n[-1])
        ]
        sums = [series.of(s, column).sum() for column in ("births", "refused", "deaths")]
        assert [births, refused, deaths] == [f"{x:,.0f}" for x in sums]
        causes = {row[1]: row[2] for row in rows if row and row[0] == s and len(row) == 4}
        known = {cause for _, of, cause in truth[2] if of == s}
        assert causes == {cause: f"{total(truth[2], s, cause):,}" for cause in known}


def test_the_account_has_the_numbers_of_the_series(run, series, truth):
    findings = write_why(run)
    for fell in findings["fell"]:
        s, span = fell["species"], range(fell["since"] + 1, fell["tick"] + 1)
        assert fell["deaths"] == sum(truth[1][tick, s] for tick in span)
        assert fell["births"] == sum(truth[0][tick, s] for tick in span)
        assert fell["from"] == series.of(s)[np.searchsorted(series.ticks, fell["since"])]
        if fell["extinct"]:
            assert fell["tick"] == series.extinct[series.index(s)]
    for s, energy in findings["energy"].items():
        for name, value in energy.items():
            column = series.columns.get(name)
            whole = 0.0 if column is None else series.of(s, name).sum()
            assert value == pytest.approx(whole / max(series.of(s).sum(), 1.0), rel=1e-6)


def test_an_extinction_is_told_alike_in_story_report_and_account(run, series, truth):
    replay = Replay(run)
    replay.handle({"kind": "seek", "tick": TICKS - 1})
    told = {e["species"]: e for e in replay.greeting()[1]["entries"] if e["kind"] == "extinct"}
    fell = {f["species"]: f for f in write_why(run)["fell"] if f["extinct"]}
    for end in declines(series):
        s, span = end.species, range(end.since + 1, end.tick + 1)
        by_cause = {c: sum(truth[2][tick, s, c] for tick in span) for c in end.causes}
        assert end.causes == by_cause
        if series.n[0, series.index(s)] == 0:
            continue  # gone within the first tick: no curve begins
        assert told[s]["tick"] == end.tick
        assert (fell[s]["since"], fell[s]["tick"]) == (end.since, end.tick)
        since, which, deaths, shares = re.match(WINDOW, told[s]["cause"]).groups()
        assert (deaths, since, which) == (f"{end.deaths:,}", f"{end.since:,}", HALF)
        named = {c: f"{k / end.deaths:.0%}" for c, k in by_cause.items() if k / end.deaths >= NAMED}
        assert {c: share for share, c in re.findall(r"(\d+%) ([^,]+)", shares)} == named


def test_each_decline_names_its_window_and_counts_the_deaths_within_it(tmp_path):
    """Deer crash from their last high, and `why` counts from the last tick with half of their peak."""
    numbers = [20] * 5 + [100] * 5 + [60] * 5 + [30] * 5 + [4] * 5
    story = Story(["deer"], {}, ["starved"].__getitem__, lambda s, now: None)
    died = np.cumsum(-np.diff(numbers, prepend=20).clip(max=0))
    for tick, n in enumerate(numbers):
        story.note(
            tick, np.array([n]), np.array([80 * (tick > 4)]), np.array([[died[tick]]]), np.array([True])
        )
    (crash,) = (entry for entry in story.entries if entry["kind"] == "crash")
    since, which, deaths, _ = re.match(WINDOW, crash["cause"]).groups()
    assert (crash["tick"], deaths, since, which) == (15, "70", "9", "last high")  # 40 and 30 died
    zero = np.zeros((len(numbers), 1))
    columns = {"n": np.array(numbers)[:, None], "births": zero, "deaths": np.diff(died, prepend=0)[:, None]}
    columns |= {DIED + "starved": columns["deaths"], "refused": zero, "taken_in": zero, "burnt": zero}
    case = Case(Series(np.arange(len(numbers)), ("deer",), columns, {}), {"species": {"deer": {}}})
    (fell,) = diagnose(case)["fell"]
    told = " ".join(happened(case, {"fell": [fell], "lowest": {}, "interventions": {}}))
    assert (
        f"deer nearly died out at tick 24; at tick 14 ({HALF}) there were 60. Deaths since then: 56 (" in told
    )


def test_parquet_files_are_what_readers_of_the_run_read(run, series):
    table = pq.ParquetDataset(run / "series").read().to_pydict()
    for row in range(0, len(table["tick"]), 7):
        s, at = table["species"][row], np.searchsorted(series.ticks, table["tick"][row])
        for column in ("n", "births", "deaths", "energy_mean"):
            if table.get(column) is not None:
                assert table[column][row] == pytest.approx(series.of(s, column)[at], nan_ok=True)


@pytest.fixture
def page(run, browser):
    """A page of the run that shows all charts."""
    with served("watch", str(run)) as command, opened(browser, command.address()) as page:
        page.evaluate("localStorage.setItem('ecs-eco-charts-2', '[]')")
        page.reload()
        page.get_by_label("Save the numbers: Births").wait_for()
        yield page


def of_series(series, title, name, unit):
    """The column of the series that a column of a saved file repeats; None for genes, which it has not."""
    species, _, what = name.partition(": ")
    columns = {"taken in": "taken_in", "burnt": "burnt"}
    match title, unit:
        case "Populations", "organisms":
            return series.of(species)
        case "Happiness", "mean happiness":
            return np.where(series.of(species) > 0, series.of(species, "happiness_mean"), np.nan)
        case "Births", "per tick":
            return series.of(species, "births")
        case "Deaths", "per tick":
            return series.of(species, DIED + what)
        case "Energy", "energy per tick":
            return series.of(species, columns[what])
        case "mean depth [m]", "m":
            return np.where(series.of(species) > 0, -series.of(species, "depth_mean"), np.nan)
        case "Genes", _:
            assert unit.startswith("mean")
            return None
    assert title == unit
    return series.of(series.species[0] if species == "the world" else species, title)


@IN_A_BROWSER[0]
@IN_A_BROWSER[1]
@IN_A_BROWSER[2]
def test_saved_numbers_are_those_of_parquet_and_the_flows_those_of_the_report(run, series, page):
    pandas, titles = pytest.importorskip("pandas"), []
    for button in page.locator("#charts [aria-label^='Save the numbers: ']").all():
        title = button.get_attribute("aria-label").removeprefix("Save the numbers: ")
        if title == "Who eats whom":
            continue
        with page.expect_download() as waiting:
            button.click()
        table = pandas.read_csv(waiting.value.path())
        titles.append(title)
        assert table["tick"].tolist() == series.ticks.tolist()
        for head in table.columns[1:]:
            name, unit = re.fullmatch(r"(.+) \[(.+)\]", head).groups()
            truth = of_series(series, title, name, unit)
            if truth is not None:
                assert table[head].tolist() == pytest.approx(truth, rel=1e-5, abs=1e-9, nan_ok=True), head
    assert {"Populations", "Births"} <= set(titles)
    replay, report = Replay(run), flows(series)
    said = page.evaluate(OF_RUN, [replay.hello(), replay.series(-1)])
    meals = {(meal["from"], meal["to"]): meal for meal in said["meals"]}
    nodes = {node["name"]: node for node in said["nodes"]}
    for meal in report.meals if report else ():
        shown = meals[meal.food, meal.eater]
        assert (shown["energy"], shown["meals"]) == pytest.approx(
            (meal.energy, meal.number), rel=1e-4, abs=1e-6
        )
    for name in nodes.keys() & (report.budgets.keys() if report else set()):
        shown, budget = nodes[name], report.budgets[name]
        for key in ("light", "other", "burnt", "dead"):
            assert shown[key] == pytest.approx(getattr(budget, key), rel=1e-4, abs=1e-5), (name, key)
            assert shown[key] >= 0
    assert (series.columns["lost"] >= 0).all()
