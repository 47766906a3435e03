"""What nervous systems made of what they sensed in the last tick, for whoever looks on: recordings,
viewers, drawings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.components import Nervous

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Thoughts(NamedTuple):
    """What `Decide` leaves of a tick: who sensed, in the order of `nerves.rows`,
    and what their networks said."""

    tick: int
    uid: np.ndarray  # u64[n]
    logits: np.ndarray | None  # f32[n, options] of the policy; None without one
    y: np.ndarray | None  # i8[n, actions] of the reflex; None without one
    choice: np.ndarray  # i16[n, groups]


class Minds(NamedTuple):
    """The nervous systems of k organisms in the last tick."""

    x: np.ndarray  # f32[k, channels] what they sensed
    y: np.ndarray  # i8[k, actions] −1 blocked, 0 left, 1 forced by the reflex
    p: np.ndarray  # f32[k, actions] probability that the policy gave; NaN where it has no say
    z: np.ndarray  # u8[k, actions] chosen by the policy, or automatic
    decision: np.ndarray  # u8[k, actions] H(y + z)


def thinkers(table: Table, who: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return who lives and sensed in the last tick, as rows i64[k] in the order of uids
    and places i64[k] in `nerves.rows`.

    `who` u64[…] are the uids of those asked for; None: all.
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
    """Return what organisms of a table sensed, weighed and decided: rows and places as `thinkers` gives them.
    """
    nerves = table.species.nerves
    thoughts = nerves.thoughts
    y = (np.zeros((len(at), len(nerves.actions)), np.int8)
         if thoughts.y is None else thoughts.y[at].astype(np.int8))
    p, z = weighed(nerves, None if thoughts.logits is None else thoughts.logits[at], thoughts.choice[at])
    return Minds(nerves.x[at], y, p, z, table[Nervous].decision[rows])


def weighed(nerves: Any, logits: np.ndarray | None, choice: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the probabilities p f32[k, actions] and the choices z u8[k, actions] of logits [k,
    options] and choices [k, groups]."""
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
    """Return the probabilities f64[k, options] of logits f32[k, options]."""
    e = np.exp(logits.astype(np.float64) - logits.max(axis=1, keepdims=True))
    return e / e.sum(axis=1, keepdims=True)
