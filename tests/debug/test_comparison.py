"""What holds between before and after a system: rows outside masks, energy, moving."""

import numpy as np
import pytest

from ecs_eco import System, World
from ecs_eco.components import Body, Metabolism, Position
from ecs_eco.debug import DebugError
from ecs_eco.testing import arrange
from tests.debug.wrong import Wool, deer, does

F = np.float32


# --- rows outside masks -------------------------------------------------------------------------------------


def test_writing_to_a_free_row_is_caught(caught):
    def work(table, world):
        table[Body].mass[5] = 7

    def heavy(table, world):
        table[Wool].weights[9] = 7

    assert caught(work) == (
        "species 'deer': Body.mass of row 5, which is free, was 1.0 and is 7.0; "
        "write only to living rows: table.rows() or table.alive"
    )
    assert "Wool.weights of row 9, which is free, was [0. 0. 0.] and is [7. 7. 7.]" in caught(
        heavy, components=[Wool]
    )


def test_writing_to_the_row_of_one_that_died_is_caught_and_clearing_it_is_not(caught, debug, meadow):
    def cull(world):
        world.run(1)
        world.kill(deer(world)[0])

    def work(table, world):
        table[Body].mass[: table.high] += 1

    assert "Body.mass of row 0, which is free, was 1.0 and is 2.0" in caught(work, setup=cull)

    def clear(table, world):
        table[Body].mass[~table.alive] = 0

    meadow(options={"systems": [does(clear)]}).run(5)


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        (
            "alive",
            False,
            "alive of uid {uid} (row 0) was True and is False; request births and deaths with table.request, ",
        ),
        (
            "uid",
            77,
            "uid of uid {uid} (row 0) was {uid} and is 77; request births and deaths with table.request, ",
        ),
        (
            "born",
            1,
            "born of uid {uid} (row 0) was 0 and is 1; request births and deaths with table.request, ",
        ),
    ],
)
def test_birth_and_death_outside_the_flushes_are_caught(caught, column, value, message):
    def work(table, world):
        getattr(table, column)[0] = value

    assert caught(work).startswith("species 'deer': " + message.format(uid=caught.uids[0]))


def test_columns_that_a_system_grows_or_replaces_are_caught(caught):
    assert caught(lambda table, world: table.reserve(500)) == (
        "species 'deer': alive has 500 rows and had 64; births add rows only at the end of `reproduce`"
    )

    def replace(table, world):
        vars(table[Body])["mass"] = table[Body].mass.astype(float)  # behind the columns, which refuse it

    assert caught(replace) == (
        "species 'deer': column Body.mass was float32[64] and is float64[64]; "
        "write into the column: table[Body].mass[rows] = …"
    )


def test_a_component_that_an_intervention_takes_away_is_right(debug, meadow):
    world = meadow(
        components=[Wool], options={"systems": [does(lambda table, world: table.columns.pop(Wool))]}
    ).run(4)
    assert Wool not in world.table("deer")


def test_a_component_that_the_table_lacks_is_named_as_without_debug_mode(debug, meadow):
    world = meadow()
    with pytest.raises(KeyError, match="unknown component 'Wool'"):
        world.get(deer(world)[0], Wool)


def test_births_and_deaths_that_a_system_carries_out_itself_are_caught(caught):
    assert caught(lambda table, world: table.vacate(np.array([0]))).startswith(
        f"species 'deer': alive of uid {caught.uids[0]} (row 0) was True and is False; "
        "request births and deaths with table.request"
    )
    assert caught(lambda table, world: table.occupy(1, 5, 2, {})).startswith(
        "species 'deer': alive of row 2, which is free, was False and is True; "
        "request births and deaths with table.request"
    )


# --- energy -------------------------------------------------------------------------------------------------


def test_energy_from_nothing_is_caught_with_who_got_most(caught):
    def gift(table, world):
        table[Metabolism].energy[table.rows()] += F([0.125, 0.25])

    message = caught(gift, setup=lambda world: arrange(world, "deer", energy=0.5), metabolism={"basal": 0.0})
    assert message == (
        "species 'deer': energy appeared without a source: the organisms' energy changed by 0.375, "
        "but taken − burnt − given by 0, a difference of 0.375; the largest gap, 0.25, is in "
        f"uid {caught.uids[1]} (row 1), with Metabolism.energy 0.5 before and 0.75 after; "
        "add it to taken, burnt or given"
    )


def test_a_little_energy_from_nothing_among_many_is_caught(caught):
    """A hundred thousandth among 500 that all change: in a plain sum rounding would hide it."""

    def work(table, world):
        m, who = table[Metabolism], table.rows()
        before = m.energy[who]
        m.energy[who] *= F(0.9)
        m.burnt[who] += before - m.energy[who]
        m.energy[who[123]] += F(1e-5)

    message = caught(work, count=500)
    assert f"uid {caught.uids[123]} (row 123)" in message


def test_energy_that_is_booked_or_passed_on_is_right(debug, meadow):
    def share(table, world):
        m, (one, two) = table[Metabolism], table.rows()
        m.energy[one] -= F(0.1)
        m.energy[two] += F(0.1)
        m.energy[two] += F(0.125)
        m.taken[two] += F(0.125)

    meadow(options={"systems": [does(share)]}).run(5)


def test_a_world_that_keeps_no_books_may_give_energy(debug):
    world = World((9.0, 9.0))
    world.add_table("mouse", Metabolism)
    world.add_system(
        type(
            "Manna",
            (System,),
            {"needs": (Metabolism,), "update": lambda s, t, w: t[Metabolism].energy.__iadd__(t.alive)},
        )()
    )
    world.spawn("mouse")
    assert world.run(3).get(1, Metabolism).energy == 4.0


def test_a_listener_that_takes_energy_from_the_living_is_caught_at_the_deaths(debug, meadow):
    world = meadow()
    first, second = deer(world)
    world.on_death.append(lambda table, rows: table[Metabolism].energy.__setitem__(1, 0.125))
    world.kill(first)
    with pytest.raises(
        DebugError,
        match=r"^after the deaths of the phase die, tick 0, species 'deer': "
        rf"energy disappeared without a sink.*uid {second} \(row 1\)",
    ):
        world.run(1)


def test_a_newborn_that_the_ledger_does_not_know_is_caught_at_its_end(debug, meadow):
    """A listener after the recorder's changes what the recorder has booked."""
    world = meadow().run(1)
    world.on_birth.append(lambda table, rows, *_: table[Metabolism].energy.__setitem__(rows, 0.75))
    world.spawn("deer", Position(x=3.0), Metabolism(energy=0.25))
    with pytest.raises(
        DebugError,
        match=r"^after Recorder, tick 1, species 'deer': "
        r"the energy ledger does not close: .* a difference of 0\.5; ",
    ):
        world.run(1)


def test_energy_given_between_ticks_is_not_held_against_a_system(debug, meadow):
    world = meadow().run(2)
    world.get(deer(world)[0], Metabolism).energy += 0.25
    assert world.run(2).tick == 4


def test_moving_without_saying_so_is_caught(caught):
    def work(table, world):
        table[Position].x[1] = 2.5

    message = caught(work, setup=lambda world: arrange(world, "deer", x=1.5))
    assert message.startswith(
        f"species 'deer': Position.x of uid {caught.uids[1]} (row 1) "
        "was 1.5 and is 2.5, but table.version is the same; add "
    )
