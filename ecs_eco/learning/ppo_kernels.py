"""PPO's loss and Adam's step as kernels: what torch_ppo.py says in autograd,
for networks whose slopes are known by hand."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ecs_eco.engine.jit import njit
from ecs_eco.learning.arithmetic import exp, fused_njit, softmax
from ecs_eco.learning.continuous import log_likelihood, slopes

# sums may be taken in any order here: always the same one for the same number of weights
summing_njit: Any = partial(njit, fastmath={"contract", "reassoc"})


@fused_njit
def loss_slopes(logits, values, offsets, choices, numbers, steps, index, clip, clip_value, entropy_weight,
                value_weight, shift, scale, share, d_logits, d_values, terms):
    """Write the slope of the loss by each logit [k, n] and value [n], `share` per transition;
    add up the loss's terms. `offsets` are those of the categorical groups; outputs of continuous ones follow.

    Loss = -min(r A, clip(r) A) - entropy_weight H + value_weight (V - R)^2, with r the ratio of the choice's
    probabilities now and then, A the advantage, R = A + V then (Schulman et al. 2017, eq. 7 and 9)."""
    n, n_groups = len(index), len(offsets) - 1
    taken, lived = np.empty((n_groups, n), np.int64), np.empty((3, n), np.float32)
    log_sum_exp, entropy = np.empty((n_groups, n), np.float32), np.empty((n_groups, n), np.float32)
    ratio, log_ratio = np.zeros(n, np.float32), np.empty(n, np.float32)
    # from all over memory: nothing else happens here, so that the next is fetched meanwhile
    for i in range(n):
        step = steps[index[i]]
        lived[0, i], lived[1, i], lived[2, i] = step.log_probability, step.value, step.advantage
        for g in range(n_groups):
            taken[g, i] = offsets[g] + max(0, min(choices[index[i], g], offsets[g + 1] - offsets[g] - 1))
    policy_loss = value_loss = total_entropy = kl = n_clipped = 0.0
    for g in range(n_groups):
        softmax(logits, offsets[g], offsets[g + 1], d_logits, log_sum_exp[g], entropy[g])
        for i in range(n):
            ratio[i] += logits[taken[g, i], i] - log_sum_exp[g, i]
            total_entropy += entropy[g, i]
    if numbers.shape[1]:
        total_entropy += log_likelihood(logits, offsets[-1], numbers, index, ratio)
    for i in range(n):
        log_ratio[i] = ratio[i] - lived[0, i]
        ratio[i] = exp(log_ratio[i])
    d_choice = log_ratio  # the slope by the logit of what was chosen, in the same memory
    for i in range(n):
        gain, r = (lived[2, i] - shift) * scale, ratio[i]
        bound = min(max(r, 1 - clip), 1 + clip)
        kl += r - 1 - log_ratio[i]
        clipped = (r > bound and gain > 0) or (r < bound and gain < 0)
        d_choice[i] = np.float32(0) if clipped else gain * r * share
        policy_loss -= min(r * gain, bound * gain)
        n_clipped += r != bound
        slope, error = _value_slope(values[i], lived[1, i], lived[1, i] + lived[2, i], clip_value)
        d_values[i] = slope * value_weight * share
        value_loss += error
    for g in range(n_groups):
        for k in range(offsets[g], offsets[g + 1]):
            for i in range(n):
                bonus = entropy_weight * share * (logits[k, i] - log_sum_exp[g, i] + entropy[g, i])
                d_logits[k, i] *= d_choice[i] + bonus
        for i in range(n):
            d_logits[taken[g, i], i] -= d_choice[i]
    if numbers.shape[1]:
        slopes(logits, offsets[-1], numbers, index, d_choice, entropy_weight * share, d_logits)
    terms[0], terms[1], terms[2], terms[3], terms[4] = policy_loss, value_loss, total_entropy, kl, n_clipped


@fused_njit
def _value_slope(value, old, target, clip_value):
    """Return slope and size of the squared error; with clip_value,
    that of the worse of the free and the held value."""
    error = value - target
    if 0 < clip_value < abs(value - old):
        held = old + (clip_value if value > old else -clip_value)
        if (held - target) ** 2 > error**2:
            return np.float32(0), (held - target) ** 2
    return 2 * error, error**2


@summing_njit
def adam(weights, gradients, moment_1, moment_2, step, rate, epsilon, max_norm, decay=0.0):
    """Take Adam's step (Kingma and Ba 2015, algorithm 1) down the sum of the gradients' rows;
    return its length.

    Weights decay apart from the gradient (Loshchilov and Hutter 2019). If the gradient is not finite,
    nothing changes.
    """
    gradient = gradients[0]
    for c in range(1, len(gradients)):
        for i in range(len(gradient)):
            gradient[i] += gradients[c, i]
    square = 0.0
    for i in range(len(gradient)):
        square += np.float64(gradient[i]) ** 2
    norm = np.sqrt(square)
    if not np.isfinite(norm):
        return norm
    hold = np.float32(max_norm / (norm + 1e-6) if 0 < max_norm < norm else 1.0)
    scale, root = np.float32(rate / (1 - 0.9**step)), np.float32(1 / np.sqrt(1 - 0.999**step))
    keep = np.float32(1 - rate * decay)
    for i in range(len(gradient)):
        slope = gradient[i] * hold
        moment_1[i] += np.float32(0.1) * (slope - moment_1[i])
        moment_2[i] += np.float32(0.001) * (slope * slope - moment_2[i])
        weights[i] = weights[i] * keep - scale * moment_1[i] / (
            np.sqrt(moment_2[i]) * root + np.float32(epsilon)
        )
    return norm
