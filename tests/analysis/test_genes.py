"""Genes over time: values read from letters, means and spread, and selection of a known strength."""

from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco.analysis.figures import save
from ecs_eco.analysis.genes import course, edges_of, generation_time, haldanes, log_odds_slope, selection
from ecs_eco.analysis.genes_figures import alleles, courses
from ecs_eco.analysis.lineage import ALIVE, Lineage
from ecs_eco.genomes import Gene, Layout, layout_of
from ecs_eco.genomes.models import GenomeSection
from ecs_eco.life.kind import Kind
from ecs_eco.record.genomes import genes_of
from tests.analysis.families import FAMILY, GENES, family

GENE = {"name": "size", "letters": 3, "low": 0.5, "high": 4.0}


def recorded(layout):
    """What a manifest says of a layout's genes, for finches."""
    return {"finch": genes_of(SimpleNamespace(species=Kind(heredity=SimpleNamespace(layout=layout))))}


def of_texts(texts, genomes):
    return family([(i + 1, 0, 0, 0, ALIVE, text) for i, text in enumerate(texts)], genomes=genomes, end=0)


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"code": "gray"},
        {"scale": "log"},
        {"code": "additive", "codons": 4},
        {"whole": True, "low": 1},
        {"code": "gray", "scale": "log"},
        {"values": list(range(64)), "low": None, "high": None},
    ],
)
@pytest.mark.parametrize(
    "ploidy", [{}, {"ploidy": 2, "dominance": "mean"}, {"ploidy": 2, "dominance": "greater"}, {"ploidy": 2}]
)
def test_values_are_those_that_the_layout_decodes(more, ploidy):
    layout = Layout([Gene(**GENE | more)], "ACGT", **ploidy)
    loci = layout.random(np.arange(40, dtype=np.uint64))
    lineage = of_texts([layout.text(row) for row in loci], recorded(layout))
    assert lineage.values("size") == pytest.approx(layout.decode(loci)["size"], rel=1e-6)


@pytest.mark.parametrize("doubled", ["first", "mean", "sum", "greatest"])
@pytest.mark.parametrize("ploidy", [{}, {"ploidy": 2, "dominance": "mean"}])
def test_values_of_genes_without_a_place_are_those_that_the_layout_decodes(doubled, ploidy):
    layout = layout_of(
        GenomeSection(
            max_length=40,
            loci=40,
            copy_rule=doubled,
            **ploidy,
            genes=[
                {"name": "red", "promoter": "TA", "letters": 1, "values": [3, 1, 2, 0]},
                {"name": "size", "promoter": "GC", "letters": 2, "low": 1, "high": 15, "copies": 2},
            ],
        )
    )
    loci = layout.random(np.arange(60, dtype=np.uint64))
    loci[:20, :20] = layout.blank  # some have nothing at all in a string
    lineage = of_texts([layout.text(row) for row in loci], recorded(layout))
    for gene in ("red", "size"):
        assert lineage.values(gene) == pytest.approx(layout.decode(loci)[gene], rel=1e-6), gene


def test_a_gene_is_found_by_its_trait_and_others_have_no_value():
    rows = [(1, 0, 0, 0, ALIVE, "AT"), (2, 0, 0, 0, ALIVE, "TA"), (3, 0, 0, 0, ALIVE, "")]
    both = family(rows, species=["finch", "finch", "moss"], end=0)
    for name in ("red", "reflex.red.weight"):
        assert both.values(name)[:2].tolist() == [0, -1]
        assert np.isnan(both.values(name)[2])
    assert both.frequencies("finch", "reflex.red.weight", 1).values == ("0", "-1")


def test_misuse_of_values_is_refused():
    with pytest.raises(KeyError, match='did you mean "song"'):
        family().values("sung")
    with pytest.raises(ValueError, match="does not define what its codons"):
        family().values("beak")
    weights = {
        "finch": GENES["finch"]
        | {"genes": [{"name": "brain", "at": 0, "letters": 2, "trait": None, "weights": 9}]}
    }
    with pytest.raises(ValueError, match="codes for 9 weights"):
        family(genomes=weights).values("brain")
    with pytest.raises(ValueError, match="finch, robin have a gene with that name; choose one"):
        family(genomes=GENES | {"robin": GENES["finch"]}).values("red")


def test_the_course_of_a_gene_is_counted_among_the_living():
    song = course(family(), "finch", "song", 9)  # A and G mean 3, C means 1, T means 2
    assert song.n.tolist() == [2, 5]
    assert song.mean.tolist() == pytest.approx([3, (3 + 1 + 3 + 3 + 2) / 5])
    values = family().values("song")[family().alive(9)]
    assert song.sd.tolist() == pytest.approx([0, values.std()])
    assert song.share[1].tolist() == pytest.approx([(values == v).mean() for v in (1, 2, 3)])
    assert song.edges.tolist() == [0.5, 1.5, 2.5, 3.5]


def test_bins_are_about_each_value_or_equal():
    assert edges_of(np.array([1.0, 2.0, 4.0])).tolist() == [0.5, 1.5, 3.0, 5.0]
    assert edges_of(np.array([2.0, 2.0])).tolist() == [1.5, 2.5]
    assert edges_of(np.geomspace(1, 16, 99), log=True, bins=4) == pytest.approx([1, 2, 4, 8, 16])


def test_a_generation_is_the_mean_age_of_parents_at_births():
    #  of 1 at 2, of 1 and 2 at 3, of 3 and 4 (born at 2 and 3) at 5, of 5 (5) at 8, of 6 and 7 (8) at 9
    assert generation_time(family(), "finch") == pytest.approx(np.mean([2, 3, 3, 3, 2, 3, 1, 1]))
    assert np.isnan(generation_time(family(FAMILY[:2]), "finch"))


@pytest.mark.parametrize("s", [-0.3, 0.0, 0.05, 0.4])
def test_selection_in_a_population_without_overlap_is_ln_of_fitness(s):
    p, found = 0.3, []
    for _ in range(30):  # haploid selection, exact: p' = p (1 + s) / mean fitness
        found.append(p)
        p = p * (1 + s) / (1 + p * s)
    assert log_odds_slope(np.array(found), np.arange(30), 1000) == pytest.approx(np.log1p(s), abs=1e-9)


def test_lost_and_fixed_alleles_and_empty_samples_weigh_nothing():
    p = 1 / (1 + np.exp(-0.2 * np.arange(-5, 5)))
    with_ends = np.concatenate([p, [1.0, 1.0, np.nan]])
    assert log_odds_slope(with_ends, np.arange(13), 50) == pytest.approx(0.2)
    assert np.isnan(log_odds_slope(np.array([0.0, 0.5, 1.0]), np.arange(3)))


def overlapping(ratio, ticks=400, n=1500, death=0.05, seed=0):
    """A lineage of n in which those with a T die at `death`, others at `ratio` times that; each of the dead
    is replaced by a child of one who lives."""
    rng = np.random.default_rng(seed)
    living = np.arange(n)
    carries = list(rng.random(n) < 0.3)
    parent, born, died = [-1] * n, [0] * n, [ALIVE] * n
    for tick in range(1, ticks):
        has = np.array([carries[i] for i in living])
        dies = rng.random(n) < death * np.where(has, 1.0, ratio)
        parents = rng.choice(living[~dies], dies.sum())
        for i in living[dies]:
            died[i] = tick
        new = np.arange(len(born), len(born) + len(parents))
        parent += parents.tolist()
        born += [tick] * len(new)
        died += [ALIVE] * len(new)
        carries += [carries[i] for i in parents]
        living = np.concatenate([living[~dies], new])
    uid = np.arange(1, len(born) + 1, dtype=np.uint64)
    none = np.zeros(len(uid), np.uint64)
    born, died = np.array(born), np.array(died)
    return Lineage(
        uid,
        np.array(parent) + 1,
        none,
        np.full(len(uid), "finch"),
        born,
        died,
        np.full(len(uid), ""),
        np.where(carries, "TA", "AA").astype(object),
        ticks - 1,
        1.0,
        GENES,
    )


@pytest.mark.parametrize("ratio", [1.0, 1.3])
def test_selection_of_a_known_strength_is_found_where_generations_overlap(ratio):
    lineage = overlapping(ratio)
    known = np.log((1 - 0.05) / (1 - 0.05 * ratio))  # survivors breed alike: only deaths change the odds
    found = selection(lineage, "finch", "red", "-1")
    assert found.per_tick == pytest.approx(known, abs=0.0015)
    assert found.generation == pytest.approx(20, rel=0.25)  # the mean life
    assert found.s == found.per_tick * found.generation
    assert found.first == pytest.approx(0.3, abs=0.04)
    early = selection(lineage, "finch", "red", "-1", until=100)
    assert early.samples < found.samples
    with pytest.raises(KeyError, match="did you mean"):
        selection(lineage, "finch", "red", "1")


def test_haldanes_are_standard_deviations_a_generation():
    lineage = overlapping(1.0, ticks=40, n=50)
    song = course(lineage, "finch", "red", 1)
    steady = SimpleNamespace(
        ticks=np.arange(11), mean=0.3 * np.arange(11), sd=np.full(11, 2.0), n=np.full(11, 5)
    )
    assert haldanes(steady, 20) == pytest.approx(0.3 / 2 * 20)
    assert np.isfinite(haldanes(song, 10))


def test_alleles_count_strings_and_are_drawn(tmp_path):
    rows = [(1, 0, 0, 0, ALIVE, "ATTT"), (2, 0, 0, 0, ALIVE, "CTAT"), (3, 0, 0, 0, ALIVE, "CGCG")]
    genomes = {"finch": GENES["finch"] | {"ploidy": 2}}
    beaks = family(rows, genomes=genomes, end=0).frequencies("finch", "beak", 1)
    assert dict(zip(beaks.values, beaks.copies[0].tolist(), strict=True)) == {"A": 2, "C": 3, "T": 1}
    assert beaks.allele[0].sum() == pytest.approx(1)
    lineage = family()
    drawn = alleles([lineage.frequencies("finch", gene, 1) for gene in ("red", "song")], "finch")
    assert [line.get_label() for line in drawn.axes[0].get_lines()] == [
        "red = -1",
        "song = 3",
        "song = 1",
        "song = 2",
    ]
    assert save(drawn, tmp_path / "alleles.png").stat().st_size > 5000
    shaded = courses([course(lineage, "finch", "song", 1)], {"song": "Song.length"}, "finch")
    assert shaded.axes[0].get_ylabel() == "Song.length"
    assert save(shaded, tmp_path / "courses.png").stat().st_size > 5000
