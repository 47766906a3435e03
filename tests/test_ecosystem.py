import threading

import numpy as np
import pytest

from ecs_eco import System, World
from ecs_eco.components import Body, Chemistry, Metabolism, Position


@pytest.fixture
def world():
    world = World((10, 10), dt=0.5, seed=4)
    world.add_table("hare", Position, Metabolism)
    world.add_table("fox", Position)
    world.spawn("hare", Position(x=1), Metabolism(energy=2))
    world.spawn("hare", n=2)
    world.spawn("fox", Position(x=5))
    world.flush()
    return world


def _events(world):
    events = []
    world.on_birth.append(
        lambda t, rows, parents, _: events.append(
            ("born", world.tick, t.uid[rows].tolist(), parents.tolist())
        )
    )
    world.on_death.append(
        lambda t, rows: events.append(("died", world.tick, t.uid[rows].tolist(), t.cause[rows].tolist()))
    )
    return events


def test_spawn_gives_the_values_of_components_and_defaults_for_the_others(world):
    hare = world.tables["hare"]
    assert hare.uid[:3].tolist() == [1, 2, 3]
    assert hare[Position].x[:3].tolist() == [1, 0, 0]
    assert hare[Metabolism].energy[:3].tolist() == [2, 1, 1]
    assert world.tables["fox"].uid[0] == 4


def test_births_and_deaths_wait_for_the_end_of_their_phases(world):
    seen = []

    class Act(System):
        phase = "environment"

        def process(self, *_):
            if self.world.tick == 0:
                self.world.kill(2, "drowned", killer=4)
                self.world.spawn("hare", parent=1)

    class Look(System):
        def __init__(self, phase):
            self.phase = phase

        def process(self, *_):
            hare = self.world.tables["hare"]
            seen.append((self.phase, hare.uid[hare.by_uid()].tolist()))

    world.add_system(Act())
    for phase in ("interact", "die", "reproduce", "record"):
        world.add_system(Look(phase))
    events = _events(world)
    world.step()
    assert seen == [("interact", [1, 2, 3]), ("die", [1, 2, 3]), ("reproduce", [1, 3]), ("record", [1, 3, 5])]
    assert events == [("died", 0, [2], [world.cause("drowned")]), ("born", 0, [5], [1])]
    assert world.causes == ["culled", "drowned"]


def test_killing_twice_keeps_the_first_cause(world):
    events = _events(world)
    world.kill(1, "drowned", killer=4)
    world.kill(1, "culled", killer=3)
    table, row = world.locate(1)
    assert (table.cause[row], table.killer[row]) == (world.cause("drowned"), 4)
    world.run(2)
    assert events == [("died", 0, [1], [world.cause("drowned")])]
    with pytest.raises(KeyError, match="no living entity has the uid 1"):
        world.kill(1)


def test_uids_are_never_used_again_though_rows_are(world):
    used = {1, 2, 3, 4}
    for _ in range(20):
        world.kill(max(world.tables["hare"].uid.tolist()))
        world.spawn("hare", n=1)
        world.run(1)
        alive = set(world.tables["hare"].uid[world.tables["hare"].rows()].tolist())
        new = alive - used
        assert len(new) == 1
        assert min(new) > max(used)
        used |= new
    assert world.tables["hare"].high == 3
    assert world.next_uid == 25


def test_births_are_in_the_order_of_requests_table_by_table(world):
    world.spawn("fox", parent=4)
    world.spawn("hare", parent=1)
    world.spawn("hare", parent=3)
    events = _events(world)
    world.flush()
    assert events == [("born", 0, [5], [1]), ("born", 0, [6], [3]), ("born", 0, [7], [4])]


def test_deaths_are_told_in_the_order_of_uids_and_before_the_rows_are_free(world):
    world.kill(3)
    world.kill(1)
    collected = []
    world.on_death.append(
        lambda t, rows: collected.append((t.uid[rows].tolist(), t[Metabolism].energy[rows].tolist()))
    )
    world.flush()
    assert collected == [([1, 3], [2, 1])]


def test_time_is_ticks_of_dt(world):
    calls = []
    assert world.run(4, progress=lambda done, of: calls.append((done, of))) is world
    assert (world.tick, world.time, calls) == (4, 2.0, [(4, 4)])
    world.run(0)
    assert world.tick == 4


def test_each_goes_by_uid_over_all_tables(world):
    world.kill(1)
    world.spawn("hare", Position(x=8))
    world.flush()
    assert [(uid, p.x) for uid, p in world.each(Position)] == [(2, 0), (3, 0), (4, 5), (5, 8)]
    assert [uid for uid, _, _ in world.each(Position, Metabolism)] == [2, 3, 5]
    assert world.get(5, Position).x == 8


def test_surroundings_are_constant_or_a_function_of_place(world):
    x = np.array([1, 2], np.float32)
    world.ambient["light"] = 0.25
    assert world.surroundings("light", x, x, x).tolist() == [0.25, 0.25]
    world.environment["light"] = lambda w, x, y, z: x * w.dt
    assert world.surroundings("light", x, x, x).tolist() == [0.5, 1.0]


def test_split_hands_every_item_to_the_kernel_once(monkeypatch):
    monkeypatch.setattr("ecs_eco.compiled.workers.PARALLEL_FROM", 10)
    for threads, n, parts in ((1, 100, 1), (3, 9, 1), (3, 100, 3)):
        out, calls = np.zeros(n, int), []

        def kernel(first, last, out, calls=calls):
            out[first:last] += 1
            calls.append((first, last, threading.get_ident()))

        world = World(threads=threads)
        world.split(kernel, n, out)
        assert out.tolist() == [1] * n
        assert len(calls) == parts


def test_an_error_in_a_kernel_on_a_thread_arrives(monkeypatch):
    monkeypatch.setattr("ecs_eco.compiled.workers.PARALLEL_FROM", 0)

    def kernel(first, last):
        raise FloatingPointError("here")

    world = World(threads=2)
    with pytest.raises(FloatingPointError, match="here"):
        world.split(kernel, 4)


def test_the_digest_tells_worlds_apart_by_what_decides_their_future_and_not_by_rows(world):
    first = world.digest()
    hare = world.tables["hare"]
    hare.reorder(np.array([2, 0, 1]))
    assert world.digest() == first
    hare[Metabolism].energy[0] += 1e-6
    assert world.digest() != first
    hare[Metabolism].energy[0] -= 1e-6
    world.tick += 1
    assert world.digest() != first


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda w: World((10,)),
            ValueError,
            r"space.size is \[10\]; it must be two or three positive numbers",
        ),
        (lambda w: World((10, float("inf"))), ValueError, "must be two or three positive numbers"),
        (
            lambda w: World((10, 10), edges="round"),
            ValueError,
            "space.edges is 'round'; it must be 'torus' or 'walls'",
        ),
        (lambda w: World(cell=0.0), ValueError, "space.cell is 0.0; it must be a positive length"),
        (lambda w: World(dt=0), ValueError, "dt is 0; expected a finite number of seconds above 0"),
        (lambda w: World(dt=float("nan")), ValueError, "dt is nan"),
        (lambda w: World(threads=0), ValueError, "threads is 0; expected a whole number of at least 1"),
        (lambda w: w.add_table("hare"), ValueError, "table 'hare' already exists; choose another name"),
        (lambda w: w.table("har"), KeyError, "unknown table .*har.*; known: hare, fox; did you mean .*hare"),
        (lambda w: w.spawn("wolf"), KeyError, "unknown table 'wolf'"),
        (lambda w: w.spawn("fox", Metabolism()), KeyError, "table 'fox': unknown component 'Metabolism'"),
        (
            lambda w: w.spawn("fox", n=0),
            ValueError,
            "spawn 'fox': n is 0; expected a whole number of at least 1",
        ),
        (lambda w: w.spawn("fox", x=3), TypeError, "unexpected keyword argument 'x'"),
        (lambda w: w.kill(77), KeyError, "no living entity has the uid 77"),
        (lambda w: w.kill(0), KeyError, "no living entity has the uid 0"),
        (lambda w: w.get(-1, Position), KeyError, "no living entity has the uid -1"),
        (lambda w: w.get(4, Body), KeyError, "table 'fox': unknown component 'Body'"),
        (lambda w: w.run(-1), ValueError, "ticks is -1; expected a whole number of at least 0"),
        (lambda w: w.series(), RuntimeError, "this world has no recorder; build it with World.from_config"),
    ],
)
def test_misuse_says_what_is_wrong_and_what_is_allowed(world, call, error, message):
    with pytest.raises(error, match=message):
        call(world)


def test_a_value_of_another_shape_is_refused_when_spawning():
    world = World()
    world.add_table("sea", Chemistry, dims={"substances": 2})
    with pytest.raises(
        ValueError,
        match=r"newborns of 'sea': Chemistry.molarity has shape \(3, 3\); "
        r"expected \(3, 2\)",
    ):
        world.spawn("sea", Chemistry(molarity=[1, 2, 3]), n=3)
    world.spawn("sea", Chemistry(molarity=[1, 2]), n=2)
    world.flush()
    assert world.tables["sea"][Chemistry].molarity[:2].tolist() == [[1, 2], [1, 2]]


def test_a_world_knows_at_most_255_causes():
    world = World()
    codes = [world.cause(f"cause {i}") for i in range(254)]
    assert codes == list(range(2, 256))
    assert world.cause("cause 7") == 9
    with pytest.raises(ValueError, match="cause 'one more': a world has at most 255 causes of death"):
        world.cause("one more")


def test_another_thread_may_not_touch_a_world(world):
    errors = []

    def other():
        try:
            world.run(1)
        except RuntimeError as error:
            errors.append(str(error))

    thread = threading.Thread(target=other)
    thread.start()
    thread.join()
    assert errors == ["only the thread that created a world may use it: 'MainThread'"]
