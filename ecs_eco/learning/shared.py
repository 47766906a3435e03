"""One learner for several worlds: each world collects its own rollout, and one update learns from all of
them.

An update therefore never depends on the conditions in a single world (a certain prey density, a certain hour
of the day).
"""

from __future__ import annotations

import numpy as np

from ecs_eco.learning.ppo import Learner
from ecs_eco.learning.rollout import Rollout


class SharedLearner:
    """A learner and the worlds that train it; it learns when all participants have a full rollout."""

    def __init__(self, learner: Learner, worlds: int) -> None:
        self.learner = learner
        self.shares = [Share(self) for _ in range(worlds)]

    def meet(self) -> dict[str, float] | None:
        """Learn if all participants are ready; return the result of `Learner.update`, or None while other
        participants are still collecting."""
        taking = [share for share in self.shares if share.active]
        if any(share.ready is None for share in taking):
            return None
        self.learner.rollout = Rollout.joined([share.ready for share in taking if share.ready is not None])
        for share in taking:
            share.forget()
        return self.learner.fit()


class Share:
    """One world's part of the learner, which its nervous systems use in place of their own learner."""

    def __init__(self, together: SharedLearner) -> None:
        self.together, self.active = together, True
        self.rollout, self._spare = (Rollout.like(together.learner.rollout) for _ in range(2))
        self.ready: Rollout | None = None  # with advantages, waiting for the other participants

    @property
    def full(self) -> bool:
        """Whether the rollout has reached its horizon."""
        return self.rollout.ticks >= self.together.learner.ppo.horizon

    def update(self, rows: np.ndarray, values: np.ndarray) -> dict[str, float] | None:
        """Submit the full rollout; `values` f32[n] estimate the future rewards of living organisms, `rows`
        i64[n]."""
        self.rollout.advantages(rows, values, self.together.learner.ppo.gae_lambda)
        self.ready, self.rollout = self.rollout, self._spare
        self.rollout.clear()
        return self.together.meet()

    def forget(self) -> None:
        """Withdraw the submitted rollout."""
        if self.ready is not None:
            self._spare, self.ready = self.ready, None

    def renew(self, active: bool) -> None:
        """Restart in another world: discard unused transitions, and choose whether it participates from now
        on."""
        self.forget()
        self.rollout.clear()
        self.active = active
