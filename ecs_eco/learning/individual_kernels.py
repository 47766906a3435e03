"""Kernels for animals that each have their own network: newborns' weights, recording of transitions, PPO
updates.

Columns are in blocks (see `Blocked.by_address`); animal j of the arguments is row `rows[j]` of the table.
Each animal's numbers are summed in an order that depends only on that animal's rollout.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.vectors import LANES, load, prefetch, store
from ecs_eco.engine.blocks import BLOCK, block_of, flat_block_of, prefetch_row
from ecs_eco.engine.random import draw, mix
from ecs_eco.learning.adam import adam
from ecs_eco.learning.arithmetic import fused_njit
from ecs_eco.learning.gradient import Layout, gather_observations, layout_of, loss_gradient, transpose_weights
from ecs_eco.learning.loss import (
    LOSS_TERMS,
    LossScratch,
    LossSettings,
    allocate_scratch,
    gather_transitions,
    take_terms,
)
from ecs_eco.learning.rollout import STEP, fill_advantages, summarize

TERMS = (*LOSS_TERMS, "gradient_norm", "explained_variance", "reward")
AHEAD = 8  # number of animals recorded while a later animal's data is fetched
_BIRTH = 1 << 32  # first `purpose` number of the draws for newborns' weights


class Hyperparameters(NamedTuple):
    """The hyperparameters of one animal, which are fields of PPO."""

    learning_rate: np.float32
    discount: np.float32
    entropy_coef: np.float32
    gae_lambda: np.float32
    clip: np.float32
    clip_value: np.float32
    value_weight: np.float32
    adam_epsilon: np.float64
    max_grad_norm: np.float64
    weight_decay: np.float64
    epochs: np.int64
    minibatch_size: np.int64
    normalise_advantage: np.bool_


class Workspace(NamedTuple):
    """The memory that one thread needs to train an animal."""

    network: np.ndarray  # f32[…], see `gradient.Layout`
    layout: Layout
    loss: LossScratch
    steps: np.ndarray  # STEP[horizon]: the transitions of an animal
    numbers: np.ndarray  # f32[horizon, 0]: there are no continuous actions
    order: np.ndarray  # i64[horizon]


@fused_njit
def draw_newborn(key, who, deviations, weights):
    """Draw weights f32[k, size] from normal distributions (Box and Muller 1958) with these standard
    deviations."""
    for j in range(len(who)):
        for i in range(len(deviations)):
            weights[j, i] = 0
            if deviations[i] > 0:
                length = math.sqrt(-2 * math.log(1 - np.float64(draw(key, who[j], _BIRTH + 2 * i))))
                angle = 2 * math.pi * np.float64(draw(key, who[j], _BIRTH + 2 * i + 1))
                weights[j, i] = deviations[i] * np.float32(length * math.cos(angle))


@fused_njit
def record(observations, choices, returns, length, rows, x, choice, log_probability, value):
    """Append a transition to each animal's rollout; return how many rollouts were full. `returns` contains
    the columns of log-probabilities, values and rewards."""
    log_probabilities, values, rewards = returns
    full, horizon = 0, rewards[1].shape[1]
    for j in range(len(rows)):
        _prefetch_place(
            rows[min(j + AHEAD, len(rows) - 1)], length, observations, choices, log_probabilities, values
        )
        row, at = rows[j], rows[j] % BLOCK
        t = length[row]
        if not 0 <= t < horizon:
            full += 1
            continue
        seen, taken = block_of(row, observations), block_of(row, choices)
        for i in range(x.shape[1]):
            seen[at, t, i] = x[j, i]
        for g in range(choice.shape[1]):
            taken[at, t, g] = choice[j, g]
        block_of(row, log_probabilities)[at, t] = log_probability[j]
        block_of(row, values)[at, t], block_of(row, rewards)[at, t] = value[j], 0
        length[row] = t + 1
    return full


@fused_njit
def _prefetch_place(row, length, observations, choices, log_probabilities, values):
    """Prefetch the memory for an animal's next transition."""
    place, c = row % BLOCK * values[1].shape[1] + length[row], observations[1].shape[2]
    for k in range(0, c, LANES):
        prefetch(flat_block_of(row, observations), place * c + k)
    prefetch(flat_block_of(row, choices), place * choices[1].shape[2])
    prefetch(flat_block_of(row, log_probabilities), place)
    prefetch(flat_block_of(row, values), place)


@fused_njit
def credit(rewards, rows, length, reward):
    """Add the reward f32[n] to each animal's last transition, if it has one."""
    for j in range(len(rows)):
        t = length[rows[j]] - 1
        if 0 <= t < rewards[1].shape[1]:
            block_of(rows[j], rewards)[rows[j] % BLOCK, t] += reward[j]


@fused_njit
def full_rollouts(length, rows, uid, born, tick, horizon, due):
    """Write to `due` which rollouts are complete: either full, or an animal's first rollout, which ends at an
    age drawn from the uid."""
    for i in range(len(rows)):
        n = length[rows[i]]
        due[i] = n >= horizon or (n > 0 and np.uint64(tick - born[i]) == mix(uid[i]) % np.uint64(horizon))


@fused_njit
def train(
    first,
    last,
    networks,
    counters,
    observations,
    choices,
    returns,
    rows,
    uid,
    bootstrap,
    settings,
    seed,
    layers,
    offsets,
    report,
):
    """Train animals first … last − 1 on their rollouts and empty them; `report` f64[n, TERMS] receives the
    means over each animal's steps.

    `networks` contains the columns of weights and both moments, `counters` the columns of steps, updates and
    rollout lengths, `returns` the columns of log-probabilities, values and rewards. `bootstrap` f32[n] are
    the values of the current states; `settings` is f64[n, Hyperparameters]. With a learning rate of 0,
    nothing changes.
    """
    steps, updates, length = counters
    horizon = returns[0][1].shape[1]
    work = _workspace(layers, offsets, horizon)
    ended, later, gain = np.zeros(horizon, np.bool_), np.empty(1, np.float32), np.empty(1, np.float32)
    for j in range(first, last):
        row, own, terms = rows[j], _hyperparameters(settings, j), report[j]
        n = max(0, min(length[row], horizon))
        length[row] = 0
        if n == 0 or own.learning_rate == 0:
            continue
        lived = work.steps[:n]
        _read_transitions(row, returns, lived)
        later[0], gain[0] = bootstrap[j], 0
        fill_advantages(lived, ended, later, gain, own.discount, own.gae_lambda)
        shift, scale, terms[6], terms[7] = summarize(lived, own.normalise_advantage)
        loss = LossSettings(
            own.clip, own.clip_value, own.entropy_coef, own.value_weight, np.float32(shift), np.float32(scale)
        )
        if j + 1 < last:  # fetch the next animal's data while this one learns
            for column in networks:
                prefetch_row(rows[j + 1], column)
            prefetch_row(rows[j + 1], observations)
        key = mix(mix(seed ^ uid[j]) + np.uint64(updates[row]))
        updates[row] += 1
        _fit(row, n, networks, steps, observations, choices, work, layers, offsets, own, loss, key, terms)


@fused_njit
def _hyperparameters(settings, j):
    """Return row j of the settings."""
    return Hyperparameters(
        np.float32(settings[j, 0]),
        np.float32(settings[j, 1]),
        np.float32(settings[j, 2]),
        np.float32(settings[j, 3]),
        np.float32(settings[j, 4]),
        np.float32(settings[j, 5]),
        np.float32(settings[j, 6]),
        settings[j, 7],
        settings[j, 8],
        settings[j, 9],
        np.int64(settings[j, 10]),
        np.int64(settings[j, 11]),
        settings[j, 12] != 0,
    )


@fused_njit
def _workspace(layers, offsets, horizon):
    """Return the memory for one animal's rollout, all of whose steps belong to one row."""
    layout = layout_of(layers, horizon)
    return Workspace(
        np.zeros(layout.end, np.float32),
        layout,
        allocate_scratch(offsets, 0, horizon),
        np.zeros(horizon, STEP),
        np.empty((horizon, 0), np.float32),
        np.empty(horizon, np.int64),
    )


@fused_njit
def _read_transitions(row, returns, steps):
    """Copy the transitions of an animal."""
    at = row % BLOCK
    log_probability = block_of(row, returns[0])[at]
    value, reward = block_of(row, returns[1])[at], block_of(row, returns[2])[at]
    for t in range(len(steps)):
        steps[t].log_probability, steps[t].value, steps[t].reward = log_probability[t], value[t], reward[t]


@fused_njit
def _fit(row, n, networks, steps, observations, choices, work, layers, offsets, own, loss, key, terms):
    """Perform an animal's Adam steps, and write the means of the loss terms over these steps."""
    at, size, layout = row % BLOCK, networks[0][1].shape[1], work.layout
    kept = block_of(row, networks[0])[at]
    moment_1, moment_2 = block_of(row, networks[1])[at], block_of(row, networks[2])[at]
    seen, taken = block_of(row, observations)[at], block_of(row, choices)[at]
    weights = work.network[layout.weights : layout.weights + size]
    gradient = work.network[layout.gradient : layout.gradient + size].reshape(1, size)
    for i in range(0, size, LANES):
        store(work.network, layout.weights + i, load(kept, i))
    order = work.order[:n]
    for i in range(n):
        order[i] = i
    settings = own.learning_rate, own.adam_epsilon, own.max_grad_norm, own.weight_decay
    epochs, parts = own.epochs, max(1, (n + own.minibatch_size - 1) // own.minibatch_size)
    for epoch in range(epochs):
        if parts > 1:
            _shuffle(order, key + np.uint64(epoch))
        for part in range(parts):
            chosen = order[n * part // parts : n * (part + 1) // parts]
            if parts > 1 or epoch == 0:
                gather_observations(seen, chosen, work.network)
                share = np.float32(1 / len(chosen))
                gather_transitions(work.loss, work.steps, taken, work.numbers, offsets, chosen, share)
            transpose_weights(work.network, layout, layers)
            loss_gradient(work.network, layout, layers, len(chosen), offsets, loss, work.loss)
            steps[row] += 1
            terms[5] += adam(weights, gradient, moment_1, moment_2, steps[row], settings)
    for i in range(size):  # a slice copy would check each number for overlap
        kept[np.uint64(i)] = weights[np.uint64(i)]
    take_terms(work.loss, terms)
    for term in range(6):
        terms[term] /= epochs * parts


@fused_njit
def _shuffle(index, key):
    """Shuffle the numbers (Durstenfeld 1964)."""
    for i in range(len(index) - 1, 0, -1):
        other = np.int64(mix(mix(key) + np.uint64(i)) % np.uint64(i + 1))
        index[i], index[other] = index[other], index[i]
