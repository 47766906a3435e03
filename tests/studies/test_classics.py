"""Three classic experiments: their statistics on numbers counted by hand."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from studies import fishing_for_size, learning_classics, prudence, rapid_evolution


def run(arm, seed, **result):
    return {"case": {"arm": arm, "seed": seed}, "result": result}


def test_only_cycles_with_a_lag_nearer_to_a_half_than_to_a_quarter_are_near_antiphase():
    lags = [0.25, 0.37, 0.38, 0.5, 0.62, 0.63, None]
    cases = [run("clones", seed, lag=lag, cycles=True) for seed, lag in enumerate(lags)]
    cases += [run("clones", 7, lag=0.5, cycles=False), run("clone", 0, lag=0.5, cycles=True)]
    assert rapid_evolution.antiphase(cases, "clones") == 3


def test_arms_are_compared_by_seed_without_those_that_lack_a_value_in_one_of_them():
    cases = [run("clones", seed, period=period) for seed, period in ((1, 300.0), (2, 320.0), (3, None))]
    cases += [run("clone", seed, period=100.0) for seed in (1, 2, 3)]
    mean, low, high = rapid_evolution.gap(cases, "period", "clones", "clone")
    half = 12.706 * 14.142 / 2**0.5  # Student's t with one degree of freedom; 200 and 220 deviate by 14.142
    assert (mean, low, high) == pytest.approx((210.0, 210 - half, 210 + half), abs=0.1)


def test_a_pause_undoes_half_of_a_change_in_log_weight_from_8_to_2_grams_with_4_at_its_end():
    weights = [0.0] * 31
    weights[fishing_for_size.BEFORE], weights[fishing_for_size.AFTER], weights[-1] = 8.0, 2.0, 4.0
    cases = [run("largest", seed, weight=" ".join(map(str, weights))) for seed in (1, 2)]
    with np.errstate(divide="ignore"):
        assert fishing_for_size.recovery(cases, "largest") == [0.5, 0.5, 0.5]


def test_ratios_of_catches_are_of_totals_and_paired_by_seed():
    cases = [run("smallest", 1, **{"yield": "1 2 3"}), run("largest", 1, **{"yield": "9 2 0.5"})]
    cases += [run("smallest", 2, **{"yield": "0 5 5"}), run("largest", 2, **{"yield": "0 4 1"})]
    first, second = (fishing_for_size.catch(cases, arm, 1, 3) for arm in ("smallest", "largest"))
    assert fishing_for_size.ratio(first, second)[0] == 2.0  # 5 to 2.5, and 10 to 5


def test_selection_is_split_into_slopes_within_and_among_patches():
    intake, young, where = np.array([1.0, 3.0, 4.0]), np.array([0, 2, 5]), np.array([0, 0, 1])
    parts = prudence.selection(intake, young, where, after=np.array([0, 3, 7]))  # patch 2 had no grazers
    # deviations of intake: -1, 1 and 0 within patches, -1 and 1 among them, -5/3, 1/3 and 4/3 in all;
    # 1 + grazers: from 3 to 1, and from 2 to 4
    assert parts == pytest.approx([2, 2, np.log(3) + np.log(2), 2, 14 / 3])


def test_late_values_are_means_of_the_last_samples_and_their_ratios_are_paired_by_seed():
    cases = [run("local", 2, intake="9 2 3 5"), run("local", 1, intake="9 9 1 3")]
    cases += [run("global", 1, intake="1 1 4 6"), run("global", 2, intake="1 1 8 10")]
    local, other = (prudence.late(cases, arm, part=2) for arm in ("local", "global"))
    assert np.exp(local) == pytest.approx([2, 4])
    assert np.exp(other) == pytest.approx([5, 9])
    assert np.exp(prudence.late(cases, "local")) == pytest.approx([3, 5])
    assert prudence.ratio(local - other)[0] == pytest.approx((2 / 5 * 4 / 9) ** 0.5, abs=1e-3)


@pytest.mark.parametrize("seed", [None, 1])
def test_newborns_exchange_places_only_if_shuffled_and_their_mothers_are_noted(seed):
    section = prudence.WORLD["species"]
    small = {"plant": section["plant"] | {"count": 150}, "grazer": section["grazer"] | {"count": 40}}
    world = World.from_config(
        prudence.WORLD | {"space": {"size": [20.0, 20.0], "edges": "torus"}, "species": small}, seed=1
    )
    grazers, mothers, places, noted = world.table("grazer"), list[int](), [], []

    def note(table, rows, parents, _):
        if table is grazers:
            noted.append(parents.tolist())
            places.append(list(zip(table[Position].x[rows], table[Position].y[rows], strict=True)))

    world.on_birth += [note, prudence.settle(grazers, mothers, seed), note]
    world.run(30)
    before, after = places[::2], places[1::2]
    assert len(mothers) > 20
    assert mothers == [uid for some in noted[::2] for uid in some]
    assert [sorted(some) for some in before] == [sorted(some) for some in after]
    assert (before == after) is (seed is None)


def test_learners_are_compared_by_last_quarters_last_catches_and_doubled_neighbors():
    eats, intake = "1 1 1 1 1 1 0.5 0.7", "0.2 0.2 0.2 0.2 0.2 0.2 0.4 0.6"
    cases = [
        run("local, learn", 1, eats=eats, intake=intake),
        run("local, learn", 2, eats=None, intake=intake),
    ]
    assert learning_classics.end(cases, "local, learn", "eats") == pytest.approx({1: 0.6})
    assert learning_classics.intake(cases[:1], "local, learn") == pytest.approx({1: 0.6 * 0.5})
    years = [0.0] * (learning_classics.LAST - 3) + [1.0, 2.0, 4.0, 99.0]
    caught = [
        run("fished", 1, **{"yield": " ".join(map(str, years))}),
        run("fished", 2, **{"yield": "0 " * 20}),
    ]
    assert learning_classics.catch(caught, "fished") == {1: 7.0, 2: 1.0}
    near = [run("confusion, learn", 1, near="3 6.2 6.4 3"), run("confusion, learn", 2, near="3 3 3 3")]
    assert round(learning_classics.SCATTERED, 4) == 3.1416  # 400 / 60² · π · 3²
    assert learning_classics.doubled(near, "confusion, learn") == [750]  # the third look of every 250 ticks
    assert learning_classics.ratio({1: 2.0, 2: 8.0, 3: 1.0}, {1: 1.0, 2: 1.0})[0] == pytest.approx(
        4.0, abs=0.01
    )
    assert learning_classics.gap({1: 2.0, 2: 8.0}, {1: 1.0, 2: 1.0})[0] == 4.0


def test_each_arm_is_the_arm_of_its_study_with_its_own_changes():
    for arm, of in learning_classics.ARMS.items():
        world, _ = learning_classics.world_of(arm)
        learns = [species.policy.learn for species in world.species.values()]
        assert sum(learns) == of["learn"], arm
    world, own = learning_classics.world_of("not fished, learn")
    assert (own, world.land_use[0].rate, world.species["silverside"].policy.hidden) == ("none", 0.0, [8])
