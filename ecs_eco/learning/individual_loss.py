"""PPO's loss of one animal, whose transitions are few: what ppo_kernels.loss_slopes says of many.

Transitions are turned on their side, so that all loops run along a block of them, as vectors: float32 is all
that is in these loops, and their length is the arrays', for the compiler undoes short loops of known length.
"""

from __future__ import annotations

import numpy as np

from ecs_eco.compiled.vectors import LANES, load, store, where_less
from ecs_eco.learning.arithmetic import exp, fused_njit, log, lone_fused_njit
from ecs_eco.learning.tiles import up

BLOCK = 32  # transitions
VALUES, ENTROPY, CHANGE, CLIPPED = BLOCK, 2 * BLOCK, 3 * BLOCK, 4 * BLOCK  # in `sums`, behind the policy's


@fused_njit
def desk_for(offsets, horizon):
    """Return the arrays in which `lay_out` and `loss_slopes` work, where `offsets` are those of the groups.

    Of each transition f32[horizon]: its share of the loss, log-probability, value, advantage, and what was
    taken of each group, [G, horizon]. Of a block: outputs, probabilities; mean and scale of each group's;
    what is the same for all options; `sums`, the terms of the loss.
    """
    k, n_groups, n = offsets[-1], len(offsets) - 1, up(horizon, BLOCK)
    share, then, old, advantage, taken = (
        np.zeros(n, np.float32),
        np.zeros(n, np.float32),
        np.zeros(n, np.float32),
        np.zeros(n, np.float32),
        np.zeros((n_groups, n), np.float32),
    )
    side, p = np.zeros((k + 1, BLOCK), np.float32), np.zeros((k, BLOCK), np.float32)
    means, scales = np.zeros((n_groups, BLOCK), np.float32), np.zeros((n_groups, BLOCK), np.float32)
    now, sums = np.zeros(BLOCK, np.float32), np.zeros(5 * BLOCK, np.float32)
    return share, then, old, advantage, taken, side, p, means, scales, now, sums


@fused_njit
def lay_out(desk, lived, choices, at, chosen, offsets):
    """Lay out the chosen transitions i64[n] of `lived` (a STEP each) and `choices` int[at, t, G]."""
    share, then, old, advantage, taken = desk[:5]
    n = len(chosen)
    for i in range(len(share)):  # those behind are of no account, and finite
        share[i] = then[i] = old[i] = advantage[i] = 0
    for i in range(n):
        step = lived[chosen[i]]
        share[i], then[i], old[i] = np.float32(1 / n), step.log_probability, step.value
        advantage[i] = step.advantage
        for g in range(len(offsets) - 1):
            taken[g, i] = np.float32(max(0, min(choices[at, chosen[i], g], offsets[g + 1] - offsets[g] - 1)))


@fused_njit
def loss_slopes(room, out, d_out, wide, rows, n, offsets, settings, entropy_weight, shift, scale, desk):
    """Write the slopes of the mean loss by the outputs of n transitions, zeros into the rows behind them;
    add the loss's terms to the `sums` of the desk.

    Outputs and slopes are (rows, wide), from `out` and `d_out` of the room f32[…] on: the logits of the
    groups between `offsets`, then the value. `settings` are those of `individual.SETTINGS`.
    """
    share, then, old, advantage, taken, side, p, means, scales, now, sums = desk
    n_groups, k, one, clip = len(offsets) - 1, offsets[-1], np.float32(1), np.float32(settings[1])
    weight, clip_value, value_weight = (
        np.float32(entropy_weight),
        np.float32(settings[2]),
        np.float32(settings[3]),
    )
    flat = side.reshape(-1)
    for start in range(0, n, BLOCK):
        size = min(BLOCK, n - start)
        _turn_outputs(room, out + start * wide, wide, size, side)
        _begin(then, start, now)
        for g in range(n_groups):
            _take_largest(flat, offsets[g], offsets[g + 1])
            _judge(side, p, offsets[g], offsets[g + 1], g, taken, share, start, means, scales, now, sums)
        _policy(share, advantage, start, one - clip, one + clip, shift, scale, now, sums)
        _value(side, k, share, old, advantage, start, clip_value, value_weight, sums)
        for g in range(n_groups):
            _turn(side, p, offsets[g], offsets[g + 1], g, taken, share, start, means, scales, now, weight)
        _turn_back(side, size, room, d_out + start * wide, wide, min(BLOCK, rows - start))


@lone_fused_njit
def _turn_outputs(room, out, wide, size, side):
    """Turn the outputs of the block's first `size` transitions on their side; behind them are zeros."""
    for o in range(side.shape[0]):
        for i in range(size):
            side[o, i] = room[np.uint64(out + i * wide + o)]
        for i in range(size, side.shape[1]):
            side[o, i] = 0


@lone_fused_njit
def _begin(then, start, now):
    for i in range(len(now)):
        now[i] = -then[np.uint64(start + i)]


@fused_njit
def _take_largest(side, low, high):
    """Take from a group's logits the largest of them."""
    for i in range(0, BLOCK, LANES):
        most = load(side, low * BLOCK + i)
        for k in range(low + 1, high):
            logit = load(side, k * BLOCK + i)
            most = where_less(most, logit, logit, most)
        for k in range(low, high):
            store(side, k * BLOCK + i, load(side, k * BLOCK + i) - most)


@lone_fused_njit
def _judge(side, p, low, high, g, taken, share, start, means, scales, now, sums):
    """Write the exponentials of a group's logits, which are at most 0, 1 / their sum, and the logits' mean by
    probability; add the logarithm of what was taken to `now`, the entropy to `sums`."""
    zero, one = np.float32(0), np.float32(1)
    for i in range(len(now)):
        means[g, i] = zero
        scales[g, i] = zero
    for k in range(low, high):
        option = np.float32(k - low)
        for i in range(len(now)):
            less, choice = side[k, i], taken[g, np.uint64(start + i)]
            size = exp(less)
            p[k, i] = size
            scales[g, i] += size
            means[g, i] += size * less
            now[i] += less if choice == option else zero
    for i in range(len(now)):
        total = scales[g, i]
        scale, most = one / total, log(total)
        mean = means[g, i] * scale
        scales[g, i] = scale
        means[g, i] = mean
        now[i] -= most
        sums[ENTROPY + i] += share[np.uint64(start + i)] * (most - mean)


@lone_fused_njit
def _policy(share, advantage, start, low, high, shift, scale, now, sums):
    """Turn `now`, by how much the log-probabilities of what was taken have changed, into the slopes by its
    logits; add to the loss of the policy, the change, and what was clipped."""
    zero, one = np.float32(0), np.float32(1)
    for i in range(len(now)):
        at = np.uint64(start + i)
        change, gain, part = now[i], (advantage[at] - shift) * scale, share[at]
        r = exp(change)
        bound = low if r < low else (high if r > high else r)
        free, held = r * gain, bound * gain
        now[i] = zero if free > held else free * part  # beyond the bound, on the side of gain
        sums[i] -= part * (held if free > held else free)
        sums[CHANGE + i] += part * (r - one - change)
        sums[CLIPPED + i] += part if bound != r else zero


@lone_fused_njit
def _value(side, k, share, old, advantage, start, clip_value, weight, sums):
    """Turn the values, row k of `side`, into the slopes by them; add the squared errors, with clip_value
    those of the worse of the free and the held value."""
    zero = np.float32(0)
    for i in range(side.shape[1]):
        at = np.uint64(start + i)
        part, change, gain = share[at], side[k, i] - old[at], advantage[at]
        held = -clip_value if change < -clip_value else (clip_value if change > clip_value else change)
        error, miss = change - gain, (held if clip_value > zero else change) - gain
        free, worst = error * error, miss * miss
        slope = (error + error) * weight * part
        side[k, i] = zero if worst > free else slope
        sums[VALUES + i] += part * (worst if worst > free else free)


@lone_fused_njit
def _turn(side, p, low, high, g, taken, share, start, means, scales, now, weight):
    """Turn a group's logits into the slopes by them."""
    zero = np.float32(0)
    for k in range(low, high):
        option = np.float32(k - low)
        for i in range(len(now)):
            at, d = np.uint64(start + i), now[i]
            bonus, choice = weight * share[at] * (side[k, i] - means[g, i]), taken[g, at]
            side[k, i] = p[k, i] * scales[g, i] * (d + bonus) - (d if choice == option else zero)


@lone_fused_njit
def _turn_back(side, size, room, d_out, wide, rows):
    """Write the slopes of the block's first `size` transitions as rows, zeros into those behind them."""
    for o in range(side.shape[0]):
        for i in range(size):
            room[np.uint64(d_out + i * wide + o)] = side[o, i]
        for i in range(size, rows):
            room[np.uint64(d_out + i * wide + o)] = 0


@fused_njit
def tell(desk, steps, terms):
    """Write the means of the loss's terms over these steps of an update, and let the next begin at 0."""
    sums = desk[-1]
    for term in range(5):
        total = 0.0
        for i in range(term * BLOCK, (term + 1) * BLOCK):
            total += sums[np.uint64(i)]
            sums[np.uint64(i)] = 0
        terms[term] = total / steps
