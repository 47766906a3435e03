"""A torch module for every animal: the weights of all are rows of one column,
and torch.func lets them think and learn at once.

The columns are those of individual.py, so that brains are born, inherited, saved and freed in the same way.
"""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from torch.func import functional_call, grad_and_value, vmap

from ecs_eco.compiled.elementary import power
from ecs_eco.compiled.threads import one_torch_thread
from ecs_eco.engine.random import mix_int
from ecs_eco.learning.individual import Individuals, require_finite, summary
from ecs_eco.learning.module_brain import ModuleBrain, made
from ecs_eco.learning.policy_network import PolicyNetwork, Split
from ecs_eco.learning.settings import PPO
from ecs_eco.learning.torch_ppo import TERMS, ppo_loss

if TYPE_CHECKING:
    from ecs_eco.engine.schema import Columns

ANIMALS = 256  # that go through their networks at once


class IndividualModules(Individuals):
    """The networks of all individuals of a species, each `network(n_observations, groups)`
    with weights of its own.

    On the CPU the same animals think and learn the same bits on any number of threads. What torch.func.vmap
    has no rule for (as of torch 2: GRUCell and LSTMCell) goes animal by animal. Raises ValueError for a
    module that cannot be a brain.
    """

    by_row = False  # torch computes many at once

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
        module = self.brain.module
        self.n_observations, self.groups, self.hidden, self.ppo, self.seed = (
            n_observations,
            tuple(groups),
            (),
            ppo,
            seed,
        )
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

    def reset(self, ppo: PPO) -> None:
        """Take other hyperparameters."""
        self.ppo = ppo

    def draw(self, who: np.ndarray, key: int | np.uint64) -> np.ndarray:
        """Return the weights f32[k, size] that the module's constructor draws for newborn: the same for the
        same key and `who` u64[k]."""
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
        """Return the weights of a shared brain of this network in the order in
        which individuals keep theirs: f32[size]."""
        return np.concatenate([np.asarray(brain.named()[name], np.float32).ravel() for name in self.names])

    def module(self, weights: np.ndarray) -> torch.nn.Module:
        """Return one organism's network, of weights f32[size]."""
        module = copy.deepcopy(self.brain.module).cpu()
        parameters = [p for p in module.parameters() if p.requires_grad]
        torch.nn.utils.vector_to_parameters(torch.from_numpy(np.array(weights)), parameters)
        return module

    def forward(
        self, policy: Columns, rows: np.ndarray, x: np.ndarray, split: Split
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return logits f32[n, n_logits] and values f32[n] of the animals of `rows` i64[n], without memory."""
        return self.recall(policy, rows, x, np.zeros((len(rows), self.memory), np.float32))[:2]

    def recall(
        self, policy: Columns, rows: np.ndarray, x: np.ndarray, memory: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return logits, values, and the memory f32[n, memory] from here on, of animals with this memory."""
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
        """As `Individuals.learn`; `memory` f32[n, memory] is what the animals remembered when their rollouts
        began, `numbers` f32[n, horizon, n_numbers] what they drew for continuous actions. Nobody has `own`
        hyperparameters here."""
        settings = np.empty((3, len(rows)), np.float32)
        settings[0], settings[1], settings[2] = plasticity or (
            self.ppo.learning_rate,
            self.ppo.discount,
            self.ppo.entropy,
        )
        lengths = experience.length[rows]
        learning = np.flatnonzero((settings[0] != 0) & (lengths > 0))
        report = np.zeros((len(rows), len(TERMS) + 3))
        drawn = np.zeros((len(rows), self.ppo.horizon, 0), np.float32) if numbers is None else numbers
        with self.brain.reproducible(), one_torch_thread():
            for start in range(0, len(learning), ANIMALS):
                here = learning[start : start + ANIMALS]
                began = np.zeros((len(here), self.memory), np.float32) if memory is None else memory[here]
                report[here] = self._fit(
                    policy,
                    experience,
                    rows[here],
                    uid[here],
                    bootstrap[here],
                    settings[:, here],
                    began,
                    drawn[here],
                )
        experience.length[rows] = 0
        require_finite(report, uid)
        return summary(report[learning], lengths[learning], settings[0, learning])

    def _think(self, weights: np.ndarray, x: np.ndarray, memory: np.ndarray) -> Any:
        """Let each animal's network see one observation."""
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

    def _fit(
        self,
        policy: Columns,
        experience: Columns,
        rows: np.ndarray,
        uid: np.ndarray,
        bootstrap: np.ndarray,
        settings: np.ndarray,
        began: np.ndarray,
        numbers: np.ndarray,
    ) -> np.ndarray:
        """Let animals learn, each from its rollout, and write weights and moments; return f64[k, terms …]."""
        ppo, tensor = self.ppo, self.brain.tensor
        lengths = experience.length[rows].astype(np.int64)
        here = {
            name: getattr(experience, name)[rows]
            for name in ("observations", "log_probability", "value", "reward")
        }
        there = np.arange(ppo.horizon) < lengths[:, None]
        advantage = _advantages(
            here["reward"], here["value"], bootstrap, lengths, settings[1], ppo.gae_lambda
        )
        report = np.zeros((len(rows), len(TERMS) + 3))
        report[:, -2:] = np.stack(
            [_explained(advantage, here["value"], there), (here["reward"] * there).sum(1) / lengths], axis=1
        )
        shift, scale = (
            _normal(advantage, there)
            if ppo.normalise_advantage
            else (np.zeros(len(rows)), np.ones(len(rows)))
        )
        fixed = (
            tensor(here["observations"]),
            tensor(experience.choices[rows].astype(np.int64)),
            tensor(numbers),
            tensor(here["log_probability"]),
            tensor(here["value"]),
            tensor(advantage),
            tensor(began),
        )
        scalars = tuple(tensor(v.astype(np.float32)) for v in (settings[2], shift, scale))
        weights, moments = (
            tensor(policy.weights[rows]),
            [tensor(policy.moment_1[rows]), tensor(policy.moment_2[rows])],
        )
        steps, n_steps = policy.steps[rows].astype(np.int64), 0
        slope = self._each(grad_and_value(self._loss, has_aux=True))
        parts = 1 if self.memory else max(1, -(-ppo.horizon // ppo.minibatch))
        updates = policy.updates[rows]
        for epoch in range(ppo.epochs):
            for chosen in _shares(there, parts, self.seed, uid, updates, epoch):
                gradient, (_, terms) = slope(weights, *fixed, tensor(chosen.astype(np.float32)), *scalars)
                norm = gradient.double().norm(dim=1)
                steps, n_steps = steps + 1, n_steps + 1
                self._adam(weights, gradient, moments, norm, steps, settings[0])
                report[:, : len(TERMS)] += torch.stack(terms, dim=1).cpu().numpy()
                report[:, len(TERMS)] += norm.cpu().numpy()
        report[:, : len(TERMS) + 1] /= n_steps
        policy.weights[rows], policy.moment_1[rows], policy.moment_2[rows] = (
            t.cpu().numpy() for t in (weights, *moments)
        )
        policy.steps[rows], policy.updates[rows] = steps, updates + 1
        return report

    def _loss(
        self,
        weights: torch.Tensor,
        observations: torch.Tensor,
        choices: torch.Tensor,
        numbers: torch.Tensor,
        log_probability: torch.Tensor,
        value: torch.Tensor,
        advantage: torch.Tensor,
        began: torch.Tensor,
        chosen: torch.Tensor,
        entropy: torch.Tensor,
        shift: torch.Tensor,
        scale: torch.Tensor,
    ) -> tuple[torch.Tensor, tuple[torch.Tensor, ...]]:
        """Return the mean loss of one animal over the transitions that are `chosen` f32[horizon],
        and its terms."""
        logits, values = self._replay(self._named(weights), observations, began)
        old = {"log_probability": log_probability, "value": value, "advantage": advantage}
        loss, terms = ppo_loss(
            logits, values, choices, numbers, self.groups, old, self.ppo, self.ppo.clip, entropy, shift, scale
        )
        n = chosen.sum().clamp(min=1)
        return (loss * chosen).sum() / n, tuple((term.detach() * chosen).sum() / n for term in terms)

    def _replay(
        self, named: dict[str, torch.Tensor], observations: torch.Tensor, state: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return logits [horizon, k] and values [horizon] of one animal;
        gradients go back `unroll` ticks of its memory."""
        module = self.brain.module
        if not self.memory:
            return functional_call(module, named, (observations,))
        state, outputs = state[None], []
        for t in range(len(observations)):
            state = state.detach() if t % self.ppo.unroll == 0 else state
            logits, values, state = functional_call(module, named, (observations[t : t + 1], state))
            outputs.append((logits, values))
        return torch.cat([o[0] for o in outputs]), torch.cat([o[1] for o in outputs])

    def _adam(
        self,
        weights: torch.Tensor,
        gradient: torch.Tensor,
        moments: list[torch.Tensor],
        norm: torch.Tensor,
        steps: np.ndarray,
        rate: np.ndarray,
    ) -> None:
        """Take each animal's step of Adam in place; who has a gradient that is not finite stays as it is."""
        ppo, tensor = self.ppo, self.brain.tensor
        sound = torch.isfinite(norm)[:, None]
        held = (
            torch.clamp(ppo.max_grad_norm / (norm + 1e-6), max=1.0)[:, None].float()
            if ppo.max_grad_norm
            else 1.0
        )
        slope = torch.where(sound, torch.nan_to_num(gradient) * held, 0.0)
        first, second = moments
        first += torch.where(sound, 0.1 * (slope - first), 0.0)
        second += torch.where(sound, 0.001 * (slope * slope - second), 0.0)
        pace = tensor((rate / (1 - power(0.9, steps))).astype(np.float32))[:, None]
        root = tensor((1 / np.sqrt(1 - power(0.999, steps))).astype(np.float32))[:, None]
        keep = tensor((1 - rate * ppo.weight_decay).astype(np.float32))[:, None]
        moved = weights * keep - pace * first / (second.sqrt() * root + ppo.adam_epsilon)
        weights.copy_(torch.where(sound, moved, weights))

    def _try(self) -> None:
        """Go animal by animal where torch has no way for several at once; raise ValueError where such a
        network cannot learn at all."""
        n, horizon = 2, 3
        flat = (horizon,)
        seen, chosen = (horizon, self.n_observations), (horizon, len(self.offsets) - 1)
        shapes = (
            (self.size,),
            seen,
            chosen,
            (horizon, self.n_numbers),
            flat,
            flat,
            flat,
            (self.memory,),
            flat,
            (),
            (),
            (),
        )
        kinds = [np.int64 if shape is chosen else np.float32 for shape in shapes]
        zeros = [
            self.brain.tensor(np.zeros((n, *shape), kind)) for shape, kind in zip(shapes, kinds, strict=True)
        ]
        for each in (vmap, one_by_one):
            self._each = each
            try:
                with one_torch_thread(), self.brain.reproducible(), warnings.catch_warnings():
                    # of operations that vmap itself would do one by one
                    warnings.simplefilter("error", UserWarning)
                    each(grad_and_value(self._loss, has_aux=True))(*zeros)
                    with torch.no_grad():  # operations may be others then
                        self._think(
                            np.zeros((n, self.size), np.float32),
                            zeros[1][:, 0].cpu().numpy(),
                            zeros[7].cpu().numpy(),
                        )
                return
            except Exception as error:
                failed = error
        raise ValueError(
            f"cannot be an individual's: torch.func raises {type(failed).__name__}: "
            f"{str(failed).strip().splitlines()[0][:200]}"
        ) from failed


def one_by_one(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return what torch.func.vmap returns for a function, with the items
    of its arguments taken one after the other."""

    def mapped(*arguments: torch.Tensor) -> Any:
        return _stacked([function(*(a[i] for a in arguments)) for i in range(len(arguments[0]))])

    return mapped


def _stacked(items: list[Any]) -> Any:
    if isinstance(items[0], tuple):
        return tuple(_stacked(list(parts)) for parts in zip(*items, strict=True))
    return torch.stack(items)


def _advantages(
    reward: np.ndarray,
    value: np.ndarray,
    bootstrap: np.ndarray,
    lengths: np.ndarray,
    discount: np.ndarray,
    gae_lambda: float,
) -> np.ndarray:
    """Return the advantages f32[k, horizon] (Schulman et al. 2016, eq. 16),
    zero beyond each rollout's length."""
    out, later, gain = np.zeros_like(value), np.array(bootstrap, np.float32), np.zeros(len(value), np.float32)
    for t in range(value.shape[1] - 1, -1, -1):
        there = t < lengths
        td_error = reward[:, t] + discount * later - value[:, t]
        gain = np.where(there, td_error + discount * np.float32(gae_lambda) * gain, gain)
        later = np.where(there, value[:, t], later)
        out[:, t] = np.where(there, gain, 0)
    return out


def _normal(advantage: np.ndarray, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what to take from each animal's advantages, and to multiply them with,
    for mean 0 and deviation 1."""
    n = there.sum(axis=1)
    mean = (advantage.astype(float) * there).sum(axis=1) / n
    spread = np.sqrt((((advantage - mean[:, None]) * there) ** 2).sum(axis=1) / n)
    single = n < 2
    return np.where(single, 0, mean), np.where(single, 1, 1 / (spread + 1e-8))


def _explained(advantage: np.ndarray, value: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Return which share of the targets' variance the values explain, per animal; NaN where there is none."""

    def variance(v: np.ndarray) -> np.ndarray:
        n = there.sum(axis=1)
        mean = (v * there).sum(axis=1) / n
        return (((v - mean[:, None]) * there) ** 2).sum(axis=1) / n

    target = variance((advantage + value).astype(float))
    left = variance(advantage.astype(float))
    return np.where(target > 0, 1 - left / np.where(target > 0, target, 1), np.nan)


def _shares(
    there: np.ndarray, parts: int, seed: int, uid: np.ndarray, updates: np.ndarray, epoch: int
) -> list[np.ndarray]:
    """Return masks bool[k, horizon] that share out each animal's transitions
    at random among the gradient steps of an epoch."""
    if parts == 1:
        return [there]
    order = np.empty(there.shape)
    for i in range(len(there)):
        key = [mix_int(seed ^ int(uid[i])), int(updates[i]) * 1_000_003 + epoch]
        order[i] = np.random.Generator(np.random.Philox(key=key)).permutation(there.shape[1])
    return [there & (order * parts // there.shape[1] == part) for part in range(parts)]
