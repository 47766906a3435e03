from ecs_eco.components import Metabolism
from ecs_eco.systems import ResetFlows
from ecs_eco.testing import act, arrange


def test_flows_are_counted_from_zero_and_energy_stays(meadow):
    world = meadow()
    deer = arrange(world, "deer", taken=[1, 2], burnt=3, given=4, energy=[0.5, 0.25], digesting=2)
    act(world, ResetFlows)
    m = deer[Metabolism]
    assert [m.taken[:2].tolist(), m.burnt[:2].tolist(), m.given[:2].tolist()] == [[0, 0]] * 3
    assert (m.energy[:2].tolist(), m.digesting[:2].tolist()) == ([0.5, 0.25], [2, 2])
