"""A run as a case: who could have bred."""

import numpy as np
import pytest

from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.why import Case
from ecs_eco.analysis.why.limits import greatest_rate, unborn


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


@pytest.mark.parametrize("part", ["genes", "derived"])
def test_what_genes_decide_is_not_taken_from_the_world_file(part):
    way = {"kind": "asexual", "place": "anywhere", "rate": 0.5, "energy_min": 0.0, "energy_given": 0.0}
    n = np.full(10, 20.0)
    columns = {"n": n[:, None], "births": np.full((10, 1), 2)}

    def case(*traits):
        coded = [{"name": f"g{i}", "trait": trait} for i, trait in enumerate(traits)]
        genome = {"genes": coded} if part == "genes" else {"derived": {one["name"]: one for one in coded}}
        held = {"tick": np.zeros(4, int), "energy": np.ones(4)}
        series = Series(np.arange(10), ("deer",), columns, {"config": {"dt": 1.0}})
        return Case(series, {"species": {"deer": {"reproduction": way, "genome": genome}}}, {"deer": held})

    assert unborn(case("body.mass"), "deer", 0, 10) == pytest.approx((0, 0.4))
    assert unborn(case("reproduction.energy_min"), "deer", 0, 10) == (0, 0)
    assert greatest_rate(case("reproduction.rate"), "deer") == pytest.approx(0.1)
