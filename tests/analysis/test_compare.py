"""Arms side by side: the numbers that are told, and the files that are left."""

import json
import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import combine_pvalues

from ecs_eco.analysis.compare import clean, compare

chains = SimpleNamespace(**runpy.run_path(str(Path(__file__).with_name("chains.py"))))


def dying(seed: int) -> np.ndarray:
    """A chain whose wolves are gone from tick 500 + 100 × seed on."""
    numbers = chains.chain(1500, seed)
    numbers[499 + 100 * seed :, 2] = 0
    return numbers


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, Path]:
    out = tmp_path_factory.mktemp("compared")
    trained = [chains.series_table(chains.chain(1500, seed), seed) for seed in range(5)]
    random = [chains.write_run(out / f"random-{seed}", dying(seed), seed, events=False) for seed in range(5)]
    return compare({"trained": trained, "random": random}, out / "result", n_boot=99), out / "result"


def test_persistence_and_extinction_are_counted(compared: tuple[dict, Path]) -> None:
    arms = compared[0]["arms"]
    assert (arms["trained"]["persisted"], arms["random"]["persisted"]) == (5, 0)
    assert arms["random"]["persistence"] == [0.0, 0.0, pytest.approx(0.434, abs=1e-3)]
    assert arms["random"]["seeds"] == [0, 1, 2, 3, 4]
    assert arms["trained"]["ticks"] == 1500
    assert "<td>1,500</td>" in (compared[1] / "compare.html").read_text()
    wolf = arms["random"]["per_species"]["wolf"]
    # the third of five
    assert (wolf["extinctions"], wolf["median_extinction"]) == (5, 699.0)
    assert arms["random"]["per_species"]["deer"]["median_extinction"] is None


def test_effects_have_intervals(compared: tuple[dict, Path]) -> None:
    effect = compared[0]["effects"]["random"]
    assert effect["persistence"][0] == -1
    assert effect["persistence"][2] < 0
    value, low, high = effect["per_species"]["wolf"]["lifetime"]
    assert value == pytest.approx(699 - 1500)
    assert low < value < high < 0
    assert effect["per_species"]["wolf"]["log_rank_p"] < 0.01
    assert effect["per_species"]["deer"]["log_rank_p"] == 1


def test_cycles_are_told_per_arm(compared: tuple[dict, Path]) -> None:
    trained = compared[0]["arms"]["trained"]
    assert trained["per_species"]["deer"]["cycling"] >= 3
    alone = [run["peaks"]["deer"]["p"] for run in trained["runs"]]
    assert trained["per_species"]["deer"]["pooled_p"] == pytest.approx(combine_pvalues(alone).pvalue)
    assert trained["lags"]["deer→wolf"]["median"] == pytest.approx(0.28, abs=0.04)
    assert trained["coupling"]["deer→wolf"]["p"] < 0.05
    assert compared[0]["arms"]["random"]["coupling"] == {}


def test_an_arm_without_a_species_has_the_coupling_of_the_others() -> None:
    chain = [chains.chain(1500, seed) for seed in range(5)]
    for numbers in chain:
        numbers[:, 2] = 0  # no wolves from the start
    tables = [chains.series_table(numbers, seed) for seed, numbers in enumerate(chain)]
    assert list(compare({"no wolves": tables}, n_boot=99)["arms"]["no wolves"]["coupling"]) == ["grass→deer"]


def test_the_files_hold_what_was_returned(compared: tuple[dict, Path]) -> None:
    result, out = compared
    assert json.loads((out / "compare.json").read_text()) == result
    page = (out / "compare.html").read_text()
    assert "0 (0 to 0.434)" in page
    assert page.count('class="plot') == 2  # the wolves' survival, and the numbers
    assert "://" not in page
    assert {p.name for p in (out / "figures").iterdir()} == {"numbers.svg", "survival_wolf.svg"}


def test_one_arm_and_one_short_run_are_enough() -> None:
    comparison = compare({"only": [chains.series_table(chains.chain(50))]})
    assert comparison["effects"] == {}
    assert comparison["arms"]["only"]["per_species"]["deer"]["long_enough"] == 0


def test_misuse_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one arm"):
        compare({})
    with pytest.raises(ValueError, match="'empty' has no runs"):
        compare({"empty": []})
    few = {"deer": np.ones(5), "wolf": np.ones(5)}
    with pytest.raises(ValueError, match="'b' has a run with deer, but the first arm has deer, wolf"):
        compare({"a": [few], "b": [{"deer": np.ones(5)}]})


def test_what_json_cannot_hold_becomes_null() -> None:
    assert clean({"a": (np.nan, np.int64(3), np.bool_(True)), "b": np.array([np.inf, 1.5])}) == {
        "a": [None, 3, True],
        "b": [None, 1.5],
    }


def test_a_species_that_was_never_there_did_not_die_out_and_is_compared_with_nobody(tmp_path: Path) -> None:
    numbers = [chains.chain(400, seed) for seed in range(3)]
    without = [n.copy() for n in numbers]
    for n in without:
        n[:, 2] = 0
    arms = {"world": numbers, "no-wolf": without}
    comparison = compare(
        {arm: [chains.series_table(n, i) for i, n in enumerate(runs)] for arm, runs in arms.items()},
        tmp_path,
        n_boot=19,
    )
    wolf = comparison["arms"]["no-wolf"]["per_species"]["wolf"]
    assert (wolf["extinctions"], wolf["median_extinction"], wolf["mean_time"]) == (0, None, None)
    assert set(comparison["effects"]["no-wolf"]["per_species"]) == {"grass", "deer"}
    assert not (tmp_path / "figures" / "survival_wolf.svg").exists()


def test_the_page_opens_with_the_world_and_the_clear_differences(tmp_path: Path) -> None:
    alone = [{"hare": [100 + k, 90, 95], "lynx": [5, 5, 5]} for k in range(4)]
    fed = [{"hare": [200 + k, 190, 195], "lynx": [5, 6, 5 - k % 2]} for k in range(4)]
    compare({"alone": alone, "fed": fed}, tmp_path, n_boot=9)
    text = (tmp_path / "compare.html").read_text()
    assert "<h1>2 arms compared</h1>" in text
    assert "fed: mean numbers differ from alone: hare +100 (" in text
    assert "lynx +" not in text[: text.index("<h2>")]
    compare({"alone": alone, "again": alone[::-1]}, tmp_path, n_boot=9)
    assert "again: no mean number differs clearly." in (tmp_path / "compare.html").read_text()
