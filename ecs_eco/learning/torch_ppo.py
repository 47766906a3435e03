"""Proximal policy optimization (Schulman et al. 2017) for any torch module, in a population whose members are
born and die while it learns.

learner.py goes through the rollout. Here, `_step` takes one optimizer step, `_replay` repeats the module's
decisions (along stored sequences if it has memory), and `ppo_loss` computes the loss. The requirements for
modules are in module_brain.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import torch

from ecs_eco.compiled.threads import in_parallel
from ecs_eco.learning.continuous import HALF_LOG_2_PI, LEAST, MOST
from ecs_eco.learning.learner import CHUNK, RolloutLearner
from ecs_eco.learning.loss import LOSS_TERMS
from ecs_eco.learning.settings import PPO


class TorchLearner(RolloutLearner):
    """PPO for a torch module, in a population whose members are born and die mid-rollout.

    Parameters
    ----------
    brain : ModuleBrain
    ppo : PPO
    seed : int
        Random seed for the order of minibatches.
    workers : int, default 1
        Number of threads, which on the CPU affects speed, never results.

    Notes
    -----
    In each tick: sense; record the last actions' outcomes with `rollout.credit`, `end` and `cut`;
    if `full`, call `update` with the values of the new observations; decide; call `rollout.store`.
    """

    def __init__(self, brain: Any, ppo: PPO, seed: int, workers: int = 1) -> None:
        super().__init__(brain, ppo, seed, workers)
        self.optimiser = self._optimiser()

    def _optimiser(self) -> torch.optim.Optimizer:
        """Return Adam (Kingma and Ba 2015) with decoupled weight decay (Loshchilov and Hutter 2019)."""
        ppo, parameters = self.ppo, self.brain.parameters()
        optimiser = torch.optim.AdamW(
            parameters, ppo.learning_rate, eps=ppo.adam_epsilon, weight_decay=ppo.weight_decay
        )
        # torch would do this only at the first step; this way, checkpoints have the same parts before and
        # after it
        for p in parameters:
            zeros = torch.zeros_like(p.detach())
            optimiser.state[p] = {"step": torch.tensor(0.0), "exp_avg": zeros, "exp_avg_sq": zeros.clone()}
        return optimiser

    def _step(self, chosen: np.ndarray, rate: float, clip: float, shift: float, scale: float) -> np.ndarray:
        """Take one optimizer step to reduce the mean loss over the `chosen` i64[k] transitions or stretches.

        Returns the means of the loss's terms and the gradient's norm; if the norm is not finite, nothing
        changes.
        """
        parameters = self.brain.parameters()
        pieces = list(self._pieces(chosen))
        n = int(np.diff(self._stretches)[chosen].sum()) if self.brain.memory else len(chosen)
        gradients: list[Sequence[torch.Tensor | None]] = [()] * len(pieces)
        terms = np.zeros((len(pieces), len(LOSS_TERMS) + 1))

        def work(worker: int) -> None:
            for i in range(worker, len(pieces), self.workers):
                loss, terms[i, :-1] = self._loss(pieces[i], clip, shift, scale)
                gradients[i] = torch.autograd.grad(loss / n, parameters, allow_unused=True)

        with self.brain.reproducible():
            in_parallel(work, self.workers if self.brain.device == "cpu" else 1)
            for parameter, *parts in zip(parameters, *gradients, strict=True):
                parameter.grad = sum(
                    part if part is not None else torch.zeros_like(parameter) for part in parts
                )
            norm = float(torch.nn.utils.clip_grad_norm_(parameters, self.ppo.max_grad_norm or np.inf))
            if np.isfinite(norm):
                for group in self.optimiser.param_groups:
                    group.update(
                        {"lr": rate, "eps": self.ppo.adam_epsilon, "weight_decay": self.ppo.weight_decay}
                    )
                self.optimiser.step()
        total: np.ndarray = terms.sum(axis=0) / n
        total[-1] = norm
        return total

    def _loss(
        self, piece: np.ndarray, clip: float, shift: float, scale: float
    ) -> tuple[torch.Tensor, list[float]]:
        """Return the summed loss over a piece of a minibatch, and the sums of its terms."""
        logits, values, index = self._replay(piece)
        rollout, device = self.rollout, self.brain.device
        step = rollout.steps[index]
        batch = {
            name: torch.from_numpy(step[name].copy()).to(device)
            for name in ("log_probability", "value", "advantage")
        }
        batch["choices"] = torch.from_numpy(rollout.choices[index].astype(np.int64)).to(device)
        batch["numbers"] = torch.from_numpy(rollout.numbers[index]).to(device)
        groups, bonus = self.brain.groups, self.ppo.entropy_coef
        loss, terms = ppo_loss(logits, values, batch, groups, self.ppo, clip, bonus, shift, scale)
        return loss.sum(), [float(term.detach().sum()) for term in terms]

    def _replay(self, piece: np.ndarray) -> tuple[torch.Tensor, torch.Tensor, np.ndarray]:
        """Return the module's current logits [n, k] and values [n] for a piece, and the piece's transitions
        i64[n].

        A module with memory starts each stretch from the stored state, and gradients flow back to the
        beginning of the stretch: truncated backpropagation through time (Williams and Peng 1990). Longer
        stretches come first, so that the stretches still running in step t are the first ones.
        """
        rollout = self.rollout
        if not self.brain.memory:
            logits, values = self.brain.run(rollout.observations[piece])
            return logits, values, piece
        begin, length = self._stretches[piece], np.diff(self._stretches)[piece]
        order = np.argsort(-length, kind="stable")
        begin, length = begin[order], length[order]
        state = self.brain.tensor(rollout.memory[self._lives[begin]])
        outputs, steps = [], []
        for t in range(int(length[0])):
            going = int(np.searchsorted(-length, -t, side="left"))  # those longer than t
            index = self._lives[begin[:going] + t]
            logits, values, state = self.brain.run(rollout.observations[index], state[:going])
            outputs.append((logits, values))
            steps.append(index)
        return torch.cat([o[0] for o in outputs]), torch.cat([o[1] for o in outputs]), np.concatenate(steps)

    def _pieces(self, chosen: np.ndarray) -> Iterator[np.ndarray]:
        """Yield a minibatch in pieces of about CHUNK transitions."""
        size = max(1, CHUNK // self.ppo.unroll) if self.brain.memory else CHUNK
        for start in range(0, len(chosen), size):
            yield chosen[start : start + size]

    def _optimiser_state(self) -> dict[str, np.ndarray]:
        """Return the optimizer's state, under names of the form "optimiser.PARAMETER.WHAT"."""
        names = list(self.brain.named())
        return {
            f"optimiser.{names[i]}.{word}": torch.as_tensor(value).detach().cpu().numpy().copy()
            for i, held in self.optimiser.state_dict()["state"].items()
            for word, value in held.items()
        }

    def _load_optimiser(self, state: dict[str, np.ndarray]) -> None:
        numbers: dict[int, dict[str, torch.Tensor]] = {}
        names = list(self.brain.named())
        for key, array in state.items():
            if key.startswith("optimiser."):
                name, _, word = key.removeprefix("optimiser.").rpartition(".")
                if name not in names:
                    raise ValueError(
                        f"{key}: this network has no parameter {name}; it has {', '.join(names)}"
                    )
                numbers.setdefault(names.index(name), {})[word] = torch.from_numpy(np.array(array))
        self.optimiser.load_state_dict(
            {"state": numbers, "param_groups": self.optimiser.state_dict()["param_groups"]}
        )


def ppo_loss(
    logits: torch.Tensor,
    values: torch.Tensor,
    batch: dict[str, torch.Tensor],
    groups: Sequence[int],
    ppo: PPO,
    clip: float,
    entropy_weight: float | torch.Tensor,
    shift: float | torch.Tensor,
    scale: float | torch.Tensor,
) -> tuple[torch.Tensor, tuple[torch.Tensor, ...]]:
    """Return PPO's loss for each transition, f32[n], and the `LOSS_TERMS`, each f32[n] (Schulman et al. 2017,
    eq. 7 and 9).

    `logits` f32[n, sum(groups)] and `values` f32[n] are current; the batch has the values at the
    time of the decision: choices i64[n, categorical groups], numbers f32[n, continuous groups],
    log_probability, value and advantage, each f32[n]. Advantages are normalized to (A - shift) * scale.
    """
    choices, numbers, old_value = batch["choices"], batch["numbers"], batch["value"]
    log_probability, entropy = torch.zeros_like(values), torch.zeros_like(values)
    categorical = choices.shape[1]
    for g, group in enumerate(torch.split(logits, list(groups), dim=1)):
        if g < categorical:
            log_p = torch.log_softmax(group, dim=1)
            log_probability = log_probability + log_p.gather(1, choices[:, g : g + 1])[:, 0]
            entropy = entropy - (log_p.exp() * log_p).sum(dim=1)
        else:  # a normal distribution, given by its mean and log standard deviation
            spread = group[:, 1].clamp(float(LEAST), float(MOST))
            z = (numbers[:, g - categorical] - group[:, 0]) * (-spread).exp()
            log_probability = log_probability - (0.5 * z * z + spread + float(HALF_LOG_2_PI))
            entropy = entropy + spread + float(HALF_LOG_2_PI) + 0.5
    advantage = (batch["advantage"] - shift) * scale
    log_ratio = log_probability - batch["log_probability"]
    ratio = log_ratio.exp()
    clipped = ratio.clamp(1 - clip, 1 + clip)
    policy_loss = -torch.minimum(ratio * advantage, clipped * advantage)
    target = old_value + batch["advantage"]
    value_loss = (values - target) ** 2
    if ppo.clip_value:
        held = old_value + (values - old_value).clamp(-ppo.clip_value, ppo.clip_value)
        value_loss = torch.maximum(value_loss, (held - target) ** 2)
    loss = policy_loss - entropy_weight * entropy + ppo.value_weight * value_loss
    return loss, (policy_loss, value_loss, entropy, ratio - 1 - log_ratio, (ratio != clipped).float())
