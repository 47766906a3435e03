"""CleanRL-style PPO on PettingZoo's dicts, while agents are born and die. `python examples/rl_parallel.py
130000` takes about a minute; it needs the `rl` extra."""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.distributions import Categorical

from ecs_eco import World
from ecs_eco.learning import from_torch
from ecs_eco.rl import parallel_env

GRAZING = Path(__file__).parent / "grazing.toml"
HORIZON, EPOCHS, MINIBATCH, RATE, GAMMA, LAMBDA, CLIP, ENTROPY = 64, 3, 1024, 1e-3, 0.95, 0.95, 0.2, 0.003


class Agent(nn.Module):
    def __init__(self, n: int, sizes: list[int]) -> None:
        super().__init__()
        self.sizes, nets = sizes, [[n, 64, 64, sum(sizes)], [n, 64, 64, 1]]
        layers = [[layer for a, b in pairwise(net) for layer in (nn.Linear(a, b), nn.Tanh())] for net in nets]
        self.actor, self.critic = (nn.Sequential(*net[:-1]) for net in layers)

    def forward(self, x, action=None):  # -> action [n, groups], log-probability, entropy and value [n]
        groups = [Categorical(logits=part) for part in self.actor(x).split(self.sizes, -1)]
        action = torch.stack([group.sample() for group in groups], 1) if action is None else action
        logs = sum(group.log_prob(action[:, i]) for i, group in enumerate(groups))
        return action, logs, sum(group.entropy() for group in groups), self.critic(x)[:, 0]


@torch.no_grad()
def collect(env, agent: Agent, x: dict) -> tuple[dict, list]:
    """Act; return the final observations and all (x, action, log-probability, advantage, return)."""
    lives, batch = {}, []
    for _ in range(HORIZON):
        names, seen = env.agents, torch.from_numpy(np.stack([x[name] for name in env.agents]))
        actions, logs, _, values = agent(seen)
        x, rewards, *_ = env.step(dict(zip(names, actions.numpy(), strict=True)))
        for i, name in enumerate(names):
            lives.setdefault(name, []).append((seen[i], actions[i], logs[i], float(values[i]), rewards[name]))
    for name, life in lives.items():
        ahead, last = 0.0, float(agent.critic(torch.from_numpy(x[name]))) if name in env.agents else 0.0
        for *step, value, reward in reversed(life):
            ahead, last = reward + GAMMA * last - value + GAMMA * LAMBDA * ahead, value
            batch.append((*step, ahead, ahead + value))
    return x, batch


def train(steps: int, seed: int, look=lambda *_: None) -> nn.Sequential:
    """Train for `steps` steps, summed over agents; `look(steps so far, policy)` is called after each update."""
    torch.manual_seed(seed)
    env, done = parallel_env(GRAZING, "deer", training=True, max_cycles=10**6), 0  # always 64 deer
    agent = Agent(len(env.channels), [len(names) for names in env.options.values()])
    x, optimiser = env.reset(seed=seed)[0], torch.optim.Adam(agent.parameters(), RATE, eps=1e-5)
    while done < steps:
        x, batch = collect(env, agent, x)
        seen, action, old, gain, target = (
            torch.stack([torch.as_tensor(value) for value in part]) for part in zip(*batch, strict=True)
        )
        done, gain = done + len(batch), (gain - gain.mean()) / (gain.std() + 1e-8)
        for part in [part for _ in range(EPOCHS) for part in torch.randperm(len(batch)).split(MINIBATCH)]:
            _, logs, entropy, value = agent(seen[part], action[part])
            ratio, a = (logs - old[part]).exp(), gain[part]
            policy = torch.min(ratio * a, ratio.clamp(1 - CLIP, 1 + CLIP) * a) + ENTROPY * entropy
            optimiser.zero_grad()
            (0.5 * (value - target[part]).square() - policy).mean().backward()
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimiser.step()
        look(done, agent.actor)
    return agent.actor


if __name__ == "__main__":
    policy = from_torch(train(int((sys.argv[1:] or ["2048"])[0]), seed=1))
    print("after PPO on PettingZoo's dicts:", World.from_config(GRAZING, policies={"deer": policy}).run(300))
