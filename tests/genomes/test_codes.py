"""What codons mean: numbers in positional and Gray code, sums, scales and waves."""

import numpy as np
import pytest

from ecs_eco.genomes import Gene
from ecs_eco.genomes.codes import cosines
from tests.genomes.layouts import RED, meaning, one


def test_a_codon_is_a_number_with_its_first_letter_as_most_significant_digit() -> None:
    layout = one(Gene(name="n", letters=3, low=0, high=63, whole=True))
    assert [meaning(layout, t)["n"] for t in ("AAA", "AAT", "ACA", "CAA", "TTT", "GCT")] == [
        0,
        3,
        4,
        16,
        63,
        2 * 16 + 4 + 3,
    ]


def test_several_codons_may_code_for_one_value() -> None:
    layout = one(RED)
    assert [meaning(layout, letter)["red"] for letter in "ACGT"] == [0, 0, 0, -1]
    assert layout.alphabet.decode(layout.encode({"red": -1})[0]) == "T"
    assert layout.alphabet.decode(layout.encode({"red": 0})[0]) == "A"


@pytest.mark.parametrize(("letters", "n"), [("AB", 5), ("ACG", 4), ("ACGT", 3)])
def test_neighbours_in_gray_code_differ_in_one_letter_by_one(letters: str, n: int) -> None:
    size = len(letters)
    layout = one(Gene(name="g", letters=n, low=0, high=size**n - 1, whole=True, code="gray"), letters)
    rows = layout.encode({"g": np.arange(size**n)}).astype(int)
    steps = (rows[1:] - rows[:-1]) % size
    assert (np.count_nonzero(steps, axis=1) == 1).all()
    assert (steps.sum(axis=1) == 1).all()
    assert len({tuple(r) for r in rows}) == size**n
    assert np.array_equal(layout.decode(rows.astype(np.uint8))["g"], np.arange(size**n))


def test_neighbours_in_positional_code_may_differ_in_every_letter() -> None:
    layout = one(Gene(name="g", letters=3, low=0, high=63, whole=True))
    assert [layout.alphabet.decode(r) for r in layout.encode({"g": [15, 16]})] == ["ATT", "CAA"]


def test_additive_codons_add_up_wherever_they_are() -> None:
    layout = one(Gene(name="a", letters=1, codons=4, code="additive", low=0, high=12, whole=True))
    assert [meaning(layout, t)["a"] for t in ("AAAA", "TAAA", "AAAT", "CCCC", "TTTT", "GACA")] == [
        0,
        3,
        3,
        4,
        12,
        3,
    ]
    assert np.array_equal(layout.decode(layout.encode({"a": np.arange(13)}))["a"], np.arange(13))


def test_equal_steps_of_a_logarithmic_scale_are_equal_factors() -> None:
    layout = one(Gene(name="l", letters=1, low=1, high=8, scale="log"))
    assert [meaning(layout, letter)["l"] for letter in "ACGT"] == pytest.approx([1, 2, 4, 8])
    assert layout["l"].resolution == pytest.approx(4)
    # nearer, if not in its logarithm
    assert meaning(layout, layout.alphabet.decode(layout.encode({"l": 2.9})[0]))["l"] == pytest.approx(2)


def test_the_resolution_is_the_range_over_the_steps() -> None:
    layout = one(Gene(name="r", letters=2, low=0.2, high=0.5))
    assert layout["r"].resolution == pytest.approx(0.3 / 15)
    assert meaning(layout, "AC")["r"] == pytest.approx(0.22)


def test_direct_weights_have_a_codon_each() -> None:
    layout = one(Gene(name="w", letters=1, low=-3, high=3, form="direct"), shapes={"w": [(2, 1), (1,)]})
    assert meaning(layout, "ATC")["w"] == pytest.approx([-3, 3, -1])
    assert layout.length == 3


def test_cosine_weights_are_the_sum_of_waves() -> None:
    layout = one(
        Gene(name="w", letters=1, low=-3, high=3, form="cosine", coefficients=2),
        "AT",
        shapes={"w": [(2, 3), (2,)]},
    )
    assert layout.length == 4  # two of the matrix, two of the bias
    i, j = np.arange(3) + 0.5, np.arange(2) + 0.5
    wave = np.cos(np.pi * i / 3) * np.sqrt(2 / 3) / np.sqrt(2)  # along the outputs, the same for both inputs
    matrix = 3 / np.sqrt(6) - 3 * np.tile(wave, 2)
    bias = -3 / np.sqrt(2) + 3 * np.cos(np.pi * j / 2)
    assert meaning(layout, "TAAT")["w"] == pytest.approx([*matrix, *bias], abs=1e-6)


@pytest.mark.parametrize("shape", [(4, 5), (7,), (1, 3), (6, 2)])
def test_the_waves_are_orthonormal_and_all_of_them_span_everything(shape: tuple[int, ...]) -> None:
    basis = cosines(shape, 1000)
    assert basis.shape == (np.prod(shape), np.prod(shape))
    assert basis @ basis.T == pytest.approx(np.eye(len(basis)), abs=1e-12)
    assert cosines(shape, 3) == pytest.approx(basis[:3])


def test_with_all_coefficients_any_weights_come_back() -> None:
    gene = Gene(name="w", letters=8, low=-8, high=8, form="cosine", coefficients=100)
    layout = one(gene, shapes={"w": [(5, 4), (4,)]})
    w = np.random.default_rng(1).normal(size=(10, 24))
    assert layout.decode(layout.encode({"w": w}))["w"] == pytest.approx(w, abs=layout["w"].resolution * 3)
