"""The layers of a plain network as a table for kernels: i64[layers, 7], one `Layer` per row."""

from __future__ import annotations

from typing import NamedTuple

from ecs_eco.learning.arithmetic import fused_njit


class Layer(NamedTuple):
    """One layer of a plain network: its widths, and where its numbers begin."""

    inputs: int
    outputs: int
    weights: int  # start of its matrix (inputs, outputs) in a row of weights; its bias follows
    transposed: int  # start in the transposed weights, whose rows are padded to a multiple of LANES
    below: int  # start of its input [numbers per transition]; 0: the observations
    above: int  # start of its output
    hidden: int  # whether tanh is applied


@fused_njit
def layer_of(layers, i):
    """Return row i of the table."""
    return Layer(
        layers[i, 0], layers[i, 1], layers[i, 2], layers[i, 3], layers[i, 4], layers[i, 5], layers[i, 6]
    )
