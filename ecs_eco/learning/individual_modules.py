"""A torch module for every animal: weights are rows of one column; torch.func runs and trains them together.

The columns are the same as in individual.py, so brains are created, inherited, saved and freed in the same
way.
"""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from torch.func import functional_call, grad_and_value, vmap

from ecs_eco.compiled.threads import one_torch_thread
from ecs_eco.engine.random import mix_int
from ecs_eco.learning.adam import adam_each
from ecs_eco.learning.individual import Animals, Individuals, setting_of
from ecs_eco.learning.loss import LOSS_TERMS
from ecs_eco.learning.module_brain import ModuleBrain, made
from ecs_eco.learning.policy_network import PolicyNetwork, Split
from ecs_eco.learning.rollout import STEP, fill_advantages, summarize
from ecs_eco.learning.settings import PPO
from ecs_eco.learning.torch_ppo import ppo_loss

if TYPE_CHECKING:
    from ecs_eco.engine.schema import Columns

ANIMALS = 256  # animals whose networks run together


class IndividualModules(Individuals):
    """The networks of all individuals of a species, each `network(n_observations, groups)` with its own
    weights.

    On the CPU, decisions and learning are bit-identical for any number of threads. Modules that
    torch.func.vmap does not support (in torch 2, GRUCell and LSTMCell) run one animal at a time. Raises
    ValueError if a module cannot be a brain.
    """

    by_row = False  # torch computes many rows at once

    def __init__(
        self,
        network: Callable[..., Any],
        n_observations: int,
        groups: tuple[int, ...],
        ppo: PPO,
        seed: int,
        device: str = "cpu",
    ) -> None:
        self.network = network
        self.brain = ModuleBrain(made(network, n_observations, groups, seed), n_observations, groups, device)
        module, self.ppo, self.seed = self.brain.module, ppo, seed
        self.n_observations, self.groups, self.hidden = n_observations, tuple(groups), ()
        self.offsets, self.n_logits, self.memory = self.brain.offsets, self.brain.n_logits, self.brain.memory
        self.n_numbers = self.brain.n_numbers
        self.names = [name for name, p in module.named_parameters() if p.requires_grad]
        self.shapes = [tuple(p.shape) for p in module.parameters() if p.requires_grad]
        self.size = sum(int(np.prod(shape)) for shape in self.shapes)
        self.dims = {
            "weights": self.size,
            "horizon": ppo.horizon,
            "channels": n_observations,
            "groups": len(self.offsets) - 1,
        }
        self.dims |= {"memory": self.memory} if self.memory else {}
        self._each: Callable[..., Any] = vmap
        self._try()

    def draw(self, who: np.ndarray, key: int | np.uint64) -> np.ndarray:
        """Return the weights f32[k, size] that the module's constructor draws for newborns; each is
        determined by the key and its `who` u64[k]."""
        weights = np.empty((len(who), self.size), np.float32)
        with torch.random.fork_rng(devices=[]), one_torch_thread():
            for i, one in enumerate(np.asarray(who, np.uint64).tolist()):
                torch.manual_seed(mix_int(int(key) ^ mix_int(one)) & 0x7FFFFFFFFFFFFFFF)
                parameters = [
                    p for p in self.network(self.n_observations, self.groups).parameters() if p.requires_grad
                ]
                weights[i] = torch.nn.utils.parameters_to_vector(parameters).detach().numpy()
        return weights

    def flat(self, brain: PolicyNetwork) -> np.ndarray:
        """Return the weights of a shared brain with this network in the individuals' order: f32[size]."""
        return np.concatenate([np.asarray(brain.named()[name], np.float32).ravel() for name in self.names])

    def module(self, weights: np.ndarray) -> torch.nn.Module:
        """Return one organism's network, with weights f32[size]."""
        module = copy.deepcopy(self.brain.module).cpu()
        parameters = [p for p in module.parameters() if p.requires_grad]
        torch.nn.utils.vector_to_parameters(torch.from_numpy(np.array(weights)), parameters)
        return module

    def forward(
        self, policy: Columns, rows: np.ndarray, x: np.ndarray, split: Split
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return logits f32[n, n_logits] and values f32[n] of animals in `rows` i64[n], without memory."""
        return self.recall(policy, rows, x, np.zeros((len(rows), self.memory), np.float32))[:2]

    def recall(
        self, policy: Columns, rows: np.ndarray, x: np.ndarray, memory: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the logits, values and next memory f32[n, memory] of animals with this memory."""
        n = len(rows)
        logits, values = np.empty((n, self.n_logits), np.float32), np.empty(n, np.float32)
        later = np.empty((n, self.memory), np.float32)
        with self.brain.reproducible(), torch.no_grad(), one_torch_thread():
            for start in range(0, n, ANIMALS):
                here = slice(start, start + ANIMALS)
                out = self._think(policy.weights[rows[here]], x[here], memory[here])
                logits[here], values[here] = out[0].cpu().numpy(), out[1].cpu().numpy()
                if self.memory:
                    later[here] = out[2].cpu().numpy()
        return logits, values, later

    def _train(self, policy: Columns, experience: Columns, animals: Animals, split: Split) -> None:
        """Perform the animals' Adam steps, and write their reports."""
        rates, lengths = setting_of(animals.settings, "learning_rate"), experience.length[animals.rows]
        learning = np.flatnonzero((rates != 0) & (lengths > 0))
        with self.brain.reproducible(), one_torch_thread():
            for start in range(0, len(learning), ANIMALS):
                here = learning[start : start + ANIMALS]
                animals.report[here] = self._fit(policy, experience, animals.part(here))

    def _think(self, weights: np.ndarray, x: np.ndarray, memory: np.ndarray) -> Any:
        """Run each animal's network on its observation."""
        tensor = self.brain.tensor
        inputs = (tensor(x[:, None]), tensor(memory[:, None])) if self.memory else (tensor(x[:, None]),)
        out = self._each(lambda w, *seen: functional_call(self.brain.module, self._named(w), seen))(
            tensor(weights), *inputs
        )
        return tuple(o[:, 0] for o in out)

    def _named(self, weights: torch.Tensor) -> dict[str, torch.Tensor]:
        """Return one animal's weights f32[size] by name."""
        sizes = [int(np.prod(shape)) for shape in self.shapes]
        parts = torch.split(weights, sizes)
        return {
            name: part.view(shape) for name, part, shape in zip(self.names, parts, self.shapes, strict=True)
        }

    def _fit(self, policy: Columns, experience: Columns, animals: Animals) -> np.ndarray:
        """Train each animal on its rollout, and write weights and moments; return f64[k, terms …]."""
        ppo, tensor, rows, settings = self.ppo, self.brain.tensor, animals.rows, animals.settings
        lengths = experience.length[rows].astype(np.int64)
        steps, (shift, scale, explained, reward) = self._advantages_of(experience, animals, lengths)
        fixed = {name: tensor(steps[name]) for name in ("log_probability", "value", "advantage")} | {
            "observations": tensor(experience.observations[rows]),
            "choices": tensor(experience.choices[rows].astype(np.int64)),
            "numbers": tensor(animals.numbers),
            "memory": tensor(animals.memory),
            "entropy": tensor(setting_of(settings, "entropy_coef")),
            "shift": tensor(shift.astype(np.float32)),
            "scale": tensor(scale.astype(np.float32)),
        }
        kept = policy.weights[rows], policy.moment_1[rows], policy.moment_2[rows]
        weights, moment_1, moment_2 = kept
        report, n_steps = np.zeros_like(animals.report), 0
        report[:, -2], report[:, -1] = explained, reward
        slope = self._each(grad_and_value(self._loss, has_aux=True))
        rates = setting_of(settings, "learning_rate")
        how = ppo.adam_epsilon, ppo.max_grad_norm, ppo.weight_decay
        parts = 1 if self.memory else max(1, -(-ppo.horizon // ppo.minibatch_size))
        there, updates = np.arange(ppo.horizon) < lengths[:, None], policy.updates[rows]
        for epoch in range(ppo.epochs):
            for chosen in _minibatches(there, parts, self.seed, animals.uid, updates, epoch):
                mask = tensor(chosen.astype(np.float32))
                gradient, (_, terms) = slope(tensor(weights), fixed | {"chosen": mask})
                n_steps += 1
                report[:, : len(LOSS_TERMS)] += torch.stack(terms, dim=1).cpu().numpy()
                slopes, steps_taken = gradient.cpu().numpy(), policy.steps[rows] + n_steps
                report[:, len(LOSS_TERMS)] += adam_each(
                    weights, slopes, moment_1, moment_2, steps_taken, rates, how
                )
        report[:, : len(LOSS_TERMS) + 1] /= n_steps
        policy.weights[rows], policy.moment_1[rows], policy.moment_2[rows] = kept
        policy.steps[rows] += n_steps
        policy.updates[rows] = updates + 1
        return report

    def _advantages_of(
        self, experience: Columns, animals: Animals, lengths: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the animals' transitions with advantages, STEP[k, horizon], padded with zeros beyond each
        rollout's length, and the statistics of `summarize` for each animal, f64[4, k]."""
        shape, gae_lambda = (len(lengths), self.ppo.horizon), np.float32(self.ppo.gae_lambda)
        steps, ended = np.zeros(shape, STEP), np.zeros(self.ppo.horizon, np.bool_)
        for name in ("log_probability", "value", "reward"):
            steps[name] = getattr(experience, name)[animals.rows]
        discount, said = setting_of(animals.settings, "discount"), []
        for i, n in enumerate(lengths.tolist()):
            later, gain = animals.bootstrap[i : i + 1].copy(), np.zeros(1, np.float32)
            fill_advantages(steps[i, :n], ended, later, gain, discount[i], gae_lambda)
            said.append(summarize(steps[i, :n], self.ppo.normalise_advantage))
        return steps, np.array(said).T

    def _loss(
        self, weights: torch.Tensor, one: dict[str, torch.Tensor]
    ) -> tuple[torch.Tensor, tuple[torch.Tensor, ...]]:
        """Return the mean loss of one animal over the `chosen` f32[horizon] transitions, and its terms."""
        logits, values = self._replay(self._named(weights), one["observations"], one["memory"])
        entropy, shift, scale, chosen = (one[name] for name in ("entropy", "shift", "scale", "chosen"))
        ppo = self.ppo
        loss, terms = ppo_loss(logits, values, one, self.groups, ppo, ppo.clip, entropy, shift, scale)
        n = chosen.sum().clamp(min=1)
        return (loss * chosen).sum() / n, tuple((term.detach() * chosen).sum() / n for term in terms)

    def _replay(
        self, named: dict[str, torch.Tensor], observations: torch.Tensor, state: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return logits [horizon, k] and values [horizon] of one animal; gradients flow back through `unroll`
        ticks of its memory."""
        module = self.brain.module
        if not self.memory:
            return functional_call(module, named, (observations,))
        state, outputs = state[None], []
        for t in range(len(observations)):
            state = state.detach() if t % self.ppo.unroll == 0 else state
            logits, values, state = functional_call(module, named, (observations[t : t + 1], state))
            outputs.append((logits, values))
        return torch.cat([o[0] for o in outputs]), torch.cat([o[1] for o in outputs])

    def _try(self) -> None:
        """Switch to running one animal at a time if torch cannot run several together. Raises ValueError if
        such a network cannot learn at all."""
        n, horizon = 2, 3
        weights, memory = np.zeros((n, self.size), np.float32), np.zeros((n, self.memory), np.float32)
        seen, zeros = np.zeros((n, horizon, self.n_observations), np.float32), torch.zeros(n, horizon)
        blank = dict.fromkeys(("log_probability", "value", "advantage", "chosen"), zeros) | {
            "observations": torch.from_numpy(seen),
            "choices": torch.zeros((n, horizon, len(self.offsets) - 1), dtype=torch.int64),
            "numbers": torch.zeros(n, horizon, self.n_numbers),
            "memory": torch.from_numpy(memory),
            **dict.fromkeys(("entropy", "shift", "scale"), torch.zeros(n)),
        }
        blank = {name: tensor.to(self.brain.device) for name, tensor in blank.items()}
        for each in (vmap, one_by_one):
            self._each = each
            try:
                with one_torch_thread(), self.brain.reproducible(), warnings.catch_warnings():
                    # vmap warns about operations that it would run one by one
                    warnings.simplefilter("error", UserWarning)
                    each(grad_and_value(self._loss, has_aux=True))(self.brain.tensor(weights), blank)
                    with torch.no_grad():  # inference can use different operations
                        self._think(weights, seen[:, 0], memory)
                return
            except Exception as error:
                failed = error
        raise ValueError(
            f"cannot be used for individuals: torch.func raises {type(failed).__name__}: "
            f"{str(failed).strip().splitlines()[0][:200]}"
        ) from failed


def one_by_one(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function like torch.func.vmap's that computes the items of its arguments one by one."""

    def item(argument: Any, i: int) -> Any:
        return {k: v[i] for k, v in argument.items()} if isinstance(argument, dict) else argument[i]

    def mapped(*arguments: Any) -> Any:
        return _stacked([function(*(item(a, i) for a in arguments)) for i in range(len(arguments[0]))])

    return mapped


def _stacked(items: list[Any]) -> Any:
    if isinstance(items[0], tuple):
        return tuple(_stacked(list(parts)) for parts in zip(*items, strict=True))
    return torch.stack(items)


def _minibatches(
    there: np.ndarray, parts: int, seed: int, uid: np.ndarray, updates: np.ndarray, epoch: int
) -> list[np.ndarray]:
    """Return masks bool[k, horizon] that randomly distribute each animal's transitions over the gradient
    steps of an epoch."""
    if parts == 1:
        return [there]
    order = np.empty(there.shape)
    for i in range(len(there)):
        key = [mix_int(seed ^ int(uid[i])), int(updates[i]) * 1_000_003 + epoch]
        order[i] = np.random.Generator(np.random.Philox(key=key)).permutation(there.shape[1])
    return [there & (order * parts // there.shape[1] == part) for part in range(parts)]
