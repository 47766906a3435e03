"""A policy network that all members of a species share: the common part of `Brain` and `ModuleBrain`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Split = Callable[..., None]
"""`World.split`: calls kernel(first, last, *arguments) for parts of 0…n, on all threads."""


class PolicyNetwork:
    """A policy and a value computed from the same observations.

    Its outputs are the logits of the categorical groups, with group g's at offsets[g]:offsets[g + 1],
    followed by the mean and log standard deviation of each continuous group.
    """

    n_observations: int
    groups: tuple[int, ...]
    offsets: np.ndarray
    n_numbers: int  # continuous groups
    n_logits: int  # outputs
    memory: int  # number of values kept between decisions
    by_row: bool  # whether rows are independent, bit for bit, so processes can share them
    called: str  # in errors

    def forward(self, observations: np.ndarray, split: Split | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return logits and values; a network with memory starts from empty memory.

        Parameters
        ----------
        observations : array of float32, shape (n, n_observations)
        split : callable, optional
            `world.split`, to use the threads of a world; torch modules ignore it.

        Returns
        -------
        logits : array of float32, shape (n, sum(groups))
        values : array of float32, shape (n,)
        """
        memory = np.zeros((len(observations), self.memory), np.float32)
        return self.recall(observations, memory, split)[:2]

    def recall(
        self, observations: np.ndarray, memory: np.ndarray, split: Split | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the logits, values and next memory f32[n, memory] of organisms with this memory."""
        raise NotImplementedError

    def named(self) -> dict[str, np.ndarray]:
        """Return the weights that learning changes, by name and shaped as in torch; on the CPU they are
        views."""
        raise NotImplementedError

    def state(self) -> dict[str, np.ndarray]:
        """Return a copy of the weights by name; for a torch module, a copy of its parameters and buffers.

        Returns
        -------
        dict of str to array
        """
        return {name: np.array(part, order="C") for name, part in self._parts().items()}

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Set the weights.

        Parameters
        ----------
        state : dict of str to array
            Weights as returned by `state`.

        Raises
        ------
        ValueError
            If a weight is missing, is unknown or has a different shape.
        """
        mine = self._parts()
        if wrong := sorted(set(state) ^ set(mine)):
            raise ValueError(
                f"weights {', '.join(wrong)}: missing or unknown; this {self.called} has {', '.join(mine)}"
            )
        for name, part in mine.items():
            if np.shape(state[name]) != part.shape:
                raise ValueError(
                    f"{name} has shape {np.shape(state[name])}; this {self.called} needs {part.shape}"
                )
        self._set(state)

    def _parts(self) -> dict[str, np.ndarray]:
        """Return the arrays of `state`."""
        return self.named()

    def _set(self, state: dict[str, np.ndarray]) -> None:
        """Load the weights from a valid `state`."""
        for name, part in self.named().items():
            part[...] = state[name]

    def _rows(self, observations: np.ndarray) -> int:
        """Return the number n of observations. Raises ValueError if their shape is wrong."""
        n = len(observations)
        if np.shape(observations) != (n, self.n_observations):
            raise ValueError(
                f"observations have shape {np.shape(observations)}; expected (n, {self.n_observations})"
            )
        return n
