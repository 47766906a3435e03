"""Measure the cost of a brain for every animal: ms per tick for inference, storage and learning by PPO.

    python benchmarks/individual_ppo.py [--sizes 300 1000 3000] [--threads 1 2]

Each animal has its own weights, Adam optimizer and 32-tick rollout, and uses each transition in 4 epochs; all
were born in the same tick. For comparison, the same run also times the same networks and loss in torch
(baddbmm and autograd over the whole population, torch.optim.Adam); all animals learn every 32 ticks. Work on
one thread is measured in processor time, which other processes disturb less, and work on several threads in
wall-clock time.
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

from ecs_eco import World
from ecs_eco.components import Experience, Policy
from ecs_eco.learning import PPO, Individuals, choose

SETTINGS = PPO(horizon=32, epochs=4, learning_rate=1e-3)
PARTS = ("inference", "choice", "storage", "learning")


class Herd:
    """A population with random observations and rewards that times each part of its ticks."""

    def __init__(
        self, n: int, n_observations: int, hidden: tuple[int, ...], actions: int, threads: int
    ) -> None:
        self.minds = Individuals(n_observations, (actions,), hidden, SETTINGS, 1)
        self.world = World(threads=threads)
        self.table = self.world.add_table("animal", Policy, Experience, dims=self.minds.dims)
        self.uid = np.arange(1, n + 1, dtype=np.uint64)
        self.rows = self.table.occupy(n, 1, 0, {(Policy, "weights"): self.minds.draw(self.uid, 3)})
        rng = np.random.default_rng(0)
        self.seen, self.chance = (
            rng.standard_normal((8, n, n_observations), dtype=np.float32),
            rng.random((n, 1), dtype=np.float32),
        )
        self.choice, self.log_probability = np.empty((n, 1), np.int16), np.empty(n, np.float32)
        self.clock = time.process_time if threads == 1 else time.perf_counter
        self.tick = 0

    def live(self) -> list[float]:
        """Run one tick; return the time of its PARTS [s]. As in a run, recent tick times decide whether
        threads share the work."""
        times: list[float] = []
        self.world.workers.tick(lambda: times.extend(self._live()), lambda: len(self.rows))
        return times

    def _live(self) -> list[float]:
        minds, rows, split, x = self.minds, self.rows, self.world.split, self.seen[self.tick % 8]
        policy, experience, times = self.table[Policy], self.table[Experience], [self.clock()]
        logits, values = minds.forward(policy, rows, x, split)
        times.append(self.clock())
        minds.credit(experience, rows, x[:, 0])
        times.append(self.clock())
        due = np.flatnonzero(minds.due(experience, rows, self.uid, self.table.born[rows], self.tick))
        minds.learn(policy, experience, rows[due], self.uid[due], values[due], None, split)
        times.append(self.clock())
        choose(logits, minds.offsets, self.chance, self.choice, self.log_probability)
        times.append(self.clock())
        minds.store(experience, rows, x, self.choice, self.log_probability, values)
        times.append(self.clock())
        self.tick += 1
        think, credit, learn, choosing, store = np.diff(times)
        return [think, choosing, credit + store, learn]


class Plain:
    """The same population as stacked tensors."""

    def __init__(self, n: int, n_observations: int, hidden: tuple[int, ...], actions: int) -> None:
        widths = (n_observations, *hidden, actions + 1)
        self.layers = [
            (torch.nn.Parameter(torch.randn(n, a, b) / a**0.5), torch.nn.Parameter(torch.zeros(n, 1, b)))
            for a, b in zip(widths, widths[1:], strict=False)
        ]
        self.parameters = [p for layer in self.layers for p in layer]
        self.adam = torch.optim.Adam(self.parameters, SETTINGS.learning_rate, eps=SETTINGS.adam_epsilon)
        horizon = SETTINGS.horizon
        self.now, self.x = torch.randn(n, 1, n_observations), torch.randn(n, horizon, n_observations)
        self.choice, self.reward = torch.randint(0, actions, (n, horizon, 1)), torch.randn(n, horizon)

    def forward(self, x: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return logits [n, t, actions] and values [n, t]."""
        for matrix, bias in self.layers[:-1]:
            x = torch.tanh(torch.baddbmm(bias, x, matrix))
        x = torch.baddbmm(self.layers[-1][1], x, self.layers[-1][0])
        return x[..., :-1], x[..., -1]

    def act(self) -> None:
        """Run inference for one tick."""
        with torch.inference_mode():
            self.forward(self.now)

    def update(self) -> None:
        """Train the whole population on its rollouts."""
        s = SETTINGS
        with torch.no_grad():
            logits, old = self.forward(self.x)
            then = torch.log_softmax(logits, 2).gather(2, self.choice)[..., 0]
            later, gain, gains = (
                torch.zeros_like(old[:, 0]),
                torch.zeros_like(old[:, 0]),
                torch.empty_like(old),
            )
            for t in range(s.horizon - 1, -1, -1):
                gain = self.reward[:, t] + s.discount * later - old[:, t] + s.discount * s.gae_lambda * gain
                later, gains[:, t] = old[:, t], gain
            target = gains + old
            advantage = (gains - gains.mean(1, keepdim=True)) / (
                gains.std(1, keepdim=True, correction=0) + 1e-8
            )
        for _ in range(s.epochs):
            logits, value = self.forward(self.x)
            p = torch.log_softmax(logits, 2)
            ratio = torch.exp(p.gather(2, self.choice)[..., 0] - then)
            loss = -torch.minimum(ratio * advantage, ratio.clamp(1 - s.clip, 1 + s.clip) * advantage)
            loss = loss + s.entropy_coef * (p.exp() * p).sum(2) + s.value_weight * (value - target) ** 2
            self.adam.zero_grad()
            loss.mean(1).sum().backward()
            gradients = [g for q in self.parameters if (g := q.grad) is not None]
            norm = torch.stack([g.flatten(1).square().sum(1) for g in gradients]).sum(0).sqrt()
            hold = (s.max_grad_norm / (norm + 1e-6)).clamp(max=1)[:, None, None]
            for g in gradients:
                g.mul_(hold)
            self.adam.step()


def shortest(work: Callable[[], object], repeats: int, threads: int) -> float:
    """Return the shortest of several timings [ms]."""
    clock, times = time.process_time if threads == 1 else time.perf_counter, []
    for _ in range(repeats):
        start = clock()
        work()
        times.append(clock() - start)
    return min(times) * 1e3


def measure(n: int, network: tuple[int, tuple[int, ...], int], threads: int, repeats: int) -> dict[str, Any]:
    """Time one population alternately with our code and with plain torch."""
    torch.set_num_threads(threads)
    herd, plain, horizon = Herd(n, *network, threads), Plain(n, *network), SETTINGS.horizon
    for _ in range(horizon):
        herd.live()
    plain.act()
    plain.update()
    rounds, acts, updates = [], [], []
    for _ in range(repeats):  # one horizon each, so every animal learns once
        rounds.append(np.mean([herd.live() for _ in range(horizon)], axis=0) * 1e3)
        acts.append(shortest(plain.act, 10, threads))
        updates.append(shortest(plain.update, 1, threads) / horizon)
    ms = min(rounds, key=sum)
    columns = herd.table.nbytes
    return {
        "animals": n,
        "network": "-".join(map(str, (network[0], *network[1], network[2]))),
        "threads": threads,
        "ticks/s": float(1e3 / ms.sum()),
        **{f"{part}, ms": float(t) for part, t in zip(PARTS, ms, strict=True)},
        "inference in torch, ms": min(acts),
        "learning in torch, ms": min(updates),
        "times as fast": float((min(acts) + min(updates)) / (ms[0] + ms[3])),
        "MiB of columns": columns / 2**20,
    }


def main() -> None:
    """Measure all sizes in turn."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[300, 1000, 3000])
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeats", type=int, default=8)
    options = parser.parse_args()
    measure(40, (16, (16,), 8), 1, 1)  # compiles
    small, large = (16, (16,), 8), (24, (32,), 8)
    rows = [measure(options.sizes[0], small, 1, options.repeats)]
    rows += [
        measure(n, large, threads, options.repeats) for n in options.sizes for threads in options.threads
    ]
    _bench.save("individual_ppo", "A brain for every animal: inference and learning per tick", rows)


if __name__ == "__main__":
    main()
