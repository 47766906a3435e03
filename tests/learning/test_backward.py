"""The gradient of a plain network is autograd's, whatever the shapes, and each bit of it the same again."""

import numpy as np
import pytest
import torch

from ecs_eco.learning import PPO, Brain
from ecs_eco.learning.backward import BLOCK, Passes
from ecs_eco.learning.continuous import CONTINUOUS
from ecs_eco.learning.rollout import Rollout
from ecs_eco.learning.torch_ppo import ppo_loss

CLIP, SHIFT, SCALE = 0.2, 0.1, 0.7


def _brain(n_observations, groups, hidden, trunk):
    brain, rng = Brain(n_observations, groups, hidden, trunk=trunk), np.random.default_rng(3)
    brain.load({name: rng.normal(0, 0.4, w.shape).astype(np.float32) for name, w in brain.state().items()})
    return brain


def _lived(brain, n):
    """A rollout of n transitions that a policy a little other than the brain's went through."""
    rng, rollout = (
        np.random.default_rng(4),
        Rollout(brain.n_observations, len(brain.offsets) - 1, 0.9, n_numbers=brain.n_numbers),
    )
    choices = np.column_stack([rng.integers(0, size, n) for size in np.diff(brain.offsets)])
    seen, numbers = (
        rng.normal(size=(n, k)).astype(np.float32) for k in (brain.n_observations, brain.n_numbers)
    )
    rollout.store(np.arange(n), seen, choices, rng.normal(-2, 0.3, n), rng.normal(size=n), numbers=numbers)
    rollout.steps["advantage"] = rng.normal(size=n)
    return rollout


def _ours(brain, rollout, index, ppo):
    passes, gradient, terms = Passes(brain), np.full(brain.size, np.nan, np.float32), np.zeros(6)
    passes.begin(1)
    settings = np.array(
        [CLIP, ppo.clip_value, ppo.entropy, ppo.value_weight, SHIFT, SCALE, 1 / len(index)], np.float32
    )
    log = rollout.observations, rollout.choices, rollout.numbers, rollout.steps
    passes.gradient(0, index, log, settings, gradient, terms)
    return gradient, terms[:5]


def _autograd(brain, rollout, index, ppo):
    """The same by torch in float64, from the weights' own places."""
    weights = torch.from_numpy(brain.weights.astype(float)).requires_grad_()
    out, at = [], 0
    for tower in brain.towers:
        h = torch.from_numpy(rollout.observations[index].astype(float))
        for level, (a, b) in enumerate(tower):
            head = level == len(tower) - 1
            matrix = weights[at : at + a * b].view((b, a) if head else (a, b))
            at += -(-a * b // 16) * 16
            h = h @ (matrix.T if head else matrix) + weights[at : at + b]
            at += -(-b // 16) * 16
            h = h if head else torch.tanh(h)
        out.append(h)
    outputs, steps = torch.cat(out, 1), rollout.steps[index]
    old = {
        name: torch.from_numpy(steps[name].astype(float))
        for name in ("log_probability", "value", "advantage")
    }
    loss, terms = ppo_loss(
        outputs[:, :-1],
        outputs[:, -1],
        torch.from_numpy(rollout.choices[index].astype(np.int64)),
        torch.from_numpy(rollout.numbers[index].astype(float)),
        brain.groups,
        old,
        ppo,
        CLIP,
        ppo.entropy,
        SHIFT,
        SCALE,
    )
    loss.mean().backward()
    return weights.grad.numpy(), np.array([float(term.detach().sum()) for term in terms])


@pytest.mark.parametrize("trunk", ["shared", "separate"])
@pytest.mark.parametrize(
    ("shape", "n"),
    [
        ((1, (1,), (1,)), 1),
        ((24, (3, 3, 2), (64, 64)), BLOCK),
        ((5, (3, 2), (16, 8)), 2 * BLOCK + 7),
        ((33, (4,), (20, 70, 3)), 3),
        ((7, (2, 17), (48,)), BLOCK + 1),
        ((6, (3, CONTINUOUS, CONTINUOUS), (12, 12)), 50),
    ],
)
@pytest.mark.parametrize("ppo", [PPO(), PPO(clip_value=0.3, entropy=0.2)], ids=["free", "held"])
def test_the_gradient_is_that_of_autograd(shape, n, trunk, ppo):
    brain = _brain(*shape, trunk)
    rollout = _lived(brain, n + 20)
    index = np.random.default_rng(5).permutation(n + 20)[:n]
    gradient, terms = _ours(brain, rollout, index, ppo)
    expected, sums = _autograd(brain, rollout, index, ppo)
    np.testing.assert_allclose(terms, sums, rtol=2e-4, atol=1e-4)
    for ours, right in zip(brain.views(gradient), brain.views(expected.astype(np.float32)), strict=True):
        for layer, wanted in zip(ours, right, strict=True):
            for part, value in zip(layer, wanted, strict=True):
                np.testing.assert_allclose(part, value, rtol=2e-4, atol=2e-5 * np.abs(expected).max())


def test_the_gradient_is_the_same_bits_whatever_the_worker_did_before():
    brain = _brain(24, (3, 3), (64, 64), "shared")
    rollout = _lived(brain, 600)
    index, other = np.arange(300), np.arange(200, 600)
    first, _ = _ours(brain, rollout, index, PPO())
    passes, again, terms = Passes(brain), np.zeros(brain.size, np.float32), np.zeros(6)
    passes.begin(2)
    log = rollout.observations, rollout.choices, rollout.numbers, rollout.steps
    for worker in (0, 1, 0):
        for chosen in (other, index):
            settings = np.array(
                [CLIP, PPO().clip_value, PPO().entropy, PPO().value_weight, SHIFT, SCALE, 1 / len(chosen)],
                np.float32,
            )
            passes.gradient(worker, chosen, log, settings, again, terms)
        assert np.array_equal(first[brain.weights != 0], again[brain.weights != 0])
