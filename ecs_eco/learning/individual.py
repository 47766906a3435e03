"""A brain for every animal: each has its own weights, its own Adam and its own hyperparameters,
and learns from its own life.

Nothing is kept here: weights and rollouts are columns of the animals' table, in blocks of rows (components
Policy and Experience), so that a brain is born and dies with its animal. The loss is that of ppo.py; the
kernels are in individual_kernels.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.learning import individual_kernels as kernels
from ecs_eco.learning.policy_network import PolicyNetwork, Split
from ecs_eco.learning.settings import PPO
from ecs_eco.space.one_band import OneBand

if TYPE_CHECKING:
    from ecs_eco.engine.schema import Columns

# hyperparameters that the kernels get in one row for each animal
SETTINGS = (
    "gae_lambda",
    "clip",
    "clip_value",
    "value_weight",
    "adam_epsilon",
    "max_grad_norm",
    "weight_decay",
)
COUNTS = "epochs", "minibatch"
WEIGHTS = 170  # used, there and back in learning, in the 30 ns that `split` counts as an organism


class Individuals:
    """The networks of all individuals of a species: a shared trunk of tanh layers,
    heads for policy and value, and PPO.

    `policy` and `experience` are the columns of these components. Rows come in canonical order; what an
    animal thinks and learns depends, bit for bit, neither on its row, nor on the others, nor on threads. A
    tick is: sense; credit; learn, for those that are `due`; forward; choose; store.
    """

    memory = 0  # numbers that each keeps from one decision to the next
    by_row = True  # what one thinks depends on no other, to the bit: processes may share the rows
    n_numbers = 0  # continuous actions: their kernels know categorical ones alone

    def __init__(
        self, n_observations: int, groups: tuple[int, ...], hidden: tuple[int, ...], ppo: PPO, seed: int
    ) -> None:
        _check(n_observations, groups, hidden)
        self.n_observations, self.groups, self.hidden, self.ppo, self.seed = (
            n_observations,
            tuple(groups),
            tuple(hidden),
            ppo,
            seed,
        )
        self.bands = OneBand()  # the processes that share its work
        # group g's logits are offsets[g]:offsets[g + 1]
        self.offsets = np.cumsum((0, *groups)).astype(np.int64)
        self.n_logits = int(self.offsets[-1])
        self.widths = np.array([n_observations, *hidden, self.n_logits + 1])
        layers = list(pairwise(self.widths.tolist()))
        # matrix (in, out), bias, …
        self.shapes: list[tuple[int, ...]] = [shape for a, b in layers for shape in ((a, b), (b,))]
        self.size = sum(a * b + b for a, b in layers)
        self.dims = {
            "weights": self.size,
            "horizon": ppo.horizon,
            "channels": n_observations,
            "groups": len(groups),
        }
        self.reset(ppo)

    def reset(self, ppo: PPO) -> None:
        """Take other hyperparameters; the horizon stays."""
        self.ppo = ppo
        self._settings = np.array([getattr(ppo, field) for field in SETTINGS], np.float64)

    def flat(self, brain: PolicyNetwork) -> np.ndarray:
        """Return the weights of a shared brain in the order in which individuals keep theirs: f32[size]."""
        weights = np.empty(self.size, np.float32)
        parts, named, n = self.views(weights), brain.named(), self.n_logits
        for level in range(len(self.hidden)):
            parts[2 * level][...] = named[f"trunk.{level}.weight"].T
            parts[2 * level + 1][...] = named[f"trunk.{level}.bias"]
        for part, where in (("policy", slice(0, n)), ("value", slice(n, n + 1))):
            parts[-2][:, where] = named[f"{part}.head.weight"].T
            parts[-1][where] = named[f"{part}.head.bias"]
        return weights

    def views(self, weights: np.ndarray) -> list[np.ndarray]:
        """Return the parts of weights [..., size] in the order of `shapes`;
        the value is the last output of the last layer."""
        ends = np.cumsum([int(np.prod(shape)) for shape in self.shapes])
        parts = np.split(weights, ends[:-1], axis=-1)
        return [
            part.reshape(*weights.shape[:-1], *shape) for part, shape in zip(parts, self.shapes, strict=True)
        ]

    def module(self, weights: np.ndarray) -> Any:
        """Return one organism's network, of weights f32[size], as a torch module."""
        import torch

        from ecs_eco.learning.mlp import MLP

        module, n = MLP(self.n_observations, self.groups, self.hidden), self.n_logits
        parts = [torch.from_numpy(part.copy()) for part in self.views(weights)]
        state = {f"trunk.{i}.weight": parts[2 * i].T for i in range(len(self.hidden))}
        state |= {f"trunk.{i}.bias": parts[2 * i + 1] for i in range(len(self.hidden))}
        for name, where in (("policy", slice(0, n)), ("value", slice(n, n + 1))):
            state |= {f"{name}.head.weight": parts[-2][:, where].T, f"{name}.head.bias": parts[-1][where]}
        module.load_state_dict(state)
        return module.eval()

    def draw(self, who: np.ndarray, key: int | np.uint64) -> np.ndarray:
        """Return random networks f32[k, size] for newborn, each the same for the same key and `who` u64[k].

        Weights are normal with deviation gain / sqrt(inputs), the gain sqrt(2), 0.01 of the logits,
        1 of the value; biases are zero.
        """
        deviations = np.zeros(self.size, np.float32)
        for matrix in self.views(deviations)[::2]:
            matrix[...] = np.sqrt(2 / matrix.shape[0])
        matrix[:, :-1], matrix[:, -1] = 0.01 / np.sqrt(matrix.shape[0]), 1 / np.sqrt(matrix.shape[0])
        weights = np.empty((len(who), self.size), np.float32)
        kernels.draw_newborn(np.uint64(key), np.asarray(who, np.uint64), deviations, weights)
        return weights

    def prune(self, weights: np.ndarray, units: np.ndarray, layer: int) -> None:
        """Leave each network of weights f32[k, size] the first `units` i64[k] of a hidden layer.

        All weights to and from the others become 0, and stay so: no gradient reaches them.
        """
        missing = np.arange(self.hidden[layer]) >= units[:, None]
        into, bias, out = self.views(weights)[2 * layer : 2 * layer + 3]
        into[np.broadcast_to(missing[:, None], into.shape)] = 0
        bias[missing] = 0
        out[missing] = 0

    def complete(self, weights: np.ndarray, fresh: np.ndarray) -> None:
        """Give networks f32[k, size] the hidden units that they lack (weights of 0) of `fresh` ones."""
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
        """Return the logits f32[n, n_logits] and values f32[n] of what the animals
        of `rows` i64[n] observe, f32[n, c]."""
        n = len(rows)
        if x.shape != (n, self.n_observations):
            raise ValueError(f"observations have shape {x.shape}; allowed is {(n, self.n_observations)}")
        x = np.ascontiguousarray(x, np.float32)
        logits, values = np.empty((n, self.n_logits), np.float32), np.empty(n, np.float32)
        if n:
            split(
                kernels.think,
                n,
                rows,
                policy.weights.by_address(),
                self.widths,
                x,
                logits,
                values,
                work=n * self.size // WEIGHTS,
            )
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
        """Append a transition to the rollout of each row i64[n]: f32[n, c], int[n, groups], f32[n], f32[n].

        Raises ValueError where a rollout is full: `learn` empties it.
        """
        if not len(rows):
            return
        full = kernels.record(
            *(
                column.by_address()
                for column in (
                    experience.observations,
                    experience.choices,
                    experience.log_probability,
                    experience.value,
                    experience.reward,
                )
            ),
            rows,
            experience.length,
            np.ascontiguousarray(x, np.float32),
            choice,
            log_probability,
            values,
        )
        if full:
            horizon = self.ppo.horizon
            raise ValueError(
                f"{full} of {len(rows)} rollouts have their {horizon} transitions already: "
                "`learn` from those `due` first"
            )

    def credit(self, experience: Columns, rows: np.ndarray, reward: np.ndarray) -> None:
        """Add rewards f32[n] to the last transition of each row; rows without one (newborn) are passed over."""
        if len(rows):
            kernels.credit(experience.reward.by_address(), rows, experience.length, reward)

    def due(
        self, experience: Columns, rows: np.ndarray, uid: np.ndarray, born: np.ndarray, tick: int
    ) -> np.ndarray:
        """Return whose rollout is at an end, bool[n].

        The first rollout of a life ends at an age drawn from the uid, the later ones when they are full:
        about 1 / horizon of the animals learn in a tick, even when all were born in the same one.
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
    ) -> dict[str, float]:
        """Let the animals of `rows` i64[n] learn from their rollouts and empty these;
        they expect `bootstrap` f32[n] of what comes.

        `plasticity` has their learning rates, discounts and weights of the entropy, each f32[n] or one number
        for all; None: those of `ppo`; `own` has other hyperparameters by name, [n] each.
        With a learning rate of 0 an animal forgets its rollout and stays as it
        is. Returns the means over those that learnt, named as those of `Learner.update`, and their number
        n_animals. Raises FloatingPointError where a gradient is not finite.
        """
        ppo, n = self.ppo, len(rows)
        settings = np.empty((3, n), np.float32)
        settings[0], settings[1], settings[2] = plasticity or (ppo.learning_rate, ppo.discount, ppo.entropy)
        others, epochs, minibatch = self._settings_of(n, own or {})
        report, lengths = np.zeros((n, len(kernels.TERMS))), experience.length[rows]
        bootstrap = np.ascontiguousarray(bootstrap, np.float32)

        start, stop = self.bands.part(n)
        mine = slice(start, stop)
        columns = (
            policy.weights,
            policy.moment_1,
            policy.moment_2,
            experience.observations,
            experience.choices,
            experience.log_probability,
            experience.value,
            experience.reward,
        )
        if stop > start:
            split(
                kernels.train,
                stop - start,
                *(column.by_address() for column in columns),
                rows[mine],
                uid[mine],
                policy.steps,
                policy.updates,
                experience.length,
                bootstrap[mine],
                np.ascontiguousarray(settings[:, mine]),
                others[mine],
                epochs[mine],
                minibatch[mine],
                ppo.normalise_advantage,
                np.uint64(self.seed),
                self.widths,
                self.offsets,
                report[mine],
                work=int(lengths[mine] @ epochs[mine]) * self.size // WEIGHTS,
            )
        if self.bands.size > 1:
            self._tell(policy, rows, report)
            experience.length[rows] = 0
        learnt = (settings[0] != 0) & (lengths > 0)
        require_finite(report, uid)
        told = report, lengths, settings[0]
        if np.count_nonzero(learnt) < n:
            told = report[learnt], lengths[learnt], settings[0, learnt]
        return summary(*self.bands.learnt(self, *told))

    def _settings_of(self, n: int, own: Mapping[str, np.ndarray]) -> tuple[np.ndarray, ...]:
        """Return the hyperparameters f64[n, SETTINGS], epochs and minibatch i64[n] of n animals: those of the
        species, but for their `own` [n]."""
        others, counts = np.empty((n, len(SETTINGS))), np.empty((2, n), np.int64)
        others[:], counts[0], counts[1] = self._settings, self.ppo.epochs, self.ppo.minibatch
        for field, values in own.items():
            if field in SETTINGS:
                others[:, SETTINGS.index(field)] = values
            elif field in COUNTS:
                counts[COUNTS.index(field)] = values
        return others, counts[0], counts[1]

    def _tell(self, policy: Columns, rows: np.ndarray, report: np.ndarray) -> None:
        """Let all processes have what each of them has learnt for its part of the rows i64[n]."""
        n, (first, last) = len(rows), self.bands.part(len(rows))
        for column in (policy.weights, policy.moment_1, policy.moment_2, policy.steps, policy.updates):
            column[rows] = self.bands.gathered(n, column[rows[first:last]])
        self.bands.whole(n, report)


def require_finite(report: np.ndarray, uid: np.ndarray) -> None:
    """Raise FloatingPointError that names an animal whose gradient is not finite."""
    if isfinite(np.add.reduce(report[:, 5])):
        return
    finite = np.isfinite(report[:, 5])
    if not finite.all():
        lost = np.flatnonzero(~finite)
        raise FloatingPointError(
            f"the gradient of animal {uid[lost[0]]} is {report[lost[0], 5]} ({lost.size} such in all); "
            "observations, rewards and values must be finite"
        )


def summary(report: np.ndarray, lengths: np.ndarray, rates: np.ndarray) -> dict[str, float]:
    """Return means over animals; of the reward over transitions; NaN where nobody learnt."""
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


def _check(n_observations: int, groups: tuple[int, ...], hidden: tuple[int, ...]) -> None:
    if n_observations < 1:
        raise ValueError(f"n_observations = {n_observations}: allowed is a whole number >= 1")
    if not groups or min(groups) < 1:
        raise ValueError(
            f"groups = {groups}: allowed is a tuple of one or more sizes >= 1, one per action group"
        )
    if min(hidden, default=1) < 1:
        raise ValueError(f"hidden = {hidden}: allowed is a tuple of layer widths >= 1, or ()")
