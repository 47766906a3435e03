"""What a record keeps of births and deaths."""

import numpy as np

from ecs_eco import World
from ecs_eco.components import Metabolism, Position
from ecs_eco.engine.addresses import Addresses
from ecs_eco.record.ledger import LEDGER
from ecs_eco.record.rows import Rows, note_births, note_deaths, noted_of


def ants():
    world = World((10, 10))
    table = world.add_table("ant", Position, Metabolism)
    for i in range(5):
        world.spawn("ant", Position(x=i, y=2 * i), Metabolism(energy=0.5 + i))
    world.flush()
    return table


def columns_of(table):
    return Addresses(lambda: [noted_of(table)])()[0]


def test_each_of_the_dying_is_kept_with_place_energy_age_cause_and_flows_in_the_order_given():
    table, page, died, rows = ants(), np.zeros((2, len(LEDGER))), np.zeros(256, np.int32), Rows()
    m = table[Metabolism]
    m.taken[:5], m.burnt[:5], m.given[:5] = range(5), range(10, 15), range(20, 25)
    table.cause[[3, 1]], table.killer[3], table.born[1] = 7, 42, -4
    note_deaths(table, columns_of(table), np.array([3, 1]), 6, 0.5, True, 1, page, died, rows)
    ((tick, species, uid, x, y, z, energy, cause, killer, age),) = rows.taken("deaths", 6)
    assert (tick.tolist(), species.tolist(), uid.tolist()) == ([6, 6], [1, 1], [4, 2])
    assert (x.tolist(), y.tolist(), z.tolist()) == ([3, 1], [6, 2], [0, 0])
    assert (energy.tolist(), age.tolist()) == ([3.5, 1.5], [3.0, 5.0])
    assert (cause.tolist(), killer.tolist()) == ([7, 7], [42, 0])
    assert page.tolist() == [[0.0] * 7, [0, 0, 4.0, 24.0, 44.0, 5.0, 0]]
    assert died.nonzero()[0].tolist() == [7]
    assert died[7] == 2
    assert (rows.n, rows.taken("deaths", 6)) == (0, [])


def test_between_ticks_what_the_dying_held_is_lost_and_their_flows_are_known():
    table, page = ants(), np.zeros((1, len(LEDGER)))
    table[Metabolism].taken[:5] = 1
    note_deaths(
        table, columns_of(table), np.array([0]), 6, 0.5, False, 0, page, np.zeros(256, np.int32), None
    )
    assert page.tolist() == [[0, 0, 0, 0, 0, 0.5, 0]]


def test_the_dying_lose_no_negative_energy_because_they_cannot_burn_what_they_lack():
    table, page = ants(), np.zeros((1, len(LEDGER)))
    m = table[Metabolism]
    m.energy[:2], m.burnt[:2], m.taken[:2] = [-0.25, 0.5], 1.0, 2.0
    columns, died = columns_of(table), np.zeros(256, np.int32)
    note_deaths(table, columns, np.array([0, 1]), 6, 0.5, True, 0, page, died, None)
    assert page.tolist() == [[0, 0, 4.0, 1.75, 0, 0.5, 0]]  # 0.75 + 1 burned; the same change of the stock
    note_deaths(table, columns, np.array([0]), 6, 0.5, False, 0, page, died, None)
    assert page.tolist() == [[0, 0, 4.0, 1.5, 0, 0.5, 0]]


def test_what_the_table_lacks_is_zero():
    world, page, rows = World((10, 10)), np.zeros((1, len(LEDGER))), Rows()
    table = world.add_table("stone")
    world.spawn("stone", n=2)
    world.flush()
    note_deaths(
        table, columns_of(table), np.array([0, 1]), 0, 1.0, True, 0, page, np.zeros(256, np.int32), rows
    )
    ((_, _, uid, x, y, z, energy, *_),) = rows.taken("deaths", 0)
    assert uid.tolist() == [1, 2]
    assert not any(a.any() for a in (x, y, z, energy, page))


def test_births_of_ticks_that_are_over_come_first_and_room_grows():
    table, page, rows = ants(), np.zeros((1, len(LEDGER))), Rows()
    parents, second = np.array([8, 9], np.uint64), np.zeros(2, np.uint64)
    for tick in range(100):
        note_births(table, columns_of(table), np.array([4, 2]), parents, second, tick, 0, page, rows)
    over, later = rows.taken("births", 98)
    assert (over[0].tolist(), later[0].tolist()) == ([t for t in range(99) for _ in range(2)], [99, 99])
    _, species, uid, x, _, _, energy, parent, parent2, genome = later
    assert (species.tolist(), uid.tolist(), x.tolist()) == ([0, 0], [5, 3], [4, 2])
    assert (energy.tolist(), parent.tolist(), parent2.tolist()) == ([4.5, 2.5], [8, 9], [0, 0])
    assert genome.tolist() == [b"", b""]
    assert page.tolist() == [[0, 700, 0, 0, 0, 0, 0]]
