"""The interface of a policy network, which `Brain` and `ModuleBrain` share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

Split = Callable[..., None]
"""`World.split`: calls kernel(first, last, *arguments) for parts of 0…n, on all threads."""


class PolicyNetwork(Protocol):
    """A policy and a value over the same observations.

    Its outputs are the logits of the categorical groups, group g's at offsets[g]:offsets[g + 1], then mean
    and logarithm of the deviation of each continuous one.
    """

    n_observations: int
    groups: tuple[int, ...]
    offsets: np.ndarray
    n_numbers: int  # continuous groups
    n_logits: int  # outputs
    memory: int  # numbers that it keeps between decisions
    by_row: bool  # whether a row's bits depend on no other row: processes may share the rows

    def forward(self, observations: np.ndarray, split: Split | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return outputs f32[n, n_logits] and values f32[n] of f32[n, n_observations]; a network with a
        memory starts with an empty one."""

    def recall(
        self, observations: np.ndarray, memory: np.ndarray, split: Split | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return outputs, values, and the next memory f32[n, memory], of organisms with this memory."""

    def named(self) -> dict[str, np.ndarray]:
        """Return the weights that learning changes, by name."""

    def state(self) -> dict[str, np.ndarray]:
        """Return a copy of the weights by name."""

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Load the weights of `state()`. Raises ValueError that names missing or unknown weights and wrong
        shapes."""
