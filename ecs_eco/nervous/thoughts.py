"""The outputs of nervous systems in the last tick, for recordings, viewers and drawings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.components import Motor, Nervous

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Thoughts(NamedTuple):
    """The results of `Decide` in a tick: the organisms that sensed, in the order of `nerves.rows`, and their
    networks' outputs."""

    tick: int
    uid: np.ndarray  # u64[n]
    logits: np.ndarray | None  # f32[n, options] from the policy; None without one
    y: np.ndarray | None  # i8[n, actions] from the reflex; None without one
    choice: np.ndarray  # i16[n, categorical groups]
    numbers: np.ndarray | None = None  # f32[n, continuous groups] drawn, in units of half the range
    shift: np.ndarray | None = None  # f32[n, continuous groups] added by the reflex


class Minds(NamedTuple):
    """The nervous systems of k organisms in the last tick.

    If a species has continuous actions, y, z and the decision are f32; for these actions they contain, in the
    actions' units, the number added by the reflex, the number drawn by the policy (the resting value without
    a policy), and the number executed.
    """

    x: np.ndarray  # f32[k, channels], their observations
    y: np.ndarray  # i8[k, actions]: −1 blocked, 0 free, 1 forced by the reflex
    p: np.ndarray  # f32[k, actions]: probability under the policy; NaN if it does not choose the action
    z: np.ndarray  # u8[k, actions]: chosen by the policy, or automatic
    decision: np.ndarray  # u8[k, actions]: H(y + z)


def thinkers(table: Table, who: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the living organisms that sensed in the last tick, as rows i64[k] in uid order and positions
    i64[k] in `nerves.rows`.

    `who` u64[…] are the requested uids; None means all.
    """
    nerves = table.species.nerves
    thoughts = None if nerves is None else nerves.thoughts
    if thoughts is None or not len(thoughts.uid):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    there = table.uid[nerves.rows] == thoughts.uid
    at = np.flatnonzero(there if who is None else there & np.isin(thoughts.uid, who))
    at = at[np.argsort(thoughts.uid[at], kind="stable")]
    return nerves.rows[at], at


def minds(table: Table, rows: np.ndarray, at: np.ndarray) -> Minds:
    """Return the observations, network outputs and decisions of organisms in a table, given their rows and
    positions from `thinkers`."""
    nerves = table.species.nerves
    thoughts = nerves.thoughts
    y = (
        np.zeros((len(at), len(nerves.actions)), np.int8)
        if thoughts.y is None
        else thoughts.y[at].astype(np.int8)
    )
    p, z = weighed(nerves, None if thoughts.logits is None else thoughts.logits[at], thoughts.choice[at])
    decision = table[Nervous].decision[rows]
    if len(nerves.ranges):
        y, z, decision = with_numbers(nerves, (y, z, decision), numbers_of(table, rows, at))
    return Minds(nerves.x[at], y, p, z, decision)


def numbers_of(table: Table, rows: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the numbers added to continuous actions by the reflex, chosen by the policy, and executed, each
    f32[k, continuous groups], given rows and positions from `thinkers`."""
    nerves, thoughts = table.species.nerves, table.species.nerves.thoughts
    shape = len(at), len(nerves.ranges)
    shift = np.zeros(shape, np.float32) if thoughts.shift is None else thoughts.shift[at]
    drawn = None if thoughts.numbers is None else thoughts.numbers[at]
    chosen = np.broadcast_to(nerves.ranges.of(table, rows).command(drawn, None), shape)
    return shift, chosen, table[Motor].command[rows] if shape[1] else shift


def with_numbers(
    nerves: Any, matrices: tuple[np.ndarray, ...], numbers: tuple[np.ndarray, ...]
) -> tuple[np.ndarray, ...]:
    """Return matrices [k, actions] as f32, with numbers f32[k, continuous groups] in the columns of
    continuous actions."""
    out = tuple(matrix.astype(np.float32) for matrix in matrices)
    for matrix, values in zip(out, numbers, strict=True):
        matrix[:, nerves.ranges.columns] = values
    return out


def weighed(nerves: Any, logits: np.ndarray | None, choice: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the probabilities p f32[k, actions] and the choices z u8[k, actions] for logits [k, options] and
    choices [k, groups]."""
    k, n = len(choice), len(nerves.actions)
    z = np.repeat(nerves.automatic[None].astype(np.uint8), k, axis=0)
    p = np.full((k, n), np.nan, np.float32)
    if logits is None:
        return p, z
    for g, (first, last) in enumerate(zip(nerves.offsets[:-1], nerves.offsets[1:], strict=True)):
        share = softmax(logits[:, first:last])
        for option, action in enumerate(nerves.targets[first:last]):
            if action >= 0:
                p[:, action] = share[:, option]
                z[:, action] |= (choice[:, g] == option).astype(np.uint8)
    return p, z


def softmax(logits: np.ndarray) -> np.ndarray:
    """Return the probabilities f64[k, options] for logits f32[k, options]."""
    e = arrays.exp(logits.astype(np.float64) - logits.max(axis=1, keepdims=True))
    return e / e.sum(axis=1, keepdims=True)
