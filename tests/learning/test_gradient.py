"""The gradient of a plain network is autograd's, whatever the shapes, and each bit of it the same again."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from ecs_eco.compiled.workers import Workers
from ecs_eco.components import Experience, Policy
from ecs_eco.engine.table import Table
from ecs_eco.learning import PPO, Brain, Individuals
from ecs_eco.learning.continuous import CONTINUOUS
from ecs_eco.learning.gradient import BLOCK, scratch_for, shared_gradient
from ecs_eco.learning.loss import LossSettings
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


def _ours(brain, rollout, index, ppo, scratch=None):
    gradient, terms = np.full(brain.size, np.nan, np.float32), np.zeros(6)
    numbers = CLIP, ppo.clip_value, ppo.entropy_coef, ppo.value_weight, SHIFT, SCALE
    settings, share = LossSettings(*map(np.float32, numbers)), np.float32(1 / len(index))
    log = rollout.observations, rollout.choices, rollout.numbers, rollout.steps
    scratch = scratch_for(brain.layers) if scratch is None else scratch
    network = brain.weights, brain.layers, brain.offsets
    shared_gradient(scratch, *network, log, index, settings, share, gradient, terms)
    return gradient, terms[:5] * len(index)


def _autograd(network, weights, rollout, index, ppo, shift=SHIFT, scale=SCALE):
    """The same by torch in float64, from the weights' own layout."""
    weights = torch.from_numpy(weights.astype(float)).requires_grad_()
    out, at = [], 0
    for tower in network.towers:
        h = torch.from_numpy(rollout.observations[index].astype(float))
        for level, (a, b) in enumerate(tower):
            h = h @ weights[at : at + a * b].view(a, b) + weights[at + a * b : at + (a + 1) * b]
            at += (a + 1) * b
            h = h if level == len(tower) - 1 else torch.tanh(h)
        out.append(h)
    outputs, steps = torch.cat(out, 1), rollout.steps[index]
    old = {
        name: torch.from_numpy(steps[name].astype(float))
        for name in ("log_probability", "value", "advantage")
    }
    batch = old | {
        "choices": torch.from_numpy(rollout.choices[index].astype(np.int64)),
        "numbers": torch.from_numpy(rollout.numbers[index].astype(float)),
    }
    logits, values, bonus = outputs[:, :-1], outputs[:, -1], ppo.entropy_coef
    loss, terms = ppo_loss(logits, values, batch, network.groups, ppo, CLIP, bonus, shift, scale)
    loss.mean().backward()
    return weights.grad.numpy(), np.array([float(term.detach().sum()) for term in terms])


def _require_close(network, gradient, expected):
    parts = zip(network.views(gradient), network.views(expected), strict=True)
    for part, value in parts:
        np.testing.assert_allclose(part, value, rtol=2e-4, atol=2e-5 * np.abs(expected).max())


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
@pytest.mark.parametrize("ppo", [PPO(), PPO(clip_value=0.3, entropy_coef=0.2)], ids=["free", "held"])
def test_the_gradient_is_that_of_autograd(shape, n, trunk, ppo):
    brain = _brain(*shape, trunk)
    rollout = _lived(brain, n + 20)
    index = np.random.default_rng(5).permutation(n + 20)[:n]
    gradient, terms = _ours(brain, rollout, index, ppo)
    expected, sums = _autograd(brain, brain.weights, rollout, index, ppo)
    np.testing.assert_allclose(terms, sums, rtol=2e-4, atol=1e-4)
    _require_close(brain, gradient, expected)


@pytest.mark.parametrize(
    ("shape", "n"),
    [((1, (1,), ()), 1), ((24, (8,), (32,)), 32), ((5, (3, 2), (16, 8)), 71), ((33, (4,), (20, 70, 3)), 3)],
)
@pytest.mark.parametrize("ppo", [PPO(), PPO(clip_value=0.3, entropy_coef=0.2)], ids=["free", "held"])
def test_the_gradient_of_each_individual_is_that_of_autograd(shape, n, ppo):
    """The first moments of Adam are a tenth of its first gradient."""
    ppo = replace(ppo, horizon=n, epochs=1, max_grad_norm=0, discount=0.0, normalise_advantage=False)
    minds, rng = Individuals(*shape, ppo, 0), np.random.default_rng(3)
    table = Table("goat", (Policy, Experience), dims=minds.dims)
    born = rng.normal(0, 0.4, (2, minds.size)).astype(np.float32)
    rows = table.occupy(2, 1, 0, {(Policy, "weights"): born})
    lived = [_lived(_brain(*shape[:2], (1,), "shared"), n) for _ in rows]
    for t in range(n):
        step = np.array([r.steps[t] for r in lived])
        seen, choices = (np.array([getattr(r, of)[t] for r in lived]) for of in ("observations", "choices"))
        minds.store(table[Experience], rows, seen, choices, step["log_probability"], step["value"])
        # without a discount the advantage is what the reward exceeds the value by
        minds.credit(table[Experience], rows, step["advantage"] + step["value"])
    whole = Workers(1).split
    minds.learn(table[Policy], table[Experience], rows, table.uid[rows], np.zeros(2), None, whole)
    for i, row in enumerate(rows.tolist()):
        expected, _ = _autograd(minds, born[i], lived[i], np.arange(n), ppo, 0.0, 1.0)
        _require_close(minds, table[Policy].moment_1[row] / np.float32(0.1), expected)


def test_the_gradient_is_the_same_bits_whatever_the_worker_did_before():
    brain = _brain(24, (3, 3), (64, 64), "shared")
    rollout = _lived(brain, 600)
    first, _ = _ours(brain, rollout, np.arange(300), PPO())
    scratch = scratch_for(brain.layers)
    _ours(brain, rollout, np.arange(200, 600), PPO(), scratch)
    assert np.array_equal(first, _ours(brain, rollout, np.arange(300), PPO(), scratch)[0])
