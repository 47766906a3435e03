"""Births at once and birth by birth: the same distributions, and nothing but parents and key decides."""

import random

import numpy as np
import pytest
from deap import tools
from scipy.stats import chi2, chi2_contingency

from ecs_eco.genomes import Gene, Layout
from ecs_eco.genomes.kernels import forward
from tests.genomes.births import ALPHA, KEYS, N, layout_of, operators


def origins(layout: Layout, mate: tuple, twins: bool, chance: float = 1.0) -> np.ndarray:
    """Which parent each locus of N children is from: 0 or 1."""
    first = np.zeros((N, layout.length), np.uint8)
    return operators(layout, mate, None, twins, chance).offspring(first, first + 1, KEYS)


def same_counts(a: np.ndarray, b: np.ndarray) -> None:
    """Two samples of whole numbers of the same distribution,
    by a chi-square test with sparse cells put together."""
    values = np.unique(np.concatenate([a, b]))
    table = np.array([[(x == v).sum() for v in values] for x in (a, b)])
    rare = table.sum(axis=0) < 20
    table = np.concatenate([table[:, ~rare], table[:, rare].sum(axis=1, keepdims=True)], axis=1)
    table = table[:, table.sum(axis=0) > 0]
    assert table.shape[1] > 1, "nothing varies"
    assert chi2_contingency(table).pvalue > ALPHA


CROSSINGS = [(tools.cxOnePoint, {}), (tools.cxTwoPoint, {}), (tools.cxUniform, {"indpb": 0.3})]


@pytest.mark.parametrize("mate", CROSSINGS, ids=lambda m: m[0].__name__)
def test_kernels_cross_as_deap_does(mate: tuple) -> None:
    layout = layout_of(10)
    at_once, each = (origins(layout, mate, twins) for twins in (True, False))
    assert not np.array_equal(at_once, each)
    weights = 1 << np.arange(10)
    same_counts(at_once @ weights % 1024, each @ weights % 1024)  # the whole pattern
    for locus in range(10):
        same_counts(at_once[:, locus], each[:, locus])
    for locus in range(9):
        same_counts(at_once[:, locus] * 2 + at_once[:, locus + 1], each[:, locus] * 2 + each[:, locus + 1])


@pytest.mark.parametrize("twins", [True, False])
@pytest.mark.parametrize("mate", CROSSINGS, ids=lambda m: m[0].__name__)
def test_neither_parent_is_favoured_at_any_locus(mate: tuple, twins: bool) -> None:
    counts = origins(layout_of(10), mate, twins).sum(axis=0)
    statistic = ((counts - N / 2) ** 2 / (N / 4)).max()
    assert chi2.sf(statistic, 1) > ALPHA


def test_crossing_at_one_point_breaks_all_places_alike() -> None:
    child = origins(layout_of(10), (tools.cxOnePoint, {}), True).astype(int)
    breaks = np.abs(np.diff(child, axis=1))
    assert (breaks.sum(axis=1) == 1).all()
    counts = breaks.sum(axis=0)
    assert chi2.sf(((counts - N / 9) ** 2 / (N / 9)).sum(), 8) > ALPHA


@pytest.mark.parametrize("twins", [True, False])
def test_without_a_crossing_the_child_copies_one_parent(twins: bool) -> None:
    child = origins(layout_of(10), (tools.cxUniform, {"indpb": 0.5}), twins, chance=0.25)
    whole = (child == child[:, :1]).all(axis=1)
    assert whole.mean() == pytest.approx(0.75 + 0.25 * 2 / 2**10, abs=0.03)
    assert child[whole, 0].mean() == pytest.approx(0.5, abs=0.03)
    assert (
        origins(layout_of(10), (tools.cxUniform, {"indpb": 0.5}), twins, chance=0.0)[:, :1] == child[:, :1]
    ).mean() > 0.8


MUTATIONS = [
    ((tools.mutUniformInt, {"low": 0, "up": 3, "indpb": 0.2}), "ACGT"),
    ((tools.mutUniformInt, {"low": 1, "up": 2, "indpb": 0.5}), "ACGT"),
    ((tools.mutFlipBit, {"indpb": 0.3}), "01"),
    ((tools.mutShuffleIndexes, {"indpb": 0.2}), "ACGT"),
]


@pytest.mark.parametrize(("mutate", "letters"), MUTATIONS, ids=["uniform", "bounded", "flip", "shuffle"])
def test_kernels_mutate_as_deap_does(mutate: tuple, letters: str) -> None:
    layout = layout_of(6, letters)
    parent = np.tile(np.array([0, 1, 0, 1, 1, 0], np.uint8), (N, 1))
    if mutate[0] is tools.mutShuffleIndexes:
        parent = np.tile(np.array([0, 1, 2, 3, 3, 0], np.uint8), (N, 1))
    at_once, each = (
        operators(layout, None, mutate, twins).offspring(parent, None, KEYS).astype(int)
        for twins in (True, False)
    )
    assert not np.array_equal(at_once, each)
    same_counts((at_once != parent).sum(axis=1), (each != parent).sum(axis=1))
    for locus in range(6):
        same_counts(at_once[:, locus], each[:, locus])
    weights = len(letters) ** np.arange(6)
    same_counts(at_once @ weights, each @ weights)
    if mutate[0] is tools.mutShuffleIndexes:
        assert np.array_equal(np.sort(at_once), np.sort(parent))


@pytest.mark.parametrize("twins", [True, False])
def test_a_gene_may_mutate_at_a_rate_of_its_own(twins: bool) -> None:
    layout = Layout(
        [Gene(name="a", letters=3, low=0, high=1), Gene(name="b", letters=2, low=0, high=1, mutation=0.8)],
        "01",
        loci=7,
    )
    parent = np.zeros((N, 7), np.uint8)
    child = operators(layout, None, (tools.mutFlipBit, {"indpb": 0.1}), twins).offspring(parent, None, KEYS)
    assert child.mean(axis=0) == pytest.approx([0.1, 0.1, 0.1, 0.8, 0.8, 0.1, 0.1], abs=0.025)


@pytest.mark.parametrize("twins", [True, False])
def test_bounds_of_each_locus_go_with_the_locus(twins: bool) -> None:
    layout = Layout([Gene(name="a", letters=2, low=0, high=1, mutation=1.0)], loci=4)
    arguments = {"low": [0, 1, 2, 3], "up": [0, 1, 2, 3], "indpb": 0.5}
    child = operators(layout, None, (tools.mutUniformInt, arguments), twins).offspring(
        np.zeros((500, 4), np.uint8), None, KEYS[:500]
    )
    assert (child[:, :2] == [0, 1]).all()
    assert {tuple(c) for c in child[:, 2:].tolist()} == {(0, 0), (2, 0), (0, 3), (2, 3)}


# --- two strings --------------------------------------------------------------------------------------------


def diploid(twins: bool, chance: float = 1.0) -> np.ndarray:
    """Children [N, 2, 6] of parents with strings of 0 and 1, and of 2 and 3."""
    layout = Layout([Gene(name="g", letters=2, low=0, high=1)], loci=6, ploidy=2)
    parents = [np.repeat(np.array([[a, a + 1]], np.uint8), 6, axis=1).repeat(N, axis=0) for a in (0, 2)]
    return (
        operators(layout, (tools.cxTwoPoint, {}), None, twins, chance)
        .offspring(*parents, KEYS)
        .reshape(N, 2, 6)
    )


@pytest.mark.parametrize("twins", [True, False])
def test_each_parent_gives_one_string_crossed_of_its_two(twins: bool) -> None:
    child = diploid(twins)
    mothers = child < 2
    assert (mothers == mothers[:, :, :1]).all(), "a string is one parent's"
    assert (mothers[:, 0, 0] != mothers[:, 1, 0]).all(), "one of each"
    assert mothers[:, 0, 0].mean() == pytest.approx(0.5, abs=0.03)
    assert (child % 2).mean(axis=(0, 1)) == pytest.approx(0.5, abs=0.03)
    assert ((child % 2).min(axis=2) != (child % 2).max(axis=2)).mean() > 0.8  # crossed


def test_kernels_make_gametes_as_deap_does() -> None:
    weights = 2 ** np.arange(6)
    same_counts(
        *(
            (diploid(twins)[:, 0] % 2) @ weights + 64 * (diploid(twins)[:, 0, 0] // 2)
            for twins in (True, False)
        )
    )


def test_both_gametes_of_a_birth_are_crossed_on_their_own() -> None:
    child = diploid(True) % 2
    same = (child[:, 0] == child[:, 1]).all(axis=1).mean()
    assert same < 0.1


def test_a_diploid_without_mate_is_copied() -> None:
    layout = Layout([Gene(name="g", letters=2, low=0, high=1)], ploidy=2)
    parent = layout.random(KEYS[:50])
    assert np.array_equal(operators(layout).offspring(parent, None, KEYS[:50]), parent)


# --- promises -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("twins", [True, False])
def test_a_child_depends_on_its_parents_and_its_key_alone(twins: bool) -> None:
    layout = layout_of(12)
    births = operators(
        layout, (tools.cxTwoPoint, {}), (tools.mutUniformInt, {"low": 0, "up": 3, "indpb": 0.2}), twins
    )
    keys = KEYS[:60]
    first, second = layout.random(keys), layout.random(keys + np.uint64(1))
    before = first.copy()
    child = births.offspring(first, second, keys)
    order = np.random.default_rng(1).permutation(60)
    random.seed(99)
    assert np.array_equal(births.offspring(first[order], second[order], keys[order]), child[order])
    assert np.array_equal(births.offspring(first[7:8], second[7:8], keys[7:8])[0], child[7])
    assert np.array_equal(first, before), "parents stay as they are"
    assert not np.array_equal(births.offspring(first, second, keys + np.uint64(1)), child)


def test_the_users_random_numbers_go_on_as_if_nobody_was_born() -> None:
    layout = layout_of(12)
    random.seed(5)
    expected = [random.random() for _ in range(3)]
    random.seed(5)
    births = operators(
        layout, (tools.cxTwoPoint, {}), (tools.mutUniformInt, {"low": 0, "up": 3, "indpb": 0.2}), twins=False
    )
    first = layout.random(KEYS[:5])
    births.offspring(first, first[::-1].copy(), KEYS[:5])
    assert [random.random() for _ in range(3)] == expected


def test_nothing_mutates_where_mutation_is_off() -> None:
    layout = layout_of(12)
    births = operators(layout, None, (tools.mutUniformInt, {"low": 0, "up": 3, "indpb": 1.0}))
    parent = layout.random(KEYS[:50])
    assert not np.array_equal(births.offspring(parent, None, KEYS[:50]), parent)
    births.mutation = False
    assert np.array_equal(births.offspring(parent, None, KEYS[:50]), parent)


def test_what_is_registered_later_makes_the_next_children() -> None:
    layout = layout_of(4)
    births = operators(layout)
    parent = np.zeros((3, 4), np.uint8)
    births.toolbox.register("mutate", lambda genome: ([3] * len(genome),))
    assert (births.offspring(parent, None, KEYS[:3]) == 3).all()
    births.toolbox.register("mutate", tools.mutGaussian, mu=0, sigma=1, indpb=1)
    with pytest.raises(ValueError, match="mutGaussian does not work on genomes"):
        births.offspring(parent, None, KEYS[:3])


def test_a_letter_outside_the_alphabet_that_first_comes_in_a_birth_is_named() -> None:
    layout = layout_of(8)

    def rare(genome: list[int]) -> tuple[list[int]]:
        return ([*genome[:-1], 4] if genome == [1] * 8 else genome,)

    births = operators(layout, None, (rare, {}))
    with pytest.raises(
        ValueError,
        match="mutate: rare puts 4, which is not a letter, at position 7; expected whole numbers from 0 to 3",
    ):
        births.offspring(np.ones((1, 8), np.uint8), None, KEYS[:1])


def test_a_failed_birth_restores_the_users_random_numbers() -> None:
    births = operators(layout_of(8), None, (lambda genome: ([9] * 8 if genome == [1] * 8 else genome,), {}))
    state = random.getstate()
    with pytest.raises(ValueError, match="puts 9"):
        births.offspring(np.ones((1, 8), np.uint8), None, KEYS[:1])
    assert random.getstate() == state


def test_genomes_of_another_layout_are_refused() -> None:
    with pytest.raises(ValueError, match=r"expected rows of u8\[n, 10\]"):
        operators(layout_of(10)).offspring(np.zeros((1, 9), np.uint8), None, KEYS[:1])
    with pytest.raises(ValueError, match=r"chance = 1\.5; expected 0 to 1"):
        operators(layout_of(10), chance=1.5)


def test_the_forward_kernel_agrees_with_plain_matrices() -> None:
    rng = np.random.default_rng(1)
    x, weights = (
        rng.normal(size=(7, 3)).astype(np.float32),
        rng.normal(size=(7, 3 * 4 + 4 + 4 * 2 + 2)).astype(np.float32),
    )
    out = np.empty((7, 2), np.float32)
    forward(x, np.array([3, 4, 2]), weights, out)
    for i, w in enumerate(weights):
        hidden_units = np.tanh(x[i] @ w[:12].reshape(3, 4) + w[12:16])
        assert out[i] == pytest.approx(hidden_units @ w[16:24].reshape(4, 2) + w[24:], abs=1e-5)
