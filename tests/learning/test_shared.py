import numpy as np
import pytest

from ecs_eco.learning import PPO, Brain, Learner
from ecs_eco.learning.continuous import CONTINUOUS
from ecs_eco.learning.rollout import Rollout
from ecs_eco.learning.shared import SharedLearner

SETTINGS = PPO(horizon=2, epochs=2, minibatch_size=100, learning_rate=0.01, anneal=0)


def learner():
    return Learner(Brain(3, (2,), (4,), seed=1), SETTINGS, seed=5)


def live(store, world, n=3, ticks=2):
    """Two ticks of `n` animals of one world, the same for whoever stores them."""
    rng = np.random.default_rng(world)
    rows = np.arange(n)
    for _ in range(ticks):
        store.store(
            rows,
            rng.normal(size=(n, 3)).astype("f4"),
            rng.integers(0, 2, (n, 1)),
            np.full(n, -0.7, "f4"),
            np.zeros(n, "f4"),
        )
        store.credit(rows, rng.normal(size=n).astype("f4"))
    return rows, np.zeros(n, np.float32)


def test_an_update_learns_from_the_rollouts_of_all_worlds_as_from_one():
    shared, alone = learner(), learner()
    together = SharedLearner(shared, 2)
    reports = []
    for world, share in enumerate(together.shares):
        rows, values = live(share.rollout, world)
        assert share.full
        reports.append(share.update(rows, values))
    parts = [Rollout(3, 1, SETTINGS.discount) for _ in range(2)]
    for world, part in enumerate(parts):
        part.advantages(*live(part, world), SETTINGS.gae_lambda)
    alone.rollout = Rollout.joined(parts)
    report = alone.fit()
    assert reports[0] is None
    assert reports[1] == report
    assert report["n_transitions"] == 12
    assert all(np.array_equal(v, alone.brain.state()[k]) for k, v in shared.brain.state().items())


def test_who_does_not_take_part_is_not_waited_for_and_nothing_of_it_is_learnt():
    together = SharedLearner(learner(), 2)
    first, second = together.shares
    live(second.rollout, 7)
    second.renew(active=False)
    report = first.update(*live(first.rollout, 0))
    assert report is not None
    assert report["n_transitions"] == 6
    assert second.rollout.n == 0


def test_a_world_collects_on_while_it_waits_for_the_others():
    together = SharedLearner(learner(), 2)
    first, second = together.shares
    assert first.update(*live(first.rollout, 0)) is None
    live(first.rollout, 1, ticks=1)
    assert second.update(*live(second.rollout, 2))["n_transitions"] == 12
    assert (first.rollout.n, first.rollout.ticks, first.ready) == (3, 1, None)


def test_worlds_that_share_a_learner_can_have_continuous_actions():
    learner = Learner(Brain(3, (2, CONTINUOUS, CONTINUOUS), (4,), seed=1), SETTINGS, seed=5)
    (share,) = SharedLearner(learner, 1).shares
    rows, zeros = np.arange(4), np.zeros(4, np.float32)
    for _ in range(2):
        share.rollout.store(
            rows, np.ones((4, 3), "f4"), np.zeros((4, 1)), zeros, zeros, None, np.ones((4, 2), "f4")
        )
        share.rollout.credit(rows, zeros + np.float32(0.5))
    before = learner.brain.state()
    assert share.update(rows, zeros)["n_transitions"] == 8
    assert not np.array_equal(before["policy.head.bias"], learner.brain.state()["policy.head.bias"])


def test_rollouts_of_different_shapes_are_not_joined():
    with pytest.raises(ValueError, match="dimension"):
        Rollout.joined([Rollout(3, 1, 0.9), Rollout(4, 1, 0.9)])
