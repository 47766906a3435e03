import esper
import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism, Position
from ecs_eco.debug import StaleHandle


@pytest.fixture
def mice(monkeypatch):
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")
    world = World((9.0, 9.0))
    world.add_table("mouse", Position, Metabolism)
    world.spawn("mouse", Metabolism(energy=0.5), n=2)
    return world.run(1)


def test_a_handle_kept_past_death_is_caught_when_it_reads_or_writes(mice):
    kept = mice.get(1, Metabolism)
    (_, _, from_each), _ = mice.each(Position, Metabolism)
    kept.energy += 0.25
    assert from_each.energy == 0.75
    mice.kill(1)
    mice.flush()
    with pytest.raises(StaleHandle) as error:
        kept.energy = 1.0
    assert str(error.value) == (
        "tables['mouse']: Metabolism.energy through an outdated handle: "
        "uid 1 is dead, and row 0 is free now; store uids and call world.get again"
    )
    mice.spawn("mouse")
    mice.flush()
    for handle in (kept, from_each):
        with pytest.raises(StaleHandle, match="uid 1 is dead, and row 0 belongs to uid 3 now"):
            print(handle.energy)
    assert mice.get(3, Metabolism).energy == 1.0


def test_handles_that_esper_gave_are_caught_too(mice):
    with mice:
        kept = dict(esper.get_component(Metabolism))[mice.entity(2)]
        assert kept.energy == 0.5
        mice.kill(2)
        mice.flush()
        mice.sync()
        with pytest.raises(StaleHandle, match="uid 2 is dead"):
            kept.energy = 3.0
        assert len(esper.get_component(Metabolism)) == 1


def test_a_handle_outlives_growth_but_not_another_order_of_rows(mice):
    kept = mice.get(1, Metabolism)
    mice.spawn("mouse", n=500)
    mice.flush()
    kept.energy = 0.25
    assert mice.table("mouse")[Metabolism].energy[0] == 0.25
    mice.table("mouse").reorder(np.array([1, 0, *range(2, 502)]))
    with pytest.raises(StaleHandle, match="uid 1 is no longer in row 0, because rows were reordered"):
        print(kept.energy)
    assert "energy=0.25" in repr(mice.get(1, Metabolism))
