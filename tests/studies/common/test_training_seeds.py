"""Statistics over training seeds."""

import numpy as np
import pytest

from ecs_eco.analysis.rhythm import Cosinor
from studies.common.training_seeds import p_common_phase, share_gap, share_of_lives


def test_a_common_phase_is_told_from_random_ones():
    assert p_common_phase([Cosinor(0, 1, 0.1 * i) for i in range(6)]) < 0.001
    rng = np.random.default_rng(3)
    p = [
        p_common_phase([Cosinor(0, 1, a) for a in rng.uniform(0, 2 * np.pi, 5)], n=199, seed=s)
        for s in range(200)
    ]
    assert 0.02 <= np.mean(np.array(p) <= 0.05) <= 0.1  # as often as it says


def lives(kept):
    return [
        {"training": i, "seed": j, "kept": outcome}
        for i, row in enumerate(kept)
        for j, outcome in enumerate(row)
    ]


def test_the_share_of_lives_counts_training_seeds_where_all_hangs_on_them():
    # Wilson by hand for 0 of 5: z² / (5 + z²), with z = 1.95996
    assert share_of_lives(lives([[0] * 4] * 5), "kept") == pytest.approx([0, 0, 0.43448], abs=1e-5)
    every = share_of_lives(lives([[1] * 4, [1] * 4, [0] * 4, [0] * 4]), "kept")
    assert every[0] == 0.5
    assert every[1] < 0.15  # 8 of 16 independent runs would give 0.28


def test_a_gap_of_shares_stays_within_1():
    none, most = lives([[0] * 4] * 5), lives([[0] * 4, [0, 0, 1, 1], [1] * 4, [0, 0, 0, 1], [1] * 4])
    value, low, high = share_gap(most, none, "kept")
    # by hand, Wilson's ends 0.16267 and 0.88491 of 0.55, 0 and 0.43448 of 0: squares of distances add
    assert (value, low, high) == pytest.approx((0.55, -0.03206, 0.88492), abs=1e-4)
    full, empty = lives([[1] * 4] * 5), lives([[0] * 4] * 5)
    assert share_gap(full, empty, "kept") == pytest.approx([1, 1 - np.hypot(0.43448, 0.43448), 1], abs=1e-4)
