"""Statistics of a rollout before an update: advantages, their mean and deviation, and the variance that
values explain."""

from __future__ import annotations

import numpy as np

from ecs_eco.learning.arithmetic import fused_njit


@fused_njit
def fill_advantages(steps, ended, later, gain, discount, gae_lambda):
    """Fill in the advantages (Schulman et al. 2016, eq. 16) of transitions STEP[n] in order of time; after
    each, its row's life continues unless `ended` bool[n].

    `later` and `gain` f32[rows] hold the value and the advantage of each row's next transition: initially the
    bootstrap value and 0.
    """
    for i in range(len(steps) - 1, -1, -1):
        step = steps[i]
        if ended[i]:
            later[step.row], gain[step.row] = 0, 0
        td_error = step.reward + discount * later[step.row] - step.value
        step.advantage = td_error + discount * gae_lambda * gain[step.row]
        later[step.row], gain[step.row] = step.value, step.advantage


@fused_njit
def summarize(steps):
    """Return, of a rollout STEP[n], the mean and the deviation of the advantages, the share of the
    targets' variance that the values explain, and the mean reward; NaN if undefined."""
    n = len(steps)
    mean = target_mean = variance = target_variance = reward = 0.0
    for i in range(n):
        mean += steps[i].advantage
        target_mean += steps[i].advantage + steps[i].value
        reward += steps[i].reward
    mean, target_mean, reward = mean / n, target_mean / n, reward / n
    for i in range(n):
        variance += (steps[i].advantage - mean) ** 2
        target_variance += (steps[i].advantage + steps[i].value - target_mean) ** 2
    explained = 1 - variance / target_variance if target_variance > 0 else np.nan
    return mean, np.sqrt(variance / n), explained, reward
