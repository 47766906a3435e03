"""Frequencies of alleles counted by hand and against `Lineage.frequencies`."""

import numpy as np
import pytest

from ecs_eco.analysis.lineage import ALIVE
from ecs_eco.explain import Allele, alleles, follow, shares
from tests.analysis.families import FAMILY, family
from tests.explain.populations import population


@pytest.fixture(autouse=True)
def count_all(monkeypatch):
    monkeypatch.setattr(alleles, "FEWEST", 1)


def test_frequencies_are_those_that_the_lineage_counts():
    lineage = family()
    paths = follow(lineage, "finch", every=1)
    cases = {("letter", 0): (0, 1), ("letter", 1): (1, 1), ("value", "red"): "red", ("value", "song"): "song"}
    checked = 0
    for j, allele in enumerate(paths.alleles):
        for (kind, place), gene in cases.items():
            if allele.kind == kind and place in (allele.locus, allele.gene):
                counted = lineage.frequencies("finch", gene, 1)
                assert np.allclose(paths.p[:, j], counted.of(allele.value) / counted.n), allele
                checked += 1
    assert checked >= 9
    assert paths.n.tolist() == lineage.living_sums(paths.ticks).tolist()


def test_gains_and_variances_are_sums_over_organisms():
    lineage = population(2, n=60, ticks=80, loci=3, ploidy=2, parents=2)
    paths = follow(lineage, "a", every=10)
    for j, allele in enumerate(paths.alleles):
        x = shares(lineage, allele)
        for k, tick in enumerate(paths.ticks):
            living = x[lineage.alive(int(tick))]
            assert paths.p[k, j] == pytest.approx(living.mean())
            assert paths.variance[k, j] == pytest.approx(living.var())
        steps = paths.steps
        of = steps.maternal if allele.kind == "clade" else steps.both
        gain = np.bincount(steps.step, of.excess * x[steps.organism], len(paths.ticks) - 1)
        assert np.allclose(paths.gain[:, j], gain)
    assert {allele.kind for allele in paths.alleles} == {"letter", "haplotype", "clade"}


def test_shares_of_two_strings_are_halves():
    rows = [(1, 0, 0, 0, ALIVE, "AATA"), (2, 1, 0, 1, ALIVE, "TATA")]
    genes = {"finch": {"alphabet": "AT", "ploidy": 2, "genes": []}}
    lineage = family(rows, genomes=genes)
    assert shares(lineage, Allele("finch", "letter", "", 0, "T")).tolist() == [0.5, 1]
    assert shares(lineage, Allele("finch", "haplotype", "", -1, "TA")).tolist() == [0.5, 1]
    assert shares(lineage, Allele("finch", "clade", "", -1, "1")).tolist() == [1, 1]


def test_variable_length_genomes_have_copies_and_values_but_no_loci():
    kept = {
        "alphabet": "ACGT",
        "ploidy": 1,
        "longest": 12,
        "separator": "|",
        "genes": [
            {"name": "red", "promoter": "TA", "letters": 1, "trait": None, "values": [0.0, 0.0, 0.0, -1.0]}
        ],
    }
    rows = [(1, 0, 0, 0, ALIVE, "TAA"), (2, 1, 0, 1, ALIVE, "TAATAT"), (3, 1, 0, 2, ALIVE, "G")]
    lineage = family(rows, end=3, genomes={"finch": kept})
    paths = follow(lineage, "finch", every=1)
    names = [allele.name for allele in paths.alleles]
    limits = [
        "0 copies of red",
        "1 or more copies of red",
        "1 or fewer copies of red",
        "2 or more copies of red",
    ]
    assert names[:5] == [*limits, "red = 0"]
    assert [shares(lineage, allele).tolist() for allele in paths.alleles[:2]] == [[0, 0, 1], [1, 1, 0]]
    assert shares(lineage, paths.alleles[3]).tolist() == [0, 1, 0]
    assert paths.p[-1, :4] == pytest.approx([1 / 3, 2 / 3, 2 / 3, 1 / 3])
    assert shares(lineage, paths.alleles[4]).tolist() == [1, 0.5, 0]
    assert paths.p[-1, 4] == pytest.approx(0.5)


def test_letters_beyond_ascii_and_missing_genomes_are_counted():
    rows = [(*row[:5], row[5].replace("A", "α")) for row in FAMILY]
    greek = follow(
        family(rows, genomes={"finch": {"alphabet": "αCGT", "ploidy": 1, "genes": []}}), "finch", 1
    )
    plain = follow(family(genomes={"finch": {"alphabet": "ACGT", "ploidy": 1, "genes": []}}), "finch", 1)
    assert sorted(a.value.replace("α", "A") for a in greek.alleles) == sorted(a.value for a in plain.alleles)
    rows = [*FAMILY[:-1], (*FAMILY[-1][:5], "")]
    missing = follow(
        family(rows, genomes={"finch": {"alphabet": "ACGT", "ploidy": 1, "genes": []}}), "finch", 1
    )
    first = [j for j, a in enumerate(missing.alleles) if a.locus == 0]
    assert missing.p[9, first].sum() == pytest.approx(4 / 5)  # of five living finches, one has none


def test_without_genomes_there_are_clades_alone():
    rows = [(*row[:5], "") for row in FAMILY]
    assert {allele.kind for allele in follow(family(rows, genomes={}), "finch", 1).alleles} == {"clade"}


def test_other_species_have_no_share():
    lineage = family(species=["finch"] * 8 + ["cat"])
    assert np.isnan(shares(lineage, Allele("finch", "letter", "beak", 0, "T"))[-1])
    with pytest.raises(KeyError, match="dog"):
        follow(lineage, "dog")
