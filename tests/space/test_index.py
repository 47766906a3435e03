import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.space import Index, Space


def _slow(space, alive, x, y, z, uid):
    """Rows sorted by (cell, uid), cells x fastest."""
    nx, ny, nz = space.shape

    def cell(row):
        i, j, k = (min(int(v[row] * n), m - 1)
                   for v, n, m in zip((x, y, z), space.inverse, (nx, ny, nz), strict=True))
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


@pytest.mark.parametrize("between", ["nothing", "another death", "a move", "a birth"])
def test_an_index_after_deaths_is_the_one_that_is_made_anew(between):
    rng = np.random.default_rng(3)
    world = World((10, 6), cell=1.5)
    table = world.add_table("ant", Position)
    for x, y in rng.random((80, 2)):
        world.spawn("ant", Position(x=10 * x, y=6 * y))
    world.flush()
    world.index(table)
    for uid in (3, 4, 40, 80):
        world.kill(uid)
    world.flush()
    if between == "another death":
        world.kill(41)
        world.flush()
    elif between == "a move":
        table[Position].x[5] = 0.1
        table.version += 1
    elif between == "a birth":
        world.spawn("ant", Position(x=1, y=1))
        world.flush()
    kept, anew, p = world.index(table), Index(world.space), table[Position]
    anew.build(table.alive, p.x, p.y, p.z, table.uid)
    assert kept.n == anew.n == table.n
    for name in ("rows", "x", "y", "z", "uid", "start"):
        assert getattr(kept, name).tolist() == getattr(anew, name).tolist()


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
