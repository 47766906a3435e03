"""PPO by autograd: the same as PPO by hand where both can, and able to remember."""

import hashlib

import numpy as np
import pytest
import torch

from ecs_eco.learning import CONTINUOUS, MLP, PPO, Brain, Learner, ModuleBrain, TorchLearner, choose
from ecs_eco.learning.continuous import draw_numbers
from tests.learning.networks import Gru, Lstm, Plain

GROUPS = (3, 2)
KINDS = [GROUPS, (CONTINUOUS,), (3, CONTINUOUS, CONTINUOUS)]


def live(learner, n=60, ticks=4, seed=0):
    """Store ticks of n animals with random observations; some die, some are cut.

    Returns the living and their values.
    """
    rng, brain, rows = np.random.default_rng(seed), learner.brain, np.arange(n)
    memory = np.zeros((n, brain.memory), np.float32)
    for _ in range(ticks):
        observations = rng.standard_normal((n, brain.n_observations), dtype=np.float32)
        if brain.memory:
            logits, values, later = brain.recall(observations, memory)
        else:
            (logits, values), later = brain.forward(observations), memory
        choice, log_probability = np.empty((n, len(brain.offsets) - 1), np.int16), np.empty(n, np.float32)
        choose(logits, brain.offsets, rng.random(choice.shape, dtype=np.float32), choice, log_probability)
        numbers = np.empty((n, brain.n_numbers), np.float32)
        draw_numbers(
            logits[:, brain.offsets[-1] :],
            rng.random((n, 2 * brain.n_numbers), dtype=np.float32),
            numbers,
            log_probability,
        )
        learner.rollout.store(rows, observations, choice, log_probability, values, memory, numbers)
        rewards = rng.standard_normal(n, dtype=np.float32)
        learner.rollout.end(rows[:5], rewards[:5])
        learner.rollout.cut(rows[5:9], rewards[5:9], values[5:9])
        learner.rollout.credit(rows[9:], rewards[9:])
        memory = later.copy()
        memory[:9] = 0
    return rows, np.zeros(n, np.float32)


def moved(brain):
    """Give a brain weights off its first ones, so that ratios leave the clip on both sides."""
    rng = np.random.default_rng(8)
    brain.load(
        {name: a + rng.normal(0, 0.2, a.shape).astype(np.float32) for name, a in brain.state().items()}
    )


def of_mlp(brain):
    """The same network, for autograd."""
    module = MLP(brain.n_observations, brain.groups, brain.hidden, brain.trunk)
    twin = ModuleBrain(module, brain.n_observations, brain.groups)
    twin.load(brain.state())
    return twin


@pytest.mark.parametrize("groups", KINDS)
@pytest.mark.parametrize("trunk", ["shared", "separate"])
@pytest.mark.parametrize(
    "ppo",
    [
        PPO(minibatch_size=100),
        PPO(clip_value=0.3, max_grad_norm=0, weight_decay=0.1, anneal=1000, entropy_coef=0.05),
    ],
)
def test_autograd_and_the_kernels_learn_the_same(trunk, ppo, groups):
    ours = Learner(Brain(5, groups, (16, 8), 3, trunk), ppo, seed=7)
    theirs = TorchLearner(of_mlp(ours.brain), ppo, seed=7)
    for seed in range(3):
        live(ours, n=200, seed=seed)
        rows, values = live(theirs, n=200, seed=seed)
        a, b = ours.update(rows, values), theirs.update(rows, values)
        assert set(a) == set(b)
        for word in a:
            assert a[word] == pytest.approx(b[word], rel=2e-3, abs=2e-4), word
    for name, weight in ours.brain.state().items():
        np.testing.assert_allclose(weight, theirs.brain.state()[name], rtol=2e-3, atol=1e-4, err_msg=name)


@pytest.mark.parametrize("groups", KINDS)
@pytest.mark.parametrize("trunk", ["shared", "separate"])
@pytest.mark.parametrize("clip_value", [0.0, 0.3])
def test_the_gradients_of_both_are_equal(trunk, clip_value, groups):
    ppo = PPO(clip_value=clip_value, entropy_coef=0.05, max_grad_norm=0)
    ours = Learner(Brain(5, groups, (16, 8), 3, trunk), ppo, seed=7)
    theirs = TorchLearner(of_mlp(ours.brain), ppo, seed=7)
    gradients = {}
    for learner in (ours, theirs):
        rows, values = live(learner, n=600)
        moved(learner.brain)
        learner.rollout.advantages(rows, values, ppo.gae_lambda)
        learner._step(np.arange(learner.rollout.n), 0.0, ppo.clip, 0.1, 1.5)
    gradients = ours.brain.named_views(ours._gradient[0])
    for name, parameter in theirs.brain.module.named_parameters():
        size = np.abs(gradients[name]).max()
        np.testing.assert_allclose(
            parameter.grad.numpy(), gradients[name], rtol=1e-3, atol=2e-5 * size, err_msg=name
        )


@pytest.mark.parametrize("network", [Plain, Gru])
def test_an_update_gives_the_same_bits_for_any_number_of_workers_and_torch_threads(network):
    digests = set()
    before = torch.get_num_threads()
    for workers, threads in ((1, 1), (2, 2), (3, 1)):
        torch.set_num_threads(threads)
        torch.manual_seed(1)
        learner = TorchLearner(
            ModuleBrain(network(5, GROUPS), 5, GROUPS),
            PPO(minibatch_size=7000, epochs=2, unroll=2),
            3,
            workers,
        )
        for seed in range(2):
            learner.update(*live(learner, n=3000, seed=seed))
        digests.add(hashlib.sha256(b"".join(a.tobytes() for a in learner.state().values())).hexdigest())
    torch.set_num_threads(before)
    assert len(digests) == 1


@pytest.mark.parametrize("network", [Plain, Gru, Lstm])
def test_a_learner_goes_on_from_its_state(network):
    def learner():
        torch.manual_seed(1)
        return TorchLearner(ModuleBrain(network(5, GROUPS), 5, GROUPS), PPO(minibatch_size=100), 3)

    whole = learner()
    whole.update(*live(whole, seed=1))
    live(whole, seed=2)
    half = learner()
    torch.manual_seed(9)
    half.load(whole.state())
    for one in (whole, half):
        one.update(np.arange(60), np.zeros(60, np.float32))
    for (name, a), b in zip(whole.state().items(), half.state().values(), strict=True):
        assert np.array_equal(a, b), name


def test_stretches_of_a_life_are_cut_at_births_at_deaths_and_at_the_length_of_unrolling():
    learner = TorchLearner(ModuleBrain(Gru(5, GROUPS), 5, GROUPS), PPO(), 3)
    live(learner, n=20, ticks=5)
    order, begins = learner.rollout.stretches(2)
    row = learner.rollout.steps["row"][order]
    assert row.tolist() == np.repeat(np.arange(20), 5).tolist()
    lengths = np.diff(begins)
    assert lengths[:45].tolist() == [1] * 45  # nine rows that end in each tick
    assert lengths[45:].tolist() == [2, 2, 1] * 11


def test_a_replay_of_a_memory_with_unchanged_weights_gives_what_was_decided():
    learner = TorchLearner(ModuleBrain(Gru(5, GROUPS), 5, GROUPS), PPO(unroll=3), 3)
    live(learner, n=30, ticks=7)
    rollout = learner.rollout
    learner._lives, learner._stretches = rollout.stretches(3)
    _, values, index = learner._replay(np.random.default_rng(1).permutation(len(learner._stretches) - 1))
    assert sorted(index) == list(range(rollout.n))
    np.testing.assert_allclose(values.detach().numpy(), rollout.steps["value"][index], rtol=1e-4, atol=1e-5)


def test_gradients_go_back_in_time_as_far_as_a_stretch_and_no_farther():
    """The last decision of each life alone is rewarded; what was seen a tick before matters
    to it through the memory."""
    slopes = []
    for unroll in (1, 2):
        torch.manual_seed(4)
        learner = TorchLearner(ModuleBrain(Gru(1, (2,)), 1, (2,)), PPO(unroll=unroll), 3)
        live(learner, n=12, ticks=2)
        learner._lives, learner._stretches = learner.rollout.stretches(unroll)
        seen = learner.brain.tensor(learner.rollout.observations[24 - 1 : 24])
        assert seen.shape == (1, 1)
        run, given = learner.brain.run, []

        def watched(observations, state, run=run, given=given):
            given.append(state)
            if state.requires_grad:
                state.retain_grad()
            return run(observations, state)

        learner.brain.run = watched
        _, values, _ = learner._replay(np.arange(len(learner._stretches) - 1))
        values.sum().backward()
        slopes.append([state.grad is not None for state in given])
    assert slopes == [[False], [False, True]]


def test_a_gradient_that_is_not_finite_changes_nothing_and_is_named():
    learner = TorchLearner(ModuleBrain(Plain(5, GROUPS), 5, GROUPS), PPO(), 3)
    rows, values = live(learner)
    learner.rollout.credit(rows[20:21], np.array([np.nan], np.float32))
    before = learner.brain.state()
    with pytest.raises(FloatingPointError, match="update 0: the gradient is nan"):
        learner.update(rows, values)
    assert all(np.array_equal(a, before[name]) for name, a in learner.brain.state().items())


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device here")
@pytest.mark.parametrize("network", [Plain, Gru])
def test_a_graphics_processor_thinks_and_learns_as_the_processor_does_but_for_rounding(network):
    states = []
    for device in ("cpu", "cuda"):
        torch.manual_seed(1)
        learner = TorchLearner(ModuleBrain(network(5, GROUPS), 5, GROUPS, device), PPO(unroll=2), 3)
        learner.update(*live(learner))
        states.append(learner.brain.state())
    for name, weights in states[0].items():
        np.testing.assert_allclose(states[1][name], weights, rtol=1e-2, atol=1e-3, err_msg=name)
