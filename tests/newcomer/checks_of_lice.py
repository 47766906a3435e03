from wool_lab import MEADOW
from wool_lab.lice import Bite, Lice

from ecs_eco import World
from ecs_eco.testing import check_component, check_system


def lousy(threads=1):
    return World.from_config(MEADOW, threads=threads, trust=True, systems=[Bite()])


def test_lice_multiply():
    rabbits = lousy().run(10).table("rabbit")
    assert rabbits[Lice].number[rabbits.rows()].max() > 1.1


def test_lice_keep_the_rules():
    check_component(Lice)
    check_system(Bite, lousy)
