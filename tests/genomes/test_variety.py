"""How genomes of a population differ, by hand-counted numbers."""

import numpy as np
import pytest
from deap import tools

from ecs_eco.genomes import DNA, Gene, Layout, diversity, frequencies, statistics

GENES = [
    Gene(name="red", letters=1, values=[0, 0, 0, -1]),
    Gene(name="n", letters=1, low=0, high=3, whole=True),
]


def rows(*texts: str) -> np.ndarray:
    return np.stack([DNA.encode(t) for t in texts])


def test_frequencies_count_values_not_letters() -> None:
    assert frequencies(Layout(GENES), rows("AC", "CC", "TA", "GT")) == {
        "red": {0: 0.75, -1: 0.25},
        "n": {0: 0.25, 1: 0.5, 3: 0.25},
    }


def test_frequencies_of_diploids_count_strings() -> None:
    assert frequencies(Layout(GENES[:1], ploidy=2), rows("AT", "TT"))["red"] == {-1: 0.75, 0: 0.25}


def test_diversity_is_the_chance_that_two_drawn_letters_differ() -> None:
    assert diversity(Layout(GENES), rows("AA", "AC", "AG", "AT")).tolist() == [0.0, 0.75]
    assert diversity(Layout(GENES[:1], ploidy=2), rows("AT", "AT")).tolist() == [0.5]
    assert diversity(Layout(GENES), np.zeros((0, 2), np.uint8)).tolist() == [0.0, 0.0]


def test_statistics_are_those_of_deap_over_what_the_genes_say() -> None:
    layout = Layout([*GENES, Gene(name="w", letters=1, low=0, high=1, form="direct")], shapes={"w": [(1, 1)]})
    stats = statistics(layout)
    assert isinstance(stats, tools.MultiStatistics)
    stats.register("median", np.median)
    record = stats.compile(rows("AAA", "ACA", "ATA"))
    assert sorted(record) == ["diversity", "n", "red"]
    assert record["n"] == {
        "mean": pytest.approx(4 / 3),
        "std": pytest.approx(np.std([0, 1, 3])),
        "min": 0,
        "max": 3,
        "median": 1,
    }
    assert record["diversity"]["max"] == pytest.approx(2 / 3)


def test_a_logbook_keeps_them_as_chapters() -> None:
    log, stats = tools.Logbook(), statistics(Layout(GENES))
    for tick, text in enumerate(("AA", "TT")):
        log.record(tick=tick, **stats.compile(rows(text)))
    assert log.select("tick") == [0, 1]
    assert log.chapters["red"].select("mean") == [0, -1]
    assert "diversity" in str(log)
