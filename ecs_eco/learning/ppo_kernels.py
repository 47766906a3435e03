"""The gradient of PPO's loss, for weights that are shared or individual: forward, loss and backward at
once."""

from __future__ import annotations

import numpy as np

from ecs_eco.learning.arithmetic import fused_njit
from ecs_eco.learning.gradient import backward, forward, gather_observations, layout_of, transpose_weights
from ecs_eco.learning.loss import allocate_scratch, gather_transitions, output_gradient, take_terms
from ecs_eco.learning.tiles import ROWS, round_up

BLOCK = 64  # transitions that pass through a shared network at once: their activations stay in the cache


@fused_njit
def loss_gradient(scratch, layout, layers, n, offsets, settings, loss):
    """Write the gradient of the loss over n transitions, which lie in the scratch of the network and in
    that of the loss, by its weights, which are transposed too; add the loss's terms to those of the
    latter."""
    rows = round_up(n, ROWS)
    forward(scratch, layout, layers, rows)
    output_gradient(scratch, layout.deltas, layers, rows, n, offsets, settings, loss)
    backward(scratch, layout, layers, rows, n)


@fused_njit
def shared_gradient(scratch, weights, layers, offsets, log, chosen, settings, share, gradient, terms):
    """Write the gradient f32[size] of the loss over the chosen transitions i64[n], each with the weight
    `share`, and the sums of its terms, f64[5].

    `scratch`, initially zeros, is for this network only, see `scratch_for`; `log` has a rollout's
    observations, choices, numbers and steps. The gradient of each block is summed separately.
    """
    observations, choices, numbers, steps = log
    layout, loss = layout_of(layers, BLOCK), allocate_scratch(offsets, numbers.shape[1], BLOCK)
    for i in range(len(weights)):
        scratch[np.uint64(layout.weights + i)] = weights[i]
        gradient[i] = 0
    transpose_weights(scratch, layout, layers)
    for start in range(0, len(chosen), BLOCK):
        here = chosen[start : start + BLOCK]
        gather_observations(observations, here, scratch)
        gather_transitions(loss, steps, choices, numbers, offsets, here, share)
        loss_gradient(scratch, layout, layers, len(here), offsets, settings, loss)
        for i in range(len(gradient)):
            gradient[i] += scratch[np.uint64(layout.gradient + i)]
    take_terms(loss, terms)


def scratch_for(layers: np.ndarray) -> np.ndarray:
    """Return the scratch of `shared_gradient`."""
    return np.zeros(layout_of(layers, BLOCK).end, np.float32)
