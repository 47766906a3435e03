"""What nervous systems made of what they sensed in the last tick, for whoever looks on: recordings, viewers, drawings."""

from typing import Any, NamedTuple

import numpy as np

from ecs_eco.components import Nervous


class Thoughts(NamedTuple):
    """What `Decide` leaves of a tick: who sensed, in the order of `nerves.rows`, and what their networks said."""

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


def thinkers(table: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return who lives and sensed in the last tick, as rows i64[k] in the order of uids and places i64[k] in `nerves.rows`."""
    nerves = table.traits.get("nerves")
    thoughts = None if nerves is None else nerves.thoughts
    if thoughts is None or not len(thoughts.uid):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    at = np.flatnonzero(table.uid[nerves.rows] == thoughts.uid)
    at = at[np.argsort(thoughts.uid[at], kind="stable")]
    return nerves.rows[at], at


def minds(table: Any, rows: np.ndarray, at: np.ndarray) -> Minds:
    """Return what organisms of a table sensed, weighed and decided: rows and places as `thinkers` gives them."""
    nerves, k = table.traits["nerves"], len(at)
    n, thoughts = len(nerves.actions), nerves.thoughts
    y = np.zeros((k, n), np.int8) if thoughts.y is None else thoughts.y[at].astype(np.int8)
    z = np.repeat(nerves.automatic[None].astype(np.uint8), k, axis=0)
    p = np.full((k, n), np.nan, np.float32)
    if thoughts.logits is not None:
        for g, (first, last) in enumerate(zip(nerves.offsets[:-1], nerves.offsets[1:], strict=True)):
            share = softmax(thoughts.logits[at, first:last])
            for option, action in enumerate(nerves.targets[first:last]):
                if action >= 0:
                    p[:, action] = share[:, option]
                    z[:, action] |= (thoughts.choice[at, g] == option).astype(np.uint8)
    return Minds(nerves.x[at].copy(), y, p, z, table[Nervous].decision[rows])


def softmax(logits: np.ndarray) -> np.ndarray:
    """Return the probabilities f64[k, options] of logits f32[k, options]."""
    e = np.exp(logits.astype(np.float64) - logits.max(axis=1, keepdims=True))
    return e / e.sum(axis=1, keepdims=True)
