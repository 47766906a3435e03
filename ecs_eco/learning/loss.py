"""PPO's loss as a kernel: its terms, and its gradient with respect to a plain network's outputs.

Loss = -min(r A, clip(r) A) - entropy_weight H + value_weight (V - R)^2, where r is the ratio of the choice's
new and old probabilities, A the advantage, and R = A + the old value (Schulman et al. 2017, eq. 7 and 9).
`torch_ppo.ppo_loss` computes the same loss with autograd.

Transitions are transposed so that all loops run over a block of them and can be vectorized. These loops use
only float32 and take their length from arrays, because the compiler unrolls short loops of known length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.vectors import LANES, load, store, where_less
from ecs_eco.learning.arithmetic import exp, fused_njit, log, lone_fused_njit
from ecs_eco.learning.continuous import HALF_LOG_2_PI, LEAST, MOST
from ecs_eco.learning.layers import layer_of
from ecs_eco.learning.tiles import round_up

BLOCK = 32  # transitions
LOSS_TERMS = ("policy_loss", "value_loss", "entropy", "approx_kl", "clip_fraction")
# start of the sums of each loss term in `LossScratch.terms`, after the policy loss
VALUE, ENTROPY, KL, CLIPPED = BLOCK, 2 * BLOCK, 3 * BLOCK, 4 * BLOCK


class LossSettings(NamedTuple):
    """The parameters of the loss. Advantages are normalized to (A - shift) * scale."""

    clip: np.float32
    clip_value: np.float32
    entropy: np.float32
    value_weight: np.float32
    shift: np.float32
    scale: np.float32


class LossScratch(NamedTuple):
    """The arrays that `gather_transitions` and `output_gradient` use for n transitions, G choices and K
    numbers."""

    weight: np.ndarray  # f32[n]: weight of each transition in the mean
    log_probability: np.ndarray  # f32[n], at decision time
    value: np.ndarray  # f32[n], at decision time
    advantage: np.ndarray  # f32[n]
    choices: np.ndarray  # f32[G, n]
    numbers: np.ndarray  # f32[K, n]
    outputs: np.ndarray  # f32[outputs, BLOCK], the value last; then their gradient
    exponentials: np.ndarray  # f32[outputs, BLOCK], of logits minus the largest in their group
    mean_logit: np.ndarray  # f32[G, BLOCK]
    inverse_sum: np.ndarray  # f32[G, BLOCK], of the exponentials
    log_ratio: np.ndarray  # f32[BLOCK]; then the gradient with respect to the log-probability
    terms: np.ndarray  # f32[5 * BLOCK]: sums of the loss's terms


@fused_njit
def allocate_scratch(offsets, n_numbers, rows):
    """Return the scratch for a network's loss over up to `rows` transitions."""
    n, n_groups, n_outputs = round_up(rows, BLOCK), len(offsets) - 1, offsets[-1] + 2 * n_numbers + 1
    return LossScratch(
        np.zeros(n, np.float32),
        np.zeros(n, np.float32),
        np.zeros(n, np.float32),
        np.zeros(n, np.float32),
        np.zeros((n_groups, n), np.float32),
        np.zeros((n_numbers, n), np.float32),
        np.zeros((n_outputs, BLOCK), np.float32),
        np.zeros((n_outputs, BLOCK), np.float32),
        np.zeros((n_groups, BLOCK), np.float32),
        np.zeros((n_groups, BLOCK), np.float32),
        np.zeros(BLOCK, np.float32),
        np.zeros(5 * BLOCK, np.float32),
    )


@lone_fused_njit
def gather_transitions(scratch, steps, choices, numbers, offsets, chosen, weight):
    """Gather the chosen transitions i64[n] of a rollout: STEP[t], int[t, G], f32[t, K]."""
    n = len(chosen)
    for i in range(n):
        step = steps[chosen[i]]
        scratch.weight[i], scratch.log_probability[i] = weight, step.log_probability
        scratch.value[i], scratch.advantage[i] = step.value, step.advantage
        for g in range(len(offsets) - 1):
            option = max(0, min(choices[chosen[i], g], offsets[g + 1] - offsets[g] - 1))
            scratch.choices[g, i] = np.float32(option)
        for j in range(numbers.shape[1]):
            scratch.numbers[j, i] = numbers[chosen[i], j]
    for i in range(n, len(scratch.weight)):  # padding is ignored but must be finite
        scratch.weight[i] = scratch.log_probability[i] = scratch.value[i] = scratch.advantage[i] = 0


@fused_njit
def output_gradient(activations, deltas, layers, rows, n, offsets, settings, scratch):
    """Write the gradient of the loss with respect to the outputs for n transitions, and fill the rows after
    them with zeros; add the loss's terms to the scratch.

    Each head's outputs are in the network's scratch, `activations`, where `gradient.forward` wrote them;
    their gradient follows at a distance of `deltas`.
    """
    weight, old_log_probability, old_value, advantage, choices, numbers = scratch[:6]
    outputs, exponentials, mean_logit, inverse_sum, log_ratio, terms = scratch[6:]
    for start in range(0, n, BLOCK):
        size = min(BLOCK, n - start)
        _transpose_outputs(activations, layers, rows, start, size, outputs)
        _begin(old_log_probability, start, log_ratio)
        for g in range(len(offsets) - 1):
            low, high = offsets[g], offsets[g + 1]
            _subtract_largest(outputs.reshape(-1), low, high)
            group_softmax(
                outputs,
                exponentials,
                low,
                high,
                g,
                mean_logit,
                inverse_sum,
                choices,
                weight,
                start,
                log_ratio,
                terms,
            )
        for j in range(len(numbers)):
            mean = offsets[-1] + 2 * j
            normal_log_probability(outputs, mean, numbers, j, weight, start, log_ratio, terms)
        policy_gradient(weight, advantage, start, settings, log_ratio, terms)
        value_gradient(outputs, weight, old_value, advantage, start, settings, terms)
        for g in range(len(offsets) - 1):
            low, high = offsets[g], offsets[g + 1]
            logit_gradient(
                outputs,
                exponentials,
                low,
                high,
                g,
                mean_logit,
                inverse_sum,
                choices,
                weight,
                start,
                settings.entropy,
                log_ratio,
            )
        for j in range(len(numbers)):
            mean = offsets[-1] + 2 * j
            normal_gradient(outputs, mean, numbers, j, weight, start, settings.entropy, log_ratio)
        _transpose_back(outputs, layers, rows, start, size, deltas, activations)


@lone_fused_njit
def _transpose_outputs(activations, layers, rows, start, size, outputs):
    """Transpose the outputs for the block's first `size` transitions, followed by zeros."""
    first = 0
    for level in range(len(layers)):
        layer = layer_of(layers, level)
        if not layer.hidden:
            wide = round_up(layer.outputs, LANES)
            at = rows * layer.above + start * wide
            for o in range(layer.outputs):
                for i in range(size):
                    outputs[first + o, i] = activations[np.uint64(at + i * wide + o)]
                for i in range(size, outputs.shape[1]):
                    outputs[first + o, i] = 0
            first += layer.outputs


@lone_fused_njit
def _transpose_back(outputs, layers, rows, start, size, deltas, activations):
    """Write the gradient for the block's first `size` transitions as rows, then rows of zeros."""
    first = 0
    for level in range(len(layers)):
        layer = layer_of(layers, level)
        if not layer.hidden:
            wide = round_up(layer.outputs, LANES)
            at = deltas + rows * layer.above + start * wide
            for o in range(layer.outputs):
                for i in range(size):
                    activations[np.uint64(at + i * wide + o)] = outputs[first + o, i]
                for i in range(size, min(BLOCK, rows - start)):
                    activations[np.uint64(at + i * wide + o)] = 0
            first += layer.outputs


@lone_fused_njit
def _begin(log_probability, start, log_ratio):
    for i in range(len(log_ratio)):
        log_ratio[i] = -log_probability[np.uint64(start + i)]


@fused_njit
def _subtract_largest(outputs, low, high):
    """Subtract the largest logit of a group from all its logits."""
    for i in range(0, BLOCK, LANES):
        largest = load(outputs, low * BLOCK + i)
        for k in range(low + 1, high):
            logit = load(outputs, k * BLOCK + i)
            largest = where_less(largest, logit, logit, largest)
        for k in range(low, high):
            store(outputs, k * BLOCK + i, load(outputs, k * BLOCK + i) - largest)


@lone_fused_njit
def group_softmax(
    logits, exponentials, low, high, g, mean_logit, inverse_sum, choices, weight, start, log_ratio, terms
):
    """Write the exponentials of a group's logits (which are at most 0), 1 / their sum, and the
    probability-weighted mean logit. Add the log-probability of the choice to `log_ratio` and the entropy
    [nat] to the terms."""
    zero, one = np.float32(0), np.float32(1)
    for i in range(len(log_ratio)):
        mean_logit[g, i] = zero
        inverse_sum[g, i] = zero
    for k in range(low, high):
        option = np.float32(k - low)
        for i in range(len(log_ratio)):
            logit, choice = logits[k, i], choices[g, np.uint64(start + i)]
            size = exp(logit)
            exponentials[k, i] = size
            inverse_sum[g, i] += size
            mean_logit[g, i] += size * logit
            log_ratio[i] += logit if choice == option else zero
    for i in range(len(log_ratio)):
        total = inverse_sum[g, i]
        scale, log_total = one / total, log(total)
        mean = mean_logit[g, i] * scale
        inverse_sum[g, i] = scale
        mean_logit[g, i] = mean
        log_ratio[i] -= log_total
        terms[ENTROPY + i] += weight[np.uint64(start + i)] * (log_total - mean)


@lone_fused_njit
def normal_log_probability(outputs, mean, numbers, j, weight, start, log_ratio, terms):
    """Add the log-probability of number j under its normal distribution to `log_ratio`, and its entropy [nat]
    to the terms; in the outputs, the log standard deviation follows the mean."""
    for i in range(len(log_ratio)):
        at = np.uint64(start + i)
        s = min(max(outputs[mean + 1, i], LEAST), MOST)
        z = (numbers[j, at] - outputs[mean, i]) * exp(-s)
        log_ratio[i] -= np.float32(0.5) * z * z + s + HALF_LOG_2_PI
        terms[ENTROPY + i] += weight[at] * (s + HALF_LOG_2_PI + np.float32(0.5))


@lone_fused_njit
def policy_gradient(weight, advantage, start, settings, log_ratio, terms):
    """Replace `log_ratio`, the change in the choices' log-probabilities, with the gradient with respect to
    them; add to the policy loss, the divergence r - 1 - log(r) and the clipped share."""
    zero, one = np.float32(0), np.float32(1)
    low, high = one - settings.clip, one + settings.clip
    shift, scale = settings.shift, settings.scale
    for i in range(len(log_ratio)):
        at = np.uint64(start + i)
        change, gain, part = log_ratio[i], (advantage[at] - shift) * scale, weight[at]
        r = exp(change)
        bound = low if r < low else (high if r > high else r)
        free, held = r * gain, bound * gain
        log_ratio[i] = zero if free > held else free * part  # no gradient if clipping limits the gain
        terms[i] -= part * (held if free > held else free)
        terms[KL + i] += part * (r - one - change)
        terms[CLIPPED + i] += part if bound != r else zero


@lone_fused_njit
def value_gradient(outputs, weight, old_value, advantage, start, settings, terms):
    """Replace the values with their gradient; add the squared errors. With clip_value, the error is the
    larger of the errors of the unclipped and the clipped value."""
    zero, clip, value = np.float32(0), settings.clip_value, len(outputs) - 1
    for i in range(outputs.shape[1]):
        at = np.uint64(start + i)
        part, change, gain = weight[at], outputs[value, i] - old_value[at], advantage[at]
        held = -clip if change < -clip else (clip if change > clip else change)
        error, miss = change - gain, (held if clip > zero else change) - gain
        free, worst = error * error, miss * miss
        gradient = (error + error) * settings.value_weight * part
        outputs[value, i] = zero if worst > free else gradient
        terms[VALUE + i] += part * (worst if worst > free else free)


@lone_fused_njit
def logit_gradient(
    logits, exponentials, low, high, g, mean_logit, inverse_sum, choices, weight, start, entropy, log_ratio
):
    """Replace a group's logits with their gradient; `entropy` is the weight of the entropy bonus."""
    zero = np.float32(0)
    for k in range(low, high):
        option = np.float32(k - low)
        for i in range(len(log_ratio)):
            at, d = np.uint64(start + i), log_ratio[i]
            bonus, choice = entropy * weight[at] * (logits[k, i] - mean_logit[g, i]), choices[g, at]
            p = exponentials[k, i] * inverse_sum[g, i]
            logits[k, i] = p * (d + bonus) - (d if choice == option else zero)


@lone_fused_njit
def normal_gradient(outputs, mean, numbers, j, weight, start, entropy, log_ratio):
    """Replace the mean and log standard deviation of number j's distribution with their gradient."""
    zero, one = np.float32(0), np.float32(1)
    for i in range(len(log_ratio)):
        at, d, free = np.uint64(start + i), log_ratio[i], outputs[mean + 1, i]
        s = min(max(free, LEAST), MOST)
        shrink = exp(-s)
        z = (numbers[j, at] - outputs[mean, i]) * shrink
        outputs[mean, i] = -d * z * shrink
        gradient = -d * (z * z - one) - entropy * weight[at]
        outputs[mean + 1, i] = gradient if s == free else zero


@fused_njit
def take_terms(scratch, terms):
    """Write the sums of the loss's terms to `terms` f64[5], and reset them to 0."""
    sums = scratch.terms
    for term in range(5):
        total = 0.0
        for i in range(term * BLOCK, (term + 1) * BLOCK):
            total += sums[np.uint64(i)]
            sums[np.uint64(i)] = 0
        terms[term] = total
