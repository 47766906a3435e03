"""The Adam optimizer as kernels."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ecs_eco.compiled.jit import njit

# the compiler may reorder sums here; their order depends only on the number of weights
summing_njit: Any = partial(njit, fastmath={"contract", "reassoc"})


@summing_njit
def adam(weights, gradients, moment_1, moment_2, step, settings):
    """Take one Adam step (Kingma and Ba 2015, algorithm 1) for the sum of the rows of `gradients`; return its
    norm. `settings` contains the learning rate, epsilon, maximum gradient norm and weight decay.

    Weight decay is decoupled from the gradient (Loshchilov and Hutter 2019). If the gradient is not finite,
    nothing changes.
    """
    rate, epsilon, max_norm, decay = settings
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


@summing_njit
def adam_each(weights, gradients, moment_1, moment_2, steps, rates, settings):
    """Take one Adam step for each row of weights f32[k, size], with separate learning rates [k] but otherwise
    shared settings; return the gradient norms f64[k]."""
    norms = np.empty(len(weights))
    for i in range(len(weights)):
        own = (rates[i], *settings)
        norms[i] = adam(weights[i], gradients[i : i + 1], moment_1[i], moment_2[i], steps[i], own)
    return norms
