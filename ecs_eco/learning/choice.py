"""How a row of logits becomes one choice per action group."""

from __future__ import annotations

import numpy as np

from ecs_eco.learning.arithmetic import fused_njit, softmax

BLOCK = 128  # rows that are turned on their side at once


@fused_njit
def choose(logits, offsets, uniforms, choice, log_probability):
    """Draw each row's choice int[n, G], and its log-probability f32[n], where the uniforms f32[n, G] fall.

    `offsets` are the brain's; uniforms are in [0, 1). Rows go in blocks turned on their side, so that loops
    along them become vectors.
    """
    n, width = logits.shape
    side, p = np.zeros((width, BLOCK), np.float32), np.empty((width, BLOCK), np.float32)
    log_sum_exp, entropy = np.empty(BLOCK, np.float32), np.empty(BLOCK, np.float32)
    for start in range(0, n, BLOCK):
        size = min(BLOCK, n - start)
        for i in range(size):
            log_probability[start + i] = 0
            for k in range(width):
                side[k, i] = logits[start + i, k]
        for g in range(len(offsets) - 1):
            softmax(side, offsets[g], offsets[g + 1], p, log_sum_exp, entropy)
            for i in range(size):
                remaining, chosen = uniforms[start + i, g], offsets[g]
                for k in range(offsets[g], offsets[g + 1] - 1):
                    remaining -= p[k, i]
                    chosen += remaining >= 0
                choice[start + i, g] = chosen - offsets[g]
                log_probability[start + i] += side[chosen, i] - log_sum_exp[i]


@fused_njit
def choose_best(logits, offsets, choice):
    """Write each row's likeliest choice of every group into int[n, G]; the first of equals."""
    for i in range(logits.shape[0]):
        for g in range(len(offsets) - 1):
            choice[i, g] = _highest(logits, i, offsets[g], offsets[g + 1]) - offsets[g]


@fused_njit
def _highest(logits, i, low, high):
    top = low
    for k in range(low + 1, high):
        if logits[i, k] > logits[i, top]:
            top = k
    return top
