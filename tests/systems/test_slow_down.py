import numpy as np
import pytest

from ecs_eco.components import Body, Metabolism, Position, SpeedScale, Stature
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import SlowDown
from ecs_eco.testing import act

COLD = {"ambient": {"temperature": 290.0}}
LIZARD = {
    "metabolism": {"energy": 1.0, "basal": 0.25},
    "ectothermy": {"q10": 4.0, "reference": 300.0, "torpor": 280.0},
}


@pytest.mark.parametrize(
    ("kelvin", "rate", "pace"), [(300.0, 1, 1), (295.0, 0.5, 0.5), (305.0, 2, 2), (280.0, 0.0625, 0)]
)
def test_rates_rise_by_q10_with_ten_kelvin_and_torpor_ends_motion(meadow, kelvin, rate, pace):
    world = meadow(world={"ambient": {"temperature": kelvin}, "dt": 0.5}, **LIZARD)
    act(world, SlowDown)
    deer = world.tables["deer"]
    assert deer[SpeedScale].pace[:2].tolist() == [pace, pace]
    assert deer[Metabolism].energy[:2] == pytest.approx(1 + (1 - rate) * 0.125)
    assert deer[Metabolism].burnt[:2] == pytest.approx((rate - 1) * 0.125)


def test_it_starves_later_in_the_cold_and_each_has_its_own_q10(meadow):
    ways = [{"ectothermy": {"q10": q10, "reference": 300.0}} for q10 in (1.0, 4.0)]
    assert [meadow(world=COLD, **LIZARD | way).run(6).tables["deer"].n for way in ways] == [0, 2]
    gene = {"name": "g", "trait": "ectothermy.q10", "letters": 1, "values": [1.0, 4.0]}
    world = meadow(world=COLD, count=40, genome={"alphabet": "01", "genes": [gene]}, **LIZARD).run(6)
    assert 0 < world.tables["deer"].n < 40


def test_in_the_cold_the_young_save_a_share_of_their_own_upkeep(meadow):
    world = meadow(world=COLD, **LIZARD, growth={"rate": 1e-12, "newborn": 0.1})
    deer = world.tables["deer"]
    mass = np.float32([deer[Stature].mass[0] / 16, deer[Stature].mass[1]])
    deer[Body].mass[:2] = mass
    world.run(1)
    assert deer[Metabolism].energy[:2] == pytest.approx(1 - 0.25 * 0.25 * np.array([0.125, 1]))


@pytest.mark.parametrize("kelvin", [290.0, 310.0])
def test_the_torpid_burn_nothing_and_stand_still(meadow, kelvin):
    torpor = {"metabolism": {"energy": 0.3, "basal": 0.25, "torpor": True}}
    world = meadow(world={"ambient": {"temperature": kelvin}}, **LIZARD | torpor).run(6)
    m, x = world.tables["deer"][Metabolism], world.tables["deer"][Position].x
    before = [m.energy[:2].tolist(), m.burnt[:2].tolist(), x[:2].tolist()]
    world.run(20)
    assert before == [[0.0, 0.0], m.burnt[:2].tolist(), x[:2].tolist()]
    assert m.energy[:2].tolist() == [0.0, 0.0]


def test_a_gene_for_the_pace_is_refused(meadow):
    gene = {"name": "g", "trait": "locomotion.pace", "letters": 4, "low": 0.5, "high": 2.0}
    with pytest.raises(ConfigError, match=r'genes.0.trait = "locomotion.pace"\n.*temperature sets the pace'):
        meadow(genome={"alphabet": "01", "genes": [gene]}, locomotion={"speed": {"walk": 1.0}}, **LIZARD)
    assert load("predator-prey").species["deer"].ectothermy is None
