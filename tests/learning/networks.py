"""Networks that tests bring along, as users would write them."""

import torch
from torch import nn


class Plain(nn.Module):
    """The built-in network, written by somebody else: only autograd trains it."""

    def __init__(self, n_observations, groups, hidden=(16, 8)):
        super().__init__()
        widths = [n_observations, *hidden]
        layers = [
            layer for a, b in zip(widths, hidden, strict=False) for layer in (nn.Linear(a, b), nn.Tanh())
        ]
        self.trunk = nn.Sequential(*layers)
        self.policy, self.value = nn.Linear(widths[-1], sum(groups)), nn.Linear(widths[-1], 1)

    def forward(self, observations):
        h = self.trunk(observations)
        return self.policy(h), self.value(h)[:, 0]


class Gru(nn.Module):
    """One that remembers."""

    def __init__(self, n_observations, groups, memory=16):
        super().__init__()
        self.memory = memory
        self.cell = nn.GRUCell(n_observations, memory)
        self.policy, self.value = nn.Linear(memory, sum(groups)), nn.Linear(memory, 1)

    def forward(self, observations, state):
        state = self.cell(observations, state)
        return self.policy(state), self.value(state)[:, 0], state


class Lstm(nn.Module):
    """One that keeps two states of 8 numbers in one row of 16."""

    memory = 16

    def __init__(self, n_observations, groups):
        super().__init__()
        self.cell = nn.LSTMCell(n_observations, 8)
        self.policy, self.value = nn.Linear(8, sum(groups)), nn.Linear(8, 1)

    def forward(self, observations, state):
        hidden, cell = self.cell(observations, (state[:, :8], state[:, 8:]))
        return self.policy(hidden), self.value(hidden)[:, 0], torch.cat([hidden, cell], dim=1)
