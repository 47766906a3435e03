"""Stable-Baselines3's PPO trains deer in slots; the trained policy then runs in the world.

python examples/rl_slots.py 200000      # about a minute; needs the `rl` extra and stable-baselines3
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from torch import nn

from ecs_eco import World
from ecs_eco.learning import from_torch
from ecs_eco.rl import slots, vec_env

GRAZING = Path(__file__).parent / "grazing.toml"


def sequential(model: Any) -> nn.Sequential:
    """Return a model's policy as a plain Sequential of Linear and Tanh layers."""
    policy = model.policy
    return nn.Sequential(*policy.mlp_extractor.policy_net, policy.action_net)


def train(steps: int, seed: int, look: Callable[[int, nn.Module], Any] = lambda *_: None) -> nn.Sequential:
    """Train for `steps` steps, summed over slots; `look(steps so far, policy)` is called after each
    rollout."""
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback

    class Look(BaseCallback):
        def _on_step(self) -> bool:
            return True

        def _on_rollout_start(self) -> None:
            look(self.num_timesteps, sequential(self.model))

    torch.set_num_threads(1)
    envs = slots(GRAZING, "deer", 64, training=True, max_cycles=10**6)  # always 64 deer
    model = PPO(
        "MlpPolicy",
        vec_env(envs),
        n_steps=64,
        batch_size=1024,
        n_epochs=3,
        learning_rate=1e-3,
        gamma=0.95,
        ent_coef=0.003,
        seed=seed,
        device="cpu",
    )
    model.learn(steps, callback=Look())
    look(model.num_timesteps, sequential(model))
    return sequential(model)


if __name__ == "__main__":
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 4096
    policy = from_torch(train(steps, seed=1))
    world = World.from_config(GRAZING, seed=1, policies={"deer": policy}).run(300)
    print(f"after {steps} steps with Stable-Baselines3:", world)
