"""Statistics over training seeds."""

import numpy as np

from ecs_eco.analysis.rhythm import Cosinor
from studies.common.training_seeds import p_common_phase


def test_a_common_phase_is_told_from_random_ones():
    assert p_common_phase([Cosinor(0, 1, 0.1 * i) for i in range(6)]) < 0.001
    rng = np.random.default_rng(3)
    p = [
        p_common_phase([Cosinor(0, 1, a) for a in rng.uniform(0, 2 * np.pi, 5)], n=199, seed=s)
        for s in range(200)
    ]
    assert 0.02 <= np.mean(np.array(p) <= 0.05) <= 0.1  # as often as it says
