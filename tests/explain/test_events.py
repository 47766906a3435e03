"""Sweeps that were planted are found, and drift is not taken for one."""

import numpy as np
import pytest

from ecs_eco.engine.uids import BITS
from ecs_eco.explain import assess, follow, rises
from ecs_eco.explain.events import _kind, _windows
from tests.analysis.families import family
from tests.explain.populations import population


def test_a_planted_letter_is_found_with_its_strength():
    lineage = population(1, n=500, ticks=700, loci=6, parents=2, s=0.3, start=0.1, locus=2)
    (sweep,) = rises(lineage)
    assert sweep.lead.name == "letter T at locus 2"
    assert sweep.interval[0] < 0.3 < sweep.interval[1]
    assert sweep.kind == "complete"
    assert sweep.first <= 0.11
    assert sweep.last > 0.95
    assert 0 <= sweep.begin < sweep.half < sweep.end <= 700
    at = dict(zip(sweep.ticks.tolist(), sweep.path.tolist(), strict=True))
    assert at[sweep.begin] <= sweep.first + 0.25 * (max(at.values()) - sweep.first)
    assert at[sweep.half] >= 0.5
    assert sweep.p <= sweep.q < 0.01


def test_linked_letters_are_one_event_and_the_letter_names_it():
    rng = np.random.default_rng(1)
    founders = rng.random((300, 1, 4)) < 0.5
    founders[:, 0, 0] = np.arange(300) < 60
    founders[:, 0, 1] = founders[:, 0, 0]  # a hitchhiker
    lineage = population(
        3, n=300, ticks=400, loci=4, parents=2, recombination=0.001, s=0.4, founders=founders
    )
    sweeps = rises(lineage)
    first = max(sweeps, key=lambda sweep: -sweep.p)
    assert first.lead.kind == "letter"
    assert {first.lead.locus} | {a.locus for a, _ in first.linked if a.kind == "letter"} >= {0, 1}
    assert all(r2 >= 0.5 or allele.kind != "letter" for allele, r2 in first.linked)


def test_letters_that_a_clone_carries_along_are_of_its_event():
    lineage = population(3, n=1000, ticks=600, loci=100, parents=1, s=0.3, start=0.05)
    (sweep,) = rises(lineage)
    assert sweep.lead.locus == 0
    assert "letter" in {allele.kind for allele, _ in sweep.linked}
    assert min(r2 for _, r2 in sweep.linked) < 0.5  # of other frequency: rose with it alone


def test_two_copies_each_add_their_benefit():
    lineage = population(2, n=300, ticks=400, loci=3, ploidy=2, parents=2, s=0.25, start=0.1)
    (sweep,) = rises(lineage)
    assert sweep.lead.locus == 0
    assert sweep.interval[0] < 0.25 < sweep.interval[1]


@pytest.mark.slow
@pytest.mark.parametrize(("parents", "ploidy", "mutation"), [(1, 1, 0.0), (2, 1, 0.01), (2, 2, 0.0)])
def test_drift_gives_small_p_values_no_more_often_than_they_say(parents, ploidy, mutation):
    p = [
        chance
        for seed in range(12)
        for paths in [
            follow(population(seed, 200, 400, 30, ploidy=ploidy, parents=parents, mutation=mutation), "a")
        ]
        for allele, chance in zip(paths.alleles, assess(paths).p, strict=True)
        if allele.value == "T"
    ]
    for limit in (0.5, 0.1, 0.02):
        assert np.mean(np.array(p) <= limit) <= limit * 1.3


def test_windows_are_the_run_and_its_equal_parts():
    assert _windows(20) == [(0, 20)]
    assert _windows(64) == [(0, 64), (0, 32), (32, 64), (0, 16), (16, 32), (32, 48), (48, 64)]


@pytest.mark.parametrize(
    ("path", "end", "kind"),
    [
        ([0.1, 0.5, 0.97, 0.99, 1, 1, 1, 1, 1], 2, "complete"),
        ([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.8], 8, "partial"),
        ([0.1, 0.5, 0.6, 0.62, 0.6, 0.6, 0.61, 0.6, 0.6, 0.61, 0.6, 0.6], 2, "balanced"),
        ([0.1, 0.5, 0.8, 0.6, 0.3, 0.1, 0.1, 0.05, 0], 2, "passing"),
    ],
)
def test_a_rise_is_called_by_what_became_of_it(path, end, kind):
    path = np.array(path)
    assert _kind(path, 0.1, path.max() - 0.1, end) == kind


def test_one_founder_and_an_extinct_species_have_no_sweeps():
    one = [(1, 0, 0, 0, -1, "AC"), *((i, i - 1, 0, i, -1, "AC") for i in range(2, 30))]
    assert rises(family(one, end=30)) == []
    gone = [(i, i - 3 if i > 3 else 0, 0, i // 3, i // 3 + 3, "AC"[i % 2] + "A") for i in range(1, 60)]
    assert rises(family(gone, end=60)) == []


def test_errors_say_what_is_missing():
    alone = family([(1, 0, 0, 0, -1, "A"), (2, 0, 0, 0, 3, "A")])
    with pytest.raises(ValueError, match="record a world in which a species reproduces"):
        rises(alone)
    with pytest.raises(ValueError, match="record a world in which a species reproduces"):
        rises(
            family([(1, 0, 0, 0, -1, "A"), (2, 1, 0, 0, 3, "A")])
        )  # in the tick in which its parent appears
    with pytest.raises(ValueError, match="no finch was born"):
        rises(alone, "finch")
    with pytest.raises(KeyError, match="cat"):
        rises(alone, "cat")
    with pytest.raises(ValueError, match="fdr is 2"):
        rises(alone, fdr=2)


def test_an_island_that_grows_is_no_sweep_of_its_letters():
    rng = np.random.default_rng(1)
    rows, living = [], {0: [], 1: []}
    for island, letter in ((0, "A"), (1, "T")):
        for i in range(1, 41):
            uid = (island << BITS) + i
            rows.append([uid, 0, 0, 0, -1, letter])
            living[island].append(len(rows) - 1)
    count = [40, 40]
    for tick in range(1, 60):
        for island, letter in ((0, "A"), (1, "T")):
            for at in rng.permutation(living[island])[: len(living[island]) // 10]:
                rows[at][4] = tick
                living[island].remove(at)
            young = len(living[island]) // (6 if island else 12)
            for mother in rng.choice(living[island], young):
                count[island] += 1
                uid = (island << BITS) + count[island]
                rows.append([uid, rows[mother][0], 0, tick, -1, letter])
                living[island].append(len(rows) - 1)
    lineage = family(rows, end=60, genomes={"finch": {"alphabet": "AT", "ploidy": 1, "genes": []}})
    paths = follow(lineage, "finch")
    letters = [j for j, allele in enumerate(paths.alleles) if allele.kind == "letter"]
    assert paths.p[-1, letters].max() > 0.8
    assert np.allclose(paths.gain[:, letters], 0)
    assert not any(sweep.lead.kind == "letter" for sweep in rises(lineage))
