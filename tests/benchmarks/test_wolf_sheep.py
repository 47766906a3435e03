"""The rules of benchmarks/wolf_sheep_model.py, counted by hand on a torus of 5 x 5 cells, row by row;
without Mesa."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from tools.sizes import code_lines

FOLDER = Path(__file__).parents[2] / "benchmarks"
NEVER, HERE, LEFT, RIGHT, ABOVE, BELOW = 10**6, 12, 11, 13, 7, 17


@pytest.fixture(scope="module", autouse=True)
def _benchmarks_can_be_imported():
    sys.path.insert(0, str(FOLDER))
    yield
    sys.path.remove(str(FOLDER))


@pytest.fixture
def model():
    import wolf_sheep_model

    return wolf_sheep_model


@pytest.fixture
def place(model):
    """A function of (cell, energy) of sheep and of wolves that returns a world without births,
    its tables and its counts."""

    def build(sheep=(), wolves=(), ripe=(), seed=1, **parameters):
        rules = model.DEFAULT | {"sheep_reproduce": 0.0, "wolf_reproduce": 0.0} | parameters
        world, collect = model.build(5, seed, rules)
        for name, animals in (("sheep", sheep), ("wolf", wolves)):
            world.tables[name].births.clear()
            cell, energy = np.array(animals, float).reshape(-1, 2).T
            values = {(model.Animal, "cell"): cell, (model.Animal, "energy"): energy}
            world.tables[name].request(np.zeros(len(cell), np.uint64), values)
        world.flush()
        when = world.tables["grass"][model.Grass].ripe
        when[:] = NEVER
        when[list(ripe)] = 0
        return world, collect.series

    return build


def animals(world, model, name):
    """Return the (cell, energy) of all living, sorted."""
    table = world.tables[name]
    return sorted(
        (int(table[model.Animal].cell[r]), float(table[model.Animal].energy[r])) for r in table.rows()
    )


def ripe(world, model):
    return world.tables["grass"][model.Grass].ripe


def test_a_sheep_goes_where_grass_is_pays_one_and_gains_four(place, model):
    world, series = place(sheep=[(HERE, 2.0)], ripe=[RIGHT])
    world.run(1)
    assert animals(world, model, "sheep") == [(RIGHT, 5.0)]
    assert series[-1] == (1, 0, 0)


def test_grass_eaten_in_tick_1_is_counted_again_from_tick_32_on(place, model):
    world, series = place(sheep=[(HERE, 2.0)], ripe=[RIGHT])
    world.run(1)
    world.kill(int(world.tables["sheep"].uid[0]))
    world.run(32)
    assert [grass for _, _, grass in series[1:]] == [0] * 31 + [1, 1]


def test_grass_eaten_in_tick_1_feeds_again_in_tick_5_when_it_regrows_in_3(place, model):
    world, _ = place(sheep=[(HERE, 10.0)], ripe=[RIGHT], regrowth=3)
    energies = []
    for _ in range(5):
        sheep = world.tables["sheep"][model.Animal]
        sheep.cell[0] = HERE
        world.step()
        energies.append(float(sheep.energy[0]))
    assert energies == [13.0, 12.0, 11.0, 10.0, 13.0]


def test_grass_with_a_countdown_of_1_is_not_ripe_in_the_first_tick_but_in_the_second(model):
    for seed in range(5):
        world, collect = model.build(20, seed, model.DEFAULT)
        world.flush()
        when = ripe(world, model)
        assert 1 not in when
        assert when.max() == 30
        assert collect.series[0] == (100, 50, (when == 0).sum())
        assert 0.4 < (when == 0).mean() < 0.65  # a half, and 1/30 of the others
        sheep = world.tables["sheep"]
        assert (
            0 <= sheep[model.Animal].energy[:100].min() < 1 < 7 < sheep[model.Animal].energy[:100].max() < 8
        )


@pytest.mark.parametrize("kind", ["sheep", "wolves"])
def test_an_animal_starves_below_zero_not_at_zero(place, model, kind):
    world, series = place(**{kind: [(HERE, 0.5), (HERE, 1.0)]})
    world.run(1)
    assert series[-1] == ((1, 0, 0) if kind == "sheep" else (0, 1, 0))
    assert animals(world, model, kind.replace("wolves", "wolf"))[0][1] == 0.0


@pytest.mark.parametrize(
    ("kind", "table", "p"), [("sheep", "sheep", "sheep_reproduce"), ("wolves", "wolf", "wolf_reproduce")]
)
def test_a_parent_shares_its_energy_with_a_newborn_in_its_cell_that_acts_from_the_next_tick_on(
    place, model, kind, table, p
):
    world, _ = place(**{kind: [(HERE, 5.0)], p: 1.0})
    world.run(1)
    (cell, energy), newborn = animals(world, model, table)
    assert (cell, energy) == newborn
    assert energy == 2.0
    assert cell in (LEFT, RIGHT, ABOVE, BELOW)
    assert world.tables[table].n == 2
    world.run(1)
    assert [e for _, e in animals(world, model, table)] == [0.5] * 4


def test_a_wolf_goes_to_a_sheep_eats_it_and_gains_twenty(place, model):
    world, series = place(sheep=[(HERE, 5.0), (0, 5.0)], wolves=[(14, 3.0)], ripe=[RIGHT])
    world.run(1)  # the first sheep goes to the grass beside the wolf, the second is out of its reach
    assert series[-1] == (1, 1, 0)
    assert animals(world, model, "wolf") == [(RIGHT, 22.0)]
    assert [energy for _, energy in animals(world, model, "sheep")] == [4.0]


def test_a_lamb_may_be_eaten_in_the_tick_of_its_birth_and_so_may_its_parent(place, model):
    left = set()
    for seed in range(30):
        world, series = place(
            sheep=[(HERE, 3.0)], wolves=[(14, 3.0)], ripe=[RIGHT], seed=seed, sheep_reproduce=1.0
        )
        parent = int(world.tables["sheep"].uid[0])
        world.run(1)
        assert series[-1] == (1, 1, 0)
        assert animals(world, model, "sheep") == [(RIGHT, 3.0)]
        assert animals(world, model, "wolf") == [(RIGHT, 22.0)]
        left.add(int(world.tables["sheep"].uid[world.tables["sheep"].rows()[0]]) == parent)
    assert left == {True, False}


def test_a_sheep_prefers_a_bare_cell_to_grass_under_a_wolf(place, model):
    world, _ = place(sheep=[(HERE, 5.0)], wolves=[(RIGHT, 3.0), (ABOVE, 3.0), (BELOW, 3.0)], ripe=[RIGHT])
    world.run(1)
    assert animals(world, model, "sheep") == [(LEFT, 4.0)]


def test_a_sheep_with_wolves_all_around_stays_eats_what_is_there_and_is_eaten_once(place, model):
    world, series = place(
        sheep=[(HERE, 5.0)], wolves=[(c, 9.0) for c in (LEFT, RIGHT, ABOVE, BELOW)], ripe=[HERE]
    )
    world.run(1)
    assert series[-1] == (0, 4, 0)
    assert ripe(world, model)[HERE] == 1 + 30 + 1
    assert sorted(e for _, e in animals(world, model, "wolf")) == [8.0, 8.0, 8.0, 28.0]


def test_animals_leave_across_the_edges_in_all_four_directions_alike(place, model):
    world, _ = place(sheep=[(0, 5.0)] * 400)
    world.run(1)
    cells, counts = np.unique([cell for cell, _ in animals(world, model, "sheep")], return_counts=True)
    assert cells.tolist() == [1, 4, 5, 20]
    assert stats.chisquare(counts).pvalue > 1e-3


def test_all_orders_are_equally_likely(model):
    alive = np.array([True, False, True, True])
    orders = [tuple(model.shuffled(alive, np.uint64(key), 7).tolist()) for key in range(1200)]
    orders_, counts = np.unique(orders, axis=0, return_counts=True)
    assert len(orders_) == 6
    assert stats.chisquare(counts).pvalue > 1e-3


@pytest.mark.parametrize(("chance", "taken", "left"), [(0.0, 2, [0, 1]), (0.5, 0, [2, 1]), (0.99, 1, [2, 0])])
def test_one_is_taken_out_of_a_chain(model, chance, taken, left):
    after = np.array([1, -1, 0, 2], np.int32)  # 3 is the head: 2, 0, 1
    assert model.take(after, 3, chance) == taken
    chain, row = [], after[3]
    while row >= 0:
        chain.append(int(row))
        row = after[row]
    assert chain == left


def test_counts_agree_with_the_tables_and_a_seed_repeats(model):
    rules = model.DEFAULT | {"sheep_reproduce": 0.2, "wolf_gain": 5.0, "regrowth": 10}
    twice = []
    for _ in range(2):
        world, collect = model.build(20, 3, rules)
        world.run(60)
        assert len(collect.series) == 61
        assert collect.series[-1][:2] == (world.tables["sheep"].n, world.tables["wolf"].n)
        assert collect.series[-1][2] == (ripe(world, model) <= 60).sum()
        twice.append((collect.series, world.digest()))
    assert twice[0] == twice[1]
    assert twice[0][0][-1][0] > 0


def test_the_model_has_at_most_150_lines_of_code():
    assert len(code_lines((FOLDER / "wolf_sheep_model.py").read_text(encoding="utf-8"))) <= 150


def test_the_comparison_passes_equal_populations_and_catches_shifted_ones():
    import wolf_sheep

    rng = np.random.default_rng(1)
    equal = [wolf_sheep.compare(*rng.poisson(500, (2, 20, 11, 3)), 10) for _ in range(60)]
    assert equal[0]["tests"] == 12
    assert sum(c["smallest p (Holm)"] < 0.05 for c in equal) <= 8  # 3 expected; 9 or more in 0.3 %
    assert all(0.3 < c["means within, SD"] < 2 for c in equal)
    a, b = rng.poisson(500, (2, 20, 11, 3))
    other = wolf_sheep.compare(a, b + 40, 10)
    assert other["smallest p (Holm)"] < 0.05
    assert other["means within, SD"] > 1.5
    assert other["means within, %"] == pytest.approx(8, abs=5)


def test_without_mesa_the_benchmark_says_what_to_install(monkeypatch):
    import wolf_sheep

    monkeypatch.setitem(sys.modules, "mesa", None)
    monkeypatch.delitem(sys.modules, "mesa.examples.advanced.wolf_sheep.model", raising=False)
    with pytest.raises(SystemExit, match=r"\.\[bench\]"):
        wolf_sheep.mesa(20, 1, 1, wolf_sheep.COEXISTING)
