"""Contributions of organisms counted by hand, and against a slow plain twin."""

import numpy as np
import pytest

from ecs_eco.analysis.lineage import ALIVE
from ecs_eco.explain import steps_of
from ecs_eco.explain.drift import rise_test
from tests.analysis.families import family, forest
from tests.explain.populations import population

#            uid, mother, father, born, died, genome: four founders have 2, 1, 1 and 0 children
GENERATIONS = [
    (1, 0, 0, 0, 1, "A"),
    (2, 0, 0, 0, 1, "A"),
    (3, 0, 0, 0, 1, "A"),
    (4, 0, 0, 0, 1, "A"),
    (5, 1, 0, 1, ALIVE, "A"),
    (6, 1, 0, 1, ALIVE, "A"),
    (7, 2, 0, 1, ALIVE, "A"),
    (8, 3, 0, 1, ALIVE, "A"),
]


def test_separate_generations_have_the_effective_size_of_textbooks():
    steps = steps_of(family(GENERATIONS, end=1), every=1)
    assert steps.generation == 1
    assert steps.living.tolist() == [4, 4]
    assert steps.both.excess[:4].tolist() == [1, 0, 0, -1]
    assert steps.both.value.tolist() == [4]
    assert steps.effective_size().tolist() == [8]  # N / Var(children) = 4 / 0.5


def test_a_child_of_two_parents_counts_half_for_each_and_whole_for_its_mothers_line():
    rows = [list(row) for row in GENERATIONS]
    rows[4][2] = 4  # the first child has a father, who had none
    steps = steps_of(family(rows, end=1), every=1)
    assert steps.both.excess[:4].tolist() == [0.5, 0, 0, -0.5]
    assert steps.maternal.excess[:4].tolist() == [1, 0, 0, -1]
    assert steps.pairs.tolist() == [1]


def test_organisms_that_all_breed_once_at_the_same_age_do_not_drift():
    # each has a child at age 2, and lives to age 4
    rows = [(1, 0, 0, 0, 4, "A"), (2, 0, 0, 0, 4, "A"), (3, 1, 0, 2, 6, "A"), (4, 2, 0, 2, 6, "A")]
    rows += [(5, 3, 0, 4, ALIVE, "A"), (6, 4, 0, 4, ALIVE, "A")]
    steps = steps_of(family(rows, end=7), every=1)
    assert np.allclose(steps.both.excess, 0)
    assert steps.both.value[:5].tolist() == [2, 2, 2, 2, 2]  # newborns are worth 1 until they breed, then 0


@pytest.mark.parametrize("seed", range(3))
def test_excesses_agree_with_a_slow_plain_twin(seed):
    lineage = family(forest(seed, 80), end=30)
    steps = steps_of(lineage, every=3)
    died = np.where(lineage.died < 0, 31, lineage.died)
    for share, found in ((0.5, steps.both), (0.0, steps.maternal)):
        ages, values = _values_of(lineage, died, share)
        expected = {}
        for k in range(len(steps.ticks) - 1):
            begin, end = steps.ticks[k], steps.ticks[k + 1]
            start, after = {}, {}
            for i in range(len(lineage)):
                born = lineage.born[i]
                if died[i] <= begin or born > end:
                    continue
                start[i] = np.interp(max(begin - born, 0), ages, values)
                after[i] = np.interp(end - born, ages, values) if died[i] > end else 0.0
            for child in range(len(lineage)):
                if begin < lineage.born[child] <= end:
                    parents = [p for p in (lineage.mother[child], lineage.father[child]) if p >= 0]
                    for n, parent in enumerate(parents):
                        part = 1.0 if len(parents) == 1 else (1 - share, share)[n]
                        if parent in after:
                            after[parent] += part
                        else:
                            expected[parent, k - 1] += part  # it died as its child was born
            growth = sum(after.values()) / sum(start.values())
            expected |= {(i, k): after[i] - growth * start[i] for i in start}
        got = dict(
            zip(zip(steps.organism.tolist(), steps.step.tolist(), strict=True), found.excess, strict=True)
        )
        assert got.keys() == expected.keys()
        assert np.allclose([got[key] for key in got], [expected[key] for key in got])


def _values_of(lineage, died, share):
    """Births to come by age, from the rates of births and deaths in the tick after each age."""
    ended = died < died.max()
    lived = died - lineage.born - ~ended
    most = int(lived.max())
    exposed = np.array([max((lived > a).sum(), 1) for a in range(most)])
    deaths = np.array([((lived == a + 1) & ended).sum() for a in range(most)])
    births = np.zeros(most)
    for child in range(len(lineage)):
        parents = [p for p in (lineage.mother[child], lineage.father[child]) if p >= 0]
        for n, parent in enumerate(parents):
            part = 1.0 if len(parents) == 1 else (1 - share, share)[n]
            births[min(lineage.born[child] - lineage.born[parent], lived[parent]) - 1] += part
    values = [0.0]
    for a in range(most - 1, -1, -1):
        values.insert(0, births[a] / exposed[a] + (1 - deaths[a] / exposed[a]) * values[0])
    return np.arange(most + 1), np.array(values) / values[0]


def test_the_effective_size_predicts_the_spread_of_neutral_letters():
    lineage = population(1, n=400, ticks=300, loci=60, parents=2)
    steps = steps_of(lineage)
    first, last = lineage.alive(0), lineage.alive(300)
    letters = np.array([list(g) for g in lineage.genome]) == "T"
    p, after = letters[first].mean(axis=0), letters[last].mean(axis=0)
    spread = ((after - p) ** 2 / (p * (1 - p))).mean()
    # unequal contributions and, of two haploid parents, the toss between their letters: pq / 2 for each birth
    assert steps.pairs.sum() == (lineage.parent > 0)[lineage.born <= steps.ticks[-1]].sum()
    drift = (1 / steps.effective_size() + steps.pairs / 2 / steps.both.value**2).sum()
    assert spread == pytest.approx(1 - np.exp(-drift), rel=0.35)  # 60 letters: 18% standard error


def test_a_species_without_recorded_births_says_what_to_record():
    rows = [(1, 0, 0, 0, 4, "A"), (2, 0, 0, 1, ALIVE, "A")]
    with pytest.raises(ValueError, match="no finch was born to parents"):
        steps_of(family(rows))
    with pytest.raises(ValueError, match="record a longer run"):
        steps_of(family(GENERATIONS, end=1), every=5)


def test_a_gain_without_variance_is_no_rise():
    s, error, ratio, p = rise_test(*np.array([[1.0], [0.0], [0.0], [0.0]]))
    assert np.isnan([s[0], error[0]]).all()
    assert (ratio[0], p[0]) == (0, 1)


def test_a_negative_skew_makes_no_rise_certain():
    *_, p = rise_test(*np.array([[3.0], [1.0], [-1.9], [1.0]]))
    assert p[0] == pytest.approx(0.0027, rel=0.01)
