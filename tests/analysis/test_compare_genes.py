"""Genes of arms side by side: outcomes with intervals over runs, and what is drawn and written."""

import numpy as np
import pytest

from ecs_eco.analysis.compare_genes import bands, blocks, genes_of, summary
from tests.analysis.families import GENES, write_folder

GENOMES = {
    "finch": GENES["finch"]
    | {
        "genes": [
            GENES["finch"]["genes"][1],
            {
                "name": "size",
                "at": 1,
                "letters": 1,
                "trait": "body.mass",
                "range": {"low": 0.0, "high": 3.0, "code": "positional", "scale": "linear", "codons": 1},
            },
        ]
    }
}


def spreading(folder, chance, seed):
    """A run of 11 ticks, each a generation of 60: children have a T by this odds ratio to parents'."""
    rng = np.random.default_rng(seed)
    rows, uid, p = [], 1, 0.3
    before = [0] * 60
    for tick in range(11):
        genomes = [("T" if rng.random() < p else "A") + rng.choice(list("ACGT")) for _ in range(60)]
        rows += [(uid + i, before[i], 0, tick, tick + 1 if tick < 10 else -1, genomes[i]) for i in range(60)]
        before, uid = [uid + i for i in range(60)], uid + 60
        p = np.mean([g[0] == "T" for g in genomes])
        p = p * chance / (1 - p + p * chance)
    return write_folder(folder, rows, genomes=GENOMES)


@pytest.fixture(scope="module")
def arms(tmp_path_factory):
    out = tmp_path_factory.mktemp("arms")
    return {
        arm: [spreading(out / f"{arm}-{k}", chance, 10 * k) for k in range(6)]
        for arm, chance in (("world", 1.5), ("neutral", 1.0))
    }


ROWS = {arm: [list(range(6))] for arm in ("world", "neutral")}


def test_selection_of_each_arm_has_an_interval_over_runs(arms):
    genes = genes_of(arms)
    assert [gene.label for gene in genes] == ["red = -1", "size"]
    red = summary(genes, ROWS, "world")["finch"]["red = -1"]
    s, low, high = red["arms"]["world"]["s"]
    assert low < np.log(1.5) < high
    assert low < s < high
    assert red["arms"]["neutral"]["s"][1] < 0 < red["arms"]["neutral"]["s"][2]
    assert red["arms"]["world"]["generation"][0] == 1
    assert red["arms"]["world"]["n"] == 6
    gap = red["against"]["neutral"]["s"]
    assert gap[0] == pytest.approx(red["arms"]["neutral"]["s"][0] - s)
    assert gap[2] < 0


def test_quantitative_genes_have_mean_spread_and_rate(arms):
    size = summary(genes_of(arms), ROWS, "world")["finch"]["size"]
    world = size["arms"]["world"]
    assert world["first"][0] == pytest.approx(1.5, abs=0.15)
    assert world["sd_last"][0] == pytest.approx(np.sqrt(1.25), abs=0.15)
    assert world["haldanes"][1] < 0 < world["haldanes"][2]
    assert set(size["against"]["neutral"]) == {"last", "haldanes"}


def test_rows_of_training_seeds_are_replicates_too(arms):
    rows = {"world": [[0, 1, 2], [3, 4, 5]], "neutral": [[0, 1, 2]]}
    red = summary(genes_of(arms), rows, "world")["finch"]["red = -1"]
    flat = summary(genes_of(arms), ROWS, "world")["finch"]["red = -1"]
    assert red["arms"]["world"]["s"][0] == pytest.approx(flat["arms"]["world"]["s"][0])
    assert red["against"]["neutral"]["s"][2] < 0


def test_bands_are_students_t_over_runs(arms):
    red = genes_of(arms)[0]
    band, curves = bands(red)["world"], np.array(red.curves["world"])
    assert band.ticks.tolist() == list(range(11))
    half = 2.5705818 * curves[:, 4].std(ddof=1) / np.sqrt(6)  # Student's t of 5 degrees of freedom
    assert band.mean[4] == pytest.approx(curves[:, 4].mean())
    assert band.high[4] - band.mean[4] == pytest.approx(half)


def test_page_and_figures_are_written_and_tables_have_every_arm(arms, tmp_path):
    genes = genes_of(arms)
    parts = "".join(blocks(tmp_path, genes, summary(genes, ROWS, "world"), "world"))
    assert {p.name for p in (tmp_path / "figures").iterdir()} == {"alleles-0.svg", "genes-0.svg"}
    assert parts.count(">neutral</td>") == 4
    assert "Differences from world" in parts


def test_runs_without_genomes_or_folders_have_no_genes(arms):
    assert genes_of({"world": [{"finch": [1, 2, 3]}]}) == []
    assert blocks(None, [], {}, "world") == []
