"""A brain for every animal, with its own weights, Adam moments and hyperparameters, that learns from that
animal's experience.

Weights and rollouts are columns of the animals' table, in blocks of rows (components Policy and Experience),
so a brain is created and freed with its animal. The loss is the same as in ppo.py; the kernels are in
individual_kernels.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.learning import individual_kernels as kernels
from ecs_eco.learning.brain import PlainNetwork
from ecs_eco.learning.inference import infer_individual
from ecs_eco.learning.policy_network import PolicyNetwork, Split
from ecs_eco.learning.settings import PPO
from ecs_eco.space.one_band import OneBand

if TYPE_CHECKING:
    from ecs_eco.engine.blocks import Blocked
    from ecs_eco.engine.schema import Columns

WEIGHTS = 170  # weights processed (forward and backward in learning) in 30 ns, the unit of `split`'s `work`


class Animals(NamedTuple):
    """The k animals that learn."""

    rows: np.ndarray  # i64[k], in their table
    uid: np.ndarray  # u64[k]
    bootstrap: np.ndarray  # f32[k]: the values of their current states
    settings: np.ndarray  # f64[k, Hyperparameters]
    report: np.ndarray  # f64[k, TERMS], written while they learn
    memory: np.ndarray  # f32[k, memory] at the beginning of their rollouts
    numbers: np.ndarray  # f32[k, horizon, continuous groups]: draws

    def part(self, which: slice | np.ndarray) -> Animals:
        """Return a subset of the animals."""
        return Animals(*(array[which] for array in self))


class Individuals(PlainNetwork):
    """The networks of all individuals of a species, and PPO for each of them.

    Each has a trunk of tanh layers, shared by the policy head and the value head. An animal's decisions and
    learning are bit-identical regardless of its row, the other animals and the number of threads. A world file
    selects it with `policy.kind = "individual"`.

    Parameters
    ----------
    n_observations : int
    groups : tuple of int
        Number of options of each categorical group, then `CONTINUOUS` for each continuous one.
    hidden : tuple of int
        Number of units in each hidden layer.
    ppo : PPO
    seed : int
        Random seed for the initial weights and the order of minibatches.
    """

    def __init__(
        self, n_observations: int, groups: tuple[int, ...], hidden: tuple[int, ...], ppo: PPO, seed: int
    ) -> None:
        super().__init__(n_observations, groups, hidden)
        self.ppo, self.seed = ppo, seed
        self.bands = OneBand()  # the processes that share the work
        self.dims = {
            "weights": self.size,
            "horizon": ppo.horizon,
            "channels": n_observations,
            "groups": len(groups),
        }

    def reset(self, ppo: PPO) -> None:
        """Replace the hyperparameters; the horizon must stay the same."""
        self.ppo = ppo

    def flat(self, brain: PolicyNetwork) -> np.ndarray:
        """Return a shared brain's weights in the order that individuals use: f32[size]."""
        weights, named = np.empty(self.size, np.float32), brain.named()
        for name, part in self.named_views(weights).items():
            part[...] = named[name]
        return weights

    def draw(self, who: np.ndarray, key: int | np.uint64) -> np.ndarray:
        """Return random networks f32[k, size] for newborns, determined by the key and `who` u64[k].

        Weights are normally distributed with standard deviation gain / sqrt(inputs); the gain is 0.01 for the
        logits, 1 for the value and sqrt(2) elsewhere. Biases are zero.
        """
        deviations = np.zeros(self.size, np.float32)
        for matrix in self.views(deviations)[::2]:
            matrix[...] = np.sqrt(2 / matrix.shape[0])
        matrix[:, :-1], matrix[:, -1] = 0.01 / np.sqrt(matrix.shape[0]), 1 / np.sqrt(matrix.shape[0])
        weights = np.empty((len(who), self.size), np.float32)
        kernels.draw_newborn(np.uint64(key), np.asarray(who, np.uint64), deviations, weights)
        return weights

    def prune(self, weights: np.ndarray, units: np.ndarray, layer: int) -> None:
        """Keep only the first `units` i64[k] units of a hidden layer in each network of weights f32[k, size].

        All weights to and from the other units become 0 and stay 0, because no gradient reaches them.
        """
        missing = np.arange(self.hidden[layer]) >= units[:, None]
        into, bias, out = self.views(weights)[2 * layer : 2 * layer + 3]
        into[np.broadcast_to(missing[:, None], into.shape)] = 0
        bias[missing] = 0
        out[missing] = 0

    def complete(self, weights: np.ndarray, fresh: np.ndarray) -> None:
        """Fill in the missing hidden units (all weights 0) of networks f32[k, size] from `fresh` ones."""
        for layer in range(len(self.hidden)):
            into, bias, out = self.views(weights)[2 * layer : 2 * layer + 3]
            lacking = ~(into.any(axis=1) | (bias != 0) | out.any(axis=2))
            given = self.views(fresh)[2 * layer : 2 * layer + 3]
            into[:] = np.where(lacking[:, None], given[0], into)
            bias[:] = np.where(lacking, given[1], bias)
            out[:] = np.where(lacking[:, :, None], given[2], out)

    def forward(
        self, policy: Columns, rows: np.ndarray, x: np.ndarray, split: Split
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the logits f32[n, n_logits] and values f32[n] of animals in `rows` i64[n] with observations
        f32[n, c]."""
        n = len(rows)
        if x.shape != (n, self.n_observations):
            raise ValueError(f"observations have shape {x.shape}; expected {(n, self.n_observations)}")
        x = np.ascontiguousarray(x, np.float32)
        logits, values = np.empty((n, self.n_logits), np.float32), np.empty(n, np.float32)
        if n:
            arguments = rows, policy.weights.by_address(), self.layers, x, logits, values
            split(infer_individual, n, *arguments, work=n * self.size // WEIGHTS)
        return logits, values

    def store(
        self,
        experience: Columns,
        rows: np.ndarray,
        x: np.ndarray,
        choice: np.ndarray,
        log_probability: np.ndarray,
        values: np.ndarray,
    ) -> None:
        """Append a transition to the rollout of each row i64[n]: `x` f32[n, c], `choice` int[n, groups],
        all other arguments f32[n].

        Raises ValueError if a rollout is full: `learn` empties it.
        """
        if not len(rows):
            return
        x, columns = np.ascontiguousarray(x, np.float32), _rollouts(experience)
        full = kernels.record(*columns, experience.length, rows, x, choice, log_probability, values)
        if full:
            horizon = self.ppo.horizon
            raise ValueError(
                f"{full} of {len(rows)} rollouts already have {horizon} transitions: "
                "call `learn` for those that are `due` first"
            )

    def credit(self, experience: Columns, rows: np.ndarray, reward: np.ndarray) -> None:
        """Add rewards f32[n] to the last transition of each row; rows without one (newborns) are skipped."""
        if len(rows):
            kernels.credit(experience.reward.by_address(), rows, experience.length, reward)

    def due(
        self, experience: Columns, rows: np.ndarray, uid: np.ndarray, born: np.ndarray, tick: int
    ) -> np.ndarray:
        """Return which animals' rollouts are complete: bool[n]. An animal's first rollout ends at an age
        drawn from the uid; later ones end when they are full. About 1 / horizon of the animals therefore
        learn in each tick, even if all were born in the same tick.
        """
        due = np.empty(len(rows), np.bool_)
        kernels.full_rollouts(experience.length, rows, uid, born, tick, self.ppo.horizon, due)
        return due

    def learn(
        self,
        policy: Columns,
        experience: Columns,
        rows: np.ndarray,
        uid: np.ndarray,
        bootstrap: np.ndarray,
        plasticity: tuple[Any, Any, Any] | None,
        split: Split,
        own: Mapping[str, np.ndarray] | None = None,
        memory: np.ndarray | None = None,
        numbers: np.ndarray | None = None,
    ) -> dict[str, float]:
        """Train the animals in `rows` i64[n] on their rollouts, then empty the rollouts; `bootstrap` f32[n]
        are the values of the animals' current states.

        `plasticity` contains their learning rates, discounts and entropy coefficients, each f32[n] or a
        number shared by all animals; None: use `ppo`. `own` contains other hyperparameters by name, [n] each
        (built-in network only). `memory` f32[n, memory] is their memory at the beginning of their rollouts,
        `numbers` f32[n, horizon, n_numbers] their draws for continuous actions. An animal with a learning
        rate of 0 discards its rollout and does not change. Returns means over the animals that learned, named
        as in `Learner.update`, and their number, n_animals. Raises FloatingPointError if a gradient is not
        finite."""
        n = len(rows)
        settings = self._settings(n, plasticity, own or {})
        rates, lengths = setting_of(settings, "learning_rate"), experience.length[rows]
        report = np.zeros((n, len(kernels.TERMS)))
        memory = np.zeros((n, self.memory), np.float32) if memory is None else memory
        numbers = np.zeros((n, self.ppo.horizon, 0), np.float32) if numbers is None else numbers
        bootstrap = np.ascontiguousarray(bootstrap, np.float32)
        animals = Animals(rows, uid, bootstrap, settings, report, memory, numbers)
        first, last = self.bands.part(n) if self.by_row else (0, n)
        if last > first:
            self._train(policy, experience, animals.part(slice(first, last)), split)
        if self.by_row and self.bands.size > 1:
            self._tell(policy, rows, report)
        experience.length[rows] = 0
        learnt = (rates != 0) & (lengths > 0)
        require_finite(report, uid)
        told = report, lengths, rates
        if np.count_nonzero(learnt) < n:
            told = report[learnt], lengths[learnt], rates[learnt]
        return summary(*(self.bands.learnt(self, *told) if self.by_row else told))

    def _train(self, policy: Columns, experience: Columns, animals: Animals, split: Split) -> None:
        """Perform the animals' Adam steps, and write their reports."""
        epochs = setting_of(animals.settings, "epochs")
        split(
            kernels.train,
            len(animals.rows),
            _addresses(policy.weights, policy.moment_1, policy.moment_2),
            (policy.steps, policy.updates, experience.length),
            *_rollouts(experience),
            *animals[:4],
            np.uint64(self.seed),
            self.layers,
            self.offsets,
            animals.report,
            work=int(experience.length[animals.rows] @ epochs) * self.size // WEIGHTS,
        )

    def _settings(
        self, n: int, plasticity: tuple[Any, Any, Any] | None, own: Mapping[str, np.ndarray]
    ) -> np.ndarray:
        """Return the hyperparameters f64[n, Hyperparameters] of n animals: the species' values, overridden by
        the animals' plasticity and their `own` [n]."""
        if plasticity is not None:
            own = {**own, **dict(zip(("learning_rate", "discount", "entropy_coef"), plasticity, strict=True))}
        settings = np.empty((n, len(kernels.Hyperparameters._fields)))
        for i, name in enumerate(kernels.Hyperparameters._fields):
            settings[:, i] = own.get(name, getattr(self.ppo, name))
        return settings

    def _tell(self, policy: Columns, rows: np.ndarray, report: np.ndarray) -> None:
        """Share the results of each process, which cover its part of the rows i64[n], with all processes."""
        n, (first, last) = len(rows), self.bands.part(len(rows))
        for column in (policy.weights, policy.moment_1, policy.moment_2, policy.steps, policy.updates):
            column[rows] = self.bands.gathered(n, column[rows[first:last]])
        self.bands.whole(n, report)


def setting_of(settings: np.ndarray, name: str) -> np.ndarray:
    """Return one hyperparameter f32[n] from the settings f64[n, Hyperparameters] of n animals."""
    return settings[:, kernels.Hyperparameters._fields.index(name)].astype(np.float32)


def require_finite(report: np.ndarray, uid: np.ndarray) -> None:
    """Raise FloatingPointError if an animal's gradient is not finite."""
    if isfinite(np.add.reduce(report[:, 5])):
        return
    finite = np.isfinite(report[:, 5])
    if not finite.all():
        lost = np.flatnonzero(~finite)
        raise FloatingPointError(
            f"the gradient of animal {uid[lost[0]]} is {report[lost[0], 5]} ({lost.size} in all); "
            "observations, rewards and values must be finite"
        )


def summary(report: np.ndarray, lengths: np.ndarray, rates: np.ndarray) -> dict[str, float]:
    """Return means over animals (for the reward, over transitions), or NaN if no animal learned."""
    n, total = len(report), np.add.reduce
    if not n:
        return dict.fromkeys((*kernels.TERMS, "learning_rate"), float("nan")) | {
            "n_transitions": 0,
            "n_animals": 0,
        }
    sums, known, transitions = total(report), report[:, 6], int(total(lengths))
    means: dict[str, float] = dict(zip(kernels.TERMS, (sums / n).tolist(), strict=True))
    known = known[np.isfinite(known)]
    means["explained_variance"] = float(total(known)) / known.size if known.size else float("nan")
    means["reward"] = float(total(report[:, 7] * lengths)) / transitions
    means["learning_rate"] = float(total(rates, dtype=float)) / n
    means["n_transitions"], means["n_animals"] = transitions, n
    return means


def _rollouts(experience: Columns) -> tuple[Any, Any, Any]:
    """Return the addresses of observations, choices, and log-probabilities, values and rewards."""
    returns = _addresses(experience.log_probability, experience.value, experience.reward)
    return experience.observations.by_address(), experience.choices.by_address(), returns


def _addresses(*columns: Blocked) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """Return the addresses of columns in the form that kernels expect."""
    return tuple(column.by_address() for column in columns)
