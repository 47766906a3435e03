"""The bytes of a frame, against hand-counted ones and a slow twin."""

import math
import struct

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Body
from ecs_eco.config import load
from ecs_eco.view.frames import Encoder, extent, grade
from ecs_eco.view.live import Live


def f32(*values):
    return np.array(values, np.float32)


def read(frame):
    """Header and blocks of a frame, read one by one."""
    magic, number, tick, base, light, sun, kinds = struct.unpack_from("<IIIIffI", frame)
    counts = struct.unpack_from(f"<{kinds}I", frame, 28)
    at, blocks = 28 + 4 * kinds, []
    for count in counts:
        blocks.append([struct.unpack_from("<HHHBBI", frame, at + 12 * i) for i in range(count)])
        at += 12 * count
    assert at == len(frame)
    return (magic, number, tick, base, light, sun), blocks


def test_a_frame_has_the_bytes_that_were_counted_by_hand():
    encoder = Encoder([100.0, 200.0], 2)
    encoder.begin(7, 2**32 + 5, 0.5, 1.0)
    encoder.add(
        f32(0, 75, 100),
        f32(0, 50, 200),
        f32(9, 9, 9),
        f32(0, math.pi, -math.pi / 2),
        np.array([0, 1, 255], np.uint8),
        np.array([1, 2, 3], np.uint64),
    )
    encoder.add(
        f32(25), f32(25), f32(0), f32(2 * math.pi), np.array([9], np.uint8), np.array([2**32 - 1], np.uint64)
    )
    head, blocks = read(encoder.bytes())
    assert head == (0x31434545, 7, 5, 0, 0.5, 1.0)
    assert encoder.bytes()[:4] == b"EEC1"
    assert blocks == [
        # a plane has no height
        [(0, 0, 0, 0, 0, 1), (49151, 16384, 0, 128, 1, 2), (65535, 65535, 0, 192, 255, 3)],
        [(16384, 8192, 0, 0, 9, 2**32 - 1)],  # a whole turn is none
    ]


def test_heights_are_shares_of_a_volume():
    encoder = Encoder([10.0, 10.0, 40.0], 1)
    encoder.begin(1, 1)
    encoder.add(f32(5), f32(5), f32(30), f32(0), np.zeros(1, np.uint8), np.ones(1, np.uint64))
    assert read(encoder.bytes())[1][0][0][2] == 49151  # 3/4 of 65535 is 49151.25


def test_the_dead_are_in_no_frame_and_who_is_outside_is_at_the_edge():
    encoder = Encoder([10.0, 10.0], 1)
    encoder.begin(1, 1)
    alive = np.array([False, True, False, True])
    encoder.add(
        f32(1, -3, 3, 12),
        f32(1, 2, 3, 5),
        f32(0, 0, 0, 0),
        f32(0, 0, 0, 0),
        np.arange(4, dtype=np.uint8),
        np.arange(10, 14, dtype=np.uint64),
        alive,
    )
    (_, ((one, two),)) = read(encoder.bytes())
    assert (one[0], one[4], one[5]) == (0, 1, 11)
    assert (two[0], two[4], two[5]) == (65535, 3, 13)


def test_a_large_frame_is_that_of_a_slow_twin():
    rng = np.random.default_rng(1)
    size = (240.0, 120.0, 60.0)
    n = 5000  # beyond the first buffer, which holds 1024
    x, y, z = ((rng.random(n) * s).astype(np.float32) for s in size)
    heading, value = rng.uniform(-10, 10, n).astype(np.float32), rng.integers(0, 256, n, np.uint8)
    uid, alive = rng.integers(1, 2**31, n).astype(np.uint64), rng.random(n) < 0.7
    encoder = Encoder(size, 1)
    for _ in range(2):  # the buffer is used again
        encoder.begin(1, 1)
        encoder.add(x, y, z, heading, value, uid, alive)
    _, (block,) = read(encoder.bytes())
    slow = [(x[i], y[i], z[i], heading[i], value[i], uid[i]) for i in range(n) if alive[i]]
    assert len(block) == len(slow)
    for got, (*place, angle, v, u) in zip(block, slow, strict=True):
        for share, p, s in zip(got[:3], place, size, strict=True):
            assert abs(share - p / s * 65535) <= 0.51
        turn = (angle / (2 * math.pi) * 256 - got[3] + 128) % 256 - 128
        assert abs(turn) <= 0.51
        assert got[4:] == (v, u)


@pytest.mark.parametrize(
    ("value", "code"), [(2.0, 1), (4.0, 255), (3.0, 128), (1.0, 1), (9.0, 255), (math.nan, 0)]
)
def test_values_are_graded_from_1_to_255(value, code):
    out = np.zeros(1, np.uint8)
    grade(np.ones(1, np.bool_), f32(value), np.float32(2), np.float32(4), out)
    assert out[0] == code


def test_a_range_without_extent_is_all_low():
    out = np.zeros(2, np.uint8)
    grade(np.ones(2, np.bool_), f32(3, 3), np.float32(3), np.float32(3), out)
    assert out.tolist() == [1, 1]


def test_the_extent_is_that_of_the_living():
    low, high = extent(np.array([False, True, True]), f32(-9, 2, 5))
    assert (low, high) == (2, 5)
    low, high = extent(np.zeros(2, np.bool_), f32(1, 2))
    assert low > high


def test_upper_halves_of_uids_follow_all_kinds_where_one_needs_them():
    encoder, none = Encoder([10.0, 10.0], 2), np.zeros(2, np.uint8)
    far = np.array([7, 31 * 2**48 + 9], np.uint64)
    for uids, upper in ((far, [0, 0, 31 << 16]), (far % np.uint64(2**32), [])):  # then none is left behind
        encoder.begin(1, 1)
        encoder.add(
            f32(1, 1),
            f32(1, 1),
            f32(0, 0),
            f32(0, 0),
            none,
            np.array([5, 6], np.uint64),
            np.array([False, True]),
        )
        encoder.add(f32(1, 1), f32(1, 1), f32(0, 0), f32(0, 0), none, uids)
        frame = encoder.bytes()
        assert struct.unpack_from("<I", frame, 12)[0] == bool(upper)
        end = len(frame) - 4 * len(upper)
        assert list(struct.unpack_from(f"<{len(upper)}I", frame, end)) == upper
        _, (_, (first, second)) = read(frame[:end])
        assert (first[5], second[5]) == (7, 9)


def test_in_a_plane_genes_take_the_place_of_heights():
    encoder, none = Encoder([10.0, 10.0], 1), np.zeros(3, np.uint8)
    encoder.begin(1, 1)
    genes = np.array([0, 300, 65535], np.uint16)
    encoder.add(*(f32(1, 2, 3),) * 4, none, np.arange(3, dtype=np.uint64), genes=genes)
    assert [one[2] for one in read(encoder.bytes())[1][0]] == [0, 300, 65535]


def test_in_a_volume_genes_follow_all_kinds_after_the_upper_halves_of_uids():
    encoder, none = Encoder([10.0, 10.0, 10.0], 2), np.zeros(2, np.uint8)
    genes, alive = np.array([300, 65535], np.uint16), np.array([False, True])
    for far, upper in ((0, []), (3 << 32, [0, 0, 3])):
        encoder.begin(1, 1)
        encoder.add(*(f32(1, 10),) * 4, none, np.array([5, 6], np.uint64), alive, genes)
        encoder.add(*(f32(1, 2),) * 4, none, np.array([7, 8 + far], np.uint64))
        frame = encoder.bytes()
        assert struct.unpack_from("<I", frame, 12)[0] == 2 + bool(upper)
        more = [*upper, 65535, 0, 0]
        end = len(frame) - 4 * len(more)
        assert list(struct.unpack_from(f"<{len(more)}I", frame, end)) == more
        assert read(frame[:end])[1][0][0][2] == 65535  # the height of the living one


MEADOW = """
format = 1
name = "meadow"
space = {{ size = {size}, edges = "walls" }}
[species.hare]
count = 40
age = [0.0, 80.0]
body = {{ radius = 0.5, mass = 4.0 }}
locomotion = {{ speed = {{ rest = 0.0 }} }}
actions = {{ speed = ["rest"] }}
automatic = ["rest"]
metabolism = {{ energy = 1.0, energy_max = 1.0, basal = 0.0 }}
{more}
"""


def hares(tmp_path, more, size=(20.0, 20.0)):
    """Return hello's entry of the hares, the sizes in a frame, and the hares' table, by uid."""
    (file := tmp_path / "meadow.toml").write_text(MEADOW.format(size=list(size), more=more))
    live = Live(world := World.from_config(load(file), seed=1, policies="random", record=False))
    table = world.tables["hare"]
    if "growth" in more:  # founders are adults
        table[Body].radius[table.rows()] = np.linspace(0.1, 0.5, 40)
    rows = read(live.frame(1, "species"))[1][0]
    return live.hello()["species"][0], {row[5]: row[2] for row in rows}, table


@pytest.mark.parametrize(
    ("more", "adult"),
    [
        (
            'reproduction = { kind = "asexual", rate = 0.1, energy_min = 1.0, energy_given = 0.5, age_min = 20.0 }',
            20.0,
        ),
        ('lethal = [{ property = "age", max = 400.0, cause_above = "too old" }]', 40.0),
    ],
)
def test_the_young_are_smaller_until_they_are_fertile_or_for_a_tenth_of_a_life(tmp_path, more, adult):
    kind, sizes, table = hares(tmp_path, more)
    assert kind["shows"] == {"grows": ("age", adult, 0.6)}
    rows = table.rows()
    age = dict(zip(table.uid[rows].tolist(), table[Biology].age[rows].tolist(), strict=True))
    assert min(age.values()) < 0.9 * adult < adult < max(age.values())
    for uid, size in sizes.items():
        assert size == pytest.approx(1 + 254 * min(1, age[uid] / adult), abs=0.51)


def test_bodies_that_grow_are_as_large_as_they_are_and_in_water_none_are_scaled(tmp_path):
    growth = "growth = { rate = 0.01 }\n"
    kind, sizes, table = hares(tmp_path, growth)
    assert kind["shows"] == {"grows": ("radius", 0.5, 0.0)}
    rows = table.rows()
    for uid, radius in zip(table.uid[rows].tolist(), table[Body].radius[rows].tolist(), strict=True):
        assert sizes[uid] == pytest.approx(1 + 254 * radius / 0.5, abs=0.51)
    assert "shows" not in hares(tmp_path, growth, (20.0, 20.0, 5.0))[0]
    assert set(hares(tmp_path, "")[1].values()) == {0}
