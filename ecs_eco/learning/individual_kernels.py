"""Kernels over animals that each have a network of their own: newborn weights, one thought,
one update of PPO.

A kernel works on one block of the columns: animal `places[j]` of the arguments is row `inner[j]` of the
block's arrays. A network is one row of numbers: of each layer the matrix (in, out), then the bias; the last
layer has all logits, then the value. `widths` i64[layers + 1] are those of the observations, the hidden
layers and the output. While an animal learns, a layer's activations are (units, transitions), padded to a
multiple of LANES, so that all loops run along the transitions, as vectors. Each animal's numbers are summed
in an order that depends on nothing but its own rollout.
"""

from __future__ import annotations

import math

import numpy as np

from ecs_eco.engine.random import draw, mix
from ecs_eco.learning.arithmetic import fused_njit, tanh
from ecs_eco.learning.ppo_kernels import adam, loss_slopes, summing_njit
from ecs_eco.learning.rollout import STEP
from ecs_eco.learning.tiles import LANES, add_product

NO_NUMBERS = np.zeros((1, 0), np.float32)  # of continuous actions, which these networks have none of
TERMS = ("policy_loss", "value_loss", "entropy", "approx_kl", "clip_fraction", "gradient_norm",
         "explained_variance", "reward")
_BIRTH = 1 << 32  # purposes of the numbers drawn for newborn weights begin here


@fused_njit
def draw_newborn(key, who, deviations, weights):
    """Fill f32[k, size] with normal numbers (Box and Muller 1958) of these deviations f32[size]; 0 stays 0.
    """
    for j in range(len(who)):
        for i in range(len(deviations)):
            weights[j, i] = 0
            if deviations[i] > 0:
                length = math.sqrt(-2 * math.log(1 - np.float64(draw(key, who[j], _BIRTH + 2 * i))))
                angle = 2 * math.pi * np.float64(draw(key, who[j], _BIRTH + 2 * i + 1))
                weights[j, i] = deviations[i] * np.float32(length * math.cos(angle))


@fused_njit
def think(weights, inner, places, widths, x, logits, values):
    """Write the logits f32[n, k] and values f32[n] of what each animal observes, f32[n, c]."""
    layers = len(widths) - 1
    scratch = np.empty((layers, widths.max()), np.float32)
    for j in range(len(inner)):
        w, below, at = weights[inner[j]], x[places[j]], 0
        for layer in range(layers):
            a, b = widths[layer], widths[layer + 1]
            above = scratch[layer, :b]
            _through(w[at : at + a * b], w[at + a * b : at + a * b + b], below, above)
            if layer < layers - 1:
                for o in range(b):
                    above[o] = tanh(above[o])
            below, at = above, at + a * b + b
        for o in range(len(below) - 1):
            logits[places[j], o] = below[o]
        values[places[j]] = below[len(below) - 1]


@fused_njit
def _through(matrix, bias, below, above):
    """Write above = bias + below @ matrix of one animal; four rows of the matrix (in * out) at a time."""
    n, full = len(above), len(below) // 4 * 4
    above[:] = bias
    for i in range(0, full, 4):
        w0, w1 = matrix[i * n : i * n + n], matrix[i * n + n : i * n + 2 * n]
        w2, w3 = matrix[i * n + 2 * n : i * n + 3 * n], matrix[i * n + 3 * n : i * n + 4 * n]
        x0, x1, x2, x3 = below[i], below[i + 1], below[i + 2], below[i + 3]
        for o in range(n):
            above[o] += (x0 * w0[o] + x1 * w1[o]) + (x2 * w2[o] + x3 * w3[o])
    for i in range(full, len(below)):
        w0, x0 = matrix[i * n : i * n + n], below[i]
        for o in range(n):
            above[o] += x0 * w0[o]


@fused_njit
def record(
    observations, choices, log_probabilities, values, rewards, inner, places, rows, length, x, choice,
    log_probability, value,
):  # fmt: skip
    """Append a transition to each animal's rollout; return how many had no room."""
    full = 0
    for j in range(len(inner)):
        at, place = inner[j], places[j]
        t = length[rows[place]]
        if not 0 <= t < rewards.shape[1]:
            full += 1
            continue
        for i in range(x.shape[1]):
            observations[at, t, i] = x[place, i]
        for g in range(choice.shape[1]):
            choices[at, t, g] = choice[place, g]
        log_probabilities[at, t], values[at, t], rewards[at, t] = log_probability[place], value[place], 0
        length[rows[place]] = t + 1
    return full


@fused_njit
def credit(rewards, inner, places, rows, length, reward):
    """Add the reward f32[n] to each animal's last transition, if it has one."""
    for j in range(len(inner)):
        t = length[rows[places[j]]] - 1
        if 0 <= t < rewards.shape[1]:
            rewards[inner[j], t] += reward[places[j]]


@fused_njit
def full_rollouts(length, rows, uid, born, tick, horizon, due):
    """Write whose rollout is at an end: full, or the first of a life,
    which ends at an age drawn from the uid."""
    for i in range(len(rows)):
        n = length[rows[i]]
        due[i] = n >= horizon or (n > 0 and np.uint64(tick - born[i]) == mix(uid[i]) % np.uint64(horizon))


@fused_njit
def train(
    weights, moments_1, moments_2, observations, choices, log_probabilities, values, rewards, inner, places,
    rows, uid, steps, updates, length, bootstrap, plasticity, settings, epochs, minibatch, normalise, seed,
    widths, offsets, report,
):  # fmt: skip
    """Let each animal learn from its rollout and empty it; `report` f64[n,
    TERMS] gets the means over its steps.

    `plasticity` f32[3, n]: learning rate, discount, weight of the entropy;
    with a learning rate of 0 nothing changes. `settings` f64[n, 7] are the other hyperparameters, as
    `individual.SETTINGS` names them; `epochs` and `minibatch` i64[n].
    """
    horizon, size = rewards.shape[1], weights.shape[1]
    room = widths.sum() * ((horizon + LANES - 1) // LANES * LANES)
    activations, slopes = np.zeros(room, np.float32), np.zeros(room, np.float32)
    gradient, lived, index = (np.zeros((1, size), np.float32), np.empty(horizon, STEP),
                              np.empty(horizon, np.int64))
    for j in range(len(inner)):
        at, place, row = inner[j], places[j], rows[places[j]]
        n, rate, terms = max(0, min(length[row], horizon)), plasticity[0, place], report[place]
        length[row], others = 0, settings[place]
        if n == 0 or rate == 0:
            continue
        shift, scale = _look_back(
            lived[:n], log_probabilities[at], values[at], rewards[at], bootstrap[place], plasticity[1, place],
            np.float32(others[0]), normalise, terms,
        )  # fmt: skip
        parts, chance = (max(1, (n + minibatch[place] - 1) // minibatch[place]),
                         mix(mix(seed ^ uid[place]) + np.uint64(updates[row])))
        updates[row] += 1
        for i in range(n):
            index[i] = i
        for epoch in range(epochs[place]):
            if parts > 1:
                _shuffle(index[:n], chance + np.uint64(epoch))
            for part in range(parts):
                chosen = index[n * part // parts : n * (part + 1) // parts]
                if parts > 1 or epoch == 0:
                    _fetch(observations[at], chosen, activations)
                steps[row] += 1
                _slope(
                    weights[at], gradient[0], choices[at], lived, chosen, shift, scale, plasticity[2, place],
                    others, widths, offsets, activations, slopes, terms,
                )  # fmt: skip
                terms[5] += adam(
                    weights[at], gradient, moments_1[at], moments_2[at], steps[row], rate, others[4],
                    others[5], others[6],
                )  # fmt: skip
        for i in range(6):
            terms[i] /= epochs[place] * parts


@fused_njit
def _look_back(lived, log_probability, value, reward, bootstrap, discount, gae_lambda, normalise, terms):
    """Fill in what an animal lived through, advantages too (Schulman et al. 2016, eq. 16);
    return their shift and scale."""
    n, later, gain = len(lived), bootstrap, np.float32(0)
    mean = target_mean = variance = target_variance = total = 0.0
    for t in range(n - 1, -1, -1):
        gain = reward[t] + discount * later - value[t] + discount * gae_lambda * gain
        later = value[t]
        lived[t].log_probability, lived[t].value, lived[t].advantage = log_probability[t], value[t], gain
        mean += gain / n
        target_mean += (gain + value[t]) / n
        total += reward[t]
    for t in range(n):
        variance += (lived[t].advantage - mean) ** 2 / n
        target_variance += (lived[t].advantage + value[t] - target_mean) ** 2 / n
    terms[6] = 1 - variance / target_variance if target_variance > 0 else np.nan
    terms[7] = total / n
    if normalise and n > 1:
        return np.float32(mean), np.float32(1 / (math.sqrt(variance) + 1e-8))
    return np.float32(0), np.float32(1)


@fused_njit
def _shuffle(index, key):
    """Bring the numbers into a random order (Durstenfeld 1964)."""
    for i in range(len(index) - 1, 0, -1):
        other = np.int64(mix(mix(key) + np.uint64(i)) % np.uint64(i + 1))
        index[i], index[other] = index[other], index[i]


@fused_njit
def _fetch(observations, chosen, activations):
    """Write the chosen observations [t, c] to the input layer (c, lanes), zeros behind them."""
    lanes = (len(chosen) + LANES - 1) // LANES * LANES
    for i in range(observations.shape[1]):
        x = activations[i * lanes : i * lanes + lanes]
        for t in range(len(chosen)):
            x[t] = observations[chosen[t], i]
        x[len(chosen) :] = 0


@fused_njit
def _slope(
    w, gradient, choices, lived, chosen, shift, scale, entropy, settings, widths, offsets, activations,
    slopes, terms,
):  # fmt: skip
    """Write the gradient [size] of the mean loss over the chosen transitions;
    add its terms' means to `terms`."""
    n, k = len(chosen), widths[len(widths) - 1]
    lanes = (n + LANES - 1) // LANES * LANES
    _forward(w, widths, activations, lanes)
    last = (widths.sum() - k) * lanes
    out, d_out = (activations[last : last + k * lanes].reshape(k, lanes),
                  slopes[last : last + k * lanes].reshape(k, lanes))
    logits, d, sums = np.empty((k, n), np.float32), np.empty((k, n), np.float32), np.empty(6)
    for o in range(k):
        logits[o] = out[o, :n]
    loss_slopes(
        logits[: k - 1], logits[k - 1], offsets, choices, NO_NUMBERS, lived, chosen, np.float32(settings[1]),
        np.float32(settings[2]), entropy,
        np.float32(settings[3]), shift, scale, np.float32(1 / n), d[: k - 1], d[k - 1], sums,
    )  # fmt: skip
    for o in range(k):
        d_out[o, :n] = d[o]
        d_out[o, n:] = 0
    for i in range(5):
        terms[i] += sums[i] / n
    _backward(w, gradient, widths, activations, slopes, lanes)


@fused_njit
def _forward(w, widths, activations, lanes):
    """Fill the activations of all layers from the first's."""
    at = unit = 0
    for layer in range(len(widths) - 1):
        a, b = widths[layer], widths[layer + 1]
        below = activations[unit * lanes : (unit + a) * lanes].reshape(a, lanes)
        above = activations[(unit + a) * lanes : (unit + a + b) * lanes]
        bias, rows = w[at + a * b : at + a * b + b], above.reshape(b, lanes)
        for o in range(b):
            rows[o] = bias[o]
        add_product(w[at : at + a * b].reshape(a, b), below, rows)
        if layer < len(widths) - 2:
            for i in range(len(above)):
                above[i] = tanh(above[i])
        at, unit = at + a * b + b, unit + a


@fused_njit
def _backward(w, gradient, widths, activations, slopes, lanes):
    """Fill the gradient of all weights from the slopes by the last layer's output;
    `slopes` of the others are used up."""
    at, unit = len(w), widths.sum()
    for layer in range(len(widths) - 2, -1, -1):
        a, b = widths[layer], widths[layer + 1]
        at, unit = at - a * b - b, unit - b
        d = slopes[unit * lanes : (unit + b) * lanes].reshape(b, lanes)
        h = activations[(unit - a) * lanes : unit * lanes]
        _dots(h.reshape(a, lanes), d, gradient[at : at + a * b].reshape(a, b),
              gradient[at + a * b : at + a * b + b])
        if layer > 0:
            d_below = slopes[(unit - a) * lanes : unit * lanes]
            d_below[:] = 0
            add_product(w[at : at + a * b].reshape(a, b).T, d, d_below.reshape(a, lanes))
            for i in range(len(h)):
                d_below[i] *= np.float32(1) - h[i] * h[i]


@summing_njit
def _dots(below, d, gradient, d_bias):
    """Write the gradient of a layer's matrix, below @ d.T, and of its bias."""
    for i in range(below.shape[0]):
        for o in range(d.shape[0]):
            total = np.float32(0)
            for t in range(d.shape[1]):
                total += below[i, t] * d[o, t]
            gradient[i, o] = total
    for o in range(d.shape[0]):
        total = np.float32(0)
        for t in range(d.shape[1]):
            total += d[o, t]
        d_bias[o] = total
