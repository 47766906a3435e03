"""One organism as an environment, and what Gymnasium makes by name."""

import warnings

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="ecs-eco[rl] is not installed")

from gymnasium.utils.env_checker import check_env

from ecs_eco import World
from ecs_eco.components import Metabolism
from ecs_eco.engine.errors import ConfigError
from ecs_eco.rl import ENVIRONMENTS, body, slots
from tests.rl.worlds import PASTURE, ROAMING


def test_gymnasium_finds_nothing_wrong_with_it():
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*infinity")  # energy has no bounds
        warnings.filterwarnings("ignore", ".*alternative render modes")  # it was not made by its name
        check_env(body(PASTURE, "deer", render_mode="rgb_array"))


def test_a_life_ends_with_death_and_the_next_is_in_the_same_world():
    env = body(PASTURE, "deer")
    x, info = env.reset(seed=1)
    world, uid = env.arena.world, info["uid"]
    world.get(uid, Metabolism).energy = -5.0
    last, reward, dead, _, info = env.step([0, 0])
    assert dead
    assert reward == pytest.approx(-1.0 - x[0])
    assert last.tolist() == x.tolist()
    assert info == {"uid": uid, "cause": "starved"}
    with pytest.raises(RuntimeError, match="reset"):
        env.step([0, 0])
    assert env.reset()[1]["uid"] != uid
    assert env.arena.world is world
    env.reset(seed=1)
    assert env.arena.world is not world


@pytest.mark.parametrize("make", [body, lambda *of: slots(*of, 3)])
def test_a_species_without_members_is_refused_when_an_episode_begins(make):
    empty = World.from_config(
        {**PASTURE, "species": PASTURE["species"] | {"deer": PASTURE["species"]["deer"] | {"count": 0}}},
        learn=False,
        record=False,
    )
    for world in (empty.config, empty):
        with pytest.raises(ConfigError, match="has no members at the start of an episode"):
            make(world, "deer").reset(seed=1)
        with pytest.raises(ConfigError, match="has no members at the start of an episode"):
            make(world, "deer").reset()


def test_a_flattened_action_is_the_same_as_that_of_its_groups():
    ways = [body(ROAMING, "deer", flat=flat) for flat in (False, True)]
    for env in ways:
        env.reset(seed=1)
    assert ways[1].action_space == gymnasium.spaces.Box(-1, 1, (2,), np.float32)
    assert isinstance(ways[0].action_space, gymnasium.spaces.Dict)
    seen = [
        env.step(action)[0].tolist()
        for env, action in zip(
            ways, ({"speed": 1, "turn": np.float32(0.1)}, np.array([0.4, 0.5])), strict=True
        )
    ]
    assert seen[0] == seen[1]
    assert ways[0].arena.world.digest() == ways[1].arena.world.digest()


def test_a_life_is_truncated_when_the_world_is_old():
    env = body(PASTURE, "deer", max_cycles=2)
    env.reset(seed=1)
    assert env.step([0, 0])[2:4] == (False, False)
    assert env.step([0, 0])[2:4] == (False, True)
    env.reset()
    assert env.arena.world.tick == 0


@pytest.mark.parametrize("name", ["Deer-v0", "Copepod-v0"])
def test_what_is_registered_is_made_and_lives(name):
    env = gymnasium.make(f"ecs_eco/{name}")
    env.action_space.seed(3)
    x, _ = env.reset(seed=3)
    assert x in env.observation_space
    for _ in range(3):
        x, reward, died, *_ = env.step(env.action_space.sample())
        assert np.isfinite(x).all()
        assert np.isfinite(reward)
        if died:
            env.reset()
    assert env.spec.max_episode_steps == 1000


def test_a_vector_of_them_is_slots():
    envs = gymnasium.make_vec("ecs_eco/Wolf-v0", num_envs=3)
    assert type(envs.unwrapped) is type(slots(PASTURE, "deer", 1))
    assert envs.reset(seed=1)[0].shape == (3, *envs.single_observation_space.shape)
    assert envs.unwrapped.arena.cycles == 1000


def test_all_that_is_registered_names_species_that_choose():
    from ecs_eco.config import load

    for world, species in ENVIRONMENTS.values():
        chosen = load(world).species[species]
        assert chosen.policy.kind != "none"
        assert chosen.happiness is not None
