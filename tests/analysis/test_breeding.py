"""The breeder's view, counted by hand and against slow twins; what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from ecs_eco.analysis.breeding import _Born
from tests.analysis.families import FAMILY, PACE, SIZE, family, forest, herd, numbers

T2 = 4.302653  # the 97.5% point of Student's t with 2 degrees of freedom


def five(**more):
    """Three founders: 1 and 2 have a child, 2 has another one alone, 3 has none."""
    mother, father = [-1, -1, -1, 0, 1], [-1, -1, -1, 1, -1]
    return herd(mother, father, [0, 0, 0, 4, 5], [6, 7, 7, 8, 9], 9, **{SIZE: [1, 3, 2, 2.5, 4]} | more)


def test_five_animals_counted_by_hand():
    found = five().breeding("finch", SIZE, every=4)
    parents, children, none = found.cohorts
    # births 1/2, 3/2 and 0: mean 2/3, variance (1/4 + 9/4) / 3 − 4/9 = 7/18
    assert (parents.start, parents.stop, parents.n, parents.births, parents.alive) == (0, 4, 3, 2.0, 0.0)
    counted = {
        "mean": 2,
        "sd": np.sqrt(2 / 3),
        "opportunity": 7 / 18 / (4 / 9),
        "differential": (1 / 2 * 1 + 3 / 2 * 3) / 2 - 2,
        "intensity": 0.5 / np.sqrt(2 / 3),
        "response": (2.5 + 4) / 2 - 2,
        "midparent": (2 - 0.5) / (1 - 0),  # two children: (midparent, offspring) = (0, 0.5) and (1, 2) from 2
        "one_parent": 0.75 / 1.5,  # weights 1/2, 1/2, 1; parents −1, 1, 1; offspring 0.5, 0.5, 2
    }
    assert numbers(parents) == pytest.approx(counted)
    # relative fitness v = 3/4, 9/4, 0 and d = −1, 1, 0: v (d − S) − d = −1/8, 1/8, 0
    half = T2 * np.sqrt(2 * (1 / 8) ** 2 / 9 * 3 / 2)
    assert parents.estimates["differential"] == pytest.approx((0.5, 0.5 - half, 0.5 + half))
    assert (children.n, children.births) == (2, 0.0)
    assert numbers(children)["mean"] == 3.25
    assert np.isnan([numbers(children)[name] for name in ("differential", "response", "midparent")]).all()
    assert none.n == 0
    assert np.isnan([none.alive, *numbers(none).values()]).all()
    assert found.whole.estimates["realized"].value == pytest.approx(1.25 / 0.5)  # of one cohort
    # 2.5 ± t (1 degree of freedom): residuals of the two children, who share a parent, from 2.5 × midparent
    # are 0.5 − 2.5 × 0 and 2 − 2.5 × 1, ± 0.5 from their mean, with influence 1 / 0.5 and weight 1 / 2 each
    half = 12.706205 * np.sqrt((0.5**2 + 0.5**2) * 2)
    assert found.whole.estimates["realized"] == pytest.approx((2.5, 2.5 - half, 2.5 + half))
    assert (found.whole.n, found.generation) == (5, pytest.approx((4 + 4 + 5) / 3))
    for name in ("opportunity", "differential", "intensity", "response", "midparent", "one_parent"):
        assert found.whole.estimates[name] == pytest.approx(parents.estimates[name], nan_ok=True), name


def test_gradients_counted_by_hand():
    herd_of_four = herd(
        [-1, -1, -1, -1, 1, 2, 2, 3], [-1] * 8, [0] * 4 + [5] * 4, [6] * 8, 7, **{SIZE: [1, 2, 3, 4] * 2}
    )
    # v = 0, 1, 2, 1; d = −1.5 … 1.5: β = Σ v d / Σ d² = 2 / 5; half squares from their mean = ½, −½, −½, ½
    plain = herd_of_four.gradients("finch", [SIZE], standardized=False)
    assert list(numbers(plain.whole).values()) == pytest.approx([0.4, -1])
    unit = np.sqrt(1.25)
    assert list(numbers(herd_of_four.gradients("finch", [SIZE]).whole).values()) == pytest.approx(
        [0.4 * unit, -1.25]
    )
    assert list(plain.whole.estimates) == [f"β {SIZE}", f"γ {SIZE} × {SIZE}"]
    table = plain.to_pandas()
    assert table[f"β {SIZE}_low"][0] < table[f"β {SIZE}"][0] < table[f"β {SIZE}_high"][0]


def test_collinear_and_constant_values_have_no_gradients():
    size = np.array([1.0, 2, 3, 4, 1, 2, 3, 4, 2, 2])
    mother = [-1] * 8 + [1, 2]

    def finches(**fields):
        return herd(mother, [-1] * 10, [0] * 8 + [5] * 2, [6] * 10, 7, **fields)

    known = finches(**{SIZE: size}).gradients("finch", [SIZE]).whole.estimates
    assert np.isfinite(list(known.values())).all()
    twins = finches(**{SIZE: size, PACE: 2 * size})
    assert np.isnan(list(numbers(twins.gradients("finch", [SIZE, PACE]).whole).values())).all()
    constant = finches(**{SIZE: size, PACE: np.full(10, 0.3)})
    found = constant.gradients("finch", [SIZE, PACE]).whole.estimates
    for name, x in found.items():
        assert x == pytest.approx(known.get(name, (np.nan,) * 3), nan_ok=True), name
    assert np.isnan(list(numbers(constant.gradients("finch", [PACE]).whole).values())).all()
    of = numbers(constant.breeding("finch", PACE).whole)  # in spite of rounding
    assert of["differential"] == of["sd"] == of["response"] == 0
    assert np.isnan([of[name] for name in ("intensity", "midparent", "realized")]).all()
    two = (
        finches(**{SIZE: np.sign(size - 2.5), PACE: np.random.default_rng(0).normal(size=10)})
        .gradients("finch", [SIZE, PACE])
        .whole
    )
    unknown = [name for name, x in two.estimates.items() if np.isnan(x.value)]
    assert unknown == [f"γ {SIZE} × {SIZE}"]  # two levels have no curvature


def slow(lineage, value, start, stop):
    """The same, organism by organism."""
    z, n = lineage.recorded[value], len(lineage)
    parents = [
        [int(p) for p in dict.fromkeys((lineage.mother[i], lineage.father[i])) if p >= 0] for i in range(n)
    ]
    cohort = {i: [j for j in range(n) if lineage.born[j] // 10 == lineage.born[i] // 10] for i in range(n)}
    mean = {i: np.mean([z[j] for j in of]) for i, of in cohort.items()}
    who = [i for i in range(n) if start <= lineage.born[i] < stop]
    w = {i: sum(1 / len(parents[c]) for c in range(n) if i in parents[c]) for i in who}
    total = sum(w.values())
    links = [(i, c, 1 / len(parents[c])) for i in who for c in range(n) if i in parents[c]]
    x = [np.mean([z[p] - mean[p] for p in parents[c]]) for _, c, _ in links]
    y = [z[c] - np.mean([mean[p] for p in parents[c]]) for _, c, _ in links]
    weights = [c for *_, c in links]
    return {
        "opportunity": np.var(list(w.values())) / np.mean(list(w.values())) ** 2,
        "differential": sum(w[i] * z[i] for i in who) / total - mean[who[0]],
        "response": np.average(y, weights=weights),
        "midparent": np.polyfit(x, y, 1, w=np.sqrt(weights))[0],
        "one_parent": np.polyfit([z[i] for i, *_ in links], y, 1, w=np.sqrt(weights))[0],
    }


@pytest.mark.parametrize("seed", range(5))
def test_estimates_agree_with_their_slow_plain_twins(seed):
    rows = [row if row[4] >= 0 else (*row[:4], 30, row[5]) for row in forest(seed)]
    z = np.random.default_rng(seed).normal(5, 1, len(rows))
    lineage = replace(family(rows, end=30), recorded={SIZE: z})
    found = lineage.breeding("finch", SIZE, every=10)
    for cohort in found.cohorts[:2]:
        of = numbers(cohort)
        expected = slow(lineage, SIZE, cohort.start, cohort.stop)
        assert {name: of[name] for name in expected} == pytest.approx(expected)


def test_errors_count_each_pair_of_organisms_with_a_common_parent_once():
    rng = np.random.default_rng(0)
    mother = np.concatenate([np.full(12, -1), rng.integers(0, 12, 40)])
    father = np.where((rng.random(52) < 0.7) & (mother >= 0), rng.integers(0, 12, 52), -1)
    made = herd(mother, father, [0] * 12 + [5] * 40, [9] * 52, 9, **{SIZE: rng.normal(size=52)})
    parents = [{int(p) for p in pair if p >= 0} for pair in zip(mother, father, strict=True)]
    kin = np.array([[i == j or bool(parents[i] & parents[j]) for j in range(52)] for i in range(52)])
    score = rng.normal(0.5, 1, 52)
    families = len({frozenset(p) for p in parents if p}) + 12
    b = _Born(made, "finch", (SIZE,), None, 0, None)
    x = b.intervals(np.arange(52))(1.0, score)
    t = (
        2.009575
        if families == 51
        else (x.high - 1) / np.sqrt(score @ kin @ score * families / (families - 1))
    )
    assert 1.96 < t < 2.03
    assert x.high - 1 == pytest.approx(1 - x.low)


def test_organisms_without_the_value_count_only_as_offspring():
    found = five(**{SIZE: [1, 3, 2, np.nan, 4]}).breeding("finch", SIZE, every=4)
    first = numbers(found.cohorts[0])
    assert (first["differential"], first["response"]) == pytest.approx((0.5, 2))
    assert found.cohorts[0].births == 2
    assert found.cohorts[1].n == 1
    lone = numbers(five(**{SIZE: [np.nan, 3, 2, 2.5, 4]}).breeding("finch", SIZE, every=4).cohorts[0])
    assert lone["differential"] == 3 - 2.5  # of 2 and 3, of which 2 has births
    assert lone["response"] == pytest.approx((0.5 * 2.5 + 4) / 1.5 - 2.5)


def test_births_of_emigrants_are_unknown():
    stayed = five()
    left = replace(stayed, cause=np.where(stayed.uid == 3, "emigrated", stayed.cause))
    found = left.breeding("finch", SIZE, every=4)
    assert found.cohorts[0].alive == pytest.approx(1 / 3)
    assert np.isnan([numbers(found.cohorts[0])[name] for name in ("differential", "response")]).all()
    assert numbers(found.cohorts[0])["midparent"] == pytest.approx(1.5)  # births to come do not bias slopes


def test_genes_and_traits_are_values_and_other_species_are_left_out():
    mixed = family(species=["finch"] * 7 + ["wren"] * 2)
    by_name, by_trait = (mixed.breeding("finch", name, every=4) for name in ("song", "Song.length"))
    assert repr(by_name.cohorts) == repr(by_trait.cohorts)
    assert by_name.whole.n == 7
    assert by_name.cohorts[2].births == 0  # 6 and 7 have a child of another species
    field = replace(mixed, recorded={SIZE: mixed.values("song", "finch")})
    assert repr(field.breeding("finch", SIZE, every=4).cohorts) == repr(by_name.cohorts)


def test_extinct_species_and_lone_founders_are_described():
    gone = [row if row[4] >= 0 else (*row[:4], 10, row[5]) for row in FAMILY]
    found = family(gone, end=50).breeding("finch", "song", every=4)
    assert found.whole.alive == 0
    assert [c.n for c in found.cohorts[3:]] == [0] * 10
    assert found.cohorts[2].births == 1.0  # 6 and 7
    alone = family(FAMILY[:2], end=10).breeding("finch", "song")
    assert len(alone.cohorts) == 1
    assert np.isnan(alone.generation)
    assert alone.whole.births == 0
    assert np.isnan(numbers(alone.whole)["differential"])


def test_misuse_is_refused():
    herd_of_five = five(**{PACE: [np.nan] * 5})
    with pytest.raises(KeyError, match=r'unknown recorded field .* did you mean "birth: Body.radius"'):
        herd_of_five.breeding("finch", "birth: Body.radiu")
    with pytest.raises(KeyError, match="unknown species 'fynch'"):
        herd_of_five.breeding("fynch", SIZE)
    with pytest.raises(KeyError, match="unknown gene 'sung'"):
        herd_of_five.gradients("finch", [SIZE, "sung"])
    with pytest.raises(ValueError, match="no organism of 'finch' has 'birth: Speed"):
        herd_of_five.breeding("finch", PACE)
    with pytest.raises(
        ValueError, match="every is 0, since is 0 and until is 9; expected every of at least 1"
    ):
        herd_of_five.breeding("finch", SIZE, every=0)
    with pytest.raises(ValueError, match="since is 5 and until is 4"):
        herd_of_five.breeding("finch", SIZE, since=5, until=4)
    with pytest.raises(ValueError, match="expected the name of at least one"):
        herd_of_five.gradients("finch", [])
