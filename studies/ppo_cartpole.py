"""Claim: PPO as shipped solves CartPole-v1 in as few steps as Stable-Baselines3 with its tuned settings, and sooner.

    python studies/ppo_cartpole.py [--short]

Solved: the mean return of the last 100 episodes is at least 475. Both learn from the same kind of environments, with the
same seeds, in turn, in one thread; speed is environment steps per second of processor time, training and environments
together. Seeds that are in the results already are not repeated. Without stable-baselines3 only ours is measured.
"""

from __future__ import annotations

import hashlib
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.learning import PPO, Training, train

RESULT = Path(__file__).parent / "results" / "ppo_cartpole.json"
SEEDS, STEPS, N_ENVS, SOLVED = range(10), 100_000, 8, 475.0
WITHIN_MEDIAN, WITHIN_MOST = 75_000, 100_000

# Stable-Baselines3's tuned settings for CartPole-v1 (rl-baselines3-zoo), in our words.
TUNED = PPO(
    horizon=32,
    learning_rate=1e-3,
    discount=0.98,
    gae_lambda=0.8,
    epochs=20,
    minibatch=256,
    clip=0.2,
    entropy=0.0,
    anneal=STEPS // N_ENVS,
)


def environments() -> Any:
    """Make the environments, one after the other in one process, as Stable-Baselines3 does."""
    import gymnasium

    return gymnasium.make_vec("CartPole-v1", N_ENVS, vectorization_mode="sync")


def ours(seed: int, steps: int) -> dict[str, Any]:
    """Train until solved or `steps` are over."""
    envs, start = environments(), time.process_time()
    training = train(envs, TUNED, steps, seed, stop=lambda so_far: so_far.steps_to(SOLVED) is not None)
    return _report(training, training.reports[-1]["n_steps"], time.process_time() - start)
