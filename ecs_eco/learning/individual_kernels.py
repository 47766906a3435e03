"""Kernels over animals that each have a network of their own: newborn weights, one thought,
one update of PPO.

Columns come in blocks, see `Blocked.by_address`; animal j of the arguments is row `rows[j]` of the table. A
network is one row of numbers: of each layer the matrix (in, out), then the bias; the last
layer has all logits, then the value. `widths` i64[layers + 1] are those of the observations, the hidden
layers and the output. Each animal's numbers are summed in an order that depends on nothing but its own
rollout.
"""

from __future__ import annotations

import math

import numpy as np

from ecs_eco.engine.blocks import BLOCK, apart, block_of, flat_block_of, prefetch_row
from ecs_eco.engine.random import draw, mix
from ecs_eco.engine.vectors import LANES, every, load, prefetch, spread, store
from ecs_eco.learning.arithmetic import fused_njit, largest, lone_fused_njit, tanh
from ecs_eco.learning.individual_gradient import backward, fetch, forward, layout
from ecs_eco.learning.individual_loss import desk_for, lay_out, loss_slopes, tell
from ecs_eco.learning.ppo_kernels import adam
from ecs_eco.learning.rollout import STEP
from ecs_eco.learning.tiles import ROWS, up

TERMS = (
    "policy_loss",
    "value_loss",
    "entropy",
    "approx_kl",
    "clip_fraction",
    "gradient_norm",
    "explained_variance",
    "reward",
)
SOON = 8  # animals: so many others are recorded while the places of one are fetched
_BIRTH = 1 << 32  # purposes of the numbers drawn for newborn weights begin here


@fused_njit
def draw_newborn(key, who, deviations, weights):
    """Fill f32[k, size] with normal numbers (Box and Muller 1958) of these deviations f32[size]; 0 stays 0."""
    for j in range(len(who)):
        for i in range(len(deviations)):
            weights[j, i] = 0
            if deviations[i] > 0:
                length = math.sqrt(-2 * math.log(1 - np.float64(draw(key, who[j], _BIRTH + 2 * i))))
                angle = 2 * math.pi * np.float64(draw(key, who[j], _BIRTH + 2 * i + 1))
                weights[j, i] = deviations[i] * np.float32(length * math.cos(angle))


@lone_fused_njit
def think(first, last, rows, weights, widths, x, logits, values):
    """Write the logits f32[n, k] and values f32[n] of what animals first … last − 1 observe, f32[n, c].

    Of a layer's inputs, every fourth is added up on its own. Up to LANES numbers behind each animal's weights
    are read, and let be.
    """
    zero, k, size, wide = spread(np.float32(0)), logits.shape[1], weights[1].shape[1], largest(widths)
    wide = up(wide, LANES)
    units = np.zeros(2 * wide, np.float32)
    for j in range(first, last):
        w, at, below, above = flat_block_of(rows[j], weights), rows[j] % BLOCK * size, 0, wide
        ahead = apart(rows[j], rows[min(j + 1, last - 1)], weights)  # the next animal's weights
        for i in range(x.shape[1]):
            units[i] = x[j, i]
        for layer in range(len(widths) - 1):
            a, b = widths[layer], widths[layer + 1]
            for o in range(0, b, LANES):
                here, y0, y1, y2, y3 = at + o, load(w, at + o + a * b), zero, zero, zero
                for i in range(below, below + a // 4 * 4, 4):
                    y0, y1 = (
                        y0 + every(units, i) * load(w, here),
                        y1 + every(units, i + 1) * load(w, here + b),
                    )
                    y2, y3 = (
                        y2 + every(units, i + 2) * load(w, here + 2 * b),
                        y3 + every(units, i + 3) * load(w, here + 3 * b),
                    )
                    for _ in range(4):
                        prefetch(w, here + ahead)
                        here += b
                for i in range(below + a // 4 * 4, below + a):
                    y0 = y0 + every(units, i) * load(w, here)
                    here += b
                y0 = (y0 + y1) + (y2 + y3)
                store(units, above + o, tanh(y0) if layer < len(widths) - 2 else y0)
            below, above, at = above, below, at + (a + 1) * b
        for o in range(k):
            logits[j, o] = units[np.uint64(below + o)]
        values[j] = units[below + k]


@fused_njit
def record(
    observations, choices, log_probabilities, values, rewards, rows, length, x, choice, log_probability, value
):
    """Append a transition to each animal's rollout; return how many had no room."""
    full, horizon = 0, rewards[1].shape[1]
    for j in range(len(rows)):
        _prefetch_place(
            rows[min(j + SOON, len(rows) - 1)], length, observations, choices, log_probabilities, values
        )
        row, at = rows[j], rows[j] % BLOCK
        t = length[row]
        if not 0 <= t < horizon:
            full += 1
            continue
        seen, taken = block_of(row, observations), block_of(row, choices)
        for i in range(x.shape[1]):
            seen[at, t, i] = x[j, i]
        for g in range(choice.shape[1]):
            taken[at, t, g] = choice[j, g]
        block_of(row, log_probabilities)[at, t] = log_probability[j]
        block_of(row, values)[at, t], block_of(row, rewards)[at, t] = value[j], 0
        length[row] = t + 1
    return full


@fused_njit
def _prefetch_place(row, length, observations, choices, log_probabilities, values):
    """Let the processor begin to fetch where an animal's next transition goes."""
    place, c = row % BLOCK * values[1].shape[1] + length[row], observations[1].shape[2]
    for k in range(0, c, LANES):
        prefetch(flat_block_of(row, observations), place * c + k)
    prefetch(flat_block_of(row, choices), place * choices[1].shape[2])
    prefetch(flat_block_of(row, log_probabilities), place)
    prefetch(flat_block_of(row, values), place)


@fused_njit
def credit(rewards, rows, length, reward):
    """Add the reward f32[n] to each animal's last transition, if it has one."""
    for j in range(len(rows)):
        t = length[rows[j]] - 1
        if 0 <= t < rewards[1].shape[1]:
            block_of(rows[j], rewards)[rows[j] % BLOCK, t] += reward[j]


@fused_njit
def full_rollouts(length, rows, uid, born, tick, horizon, due):
    """Write whose rollout is at an end: full, or the first of a life,
    which ends at an age drawn from the uid."""
    for i in range(len(rows)):
        n = length[rows[i]]
        due[i] = n >= horizon or (n > 0 and np.uint64(tick - born[i]) == mix(uid[i]) % np.uint64(horizon))


@fused_njit
def train(
    first,
    last,
    weights,
    moments_1,
    moments_2,
    observations,
    choices,
    log_probabilities,
    values,
    rewards,
    rows,
    uid,
    steps,
    updates,
    length,
    bootstrap,
    plasticity,
    settings,
    epochs,
    minibatch,
    normalise,
    seed,
    widths,
    offsets,
    report,
):
    """Let animals first … last − 1 learn from their rollouts and empty them; `report` f64[n, TERMS] gets the
    means over each one's steps.

    `plasticity` f32[3, n]: learning rate, discount, weight of the entropy;
    with a learning rate of 0 nothing changes. `settings` f64[n, 7] are the other hyperparameters, as
    `individual.SETTINGS` names them; `epochs` and `minibatch` i64[n].
    """
    horizon, size = rewards[1].shape[1], weights[1].shape[1]
    where, desk = layout(widths, horizon), desk_for(offsets, horizon)
    room, lived, index = np.zeros(where[-1], np.float32), np.empty(horizon, STEP), np.empty(horizon, np.int64)
    w, gradient = room[where[1] : where[1] + size], room[where[2] : where[2] + size].reshape(1, size)
    for j in range(first, last):
        row, at = rows[j], rows[j] % BLOCK
        n, rate, terms = max(0, min(length[row], horizon)), plasticity[0, j], report[j]
        length[row], others = 0, settings[j]
        if n == 0 or rate == 0:
            continue
        shift, scale = _look_back(
            lived[:n],
            block_of(row, log_probabilities)[at],
            block_of(row, values)[at],
            block_of(row, rewards)[at],
            bootstrap[j],
            plasticity[1, j],
            np.float32(others[0]),
            normalise,
            terms,
        )
        parts, chance = (
            max(1, (n + minibatch[j] - 1) // minibatch[j]),
            mix(mix(seed ^ uid[j]) + np.uint64(updates[row])),
        )
        updates[row] += 1
        own, own_1, own_2 = (
            block_of(row, weights)[at],
            block_of(row, moments_1)[at],
            block_of(row, moments_2)[at],
        )
        seen, taken = block_of(row, observations), block_of(row, choices)
        for i in range(n):
            index[i] = i
        for i in range(0, size, LANES):
            store(room, where[1] + i, load(own, i))
        if j + 1 < last:  # the next animal's arrive while this one learns
            for column in (weights, moments_1, moments_2):
                prefetch_row(rows[j + 1], column)
            prefetch_row(rows[j + 1], observations)
        for epoch in range(epochs[j]):
            if parts > 1:
                _shuffle(index[:n], chance + np.uint64(epoch))
            for part in range(parts):
                chosen = index[n * part // parts : n * (part + 1) // parts]
                if parts > 1 or epoch == 0:
                    fetch(seen, at, chosen, room)
                    lay_out(desk, lived, taken, at, chosen, offsets)
                steps[row] += 1
                lines = up(len(chosen), ROWS)
                unit = forward(room, where, widths, lines)
                loss_slopes(
                    room,
                    unit,
                    where[0] + unit,
                    up(widths[-1], LANES),
                    lines,
                    len(chosen),
                    offsets,
                    others,
                    plasticity[2, j],
                    shift,
                    scale,
                    desk,
                )
                backward(room, where, widths, lines, len(chosen), unit)
                terms[5] += adam(w, gradient, own_1, own_2, steps[row], rate, others[4], others[5], others[6])
        for i in range(size):  # a copy of a slice asks of each number whether the slice repeats it
            own[np.uint64(i)] = w[np.uint64(i)]
        tell(desk, epochs[j] * parts, terms)
        terms[5] /= epochs[j] * parts


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
        mean += gain
        target_mean += gain + value[t]
        total += reward[t]
    mean, target_mean = mean / n, target_mean / n
    for t in range(n):
        variance += (lived[t].advantage - mean) ** 2
        target_variance += (lived[t].advantage + value[t] - target_mean) ** 2
    variance, target_variance = variance / n, target_variance / n
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
