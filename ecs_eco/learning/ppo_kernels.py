"""PPO's loss and Adam's step as kernels, for plain networks: what torch_ppo.py does in autograd."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.learning.arithmetic import exp, fused_njit, log, lone_fused_njit
from ecs_eco.learning.continuous import log_likelihood, slopes

# sums may be taken in any order here: always the same one for the same number of weights
summing_njit: Any = partial(njit, fastmath={"contract", "reassoc"})


@fused_njit
def loss_slopes(
    logits,
    values,
    offsets,
    choices,
    numbers,
    steps,
    index,
    clip,
    clip_value,
    entropy_weight,
    value_weight,
    shift,
    scale,
    share,
    d_logits,
    d_values,
    terms,
):
    """Write the slope of the loss by each logit [k, n] and value [n], `share` per transition;
    add up the loss's terms. `offsets` are those of the categorical groups; outputs of continuous ones follow.

    Loss = -min(r A, clip(r) A) - entropy_weight H + value_weight (V - R)^2, with r the ratio of the choice's
    probabilities now and then, A the advantage, R = A + V then (Schulman et al. 2017, eq. 7 and 9)."""
    n, n_groups = len(index), len(offsets) - 1
    then, kept, sums = (
        np.empty((3, n), np.float32),
        np.empty((3 * n_groups, n), np.float32),
        np.zeros((7, n), np.float32),
    )
    taken, levels, shares = kept[:n_groups], kept[n_groups : 2 * n_groups], kept[2 * n_groups :]
    _fetch(steps, choices, offsets, index, then, taken)
    for g in range(n_groups):
        _softmax(
            logits,
            d_logits,
            offsets[g],
            offsets[g + 1],
            taken[g],
            levels[g],
            shares[g],
            sums[6],
            sums[2],
            sums[5],
        )
    entropy = 0.0
    if numbers.shape[1]:
        entropy = log_likelihood(logits, offsets[-1], numbers, index, sums[5])
    _weigh(then, shift, scale, share, clip, sums[5], sums[0], sums[3], sums[4], sums[6])
    _value_slopes(values, then, clip_value, value_weight * share, d_values, sums[1])
    d_choice = sums[6]
    for g in range(n_groups):
        _turn(
            logits,
            d_logits,
            offsets[g],
            offsets[g + 1],
            taken[g],
            levels[g],
            shares[g],
            d_choice,
            entropy_weight * share,
        )
    if numbers.shape[1]:
        slopes(logits, offsets[-1], numbers, index, d_choice, entropy_weight * share, d_logits)
    for i in range(5):
        terms[i] = _sum(sums[i])
    terms[2] += entropy


@fused_njit
def _fetch(steps, choices, offsets, index, then, taken):
    """Gather log-probability, value and advantage of the steps at `index` into f32[3, n], and which option of
    each group was taken into f32[G, n].

    They come from all over memory: nothing else happens here, so that the next is fetched meanwhile.
    """
    for i in range(len(index)):
        step = steps[index[i]]
        then[0, i], then[1, i], then[2, i] = step.log_probability, step.value, step.advantage
        for g in range(taken.shape[0]):
            taken[g, i] = max(0, min(choices[index[i], g], offsets[g + 1] - offsets[g] - 1))


@lone_fused_njit
def _softmax(logits, e, low, high, taken, level, part, top, entropies, log_probability):
    """Write e[low:high, n] = exp(logits - their largest), and what makes it probabilities: `part` f32[n]; add
    the entropy H [nat] and the log-probability of what was taken to f32[n]; `level` is H - log(sum(exp)).

    `top` f32[n] is scratch.
    """
    zero, one = np.float32(0), np.float32(1)
    n = len(taken)
    for i in range(n):
        top[i] = level[i] = logits[low, i]
        part[i] = zero
    for k in range(low + 1, high):
        number = np.float32(k - low)
        for i in range(n):
            a, b, chosen = logits[k, i], top[i], level[i]
            top[i] = a if a > b else b
            level[i] = a if taken[i] == number else chosen
    for i in range(n):
        log_probability[i] += level[i] - top[i]
        level[i] = zero
    for k in range(low, high):
        for i in range(n):
            less = logits[k, i] - top[i]
            p = exp(less)
            e[k, i] = p
            part[i] += p
            level[i] -= p * less
    for i in range(n):
        size, share = log(part[i]), one / part[i]
        entropy = level[i] * share + size
        log_probability[i] -= size
        entropies[i] += entropy
        level[i] = entropy - (top[i] + size)
        part[i] = share


@lone_fused_njit
def _weigh(then, shift, scale, share, clip, log_probability, losses, kl, clipped, d_choice):
    """Write the slope of the clipped loss by the log-probability of what was taken, d_choice f32[n], and
    losses, the divergence r - 1 - log(r) and whether r is clipped (0 or 1)."""
    zero, one = np.float32(0), np.float32(1)
    low, high = one - clip, one + clip
    for i in range(len(losses)):
        gain = (then[2, i] - shift) * scale
        log_ratio = log_probability[i] - then[0, i]
        r = exp(log_ratio)
        least = r if r > low else low
        bound = least if least < high else high
        beyond = r - bound
        kl[i] = r - one - log_ratio
        clipped[i] = zero if beyond == zero else one
        free, held = r * gain, bound * gain
        losses[i] = -free if free < held else -held
        d_choice[i] = zero if beyond * gain > zero else free * share


@lone_fused_njit
def _value_slopes(values, then, clip_value, weight, d_values, errors):
    """Write the squared errors of the values f32[n] and `weight` times their slopes; where clip_value > 0,
    those of the worse of the free and the held value."""
    zero, two = np.float32(0), np.float32(2)
    for i in range(len(errors)):
        error = values[i] - (then[1, i] + then[2, i])
        errors[i] = error * error
        d_values[i] = two * error * weight
    if clip_value <= zero:
        return
    for i in range(len(errors)):
        step = values[i] - then[1, i]
        least = step if step > -clip_value else -clip_value
        bound = least if least < clip_value else clip_value
        error, free, slope = bound - then[2, i], errors[i], d_values[i]
        held = free if bound == step else error * error
        errors[i] = held if held > free else free
        d_values[i] = zero if held > free else slope


@lone_fused_njit
def _turn(logits, d_logits, low, high, taken, level, part, d_choice, bonus):
    """Turn d_logits[low:high, n], which are exponentials of `_softmax`, into slopes: those of the choice,
    and `bonus` per nat of entropy."""
    zero = np.float32(0)
    for k in range(low, high):
        number = np.float32(k - low)
        for i in range(len(taken)):
            d = d_choice[i]
            p = d_logits[k, i] * part[i]
            own = d if taken[i] == number else zero
            d_logits[k, i] = p * (d + bonus * (logits[k, i] + level[i])) - own


@summing_njit
def _sum(x):
    total = 0.0
    for i in range(len(x)):
        total += x[i]
    return total


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
