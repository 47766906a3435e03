import hashlib

import numpy as np
import pytest
import torch

from ecs_eco.learning import PPO, Brain, Learner, choose
from ecs_eco.learning.adam import adam

GROUPS = (3, 2)


def _fill(learner, n=60, ticks=4, seed=0, reward=None):
    """Store ticks of n animals with random observations; some die, some are cut."""
    rng, brain, rows = np.random.default_rng(seed), learner.brain, np.arange(n)
    for _ in range(ticks):
        observations = rng.standard_normal((n, brain.n_observations), dtype=np.float32)
        logits, values = brain.forward(observations)
        choice, log_probability = np.empty((n, len(brain.groups)), np.int16), np.empty(n, np.float32)
        choose(logits, brain.offsets, rng.random(choice.shape, dtype=np.float32), choice, log_probability)
        learner.rollout.store(rows, observations, choice, log_probability, values)
        rewards = rng.standard_normal(n, dtype=np.float32) if reward is None else reward(observations, choice)
        learner.rollout.end(rows[:5], rewards[:5])
        learner.rollout.cut(rows[5:9], rewards[5:9], values[5:9])
        learner.rollout.credit(rows[9:], rewards[9:])
    return rows, np.zeros(n, np.float32)


def _learner(ppo=None, seed=3, workers=1, trunk="shared", hidden=(16, 8), n_observations=5):
    return Learner(Brain(n_observations, GROUPS, hidden, seed, trunk), ppo or PPO(), seed, workers)


def _hash(learner):
    return hashlib.sha256(b"".join(array.tobytes() for array in learner.state().values())).hexdigest()


def _loss(weights, brain, rollout, ppo, shift, scale):
    """The loss by torch, as the papers write it."""
    x = torch.from_numpy(rollout.observations.copy())

    def tower(name):
        h = x
        for level in range(len(brain.hidden)):
            h = torch.tanh(
                torch.nn.functional.linear(
                    h, weights[f"{name}.{level}.weight"], weights[f"{name}.{level}.bias"]
                )
            )
        return h

    shared = brain.trunk == "shared"
    hidden = tower("trunk" if shared else "policy"), tower("trunk" if shared else "value")
    logits = torch.nn.functional.linear(hidden[0], weights["policy.head.weight"], weights["policy.head.bias"])
    value = torch.nn.functional.linear(hidden[1], weights["value.head.weight"], weights["value.head.bias"])[
        :, 0
    ]
    now, entropy = 0, 0
    for g, part in enumerate(torch.split(logits, GROUPS, dim=1)):
        distribution = torch.distributions.Categorical(logits=part)
        now = now + distribution.log_prob(torch.from_numpy(rollout.choices[:, g].astype(np.int64)))
        entropy = entropy + distribution.entropy()
    old, then, gain = (
        torch.from_numpy(rollout.steps[n].copy()) for n in ("value", "log_probability", "advantage")
    )
    target, advantage = gain + old, (gain - shift) * scale
    ratio = torch.exp(now - then)
    policy = -torch.minimum(ratio * advantage, ratio.clamp(1 - ppo.clip, 1 + ppo.clip) * advantage).mean()
    error = (value - target) ** 2
    if ppo.clip_value:
        error = torch.maximum(
            error, (old + (value - old).clamp(-ppo.clip_value, ppo.clip_value) - target) ** 2
        )
    return (
        policy - ppo.entropy_coef * entropy.mean() + ppo.value_weight * error.mean(),
        policy,
        error.mean(),
        entropy.mean(),
    )


@pytest.mark.parametrize("trunk", ["shared", "separate"])
@pytest.mark.parametrize("clip_value", [0.0, 0.3])
def test_the_gradient_by_hand_agrees_with_autograd(trunk, clip_value):
    ppo = PPO(clip_value=clip_value, entropy_coef=0.05, max_grad_norm=0)
    learner = _learner(ppo, trunk=trunk)
    brain, rollout = learner.brain, learner.rollout
    rows, values = _fill(learner, n=600)
    rng = np.random.default_rng(8)  # move away, so that ratios leave the clip on both sides
    moved = {name: a + rng.normal(0, 0.2, a.shape).astype(np.float32) for name, a in brain.state().items()}
    brain.load(moved)
    rollout.advantages(rows, values, ppo.gae_lambda)
    terms = learner._step(np.arange(rollout.n), 0.0, ppo.clip, 0.1, 1.5)
    weights = {name: torch.from_numpy(a).requires_grad_() for name, a in moved.items()}
    loss, policy, error, entropy = _loss(weights, brain, rollout, ppo, 0.1, 1.5)
    loss.backward()
    mine = brain.named_views(learner._gradient[0])
    for name, weight in weights.items():
        size = weight.grad.abs().max().item()
        np.testing.assert_allclose(mine[name], weight.grad.numpy(), rtol=1e-4, atol=1e-5 * size, err_msg=name)
    np.testing.assert_allclose(terms[:3], [policy.item(), error.item(), entropy.item()], rtol=1e-4)
    assert 0.2 < terms[4] < 0.9  # of the ratios were clipped
    np.testing.assert_allclose(
        terms[5], torch.cat([w.grad.flatten() for w in weights.values()]).norm().item(), rtol=1e-4
    )


@pytest.mark.parametrize("max_norm", [0.0, 0.5])
def test_adam_agrees_with_torch(max_norm):
    rng = np.random.default_rng(0)
    weights = rng.standard_normal(100).astype(np.float32)
    theirs = torch.nn.Parameter(torch.from_numpy(weights.copy()))
    optimiser = torch.optim.Adam([theirs], lr=0.01, eps=1e-5)
    moment_1, moment_2 = np.zeros(100, np.float32), np.zeros(100, np.float32)
    for step in range(1, 6):
        gradients = rng.standard_normal((3, 100)).astype(np.float32)
        theirs.grad = torch.from_numpy(gradients.sum(axis=0))
        if max_norm:
            torch.nn.utils.clip_grad_norm_([theirs], max_norm)
        optimiser.step()
        adam(weights, gradients, moment_1, moment_2, step, (0.01, 1e-5, max_norm, 0.0))
    np.testing.assert_allclose(weights, theirs.detach().numpy(), rtol=1e-5, atol=1e-6)


def test_an_update_gives_the_same_bits_for_any_number_of_workers():
    hashes = set()
    for workers in (1, 2, 3):
        learner = _learner(PPO(minibatch_size=7000, epochs=2), workers=workers)
        for seed in range(2):
            learner.update(*_fill(learner, n=3000, ticks=4, seed=seed))
        hashes.add(_hash(learner))
    assert len(hashes) == 1


def test_an_update_depends_on_the_seed():
    hashes = set()
    for seed in (1, 2):
        learner = Learner(Brain(5, GROUPS, (16, 8), seed=3), PPO(minibatch_size=50), seed)
        learner.update(*_fill(learner))
        hashes.add(_hash(learner))
    assert len(hashes) == 2


def test_a_loaded_learner_goes_on_as_the_saved_one():
    first = _learner(PPO(minibatch_size=50))
    first.update(*_fill(first))
    _fill(first, seed=1)
    second = _learner(PPO(minibatch_size=50), seed=3)
    second.brain._draw(77)
    second.load(first.state())
    assert _hash(first) == _hash(second)
    for learner in (first, second):
        learner.update(*_fill(learner, seed=2))
    assert _hash(first) == _hash(second)
    assert first.updates == second.updates == 2


def test_results_do_not_depend_on_which_rows_the_animals_have():
    reports, weights = [], []
    for shuffle in (None, 1):
        learner = _learner(PPO(minibatch_size=50))
        rows = np.arange(60) if shuffle is None else np.random.default_rng(shuffle).permutation(200)[:60]
        rng = np.random.default_rng(4)
        for _ in range(5):
            observations = rng.standard_normal((60, 5), dtype=np.float32)
            values = rng.standard_normal(60, dtype=np.float32)
            learner.rollout.store(
                rows, observations, rng.integers(0, 2, (60, 2)), np.full(60, -1.5, np.float32), values
            )
            learner.rollout.end(rows[:7], values[:7])
            learner.rollout.credit(rows, values)
        reports.append(learner.update(rows, np.ones(60, np.float32)))
        weights.append(learner.brain.weights.copy())
    assert reports[0] == reports[1]
    assert np.array_equal(*weights)


def test_every_transition_is_used_once_an_epoch(monkeypatch):
    learner, used = _learner(PPO(minibatch_size=100, epochs=3)), []
    step = learner._step
    monkeypatch.setattr(
        learner, "_step", lambda index, *rest: (used.append(index.copy()), step(index, *rest))[1]
    )
    report = learner.update(*_fill(learner, n=83, ticks=4))
    assert report["n_transitions"] == 332
    assert [len(index) for index in used] == [83] * 12
    for epoch in range(3):
        assert sorted(np.concatenate(used[4 * epoch : 4 * epoch + 4])) == list(range(332))
    assert not np.array_equal(used[0], used[4])


def test_learning_rate_and_clip_fall_linearly_to_zero():
    learner, rates = _learner(PPO(horizon=4, anneal=16, learning_rate=0.01)), []
    for seed in range(6):
        assert not learner.full
        batch = _fill(learner, ticks=4, seed=seed)
        assert learner.full
        before = learner.brain.weights.copy()
        rates.append(learner.update(*batch)["learning_rate"])
        assert np.array_equal(before, learner.brain.weights) == (rates[-1] == 0)
    np.testing.assert_allclose(rates, [0.01, 0.0075, 0.005, 0.0025, 0, 0], atol=1e-12)


def test_an_extinct_population_learns_nothing_and_breaks_nothing():
    learner, nobody = _learner(), np.empty(0, np.int64)
    before = learner.brain.weights.copy()
    learner.rollout.store(nobody, np.empty((0, 5)), np.empty((0, 2)), np.empty(0), np.empty(0))
    assert learner.update(nobody, np.empty(0, np.float32))["n_transitions"] == 0
    assert np.array_equal(before, learner.brain.weights)


def test_a_gradient_that_is_not_finite_is_refused_before_it_does_harm():
    learner = _learner()
    rows, values = _fill(learner)
    learner.rollout.credit(rows, np.full(60, np.inf, np.float32))
    before = learner.brain.weights.copy()
    with pytest.raises(FloatingPointError, match="update 0"), np.errstate(invalid="ignore"):
        learner.update(rows, values)
    assert np.array_equal(before, learner.brain.weights)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_contextual_bandit_is_learnt(seed):
    """Two groups; the right choice of each follows from one observation.

    Chance earns 1/3 + 1/2, perfection 2.
    """

    def reward(observations, choice):
        right = (observations[:, 0] > 0) * 2, observations[:, 1] > 0
        return sum((choice[:, g] == right[g]).astype(np.float32) for g in range(2))

    learner = _learner(PPO(horizon=4, minibatch_size=500, learning_rate=3e-3, discount=0.0), seed=seed)
    rewards = [learner.update(*_fill(learner, 500, 4, 1000 * seed + k, reward))["reward"] for k in range(30)]
    assert rewards[0] < 1.0
    assert rewards[-1] > 1.75


def test_the_value_learns_what_follows():
    learner = _learner(PPO(horizon=4, minibatch_size=500, learning_rate=3e-3, discount=0.0))
    explained = [
        learner.update(*_fill(learner, 500, 4, k, lambda observations, choice: observations[:, 2] * 3))[
            "explained_variance"
        ]
        for k in range(30)
    ]
    assert explained[0] < 0.5
    assert explained[-1] > 0.9
