"""The ledger of matter: what is set by hand has a column of its own, and all else closes."""

import numpy as np
import pytest

from ecs_eco.components import Chemistry
from ecs_eco.record.matter import LEDGER, imbalance
from ecs_eco.systems import TakeStock
from ecs_eco.testing import act
from tests.systems.test_dilute import ROTS

LITRES = 4000 * np.pi / 3 / 8  # of a deer


@pytest.fixture
def herd(meadow):
    return meadow(
        world={"substances": {"sugar": "", "salt": ""}, "objects": {"bone": {"body": {"radius": 1.0}}}},
        substances={"sugar": 0.5, "salt": 0.25},
        reactions=ROTS,
        remains="bone",
        lethal=[{"property": "salt", "max": 0.6}],
    )


def pages(world):
    """The ledger as arrays [ticks, holders, substances]."""
    table = world.recorder.matter_series().to_pydict()
    shape = (-1, *world.matter.stock.shape)
    return {name: np.reshape(table[name], shape) for name in LEDGER}


def test_what_is_written_by_hand_is_booked_as_such(herd):
    herd.run(1)
    herd.tables["deer"][Chemistry].molarity[0, 0] = 0.75
    act(herd, TakeStock)
    herd.run(1)
    page = pages(herd)
    assert page["set"][:, 1] == pytest.approx(np.array([[0, 0], [0.25 * LITRES, 0]]))
    assert np.abs(imbalance(page)).max() < 1e-9


@pytest.mark.definition("3 chemical rules", "3 staying alive", "3 remains")
def test_a_body_that_dies_of_salt_leaves_its_substances_in_what_remains(herd):
    herd.tables["deer"][Chemistry].molarity[0, 1] = 0.75
    herd.run(2)
    page = pages(herd)
    held = [0.5 * LITRES, 0.75 * LITRES]
    assert page["remains"][0] == pytest.approx(np.array([held, np.negative(held)]))
    assert herd.tables["bone"].n == herd.tables["deer"].n == 1
    assert page["stock_after"][1] == pytest.approx(np.array([held, [0.5 * LITRES, 0.25 * LITRES]]))
    assert np.abs(imbalance(page)).max() < 1e-9


def test_newborn_for_whom_nobody_provides_are_endowed_and_the_culled_without_remains_are_lost(meadow):
    world = meadow(world={"substances": {"sugar": ""}}, substances={"sugar": 0.5}, reactions=ROTS)
    world.spawn("deer")
    world.kill(int(world.tables["deer"].uid[0]))
    world.run(1)
    page = pages(world)
    assert page["endowed"].ravel() == pytest.approx([0.5 * LITRES])
    assert page["lost"].ravel() == pytest.approx([-0.5 * LITRES])
    assert np.abs(imbalance(page)).max() < 1e-9


def test_the_ledger_goes_on_after_a_checkpoint(herd, tmp_path):
    from ecs_eco import World

    herd.run(3)
    herd.spawn("deer")
    herd.flush()
    herd.save(tmp_path / "here")
    again = World.restore(tmp_path / "here").run(2)
    herd.run(2)
    for name, column in pages(again).items():
        assert (column == pages(herd)[name]).all(), name
    assert again.digest() == herd.digest()
