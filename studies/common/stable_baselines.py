"""Stable-Baselines3 with our settings, for studies that compare it with our PPO; requires
stable-baselines3."""

from __future__ import annotations

from typing import Any

from ecs_eco.learning import PPO, Training


def settings(ppo: PPO, anneal: bool) -> dict[str, Any]:
    """Return the hyperparameters under Stable-Baselines3's names; with `anneal`, the learning rate and clip
    range fall linearly to 0."""

    def schedule(value: float) -> Any:
        return (lambda left: left * value) if anneal else value

    return {
        "n_steps": ppo.horizon,
        "batch_size": ppo.minibatch_size,
        "n_epochs": ppo.epochs,
        "gamma": ppo.discount,
        "gae_lambda": ppo.gae_lambda,
        "ent_coef": ppo.entropy_coef,
        "learning_rate": schedule(ppo.learning_rate),
        "clip_range": schedule(ppo.clip),
    }


def learn(model: Any, steps: int, threshold: float) -> Training:
    """Train a model for `steps`, or until the last 100 episodes have a mean return of `threshold` after a
    rollout. Return its episodes, with returns in the environments' unit (from their Monitor)."""
    import torch
    from stable_baselines3.common.callbacks import BaseCallback

    class Episodes(BaseCallback):
        """Records each episode's return and the number of steps so far."""

        def __init__(self) -> None:
            super().__init__()
            self.training = Training(brain=None)  # type: ignore[arg-type]
            self.reached = False

        def _on_step(self) -> bool:
            ended = [info["episode"]["r"] for info in self.locals["infos"] if "episode" in info]
            self.training.returns += ended
            self.training.steps += [self.num_timesteps] * len(ended)
            return not self.reached

        def _on_rollout_end(self) -> None:
            self.reached = self.training.steps_to(threshold) is not None

    torch.set_num_threads(1)
    episodes = Episodes()
    model.learn(steps, callback=episodes)
    return episodes.training
