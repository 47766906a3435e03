"""Slots: death ends an episode, and the next body takes the place."""

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="ecs-eco[rl] is not installed")

from ecs_eco.components import Metabolism
from ecs_eco.engine.errors import ConfigError
from ecs_eco.rl import slots
from tests.rl.worlds import PASTURE


def test_each_slot_follows_one_body_until_it_dies():
    envs = slots(PASTURE, "deer", 4)
    _, infos = envs.reset(seed=2)
    ended = 0
    for _ in range(400):
        before = infos["uid"]
        x, _, dead, late, infos = envs.step(envs.action_space.sample())
        assert x.shape == (4, 4)
        assert (infos["uid"][~dead] == before[~dead])[before[~dead] > 0].all()
        assert (infos["uid"][dead] != before[dead]).all()
        assert not late.any()
        assert (infos["mask"] == (infos["uid"] > 0)).all()
        held = infos["uid"][infos["mask"]]
        assert len(np.unique(held)) == len(held)
        ended += dead.sum()
        for slot in np.flatnonzero(dead):
            assert infos["final_obs"][slot].shape == (4,)
            assert infos["final_info"]["cause"][slot] in ("starved", "old age")
            assert infos["final_info"]["uid"][slot] == before[slot]
    assert ended > 5


def test_a_body_in_a_slot_is_rewarded_and_dies_as_elsewhere():
    envs = slots(PASTURE, "deer", 3)
    x, infos = envs.reset(seed=1)
    one = int(infos["uid"][1])
    envs.arena.world.get(one, Metabolism).energy = -5.0
    later, reward, dead, _, infos = envs.step(np.zeros((3, 2), int))
    assert dead.tolist() == [False, True, False]
    assert reward[1] == pytest.approx(-1.0 - x[1, 0])
    assert reward[0] == pytest.approx(later[0, 0] - x[0, 0], abs=1e-6)
    assert infos["final_obs"][1].tolist() == x[1].tolist()
    assert infos["mask"].all()  # there were six: one without a slot took it


def test_empty_slots_are_masked_sense_zeros_and_are_filled_by_the_newborn():
    envs = slots(PASTURE, "deer", 8)
    x, infos = envs.reset(seed=1)
    assert infos["mask"].tolist() == [True] * 6 + [False] * 2
    assert not x[6:].any()
    for _ in range(60):
        _, reward, dead, _, infos = envs.step(np.zeros((8, 2), int))
        if infos["mask"].all():
            break
        assert not reward[~infos["mask"] & ~dead].any()
    assert infos["mask"].all()


def test_when_the_time_is_over_all_begin_anew_in_the_same_step():
    envs = slots(PASTURE, "deer", 4, max_cycles=3)
    envs.reset(seed=1)
    for cycle in range(3):
        x, _, _, late, infos = envs.step(np.zeros((4, 2), int))
        assert late.tolist() == [cycle == 2] * 4
    assert all(final is not None for final in infos["final_obs"])
    assert envs.arena.world.tick == 0
    assert x.any(axis=1).all()


def test_when_the_species_is_extinct_a_new_world_begins():
    envs = slots(PASTURE, "deer", 6)
    _, infos = envs.reset(seed=1)
    for uid in infos["uid"].tolist():
        envs.arena.world.get(uid, Metabolism).energy = -5.0
    _, _, dead, _, infos = envs.step(np.zeros((6, 2), int))
    assert dead.all()
    assert infos["mask"].all()


def test_the_same_seeds_make_the_same_steps():
    def steps(seed):
        envs = slots(PASTURE, "deer", 5)
        envs.reset(seed=seed)
        rng = np.random.default_rng(0)
        return [envs.step(rng.integers(0, 2, (5, 2)))[0].tolist() for _ in range(50)]

    assert steps(1) == steps(1)
    assert steps(1) != steps(2)


def test_impossible_actions_are_refused():
    envs = slots(PASTURE, "deer", 3)
    envs.reset(seed=1)
    with pytest.raises(ConfigError, match="no such option"):
        envs.step(np.full((3, 2), 5))
    with pytest.raises(TypeError, match="n is missing"):
        slots(PASTURE, "deer")


def test_our_own_ppo_trains_on_slots():
    from ecs_eco.learning import PPO, train

    training = train(slots(PASTURE, "deer", 5), PPO(horizon=16), 800, seed=1, hidden=(8,))
    assert training.brain.n_observations == 4
    assert len(training.returns) > 1


def test_a_free_slot_takes_any_of_the_living():
    species = PASTURE["species"] | {"deer": PASTURE["species"]["deer"] | {"count": 40, "max_count": 40}}
    envs, taken = slots(PASTURE | {"species": species}, "deer", 4), []
    for seed in range(40):
        taken += envs.reset(seed=seed)[1]["uid"].tolist()
    first = min(taken)
    assert len(taken) == 160
    assert abs(np.mean(taken) - first - 19.5) < 4 * 40 / np.sqrt(12 * 160)
