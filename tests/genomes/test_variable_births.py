"""Births with strings of variable length: what comes out by hand, how often, and what never happens."""

from collections import Counter

import numpy as np
import pytest
from deap import tools
from hypothesis import given, settings, strategies as st
from scipy.stats import chi2, chi2_contingency

from ecs_eco.genomes.unequal import UnequalCrossover
from tests.genomes.births import ALPHA
from tests.genomes.variable import GENES, births, children, layout, texts

N = 20_000


def expected_counts(seen: Counter, shares: dict) -> None:
    """A chi-square test of counts against shares that add up to 1; nothing else was seen."""
    assert set(seen) <= set(shares), set(seen) - set(shares)
    total = sum(seen.values())
    statistic = sum((seen[x] - total * p) ** 2 / (total * p) for x, p in shares.items())
    assert chi2.sf(statistic, len(shares) - 1) > ALPHA, (seen, shares)


# --- unequal crossover --------------------------------------------------------------------------------------


def test_strings_are_cut_where_a_gene_of_the_same_rank_begins() -> None:
    seen = Counter(children(births(mate={"slip": 0.0}), "ATAAGCAA", "TACCGCTT", N))
    a, b = "ATAAGCAA", "TACCGCTT"  # red at 1 and 0, size at 4 and 4: cut at red or at size, either first
    shares = {a[:1] + b: 1 / 4, b[:0] + a[1:]: 1 / 4, a[:4] + b[4:]: 1 / 4, b[:4] + a[4:]: 1 / 4}
    expected_counts(seen, shares)


def test_by_slipping_copies_of_another_rank_pair_so_that_genes_double_and_get_lost() -> None:
    seen = Counter(children(births(mate={"slip": 1.0}, genes=GENES[:1]), "TACTAG", "TAA", N))
    # two copies before one: pairs (0, 0) and (1, 0), each with either string first
    expected_counts(seen, {"TAA": 1 / 4, "TACTAG": 1 / 4, "TACTAA": 1 / 4, "TAG": 1 / 4})
    equal = Counter(children(births(mate={"slip": 0.0}, genes=GENES[:1]), "TACTAG", "TAA", N))
    expected_counts(equal, {"TAA": 1 / 2, "TACTAG": 1 / 2})
    some = Counter(children(births(mate={"slip": 0.2}, genes=GENES[:1]), "TACTAG", "TAA", N))
    expected_counts(some, {"TAA": 0.45, "TACTAG": 0.45, "TACTAA": 0.05, "TAG": 0.05})


def test_strings_without_a_common_gene_do_not_cross() -> None:
    seen = Counter(children(births(), "TACA", "GCTT", N))
    expected_counts(seen, {"TACA": 0.5, "GCTT": 0.5})


@pytest.mark.slow
def test_the_kernel_crosses_as_the_function_with_deaps_signature() -> None:
    a, b = "TACAGCAATAG", "GTAAGCTTTAGTACC"
    arguments = {"mate": {"slip": 0.4}}
    at_once = Counter(children(births(**arguments), a, b, N))
    one = births(**arguments)
    crossing = UnequalCrossover(one.layout)
    one.toolbox.register("mate", lambda x, y: crossing(x, y, slip=0.4))
    each = Counter(children(one, a, b, N))
    assert set(at_once) == set(each)
    table = np.array([[seen[x] for x in sorted(at_once)] for seen in (at_once, each)])
    assert table.shape[1] > 10
    assert chi2_contingency(table).pvalue > ALPHA


def test_a_chance_of_crossing_leaves_the_others_whole() -> None:
    seen = Counter(children(births(mate={"slip": 0.0, "chance": 0.5}, genes=GENES[:1]), "ATAC", "TAG", N))
    expected_counts(seen, {"ATAC": 1 / 4, "TAG": 1 / 4, "ATAG": 1 / 4, "TAC": 1 / 4})


def test_diploids_get_a_crossed_string_of_each_parent() -> None:
    one = births(ploidy=2, mate={"slip": 0.0, "chance": 0.5}, genes=GENES[:1])
    seen = {tuple(sorted(text.split("|"))) for text in children(one, "ATAC|TAG", "CTAT|TAA", 500)}
    mother, father = {"ATAC", "TAG", "ATAG", "TAC"}, {"CTAT", "TAA", "CTAA", "TAT"}
    assert seen == {tuple(sorted((m, f))) for m in mother for f in father}


# --- genes doubled and lost, letters inserted and lost ------------------------------------------------------


@pytest.mark.definition("3 genome")
def test_copies_of_genes_double_in_tandem_and_get_lost_at_their_rates() -> None:
    seen = Counter(children(births(duplication=0.3, gene_deletion=0.1), "CTAGGCAAT", None, N))
    reds = {"": 0.1, "TAG": 0.6, "TAGTAG": 0.3}
    sizes = {"": 0.1, "GCAA": 0.6, "GCAAGCAA": 0.3}
    expected_counts(seen, {f"C{r}{s}T": p * q for r, p in reds.items() for s, q in sizes.items()})


def test_letters_are_inserted_and_lost_at_their_rates() -> None:
    seen = Counter(
        children(
            births(
                insertion=0.2,
                base_deletion=0.1,
                alphabet="01",
                genes=[{"name": "g", "letters": 1, "low": 0, "high": 1, "promoter": "1111"}],
            ),
            "01",
            None,
            N,
        )
    )
    first = {"0": 0.7, "": 0.1, "00": 0.1, "10": 0.1}
    second = {"1": 0.7, "": 0.1, "01": 0.1, "11": 0.1}
    shares: Counter = Counter()
    for a, p in first.items():
        for b, q in second.items():
            shares[a + b or "1"] += p * q  # the last letter stays
    expected_counts(seen, dict(shares))


@pytest.mark.parametrize("rate", [1e-3, 0.02])
def test_rare_events_have_their_rates_over_long_strings(rate: float) -> None:
    one = births(max_length=300, loci=200, insertion=rate)
    keys = np.arange(4000, dtype=np.uint64)
    child = one.offspring(one.layout.random(keys), None, keys)
    grown = one.layout.lengths(child)[:, 0] - 200
    mean, deviation = 200 * rate, np.sqrt(200 * rate * (1 - rate))
    assert grown.mean() == pytest.approx(mean, abs=5 * deviation / np.sqrt(4000))
    assert grown.std() == pytest.approx(deviation, rel=0.1)


def test_point_mutations_have_their_rate_at_every_letter_and_none_beyond_the_end() -> None:
    one = births(mutate={"operator": "mutUniformInt", "indpb": 0.2}, max_length=12)
    keys = np.arange(N, dtype=np.uint64)
    parent = np.repeat(one.layout.rows(["ACGTACGT"]), N, axis=0)
    child = one.offspring(parent, None, keys)
    assert (child[:, 8:] == one.layout.blank).all()
    changed = (child != parent)[:, :8].sum(axis=0)
    statistic = ((changed - 0.15 * N) ** 2 / (N * 0.15 * 0.85)).max()
    assert chi2.sf(statistic, 1) > ALPHA
    together = Counter((child[:, 0].astype(int) * 4 + child[:, 1]).tolist())
    share = [0.85 if i == 0 else 0.05 for i in range(4)], [0.85 if i == 1 else 0.05 for i in range(4)]
    expected_counts(together, {4 * i + j: share[0][i] * share[1][j] for i in range(4) for j in range(4)})


def test_a_gene_may_mutate_at_a_rate_of_its_own_wherever_it_is() -> None:
    genes = [GENES[0], GENES[1] | {"mutation": 1.0}]
    one = births(genes=genes)
    child = np.array([list(text) for text in children(one, "ATAGGCAAC", None, 2000)])
    differs = (child != list("ATAGGCAAC")).mean(axis=0)
    assert differs[[0, 1, 2, 3, 4, 5, 8]].tolist() == [0] * 7
    assert differs[6:8] == pytest.approx([0.75, 0.75], abs=0.05)


def test_bits_flip_and_letters_change_places() -> None:
    bits = {"alphabet": "01", "genes": [{"name": "g", "letters": 1, "low": 0, "high": 1, "promoter": "1110"}]}
    flipped = children(births(mutate={"operator": "mutFlipBit", "indpb": 1.0}, **bits), "0110", None, 5)
    assert flipped == ["1001"] * 5
    mixed = children(births(mutate={"operator": "mutShuffleIndexes", "indpb": 0.5}), "AACCGT", None, 200)
    assert {"".join(sorted(text)) for text in mixed} == {"AACCGT"}
    assert len(set(mixed)) > 20


# --- the limit ----------------------------------------------------------------------------------------------


def test_what_would_exceed_the_limit_does_not_happen_and_is_counted() -> None:
    one = births(max_length=8, duplication=1.0)
    assert children(one, "TACTAG", None, 10) == ["TACTAG"] * 10
    assert one.at_limit.tolist() == [0, 20, 0, 0, 0]
    one = births(max_length=8, insertion=1.0)
    assert {len(text) for text in children(one, "TACTAG", None, 10)} == {8}
    assert one.at_limit.tolist() == [0, 0, 0, 40, 0]
    one = births(max_length=8, base_deletion=1.0)
    assert {len(text) for text in children(one, "TACTAG", None, 10)} == {1}
    assert one.at_limit.tolist() == [0, 0, 0, 0, 10]
    one = births(max_length=8, gene_deletion=1.0)
    assert children(one, "TACTAG", None, 10) == ["TAG"] * 10
    assert one.at_limit.tolist() == [0, 0, 10, 0, 0]


def test_a_crossing_that_makes_too_long_a_string_does_not_take_place() -> None:
    one = births(max_length=7, mate={"slip": 1.0}, genes=GENES[:1])
    seen = Counter(children(one, "TACTAG", "TAATAA", 8000))
    assert max(map(len, seen)) == 6
    # pairs (1, 0) make nine letters: the child is its first parent; (0, 1) make three
    shares = {"TACTAG": 2 / 8, "TAATAA": 2 / 8, "TACTAA": 1 / 8, "TAATAG": 1 / 8, "TAA": 1 / 8, "TAG": 1 / 8}
    expected_counts(seen, shares)
    assert 1800 < one.at_limit[0] < 2200


# --- promises -----------------------------------------------------------------------------------------------

LIVELY = {
    "insertion": 0.05,
    "base_deletion": 0.05,
    "duplication": 0.1,
    "gene_deletion": 0.1,
    "mate": {"slip": 0.5},
    "mutate": {"operator": "mutUniformInt", "indpb": 0.1},
}


@settings(max_examples=40)
@given(
    st.lists(
        st.tuples(st.text("ACGT", min_size=1, max_size=24), st.text("ACGT", min_size=1, max_size=24)),
        min_size=1,
        max_size=6,
    ),
    st.sampled_from([1, 2]),
    st.integers(0, 2**63),
)
def test_children_are_strings_within_their_bounds_that_say_valid_organisms(pairs, ploidy, first) -> None:
    one = births(ploidy=ploidy, **LIVELY)
    of = one.layout
    if ploidy == 2:
        pairs = [("|".join(pair), "|".join(pair[::-1])) for pair in pairs]
    keys = np.uint64(first) + np.arange(len(pairs), dtype=np.uint64)
    mothers, fathers = (of.rows([pair[i] for pair in pairs]) for i in (0, 1))
    before = mothers.copy()
    child = one.offspring(mothers, fathers, keys)
    assert np.array_equal(mothers, before)
    lengths = of.lengths(child)
    assert ((lengths >= 1) & (lengths <= 24)).all()
    strings = child.reshape(-1, 24)
    beyond = np.arange(24) >= lengths.reshape(-1, 1)
    assert ((strings == of.blank) == beyond).all()
    assert all(np.isfinite(values).all() for values in of.decode(child).values())
    alone = one.offspring(mothers[-1:], fathers[-1:], keys[-1:])
    assert np.array_equal(alone[0], child[-1]), "a child depends on its parents and its key alone"


def test_nothing_mutates_where_mutation_is_off() -> None:
    one = births(**LIVELY)
    one.mutation = False
    assert children(one, "TACGCAAT", None, 50) == ["TACGCAAT"] * 50


# --- DEAP's own operators -----------------------------------------------------------------------------------


def test_deaps_messy_crossover_changes_lengths() -> None:
    one = births(mate={"operator": "cxMessyOnePoint"})
    assert one.toolbox.mate.func is tools.cxMessyOnePoint
    seen = children(one, "TACGCAATTT", "GG", 600)
    assert {len(text) for text in seen} == set(range(1, 13))
    assert one.at_limit[0] > 0  # a cut that left nothing


@pytest.mark.parametrize(
    "mate", [{"operator": "cxOnePoint"}, {"operator": "cxTwoPoint"}, {"operator": "cxUniform", "indpb": 0.5}]
)
def test_deaps_other_crossovers_take_lists_of_different_lengths(mate: dict) -> None:
    seen = children(births(mate=mate), "AAAAAA", "CCC", 300)
    assert {len(text) for text in seen} == {3, 6}
    assert any(len(set(text)) > 1 for text in seen)


def test_functions_of_ones_own_may_return_any_length_and_their_excess_is_counted() -> None:
    one = births()
    one.toolbox.register("mutate", lambda genome, n: (genome * n,), n=2)
    assert children(one, "TACGCAAC", None, 2) == ["TACGCAACTACGCAAC"] * 2
    one.toolbox.register("mutate", lambda genome, n: (genome * n,), n=9)
    assert children(one, "TACGCAAC", None, 2) == ["TACGCAAC"] * 2
    assert one.at_limit.tolist() == [0, 0, 0, 2, 0]
    one.toolbox.register("mutate", lambda genome: ([*genome[:-1], 4],))
    with pytest.raises(ValueError, match="puts 4, which is not a letter, at position"):
        children(one, "TACGCAAC", None, 1)


def test_operators_that_do_not_fit_are_refused() -> None:
    from ecs_eco.genomes import Gene, Layout, toolbox_of

    fixed = Layout([Gene(name="g", letters=2, low=0, high=1)])
    with pytest.raises(ValueError, match=r"cuts strings at genes, which needs genome\.max_length"):
        toolbox_of({"mate": {"operator": "cxUnequal"}}, fixed)
    with pytest.raises(ValueError, match=r"slip = 1\.5; expected 0 to 1"):
        births(mate={"slip": 1.5})
    with pytest.raises(ValueError, match="genes have no fixed position"):
        births(mutate={"operator": "mutUniformInt", "indpb": 0.1, "low": [0, 1]})
    one = births(genes=[GENES[0] | {"mutation": 0.1}])
    one.toolbox.register("mutate", lambda genome, indpb: (genome,), indpb=0.5)
    with pytest.raises(ValueError, match="ignores the positions of genes"):
        children(one, "TAC", None, 1)
    assert layout().longest == 24


def test_texts_of_rows_are_those_of_the_record() -> None:
    of = layout(ploidy=2)
    rows = of.rows(["TAC|GGGG", "A|C"])
    letters = np.array([*"ACGT", "", "|"])
    assert ["".join(letters[row]) for row in of.joined(rows)] == texts(of, rows)
