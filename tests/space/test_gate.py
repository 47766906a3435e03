"""What comes into a world from outside is brought within its limits, or refused with the organism,
the field, the value and the limits."""

import numpy as np
import pytest

from ecs_eco import System, World
from ecs_eco.components import Biology, Body, Metabolism, Position
from ecs_eco.engine.schema import component, f32, f64, i16
from ecs_eco.space.gate import limits_of
from ecs_eco.systems import Move

F = np.float32


def _world(edges="torus", size=(100.0, 60.0)):
    world = World(size, edges=edges)
    world.add_table("moss", Position, Body, Metabolism)
    return world


def _born(world):
    world.flush()
    table = world.tables["moss"]
    return table, table.rows()


@pytest.mark.parametrize(
    ("x", "comes_to"), [(-500.0, 0.0), (-1.0, 99.0), (100.0, 0.0), (250.0, 50.0), (-0.0, 0.0), (1e-45, 1e-45)]
)
def test_a_place_beyond_the_edge_of_a_torus_is_brought_back_around_it(x, comes_to):
    world = _world()
    world.spawn("moss", Position(x=x, y=1.0))
    table, rows = _born(world)
    assert table[Position].x[rows] == F(comes_to)


@pytest.mark.parametrize(
    ("heading", "comes_to"),
    [
        (-np.pi / 2, 1.5 * np.pi),
        (7.0, 7.0 - 2 * np.pi),
        (-601 * np.pi, np.pi),
        (float(F(2 * np.pi)), 2 * np.pi),
    ],
)
def test_a_heading_beyond_the_circle_is_brought_back_around_it(heading, comes_to):
    world = _world()
    world.spawn("moss", Position(heading=heading))
    table, rows = _born(world)
    assert table[Position].heading[rows] == pytest.approx(comes_to, abs=1e-3)
    table[Position].heading[rows] = heading
    world.run(1)
    assert table[Position].heading[rows] == pytest.approx(comes_to, abs=1e-3)


@pytest.mark.parametrize("heading", [np.nan, np.inf, 1e30, -1e4])
def test_a_heading_that_float32_cannot_tell_is_refused(heading):
    world = _world()
    allowed = r"expected: 0 to 6.28319 rad; values up to ±6283.19 rad are wrapped around the circle"
    with pytest.raises(ValueError, match=rf"spawn 'moss': Position\.heading is .*; {allowed}"):
        world.spawn("moss", Position(heading=heading))
    world.spawn("moss")
    world.run(1)
    world.tables["moss"][Position].heading[0] = heading
    with pytest.raises(ValueError, match=rf"moss, uid 1: Position\.heading is .*; {allowed}"):
        world.run(1)


@pytest.mark.parametrize("x", [np.nan, np.inf, -np.inf, 1e30, -1e9])
@pytest.mark.parametrize("edges", ["torus", "walls"])
def test_a_place_that_float32_cannot_tell_is_refused(x, edges):
    world = _world(edges)
    with pytest.raises(ValueError, match=r"spawn 'moss': Position\.x is .*; expected: 0 to 100 m"):
        world.spawn("moss", Position(x=x, y=1.0))
    assert not world.tables["moss"].births


@pytest.mark.parametrize("y", [-1.0, 60.5, 1e9])
def test_a_place_outside_of_walls_is_refused_and_one_on_a_wall_is_just_before_it(y):
    world = _world("walls")
    with pytest.raises(ValueError, match=r"Position\.y is .*; expected: 0 to 60 m$"):
        world.spawn("moss", Position(x=1.0, y=y))
    world.spawn("moss", Position(x=1.0, y=60.0))
    table, rows = _born(world)
    assert table[Position].y[rows] == np.nextafter(F(60), F(0))


def test_a_volume_has_a_floor_and_a_ceiling_whatever_its_edges():
    world = World((10.0, 10.0, 5.0))
    world.add_table("moss", Position)
    with pytest.raises(ValueError, match=r"Position\.z is -1\.0; expected: 0 to 5 m$"):
        world.spawn("moss", Position(x=11.0, z=-1.0))


@pytest.mark.parametrize("ways", ["column", "handle", "esper"])
def test_places_written_between_ticks_are_brought_back_or_refused(ways):
    world = _world()
    world.spawn("moss", Position(x=5.0, y=5.0), n=3)
    world.run(1)
    for value in (-500.0, np.nan):
        if ways == "column":
            world.tables["moss"][Position].x[1] = value
        elif ways == "handle":
            world.get(2, Position).x = value
        else:
            import esper

            with world:
                esper.component_for_entity(world.entity(2), Position).x = value
        if np.isnan(value):
            with pytest.raises(ValueError, match=r"moss, uid 2: Position\.x is nan; expected"):
                world.run(1)
            assert world.tick == 2
        else:
            world.run(1)
            assert world.get(2, Position).x == 0.0


@pytest.mark.parametrize(
    ("kind", "field", "value", "allowed"),
    [
        (Metabolism, "energy", np.nan, "finite numbers"),
        (Body, "radius", -1.0, "0 to 1e.30"),
        (Body, "mass", np.inf, "0 to 1e.30"),
    ],
)
def test_fields_have_limits_and_all_numbers_are_finite(kind, field, value, allowed):
    world = _world()
    message = rf"{kind.__name__}\.{field} is .*; expected: {allowed}"
    with pytest.raises(ValueError, match="spawn 'moss': " + message):
        world.spawn("moss", kind(**{field: value}))
    world.spawn("moss", n=4)
    world.run(1)
    world.tables["moss"].field(kind, field)[2:4] = value
    with pytest.raises(
        ValueError, match=rf"moss, uid 3: {kind.__name__}\.{field} is \S+ \(1 more\); expected: {allowed}"
    ):
        world.run(1)
    world.tables["moss"].field(kind, field)[2:4] = 1.0
    assert world.run(1).tick == 2


def test_free_rows_may_hold_anything():
    world = _world()
    world.spawn("moss", n=2)
    world.run(1)
    world.tables["moss"][Metabolism].energy[5:] = np.nan
    assert world.run(1).tick == 2


def test_a_sex_that_there_is_not_and_a_cause_that_nobody_knows_are_refused():
    world = _world()
    world.tables["moss"].add_component(Biology)
    with pytest.raises(ValueError, match=r"Biology\.sex is 3; expected: 0 to 2"):
        world.spawn("moss", Biology(sex=3))
    world.spawn("moss")
    world.run(1)
    world.tables["moss"].cause[0] = 200
    with pytest.raises(ValueError, match="moss, uid 1: cause of death 200; expected: 0 to 1"):
        world.run(1)


def test_a_component_of_ones_own_has_the_limits_that_it_declares():
    @component
    class Wool:
        length: f32["hairs"].within(0, 2) = 1.0  # noqa: F821
        shorn: f32 = np.inf  # its own default says that it needs no finite number

    world = World((9.0, 9.0))
    world.add_table("sheep", Wool, dims={"hairs": 3})
    world.spawn("sheep", Wool(length=[0, 2, 1]))
    with pytest.raises(ValueError, match=r"Wool\.length is 2\.5; expected: 0 to 2"):
        world.spawn("sheep", Wool(length=[0, 2.5, 1]))
    world.run(1)
    world.tables["sheep"][Wool].length[0, 1] = -1
    with pytest.raises(ValueError, match=r"sheep, uid 1: Wool\.length is -1\.0"):
        world.run(1)


def test_a_column_is_not_replaced_by_one_of_another_type_or_shape():
    world = _world()
    p = world.tables["moss"][Position]
    for column in (np.zeros(3, F), np.zeros(64), np.zeros((64, 2), F), 5.0):
        with pytest.raises(ValueError, match=r"column x is float32\[64\] and cannot become"):
            p.x = column
    p.x += 1
    p.x = p.x * 2
    assert p.x[0] == 2.0


def test_a_column_is_not_replaced_by_one_with_gaps():
    world = _world()
    with pytest.raises(
        ValueError,
        match=r"column x cannot become an array with gaps between its rows; "
        r"write into it: x\[rows\] = …",
    ):
        world.tables["moss"][Position].x = np.zeros(128, F)[::2]


def test_dead_rows_that_hold_anything_hide_nothing():
    world = _world()
    world.spawn("moss", n=5)
    world.run(1)
    table = world.tables["moss"]
    world.kill(2)
    world.flush()
    table[Position].x[1] = table[Metabolism].energy[1] = np.nan
    assert world.run(1).tick == 2
    table[Position].x[3], table[Metabolism].energy[2] = 105.0, np.inf
    with pytest.raises(ValueError, match=r"moss, uid 3: Metabolism\.energy is inf"):
        world.run(1)
    assert table[Position].x[3] == 5.0
    assert np.isnan(table[Position].x[1])


def test_all_limits_of_a_table_are_looked_at_whatever_the_types_and_sizes():
    @component
    class Rich:
        a: f32[3] = 0.0
        b: f64 = 0.0
        c: i16.within(-3, 3) = 0
        d: f32 = 0.0
        e: f32[2, 2].within(0, 9) = 1.0

    world = World((9.0, 9.0))
    world.add_table("moss", Position, Body, Metabolism, Rich)
    world.spawn("moss", n=7)
    world.run(1)
    table, refused = world.tables["moss"], 0
    for limits in limits_of(world, table):
        column = table.field(limits.component, limits.field)
        for row in (0, 6):
            at = (row, *(k - 1 for k in column.shape[1:]))
            before, column[at] = column[at], np.nan if column.dtype.kind == "f" else 4
            with pytest.raises(ValueError, match=rf"moss, uid {row + 1}: {limits.name} is"):
                world.run(1)
            column[at] = before
            refused += 1
    assert refused == 2 * (4 + 2 + 4 + 5)  # digestion is counted in ticks
    assert world.run(1).tick == 2


def test_a_parent_that_is_no_uid_is_refused():
    with pytest.raises(ValueError, match="parent is -1"):
        _world().spawn("moss", parent=-1)


@pytest.mark.parametrize("given", [[1.0, 2.0], np.zeros((2, 2)), "bright"])
def test_surroundings_of_ones_own_give_a_number_for_each_place(given):
    world = _world()
    world.environment["light"] = lambda world, x, y, z: given
    with pytest.raises(ValueError, match=r"environment\['light'\] gives .*; expected: 3 numbers"):
        world.surroundings("light", *np.zeros((3, 3), F))


def test_surroundings_that_are_one_number_are_the_same_everywhere():
    world = _world()
    world.environment["light"] = lambda world, x, y, z: 0.5
    assert world.surroundings("light", *np.zeros((3, 3), F)).tolist() == [0.5] * 3


@pytest.mark.parametrize(
    ("network", "value"),
    [("reflex", np.zeros((1, 1), np.int8)), ("happiness", np.zeros(1, F)), ("happiness", 1.0)],
)
def test_a_network_of_ones_own_answers_for_each_organism_and_action(menagerie, network, value):
    world = World.from_config(menagerie(), policies="random")
    setattr(world.tables["lynx"].species.nerves, network, lambda x: value)
    with pytest.raises(ValueError, match=rf"lynx: the {network} network gives .*; expected: an array"):
        world.run(1)


def test_a_newcomer_placed_by_hand_outside_of_walls_is_refused_when_it_is_asked_for():
    from ecs_eco.systems import Intervene

    world = _world("walls")
    world.add_system(Intervene())
    with pytest.raises(ValueError, match=r"intervene: add: Position\.x is 1000\.0; expected: 0 to 100 m"):
        world.intervene({"kind": "add", "species": "moss", "count": 1, "at_place": [1000.0, 5.0]})


def test_what_a_system_writes_within_a_tick_harms_no_memory(menagerie):
    class Scatter(System):
        phase = "environment"

        def process(self, *_):
            for table in self.world.tables.values():
                p, rows = table[Position], table.rows()
                odd = [np.nan, np.inf, -np.inf, 1e30, -1e30, -500.0, -0.0, 1e-45, 3e38]
                p.x[rows], p.y[rows] = np.resize(odd, rows.size), np.resize(odd[::-1], rows.size)
                p.heading[rows] = np.resize(odd[3:], rows.size)
                table.version += 1

    world = World.from_config(menagerie(), policies="random")
    world.add_system(Scatter())
    with np.errstate(all="ignore"):
        world.run(1)
    assert any(isinstance(s, Move) for s in world.systems)
