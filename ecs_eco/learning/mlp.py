"""The built-in network as a torch module, and a test of whether a module is equivalent to it."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from torch import nn

from ecs_eco.learning.continuous import spreads


class MLP(nn.Module):
    """An actor-critic network of tanh layers as a torch module, with `Brain`'s weight names and shapes.

    Parameters
    ----------
    n_observations : int
    groups : tuple of int
        Number of options of each action group.
    hidden : tuple of int, default (64, 64)
        Number of units in each hidden layer.
    trunk : {"shared", "separate"}
        Whether policy and value share the hidden layers.

    Notes
    -----
    Weights are orthogonal (Saxe et al. 2014). The gain is 0.01 for the policy head, 1 for the value head and
    sqrt(2) elsewhere.

    Examples
    --------
    >>> import torch
    >>> from ecs_eco.learning import MLP
    >>> logits, values = MLP(3, groups=(2, 4)).forward(torch.zeros(5, 3))
    >>> tuple(logits.shape), tuple(values.shape)
    ((5, 6), (5,))
    """

    def __init__(
        self,
        n_observations: int,
        groups: tuple[int, ...],
        hidden: tuple[int, ...] = (64, 64),
        trunk: str = "shared",
    ) -> None:
        super().__init__()
        widths = [n_observations, *hidden]
        shared = trunk == "shared"
        for name in ("trunk",) if shared else ("policy", "value"):
            layers = {str(i): nn.Linear(a, b) for i, (a, b) in enumerate(zip(widths, hidden, strict=False))}
            setattr(self, name, nn.ModuleDict(layers))
        for name, size, gain in (("policy", sum(groups), 0.01), ("value", 1, 1.0)):
            if shared:
                setattr(self, name, nn.ModuleDict())
            tower: Any = getattr(self, name)
            tower["head"] = nn.Linear(widths[-1], size)
            nn.init.orthogonal_(tower["head"].weight, gain)
        of_spreads = torch.zeros(sum(groups), 1, dtype=torch.bool)
        of_spreads[spreads(groups)] = True
        self.register_buffer("_of_spreads", of_spreads, persistent=False)
        self._continuous = bool(of_spreads.any())
        head: Any = self.policy
        with torch.no_grad():
            head["head"].weight.masked_fill_(of_spreads, 0.0)
        for name, parameter in self.named_parameters():
            if name.endswith("bias"):
                nn.init.zeros_(parameter)
            elif "head" not in name:
                nn.init.orthogonal_(parameter, 2**0.5)
        self.hidden, self.shared = tuple(hidden), shared

    def forward(self, observations: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return logits and values.

        Parameters
        ----------
        observations : tensor of float32, shape (n, n_observations)

        Returns
        -------
        logits : tensor of float32, shape (n, sum(groups))
        values : tensor of float32, shape (n,)
        """
        above = [observations]
        for name in ("trunk",) if self.shared else ("policy", "value"):
            h = observations
            for level in range(len(self.hidden)):
                h = torch.tanh(getattr(self, name)[str(level)](h))
            above.append(h)
        policy: Any = self.policy
        value: Any = self.value
        values = value["head"](above[-1])[:, 0]
        if not self._continuous:
            return policy["head"](above[1]), values
        of_spreads: Any = self._of_spreads  # only their biases are learned
        weight = torch.where(of_spreads, policy["head"].weight.detach(), policy["head"].weight)
        return nn.functional.linear(above[1], weight, policy["head"].bias), values


Plain = tuple[tuple[int, ...], str, dict[str, np.ndarray]]
"""A plain network: its hidden layers, its trunk, and its weights in the form that `Brain.state()` returns."""


def plain(module: object, n_observations: int, n_logits: int) -> Plain | None:
    """Return a module's weights if it computes the same as `Brain`, so that kernels can run it; otherwise
    None.

    Such a module is an `MLP`, or a Sequential of Linear and Tanh with n_logits outputs, or one more for the
    value. Raises ValueError if a Sequential has the wrong number of inputs or outputs.
    """
    if (
        type(module) is MLP
        and "forward" not in vars(module)
        and not module._forward_hooks
        and not module._forward_pre_hooks
    ):
        state = {name: tensor.detach().cpu().numpy().copy() for name, tensor in module.state_dict().items()}
        return module.hidden, "shared" if module.shared else "separate", state
    if type(module) is not nn.Sequential or not _alternate(list(module)):
        return None
    return _sequential(list(module)[::2], n_observations, n_logits)


def _alternate(layers: list[nn.Module]) -> bool:
    """Return whether the layers alternate between Linear and Tanh, beginning and ending with Linear."""
    kinds = [type(layer) for layer in layers]
    return len(kinds) > 2 and kinds == [nn.Linear, nn.Tanh] * (len(kinds) // 2) + [nn.Linear]


def _sequential(linear: list[Any], n_observations: int, n_logits: int) -> Plain:
    inputs, outputs = int(linear[0].in_features), int(linear[-1].out_features)
    if inputs != n_observations or outputs not in (n_logits, n_logits + 1):
        raise ValueError(
            f"takes {inputs} observations and gives {outputs} numbers; "
            f"this species has {n_observations} channels, and {n_logits} options to choose from: "
            f"expected {n_logits} outputs, or {n_logits + 1} where the last is the value"
        )
    state: dict[str, np.ndarray] = {}
    for i, layer in enumerate(linear):
        weight = layer.weight.detach().cpu().numpy().astype(np.float32)
        bias = np.zeros(len(weight), np.float32)
        if layer.bias is not None:
            bias = layer.bias.detach().cpu().numpy().astype(np.float32)
        if i < len(linear) - 1:
            state |= {f"trunk.{i}.weight": weight, f"trunk.{i}.bias": bias}
    value = slice(n_logits, n_logits + 1) if outputs > n_logits else slice(0, 1)
    unknown = outputs == n_logits  # the module outputs no values, so they start at 0
    state |= {
        "policy.head.weight": weight[:n_logits],
        "policy.head.bias": bias[:n_logits],
        "value.head.weight": weight[value] * (not unknown),
        "value.head.bias": bias[value] * (not unknown),
    }
    return tuple(int(x.out_features) for x in linear[:-1]), "shared", state


def from_torch(module: nn.Module) -> nn.Module:
    """Check a network that was trained elsewhere, and return it for a world's `policies={"deer": …}`.

    Parameters
    ----------
    module : torch.nn.Sequential
        Alternating Linear and Tanh layers. The last layer has an output for each option of the species'
        action groups, and can have one more for the value.

    Returns
    -------
    torch.nn.Module

    Raises
    ------
    ValueError
        If it has layers of any other kind.

    Examples
    --------
    >>> from torch import nn
    >>> from ecs_eco.learning import from_torch
    >>> network = from_torch(nn.Sequential(nn.Linear(9, 32), nn.Tanh(), nn.Linear(32, 7)))
    """
    if type(module) is not nn.Sequential:
        raise ValueError(
            f"{type(module).__name__}: expected a torch.nn.Sequential of Linear and Tanh, "
            "or `policy.network` for any other"
        )
    layers = list(module)
    if not _alternate(layers):
        raise ValueError(
            f"layers {', '.join(type(x).__name__ for x in layers)}: "
            "expected alternating Linear and Tanh, with Linear at both ends"
        )
    return module
