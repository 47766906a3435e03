"""Convert a row of logits to one choice per action group."""

from __future__ import annotations

import numpy as np

from ecs_eco.learning.arithmetic import exp, fused_njit, log, lone_fused_njit

BLOCK = 128  # rows transposed together


@lone_fused_njit
def choose(logits, offsets, uniforms, choice, log_probability):
    """Draw a choice in each group for each row, and write the log-probabilities.

    Parameters
    ----------
    logits : array of float32, shape (n, sum(groups))
    offsets : array of int
        First column of each group, and the end: `brain.offsets`.
    uniforms : array of float32, shape (n, groups)
        Random numbers in [0, 1).
    choice : array of int, shape (n, groups)
        Receives the chosen options, counted from 0.
    log_probability : array of float32, shape (n,)
        Receives the sum over groups.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.learning import Brain, choose
    >>> brain = Brain(3, groups=(2, 4), seed=1)
    >>> logits, _ = brain.forward(np.zeros((5, 3), np.float32))
    >>> choice, log_probability = np.zeros((5, 2), np.int16), np.zeros(5, np.float32)
    >>> choose(logits, brain.offsets, np.full((5, 2), 0.99, np.float32), choice, log_probability)
    >>> choice[0].tolist()
    [1, 3]
    """
    n, width = logits.shape
    side, total = np.zeros((width, BLOCK), np.float32), np.empty(BLOCK, np.float32)
    rest, sure = np.zeros(BLOCK, np.float32), np.empty(BLOCK, np.float32)
    taken, number = np.empty(BLOCK, np.float32), np.empty(BLOCK, np.float32)
    for start in range(0, n, BLOCK):
        size = min(BLOCK, n - start)
        for k in range(width):
            for i in range(size):
                side[k, i] = logits[start + i, k]
        for i in range(BLOCK):
            sure[i] = 0
        for g in range(len(offsets) - 1):
            for i in range(size):
                rest[i] = uniforms[start + i, g]
            _draw(side, offsets[g], offsets[g + 1], rest, total, taken, number)
            for i in range(BLOCK):
                sure[i] += taken[i] - log(total[i])
            for i in range(size):
                choice[start + i, g] = np.int32(number[i])
        for i in range(size):
            log_probability[start + i] = sure[i]


@lone_fused_njit
def _draw(side, low, high, rest, total, taken, number):
    """Choose one of the options low … high − 1 in each column, according to `rest`, uniform in [0, 1).

    `side` f32[k, BLOCK] contains logits, from which the largest is subtracted in place. `total` receives the
    sum of their exponentials, `taken` the chosen logit and `number` its index from 0; each is f32[BLOCK], so
    that loops can be vectorized.
    """
    zero, one = np.float32(0), np.float32(1)
    for i in range(BLOCK):
        taken[i] = side[low, i]
        total[i] = zero
    for k in range(low + 1, high):
        for i in range(BLOCK):
            a, b = side[k, i], taken[i]
            taken[i] = a if a > b else b
    for k in range(low, high):
        for i in range(BLOCK):
            less = side[k, i] - taken[i]
            side[k, i] = less
            total[i] += exp(less)
    for i in range(BLOCK):
        rest[i] *= total[i]
        taken[i] = side[low, i]
        number[i] = zero
    for k in range(low, high - 1):
        for i in range(BLOCK):
            left, a, b = rest[i] - exp(side[k, i]), side[k + 1, i], taken[i]
            rest[i] = left
            number[i] = number[i] + (one if left >= zero else zero)
            taken[i] = a if left >= zero else b


@fused_njit
def choose_best(logits, offsets, choice):
    """Write the most probable choice in each group for each row; if several are tied, the first of them.

    Parameters
    ----------
    logits : array of float32, shape (n, sum(groups))
    offsets : array of int
        First column of each group, and the end: `brain.offsets`.
    choice : array of int, shape (n, groups)
        Receives the chosen options, counted from 0.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.learning import Brain, choose_best
    >>> choice = np.zeros((1, 2), np.int16)
    >>> logits = np.array([[0.0, 1.0, 5.0, 0.0, 0.0, 0.0]], np.float32)
    >>> choose_best(logits, Brain(3, groups=(2, 4)).offsets, choice)
    >>> choice.tolist()
    [[1, 0]]
    """
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
