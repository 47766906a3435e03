import numpy as np
import pytest
import torch

from ecs_eco.components import Experience, Policy
from ecs_eco.engine.random import mix_int
from ecs_eco.engine.table import Table
from ecs_eco.learning import PPO, Brain, Individuals, Learner, choose
from ecs_eco.learning.rollout import STEP, fill_advantages, summarize

GROUPS, MASK = (3, 2), (1 << 64) - 1


def whole(kernel, n, *arguments, work=None):
    kernel(0, n, *arguments)


def herd(individuals, uid):
    table = Table("goat", (Policy, Experience), dims=individuals.dims)
    uid = np.array(uid, np.uint64)
    rows = table.occupy(len(uid), 1, 0, {(Policy, "weights"): individuals.draw(uid, 5)})
    table.uid[rows] = uid
    return table, rows


class Plain:
    """PPO of one animal alone, by autograd, torch.optim.AdamW and in float64."""

    def __init__(self, individuals, weights, uid, rate, discount, entropy):
        self.ppo, self.seed, self.uid, self.updates = individuals.ppo, individuals.seed, uid, 0
        self.discount, self.entropy, self.records, self.rewards = discount, entropy, [], []
        self.parts = [
            torch.tensor(part, dtype=torch.float64, requires_grad=True) for part in individuals.views(weights)
        ]
        self.adam = torch.optim.AdamW(
            self.parts, rate, eps=self.ppo.adam_epsilon, weight_decay=self.ppo.weight_decay
        )

    def forward(self, x):
        h = torch.as_tensor(x, dtype=torch.float64)
        for matrix, bias in zip(self.parts[:-2:2], self.parts[1:-2:2], strict=True):
            h = torch.tanh(h @ matrix + bias)
        out = h @ self.parts[-2] + self.parts[-1]
        return out[:, :-1], out[:, -1]

    def judge(self, x, choices):
        """Return log-probability and entropy of the choices, and the value."""
        logits, value = self.forward(x)
        groups = [torch.distributions.Categorical(logits=part) for part in logits.split(GROUPS, 1)]
        now = sum(g.log_prob(torch.as_tensor(choices[:, i].astype(np.int64))) for i, g in enumerate(groups))
        return now, sum(g.entropy() for g in groups), value

    def store(self, x, choice):
        with torch.no_grad():
            now, _, value = self.judge(x[None], choice[None])
        self.records.append((x, choice, now.item(), value.item()))
        self.rewards.append(0.0)

    def shuffle(self, order, epoch):
        """Shuffle in place, by keys from seed, uid, update and epoch."""
        key = mix_int(mix_int(self.seed ^ self.uid) + self.updates)
        for i in range(len(order) - 1, 0, -1):
            j = mix_int((mix_int((key + epoch) & MASK) + i) & MASK) % (i + 1)
            order[i], order[j] = order[j], order[i]

    def learn(self, x_now):
        ppo, n = self.ppo, len(self.records)
        x, choices = np.array([r[0] for r in self.records]), np.array([r[1] for r in self.records])
        then, old = (torch.tensor([r[i] for r in self.records], dtype=torch.float64) for i in (2, 3))
        with torch.no_grad():
            later, gain, gains = self.forward(x_now[None])[1].item(), 0.0, []
        for t in range(n - 1, -1, -1):
            gain = (
                self.rewards[t]
                + self.discount * later
                - old[t].item()
                + self.discount * ppo.gae_lambda * gain
            )
            later = old[t].item()
            gains.insert(0, gain)
        advantage = torch.tensor(gains, dtype=torch.float64)
        target = advantage + old
        if ppo.normalise_advantage and n > 1:
            advantage = (advantage - advantage.mean()) / (advantage.std(correction=0) + 1e-8)
        parts, order = -(-n // ppo.minibatch_size), list(range(n))
        for epoch in range(ppo.epochs):
            self.shuffle(order, epoch)
            for part in range(parts):
                chosen = order[n * part // parts : n * (part + 1) // parts]
                self.step(
                    x[chosen], choices[chosen], then[chosen], old[chosen], advantage[chosen], target[chosen]
                )
        self.updates, self.records, self.rewards = self.updates + 1, [], []

    def step(self, x, choices, then, old, advantage, target):
        ppo = self.ppo
        now, entropy, value = self.judge(x, choices)
        ratio = torch.exp(now - then)
        policy = -torch.minimum(ratio * advantage, ratio.clamp(1 - ppo.clip, 1 + ppo.clip) * advantage).mean()
        error = (value - target) ** 2
        if ppo.clip_value:
            error = torch.maximum(
                error, (old + (value - old).clamp(-ppo.clip_value, ppo.clip_value) - target) ** 2
            )
        self.adam.zero_grad()
        (policy - self.entropy * entropy.mean() + ppo.value_weight * error.mean()).backward()
        if ppo.max_grad_norm:
            torch.nn.utils.clip_grad_norm_(self.parts, ppo.max_grad_norm)
        self.adam.step()

    def flat(self, name=None):
        parts = [self.adam.state[p][name] if name else p.detach() for p in self.parts]
        return torch.cat([p.flatten() for p in parts]).numpy()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "settings"),
    [
        ((6,), {}),
        ((), {"clip_value": 0.1, "max_grad_norm": 0}),
        ((6, 4), {"minibatch_size": 3, "weight_decay": 0.3}),
        ((5, 4, 3), {"horizon": 40, "normalise_advantage": False, "weight_decay": 0.1}),
    ],
)
def test_five_lives_agree_with_five_plain_learners(hidden, settings):
    ppo = PPO(**{"horizon": 9, "epochs": 3, "adam_epsilon": 1e-3} | settings)
    individuals = Individuals(4, GROUPS, hidden, ppo, 11)
    uid = [3, 70, 500, 12, 2**40 + 1]
    table, rows = herd(individuals, uid)
    rates, discounts, entropies = np.array(
        [[0.02, 0.005, 0.01, 0.03, 0.001], [0.9, 0.5, 0, 0.99, 1], [0, 0.1, 0.02, 1, 0]], np.float32
    )
    table.born[rows] = births = np.array([0, 0, 4, 7, 30])
    plain = [
        Plain(
            individuals,
            table[Policy].weights[int(r)],
            u,
            *(float(a[i]) for a in (rates, discounts, entropies)),
        )
        for i, (r, u) in enumerate(zip(rows, uid, strict=True))
    ]
    rng, policy, experience = np.random.default_rng(2), table[Policy], table[Experience]
    for tick in range(160):
        there = np.flatnonzero(births <= tick)
        x, rewards = (
            rng.standard_normal((5, 4)).astype(np.float32)[there],
            rng.standard_normal(5).astype(np.float32)[there],
        )
        individuals.credit(experience, rows[there], rewards)
        for i, reward in zip(there, rewards, strict=True):
            if plain[i].rewards:
                plain[i].rewards[-1] += float(reward)
        due = individuals.due(experience, rows[there], table.uid[rows[there]], births[there], tick)
        mine = there[due]
        if mine.size:
            _, values = individuals.forward(policy, rows[mine], x[due], whole)
            plasticity = rates[mine], discounts[mine], entropies[mine]
            individuals.learn(
                policy, experience, rows[mine], table.uid[rows[mine]], values, plasticity, whole
            )
            for i, seen in zip(mine, x[due], strict=True):
                plain[i].learn(seen)
        logits, values = individuals.forward(policy, rows[there], x, whole)
        choice, log_probability = np.empty((len(there), 2), np.int16), np.empty(len(there), np.float32)
        choose(logits, individuals.offsets, rng.random((len(there), 2), np.float32), choice, log_probability)
        individuals.store(experience, rows[there], x, choice, log_probability, values)
        for k, i in enumerate(there):
            plain[i].store(x[k], choice[k])
    assert policy.updates[rows].tolist() == [p.updates for p in plain]
    assert min(policy.updates[rows]) >= 3
    for r, p, rate in zip(rows.tolist(), plain, rates, strict=True):
        assert policy.steps[r] == next(iter(p.adam.state.values()))["step"]
        np.testing.assert_allclose(policy.weights[r], p.flat(), rtol=2e-4, atol=2e-5)
        np.testing.assert_allclose(policy.moment_1[r], p.flat("exp_avg"), rtol=2e-3, atol=2e-5)
        np.testing.assert_allclose(policy.moment_2[r], p.flat("exp_avg_sq"), rtol=2e-3, atol=1e-6)
        # it has moved far
        assert np.abs(individuals.draw(table.uid[[r]], 5)[0] - policy.weights[r]).max() > 5 * rate


def test_advantages_and_what_they_say_are_those_counted_by_hand():
    steps, half = np.zeros(3, STEP), np.float32(0.5)
    steps["value"], steps["reward"] = [1, 2, 0], [1, 3, -1]
    later, gain = np.array([4], np.float32), np.zeros(1, np.float32)
    fill_advantages(steps, np.zeros(3, np.bool_), later, gain, half, half)
    # -1 + 0.5 * 4 - 0 = 1;  3 + 0.5 * 0 - 2 + 0.25 * 1 = 1.25;  1 + 0.5 * 2 - 1 + 0.25 * 1.25 = 1.3125
    assert steps["advantage"].tolist() == [1.3125, 1.25, 1]
    shift, scale, explained, reward = summarize(steps, True)
    assert shift == 1.1875
    assert 1 / scale == pytest.approx((0.0546875 / 3) ** 0.5)  # of 0.125, 0.0625 and -0.1875
    targets = np.array([2.3125, 3.25, 1])
    assert explained == pytest.approx(1 - 0.0546875 / 3 / targets.var())
    assert reward == 1
    assert summarize(steps, False)[:2] == summarize(steps[:1], True)[:2] == (0, 1)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_each_of_twenty_individuals_learns_its_own_bandit(seed):
    individuals = Individuals(
        2, (4,), (8,), PPO(horizon=16, learning_rate=0.02, discount=0.0, epochs=4), seed
    )
    uid = np.arange(1, 21, dtype=np.uint64)
    table, rows = herd(individuals, uid)
    best, rng, x = (uid % 4).astype(np.int64), np.random.default_rng(seed), np.ones((20, 2), np.float32)
    choice, log_probability = np.empty((20, 1), np.int16), np.empty(20, np.float32)
    policy, experience = table[Policy], table[Experience]
    for tick in range(480):
        due = np.flatnonzero(individuals.due(experience, rows, uid, table.born[rows], tick))
        logits, values = individuals.forward(policy, rows, x, whole)
        individuals.learn(policy, experience, rows[due], uid[due], values[due], None, whole)
        choose(logits, individuals.offsets, rng.random((20, 1), np.float32), choice, log_probability)
        individuals.store(experience, rows, x, choice, log_probability, values)
        individuals.credit(
            experience, rows, (rng.random(20) < np.where(choice[:, 0] == best, 0.8, 0.2)).astype(np.float32)
        )
    logits, _ = individuals.forward(policy, rows, x, whole)
    p = torch.softmax(torch.from_numpy(logits), 1).numpy()[np.arange(20), best]
    assert p.min() > 0.6  # chance: 0.25
    assert p.mean() > 0.85


def test_the_report_holds_means_over_those_that_learnt():
    individuals = Individuals(2, (2,), (), PPO(horizon=4, epochs=2, value_weight=0.0), 0)
    table, rows = herd(individuals, [1, 2, 3])
    experience, zero = table[Experience], np.zeros(3, np.float32)
    for n, reward in ((3, 1), (2, 4)):  # animal 3 has one transition less
        even = np.full(n, -np.log(2), np.float32)
        individuals.store(
            experience, rows[:n], np.ones((n, 2), np.float32), np.zeros((n, 1), np.int16), even, zero[:n]
        )
        individuals.credit(experience, rows[:n], np.full(n, reward, np.float32))
    rates = np.array([0.1, 0, 0.3], np.float32)
    report = individuals.learn(
        table[Policy], experience, rows, table.uid[rows], zero, (rates, 0.0, 0.0), whole
    )
    assert (report["n_animals"], report["n_transitions"]) == (2, 3)
    assert report["reward"] == pytest.approx((1 + 4 + 1) / 3)
    assert report["learning_rate"] == pytest.approx(0.2)
    assert report["entropy"] == pytest.approx(np.log(2), rel=0.2)
    assert set(report) >= {
        "policy_loss",
        "value_loss",
        "approx_kl",
        "clip_fraction",
        "gradient_norm",
        "explained_variance",
    }
    assert not experience.length[rows].any()
    nobody = individuals.learn(table[Policy], experience, rows, table.uid[rows], zero, None, whole)
    assert nobody["n_animals"] == 0
    assert np.isnan(nobody["reward"])


def test_numbers_that_are_not_finite_reach_no_other_animal():
    """Activations of a longer rollout lie behind those of the next, shorter one."""
    individuals = Individuals(2, (2,), (3,), PPO(horizon=4), 0)
    table, rows = herd(individuals, [77, 1])
    zero = np.zeros(2, np.float32)
    for n in (2, 2, 1):
        x = np.array([[np.nan, np.nan], [1, 2]], np.float32)[:n]
        individuals.store(table[Experience], rows[:n], x, np.zeros((n, 1), np.int16), zero[:n], zero[:n])
    with pytest.raises(FloatingPointError, match="animal 77"):
        individuals.learn(table[Policy], table[Experience], rows, table.uid[rows], zero, None, whole)
    assert np.isfinite(table[Policy].weights[1]).all()
    assert np.isfinite(table[Policy].moment_2[1]).all()
    assert table[Policy].moment_2[1].max() > 0


def test_a_reward_that_is_not_finite_is_named_with_its_animal():
    individuals = Individuals(2, (2,), (), PPO(horizon=4), 0)
    table, rows = herd(individuals, [1, 77])
    zero = np.zeros(2, np.float32)
    individuals.store(
        table[Experience], rows, np.ones((2, 2), np.float32), np.zeros((2, 1), np.int16), zero, zero
    )
    individuals.credit(table[Experience], rows, np.array([1, np.nan], np.float32))
    before = table[Policy].weights[int(rows[1])].copy()
    with pytest.raises(FloatingPointError, match=r"animal 77 is nan \(1 in all\)"):
        individuals.learn(table[Policy], table[Experience], rows, table.uid[rows], zero, None, whole)
    assert np.array_equal(table[Policy].weights[int(rows[1])], before)


def test_the_shared_learner_decays_its_weights_apart_from_the_gradient():
    after = []
    for decay in (0.0, 0.5):
        learner = Learner(
            Brain(3, (2,), (4,), seed=1), PPO(learning_rate=0.1, epochs=1, weight_decay=decay), 0
        )
        before = learner.brain.weights.copy()
        rows, x = np.arange(6), np.random.default_rng(0).standard_normal((6, 3), np.float32)
        _, values = learner.brain.forward(x)
        learner.rollout.store(rows, x, np.zeros((6, 1), np.int16), np.full(6, -0.7, np.float32), values)
        learner.update(rows, values)
        after.append(learner.brain.weights)
    np.testing.assert_allclose(after[1], after[0] - 0.1 * 0.5 * before, atol=1e-6)
    assert np.abs(before).max() > 0.5
