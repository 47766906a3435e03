"""Custom networks for studies, written as a user would write them."""

from __future__ import annotations

import torch
from torch import nn

from ecs_eco.learning import MLP


class ByAutograd(MLP):
    """The built-in two-trunk network as a custom class, which only autograd can train."""

    def __init__(self, n_observations: int, groups: tuple[int, ...]) -> None:
        super().__init__(n_observations, groups, (64, 64), "separate")


class Plain(nn.Module):
    """The built-in network as a torch user would write it: two layers of 64 tanh units and two heads."""

    def __init__(self, n_observations: int, groups: tuple[int, ...]) -> None:
        super().__init__()
        self.trunk = nn.Sequential(
            _layer(n_observations, 64, 2**0.5), nn.Tanh(), _layer(64, 64, 2**0.5), nn.Tanh()
        )
        self.policy, self.value = _layer(64, sum(groups), 0.01), _layer(64, 1, 1.0)

    def forward(self, observations: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return logits and values."""
        features = self.trunk(observations)
        return self.policy(features), self.value(features)[:, 0]


class Remembering(nn.Module):
    """One GRU (Cho et al. 2014) for the policy and one for the value, each followed by a layer and a head; in
    a shared GRU, learning the value would overwrite what the policy needs."""

    memory = 128

    def __init__(self, n_observations: int, groups: tuple[int, ...]) -> None:
        super().__init__()
        half = self.memory // 2
        self.policy_cell, self.value_cell = nn.GRUCell(n_observations, half), nn.GRUCell(n_observations, half)
        self.policy = nn.Sequential(_layer(half, 64, 2**0.5), nn.Tanh(), _layer(64, sum(groups), 0.01))
        self.value = nn.Sequential(_layer(half, 64, 2**0.5), nn.Tanh(), _layer(64, 1, 1.0))

    def forward(
        self, observations: torch.Tensor, state: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return logits, values and the next state."""
        for_policy, for_value = state.chunk(2, dim=1)
        for_policy = self.policy_cell(observations, for_policy)
        for_value = self.value_cell(observations, for_value)
        return (
            self.policy(for_policy),
            self.value(for_value)[:, 0],
            torch.cat([for_policy, for_value], dim=1),
        )


def _layer(n_in: int, n_out: int, gain: float) -> nn.Linear:
    """Return an orthogonally initialized layer (Saxe et al. 2014) with zero bias."""
    layer = nn.Linear(n_in, n_out)
    nn.init.orthogonal_(layer.weight, gain)
    nn.init.zeros_(layer.bias)
    return layer
