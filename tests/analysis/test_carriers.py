"""Who carries which value of a gene, hand-counted; and how that is drawn."""

import pytest

from ecs_eco.analysis.carriers import carriers, numbers
from ecs_eco.analysis.figures import save
from ecs_eco.analysis.lineage import ALIVE
from tests.analysis.families import GENES, family


def test_frequencies_are_counted_among_the_living():
    frequencies = family().frequencies("finch", "beak", 3)
    assert frequencies.ticks.tolist() == [0, 3, 6, 9]
    assert frequencies.values == ("A", "C", "T")
    assert frequencies.count.tolist() == [[1, 1, 0], [2, 2, 0], [1, 2, 0], [2, 1, 2]]
    assert frequencies.n.tolist() == [2, 4, 3, 5]
    assert frequencies.share[2].tolist() == [1 / 3, 2 / 3, 0]
    assert frequencies.of("T").tolist() == [0, 0, 0, 2]


def test_codons_that_mean_the_same_are_one_value_in_the_order_of_codons():
    red = family().frequencies("finch", "red", 9)
    assert red.values == ("0", "-1")
    assert red.count.tolist() == [[2, 0], [3, 2]]
    song = family().frequencies("finch", "song", 9)  # A and G mean 3, C means 1, T means 2
    assert song.values == ("3", "1", "2")
    assert song.count.tolist() == [[2, 0, 0], [3, 1, 1]]


def test_a_gene_may_be_given_by_its_place():
    frequencies = family().frequencies("finch", (0, 2), 9)
    assert frequencies.values == ("AA", "AC", "CA", "CG", "TA", "TT")
    assert frequencies.count[1].tolist() == [1, 1, 0, 1, 1, 1]


def test_one_of_two_strings_is_enough_to_carry_a_value():
    # strings of two loci
    rows = [(1, 0, 0, 0, ALIVE, "ATTT"), (2, 0, 0, 0, ALIVE, "CTAT"), (3, 0, 0, 0, ALIVE, "CGCG")]
    beaks = family(rows, genomes={"finch": GENES["finch"] | {"ploidy": 2}}, end=0).frequencies(
        "finch", "beak", 1
    )
    assert dict(zip(beaks.values, beaks.count[0].tolist(), strict=True)) == {"A": 2, "C": 2, "T": 1}
    assert beaks.n.tolist() == [3]


def test_carriers_of_genes_without_a_place_are_found_by_promoters_once_for_each_value():
    genes = {
        "alphabet": "ACGT",
        "ploidy": 2,
        "longest": 12,
        "separator": "|",
        "genes": [
            {"name": "red", "promoter": "TA", "letters": 1, "trait": None, "values": [0.0, 0.0, 0.0, -1.0]},
            {"name": "size", "promoter": "GC", "letters": 2, "trait": None},
        ],
    }
    rows = [
        (1, 0, 0, 0, ALIVE, "TATTAT|TAA"),
        (2, 0, 0, 0, ALIVE, "GCTAC|C"),
        (3, 0, 0, 0, ALIVE, "ATAG|TAC"),
        (4, 0, 0, 0, ALIVE, "TA|GCAC"),
    ]
    finches = family(rows, genomes={"finch": genes}, end=0)
    red = finches.frequencies("finch", "red", 1)
    assert dict(zip(red.values, red.count[0].tolist(), strict=True)) == {"0": 2, "-1": 1}
    size = finches.frequencies("finch", "size", 1)  # TA within the first is no promoter
    assert dict(zip(size.values, size.count[0].tolist(), strict=True)) == {"AC": 1, "TA": 1}
    assert red.n.tolist() == [4]
    with pytest.raises(ValueError, match="genes have no fixed position"):
        finches.frequencies("finch", (0, 2), 1)


def test_codons_are_numbered_with_the_first_letter_first():
    size = {"name": "size", "letters": 2, "values": range(16)}
    assert numbers(["AA", "AT", "CA", "TT"], size, "ACGT").tolist() == [0, 3, 4, 15]
    with pytest.raises(ValueError, match="gene 'size': the letter 'X' is not in 'ACGT'"):
        numbers(["AX"], size, "ACGT")


def test_carriers_are_drawn_in_the_colour_of_their_gene(tmp_path):
    lineage = family()
    figure = carriers([lineage.frequencies("finch", gene, 1) for gene in ("red", "song")], "finch")
    (ax,) = figure.axes
    lines = {line.get_label(): line for line in ax.get_lines()}
    assert list(lines) == ["red", "song = 1", "song = 2", "all"]
    assert lines["red"].get_color() == "#d7191c"
    assert lines["red"].get_ydata().tolist() == [0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 2]
    assert len({line.get_color() for line in lines.values()}) == 4
    assert save(figure, tmp_path / "carriers.png").stat().st_size > 5000
