"""The sea in which krill learn too."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.config import load
from ecs_eco.lab.pretraining import pretrain
from ecs_eco.testing import check_world

SMALL = {
    "species.phytoplankton.count": 150,
    "species.copepod.count": 40,
    "species.krill.count": 12,
    "species.krill.max_count": 12,
    "training.set": {},
    "space.size": [20.0, 20.0, 20.0],
}
SOON = {"species.copepod.ppo.horizon": 20, "species.krill.ppo.horizon": 20}


def test_it_keeps_its_promises_while_both_learn():
    small = load("learning-krill", SMALL | SOON)
    check_world(
        lambda threads: World.from_config(small, policies="untrained", threads=threads, learn=True), ticks=60
    )


def test_copepods_are_those_of_the_other_sea():
    here, other = (load(name) for name in ("learning-krill", "diel-migration"))
    one, two = (c.species["copepod"].model_dump() for c in (here, other))
    assert one == two
    for part in ("space", "sun", "water", "fields", "dt"):
        assert getattr(here, part) == getattr(other, part), part
    assert here.species["krill"].reflex is None


@pytest.mark.slow
def test_copepods_go_down_by_day_and_krill_keep_their_number_with_the_bundled_policies():
    world = World.from_config(load("learning-krill"), seed=5).run(300)  # a day
    depths = []
    for _ in range(2):  # a night, then noon: days begin at sunrise
        world.run(275 if not depths else 100)
        copepods = world.tables["copepod"]
        depths.append(30.0 - float(copepods[Position].z[copepods.rows()].mean(dtype=np.float64)))
    assert depths[1] > depths[0] + 8
    assert 30 <= world.tables["krill"].n <= 40


def test_both_are_trained_at_a_time(tmp_path):
    trained = pretrain(load("learning-krill", SMALL | SOON), seed=1, ticks=50, out=tmp_path)
    assert set(trained["policies"]) == {"copepod", "krill"}
    assert all(trained["reports"][name]["n_transitions"] > 0 for name in ("copepod", "krill"))
    assert trained["reports"]["krill"]["learning_rate"] == pytest.approx(1e-3)
