"""The learner without an ecosystem: PPO on a Gymnasium vector environment (`pip install -e ".[gym]"`)."""

import gymnasium
import numpy as np

from ecs_eco.learning import PPO, train

if __name__ == "__main__":
    envs = gymnasium.make_vec("CartPole-v1", num_envs=16, vectorization_mode="sync")
    ppo = PPO(horizon=64, learning_rate=2.5e-3, minibatch_size=256, epochs=4)
    training = train(envs, ppo, total_steps=20_000, seed=1)
    first, last = np.mean(training.returns[:20]), np.mean(training.returns[-20:])
    print(
        f"{len(training.returns)} episodes: mean return {first:.0f} in the first 20, "
        f"{last:.0f} in the last 20"
    )
