"""Continuous actions: numbers drawn from normal distributions whose means and standard deviations the network
outputs.

In a network's `groups`, each continuous action appears as `CONTINUOUS`, after all categorical groups. It has
two outputs: the mean, and the natural logarithm of the standard deviation, clipped to LEAST … MOST. Numbers
are measured from the middle of the action's range in units of half its width, so its limits are −1 and 1. If
a number is beyond a limit, the limit is executed, but learning uses the number drawn.

In the built-in network, the log standard deviation is a bias, a single learned number for all observations:
if a whole layer's weights could also change it, it would fall many times faster than the mean improves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ecs_eco.learning.arithmetic import exp, fused_njit, log

LEAST, MOST = np.float32(-5.0), np.float32(2.0)  # limits of the log standard deviation
HALF_LOG_2_PI = np.float32(0.9189385332046727)
TURN = np.float32(2 * np.pi)


class Continuous(int):
    """The size of a continuous action's head, distinguishable from a categorical group with two options."""

    def __repr__(self) -> str:
        return "CONTINUOUS"


CONTINUOUS = Continuous(2)


def laid_out(groups: Sequence[int]) -> tuple[np.ndarray, int]:
    """Return the first output of each categorical group and the end of the last group, i64[G + 1], and the
    number of continuous groups that follow. Raises ValueError if a categorical group follows a continuous
    one."""
    kinds = [isinstance(group, Continuous) for group in groups]
    if kinds != sorted(kinds):
        raise ValueError(f"groups = {tuple(groups)}: continuous ones must come last")
    return np.cumsum((0, *groups[: kinds.count(False)])).astype(np.int64), kinds.count(True)


def spreads(groups: Sequence[int]) -> np.ndarray:
    """Return the indices of the outputs that are log standard deviations: i64[continuous groups]."""
    offsets, n = laid_out(groups)
    return offsets[-1] + 2 * np.arange(n) + 1


def in_units(numbers: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return numbers f32[n, k] as actions between low [k] and high [k], in the actions' units."""
    actions: np.ndarray = (low + high) / 2 + (high - low) / 2 * np.clip(numbers, -1, 1)
    return actions


@fused_njit
def draw_numbers(outputs, uniforms, numbers, log_probability):
    """Draw numbers f32[n, k] from normal distributions given by outputs f32[n, 2 k] (mean, log standard
    deviation); add their log-probabilities to `log_probability` f32[n]. Uniforms f32[n, 2 k] are in [0, 1)
    (Box and Muller 1958)."""
    for i in range(numbers.shape[0]):
        for j in range(numbers.shape[1]):
            radius = np.sqrt(max(np.float32(0), np.float32(-2) * log(np.float32(1) - uniforms[i, 2 * j])))
            z = np.float32(radius * np.cos(TURN * uniforms[i, 2 * j + 1]))
            spread = min(max(outputs[i, 2 * j + 1], LEAST), MOST)
            numbers[i, j] = outputs[i, 2 * j] + exp(spread) * z
            log_probability[i] -= np.float32(0.5) * z * z + spread + HALF_LOG_2_PI
