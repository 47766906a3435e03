"""The members of a species are PettingZoo's agents: born, dying, and never back."""

import warnings

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="ecs-eco[rl] is not installed")
pytest.importorskip("pettingzoo", reason="ecs-eco[rl] is not installed")

from pettingzoo.test import parallel_api_test, parallel_seed_test

from ecs_eco import World
from ecs_eco.components import Metabolism
from ecs_eco.engine.errors import ConfigError
from ecs_eco.rl import parallel_env
from tests.rl.worlds import PASTURE


def lived(env, cycles, seed=None):
    """Act at random for some cycles; return what each step gave, and who lived and died."""
    env.reset(seed=seed)
    steps, born, dead = [], set(env.agents), set()
    for _ in range(cycles):
        out = env.step({agent: env.action_space(agent).sample() for agent in env.agents})
        assert len({frozenset(part) for part in out}) == 1  # the same agents in all five
        ended = {agent for agent, over in out[2].items() if over}
        assert not dead & set(out[0])
        dead |= ended
        assert set(env.agents) == set(out[0]) - ended
        born |= set(out[0])
        steps.append(out)
    return steps, born, dead


@pytest.mark.slow
@pytest.mark.parametrize(("pool", "cycles"), [(None, 10_000), (600, 1_000)])
def test_it_passes_the_api_test_over_10_000_cycles_with_births_and_deaths(pool, cycles, monkeypatch):
    env = parallel_env(PASTURE, "deer", pool)
    seen, step = set(), env.step
    monkeypatch.setattr(env, "step", lambda actions: seen.update(actions) or step(actions))
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "(?s).*possible_agents")  # there are none without a pool
        warnings.filterwarnings("ignore", "No agents present.*")  # after the last cycle
        parallel_api_test(env, cycles)
    assert len(seen) > cycles / 20
    assert env.arena.world.tick == cycles


@pytest.mark.slow
@pytest.mark.parametrize("pool", [None, 400])
def test_it_passes_the_seed_test(pool):
    parallel_seed_test(lambda: parallel_env(PASTURE, "deer", pool), 10_000)


@pytest.mark.slow
def test_the_same_seeds_make_the_same_lives():
    first, born, dead = lived(parallel_env(PASTURE, "deer"), 400, seed=4)
    second, *_ = lived(parallel_env(PASTURE, "deer"), 400, seed=4)
    assert len(born) > 15
    assert len(dead) > 8
    for one, other in zip(first, second, strict=True):
        assert {a: x.tolist() for a, x in one[0].items()} == {a: x.tolist() for a, x in other[0].items()}
        assert one[1:] == other[1:]
    third, *_ = lived(parallel_env(PASTURE, "deer"), 20, seed=5)
    assert any(a[0].keys() != b[0].keys() or a[1] != b[1] for a, b in zip(first, third, strict=False))


def test_a_later_episode_is_another_one_and_follows_from_the_seed():
    env, other = parallel_env(PASTURE, "deer"), parallel_env(PASTURE, "deer")
    first = [env.reset(seed=3)[0], env.reset()[0]]
    second = [other.reset(seed=3)[0], other.reset()[0]]
    assert [{a: x.tolist() for a, x in o.items()} for o in first] == [
        {a: x.tolist() for a, x in o.items()} for o in second
    ]
    assert any(first[0][a].tolist() != first[1][a].tolist() for a in first[0])


def test_the_dead_have_a_last_entry_with_reward_and_cause():
    env = parallel_env(PASTURE, "deer")
    seen, _ = env.reset(seed=1)
    one = env.agents[2]
    env.arena.world.get(one, Metabolism).energy = -5.0
    felt = seen[one][0]
    seen, reward, dead, late, infos = env.step({agent: [0, 0] for agent in env.agents})
    assert dead[one]
    assert not late[one]
    assert reward[one] == pytest.approx(-1.0 - felt)
    assert seen[one][0] == pytest.approx(felt)
    assert infos[one] == {"cause": "starved"}
    assert one not in env.agents
    assert not any(one in part for part in env.step({agent: [0, 0] for agent in env.agents}))


def test_all_are_truncated_when_the_time_is_over():
    env = parallel_env(PASTURE, "deer", max_cycles=3)
    env.reset(seed=1)
    for cycle in range(3):
        *_, late, _ = env.step({agent: [0, 0] for agent in env.agents})
        assert set(late.values()) == {cycle == 2}
    assert env.agents == []
    assert env.step({}) == ({}, {}, {}, {}, {})


@pytest.mark.slow
@pytest.mark.parametrize("pool", [None, 400])
def test_who_is_born_in_the_last_step_is_no_agent(pool):
    """Nobody could act for them: PettingZoo takes one who comes with the end for one who died before."""
    env = parallel_env(PASTURE, "deer", pool)
    env.reset(seed=1)
    acted, births = set(env.agents), []
    for cycle in range(1, 200):
        env.step({agent: [0, 0] for agent in env.agents})
        if set(env.agents) - acted:
            births.append(cycle)
        acted |= set(env.agents)
    assert len(births) > 5
    for last in births:
        env.max_cycles = last
        env.reset(seed=1)
        for _ in range(last):
            agents = set(env.agents)
            *_, over, late, _ = env.step({agent: [0, 0] for agent in env.agents})
        assert over.keys() == late.keys() == agents
        assert env.agents == []


def test_an_episode_is_truncated_when_the_pool_is_used_up():
    env = parallel_env(PASTURE, "deer", pool=8)
    env.reset(seed=1)
    assert env.agents == [f"deer_{i}" for i in range(6)]
    late = {}
    while env.agents:
        *_, late, _ = env.step({agent: [0, 0] for agent in env.agents})
    assert all(late.values())
    with pytest.raises(ConfigError, match="smaller than the initial population"):
        parallel_env(PASTURE, "deer", pool=3).reset()


def test_observations_are_in_their_space_and_have_names():
    env = parallel_env(PASTURE, "deer")
    assert env.channels == ("energy", "grass_forward", "grass_left", "grass_near")
    assert env.options == {"speed": ("still", "walk"), "turn": ("left", "none", "right")}
    space = env.observation_space(1)
    assert space.low[1:].tolist() == pytest.approx([-1, -1, 0], abs=1e-5)
    assert space.high[1:].tolist() == pytest.approx([1, 1, 1], abs=1e-5)
    for seen, *_ in lived(env, 100, seed=2)[0]:
        assert all(x in space for x in seen.values())


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda a: a.pop(next(iter(a))), r"no action \(1 such\)"),
        (lambda a: a.update({10_000: [0, 0]}), "10000.*\n.*dead or never born"),
        (lambda a: a.update({next(iter(a)): [0, 3]}), "no such option.*0 .left., 1 .none., 2 .right."),
        (lambda a: a.update({next(iter(a)): [0, np.nan]}), "not a number"),
        (lambda a: a.update({next(iter(a)): [0]}), "for each agent, an action in MultiDiscrete"),
    ],
)
def test_wrong_actions_are_refused_and_the_episode_goes_on(change, says):
    env = parallel_env(PASTURE, "deer")
    env.reset(seed=1)
    actions = {agent: [0, 0] for agent in env.agents}
    change(actions)
    with pytest.raises(ConfigError, match=says):
        env.step(actions)
    env.step({agent: [0, 0] for agent in env.agents})


def test_it_goes_on_from_a_checkpoint_as_without(tmp_path):
    env = parallel_env(PASTURE, "deer")
    env.reset(seed=1)
    for cycle in range(6):
        if cycle == 2:
            path = env.save(tmp_path / "third")
            assert not path.exists()  # a tick is under way
        env.step({agent: [1, agent % 3] for agent in env.agents})
    again = parallel_env(World.restore(path), "deer")
    again.reset()
    for _ in range(3):
        again.step({agent: [1, agent % 3] for agent in again.agents})
    assert again.arena.world.tick == env.arena.world.tick
    for one in (env, again):
        one.arena.door.act([[0, 0]] * len(one.agents))
    assert again.arena.world.digest() == env.arena.world.digest()


def test_it_shows_itself_and_its_state():
    env = parallel_env(PASTURE, "deer", render_mode="rgb_array")
    env.reset(seed=1)
    assert env.render().shape == (480, 480, 3)
    assert len(np.unique(env.render().reshape(-1, 3), axis=0)) == 3  # paper, grass, deer
    assert env.state() in env.state_space
    assert env.state().sum(axis=(1, 2)).tolist() == [12, 6]
    assert parallel_env(PASTURE, "deer").render() is None


@pytest.mark.parametrize(
    ("species", "more", "says"),
    [
        ("dear", {}, 'did you mean "deer"'),
        ("grass", {}, "the species has no reward"),
        ("deer", {"render_mode": "human"}, "rgb_array"),
    ],
)
def test_what_cannot_be_an_environment_is_refused(species, more, says):
    with pytest.raises(ConfigError, match=says):
        parallel_env(PASTURE, species, **more)
