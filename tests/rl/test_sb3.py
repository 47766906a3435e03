"""Stable-Baselines3 trains on slots, and what it learns decides in the world as it does outside."""

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="ecs-eco[rl] is not installed")
stable_baselines3 = pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed")

from ecs_eco.components import Metabolism
from ecs_eco.rl import slots, vec_env
from tests.rl.worlds import PASTURE, ROAMING


@pytest.mark.parametrize("world", [PASTURE, ROAMING], ids=["options", "options and numbers"])
def test_its_ppo_trains_on_slots(world):
    model = stable_baselines3.PPO(
        "MlpPolicy",
        vec_env(slots(world, "deer", 5)),
        n_steps=16,
        batch_size=40,
        n_epochs=1,
        seed=1,
        device="cpu",
    )
    before = model.policy.action_net.weight.detach().clone()
    model.learn(200)
    assert (model.policy.action_net.weight != before).any()


def test_the_dead_and_the_late_have_their_last_observation():
    envs = vec_env(slots(PASTURE, "deer", 3, max_cycles=2))
    envs.seed(1)
    x = envs.reset()
    uid = int(envs.envs.uid[1])
    envs.envs.arena.world.get(uid, Metabolism).energy = -5.0
    later, reward, done, infos = envs.step(np.zeros((3, 2), int))
    assert done.tolist() == [False, True, False]
    assert infos[1]["terminal_observation"].tolist() == x[1].tolist()
    assert not infos[1]["TimeLimit.truncated"]
    assert reward.dtype == np.float32
    *_, done, infos = envs.step(np.zeros((3, 2), int))
    assert done.all()
    assert all(info["TimeLimit.truncated"] for info in infos)
    assert later.shape == (3, 4)
