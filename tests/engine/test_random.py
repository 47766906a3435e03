import numpy as np

from ecs_eco.engine import random
from ecs_eco.engine.random import bits, draw, draw_many, mix, mix_int, tick_key


def test_mix_is_the_finaliser_of_splitmix64():
    # the first outputs of splitmix64 with seed 1234567 (Vigna's test vector):
    # the generator's state grows by the golden ratio
    state, outputs = 1234567, [6457827717110365317, 3203168211198807973, 9817491932198370423]
    for expected in outputs:
        assert mix_int(state) == expected
        assert int(mix(np.uint64(state))) == expected
        state = (state + 0x9E3779B97F4A7C15) % 2**64


def test_a_kernel_an_array_and_a_slow_twin_draw_the_same():
    key, who = tick_key(5, 77), np.array([1, 2, 3, 2**40, 2**63], np.uint64)

    def slow(uid, purpose):
        bits = mix_int((mix_int(int(key) ^ uid) + purpose * 0xD1342543DE82EF95) % 2**64)
        return (bits >> 40) / 2**24

    for purpose in (random.PLACE, random.FEED + (3 << 8)):
        many = draw_many(key, who, purpose)
        assert many.dtype == np.float32
        assert (
            many.tolist()
            == [float(draw(key, w, purpose)) for w in who]
            == [slow(int(w), purpose) for w in who]
        )


def test_draw_takes_the_upper_24_of_64_random_bits():
    key = tick_key(2, 3)
    for who in (1, 2**63):
        many = bits(key, np.uint64(who), random.FEED)
        assert float(draw(key, np.uint64(who), random.FEED)) == (int(many) >> 40) / 2**24


def test_keys_that_are_made_64_at_a_time_are_those_of_single_ticks():
    for seed in (0, 5, -1, 2**64 - 1):
        for tick in (0, 63, 64, 1000, 2**40):
            key = tick_key(seed, tick)
            assert type(key) is np.uint64
            assert int(key) == mix_int((mix_int(seed % 2**64) + tick) % 2**64)


def test_every_part_of_the_key_counts():
    base = draw(tick_key(1, 10), np.uint64(5), 3)
    others = [
        draw(tick_key(2, 10), np.uint64(5), 3),
        draw(tick_key(1, 11), np.uint64(5), 3),
        draw(tick_key(1, 10), np.uint64(6), 3),
        draw(tick_key(1, 10), np.uint64(5), 4),
    ]
    assert base == draw(tick_key(1, 10), np.uint64(5), 3)
    assert len({float(base), *map(float, others)}) == 5
    assert tick_key(-1, 0) == tick_key(2**64 - 1, 0)


def test_draws_are_uniform_and_do_not_follow_uid_tick_or_purpose():
    n = 40_000
    who = np.arange(1, n + 1, dtype=np.uint64)
    series = {
        "uids": draw_many(tick_key(1, 1), who, 1),
        "ticks": np.array([draw(tick_key(1, t), np.uint64(1), 1) for t in range(n)]),
        "purposes": np.array([draw(tick_key(1, 1), np.uint64(1), p) for p in range(n)]),
    }
    for name, u in series.items():
        assert u.min() >= 0, name
        assert u.max() < 1, name
        counts = np.histogram(u, 50, (0, 1))[0]
        chi2 = ((counts - n / 50) ** 2 / (n / 50)).sum()
        assert chi2 < 95, name  # 49 degrees of freedom: p < 1e-4
        assert abs(np.corrcoef(u[1:], u[:-1])[0, 1]) < 4 / np.sqrt(n), name


def test_purposes_are_different_numbers():
    names = ("PLACE", "SEX", "DECIDE", "FEED", "BIRTH", "SPREAD", "WANDER", "USER")
    numbers = [getattr(random, n) for n in names]
    assert len(set(numbers)) == len(numbers)
    assert max(numbers) < 256  # salts begin at 1 << 8
