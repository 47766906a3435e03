import numpy as np
import pytest

from ecs_eco.components import Metabolism
from ecs_eco.systems import Grow
from ecs_eco.systems.grow import grow
from ecs_eco.testing import act, arrange

F = np.float32
GRASS = {"count": 4, "metabolism": {"energy": 0.5, "energy_max": 1.0, "photosynthesis": 0.25}}


def test_a_plant_grows_by_light_until_it_is_full(meadow):
    world = meadow(grass=GRASS, world={"dt": 0.5, "ambient": {"light": 0.5}})
    grass = arrange(world, "grass", energy=[0.0, 0.5, 0.96875, 1.5])
    act(world, Grow)  # 0.25/s × 0.5 s × 0.5 = 0.0625
    # the overfull keeps what it has
    assert grass[Metabolism].energy[:4].tolist() == [0.0625, 0.5625, 1.0, 1.5]
    assert grass[Metabolism].taken[:4].tolist() == [0.0625, 0.0625, 0.03125, 0.0]


def test_light_may_differ_from_place_to_place(meadow):
    world = meadow(grass=GRASS)
    grass = arrange(world, "grass", x=[0, 4, 8, 12], energy=0)
    world.environment["light"] = lambda w, x, y, z: x / np.float32(16)
    act(world, Grow)
    assert grass[Metabolism].energy[:4].tolist() == [0, 0.0625, 0.125, 0.1875]


def test_in_the_dark_and_without_growth_nothing_grows(meadow):
    for world in (meadow(grass=GRASS, world={"ambient": {"light": 0.0}}), meadow(grass={"count": 4})):
        act(world, Grow)
        assert world.tables["grass"][Metabolism].energy[:4].tolist() == [0.5] * 4
        assert (
            world.tables["deer"][Metabolism].energy[:2].tolist()
            == world.tables["deer"][Metabolism].energy[:2].tolist()
        )
        assert not world.tables["deer"][Metabolism].taken[:2].any()


@pytest.mark.parametrize("seed", [1, 2])
def test_the_kernel_is_its_slow_twin(seed):
    rng = np.random.default_rng(seed)
    n = 50
    alive, light = rng.random(n) < 0.7, rng.random(n).astype(F)
    energy, taken = rng.random(n).astype(F) * F(1.2), rng.random(n).astype(F)
    before, counted = energy.copy(), taken.copy()
    grow(0, n, alive, light, F(0.3), F(1), energy, taken)
    expected = np.where(alive, np.maximum(before, np.minimum(before + F(0.3) * light, F(1))), before)
    assert np.allclose(energy, expected, rtol=1e-6)
    assert np.allclose(taken, counted + (expected - before), atol=1e-6)
