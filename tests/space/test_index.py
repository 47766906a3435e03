import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.space import Index, Space


def _slow(space, alive, x, y, z, uid):
    """Rows sorted by (cell, uid), cells x fastest."""
    nx, ny, nz = space.shape

    def cell(row):
        i, j, k = (
            min(int(v[row] * n), m - 1)
            for v, n, m in zip((x, y, z), space.inverse, (nx, ny, nz), strict=True)
        )
        return (k * ny + j) * nx + i

    rows = sorted((r for r in range(len(x)) if alive[r]), key=lambda r: (cell(r), uid[r]))
    return rows, [cell(r) for r in rows]


@pytest.mark.parametrize("size", [(10.0, 6.0), (10.0, 6.0, 4.0)])
@pytest.mark.parametrize("cell", [0.5, 3.0, 20.0])
def test_entries_are_sorted_by_cell_then_uid(size, cell):
    rng = np.random.default_rng(2)
    space = Space(size, cell=cell)
    n = 200
    x, y, z = ((rng.random(n) * s).astype(np.float32) for s in (*size, 0.0)[:3])
    alive, uid = rng.random(n) < 0.8, (rng.permutation(n) + 1).astype(np.uint64)
    index = Index(space)
    index.build(alive, x, y, z, uid)
    rows, cells = _slow(space, alive, x, y, z, uid)
    assert index.rows.tolist() == rows
    assert index.uid.tolist() == uid[rows].tolist()
    assert index.x.tolist() == x[rows].tolist()
    assert index.start.tolist() == np.searchsorted(cells, range(space.n_cells + 1)).tolist()


def test_an_index_is_made_anew_when_someone_moved_was_born_or_died_and_only_then():
    world = World((10, 10), cell=1.0)
    table = world.add_table("ant", Position)
    assert world.index(table).n == 0
    world.spawn("ant", Position(x=5), n=2)
    world.flush()
    index = world.index(table)
    assert index.x.tolist() == [5, 5]
    built = index.rows
    assert world.index(table).rows is built
    table[Position].x[0] = 9
    table.version += 1
    assert world.index(table).x.tolist() == [5, 9]
    world.kill(2)
    world.flush()
    assert world.index(table).uid.tolist() == [1]


def _same(kept, table, space):
    anew, p = Index(space), table[Position]
    anew.build(table.alive, p.x, p.y, p.z, table.uid)
    assert kept.n == anew.n == table.n
    assert kept.flat == anew.flat
    return all(
        getattr(kept, name).tolist() == getattr(anew, name).tolist()
        for name in ("rows", "x", "y", "z", "uid", "start")
    )


@pytest.mark.parametrize("size", [(10, 6), (10, 6, 4)])
def test_an_index_after_births_and_deaths_is_the_one_that_is_made_anew(size):
    """Whatever happens between two looks at it."""
    rng = np.random.default_rng(3)
    world = World(size, cell=1.5)
    table = world.add_table("ant", Position)

    def bear(n):
        for place in rng.random((n, len(size))):
            world.spawn("ant", Position(**dict(zip("xyz", place * size, strict=False))))
        world.flush()

    def die(n):
        for uid in rng.choice(table.uid[table.alive], min(n, table.n), replace=False):
            world.kill(int(uid))
        world.flush()

    def move(n):
        table[Position].x[table.rows()[:n]] = rng.random(min(n, table.n)) * size[0]
        table.version += 1

    bear(80)
    for _ in range(100):
        for do in rng.choice([bear, die, die, bear, move], rng.integers(1, 4), p=[0.3, 0.3, 0.15, 0.2, 0.05]):
            do(int(rng.integers(1, 8 if table.n > 40 else 30)))
        assert _same(world.index(table), table, world.space)


def test_newborn_that_are_older_than_some_of_the_living_are_sorted_in():
    world = World((10, 6), cell=20.0)
    table = world.add_table("ant", Position)
    for _ in range(9):
        world.spawn("ant", Position(x=1, y=1))
    world.flush()
    world.index(table)
    table.settle(np.array([5000], np.uint64), np.zeros(1, np.int64), {})  # a migrant
    world.spawn("ant", Position(x=1, y=1))
    world.flush()
    assert _same(world.index(table), table, world.space)
    world.spawn("ant", Position(x=1, y=1))
    world.flush()
    assert _same(world.index(table), table, world.space)


def test_order_depends_on_places_and_uids_and_not_on_rows():
    world = World((10, 10), cell=2.0)
    table = world.add_table("ant", Position)
    for x in (1.5, 0.5, 9, 1, 5, 0.2):
        world.spawn("ant", Position(x=x, y=1))
    world.flush()
    before = [world.index(table).uid.tolist(), world.index(table).x.tolist()]
    table.reorder(np.array([5, 3, 0, 1, 4, 2]))
    assert [world.index(table).uid.tolist(), world.index(table).x.tolist()] == before
    assert before[0] == [1, 2, 4, 6, 5, 3]
