"""Genes on a string of letters: every string says something valid, and values come back."""

import time

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ecs_eco.engine.errors import ConfigError, UnknownName
from ecs_eco.genomes import Gene, Layout, Trait
from ecs_eco.testing import check_genome
from tests.genomes.layouts import RED, meaning, one

RADIUS = Trait("body.radius", "Body", "radius", None, 0.4, 1e-6, 1e30, "number", "m", "radius")
SIGN = Trait("reflex.red.weight", "Reflexes", "weight", 0, -1, -1.0, 1.0, "sign", "1", "red")


# --- round trips --------------------------------------------------------------------------------------------


@st.composite
def layouts(draw) -> Layout:
    size = draw(st.integers(2, 6))
    genes, shapes = [], {}
    for i in range(draw(st.integers(1, 5))):
        letters = draw(st.integers(1, 4))
        kind, name = (
            draw(st.sampled_from(["values", "range", "whole", "additive", "direct", "cosine"])),
            f"g{i}",
        )
        low = draw(st.floats(-50, 50, width=32))
        more: dict = {
            "low": low,
            "high": low + draw(st.floats(0.5, 100, width=32)),
            "code": draw(st.sampled_from(["positional", "gray"])),
        }
        if kind == "values":
            letters = min(letters, 2)
            more = {
                "values": draw(
                    st.lists(st.floats(-9, 9, width=16), min_size=size**letters, max_size=size**letters)
                )
            }
        elif kind == "whole":
            more |= {"low": round(low), "high": round(low) + draw(st.integers(1, 30)), "whole": True}
        elif kind == "additive":
            more |= {"code": "additive", "codons": draw(st.integers(2, 5))}
        elif kind == "direct":
            more["form"], shapes[name] = "direct", [(2, draw(st.integers(1, 3))), (2,)]
        elif kind == "cosine":
            more |= {"form": "cosine", "coefficients": draw(st.integers(1, 9))}
            shapes[name] = [(2, draw(st.integers(1, 3))), (2,)]
        elif draw(st.booleans()):
            more |= {"scale": "log", "low": abs(low) + 0.1, "high": abs(low) + 0.1 + (more["high"] - low)}
        genes.append(Gene(name=name, letters=letters, **more))
    return Layout(
        genes,
        "ABCDEF"[:size],
        ploidy=draw(st.sampled_from([1, 2])),
        shapes=shapes,
        expression=draw(st.sampled_from(["first", "mean", "greater"])),
    )


@settings(max_examples=60)
@given(layouts())
def test_any_layout_can_be_lived_with(layout: Layout) -> None:
    check_genome(layout, 200)
    assert str(layout).count("\n") == len(layout.genes)


@settings(max_examples=60)
@given(layouts(), st.integers(0, 2**32))
def test_a_value_comes_back_within_half_a_resolution(layout: Layout, seed: int) -> None:
    rng, values = np.random.default_rng(seed), {}
    for code in layout.genes:
        values[code.name] = rng.uniform(code.low, code.high, (50, *code.width))
        if code.gene.values:
            values[code.name] = rng.choice(code.gene.values, 50)
        if code.gene.form == "cosine":  # of what it can say at all
            values[code.name] = layout.decode(layout.random(np.arange(50, dtype=np.uint64)))[code.name]
        if code.gene.whole:
            values[code.name] = np.rint(values[code.name])
    again = layout.decode(layout.encode(values, clip=True))
    for code in layout.genes:
        off = np.abs(again[code.name] - values[code.name]).max()
        fine = 1e-5 * max(abs(code.low), abs(code.high))
        if code.gene.form == "cosine":
            assert layout.ploidy == 2 or off <= 1e-4 * max(abs(code.low), abs(code.high))
        else:
            assert off <= code.resolution / 2 + fine


def test_a_hundred_thousand_genomes_decode_in_well_under_a_second_and_stay() -> None:
    layout = Layout(
        [
            RED,
            Gene(name="size", letters=6, low=0.2, high=0.6, code="gray"),
            Gene(name="n", letters=2, low=0, high=9, whole=True),
            Gene(name="w", letters=3, low=-2, high=2, form="direct"),
        ],
        shapes={"w": [(4, 3), (3,)]},
    )
    loci = layout.random(np.arange(100_000, dtype=np.uint64))
    layout.decode(loci[:2])
    start = time.process_time()
    values = layout.decode(loci)
    seconds = time.process_time() - start
    again = layout.decode(layout.encode(values))
    assert all(np.array_equal(again[name], values[name]) for name in values)
    assert seconds < 1.0
    for letter in range(4):
        assert (loci == letter).mean() == pytest.approx(0.25, abs=0.002)


# --- two strings --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("how", "value"), [("first", 1), ("mean", 2), ("greater", 3)])
def test_dominance_says_how_two_alleles_make_a_value(how: str, value: float) -> None:
    layout = one(Gene(name="n", letters=1, low=0, high=3), ploidy=2, expression=how)
    assert meaning(layout, "CT")["n"] == value
    assert layout.alleles(layout.alphabet.encode("CT")[None], "n").tolist() == [[1, 3]]


def test_a_gene_may_have_a_dominance_of_its_own() -> None:
    genes = [
        Gene(name="a", letters=1, low=0, high=3),
        Gene(name="b", letters=1, low=0, high=3, expression="greater"),
    ]
    assert meaning(Layout(genes, ploidy=2, expression="mean"), "CCTT") == {"a": 2, "b": 3}


def test_a_mean_of_whole_numbers_is_rounded_to_one() -> None:
    gene = Gene(name="s", trait="reflex.red.weight", letters=1, values=[-1, 0, 1, 1])
    layout = one(gene, ploidy=2, expression="mean", traits={SIGN.name: SIGN})
    assert meaning(layout, "AC")["s"] == 0
    assert meaning(layout, "AA")["s"] == -1


def test_encoding_makes_both_strings_alike() -> None:
    layout = one(Gene(name="n", letters=2, low=0, high=15), ploidy=2, loci=3)
    assert layout.alphabet.decode(layout.encode({"n": 6})[0]) == "CGACGA"


# --- places and pieces --------------------------------------------------------------------------------------


def test_genes_follow_one_another_and_the_rest_is_neutral() -> None:
    a, c = (Gene(name=name, letters=2, low=0, high=1) for name in "ac")
    layout = Layout([a, Gene(name="b", letters=1, low=0, high=1, at=4), c], loci=9)
    assert [(c.first, c.stop) for c in layout.genes] == [(0, 2), (4, 5), (5, 7)]
    pieces = layout.mark("ACGTACGTA")
    assert [(p.gene, p.first, p.letters) for p in pieces] == [
        ("a", 0, "AC"),
        ("", 2, "GT"),
        ("b", 4, "A"),
        ("c", 5, "CG"),
        ("", 7, "TA"),
    ]


def test_genes_need_not_stand_in_the_order_of_their_loci() -> None:
    layout = Layout(
        [Gene(name="a", letters=1, low=0, high=3, at=2), Gene(name="b", letters=2, low=0, high=15, at=0)]
    )
    assert meaning(layout, "CAT") == {"a": 3, "b": 4}
    assert [p.gene for p in layout.mark("CAT")] == ["b", "a"]


def test_a_marked_pair_of_strings_says_which_is_which() -> None:
    assert [(p.string, p.gene) for p in one(RED, ploidy=2).mark("AT")] == [(0, "red"), (1, "red")]


def test_the_table_says_where_what_and_how_fine() -> None:
    layout = one(
        Gene(name="size", trait="body.radius", letters=2, low=0.2, high=0.5), traits={RADIUS.name: RADIUS}
    )
    assert layout.table() == [
        {
            "gene": "size",
            "loci": "0-1",
            "trait": "body.radius",
            "codes for": "0.2 to 0.5 (positional)",
            "resolution": "0.02 m",
        }
    ]
    assert "body.radius" in str(layout).splitlines()[1]


def test_rates_are_the_genes_own_where_they_have_one() -> None:
    layout = Layout([RED, Gene(name="b", letters=2, low=0, high=1, mutation=0.25)], loci=4)
    assert layout.rates(0.5).tolist() == [0.5, 0.25, 0.25, 0.5]


def test_own_says_the_values_of_the_species_and_draws_the_rest() -> None:
    genes = [
        Gene(name="size", trait="body.radius", letters=4, low=0.2, high=0.71),
        Gene(name="marker", letters=8, low=0, high=1),
    ]
    rows = Layout(genes, traits={RADIUS.name: RADIUS}).own(3)
    assert (rows == rows[0]).all()
    assert len(set(rows[0, 4:].tolist())) > 1
    assert Layout(genes, traits={RADIUS.name: RADIUS}).decode(rows)["size"] == pytest.approx(0.4)


# --- errors -------------------------------------------------------------------------------------------------
G = {"name": "g", "letters": 1, "low": 0.0, "high": 1.0}
REFUSED = [
    ([G, G], {}, "another gene has this name"),
    ([G | {"low": 1.0}], {}, "not below high"),
    ([G | {"low": None}], {}, "genes.0.low"),
    ([G | {"values": [1.0] * 4}], {}, "given together with values"),
    (
        [{"name": "g", "letters": 1, "values": [1.0, 2.0]}],
        {},
        "2 values, but a codon of 1 of 4 letters has 4",
    ),
    ([G | {"letters": 16}], {}, r"4\^16 values; expected: at most 15"),
    ([G | {"scale": "log"}], {}, "no logarithm"),
    ([G | {"low": 0.5, "whole": True}], {}, "not a whole number"),
    ([G | {"low": 1.0, "high": 4.0, "whole": True, "scale": "log"}], {}, "not possible for whole numbers"),
    ([G | {"code": "additive"}], {}, "at least 2"),
    ([G | {"codons": 2}], {}, 'has no effect with code = "positional"'),
    ([G | {"coefficients": 3}], {}, "only for the weights"),
    (
        [G, G | {"name": "h", "at": 0}],
        {},
        "overlaps the gene g, which occupies loci 0 to 0; expected: at least 1",
    ),
    ([G, G | {"name": "h", "letters": 3}], {"loci": 3}, "string is too short: the genes need 4 loci"),
    ([G | {"trait": "body.radus"}], {"traits": {"body.radius": RADIUS}}, 'did you mean "body.radius"'),
    ([G | {"trait": "body.radius"}], {"traits": {"body.radius": RADIUS}}, "outside the range of body.radius"),
    ([G | {"trait": "a"}, G | {"name": "h", "trait": "a"}], {}, "the gene g also codes for it"),
    (
        [G | {"trait": "reflex.red.weight", "low": -1, "high": 2}],
        {"traits": {SIGN.name: SIGN}},
        "expected: -1 to 1",
    ),
    ([G | {"form": "direct"}], {}, "network that it codes for is unknown"),
    ([G | {"form": "cosine"}], {"shapes": {"g": [(2, 2)]}}, "is missing: the number for each matrix"),
    ([G | {"form": "direct", "coefficients": 3}], {"shapes": {"g": [(2, 2)]}}, "every weight has a codon"),
    (
        [G | {"form": "direct", "code": "additive", "codons": 2}],
        {"shapes": {"g": [(2, 2)]}},
        "positional or gray",
    ),
    ([G | {"form": "direct", "low": 1.0, "high": 2.0, "scale": "log"}], {"shapes": {"g": [(2, 2)]}}, "scale"),
    ([G | {"form": "direct", "letters": 9}], {"shapes": {"g": [(2, 2)]}}, "at most 8"),
    ([G | {"trait": "policy.weights"}], {"shapes": {"policy.weights": [(2, 2)]}}, "direct or cosine"),
    ([], {}, "at least one gene"),
    ([G], {"ploidy": 3}, "ploidy"),
    ([G], {"dominance": "second"}, "first, mean, greater"),
]


@pytest.mark.parametrize(("genes", "arguments", "words"), REFUSED, ids=[w[:30] for _, _, w in REFUSED])
def test_a_layout_that_cannot_be_is_refused_with_the_reason(
    genes: list[dict], arguments: dict, words: str
) -> None:
    with pytest.raises(ConfigError, match=words):
        Layout([Gene(**g) for g in genes], **arguments)


def test_all_that_is_wrong_is_said_at_once() -> None:
    with pytest.raises(ConfigError) as caught:
        Layout([Gene(**G | {"low": 2.0}), Gene(**G | {"trait": "x", "at": 0})], traits={})
    assert len(caught.value.problems) == 4


@pytest.mark.parametrize(
    "loci", [np.zeros((2, 3), np.uint8), np.zeros((2, 2)), np.zeros(2, np.uint8), [[0, 0]]]
)
def test_rows_of_another_form_are_refused(loci: object) -> None:
    with pytest.raises(ValueError, match=r"expected rows of u8\[n, 2\]"):
        one(Gene(name="g", letters=2, low=0, high=1)).decode(loci)


def test_a_number_that_is_no_letter_is_refused_with_its_place() -> None:
    with pytest.raises(ValueError, match="genome 1: 4 at position 0 is not the number of a letter"):
        one(RED).decode(np.array([[0], [4]], np.uint8))


def test_values_that_no_codon_codes_for_are_refused() -> None:
    size = one(Gene(name="size", letters=2, low=0.2, high=0.6))
    with pytest.raises(ValueError, match=r"gene 'size': no codon codes for 0.7; expected 0.2 to 0.6"):
        size.encode({"size": [0.3, 0.7]})
    assert size.decode(size.encode({"size": 0.7}, clip=True))["size"] == pytest.approx(0.6)
    with pytest.raises(ValueError, match="expected -1, 0"):
        one(RED).encode({"red": 1})
    assert one(RED).decode(one(RED).encode({"red": [-0.6, 3]}, clip=True))["red"].tolist() == [-1, 0]
    with pytest.raises(ValueError, match="not finite"):
        size.encode({"size": float("nan")})
    weights = one(Gene(name="w", letters=2, low=-1, high=1, form="direct"), shapes={"w": [(2, 2)]})
    with pytest.raises(ValueError, match=r"shape \(3,\); expected \(n, 4\)"):
        weights.encode({"w": [0, 0, 0]})
    with pytest.raises(ValueError, match="expected weights from -1 to 1"):
        weights.encode({"w": [0, 0, 0, 2]})


def test_names_of_genes_are_known_or_refused() -> None:
    layout = Layout([Gene(name="size", trait="body.radius", letters=1, low=0.1, high=1)])
    with pytest.raises(UnknownName, match='did you mean "size"'):
        layout.encode({"siz": 1})
    with pytest.raises(ValueError, match="no value; values are given for"):
        layout.encode({})
    with pytest.raises(ValueError, match="expected 1 or 3"):
        Layout([Gene(**G), Gene(**G | {"name": "h"})]).encode({"g": [0, 0, 0], "h": [0, 0]})


def test_a_text_with_a_wrong_letter_or_length_is_refused() -> None:
    with pytest.raises(ValueError, match="'X' at position 1"):
        one(RED, loci=2).mark("AX")
    with pytest.raises(ValueError, match=r"expected rows of u8\[n, 2\]"):
        one(RED, loci=2).mark("A")
