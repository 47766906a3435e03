"""The breeder's view: counted by hand, against slow twins, and in simulated herds of known heritability."""

from dataclasses import replace

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.analysis.breeding import _Born, forest, responses
from ecs_eco.analysis.figures import save
from ecs_eco.analysis.lineage import ALIVE, Lineage
from ecs_eco.config import load
from ecs_eco.record import Recorder
from tests.analysis.families import FAMILY, family, forest as forest_of

SIZE, PACE = "birth: Body.radius", "birth: Speed.pace"
T2 = 4.302653  # the 97.5% point of Student's t with 2 degrees of freedom


def herd(mother, father, born, died, end, **fields):
    """A lineage of finches from indices of parents (−1: none) and recorded fields."""
    rows = zip(np.add(mother, 1), np.add(father, 1), born, died, strict=True)
    made = family([(i + 1, *map(int, row), "AA") for i, row in enumerate(rows)], end=end)
    return replace(made, recorded={name: np.array(of, float) for name, of in fields.items()})


def five(**more):
    """Three founders: 1 and 2 have a child, 2 has another one alone, 3 has none."""
    mother, father = [-1, -1, -1, 0, 1], [-1, -1, -1, 1, -1]
    return herd(mother, father, [0, 0, 0, 4, 5], [6, 7, 7, 8, 9], 9, **{SIZE: [1, 3, 2, 2.5, 4]} | more)


def values(cohort):
    return {name: x.value for name, x in cohort.estimates.items()}


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
    assert values(parents) == pytest.approx(counted)
    # relative fitness v = 3/4, 9/4, 0 and d = −1, 1, 0: v (d − S) − d = −1/8, 1/8, 0
    half = T2 * np.sqrt(2 * (1 / 8) ** 2 / 9 * 3 / 2)
    assert parents.estimates["differential"] == pytest.approx((0.5, 0.5 - half, 0.5 + half))
    assert (children.n, children.births) == (2, 0.0)
    assert values(children)["mean"] == 3.25
    assert np.isnan([values(children)[name] for name in ("differential", "response", "midparent")]).all()
    assert none.n == 0
    assert np.isnan([none.alive, *values(none).values()]).all()
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
    assert list(values(plain.whole).values()) == pytest.approx([0.4, -1])
    unit = np.sqrt(1.25)
    assert list(values(herd_of_four.gradients("finch", [SIZE]).whole).values()) == pytest.approx(
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
    assert np.isnan(list(values(twins.gradients("finch", [SIZE, PACE]).whole).values())).all()
    constant = finches(**{SIZE: size, PACE: np.full(10, 0.3)})
    found = constant.gradients("finch", [SIZE, PACE]).whole.estimates
    for name, x in found.items():
        assert x == pytest.approx(known.get(name, (np.nan,) * 3), nan_ok=True), name
    of = values(constant.breeding("finch", PACE).whole)  # in spite of rounding
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
    rows = [row if row[4] >= 0 else (*row[:4], 30, row[5]) for row in forest_of(seed)]
    z = np.random.default_rng(seed).normal(5, 1, len(rows))
    lineage = replace(family(rows, end=30), recorded={SIZE: z})
    found = lineage.breeding("finch", SIZE, every=10)
    for cohort in found.cohorts[:2]:
        of = values(cohort)
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
    x = b.interval(1.0, score, np.arange(52))
    t = (
        2.009575
        if families == 51
        else (x.high - 1) / np.sqrt(score @ kin @ score * families / (families - 1))
    )
    assert 1.96 < t < 2.03
    assert x.high - 1 == pytest.approx(1 - x.low)


def discrete(seed, sexes, slope=0.4, n=200, generations=12, mutation=0.3, noise=0.7071):
    """Generations of n without overlap, fitness exp(slope × value), and the heritability of each generation:
    inherited values are midparents + segregation, or the parent's + mutation; others are noise."""
    rng = np.random.default_rng(seed)
    inherited, parents, h2 = [rng.normal(0, 0.7071, n)], [np.full((2, n), -1)], []
    seen = [inherited[0] + rng.normal(0, noise, n)]
    for g in range(generations):
        a, z = inherited[-1], seen[-1]
        h2.append(np.cov(a, z, ddof=0)[0, 1] / z.var())
        p = np.exp(slope * z) / np.exp(slope * z).sum()
        pair = rng.choice(n, (2, n), p=p)
        child = (
            a[pair[0]] + rng.normal(0, mutation, n) if sexes == 1 else a[pair].mean(0) + rng.normal(0, 0.5, n)
        )
        parents.append(np.where([[True], [sexes == 2]], pair + g * n, -1))
        inherited.append(child)
        seen.append(child + rng.normal(0, noise, n))
    born = np.repeat(np.arange(generations + 1) * 10, n)
    died = np.where(born + 11 <= 10 * generations, born + 11, ALIVE)
    return herd(*np.hstack(parents), born, died, 10 * generations, **{SIZE: np.concatenate(seen)}), np.mean(
        h2
    )


def holds(interval, truth):
    return interval.low <= truth <= interval.high


@pytest.mark.parametrize("sexes", [1, 2])
def test_the_breeders_equation_holds_in_simulated_generations(sexes):
    off, inside = [], []
    for seed in range(20):
        lineage, h2 = discrete(seed, sexes)
        found = lineage.breeding("finch", SIZE)
        assert found.generation == 10
        of = found.whole.estimates
        truth = {"realized": h2, "midparent": h2, "one_parent": h2 / sexes}
        truth["response"] = h2 * of["differential"].value
        off.append([of[name].value - x for name, x in truth.items()])
        inside.append([holds(of[name], x) for name, x in truth.items()])
    # seeds are fixed; on average the estimates are right to a fifth of h²/2, and 95% intervals hold mostly
    assert np.abs(np.mean(off, axis=0)).max() < 0.03
    assert (np.sum(inside, axis=0) >= 15).all()
    assert np.sum(inside, axis=0)[0] >= 18
    assert np.std(off, axis=0).max() < 0.1


def test_without_noise_and_mutation_the_response_is_the_differential():
    lineage, _ = discrete(1, 1, mutation=0, noise=0, generations=4)
    found = lineage.breeding("finch", SIZE)
    for cohort in found.cohorts[:3]:
        assert values(cohort)["response"] == pytest.approx(values(cohort)["differential"])
    for name in ("realized", "midparent", "one_parent"):
        assert found.whole.estimates[name] == pytest.approx((1, 1, 1), abs=1e-6), name


def test_mutation_shifts_the_response_and_nothing_else():
    lineage, _ = discrete(1, 1, mutation=0, noise=0, generations=4)
    shifted = replace(lineage, recorded={SIZE: lineage.recorded[SIZE] - 0.1 * (lineage.born // 10)})
    before, after = (x.breeding("finch", SIZE) for x in (lineage, shifted))
    for one, two in zip(before.cohorts[:3], after.cohorts[:3], strict=True):
        assert values(two)["response"] == pytest.approx(values(one)["response"] - 0.1)
        assert values(two)["differential"] == pytest.approx(values(one)["differential"])
        assert values(two)["midparent"] == pytest.approx(1)


def test_without_selection_intervals_hold_zero():
    inside = [
        holds(discrete(s, 2, slope=0)[0].breeding("finch", SIZE).whole.estimates["differential"], 0)
        for s in range(20)
    ]
    assert sum(inside) >= 16


def test_gradients_are_found_in_simulated_fitness():
    inside, n = [], 400
    for seed in range(20):
        rng = np.random.default_rng(seed)
        z = rng.normal(0, 1, (n, 2)) @ [[1, 0.5], [0, 1]]
        fitness = np.exp(0.3 * z[:, 0] - 0.15 * z[:, 0] ** 2 + 0.1 * z[:, 0] * z[:, 1])
        expected = n * fitness / fitness.sum()
        d = z - z.mean(0)
        terms = np.c_[d, d[:, 0] ** 2 / 2, d[:, 0] * d[:, 1], d[:, 1] ** 2 / 2]
        beta = np.linalg.lstsq(d, expected - 1)[0]
        gamma = np.linalg.lstsq(np.c_[np.ones(n), terms], expected)[0][3:]
        mother = np.concatenate([np.full(n, -1), rng.choice(n, n, p=expected / n)])
        child = z[mother[n:]]
        fields = {SIZE: np.r_[z[:, 0], child[:, 0]], PACE: np.r_[z[:, 1], child[:, 1]]}
        made = herd(mother, [-1] * 2 * n, [0] * n + [5] * n, [6] * n + [ALIVE] * n, 5, **fields)
        found = made.gradients("finch", [SIZE, PACE], standardized=False).whole.estimates
        inside.append([holds(x, t) for x, t in zip(found.values(), [*beta, *gamma], strict=True)])
    assert (np.sum(inside, axis=0) >= 15).all()
    assert np.mean(inside) > 0.88


def overlapping(seed, ticks=400, n=200, death=0.05):
    """A herd of n of two parents that overlap: each tick some die, and larger ones have more of the young."""
    rng = np.random.default_rng(seed)
    inherited = list(rng.normal(0, 0.7071, n))
    seen = [a + rng.normal(0, 0.7071) for a in inherited]
    mother, father, born, died, living = [-1] * n, [-1] * n, [0] * n, [ALIVE] * n, np.arange(n)
    for tick in range(1, ticks + 1):
        dying = rng.random(n) < death
        for i in living[dying]:
            died[i] = tick
        left = living[~dying]
        p = np.exp(0.3 * np.array([seen[i] for i in left]))
        for _ in range(int(dying.sum())):
            i, j = rng.choice(left, 2, p=p / p.sum())
            inherited.append((inherited[i] + inherited[j]) / 2 + rng.normal(0, 0.5))
            seen.append(inherited[-1] + rng.normal(0, 0.7071))
            for column, value in zip((mother, father, born, died), (i, j, tick, ALIVE), strict=True):
                column.append(int(value))
        living = np.append(left, np.arange(len(seen) - dying.sum(), len(seen)))
    return herd(mother, father, born, died, ticks, **{SIZE: seen}), np.array(inherited)


def cut(lineage, end):
    """The lineage as it was at an earlier tick."""
    early = lineage.born <= end
    made = lineage._chosen(early)
    return replace(made, end=end, died=np.where(made.died > end, ALIVE, made.died))


def test_overlapping_generations_and_those_who_live_at_the_end():
    whole, inherited = overlapping(3)
    found, early = (x.breeding("finch", SIZE, every=20) for x in (whole, cut(whole, 259)))
    finished = [c for c in early.cohorts if c.alive == 0]
    nearly = [c for c in early.cohorts if 0 < c.alive <= 0.05]
    unfinished = [c for c in early.cohorts if c.alive > 0.05]
    assert len(finished) > 4
    assert len(nearly) > 0
    assert len(unfinished) > 1
    for c in finished:  # later births change nothing
        same = found.cohorts[early.cohorts.index(c)]
        assert (c.n, c.births) == (same.n, same.births)
        assert values(c) == pytest.approx(values(same))
    for c in nearly:  # births so far
        same = found.cohorts[early.cohorts.index(c)]
        assert 0.95 * same.births < c.births <= same.births
        assert values(c)["differential"] == pytest.approx(values(same)["differential"], abs=0.1)
    for c in unfinished:
        assert np.isnan(
            [values(c)[name] for name in ("opportunity", "differential", "intensity", "response")]
        ).all()
    used = sum(c.births for c in early.cohorts if c.alive <= 0.05)
    s = sum(c.births * values(c)["differential"] for c in early.cohorts if c.alive <= 0.05) / used
    assert early.whole.estimates["differential"].value == pytest.approx(s)
    b = _Born(whole, "finch", (SIZE,), 20, 0, None)
    done, k, d = b.complete[b.cohort], b.cohort, b.away[:, 0]
    h2 = np.sum((d * (inherited - b.per_cohort(inherited)[k]))[done]) / np.sum(d[done] ** 2)
    of = found.whole.estimates
    assert holds(of["realized"], h2)
    assert holds(of["midparent"], h2)
    assert holds(of["one_parent"], h2 / 2)
    assert of["realized"].high - of["realized"].low < 0.5


def test_the_window_can_be_chosen():
    whole, _ = overlapping(3, ticks=150)
    part = whole.breeding("finch", SIZE, every=25, since=20, until=79)
    assert [(c.start, c.stop) for c in part.cohorts] == [(20, 45), (45, 70), (70, 80)]
    assert part.whole.n == ((whole.born >= 20) & (whole.born < 80)).sum()
    assert part.whole.births > part.whole.n * 0.5  # children born later count


def test_organisms_without_the_value_count_only_as_offspring():
    found = five(**{SIZE: [1, 3, 2, np.nan, 4]}).breeding("finch", SIZE, every=4)
    first = values(found.cohorts[0])
    assert (first["differential"], first["response"]) == pytest.approx((0.5, 2))
    assert found.cohorts[0].births == 2
    assert found.cohorts[1].n == 1
    lone = values(five(**{SIZE: [np.nan, 3, 2, 2.5, 4]}).breeding("finch", SIZE, every=4).cohorts[0])
    assert lone["differential"] == 3 - 2.5  # of 2 and 3, of which 2 has births
    assert lone["response"] == pytest.approx((0.5 * 2.5 + 4) / 1.5 - 2.5)


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
    assert np.isnan(values(alone.whole)["differential"])


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


def test_tables_and_figures(tmp_path):
    lineage, _ = discrete(0, 2)
    found = lineage.breeding("finch", SIZE)
    table = found.to_pandas()
    assert table.shape == (13, 5 + 3 * 8)
    assert table["response_low"][0] < table["response"][0] < table["response_high"][0]
    drawn = responses(found, "finches")
    assert [ax.get_title(loc="left") for ax in drawn.axes[:2]] == ["finches", "Selection and response"]
    assert save(drawn, tmp_path / "responses.png").stat().st_size > 5000
    drawn = forest(lineage.gradients("finch", [SIZE]))
    assert [label.get_text() for label in drawn.axes[0].get_yticklabels()] == [
        f"β {SIZE}",
        f"γ {SIZE} × {SIZE}",
    ]
    assert save(drawn, tmp_path / "forest.png").stat().st_size > 5000


HUNGER = {"name": "hunger", "trait": "metabolism.basal", "letters": 4, "low": 0.0, "high": 0.02}
SIZES = {"name": "size", "trait": "body.radius", "letters": 3, "low": 0.25, "high": 0.35}
GOATS = {
    "space.size": [50.0, 50.0],
    "species.green.count": 900,
    "species.green.reproduction.seed_rain": 0.02,
    "species.red.count": 0,
    "species.yellow.count": 0,
    "species.goat.count": 200,
    "species.goat.diet.2.gain": 0.4,
    "species.goat.genome.genes": [HUNGER | {"code": "additive", "codons": 4}, SIZES],
    "species.goat.lethal.1.max": 80.0,
    "species.goat.policy.learn": False,
    "species.goat.reproduction.age_min": 20.0,
    "species.goat.reproduction.rest": 20.0,
    "viewer.knobs": [],
    "record": ["Body.radius"],
}


@pytest.mark.slow
def test_goats_evolve_to_burn_less():
    world = World.from_config(load("reflexes", GOATS), seed=1, record=False)
    Recorder(world, keep_events=True)
    world.run(400)
    lineage = Lineage.of(world)
    found = lineage.breeding("goat", "hunger")
    of = found.whole.estimates
    assert of["differential"].high < 0
    assert of["response"].high < 0
    first, *_, last = found.cohorts
    assert last.estimates["mean"].high < first.estimates["mean"].low
    # the gene is additive, two parents pass on half each, and few letters mutate
    assert of["midparent"].value == pytest.approx(1, abs=0.1)
    assert of["one_parent"].value == pytest.approx(0.5, abs=0.1)
    assert of["realized"].value == pytest.approx(1, abs=0.3)
    assert holds(of["realized"], 0.95)
    gradients = lineage.gradients("goat", ["hunger", "size"])
    assert gradients.whole.estimates["β hunger"].high < 0
    sizes, radii = (lineage.breeding("goat", name).whole.estimates for name in ("size", SIZE))
    for name in sizes:  # the gene sets the recorded field, in single precision
        assert radii[name] == pytest.approx(sizes[name], rel=1e-4, abs=1e-6), name
