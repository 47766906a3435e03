import numpy as np
import pytest

from ecs_eco.learning import PPO, train
from ecs_eco.learning.ppo import Learner
from ecs_eco.learning.vector_env import Training, act

gymnasium = pytest.importorskip("gymnasium")

SAME_STEP, NEXT_STEP = gymnasium.vector.AutoresetMode.SAME_STEP, gymnasium.vector.AutoresetMode.NEXT_STEP


class Corridor(gymnasium.Env):
    """Observe the time; a reward of 1 per step; the fifth step ends the episode, by death or by time limit."""

    observation_space = gymnasium.spaces.Box(0, 10, (1,))
    action_space = gymnasium.spaces.Discrete(2, start=3)

    def __init__(self, dies):
        self.dies = dies

    def reset(self, *, seed=None, options=None):
        self.time = 0
        return np.array([0], np.float32), {}

    def step(self, action):
        assert action in (3, 4)
        self.time += 1
        over = self.time == 5
        return np.array([self.time], np.float32), 1.0, over and self.dies, over and not self.dies, {}


def _corridors(mode, dies=True, n=2):
    return gymnasium.vector.SyncVectorEnv([lambda: Corridor(dies)] * n, autoreset_mode=mode)


def _watched(monkeypatch):
    """Return the rollouts as they are when they are learnt from."""
    seen, update = [], Learner.update

    def spy(self, rows, values):
        rollout = self.rollout
        seen.append({k: v.copy() for k, v in rollout.state().items()} | {"rows": rows, "values": values})
        return update(self, rows, values)

    monkeypatch.setattr(Learner, "update", spy)
    return seen


@pytest.mark.parametrize(("mode", "n_ticks"), [(SAME_STEP, 10), (NEXT_STEP, 11)])
def test_only_actions_that_were_taken_are_transitions(monkeypatch, mode, n_ticks):
    seen = _watched(monkeypatch)
    training = train(_corridors(mode), PPO(horizon=n_ticks, minibatch_size=64), 2 * n_ticks + 2, seed=0)
    rollout = seen[0]
    assert rollout["observations"][::2, 0].tolist() == [0, 1, 2, 3, 4] * 2
    assert rollout["reward"].tolist() == [1.0] * 20
    assert rollout["ended"].tolist() == ([False] * 8 + [True] * 2) * 2
    assert training.returns[:4] == [5.0] * 4
    assert training.steps[:4] == [10, 10] + ([20, 20] if mode == SAME_STEP else [22, 22])


@pytest.mark.parametrize("mode", [SAME_STEP, NEXT_STEP])
def test_a_time_limit_is_followed_by_the_value_of_the_final_observation(monkeypatch, mode):
    seen = _watched(monkeypatch)
    finals = []

    def cut(self, rows, rewards, values):
        finals.append(values)
        self.end(rows, rewards + np.float32(self.discount) * values)

    monkeypatch.setattr("ecs_eco.learning.rollout.Rollout.cut", cut)
    training = train(
        _corridors(mode, dies=False), PPO(horizon=5, minibatch_size=64, discount=0.5), 12, seed=0
    )
    fresh = train(_corridors(mode, dies=False), PPO(horizon=5, minibatch_size=64), 2, seed=0).brain
    value_at_5 = fresh.forward(np.array([[5.0], [5.0]], np.float32))[1]
    np.testing.assert_allclose(finals[0], value_at_5, rtol=1e-5)
    np.testing.assert_allclose(seen[0]["reward"][-2:], 1 + 0.5 * value_at_5, rtol=1e-5)
    assert len(seen) == len(training.reports) == 1


def test_the_living_expect_the_value_of_what_they_see(monkeypatch):
    seen = _watched(monkeypatch)
    train(_corridors(NEXT_STEP), PPO(horizon=3, minibatch_size=64), 8, seed=0)
    fresh = train(_corridors(NEXT_STEP), PPO(horizon=3, minibatch_size=64), 2, seed=0).brain
    assert seen[0]["rows"].tolist() == [0, 1]
    np.testing.assert_allclose(seen[0]["values"], fresh.forward(np.full((2, 1), 3, np.float32))[1], rtol=1e-5)


class TwoLevers(gymnasium.Env):
    """Two groups of actions; one step; the right levers depend on the observation."""

    observation_space = gymnasium.spaces.Box(-1, 1, (2,))
    action_space = gymnasium.spaces.MultiDiscrete([2, 3])

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.seen = self.np_random.choice([-1.0, 1.0], 2).astype(np.float32)
        return self.seen, {}

    def step(self, action):
        return (
            self.seen,
            float(action[0] == (self.seen[0] > 0)) + float(action[1] == 2 * (self.seen[1] > 0)),
            True,
            False,
            {},
        )


def test_several_action_groups_are_learnt():
    envs = gymnasium.vector.SyncVectorEnv([TwoLevers] * 16, autoreset_mode=SAME_STEP)
    training = train(envs, PPO(horizon=16, minibatch_size=64, learning_rate=3e-3), 8000, seed=1)
    assert np.mean(training.returns[:200]) < 1.2
    assert np.mean(training.returns[-200:]) > 1.8
    right = act(training.brain, np.array([[1, -1], [-1, 1]], np.float32))
    assert right.tolist() == [[1, 0], [0, 2]]


def test_the_same_seed_gives_the_same_training():
    first, again, other = (
        train(_corridors(NEXT_STEP), PPO(horizon=8), 200, seed=s).brain.state() for s in (1, 1, 2)
    )
    assert all(np.array_equal(first[name], again[name]) for name in first)
    assert not np.array_equal(first["policy.0.weight"], other["policy.0.weight"])


class Rooms(gymnasium.Env):
    """Three rooms, of which one is seen by its number; the right action is that number plus 1, modulo 3."""

    observation_space = gymnasium.spaces.Discrete(3, start=5)
    action_space = gymnasium.spaces.Discrete(3, start=-1)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.room = int(self.np_random.integers(3))
        return self.room + 5, {}

    def step(self, action):
        reward = float(action + 1 == (self.room + 1) % 3)
        return self.reset()[0], reward, True, False, {}


class Lamps(Rooms):
    """The same, seen as two numbers of which the first does not matter."""

    observation_space = gymnasium.spaces.MultiDiscrete([2, 3], start=[1, 5])

    def reset(self, *, seed=None, options=None):
        return np.array([1, super().reset(seed=seed)[0]]), {}


@pytest.mark.parametrize(("kind", "seen"), [(Rooms, [5, 6, 7]), (Lamps, [[1, 5], [2, 6], [1, 7]])])
def test_a_single_environment_whose_observations_are_whole_numbers_is_learnt_and_saved(kind, seen, tmp_path):
    env = kind()
    ppo = PPO(horizon=64, learning_rate=5e-3, minibatch_size=64, epochs=6, discount=0.0)
    training = train(env, ppo, 4000, seed=1, hidden=(16,))
    assert np.mean(training.returns[-100:]) > 0.8
    assert training.predict(np.array(seen)).tolist() == [0, 1, -1]  # rooms 0, 1, 2: places 1, 2, 0
    assert training.predict(seen[0]) == 0
    assert training.predict(seen[0]) in env.action_space
    other = train(env, ppo, 0, seed=2, hidden=(16,))
    other.load(training.save(tmp_path / "rooms.safetensors"))
    assert other.predict(np.array(seen)).tolist() == [0, 1, -1]
    with pytest.raises(ValueError, match="this brain"):
        train(env, ppo, 0, seed=2, hidden=(8,)).load(tmp_path / "rooms.safetensors")


def test_what_is_no_environment_and_what_is_no_array_is_refused_with_what_to_do():
    with pytest.raises(TypeError, match=r"envs = 'CartPole-v1': expected .* gymnasium.make_vec"):
        train("CartPole-v1", PPO(), 10, seed=0)
    env = Rooms()
    env.observation_space = gymnasium.spaces.Dict({"room": gymnasium.spaces.Discrete(3)})
    with pytest.raises(
        ValueError, match=r"observation space Dict.*FlattenObservation\(env\) converts others to a Box"
    ):
        train(env, PPO(), 10, seed=0)


def test_environments_that_do_not_fit_are_refused():
    envs = _corridors(gymnasium.vector.AutoresetMode.DISABLED)
    with pytest.raises(ValueError, match="expected NEXT_STEP or SAME_STEP"):
        train(envs, PPO(), 10, seed=0)
    envs = _corridors(NEXT_STEP)
    for space in (gymnasium.spaces.Box(0, 1, (1, 2)), gymnasium.spaces.Box(0, np.inf, (1,))):
        envs.single_action_space = space
        with pytest.raises(ValueError, match="expected Discrete, or MultiDiscrete or a bounded Box"):
            train(envs, PPO(), 10, seed=0)


class Reach(gymnasium.Env):
    """Two numbers from −3 to 1 and from 5 to 6; the reward is −|a − (−2)| − |b − 5.75|; one step each."""

    observation_space = gymnasium.spaces.Box(0, 1, (1,))
    action_space = gymnasium.spaces.Box(np.array([-3, 5], np.float32), np.array([1, 6], np.float32))

    def reset(self, *, seed=None, options=None):
        return np.zeros(1, np.float32), {}

    def step(self, action):
        assert action in self.action_space
        return np.zeros(1, np.float32), -float(abs(action[0] + 2) + abs(action[1] - 5.75)), True, False, {}


def test_numbers_between_limits_are_learnt():
    envs = gymnasium.vector.SyncVectorEnv([Reach] * 16, autoreset_mode=SAME_STEP)
    ppo = PPO(horizon=16, learning_rate=3e-3, epochs=6, minibatch_size=64, entropy_coef=0.0)
    training = train(envs, ppo, 12_000, seed=1)
    brain = training.brain
    a, b = act(brain, np.zeros((1, 1)))[0]
    assert training.predict(np.zeros(1)) == pytest.approx([-1 + 2 * a, 5.5 + 0.5 * b])
    assert -1 + 2 * a == pytest.approx(-2, abs=0.2)
    assert 5.5 + 0.5 * b == pytest.approx(5.75, abs=0.05)


def test_steps_to_a_threshold_are_those_of_the_first_window_that_reaches_it():
    training = Training(brain=None, returns=[1, 2, 3, 4, 5], steps=[10, 20, 30, 40, 50])
    assert training.steps_to(3.5, episodes=2) == 40
    assert training.steps_to(9, episodes=2) is None
    assert training.steps_to(1, episodes=6) is None
