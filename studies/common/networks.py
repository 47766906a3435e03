"""Networks that studies bring along, as users write them."""

from __future__ import annotations

import torch
from torch import nn

from ecs_eco.learning import MLP


class ByAutograd(MLP):
    """The built-in network with two trunks, in a class of its own: only autograd trains it."""

    def __init__(self, n_observations: int, groups: tuple[int, ...]) -> None:
        super().__init__(n_observations, groups, (64, 64), "separate")


class Remembering(nn.Module):
    """One layer, a GRU (Cho et al. 2014), and two heads on what it remembers."""

    memory = 64

    def __init__(self, n_observations: int, groups: tuple[int, ...]) -> None:
        super().__init__()
        self.encoder, self.cell = nn.Linear(n_observations, 64), nn.GRUCell(64, self.memory)
        self.policy, self.value = nn.Linear(self.memory, sum(groups)), nn.Linear(self.memory, 1)
        nn.init.orthogonal_(self.policy.weight, 0.01)
        nn.init.zeros_(self.policy.bias)

    def forward(self, observations: torch.Tensor,
                state: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return logits, values and the state that follows."""
        state = self.cell(torch.tanh(self.encoder(observations)), state)
        return self.policy(state), self.value(state)[:, 0], state
