"""TorchRL takes slots as they are, sees the dead's last observation, and its PPO trains on them."""

import warnings

import numpy as np
import pytest
import torch
from torch import nn

pytest.importorskip("gymnasium", reason="ecs-eco[rl] is not installed")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pytest.importorskip("torchrl", reason="torchrl is not installed")
    from tensordict.nn import InteractionType, TensorDictModule
    from torchrl.envs import GymWrapper
    from torchrl.modules import ProbabilisticActor, ValueOperator
    from torchrl.objectives import ClipPPOLoss
    from torchrl.objectives.value import GAE

from ecs_eco.rl import slots
from tests.rl.worlds import PASTURE

pytestmark = pytest.mark.filterwarnings("ignore")
STEPS = 300


@pytest.mark.slow
def test_a_rollout_is_what_slots_give_with_the_last_observation_of_the_dead():
    env = GymWrapper(slots(PASTURE, "deer", 4))
    env.set_seed(1)
    torch.manual_seed(2)
    rollout = env.rollout(STEPS, break_when_any_done=False)
    plain = slots(PASTURE, "deer", 4)
    plain.reset(seed=1)
    x, infos = plain.reset()  # TorchRL begins anew after a seed
    deaths = 0
    for tick in range(STEPS):
        now = rollout[:, tick]
        np.testing.assert_array_equal(now["observation"], x)
        np.testing.assert_array_equal(now["mask"], infos["mask"])
        np.testing.assert_array_equal(now["uid"], infos["uid"])
        x, reward, dead, late, infos = plain.step(now["action"].numpy())
        following = x.copy()
        for slot in np.flatnonzero(dead | late):
            following[slot] = infos["final_obs"][slot]
        np.testing.assert_array_equal(now["next", "observation"], following)
        np.testing.assert_array_equal(now["next", "terminated"][:, 0], dead)
        np.testing.assert_allclose(now["next", "reward"][:, 0], reward, rtol=1e-6)
        deaths += int(dead.sum())
        if (dead | late).all():  # then it begins anew
            x, infos = plain.reset()
    assert deaths > 0


def test_its_ppo_trains_on_them():
    bodies = slots(PASTURE, "deer", 4)
    env = GymWrapper(bodies)
    env.set_seed(1)
    torch.manual_seed(1)
    groups, width = bodies.single_action_space.nvec.tolist(), len(bodies.channels)
    net = nn.Sequential(nn.Linear(width, 16), nn.Tanh(), nn.Linear(16, sum(groups)))
    actor = ProbabilisticActor(
        TensorDictModule(net, ["observation"], ["logits"]),
        ["logits"],
        ["action"],
        distribution_class=_Groups,
        distribution_kwargs={"sizes": groups},
        return_log_prob=True,
        default_interaction_type=InteractionType.RANDOM,
    )
    critic = ValueOperator(nn.Sequential(nn.Linear(width, 16), nn.Tanh(), nn.Linear(16, 1)))
    loss = ClipPPOLoss(actor, critic)
    optimiser = torch.optim.Adam(loss.parameters(), 1e-2)
    before = net[2].weight.detach().clone()
    for _ in range(2):
        with torch.no_grad():
            rollout = env.rollout(32, actor, break_when_any_done=False)
            GAE(gamma=0.95, lmbda=0.95, value_network=critic)(rollout)
        parts = loss(rollout[rollout["mask"]])  # empty slots teach nothing
        optimiser.zero_grad()
        sum(part for name, part in parts.items() if name.startswith("loss_")).backward()
        optimiser.step()
    change = (net[2].weight - before).abs().max()
    assert torch.isfinite(change)
    assert change > 0.001


class _Groups(torch.distributions.Distribution):
    """One choice in each group of actions."""

    arg_constraints = {}

    def __init__(self, logits, sizes):
        self.parts = [torch.distributions.Categorical(logits=part) for part in logits.split(sizes, -1)]
        super().__init__(logits.shape[:-1], torch.Size([len(sizes)]), validate_args=False)

    def sample(self, shape=()):
        return torch.stack([part.sample(shape) for part in self.parts], -1)

    rsample = sample

    def log_prob(self, value):
        return sum(part.log_prob(value[..., i]) for i, part in enumerate(self.parts))

    def entropy(self):
        return sum(part.entropy() for part in self.parts)

    @property
    def mode(self):
        return torch.stack([part.probs.argmax(-1) for part in self.parts], -1)
