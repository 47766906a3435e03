import pytest

from ecs_eco.systems import Diffuse
from ecs_eco.testing import act, arrange

FIELDS = {"fields": {"musk": {"cell": 2.0, "diffusion": 0.5, "decay": 0.0},
                     "hay": {"cell": 1.0, "decay": 0.5}},
          "dt": 0.5}


def test_every_body_emits_its_rate_where_it_is(meadow):
    world = meadow(world=FIELDS, emits={"musk": 3.0}, grass={"emits": {"hay": 4.0, "musk": 1.0}})
    arrange(world, "deer", x=[1, 11], y=[1, 11])
    arrange(world, "grass", x=[5.5, 5.7], y=[3.5, 3.5])
    act(world, Diffuse)
    assert world.fields["musk"].value.sum(dtype=float) == pytest.approx(2 * 1.5 + 2 * 0.5)
    hay = world.fields["hay"].value[0]
    assert hay[3, 5] == pytest.approx(2 * 4 * 0.5 * 2.718281828 ** (-0.25), rel=1e-6)
    assert hay.sum() == hay[3, 5]  # it does not diffuse


def test_a_smell_follows_who_moves_and_stays_where_it_was(meadow):
    world = meadow(world=FIELDS, emits={"hay": 2.0})
    for x in (0.5, 9.5):
        arrange(world, "deer", x=x, y=0.5)
        act(world, Diffuse)
    fade = 2.718281828 ** (-0.25)
    assert world.fields["hay"].value[0, 0, [0, 9]].tolist() == pytest.approx([2 * fade**2, 2 * fade])


def test_the_dead_emit_no_more(meadow):
    world = meadow(world=FIELDS, emits={"musk": 2.0})
    world.kill(int(world.tables["deer"].uid[0]))
    world.flush()
    act(world, Diffuse)
    assert world.fields["musk"].value.sum(dtype=float) == pytest.approx(1.0)
