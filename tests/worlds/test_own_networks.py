"""Torch modules of one's own in a world: shared and individual, with a memory and without."""

import numpy as np
import pytest
import torch
from torch import nn

from ecs_eco import World
from ecs_eco.components import Memory, Policy
from ecs_eco.engine.errors import ConfigError
from ecs_eco.learning import MLP, Brain, ModuleBrain, from_torch
from tests.learning.networks import Gru, Lstm, Plain

LEARN = {"horizon": 8, "minibatch_size": 512, "epochs": 2, "unroll": 4}
BREED = {"kind": "asexual", "rate": 0.05, "energy_min": 0.4, "energy_given": 0.2, "dispersal": 3.0}


def herd(meadow, network, kind="shared", learn=True, ppo=None, options=None, **policy):
    """A meadow whose deer have this network, are born and die."""
    deer = {
        "count": 30,
        "policy": {"kind": kind, "network": network, "learn": learn, **policy},
        "ppo": LEARN | (ppo or {}),
        "reproduction": BREED,
    }
    return meadow(
        options={"seed": 4, **(options or {})},
        grass={"count": 60, "metabolism": {"energy": 0.5, "photosynthesis": 0.05}},
        **deer,
    )


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["shared", "individual"])
@pytest.mark.parametrize("network", [Plain, Gru, Lstm])
def test_a_world_with_modules_goes_on_from_a_checkpoint_bit_by_bit(meadow, tmp_path, network, kind):
    whole = herd(meadow, network, kind).run(40)
    begun = herd(meadow, network, kind).run(17)
    again = World.restore(begun.save(tmp_path / "world.safetensors"), trust=True).run(23)
    assert whole.digest() == again.digest()
    assert whole.next_uid > 95  # some were born


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["shared", "individual"])
@pytest.mark.parametrize("network", [Plain, Gru])
def test_threads_change_no_bit(meadow, network, kind):
    before = torch.get_num_threads()
    digests = set()
    for threads in (1, 2):
        torch.set_num_threads(threads)
        digests.add(herd(meadow, network, kind, options={"threads": threads}).run(30).digest())
    torch.set_num_threads(before)
    assert len(digests) == 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["shared", "individual"])
@pytest.mark.parametrize("network", [Plain, Gru])
def test_what_learns_changes_and_what_does_not_stays(meadow, network, kind):
    for learn in (True, False):
        world = herd(meadow, network, kind, learn)
        table = world.tables["deer"]
        nerves = table.species.nerves

        def weights(table=table, nerves=nerves):
            if nerves.brain is not None:
                return {0: nerves.brain.state()["policy.weight"]}
            rows = table.rows()
            return dict(zip(table.uid[rows].tolist(), table[Policy].weights[rows], strict=True))

        before = weights()
        after = world.run(20) and weights()
        stayed = before.keys() & after.keys()
        assert stayed
        assert any((before[who] != after[who]).any() for who in stayed) == learn


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["shared", "individual"])
def test_a_newborn_remembers_nothing_and_a_memory_follows_its_organism(meadow, kind):
    world = herd(meadow, Gru, kind)
    table = world.tables["deer"]
    world.run(5)
    assert (table[Memory].state[table.rows()] != 0).any(axis=1).all()
    born = []
    world.on_birth.append(
        lambda t, rows, *_: born.extend([] if t is not table else np.abs(t[Memory].state[rows]).max(axis=1))
    )
    world.run(30)
    assert len(born) > 3
    assert not any(born)


def test_a_memory_is_what_the_network_made_of_all_that_was_sensed(meadow):
    world = herd(meadow, Gru, learn=False)
    table = world.tables["deer"]
    nerves = table.species.nerves
    uid = int(table.uid[table.by_uid()[0]])
    module, state = world.policy("deer"), torch.zeros(1, 16)
    for _ in range(6):
        world.run(1)
        x = nerves.x[table.uid[nerves.rows] == uid]
        with torch.no_grad():
            _, _, state = module(torch.from_numpy(x), state)
    row = table.rows()[table.uid[table.rows()] == uid]
    np.testing.assert_allclose(table[Memory].state[row], state.numpy(), rtol=1e-4, atol=1e-5)


def test_a_plain_module_goes_the_fast_way_and_any_other_through_autograd(meadow):
    for network, kind in ((MLP, Brain), (Plain, ModuleBrain), (None, Brain)):
        assert type(herd(meadow, network).tables["deer"].species.nerves.brain) is kind


def test_a_policy_can_be_had_as_a_module_and_put_into_another_world(meadow):
    world = herd(meadow, None).run(20)
    module = world.policy("deer")
    other = herd(meadow, None, options={"policies": {"deer": module}, "seed": 9})
    ours, theirs = (w.tables["deer"].species.nerves.brain.state() for w in (world, other))
    assert all(np.array_equal(ours[name], theirs[name]) for name in ours)
    own = herd(meadow, Gru).run(20)
    copied = herd(meadow, Gru, options={"policies": {"deer": own.policy("deer")}, "seed": 9})
    ours, theirs = (w.tables["deer"].species.nerves.brain.state() for w in (own, copied))
    assert all(np.array_equal(ours[name], theirs[name]) for name in ours)


@pytest.mark.parametrize("network", [None, Plain])
def test_a_policy_of_an_individual_is_that_of_its_uid(meadow, network):
    world = herd(meadow, network, "individual").run(20)
    table, nerves = world.tables["deer"], world.tables["deer"].species.nerves
    uid = int(table.uid[nerves.rows[3]])
    logits, _ = nerves.think(table, world)
    theirs = world.policy("deer", uid)(torch.from_numpy(nerves.x[3:4].copy()))[0]
    np.testing.assert_allclose(theirs.detach().numpy(), logits[3:4], rtol=1e-3, atol=1e-5)
    with pytest.raises(ConfigError, match="each deer has its own policy"):
        world.policy("deer")


def test_a_sequential_trained_elsewhere_decides_in_a_world(meadow):
    channels = len(herd(meadow, None).tables["deer"].species.nerves.channels)
    net = nn.Sequential(nn.Linear(channels, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, 6))
    world = herd(meadow, None, learn=False, options={"policies": {"deer": from_torch(net)}}).run(3)
    nerves = world.tables["deer"].species.nerves
    logits, _ = nerves.think(world.tables["deer"], world)
    np.testing.assert_allclose(logits, net(torch.from_numpy(nerves.x)).detach().numpy(), rtol=1e-4, atol=1e-5)


class Wrong(nn.Module):
    """Its values have an axis too many."""

    def __init__(self, n_observations, groups):
        super().__init__()
        self.policy, self.value = nn.Linear(n_observations, sum(groups)), nn.Linear(n_observations, 1)

    def forward(self, observations):
        return self.policy(observations), self.value(observations)


@pytest.mark.parametrize("kind", ["shared", "individual"])
def test_a_module_that_cannot_be_is_refused_before_the_first_tick_with_its_species_and_shapes(meadow, kind):
    with pytest.raises(ConfigError) as error:
        herd(meadow, Wrong, kind)
    text = str(error.value)
    assert "species.deer.policy.network" in text
    assert "gives values f32[3, 1]; it should give logits f32[3, 6] and values f32[3]" in text


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"network": "learning.mlp:Mlp"}, "names code in learning.mlp, which `code` does not list"),
        ({"network": Plain, "hidden": [8]}, "the class of the network defines its layers"),
        ({"network": Plain, "kind": "none"}, "no network uses it"),
        ({"network": 3}, "policy.network"),
        ({"device": "gpu"}, "policy.device"),
        ({"device": 1}, "policy.device"),
    ],
)
def test_what_a_world_file_says_wrong_of_a_network_is_named(meadow, given, message):
    with pytest.raises(ConfigError) as error:
        meadow(policy={"kind": "shared", **given})
    assert message in str(error.value), str(error.value)


def test_a_module_of_another_class_than_the_world_names_is_refused(meadow):
    with pytest.raises(ConfigError, match="policies"):
        herd(meadow, None, options={"policies": {"deer": Gru(1, (3, 3))}})
    with pytest.raises(ConfigError, match="argument"):
        herd(meadow, None, options={"policies": Gru(1, (3, 3))})
