"""Choose the brain and the learner of a species: the built-in network with its kernels, or any torch
module."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from ecs_eco.learning.brain import Brain
from ecs_eco.learning.continuous import laid_out
from ecs_eco.learning.policy_network import PolicyNetwork
from ecs_eco.learning.settings import PPO

if TYPE_CHECKING:
    from ecs_eco.learning.individual import Individuals
    from ecs_eco.learning.learner import RolloutLearner


def brain_of(
    network: Callable[..., Any] | None,
    n_observations: int,
    groups: tuple[int, ...],
    hidden: tuple[int, ...],
    seed: int,
    device: str = "cpu",
    trunk: str = "shared",
) -> PolicyNetwork:
    """Return a new brain from `network(n_observations, groups)`, or the built-in brain with a `trunk`, which
    does not need torch on the CPU.

    Raises ValueError if the module cannot be a brain or the device does not exist.
    """
    if network is None and device == "cpu":
        return Brain(n_observations, groups, hidden, seed, trunk)
    from ecs_eco.learning.mlp import MLP
    from ecs_eco.learning.module_brain import ModuleBrain, as_brain, made

    if network is not None:
        return as_brain(made(network, n_observations, groups, seed), n_observations, groups, device)
    brain = ModuleBrain(MLP(n_observations, groups, hidden, trunk), n_observations, groups, device)
    brain.load(Brain(n_observations, groups, hidden, seed, trunk).state())
    return brain


def individuals_of(
    network: Callable[..., Any] | None,
    n_observations: int,
    groups: tuple[int, ...],
    hidden: tuple[int, ...],
    ppo: PPO,
    seed: int,
    device: str = "cpu",
) -> Individuals:
    """Return the networks of a species whose members each have their own network: kernels for the built-in
    network with categorical actions, otherwise torch.func."""
    from ecs_eco.learning.individual import Individuals

    if network is None and device == "cpu" and not laid_out(groups)[1]:
        return Individuals(n_observations, groups, hidden, ppo, seed)
    from ecs_eco.learning.individual_modules import IndividualModules
    from ecs_eco.learning.mlp import MLP

    return IndividualModules(
        network or partial(MLP, hidden=hidden), n_observations, groups, ppo, seed, device
    )


def learner_of(brain: PolicyNetwork, ppo: PPO, seed: int, workers: int = 1) -> RolloutLearner:
    """Return the learner for a brain: kernels for a plain network, autograd otherwise; both give the same
    results."""
    if isinstance(brain, Brain):
        from ecs_eco.learning.ppo import Learner

        return Learner(brain, ppo, seed, workers)
    from ecs_eco.learning.torch_ppo import TorchLearner

    return TorchLearner(brain, ppo, seed, workers)
