"""Reports of synthetic run folders: ordinary ones, and everything odd that a run may be."""

import json
import re
import runpy
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest

from ecs_eco.analysis import figures
from ecs_eco.analysis.report import rerun, write_report
from ecs_eco.analysis.report.write import ages_at_death, last_snapshot, ledger_gap
from ecs_eco.analysis.runs import load_series

chains = SimpleNamespace(**runpy.run_path(str(Path(__file__).parents[1] / "chains.py")))


@pytest.fixture
def empty_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made but not laid out and written, which takes most of the time of a report.

    For tests of what a report says; the other tests write the figures of such runs.
    """

    def save_svg(_: object, path: Path) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text('<svg viewBox="0 0 1 1"></svg>', encoding="utf-8")
        return path

    monkeypatch.setattr(figures, "save_svg", save_svg)


def words(page: Path) -> str:
    """What a reader sees of a page."""
    text = re.sub(
        r"<(style|head|pre).*?</\1>|data:image[^\"]*", " ", page.read_text(encoding="utf-8"), flags=re.S
    )
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", text))


@pytest.mark.slow
def test_a_run_in_which_all_persist_and_cycle(tmp_path: Path) -> None:
    run = chains.write_run(tmp_path / "run", chains.chain(4000, seed=1), events=False)
    page = write_report(run)
    text = words(page)
    assert page == run / "report.html"
    assert "All 3 species persisted to tick 4,000." in text
    assert re.search(r"deer cycles: a period of 2\d\d ticks, 1\d\.\d periods, p ≤ 0.002", text)
    assert re.search(r"wolf follows deer by 0\.2[5-9] of a period", text)
    assert "The ledger closes" in text
    assert "ecs-eco run predator-prey --seed 1 --ticks 4000" in page.read_text()
    drawn = {p.stem for p in (run / "figures").iterdir()}
    assert drawn == {"populations", "spectra", "lags", "phase", "deaths", "energy", "flows"}


@pytest.mark.usefixtures("empty_pictures")
def test_interventions_have_a_table_with_a_row_for_what_was_done_many_times(tmp_path: Path) -> None:
    run = chains.write_run(tmp_path / "run", chains.chain(300), events=False)
    assert "Interventions" not in words(write_report(run))
    manifest = json.loads((run / "manifest.json").read_text())
    cull, stop = {"kind": "cull", "species": "<deer>", "count": 7}, {"kind": "switch", "reproduction": False}
    manifest["intervened"] = [[10, cull], [20, cull], [20, stop], [30, cull]]
    (run / "manifest.json").write_text(json.dumps(manifest))
    text = words(write_report(run))
    assert "tick times what 10 to 30 3 cull 7 &lt;deer&gt; 20 1 reproduction off for all" in text
    assert "a dashed line marks an intervention" in text


@pytest.mark.slow
def test_a_page_asks_for_nothing_from_outside(tmp_path: Path) -> None:
    page = write_report(chains.write_run(tmp_path / "run", chains.chain(200))).read_text()
    assert not re.findall(r"""(?:src|href)=["'](?!data:|#)""", page)
    assert "://" not in page
    assert not list((tmp_path / "run").glob(".report*"))


@pytest.mark.usefixtures("empty_pictures")
def test_the_extinct_are_named_with_when_and_why(tmp_path: Path) -> None:
    numbers = chains.chain(300)
    numbers[:, 2] = np.concatenate([np.full(100, 40), np.arange(40, 0, -1), np.zeros(160)])
    run = chains.write_run(tmp_path / "run", numbers)
    text = words(write_report(run))
    assert "1 of 3 species died out; grass, deer persisted to tick 300." in text
    assert "wolf died out at tick 140." in text
    series = load_series(run)
    # the last tick with at least half of 40 is tick 120
    end = series.columns["died: starved"][121:141, 2].sum() / series.columns["deaths"][121:141, 2].sum()
    assert "At tick 120, there were 20; " in text
    assert f"{series.columns['deaths'][121:141, 2].sum():.0f} deaths followed: " in text
    assert f"starved {end:.0%}" in text


@pytest.mark.usefixtures("empty_pictures")
def test_a_run_too_short_for_cycles_says_so(tmp_path: Path) -> None:
    text = words(write_report(chains.write_run(tmp_path / "run", chains.chain(20))))
    assert "too short to look for cycles: 18 ticks remain" in text


@pytest.mark.slow
@pytest.mark.parametrize("ticks", [0, 1, 2])
def test_a_run_of_hardly_any_ticks_is_reported(tmp_path: Path, ticks: int) -> None:
    text = words(write_report(chains.write_run(tmp_path / "run", chains.chain(5)[:ticks])))
    assert ("The run has no ticks." in text) == (ticks == 0)


@pytest.mark.usefixtures("empty_pictures")
def test_a_single_species_is_reported(tmp_path: Path) -> None:
    run = chains.write_run(tmp_path / "run", chains.chain(1500)[:, :1], species=("grass",))
    text = words(write_report(run))
    assert "The only species, grass, persisted to tick 1,500." in text
    assert "Lags between species" not in text or "follows grass" not in text


@pytest.mark.usefixtures("empty_pictures")
def test_a_species_without_animals_is_named_and_does_not_count_as_extinct(tmp_path: Path) -> None:
    numbers = chains.chain(600)
    numbers[:, 2] = 0
    text = words(write_report(chains.write_run(tmp_path / "run", numbers)))
    assert "All 2 species persisted" in text
    assert "Never present: wolf." in text


def test_everybody_dead_from_the_start_is_reported(tmp_path: Path) -> None:
    text = words(write_report(chains.write_run(tmp_path / "run", np.zeros((50, 3), np.int64))))
    assert "No species had a living member" in text
    assert "No organism died." in text


@pytest.mark.usefixtures("empty_pictures")
def test_an_interrupted_run_says_so(tmp_path: Path) -> None:
    run = chains.write_run(tmp_path / "run", chains.chain(50))
    manifest = json.loads((run / "manifest.json").read_text()) | {"finished": False, "ticks": 1000}
    (run / "manifest.json").write_text(json.dumps(manifest))
    assert "50 of 1,000 ticks of 1 s (interrupted)" in words(write_report(run))


@pytest.mark.slow
def test_names_from_the_world_cannot_break_the_page(tmp_path: Path) -> None:
    names = ("<b>grass", "deer & co", "wolf")
    page = write_report(chains.write_run(tmp_path / "run", chains.chain(30), species=names)).read_text()
    assert "<b>grass" not in page
    assert "&lt;b&gt;grass" in page


def test_a_gap_in_the_ledger_is_found_where_it_is(tmp_path: Path) -> None:
    series = load_series(chains.series_table(chains.chain(50)))
    assert max(gap for gap, _, _ in ledger_gap(series).values()) < 1e-9
    series.columns["burnt"][30, 1] += 5
    gap, share, tick = ledger_gap(series)["deer"]
    assert (gap, tick) == (pytest.approx(5), 30)
    assert share == pytest.approx(5 / series.of("deer", "stock_after").max())
    series.columns["stock_before"][40, 2] += 3
    series.columns["taken_in"][40, 2] -= 3  # this tick closes, but does not start with what there was
    assert ledger_gap(series)["wolf"][::2] == (pytest.approx(3), 40)


def test_a_cause_that_first_occurs_in_a_later_part_counts_as_zero_before(tmp_path: Path) -> None:
    run = chains.write_run(tmp_path / "run", chains.chain(1500), events=False)
    first = run / "series" / "part-00000.parquet"
    pq.write_table(pq.read_table(first).drop_columns(["died: too old"]), first)
    series = load_series(run)
    assert series.of("deer", "died: too old")[:1000].sum() == 0
    assert series.of("deer", "died: too old")[1000:].sum() > 0


def test_events_are_summed_over_parts(tmp_path: Path) -> None:
    run = chains.write_run(tmp_path / "run", chains.chain(200))
    deaths = load_series(run).columns["deaths"].sum(0)
    assert ages_at_death(run) == {s: (int(n), 42.0) for s, n in zip(chains.SPECIES, deaths, strict=True)}


def test_the_last_snapshot_has_everybody(tmp_path: Path) -> None:
    numbers = chains.chain(10)
    tick, at = last_snapshot(chains.write_run(tmp_path / "run", numbers), chains.SPECIES)
    assert tick == 9
    assert [len(at[s]) for s in chains.SPECIES] == numbers[-1].tolist()
    assert last_snapshot(tmp_path, chains.SPECIES) is None


def test_the_command_names_what_differs_from_an_ordinary_run() -> None:
    manifest = {"world": "reflexes", "seed": 7, "ticks": 90}
    assert rerun(manifest) == "ecs-eco run reflexes --seed 7 --ticks 90 --out DIR"
    own = manifest | {"config": {"code": ["mine.py"]}, "target": {"mode": "portable"}}
    assert rerun(own) == "ecs-eco --portable run reflexes --seed 7 --ticks 90 --trust --out DIR"
    manifest |= {"policies": "random", "learn": False}
    assert (
        rerun(manifest) == "ecs-eco run reflexes --seed 7 --ticks 90 --policies random --no-learn --out DIR"
    )


def test_a_folder_that_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"no manifest\.json"):
        write_report(tmp_path)
    (tmp_path / "manifest.json").write_text("{}")
    with pytest.raises(FileNotFoundError, match="contains no series"):
        write_report(tmp_path)


@pytest.mark.slow
def test_two_million_births_are_reported_in_seconds(tmp_path: Path) -> None:
    numbers = chains.chain(10_000, period=700)
    numbers[:, 0] = numbers[:, 0] * 2
    run = chains.write_run(tmp_path / "run", numbers)
    write_report(run)  # imports and font caches
    start = time.process_time()
    write_report(run)
    assert time.process_time() - start < 20  # it took 5.1 with both processors busy
