"""Measure the cost of inference and learning: ns per row per tick, and µs per transition with all its epochs.

    python benchmarks/ppo.py [--sizes 1000 10000 100000] [--threads 1 2]

The network has 24 observations, two layers of 64 tanh units shared by policy and value, and two groups of
three actions; an update has 3 epochs with minibatches of 8,192. For comparison, the same network and loss are
also run with torch's autograd and torch.optim.Adam. Work on one thread is measured in processor time, which
other processes disturb less, and work on several threads in wall-clock time.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numpy as np
import torch

from ecs_eco.compiled.workers import Workers
from ecs_eco.learning import PPO, Brain, Learner, choose
from ecs_eco.learning.gradient import BLOCK, backward, forward, gather_observations, layout_of
from ecs_eco.learning.loss import LossSettings, allocate_scratch, gather_transitions, output_gradient
from ecs_eco.learning.torch_ppo import CHUNK

WIDTH, GROUPS, SETTINGS = 24, (3, 3), PPO()


def best_of(work: Callable[[], object], repeats: int, threads: int = 1) -> float:
    """Return the shortest of several timings [s]."""
    clock, times = time.process_time if threads == 1 else time.perf_counter, []
    for _ in range(repeats):
        start = clock()
        work()
        times.append(clock() - start)
    return min(times)


def fill(learner: Learner, n: int, ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """Store ticks of n rows with random observations and rewards."""
    rng, brain, rows = np.random.default_rng(0), learner.brain, np.arange(n)
    choice, log_probability = np.empty((n, len(GROUPS)), np.int16), np.empty(n, np.float32)
    for _ in range(ticks):
        seen = rng.standard_normal((n, WIDTH), dtype=np.float32)
        logits, values = brain.forward(seen)
        choose(logits, brain.offsets, rng.random(choice.shape, dtype=np.float32), choice, log_probability)
        learner.rollout.store(rows, seen, choice, log_probability, values)
        learner.rollout.credit(rows, seen[:, 0])
    return rows, values


def plain(brain: Brain) -> torch.nn.Module:
    """Return the same network as torch modules."""

    class Plain(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.trunk = torch.nn.Sequential(
                torch.nn.Linear(WIDTH, 64), torch.nn.Tanh(), torch.nn.Linear(64, 64), torch.nn.Tanh()
            )
            self.policy, self.value = torch.nn.Linear(64, sum(GROUPS)), torch.nn.Linear(64, 1)

        def forward(self, x: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
            h = self.trunk(x)
            return self.policy(h), self.value(h)[:, 0]

    return Plain()


def plain_update(net: torch.nn.Module, adam: torch.optim.Optimizer, learner: Learner) -> None:
    """Learn by autograd from a rollout with known advantages."""
    rollout = learner.rollout
    seen, choices = torch.from_numpy(rollout.observations), torch.from_numpy(rollout.choices.astype(np.int64))
    then, old, gain = (
        torch.from_numpy(rollout.steps[name].copy()) for name in ("log_probability", "value", "advantage")
    )
    advantage, target = (gain - gain.mean()) / (gain.std() + 1e-8), gain + old
    for _ in range(SETTINGS.epochs):
        for index in torch.randperm(rollout.n).split(SETTINGS.minibatch_size):
            logits, value = net(seen[index])
            parts = [torch.log_softmax(part, 1) for part in logits.split(GROUPS, 1)]
            now = sum(p.gather_transitions(1, choices[index, g : g + 1])[:, 0] for g, p in enumerate(parts))
            entropy = -sum((p.exp() * p).sum(1).mean() for p in parts)
            ratio, a = torch.exp(now - then[index]), advantage[index]
            policy = -torch.min(ratio * a, ratio.clamp(1 - SETTINGS.clip, 1 + SETTINGS.clip) * a).mean()
            loss = policy - SETTINGS.entropy_coef * entropy
            loss = loss + SETTINGS.value_weight * ((value - target[index]) ** 2).mean()
            adam.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(net.parameters(), SETTINGS.max_grad_norm)
            adam.step()


def measure(n: int, threads: int) -> dict[str, Any]:
    """Time inference and learning for n rows, alternately with our code and with plain torch."""
    learner = Learner(Brain(WIDTH, GROUPS), SETTINGS, 0, threads)
    brain, ticks = learner.brain, max(4, min(64, 640_000 // n))
    split = Workers(threads).split
    net = plain(brain)
    adam = torch.optim.Adam(net.parameters(), SETTINGS.learning_rate, eps=SETTINGS.adam_epsilon)
    seen = np.random.default_rng(1).standard_normal((n, WIDTH), dtype=np.float32)
    uniforms, choice = np.random.default_rng(2).random((n, 2), dtype=np.float32), np.empty((n, 2), np.int16)
    log_probability = np.empty(n, np.float32)

    def act() -> None:
        logits, _ = brain.forward(seen, split)
        choose(logits, brain.offsets, uniforms, choice, log_probability)

    def act_plain() -> None:
        with torch.inference_mode():
            for start in range(0, n, CHUNK):
                logits, _ = net(torch.from_numpy(seen[start : start + CHUNK]))
                for part in logits.split(GROUPS, 1):
                    torch.distributions.Categorical(logits=part).sample()

    acting, acting_plain = (best_of(work, 20, threads) / n * 1e9 for work in (act, act_plain))
    times: dict[str, list[float]] = {"ours": [], "plain": []}
    for _ in range(4):
        batch = fill(learner, n, ticks)
        times["ours"].append(best_of(lambda b=batch: learner.update(*b), 1, threads) / (n * ticks) * 1e6)
        batch = fill(learner, n, ticks)
        learner.rollout.advantages(*batch, SETTINGS.gae_lambda)
        times["plain"].append(best_of(lambda: plain_update(net, adam, learner), 1) / (n * ticks) * 1e6)
        learner.rollout.clear()
    return {
        "rows": n,
        "transitions": n * ticks,
        "threads": threads,
        "inference, ns per row": acting,
        "inference in plain torch, ns per row": acting_plain,
        "learning, µs per transition": min(times["ours"]),
        "learning in plain torch, µs per transition": min(times["plain"]),
        "bytes per transition": learner.rollout.nbytes_per_transition,
    }


def breakdown(n: int = 10_000, ticks: int = 64) -> dict[str, float]:
    """Return how long [ns] each part of one use of a transition takes."""
    learner = Learner(Brain(WIDTH, GROUPS), SETTINGS, 0)
    brain, rollout = learner.brain, learner.rollout
    batch = fill(learner, n, ticks)
    rollout.advantages(*batch, 0.95)
    layers, offsets = brain.layers, brain.offsets
    layout, loss = layout_of(layers, BLOCK), allocate_scratch(offsets, 0, BLOCK)
    scratch = np.zeros(layout.end, np.float32)
    scratch[layout.weights : layout.weights + brain.size] = brain.weights
    settings = LossSettings(*np.array([0.2, 0, 0.01, 0.5, 0, 1], "f4"))
    order = np.random.default_rng(3).permutation(rollout.n)
    blocks = iter(np.tile(order[: rollout.n // BLOCK * BLOCK], 20).reshape(-1, BLOCK))
    log = rollout.steps, rollout.choices, rollout.numbers
    parts: dict[str, Callable[[], object]] = {
        "observations, gathered": lambda: gather_observations(rollout.observations, next(blocks), scratch),
        "forward": lambda: forward(scratch, layout, layers, BLOCK),
        "the rest, gathered": lambda: gather_transitions(loss, *log, offsets, next(blocks), np.float32(1e-4)),
        "slopes of the loss": lambda: output_gradient(
            scratch, layout.deltas, layers, BLOCK, BLOCK, offsets, settings, loss
        ),
        "backward": lambda: backward(scratch, layout, layers, BLOCK, BLOCK),
    }
    result = {}
    for name, part in parts.items():
        part()
        result[f"{name}, ns per use"] = best_of(part, 1000) / BLOCK * 1e9
    result["shuffle, ns per use"] = (
        best_of(lambda: np.random.default_rng(3).permutation(rollout.n), 5) / rollout.n * 1e9
    )
    rollout_time = best_of(lambda: rollout.advantages(*batch, 0.95), 5)
    result["advantages, ns per transition"] = rollout_time / rollout.n * 1e9
    return {name: round(value, 1) for name, value in result.items()}


def main() -> None:
    """Measure all sizes in turn."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[1000, 10_000, 100_000])
    parser.add_argument("--threads", type=int, nargs="+", default=[1])
    parser.add_argument("--name", default="ppo")
    options = parser.parse_args()
    torch.set_num_threads(1)
    rows = [measure(n, threads) for n in options.sizes for threads in options.threads]
    notes = breakdown()
    _bench.save(options.name, "Inference and learning of a 24-64-64-6 network", rows, notes)
    print(notes)


if __name__ == "__main__":
    main()
