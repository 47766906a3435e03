"""Everything that ships passes the checks that ship; what breaks a rule does not."""

import numpy as np
import pytest

from ecs_eco import System, World, component as declare, components, f32, systems
from ecs_eco.components import Metabolism, Position
from ecs_eco.config import load
from ecs_eco.config.shipped import shipped
from ecs_eco.record import Recorder
from ecs_eco.testing import (
    act,
    arrange,
    check_component,
    check_system,
    check_world,
    difference,
    shuffle,
    state,
    system as system_checks,
)
from tests.worlds.aviary import AVIARY
from tests.worlds.own_worlds import WORLDS

CHECKS = {name: getattr(components, name) for name in components.__all__} | {
    name: getattr(systems, name) for name in systems.__all__
}

COSTLY = {
    "name": "costly-menagerie",
    "species": {"ram": {"neural_costs": {"hidden_unit": 1e-4, "receptor": 1e-4, "transition": 1e-3}}},
}


@pytest.fixture(scope="module")
def watched():
    """The worlds that have run in debug mode, which watches all of their systems at once."""
    return set()


def has(config, name):
    """Whether a world has a system."""
    world = World.from_config(config, policies="untrained", learn=name == "Learn")
    return name in {type(system).__name__ for system in world.systems}


@pytest.mark.parametrize(
    "name", [*CHECKS, "Recorder", *(pytest.param(world, marks=pytest.mark.slow) for world in shipped())]
)
def test_what_ships_conforms(name, menagerie, watched, monkeypatch):
    if name in shipped():
        counts = load(name).resolved()["species"]
        few = load(name, {f"species.{species}.count": min(s["count"], 120) for species, s in counts.items()})
        check_world(lambda threads: World.from_config(few, policies="untrained", threads=threads), ticks=15)
    elif name in components.__all__:
        check_component(CHECKS[name])
    else:
        training = name == "Respawn"
        own = menagerie(), AVIARY, WORLDS["winter"], WORLDS["stroll"], menagerie(**COSTLY)
        config = next(c for c in own if training or has(c, name))
        world = name if name in ("Learn", "Respawn") else config["name"]
        if world in watched:
            monkeypatch.setattr(system_checks, "_watch", lambda world, ticks: None)
        watched.add(world)
        check_system(
            CHECKS.get(name, Recorder),
            lambda threads: World.from_config(
                config, policies="untrained", threads=threads, learn=name == "Learn", training=training
            ),
            ticks=15,
        )


def _world(system):
    def make(threads):
        world = World((10, 10), threads=threads, seed=1)
        world.add_table("hare", Position, Metabolism)
        rng = np.random.default_rng(0)
        for _ in range(9):
            world.spawn(
                "hare", Position(x=rng.random() * 10, y=rng.random() * 10), Metabolism(energy=rng.random())
            )
        world.flush()
        world.add_system(systems.ResetFlows())
        world.add_system(system())
        return world

    return make


class Good(System):
    """Everyone hops by one, if the draw for its uid says so."""

    needs = (Position,)
    phase = "move"

    def update(self, table, world):
        from ecs_eco.engine import random

        rows = table.rows()
        hops = random.draw_many(world.key, table.uid[rows], random.USER) < 0.5
        table[Position].x[rows] = (table[Position].x[rows] + hops) % 10
        table.version += 1


class Silent(Good):
    """Moves and does not say so."""

    def update(self, table, world):
        table[Position].x[table.rows()] = 3


class Escape(Good):
    """Leaves the space."""

    def update(self, table, world):
        table[Position].x[: table.high] += 1
        table.version += 1


class Undefined(Good):
    """Divides by nothing."""

    needs = (Metabolism,)

    def update(self, table, world):
        with np.errstate(all="ignore"):
            table[Metabolism].energy[: table.high] /= 0


class Murder(Good):
    """Takes lives itself."""

    def update(self, table, world):
        table.alive[0] = False


class Widen(Good):
    """Makes a column of another type."""

    needs = (Metabolism,)

    def update(self, table, world):
        table[Metabolism].energy = table[Metabolism].energy.astype(np.float64)


class Dice(Good):
    """Draws from the global generator."""

    def update(self, table, world):
        np.random.random()  # noqa: NPY002


class Plague(Good):
    """Kills by a cause that nobody knows."""

    def update(self, table, world):
        table.cause[0] = 99


class First(Good):
    """Favours the first row."""

    needs = (Metabolism,)

    def update(self, table, world):
        table[Metabolism].energy[table.rows()[:1]] += 1


class Threads(Good):
    """Counts in what parts it is called."""

    needs = (Metabolism,)

    def update(self, table, world):
        def kernel(first, last, energy):
            energy[first:last] += last - first

        world.split(kernel, table.high, table[Metabolism].energy)


class Haunt(Good):
    """Feeds a row in which nobody lives."""

    needs = (Metabolism,)

    def update(self, table, world):
        table[Metabolism].energy[table.capacity - 1] += 1


class Manna(Good):
    """Feeds everyone from nothing."""

    needs = (Metabolism,)

    def update(self, table, world):
        table[Metabolism].energy[table.alive] += np.float32(0.5)


class Bare(Good):
    def update(self, table, world):
        pass


class Nowhere(Good):
    """Has a phase of its own."""

    phase = "dusk"


class Needy(Good):
    """Needs what is no component."""

    needs = (int,)


class Empty(System):
    """Does nothing."""


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (Silent, "Silent: it moves 'hare' without marking the table; add `table.version \\+= 1`"),
        (Escape, r"Escape: Position.x in table 'hare' leaves \[0, 10.0\)"),
        (
            Undefined,
            "Undefined: Metabolism.energy in table 'hare' has become (inf|nan); expected a finite value",
        ),
        (Murder, "Murder: it changes the organisms in 'hare'; use table.request and world.kill"),
        (Widen, "column energy is float32.* cannot become float64"),
        (Dice, "Dice: it uses global random numbers; use ecs_eco.engine.random"),
        (
            Plague,
            r"Plague: a cause of death in table 'hare' is unknown; get its code from world.cause\(name\)",
        ),
        (
            First,
            "First: its results change with a different row order: tick 0, hare: Metabolism.energy of uid 1 is",
        ),
        (Threads, "Threads: its results change with two threads: tick 0, hare: Metabolism.energy"),
        (Haunt, "Haunt.*'hare'.*, which is free, was .* and is .*; write only to living rows"),
        (Manna, "Manna.*'hare'.*energy appeared without a source: .*; add it to taken, burnt or given"),
        (Bare, "Bare: add a docstring that describes what the system does to which organisms"),
        (Nowhere, "Nowhere: the phase is 'dusk'; expected one of environment, sense"),
        (Needy, "Needy: needs names <class 'int'>, which is not a component"),
        (Empty, r"Empty: it must define update\(table, world\) or process\(\)"),
        (int, "<class 'int'> is not a class derived from ecs_eco.System"),
    ],
)
def test_a_system_that_breaks_a_rule_is_told_so(kind, message):
    with pytest.raises((AssertionError, ValueError), match=message):
        check_system(kind, _world(kind))


def test_a_system_that_keeps_the_rules_passes_and_must_be_in_the_world():
    check_system(Good, _world(Good))
    with pytest.raises(AssertionError, match="Good: make_world builds a world without this system; add it"):
        check_system(Good, _world(Bare))


def test_blame_for_what_another_system_does_is_not_laid_on_this_one():
    def make(threads):
        world = _world(First)(threads)
        world.add_system(Good(), phase="record")
        return world

    with pytest.raises(
        AssertionError,
        match=r"before Good runs, with a different row order, hare: .*; "
        r"another system is the cause",
    ):
        check_system(Good, make)


def test_a_component_that_breaks_a_rule_is_told_so():
    @declare
    class Mute:
        x: f32 = 0

    @declare
    class Endless:
        """Never ends."""

        x: f32 = float("inf")

    for kind, message in [
        (int, "is not a component; declare it with @component"),
        (Mute, "Mute: describe it in a docstring"),
        (Endless, "Endless.x: the default inf is not finite"),
    ]:
        with pytest.raises(AssertionError, match=message):
            check_component(kind)


def test_a_world_that_breaks_a_promise_is_told_so(menagerie):
    class Leak(System):
        """Energy vanishes."""

        needs = (Metabolism,)
        phase = "metabolise"

        def update(self, table, world):
            table[Metabolism].energy[: table.high] *= 0.5

    count = []

    class Whim(System):
        """Every world is another."""

        needs = (Metabolism,)

        def update(self, table, world):
            count.append(1)
            table[Metabolism].burnt[: table.high] += len(count)
            table[Metabolism].energy[: table.high] -= len(count)

    def make(system):
        def build(threads):
            world = World.from_config(menagerie(), policies="random", threads=threads)
            world.add_system(system())
            return world

        return build

    with pytest.raises(
        AssertionError, match=r"menagerie, tick 0, moss: the energy ledger is off by .*: stock_before"
    ):
        check_world(make(Leak), ticks=2)
    with pytest.raises(
        AssertionError,
        match=r"menagerie: the same seed gives a different world; draw random numbers with ecs_eco.draw",
    ):
        check_world(make(Whim), ticks=2)
    with pytest.raises(
        AssertionError,
        match=r"menagerie: a different row order gives different results: lynx: "
        r"(Metabolism.\w+ of uid|uids )",
    ):
        check_world(make(_balanced(First)), ticks=2)


def _balanced(kind):
    class Kind(kind):
        def update(self, table, world):
            super().update(table, world)
            table[Metabolism].taken[table.rows()[:1]] += 1

    return Kind


def test_arrange_act_shuffle_and_difference_do_what_they_say():
    world = _world(Good)(1)
    with pytest.raises(KeyError, match=r"unknown field .*enrgy.*did you mean .*energy"):
        arrange(world, "hare", enrgy=1)
    with pytest.raises(ValueError, match="broadcast"):
        arrange(world, "hare", x=[1, 2])
    with pytest.raises(KeyError, match=r"unknown system .*Bare.*known: ResetFlows, Good"):
        act(world, Bare)
    before = state(world)
    assert difference(before, state(shuffle(world, 3))) == ""
    arrange(world, "hare", energy=np.arange(9))
    assert [world.get(u, Metabolism).energy for u in (1, 5, 9)] == [0, 4, 8]
    assert "hare: Metabolism.energy of uid 1 is" in difference(before, state(world))
    world.kill(4)
    world.flush()
    assert difference(before, state(world)) == "hare: uids [4] are only in one, [] only in the other"
