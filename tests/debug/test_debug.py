"""The debug mode: what each check catches and what it says, and that it changes no result."""

import sys
from pathlib import Path

import esper
import numpy as np
import pytest

from ecs_eco import System, World, component, f32
from ecs_eco.components import Biology, Body, Metabolism, Nervous, Position
from ecs_eco.config.shipped import shipped
from ecs_eco.debug import DebugError
from ecs_eco.testing import act, arrange
from ecs_eco.testing.states import shuffle

sys.path.insert(0, str(Path(__file__).parent.parent / "worlds"))
from test_heredity import HERD

F = np.float32


@component
class Wool:
    """The coat of one animal."""

    length: f32[2] = 0.01  # [m]
    weights: f32[3].heavy = 0.0


def does(work):
    """Return a system that does `work(table, world)` to deer in tick 2."""

    def process(self, *_):
        if self.world.tick == 2:
            work(self.world.table("deer"), self.world)

    return type("Wrong", (System,), {"process": process})()


@pytest.fixture
def debug(monkeypatch):
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")


@pytest.fixture
def caught(debug, meadow):
    """A function that lets a wrong system act on the two deer (uids 3 and 4) in the debug mode,
    and returns what it is told."""

    def catch(work, *, setup=None, world=None, options=None, **deer):
        wrong = does(work)
        it = meadow(world=world, options={"systems": [wrong], **(options or {})}, **deer)
        if setup is not None:
            setup(it)
        with pytest.raises(DebugError) as error:
            it.run(5)
        assert it.tick == 2
        assert str(error.value).startswith("after Wrong, tick 2, ") or "field" in str(error.value)
        return str(error.value).removeprefix("after Wrong, tick 2, ")

    return catch


# --- nothing is caught where nothing is wrong, and nothing changes ------------------------------------------


def _in_both(monkeypatch, make, ticks):
    monkeypatch.delenv("ECS_ECO_DEBUG", raising=False)
    plain = make().run(ticks)
    assert plain.debug is None
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")
    watched = make()
    assert watched.debug is not None
    watched.run(ticks)
    assert watched.digest() == plain.digest()
    assert watched.series().equals(plain.series())
    return plain


@pytest.mark.parametrize("name", list(shipped()))
def test_a_shipped_world_has_the_same_result_in_debug_mode(monkeypatch, name):
    assert _in_both(monkeypatch, lambda: World.from_config(name), 50).tick == 50


def test_genomes_individual_brains_and_births_have_the_same_result_in_debug_mode(monkeypatch):
    world = _in_both(monkeypatch, lambda: World.from_config(HERD), 50)
    assert world.next_uid > 200


def test_the_world_with_everything_has_the_same_result_in_debug_mode(monkeypatch, menagerie):
    def make():
        return World.from_config(menagerie(), policies="untrained", learn=True)

    _in_both(monkeypatch, make, 50)


def test_a_learner_has_the_same_state_whatever_lay_in_memory_before(monkeypatch):
    """The advantages of a rollout that is not full are zero, not what the memory held."""
    digests = []
    for size in (10, 1000):
        junk = [np.full(size * 100, 7.7, F) for _ in range(50)]
        del junk
        digests.append(World.from_config("predator-prey", policies="untrained", learn=True).run(10).digest())
    assert digests[0] == digests[1]


@pytest.mark.parametrize("value", ["", "0"])
def test_debug_mode_is_off_by_default_and_by_0(monkeypatch, value):
    monkeypatch.setenv("ECS_ECO_DEBUG", value)
    world = World()
    assert world.debug is None
    table = world.add_table("sheep", Wool)
    world.spawn("sheep")
    world.flush()
    assert world.get(1, Wool)._columns is table[Wool]


def test_the_mode_is_chosen_when_a_world_is_made(monkeypatch, meadow):
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")
    world = meadow(options={"systems": [does(lambda t, w: t[Metabolism].energy.fill(np.nan))]})
    monkeypatch.delenv("ECS_ECO_DEBUG")
    with pytest.raises(DebugError, match="nan"):
        world.run(5)


def test_a_system_that_grows_a_table_by_a_flush_of_its_own_is_right(debug, meadow):
    """As an intervention does: what it does before and after the flush is checked apart."""

    def add(table, world):
        world.spawn("deer", Position(x=1.0), Metabolism(energy=0.25), n=200)
        world.kill(3)
        world.flush()

    world = meadow(options={"systems": [does(add)]}).run(4)
    assert world.table("deer").n == 201


# --- not a number -------------------------------------------------------------------------------------------


def test_nan_in_a_column_is_caught(caught):
    def work(table, world):
        table[Biology].age[table.by_uid()[1]] = np.nan

    assert caught(work) == "species 'deer': Biology.age of uid 4 (row 1) is nan; allowed are finite numbers"


def test_infinity_in_a_vector_and_in_a_heavy_column_is_caught(caught):
    def work(table, world):
        table[Wool].length[table.rows(), 1] = np.inf

    def heavy(table, world):
        table[Wool].weights[0] = [0, 0, -np.inf]

    message = caught(work, components=[Wool])
    assert (message == "species 'deer': Wool.length[1] of uid 3 (row 0) is inf (1 more); "
                       "allowed are finite numbers")
    assert (caught(heavy, components=[Wool])
            == "species 'deer': Wool.weights[2] of uid 3 (row 0) is -inf; allowed are finite numbers")


def test_nan_in_a_field_is_caught(caught):
    def work(table, world):
        world.fields["musk"].value[0, 1, 2] = np.nan

    message = caught(work, world={"fields": {"musk": {"cell": 2.0}}})
    assert "field 'musk' is nan in the cell (z, y, x) = (0, 1, 2)" in message


def test_nan_in_a_reading_is_caught_after_sense(debug, meadow):
    def broken(world, table, seekers, out, first):
        out[:, first] = np.where(table.uid[seekers.rows] == 4, np.nan, 0)

    world = meadow(sensors=[{"kind": "own", "property": "energy"},
                            {"kind": "custom", "name": "ear", "function": broken, "width": 1}])
    with pytest.raises(DebugError) as error:
        world.run(1)
    assert str(error.value) == ("after Sense, tick 0, species 'deer': "
                                "the reading 'ear' of uid 4 (row 1) is nan; allowed are finite numbers")


def test_nan_in_the_weights_of_a_shared_policy_is_caught(caught):
    def work(table, world):
        table.species.nerves.brain.named()["policy.head.bias"][1] = np.nan

    message = caught(work, policy={"kind": "shared", "hidden": [4]}, options={"policies": "untrained"})
    assert (message == "species 'deer': weight policy.head.bias[1] of the policy is nan; "
                       "allowed are finite numbers")


def test_nan_in_the_brain_of_one_is_caught(debug):
    world = World.from_config(HERD)
    goats = world.table("goat")
    policy = next(c for c in goats.columns if c.__name__ == "Policy")
    world.run(1)
    goats[policy].weights[7] = np.nan
    with pytest.raises(DebugError) as error:
        world.run(1)
    assert str(error.value).startswith("after what was done between ticks, tick 1, species 'goat': "
                                       "Policy.weights[0] of uid ")
    assert "(row 7) is nan; allowed" in str(error.value)


# --- rows outside masks -------------------------------------------------------------------------------------


def test_writing_to_a_free_row_is_caught(caught):
    def work(table, world):
        table[Body].mass[5] = 7

    def heavy(table, world):
        table[Wool].weights[9] = 7

    assert caught(work) == ("species 'deer': Body.mass of row 5, which is free, was 1.0 and is 7.0; "
                            "write to the living only: table.rows() or table.alive")
    assert ("Wool.weights of row 9, which is free, was [0. 0. 0.] and is [7. 7. 7.]"
            in caught(heavy, components=[Wool]))


def test_writing_to_the_row_of_one_that_died_is_caught_and_clearing_it_is_not(caught, debug, meadow):
    def cull(world):
        world.run(1)
        world.kill(3)

    def work(table, world):
        table[Body].mass[: table.high] += 1

    assert "Body.mass of row 0, which is free, was 1.0 and is 2.0" in caught(work, setup=cull)

    def clear(table, world):
        table[Body].mass[~table.alive] = 0

    meadow(options={"systems": [does(clear)]}).run(5)


@pytest.mark.parametrize(("column", "value", "said"), [
    ("alive", False, "alive of uid 3 (row 0) was True and is False; births and deaths are asked for: "),
    ("uid", 77, "uid of uid 3 (row 0) was 3 and is 77; births and deaths are asked for: "),
    ("born", 1, "born of uid 3 (row 0) was 0 and is 1; births and deaths are asked for: "),
])
def test_birth_and_death_outside_the_flushes_are_caught(caught, column, value, said):
    def work(table, world):
        getattr(table, column)[0] = value

    assert caught(work).startswith(f"species 'deer': {said}")


def test_columns_that_a_system_grows_or_replaces_are_caught(caught):
    assert caught(lambda table, world: table.reserve(500)) == (
        "species 'deer': alive has 500 rows and had 64; births make room at the end of `reproduce`")

    def replace(table, world):
        vars(table[Body])["mass"] = table[Body].mass.astype(float)  # behind the columns, which refuse it

    assert caught(replace) == ("species 'deer': column Body.mass was float32[64] and is float64[64]; "
                               "write into it: table[Body].mass[rows] = …")


def test_a_component_that_an_intervention_takes_away_is_right(debug, meadow):
    world = meadow(components=[Wool],
                   options={"systems": [does(lambda table, world: table.columns.pop(Wool))]}).run(4)
    assert Wool not in world.table("deer")


def test_a_component_that_the_table_lacks_is_named_as_without_debug_mode(debug, meadow):
    with pytest.raises(KeyError, match="unknown component 'Wool'"):
        meadow().get(3, Wool)


def test_a_cause_of_death_where_nobody_lives_is_caught(caught):
    def work(table, world):
        table.cause[9] = 1

    assert caught(work) == "species 'deer': cause of row 9 is 1; the row is free: who lives dies"


def test_births_and_deaths_that_a_system_carries_out_itself_are_caught(caught):
    assert caught(lambda table, world: table.vacate(np.array([0]))).startswith(
        "species 'deer': alive of uid 3 (row 0) was True and is False; births and deaths are asked for")
    assert caught(lambda table, world: table.occupy(1, 5, 2, {})).startswith(
        "species 'deer': alive of row 2, which is free, was False and is True; "
        "births and deaths are asked for")


# --- who is who ---------------------------------------------------------------------------------------------


def test_two_with_one_uid_are_caught(debug, meadow):
    world = meadow().run(1)
    world.table("deer").uid[1] = 1
    with pytest.raises(DebugError) as error:
        world.run(1)
    assert str(error.value) == ("after what was done between ticks, tick 1, species 'deer': "
                                "uid 1 lives in row 1 and in row 0 of 'grass'; a uid is given once")


def test_a_uid_that_was_never_given_is_caught(debug, meadow):
    world = meadow().run(1)
    world.table("deer").uid[1] = 50
    with pytest.raises(DebugError,
                       match=r"species 'deer': uid 50 lives in row 1, but the next to be given is 5"):
        world.run(1)


class Eraser(esper.Processor):
    """Takes an entity out of esper's own dict, past all of its functions."""

    def process(self):
        for entity, (m,) in list(esper.get_components(Metabolism)):
            if m.energy == 0.5 and self.world.tick == 2:
                dict.pop(esper._entities, entity)


def test_an_organism_that_a_processor_deletes_dies_in_debug_mode_too(debug):
    class Cat(esper.Processor):
        def process(self):
            for entity, _ in esper.get_component(Metabolism):
                esper.delete_entity(entity)
            esper.create_entity(Position(x=2), Metabolism())

    world = World((9.0, 9.0))
    world.add_table("mouse", Position, Metabolism)
    world.add_system(Cat())
    world.spawn("mouse", n=2)
    world.run(3)
    assert (world.table("mouse").n, world.next_uid) == (1, 6)


def test_entities_that_a_processor_deletes_behind_the_table_are_caught(debug):
    world = World((9.0, 9.0))
    world.add_table("mouse", Position, Metabolism)
    world.add_system(Eraser())
    world.spawn("mouse", Metabolism(energy=0.5))
    with pytest.raises(DebugError) as error:
        world.run(5)
    assert str(error.value) == ("after Eraser, tick 2, species 'mouse': esper has no entity 1, but uid 1 "
                                "(row 0) lives; to kill it, world.kill(uid, cause) or esper.delete_entity")


def test_components_that_a_processor_replaces_are_caught(debug):
    class Swap(esper.Processor):
        def process(self):
            dict.__setitem__(esper._entities[world.entity(1)], Metabolism, Metabolism(energy=9.0))

    world = World((9.0, 9.0))
    world.add_table("mouse", Position, Metabolism)
    world.add_system(Swap())
    world.spawn("mouse")
    with pytest.raises(DebugError, match="Metabolism of esper's entity 1 is not that of uid 1"):
        world.run(1)


# --- energy -------------------------------------------------------------------------------------------------


def test_energy_from_nothing_is_caught_with_who_got_most(caught):
    def gift(table, world):
        table[Metabolism].energy[table.rows()] += F([0.125, 0.25])

    message = caught(gift, setup=lambda world: arrange(world, "deer", energy=0.5), metabolism={"basal": 0.0})
    assert message == ("species 'deer': energy came from nothing: that of all living changed by 0.375, "
                       "but taken − burnt − given by 0, 0.375 apart; the largest gap, 0.25, is that of uid 4 "
                       "(row 1), Metabolism.energy 0.5 to 0.75; book it in taken, burnt or given")


def test_a_little_energy_from_nothing_among_many_is_caught(caught):
    """A hundred thousandth among 500 that all change: in a plain sum rounding would hide it."""

    def work(table, world):
        m, who = table[Metabolism], table.rows()
        before = m.energy[who]
        m.energy[who] *= F(0.9)
        m.burnt[who] += before - m.energy[who]
        m.energy[who[123]] += F(1e-5)

    assert "uid 126 (row 123)" in caught(work, count=500)


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
    world.add_system(type("Manna", (System,), {
        "needs": (Metabolism,), "update": lambda s, t, w: t[Metabolism].energy.__iadd__(t.alive)
    })())
    world.spawn("mouse")
    assert world.run(3).get(1, Metabolism).energy == 4.0


def test_a_listener_that_takes_energy_from_the_living_is_caught_at_the_deaths(debug, meadow):
    world = meadow()
    world.on_death.append(lambda table, rows: table[Metabolism].energy.__setitem__(1, 0.125))
    world.kill(3)
    with pytest.raises(DebugError, match=r"^after the deaths of the phase die, tick 0, species 'deer': "
                                         r"energy went to nowhere.*uid 4"):
        world.run(1)


def test_a_newborn_that_the_ledger_does_not_know_is_caught_at_its_end(debug, meadow):
    """A listener after the recorder's changes what the recorder has booked."""
    world = meadow().run(1)
    world.on_birth.append(lambda table, rows, *_: table[Metabolism].energy.__setitem__(rows, 0.75))
    world.spawn("deer", Position(x=3.0), Metabolism(energy=0.25))
    with pytest.raises(DebugError, match=r"^after Recorder, tick 1, species 'deer': "
                                         r"the energy ledger does not close: .* 0\.5 apart"):
        world.run(1)


def test_energy_given_between_ticks_is_not_held_against_a_system(debug, meadow):
    world = meadow().run(2)
    world.get(3, Metabolism).energy += 0.25
    assert world.run(2).tick == 4


# --- places -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("field", "value", "said"), [
    ("x", 20.0, "Position.x of uid 4 (row 1) is 20.0; allowed is [0, 20)"),
    ("y", -0.5, "Position.y of uid 4 (row 1) is -0.5; allowed is [0, 20)"),
    ("heading", 7.0, "Position.heading of uid 4 (row 1) is 7.0; allowed is [0, 2π)"),
    ("heading", -1.0, "Position.heading of uid 4 (row 1) is -1.0; allowed is [0, 2π)"),
])
def test_a_place_outside_the_space_and_a_heading_outside_the_circle_are_caught(caught, field, value, said):
    def work(table, world):
        getattr(table[Position], field)[1] = value
        table.version += 1

    assert caught(work) == f"species 'deer': {said}"


def test_moving_without_saying_so_is_caught(caught):
    def work(table, world):
        table[Position].x[1] = 2.5

    message = caught(work, setup=lambda world: arrange(world, "deer", x=1.5))
    assert message.startswith("species 'deer': Position.x of uid 4 (row 1) was 1.5 and is 2.5, "
                              "but table.version is the same; say ")


def test_an_index_that_a_system_disorders_is_caught(caught):
    def work(table, world):
        index = world.index(table)
        index.rows[:2], index.uid[:2] = index.rows[1::-1].copy(), index.uid[1::-1].copy()

    message = caught(work, setup=lambda world: arrange(world, "deer", x=1.5, y=1.5))
    assert (message == "species 'deer': entry 1 of the index of neighbours, uid 3, "
                       "follows uid 4 in one cell; systems only read it")


def test_a_system_that_acts_outside_a_tick_is_checked_too(debug, meadow):
    world = meadow(options={"systems": [type("Wrong", (System,),
                                             {"needs": (Nervous,), "update": _poison})()]})
    with pytest.raises(DebugError, match=r"after Wrong, tick 0, species 'deer': Nervous\.happiness of uid 3"):
        act(world, type(world.systems[-2]))
    assert world.debug.before is None
    shuffle(meadow()).run(3)


def _poison(self, table, world):
    table[Nervous].happiness[0] = np.nan
