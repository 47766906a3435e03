import numpy as np
import pytest

from ecs_eco.space.water import Water

F = np.float32


def test_light_falls_by_beer_lambert_and_integrates_to_the_analytic_value():
    water = Water([10.0, 10.0, 30.0], attenuation=0.2)
    z = (30.0 - (np.arange(30_000) + 0.5) / 1000).astype(F)
    light = water.light(0.8, z)
    assert light[[5000, 20_000]] == pytest.approx(0.8 * np.exp([-0.2 * 5.0005, -0.2 * 20.0005]), rel=1e-5)
    assert light.mean(dtype=float) * 30.0 == pytest.approx(0.8 * (1 - np.exp(-6.0)) / 0.2, rel=1e-5)


def test_who_floats_above_shades_what_is_below():
    water = Water([4.0, 5.0, 3.0], attenuation=0.1, layer=1.0)
    z = np.array([2.5, 2.9, 1.5, 0.5, 2.2], F)
    # 2, 1 and 1 in the layers; each 0.1 of optical depth
    water.shade([(np.array([True, True, True, True, False]), z, 2.0)])
    assert water.optical == pytest.approx([0.0, 0.3, 0.5, 0.7])
    assert water.light(1.0, np.array([3.0, 2.5, 2.0, 0.0], F)) == pytest.approx(
        np.exp([0.0, -0.15, -0.3, -0.7]), rel=1e-6
    )
    water.shade([])
    assert water.optical == pytest.approx([0.0, 0.1, 0.2, 0.3])


def test_layers_are_counted_as_a_slow_twin_counts_them():
    rng = np.random.default_rng(2)
    z, alive = (rng.random(500) * 7.0).astype(F), rng.random(500) < 0.7
    water = Water([3.0, 3.0, 7.0], attenuation=0.05, layer=0.5)
    water.shade([(alive, z, 0.3)])
    for k in range(14):
        inside = sum(1 for a, h in zip(alive, z, strict=True) if a and int((F(7.0) - h) * F(2.0)) == k)
        assert water.optical[k + 1] - water.optical[k] == pytest.approx(0.05 * 0.5 + inside * 0.3 / 9.0)


def test_temperature_falls_through_the_thermocline_and_pressure_rises_with_depth():
    water = Water([9.0, 9.0, 100.0], deep_temperature=277.0, thermocline=30.0, thermocline_width=5.0)
    temperature = water.temperature(291.0, np.array([100.0, 70.0, 65.0, 0.0], F))
    assert temperature == pytest.approx([291.0, 284.0, 284.0 - 7.0 * np.tanh(1.0), 277.0], abs=1e-3)
    assert Water([9.0, 9.0, 100.0]).temperature(291.0, np.array([3.0], F)).tolist() == [291.0]
    assert water.pressure(101_325.0, np.array([100.0, 90.0], F)) == pytest.approx(
        [101_325.0, 101_325.0 + 1025 * 9.81 * 10]
    )
