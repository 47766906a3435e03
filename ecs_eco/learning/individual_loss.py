"""PPO's loss of one animal, whose transitions are few: what ppo_kernels.loss_slopes says of many.

Transitions are turned on their side, so that all loops run along a fixed number of them, as vectors; all
that is in these loops is float32.
"""

from __future__ import annotations

import numpy as np

from ecs_eco.learning.arithmetic import exp, fused_njit, log, lone_fused_njit

BLOCK = 32  # transitions
OLD, ADVANTAGE, NOW = BLOCK, 2 * BLOCK, 3 * BLOCK  # what `fate` has behind the log-probability of then
VALUES, ENTROPY, CHANGE, CLIPPED = BLOCK, 2 * BLOCK, 3 * BLOCK, 4 * BLOCK  # what `sums` has behind the policy


@fused_njit
def desk_for(offsets):
    """Return the arrays in which `loss_slopes` works, where `offsets` are those of the groups: outputs,
    probabilities; of each group what was taken, and the entropy; `fate`, `sums` and two to spare."""
    k, n_groups = offsets[-1], len(offsets) - 1
    return (np.zeros((k + 1, BLOCK), np.float32), np.zeros((k, BLOCK), np.float32),
            np.zeros((n_groups, BLOCK), np.float32), np.zeros((n_groups, BLOCK), np.float32),
            np.zeros(4 * BLOCK, np.float32), np.zeros(5 * BLOCK, np.float32),
            np.zeros(2 * BLOCK, np.float32))


@fused_njit
def loss_slopes(room, out, d_out, wide, rows, offsets, choices, at, lived, chosen, settings, entropy_weight,
                shift, scale, desk, terms):
    """Write the slopes of the mean loss by the outputs, zeros where rows stand for no transition;
    add the means of the loss's terms to the first five of `terms`.

    Outputs and slopes are (rows, wide), from `out` and `d_out` of the room f32[…] on: the logits of the
    groups between `offsets`, then the value. `chosen` i64[n] are the transitions of the first rows, in
    `choices` int[at, t, G] and `lived` (a STEP each); `settings` are `individual.SETTINGS`.
    """
    side, p, taken, entropy, fate, sums, spare = desk
    n, n_groups, k, one = len(chosen), len(offsets) - 1, offsets[-1], np.float32(1)
    share, clip, clip_value = np.float32(1 / n), np.float32(settings[1]), np.float32(settings[2])
    weight, value_weight = np.float32(entropy_weight) * share, np.float32(settings[3]) * share
    for start in range(0, n, BLOCK):
        size = min(BLOCK, n - start)
        _turn_outputs(room, out + start * wide, wide, size, side)
        _fetch(lived, chosen, start, size, fate, sums)
        for g in range(n_groups):
            _fetch_choices(choices, at, chosen, start, size, g, offsets[g + 1] - offsets[g], taken)
            _judge(side, p, offsets[g], offsets[g + 1], taken, entropy, g, fate, sums, spare)
        _policy(fate, one - clip, one + clip, shift, scale, share, sums)
        _value(side, k, fate, clip_value, value_weight, sums)
        for g in range(n_groups):
            _turn(side, p, offsets[g], offsets[g + 1], taken, entropy, g, fate, weight)
        _turn_back(side, size, room, d_out + start * wide, wide, min(BLOCK, rows - start))
        _add_up(sums, size, 1 / n, terms)


@lone_fused_njit
def _turn_outputs(room, out, wide, size, side):
    """Turn the outputs of the block's first `size` transitions on their side."""
    for o in range(side.shape[0]):
        for i in range(size):
            side[o, i] = room[np.uint64(out + i * wide + o)]


@lone_fused_njit
def _fetch(lived, chosen, start, size, fate, sums):
    """Fetch log-probability, value and advantage of then; those of now and the entropy become 0, to be added
    to."""
    for i in range(size):
        t = chosen[start + i]
        fate[i], fate[OLD + i], fate[ADVANTAGE + i] = (lived[t].log_probability, lived[t].value,
                                                       lived[t].advantage)
    for i in range(BLOCK):
        fate[NOW + i] = 0
        sums[ENTROPY + i] = 0


@lone_fused_njit
def _fetch_choices(choices, at, chosen, start, size, g, options, taken):
    """Fetch which of a group's options was taken."""
    for i in range(size):
        taken[g, i] = np.float32(max(0, min(choices[at, chosen[start + i], g], options - 1)))


@lone_fused_njit
def _judge(side, p, low, high, taken, entropy, g, fate, sums, spare):
    """Write the probabilities of a group's options, and their logarithms in the place of the logits, and the
    entropy [nat]; add this, and the logarithm of the option taken, to those of now."""
    zero, one = np.float32(0), np.float32(1)
    for i in range(BLOCK):
        spare[i] = side[low, i]
        spare[BLOCK + i] = zero
        entropy[g, i] = zero
    for k in range(low + 1, high):
        for i in range(BLOCK):
            a, b = side[k, i], spare[i]
            spare[i] = a if a > b else b
    for k in range(low, high):
        for i in range(BLOCK):
            less = side[k, i] - spare[i]
            size = exp(less)
            side[k, i] = less
            p[k, i] = size
            spare[BLOCK + i] += size
    for i in range(BLOCK):
        total = spare[BLOCK + i]
        spare[i] = log(total)
        spare[BLOCK + i] = one / total
    for k in range(low, high):
        option = np.float32(k - low)
        for i in range(BLOCK):
            certain, size = side[k, i] - spare[i], p[k, i] * spare[BLOCK + i]
            side[k, i] = certain
            p[k, i] = size
            entropy[g, i] -= size * certain
            fate[NOW + i] += certain if taken[g, i] == option else zero
    for i in range(BLOCK):
        sums[ENTROPY + i] += entropy[g, i]


@lone_fused_njit
def _policy(fate, low, high, shift, scale, share, sums):
    """Turn the log-probabilities of now into the slopes by the logits of what was chosen;
    write the loss of the policy, the change of the probabilities, and what was clipped."""
    zero, one = np.float32(0), np.float32(1)
    for i in range(BLOCK):
        change, gain = fate[NOW + i] - fate[i], (fate[ADVANTAGE + i] - shift) * scale
        r = exp(change)
        bound = low if r < low else (high if r > high else r)
        free, held = r * gain, bound * gain
        fate[NOW + i] = zero if free > held else free * share  # beyond the bound, on the side of gain
        sums[i] = -(held if free > held else free)
        sums[CHANGE + i] = r - one - change
        sums[CLIPPED + i] = one if bound != r else zero


@lone_fused_njit
def _value(side, k, fate, clip_value, weight, sums):
    """Turn the values, row k of `side`, into the slopes by them; write the squared errors,
    with clip_value that of the worse of the free and the held value."""
    zero = np.float32(0)
    for i in range(BLOCK):
        error = side[k, i] - fate[OLD + i] - fate[ADVANTAGE + i]
        sums[VALUES + i] = error * error
    if clip_value > zero:
        for i in range(BLOCK):
            change, free = side[k, i] - fate[OLD + i], sums[VALUES + i]
            held = -clip_value if change < -clip_value else (clip_value if change > clip_value else change)
            miss = held - fate[ADVANTAGE + i]
            worse = miss * miss
            sums[VALUES + i] = worse if worse > free else free
    for i in range(BLOCK):
        error = side[k, i] - fate[OLD + i] - fate[ADVANTAGE + i]
        slope = weight * (error + error)
        side[k, i] = zero if sums[VALUES + i] > error * error else slope


@lone_fused_njit
def _turn(side, p, low, high, taken, entropy, g, fate, weight):
    """Turn the logarithms of a group's probabilities into the slopes by its logits."""
    zero = np.float32(0)
    for k in range(low, high):
        option = np.float32(k - low)
        for i in range(BLOCK):
            d = fate[NOW + i]
            slope = p[k, i] * (d + weight * (side[k, i] + entropy[g, i]))
            side[k, i] = slope - (d if taken[g, i] == option else zero)


@lone_fused_njit
def _turn_back(side, size, room, d_out, wide, rows):
    """Write the slopes of the block's first `size` transitions as rows, zeros into those behind them."""
    for o in range(side.shape[0]):
        for i in range(size):
            room[np.uint64(d_out + i * wide + o)] = side[o, i]
        for i in range(size, rows):
            room[np.uint64(d_out + i * wide + o)] = 0


@fused_njit
def _add_up(sums, size, share, terms):
    """Add the terms of the first `size` transitions, `share` of each."""
    a = b = c = d = e = 0.0
    for i in range(size):
        a, b, c = a + sums[i], b + sums[VALUES + i], c + sums[ENTROPY + i]
        d, e = d + sums[CHANGE + i], e + sums[CLIPPED + i]
    terms[0] += a * share
    terms[1] += b * share
    terms[2] += c * share
    terms[3] += d * share
    terms[4] += e * share
