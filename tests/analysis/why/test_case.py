"""A run as a case: who could have bred."""

import numpy as np
import pytest

from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.why import Case


@pytest.mark.parametrize(("given", "able"), [(0.3, 0.25), (0.0, 1.0)])
def test_those_that_cannot_pay_for_a_newborn_do_not_count_as_fed(given, able):
    way = {"kind": "asexual", "place": "anywhere", "rate": 0.02, "energy_min": 0.0, "energy_given": given}
    held = {"tick": np.zeros(4, int), "energy": np.array([0.0, 0.2, 0.3, 0.4])}
    run = Case(
        Series(np.arange(1), ("deer",), {}, {}),
        {"species": {"deer": {"reproduction": way}}},
        snapshots={"deer": held},
    )
    assert run.able("deer")[1].tolist() == [able]
