"""Every figure draws, on ordinary runs and on odd ones; what can be counted in it is counted."""

import copy
import runpy
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco.analysis import figures
from ecs_eco.analysis.cycles import cross_seed_surrogates, cycle_statistics
from ecs_eco.analysis.nervous_figure import draw_nervous_system
from ecs_eco.analysis.page import drawn
from ecs_eco.analysis.palette import FLOWS, safe
from ecs_eco.analysis.runs import Series, load_series
from ecs_eco.analysis.spectrum import spectral_peak
from ecs_eco.analysis.style import colors_of, fills
from ecs_eco.analysis.survival import kaplan_meier
from ecs_eco.config import load
from ecs_eco.engine.errors import ForeignFile

chains = SimpleNamespace(**runpy.run_path(str(Path(__file__).with_name("chains.py"))))
PAIRS = [("grass", "deer"), ("deer", "wolf")]


@pytest.fixture(scope="module")
def run() -> Series:
    numbers = chains.chain(1200)
    numbers[1000:, 2] = 0
    return load_series(chains.series_table(numbers))


def test_no_figure_is_written_through_a_link_that_leads_out(tmp_path: Path, run: Series) -> None:
    for name in ("mine", "run", "other"):
        (tmp_path / name).mkdir()
    (tmp_path / "mine" / "numbers.svg").write_text("mine")
    (tmp_path / "run" / "figures").symlink_to(tmp_path / "mine")
    with pytest.raises(ForeignFile, match=r"run/figures: is a link that leads out of .*run"):
        drawn(figures.populations(run), tmp_path / "run" / "figures" / "numbers.svg", "")
    assert [p.read_text() for p in (tmp_path / "mine").iterdir()] == ["mine"]
    drawn(figures.populations(run), tmp_path / "other" / "figures" / "numbers.svg", "")
    assert (tmp_path / "other" / "figures" / "numbers.svg").is_file()


def test_populations_give_the_numerous_species_its_own_axis(run: Series) -> None:
    left, right = figures.populations(run).axes
    assert [line.get_label() for line in right.get_lines()] == ["grass"]
    assert list(left.get_lines()[-1].get_xdata()) == [1000]  # the cross where the wolves end
    assert right.get_ylim()[0] == 0


@pytest.mark.parametrize("recurs", [True, False])
def test_a_spectrum_has_a_p_value_only_if_its_period_recurs(recurs: bool) -> None:
    peak = spectral_peak(9 + np.sin(2 * np.pi * np.arange(600) / 30), n_boot=99)
    assert (peak.recurs, peak.p <= 0.01) == (True, True)
    title = figures.spectra({"hare": peak if recurs else replace(peak, held=2.0)}).axes[0].get_title("left")
    assert title == ("hare: 30 ticks, p = 0.01" if recurs else "hare: no recurring period")


def test_populations_of_one_species_need_one_axis(run: Series) -> None:
    assert len(figures.populations(load_series(run, ("deer",))).axes) == 1


def test_a_line_marks_each_intervention_and_its_words_stand_at_the_first_of_its_kind(run: Series) -> None:
    cull = {"kind": "cull", "species": "wolf", "share": 0.5}
    done = [
        [100, cull],
        [400, cull],
        [400, {"kind": "fence", "line": [[1, 2], [3, 4]]}],
        [401, {"kind": "switch", "learning": False}],
    ]
    marked = load_series(run)
    marked.manifest["intervened"] = done
    try:
        ax = figures.populations(marked).axes[-1]
    finally:
        del marked.manifest["intervened"]
    assert [line.get_xdata()[0] for line in ax.get_lines() if line.get_linestyle() == "--"] == [100, 400, 401]
    assert [(text.xy[0], text.get_text()) for text in ax.texts] == [
        (100, "cull 50% of wolf"),
        (400, "fence along [1, 2] [3, 4]"),
    ]
    assert not figures.populations(run).axes[-1].texts


@pytest.mark.slow
def test_notebooks_show_every_figure_as_a_picture_without_pyplot(run: Series) -> None:
    drawn = [
        figures.populations(run),
        figures.phase(run, PAIRS),
        figures.deaths(run),
        draw_nervous_system(load("reflexes"), "goat"),
    ]
    for figure in [*drawn, copy.deepcopy(drawn[0])]:
        assert figure._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]


def test_phase_plots_begin_at_the_first_tick(run: Series, tmp_path: Path) -> None:
    figure = figures.phase(run, PAIRS)
    assert len(figure.axes) == 3  # two pairs and the colour bar
    assert figure.axes[1].get_xlabel() == "deer"
    assert figures.save(figure, tmp_path / "deep" / "phase.png").stat().st_size > 5000


def test_deaths_stack_to_all_deaths(run: Series) -> None:
    figure = figures.deaths(run)
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["grass", "deer", "wolf"]
    top = max(area.get_paths()[0].vertices[:, 1].max() for area in figure.axes[1].collections)
    binned = run.of("deer", "deaths").reshape(120, 10).mean(1)
    assert top == pytest.approx(binned.max())


def test_being_eaten_has_the_color_of_the_eater_and_nothing_else_that_of_a_species(run: Series) -> None:
    hue, looks = colors_of(run), fills(run)
    assert [looks[f"eaten by {eater}"][0] for eater in ("deer", "wolf")] == [hue["deer"], hue["wolf"]]
    others = [looks["starved"][0], looks["too old"][0], *FLOWS.values()]
    assert not {*others} & {*hue.values()}
    assert len({*others}) == len(others)
    assert len({hatch for _, hatch in looks.values()}) == len(looks)


def test_energy_flows_are_drawn_on_both_sides_of_zero(run: Series) -> None:
    low, high = figures.energy(run).axes[1].get_ylim()
    assert low < 0 < high


def test_spectra_and_lags_draw_with_and_without_surrogates(run: Series, tmp_path: Path) -> None:
    statistics = cycle_statistics(run, n_boot=49)
    assert len(figures.spectra(statistics.peaks).axes) == 3
    plain = figures.lags(run, PAIRS, statistics.period)
    assert len(plain.axes[0].collections) == 0
    runs = [dict(zip(chains.SPECIES, chains.chain(1200, s).T, strict=True)) for s in range(4)]
    surrogates = {f"{a}→{b}": cross_seed_surrogates(runs, a, b, 250) for a, b in PAIRS}
    banded = figures.lags(run, PAIRS, statistics.period, surrogates)
    assert len(banded.axes[0].collections) == 1
    figures.save(banded, tmp_path / "lags.png")


@pytest.mark.parametrize(("size", "label"), [([100.0, 50.0], "y [m]"), ([30.0, 30.0, 20.0], "z [m]")])
def test_a_map_shows_a_plane_from_above_and_a_volume_from_the_side(size: list[float], label: str) -> None:
    at = {"deer": np.array([[1.0, 2, 3], [4, 5, 6]]), "wolf": np.array([[7.0, 8, 9]])}
    (ax,) = figures.positions(at, size, figures.colors(["deer", "wolf"])).axes
    assert ax.get_ylabel() == label
    assert ax.get_xlim() == (0, size[0])
    assert ax.get_ylim() == (0, size[-1])
    assert ax.collections[0].get_offsets()[1].tolist() == [4, 5 if len(size) == 2 else 6]


def test_a_map_of_very_many_has_a_dot_in_each_place_that_can_be_told_apart() -> None:
    rng = np.random.default_rng(5)
    xyz = rng.uniform(0, 90, (400_000, 3))
    crowd = np.concatenate([xyz, np.full((1, 3), 90.0)])
    (ax,) = figures.positions({"grass": crowd}, [90.0, 90.0], figures.colors(["grass"])).axes
    shown = ax.collections[0].get_offsets()
    assert 0.98 * 300**2 < len(shown) <= 300**2 + 1
    assert shown[-1].tolist() == [90, 90]
    assert ax.collections[0].get_label() == "grass (400,001)"


def test_survival_starts_at_one(tmp_path: Path) -> None:
    figure = figures.survival({"a": kaplan_meier([3, 5], [True, False]), "b": kaplan_meier([2], [True])}, 5)
    assert figure.axes[0].get_lines()[0].get_ydata().tolist() == [1, 0.5, 0.5]
    figures.save(figure, tmp_path / "survival.png")


def test_species_have_the_colours_nearest_to_those_of_their_world_and_others_different_ones() -> None:
    colours = figures.colors(["grass", "deer", "wolf"], {"deer": "#123456"})
    assert colours["deer"] == safe({"deer": "#123456"})["deer"]
    assert len(set(colours.values())) == 3


def test_importing_the_figures_loads_no_matplotlib() -> None:
    code = "import sys, ecs_eco.analysis.figures; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_no_arm_is_cut_off_where_another_has_smaller_numbers() -> None:
    few, many = (load_series({"deer": np.full(50, n)}) for n in (10.0, 900.0))
    figure = figures.arms({"few": [few], "many": [many]})
    for ax in figure.axes:
        assert ax.get_ylim()[0] == 0
        assert ax.get_ylim()[1] > 900
