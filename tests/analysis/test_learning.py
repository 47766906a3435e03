"""Learning over time, from tables: curves by species, shares of actions, and the part of the report."""

import numpy as np
import pyarrow as pa
import pytest

from ecs_eco.analysis.learning import acts_of, diagnostics, summary, thinned, updates_of
from ecs_eco.analysis.report import write_report
from ecs_eco.record import run_to_folder
from ecs_eco.record.learning import UPDATE


def table(n=20):
    ticks, species = np.arange(2 * n), np.array(["deer", "wolf"] * n)
    columns = {word: np.linspace(k, k + 1, 2 * n) for k, word in enumerate(UPDATE)}
    return pa.table(
        {
            "tick": ticks,
            "species": species,
            "n_transitions": np.full(2 * n, 100),
            "n_learners": np.ones(2 * n, int),
            **columns,
        }
    )


def test_updates_are_by_species_and_summed_up_by_their_ends():
    deer = updates_of(table())["deer"]
    assert deer.ticks.tolist() == list(range(0, 40, 2))
    told = summary(deer, (np.arange(30), np.arange(30.0)))
    assert (told["updates"], told["transitions"]) == (20, 2000)
    assert told["reward"] == pytest.approx((1 / 39, 37 / 39))  # of the first and the last two
    assert told["happiness"] == (1, 28)


def test_actions_are_shares_of_those_that_decided():
    acts = acts_of(
        pa.table(
            {
                "tick": [10, 10, 20, 20],
                "species": ["deer"] * 4,
                "action": ["speed.walk", "eat.eat"] * 2,
                "n": [3, 1, 0, 4],
                "of": [4, 4, 4, 4],
            }
        )
    )
    assert acts["deer"].actions == ("speed.walk", "eat.eat")
    assert acts["deer"].share.tolist() == [[0.75, 0.25], [0, 1]]
    assert acts["deer"].groups == {"speed": [0], "eat": [1]}


def test_curves_are_thinned_by_means_without_what_is_undefined():
    ticks, values = thinned(np.arange(10), np.array([1, 3, np.nan, 5, np.nan, np.nan, 0, 2, 4, 6.0]), 5)
    assert ticks.tolist() == [0.5, 2.5, 4.5, 6.5, 8.5]
    assert values[[0, 1, 3, 4]].tolist() == [2, 5, 1, 5]
    assert np.isnan(values[2])


def test_a_species_is_drawn_in_its_colour():
    figure = diagnostics(updates_of(table()), {}, {"deer": "#111111", "wolf": "#222222"})
    assert [line.get_color() for line in figure.axes[0].get_lines()] == ["#111111", "#222222"]
    assert figure.axes[0].get_ylabel() == "reward per decision"


@pytest.mark.slow
def test_a_report_has_learning_where_there_was_some(menagerie, tmp_path):
    run_to_folder(menagerie(), seed=7, ticks=40, out=tmp_path / "run", policies="untrained", learn=True)
    page = (tmp_path / "run" / "report.html").read_text()
    assert "<h2>Learning</h2>" in page
    assert "<h2>Actions</h2>" in page
    assert (tmp_path / "run" / "figures" / "learning.svg").is_file()
    run_to_folder(menagerie(), seed=7, ticks=20, out=tmp_path / "still", policies="untrained", learn=False)
    page = write_report(tmp_path / "still").read_text()
    assert "<h2>Learning</h2>" not in page
    assert "<h2>Actions</h2>" in page
