"""Strings of variable length: genes are found by their promoters; absent and doubled ones mean something."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ecs_eco.engine.errors import ConfigError
from ecs_eco.genomes import Gene, Layout, diversity, frequencies, layout_of, statistics
from ecs_eco.genomes.promoters import copies_in, default_promoters
from ecs_eco.genomes.traits import Trait
from ecs_eco.testing import check_genome
from tests.genomes.variable import GENES, layout, section, texts

TRAIT = Trait("reflex.red.weight", "Reflexes", "weight", 0, 2.0, -1.0, 3.0, "number", "1", "")


@pytest.mark.definition("3 genome")
def test_genes_are_found_wherever_their_promoters_are() -> None:
    of = layout()
    rows = of.rows(["TACGCAC", "GTAGATTGCCAGC", "ACGT"])
    string, at, gene = of.copies(rows)
    assert list(zip(string.tolist(), at.tolist(), gene.tolist(), strict=True)) == [
        (0, 0, 0),
        (0, 3, 1),
        (1, 1, 0),
        (1, 7, 1),
    ]  # TA C, GC AC; TA G, GC CA; the last GC has no letters
    assert of.lengths(rows).tolist() == [[7], [13], [4]]
    assert {name: n.tolist() for name, n in of.copy_numbers(rows).items()} == {
        "red": [1, 1, 0],
        "size": [1, 1, 0],
    }
    assert of.decode(rows)["red"].tolist() == [1, 2, 0]
    assert of.decode(rows)["size"].tolist() == [1, 4, 0]


def test_a_promoter_within_a_gene_begins_none() -> None:
    of = layout()
    assert [piece[1:] for piece in of.mark("GCTATACC")] == [
        ("size", 0, "GCTA"),
        ("red", 4, "TAC"),
        ("", 7, "C"),
    ]


@pytest.mark.parametrize(("doubled", "expected"), [("first", 1), ("mean", 2), ("sum", 3), ("greatest", 3)])
def test_of_several_copies_the_rule_of_the_genome_says_what_counts(doubled: str, expected: float) -> None:
    of = layout(copy_rule=doubled)  # TA C is 1, TA T is 3; their sum is more than a copy can say, 3
    assert of.decode(of.rows(["TACTAT"]))["red"].tolist() == [expected]


def test_a_gene_may_have_a_rule_of_its_own() -> None:
    of = layout(copy_rule="sum", genes=[GENES[0], GENES[1] | {"copy_rule": "mean"}])
    values = of.decode(of.rows(["TACTACGCAAGCACGCTT"]))
    assert (values["red"].tolist(), values["size"].tolist()) == ([2], [pytest.approx(16 / 3)])


def test_without_a_copy_the_value_is_the_species_own() -> None:
    genes = [GENES[0] | {"trait": "reflex.red.weight"}, GENES[1]]
    of = layout_of(section(genes=genes), {"reflex.red.weight": TRAIT})
    values = of.decode(of.rows(["GCAC", "TAA"]))
    assert (values["red"].tolist(), values["size"].tolist()) == ([2, 0], [1, 0])


@pytest.mark.parametrize(
    ("dominance", "expected"), [("first", [1, 3, 2, 2]), ("mean", [2, 3, 2, 2]), ("greater", [3, 3, 2, 2])]
)
def test_of_two_strings_the_one_that_has_the_gene_says_its_value(dominance: str, expected: list) -> None:
    genes = [GENES[0] | {"trait": "reflex.red.weight"}]
    of = layout_of(section(genes=genes, ploidy=2, dominance=dominance), {TRAIT.name: TRAIT})
    rows = of.rows(["TAC|TAT", "A|TAT", "TAG|C", "A|C"])
    assert of.decode(rows)["red"].tolist() == expected
    assert of.alleles(rows, "red").tolist() == [[1, 3], [2, 3], [2, 2], [2, 2]]
    assert texts(of, rows) == ["TAC|TAT", "A|TAT", "TAG|C", "A|C"]


def test_founders_have_as_many_copies_as_their_genes_say_and_random_letters_behind() -> None:
    of = layout(genes=[GENES[0] | {"copies": 3}, GENES[1] | {"copies": 0}], loci=12, ploidy=2)
    founders = texts(of, of.random(np.arange(50, dtype=np.uint64)))
    assert {len(text) for text in founders} == {25}
    for text in founders:
        assert all(string[i : i + 2] == "TA" for string in text.split("|") for i in (0, 3, 6))
    assert len({text[9:12] for text in founders}) > 20


def test_founders_that_have_the_species_own_values() -> None:
    genes = [GENES[0] | {"trait": "reflex.red.weight", "copies": 2}, GENES[1]]
    of = layout_of(section(genes=genes), {"reflex.red.weight": TRAIT})
    (text,) = texts(of, of.own())
    assert (text[:6], len(text)) == ("TAGTAG", 10)
    assert np.flatnonzero(of.coded()).tolist() == [2, 5]


def test_values_become_strings_and_come_back() -> None:
    of = layout(ploidy=2)
    rows = of.encode({"red": [1, 3], "size": 6})
    assert texts(of, rows) == ["TACGCCG|TACGCCG", "TATGCCG|TATGCCG"]
    assert of.decode(rows)["size"].tolist() == [6, 6]
    with pytest.raises(ValueError, match="these genes need 7 letters; expected 6"):
        layout(max_length=6, loci=3, genes=[GENES[0], GENES[1] | {"copies": 0}]).encode({"red": 1, "size": 2})


@pytest.mark.definition("3 genome")
@settings(max_examples=100)
@given(
    st.lists(st.text("ACGT", min_size=1, max_size=24), min_size=1, max_size=8),
    st.sampled_from(["first", "mean", "sum", "greatest"]),
)
def test_every_string_says_a_valid_organism_and_is_read_alike_as_text_and_as_rows(strings, doubled) -> None:
    of = layout(copy_rule=doubled)
    rows = of.rows(strings)
    assert texts(of, rows) == strings
    values = of.decode(rows)
    for name, (low, high) in {"red": (0, 3), "size": (0, 15)}.items():
        assert ((values[name] >= low) & (values[name] <= high)).all()
    string, at, gene = of.copies(rows)
    found = [
        (s, place, of.genes[g].name)
        for s, place, g in zip(string.tolist(), at.tolist(), gene.tolist(), strict=True)
    ]
    spans = {"red": 3, "size": 4}
    assert found == [
        (s, place, name)
        for s, text in enumerate(strings)
        for name, place in copies_in(text, of.promoters, spans)
    ]
    for row, text in zip(rows, strings, strict=True):
        assert "".join(piece.letters for piece in of.mark(row)) == text


@pytest.mark.parametrize("changes", [{}, {"ploidy": 2}, {"copy_rule": "mean", "loci": 20}])
def test_genomes_of_variable_length_pass_the_conformance_check(changes: dict) -> None:
    check_genome(layout(**changes), 200)


def test_a_network_of_weights_is_found_like_any_gene() -> None:
    gene = {"name": "w", "letters": 2, "low": -1, "high": 1, "form": "direct", "promoter": "TTT"}
    of = layout_of(section(max_length=40, genes=[gene], copy_rule="mean"), shapes={"w": [(2, 1), (1,)]})
    rows = of.rows(["TTTAATTAA", "ATTTAAAAAATTTTTTTTTC", "ACGT"])
    assert of.decode(rows)["w"] == pytest.approx(np.array([[-1, 1, -1], [0, 0, 0], [0, 0, 0]]))


def test_default_promoters_are_rare_words_of_which_none_begins_another() -> None:
    assert default_promoters(4, "ACGT") == ["AGAA", "CGAA", "GGAA", "TGAA"]
    assert default_promoters(1, "01") == ["100000"]
    of = layout(genes=[{k: v for k, v in gene.items() if k != "promoter"} for gene in GENES])
    assert of.promoters == {"red": "CAAA", "size": "TAAA"}


def test_alphabets_of_any_letters_leave_a_separator() -> None:
    genes = [{"name": "g", "letters": 1, "low": 0, "high": 1, "promoter": "|"}]
    of = layout(alphabet="|/01", genes=genes, ploidy=2)
    assert of.separator == ";"
    assert texts(of, of.rows(["|0;/1"])) == ["|0;/1"]


REFUSED = [
    ({"max_length": 6}, r"max_length = 6\n.*founders have more letters; expected: at least 7"),
    ({"loci": 6}, "a founder's genes need 7 letters"),
    ({"genes": [GENES[0] | {"at": 3}]}, "genes have no fixed position"),
    ({"genes": [GENES[0], GENES[1] | {"promoter": "TAC"}]}, "the promoter of red is 'TA'"),
    ({"genes": [GENES[0] | {"promoter": "TX"}]}, "'X' is not in the alphabet"),
    ({"genes": [GENES[0] | {"promoter": "TTTTTTTTT"}]}, "at most 8 letters"),
    ({"insertion": 0.7, "base_deletion": 0.5}, "sum with insertion exceeds 1"),
    ({"genes": [GENES[0] | {"copies": 0}]}, "founders have neither genes nor other letters"),
]


@pytest.mark.parametrize(("changes", "reason"), REFUSED)
def test_what_cannot_be_is_refused_with_the_reason(changes: dict, reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        layout(**changes)


def test_keys_that_need_a_variable_length_are_refused_without_it() -> None:
    from ecs_eco.genomes.promoters import problems_of_variable

    given = section(max_length=None, insertion=0.1, genes=[GENES[0] | {"copy_rule": "sum"}])
    assert [".".join(map(str, p.key)) for p in problems_of_variable(given, None, {})] == [
        "insertion",
        "genes.0.promoter",
        "genes.0.copy_rule",
    ]


def test_rows_and_texts_of_another_form_are_refused() -> None:
    of = layout()
    with pytest.raises(ValueError, match=r"expected rows of u8\[n, 24\]"):
        of.decode(np.zeros((1, 23), np.uint8))
    with pytest.raises(ValueError, match="5 at position 0 is not the number of a letter; expected 0 to 4"):
        of.decode(np.full((1, 24), 5, np.uint8))
    with pytest.raises(ValueError, match="expected 1 of at most 24 letters"):
        of.rows(["ACG|T"])
    with pytest.raises(ValueError, match="have no loci in common"):
        diversity(of, of.rows(["ACG"]))


def test_statistics_are_of_values_copies_and_letters() -> None:
    of = layout()
    rows = of.rows(["TACTAC", "GCAC", "TAT"])
    record = statistics(of).compile(rows)
    assert record["copies of red"] == {
        "mean": 1.0,
        "std": pytest.approx(np.std([2, 0, 1])),
        "min": 0,
        "max": 2,
    }
    assert (record["letters"]["max"], record["size"]["max"]) == (6, 1)
    assert frequencies(of, rows)["red"] == {
        0: pytest.approx(1 / 3),
        1: pytest.approx(1 / 3),
        3: pytest.approx(1 / 3),
    }


def test_fixed_layouts_read_texts_too() -> None:
    of = Layout([Gene(name="g", letters=2, low=0, high=1)])
    assert of.longest is None
    assert [of.text(row) for row in of.rows(["AC", "GT"])] == ["AC", "GT"]
