"""The layers of a plain network, as kernels take them: a table i64[layers, 7], a `Layer` per row."""

from __future__ import annotations

from typing import NamedTuple

from ecs_eco.learning.arithmetic import fused_njit


class Layer(NamedTuple):
    """One layer of a plain network: its widths, and the positions of its numbers."""

    inputs: int
    outputs: int
    weights: int  # where its matrix (inputs, outputs) begins in a row of weights; then its bias
    transposed: int  # and in the transposed weights, whose rows are up to a multiple of LANES
    below: int  # where its input begins [numbers per transition]; 0: the observations
    above: int  # where its output begins
    hidden: int  # whether tanh is applied


@fused_njit
def layer_of(layers, i):
    """Return row i of the table."""
    return Layer(
        layers[i, 0], layers[i, 1], layers[i, 2], layers[i, 3], layers[i, 4], layers[i, 5], layers[i, 6]
    )
