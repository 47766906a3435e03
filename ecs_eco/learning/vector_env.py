"""PPO on plain Gymnasium vector environments: environments are the rows of the rollout, and episodes are
lives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.workers import Workers
from ecs_eco.learning import weights
from ecs_eco.learning.brains import brain_of, learner_of
from ecs_eco.learning.choice import choose, choose_best
from ecs_eco.learning.continuous import draw_numbers
from ecs_eco.learning.policy_network import PolicyNetwork
from ecs_eco.learning.settings import PPO
from ecs_eco.learning.spaces import Actions, Observations, as_vector, resets_in_same_step

if TYPE_CHECKING:
    from gymnasium import Env
    from gymnasium.vector import VectorEnv
    from numpy.typing import ArrayLike


@dataclass
class Training:
    """The result of `train`: the network, and the history of its training.

    Attributes
    ----------
    brain : PolicyNetwork
    returns : list of float
        Return of each finished episode.
    steps : list of int
        Total number of steps in all environments at the end of each episode.
    reports : list of dict
        Losses, entropy and more for each update.

    Examples
    --------
    >>> import gymnasium
    >>> from ecs_eco.learning import PPO, train
    >>> envs = gymnasium.make_vec("CartPole-v1", num_envs=4)
    >>> training = train(envs, PPO(horizon=32), total_steps=512, seed=1)
    >>> training.predict([0.0, 0.0, 0.1, 0.0]) in (0, 1)
    True
    >>> training.load(training.save("cartpole.safetensors"))
    >>> training.steps_to(1e9) is None
    True
    """

    brain: PolicyNetwork
    returns: list[float] = field(default_factory=list)
    steps: list[int] = field(default_factory=list)
    reports: list[dict[str, float]] = field(default_factory=list)  # of each update
    observations: Observations | None = None  # in the form that the brain uses
    actions: Actions | None = None

    def predict(self, observations: ArrayLike) -> np.ndarray:
        """Return the most probable action for each observation, in the form that the environment expects.

        Parameters
        ----------
        observations : array
            One observation, or n observations.

        Returns
        -------
        array
            One action, or n actions. A network with memory decides as it would at birth.
        """
        assert self.observations is not None
        assert self.actions is not None
        seen = np.asarray(observations)
        alone = seen.ndim == len(self.observations.shape)
        decided = act(self.brain, self.observations.rows(seen[None] if alone else seen))
        sent = self.actions.sent(decided, decided)
        return sent[0] if alone else sent

    def save(self, path: str | Path) -> Path:
        """Atomically write the weights to a safetensors file.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Path

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        return weights.save(path, self.brain.state())

    def load(self, path: str | Path) -> None:
        """Read weights written by `save`.

        Parameters
        ----------
        path : str or Path

        Raises
        ------
        ValueError
            If they are damaged or belong to a different network.
        """
        self.brain.load(weights.load(path))

    def finish(self, score: np.ndarray, over: np.ndarray, step: int) -> None:
        """Record the returns f64[n] of the episodes that are `over`, bool[n], and reset them to 0."""
        self.returns += score[over].tolist()
        self.steps += [step] * int(over.sum())
        score[over] = 0

    def steps_to(self, threshold: float, episodes: int = 100) -> int | None:
        """Return the step at which the mean return over the last episodes first reached a threshold.

        Parameters
        ----------
        threshold : float
        episodes : int, default 100

        Returns
        -------
        int or None
            Total number of steps in all environments; None if it was not reached.
        """
        if len(self.returns) < episodes:
            return None
        sums = np.cumsum([0.0, *self.returns])
        reached = np.flatnonzero((sums[episodes:] - sums[:-episodes]) / episodes >= threshold)
        return self.steps[int(reached[0]) + episodes - 1] if len(reached) else None


def train(
    envs: VectorEnv | Env,
    ppo: PPO,
    total_steps: int,
    seed: int,
    hidden: tuple[int, ...] = (64, 64),
    trunk: str = "separate",
    workers: int = 1,
    stop: Callable[[Training], bool] | None = None,
    network: Callable[..., Any] | None = None,
    device: str = "cpu",
) -> Training:
    """Train a new network on Gymnasium environments with PPO.

    Parameters
    ----------
    envs : gymnasium.vector.VectorEnv or gymnasium.Env
        Actions can be Discrete, MultiDiscrete, or a bounded Box with one axis, whose numbers are continuous
        groups. Observations can be arrays, or integers, which are one-hot encoded.
    ppo : PPO
        Hyperparameters.
    total_steps : int
        Total number of steps in all environments.
    seed : int
        Fixes every random draw.
    hidden : tuple of int, default (64, 64)
        Number of units in each hidden layer of the built-in network.
    trunk : {"separate", "shared"}
        Whether policy and value share the hidden layers.
    workers : int, default 1
        Number of threads, which affects speed, never results.
    stop : callable, optional
        Called as `stop(training)` after each update; training ends if it returns true.
    network : callable, optional
        `network(n_observations, groups)` returns a torch module; default: the built-in network.
    device : str, default "cpu"
        "cpu" or "cuda"; for torch modules.

    Returns
    -------
    Training

    Raises
    ------
    ValueError
        If a space is not supported.

    Notes
    -----
    PPO follows Schulman et al. (2017), and the advantages follow Schulman et al. (2016). A time limit is not
    treated as termination: the value of the final observation estimates the return that would have followed.
    Steps that only reset an environment also count.

    Examples
    --------
    >>> import gymnasium
    >>> from ecs_eco.learning import PPO, train
    >>> training = train(gymnasium.make_vec("CartPole-v1", num_envs=4), PPO(horizon=32), 512, seed=1)
    >>> len(training.reports)
    3
    """
    envs = as_vector(envs)
    actions, observations, resets_itself = Actions.of(envs), Observations.of(envs), resets_in_same_step(envs)
    seen = observations.rows(envs.reset(seed=seed)[0])
    brain = brain_of(network, seen.shape[1], actions.groups, hidden, seed, device, trunk)
    learner = learner_of(brain, ppo, seed, workers)
    training = Training(brain, observations=observations, actions=actions)
    rollout, n, split = learner.rollout, envs.num_envs, Workers(workers).split
    memory = np.zeros((n, brain.memory), np.float32)
    generator = np.random.Generator(np.random.Philox(key=[seed, 2**63]))
    choice, log_probability = np.empty((n, len(brain.offsets) - 1), np.int16), np.empty(n, np.float32)
    numbers = np.empty((n, brain.n_numbers), np.float32)
    score, over, everyone = np.zeros(n), np.zeros(n, bool), np.arange(n)
    for step in range(-(-total_steps // n)):
        logits, values, later = brain.recall(seen, memory, split)
        if learner.full:
            training.reports.append(learner.update(everyone[~over], values[~over]) or {})
            if stop and stop(training):
                break
            logits, values, later = brain.recall(seen, memory, split)
        _decide(brain, logits, generator, choice, numbers, log_probability)
        resetting = over  # in this step, environments only reset and ignore the action
        live = everyone[~resetting]
        rollout.store(
            live,
            seen[live],
            choice[live],
            log_probability[live],
            values[live],
            memory[live] if brain.memory else None,
            numbers[live],
        )
        observed, rewards, dead, late, info = envs.step(actions.sent(choice, numbers))
        seen, rewards = observations.rows(observed), np.asarray(rewards, np.float32)
        score[live] += rewards[live]
        over = (dead | late) & ~over
        rollout.credit(everyone[live][~over[live]], rewards[live][~over[live]])
        rollout.end(everyone[over & dead], rewards[over & dead])
        if len(cut := everyone[over & ~dead]):
            final = (
                observations.rows(np.stack([info["final_obs"][i] for i in cut]))
                if resets_itself
                else seen[cut]
            )
            rollout.cut(cut, rewards[cut], brain.recall(final, later[cut])[1])
        memory = later
        memory[over | resetting] = 0
        training.finish(score, over, (step + 1) * n)
        over &= not resets_itself
    return training


def _decide(
    brain: PolicyNetwork,
    logits: np.ndarray,
    generator: np.random.Generator,
    choice: np.ndarray,
    numbers: np.ndarray,
    log_probability: np.ndarray,
) -> None:
    """Draw choices int[n, G], numbers f32[n, K] and their log-probability f32[n]."""
    choose(logits, brain.offsets, generator.random(choice.shape, dtype=np.float32), choice, log_probability)
    if numbers.shape[1]:
        chance = generator.random((len(numbers), 2 * numbers.shape[1]), dtype=np.float32)
        draw_numbers(logits[:, brain.offsets[-1] :], chance, numbers, log_probability)


def act(brain: PolicyNetwork, observations: np.ndarray) -> np.ndarray:
    """Return the most probable choices int[n, G], counted from 0; a brain with memory decides as it would at
    birth.

    For a brain with only continuous groups, return their means f32[n, K]; −1 and 1 are the limits of their
    ranges. Raises ValueError if a brain has both kinds.
    """
    logits, _ = brain.forward(np.asarray(observations, np.float32).reshape(len(observations), -1))
    if brain.n_numbers:
        if len(brain.offsets) > 1:
            raise ValueError(f"groups = {brain.groups}: expected only choices, or only continuous actions")
        return np.clip(logits[:, ::2], -1, 1)
    choice = np.empty((len(logits), len(brain.groups)), np.int64)
    choose_best(logits, brain.offsets, choice)
    return choice
