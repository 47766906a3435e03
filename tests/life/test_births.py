import numpy as np
import pytest

from ecs_eco.life.births import ticks


@pytest.mark.parametrize("dt", [0.1, 0.3, 1.0])
def test_multiples_of_a_tick_are_whole_numbers_of_ticks_also_in_float32(dt):
    n = np.arange(1, 20_000)
    assert ticks((n * dt).astype(np.float32), dt).tolist() == n.tolist()
    assert [ticks(float(k) * dt, dt) for k in n[::100]] == n[::100].tolist()
    assert ticks(np.float32([0.0, 0.5, 1.001]) * np.float32(dt), dt).tolist() == [0, 1, 2]
