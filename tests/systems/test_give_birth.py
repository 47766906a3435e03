import numpy as np
import pytest

from ecs_eco.components import Biology, Genome, Gestation, LifeHistory, Metabolism, Position
from ecs_eco.engine import random
from ecs_eco.life.births import affordable
from ecs_eco.systems import GiveBirth, Mate
from ecs_eco.testing import act, arrange, shuffle
from tests.systems.couples import FEMALE, MALE, WAY, WIDE, mate_and_give_birth, mix


def _couples(meadow, n, **changes):
    """A world of n couples far from each other, the female first; and what will be born: [(tick,
    mother, father)], [rows]."""
    way = WAY | changes.pop("reproduction", {})
    world = meadow(
        count=2 * n, sex="random", world=WIDE | changes.pop("world", {}), reproduction=way, **changes
    )
    x = 5 + np.repeat(20.0 * np.arange(n), 2) + np.tile([0.0, 1.0], n)
    deer = arrange(
        world, "deer", x=x % 400, y=10.0 + 20 * np.floor(x / 400), sex=np.tile([FEMALE, MALE], n), energy=0.75
    )
    first, born, rows = int(deer.uid[deer.by_uid()[0]]), [], []

    def note(table, new, parents, second):
        born.extend(
            (world.tick, int(m) - first, int(f) - first) for m, f in zip(parents, second, strict=True)
        )
        rows.extend(new.tolist())

    world.on_birth.append(note)
    return world, born, rows


def _of(world, component, field, who):
    deer = world.tables["deer"]
    return deer.field(component, field)[deer.by_uid()[who]].tolist()


@pytest.mark.parametrize(
    ("gestation", "dt", "ticks"),
    [(0.0, 1.0, 0), (1.0, 1.0, 1), (3.0, 1.0, 3), (2.5, 1.0, 3), (1.0, 0.1, 10), (0.3, 0.1, 3)],
)
def test_gestation_lasts_its_time(meadow, gestation, dt, ticks):
    way = {"gestation": gestation, "rest": 1e3, "father_rest": 1e3}
    world, born, _ = _couples(meadow, 1, world={"dt": dt}, reproduction=way)
    world.tick = 5
    world.run(ticks)
    assert born == []
    assert _of(world, Gestation, "carrying", [0, 1]) == ([1, 0] if ticks else [0, 0])
    world.run(1)
    assert born == [(5 + ticks, 0, 1)]
    assert _of(world, Gestation, "carrying", [0, 1, 2]) == [0, 0, 0]
    world.run(12)
    assert len(born) == 1


def test_the_parents_pay_for_the_litter_to_the_last_digit(meadow):
    world, born, rows = _couples(
        meadow, 1, reproduction={"litter": 3, "energy_given": 0.125, "father_share": 0.25}
    )
    mate_and_give_birth(world)
    assert born == [(0, 0, 1)] * 3
    assert _of(world, Metabolism, "energy", range(5)) == [
        0.75 - 3 * 0.09375,
        0.75 - 3 * 0.03125,
        0.125,
        0.125,
        0.125,
    ]
    assert _of(world, Metabolism, "given", range(5)) == [3 * 0.09375, 3 * 0.03125, 0, 0, 0]
    assert _of(world, Gestation, "energy", range(5)) == [0] * 5
    assert _of(world, Biology, "age", [2, 3, 4]) == [0] * 3
    assert len(set(_of(world, Position, "heading", [2, 3, 4]))) == 3  # siblings share no draw
    assert len(set(_of(world, Position, "x", [2, 3, 4]))) == 3
    assert len(rows) == 3


def test_no_more_are_born_than_the_mother_can_pay_for_and_live(meadow):
    world, born, _ = _couples(
        meadow, 4, reproduction={"litter": 3, "gestation": 1.0, "father_share": 0.5, "rest": 9.0}
    )
    act(world, Mate)
    world.tick = 1
    # she pays 0.125 for each
    arrange(world, "deer", energy=[0.25, 0.375, 0.251, 0.375, 0.376, 0.375, 0.125, 0.375], given=0)
    mate_and_give_birth(world)
    assert [m for _, m, _ in born] == [0, 2, 2, 4, 4, 4]
    # with what the father gave for the unborn
    energy = [0.25 - 0.125 + 0.25, 0.251 - 0.25 + 0.125, 0.376 - 0.375, 0.125 + 0.375]
    assert _of(world, Metabolism, "energy", [0, 2, 4, 6]) == pytest.approx(energy, abs=1e-7)
    assert _of(world, Metabolism, "given", [0, 2, 4, 6]) == pytest.approx(
        [0.125 - 0.25, 0.25 - 0.125, 0.375, -0.375], abs=1e-7
    )
    assert _of(world, Gestation, "energy", [0, 2, 4, 6]) == [0] * 4
    assert _of(world, Gestation, "carrying", [0, 2, 4, 6]) == [0] * 4
    assert _of(world, Gestation, "rest", [0, 2, 4, 6]) == [10] * 4


def test_what_the_father_gave_for_the_unborn_fills_the_mother_up_at_most(meadow):
    world, born, _ = _couples(meadow, 2, max_count=4, reproduction={"father_share": 1.0})
    arrange(world, "deer", energy=[0.875, 0.75, 0.5, 0.75])
    mate_and_give_birth(world)
    assert born == []
    assert _of(world, Metabolism, "energy", range(4)) == [1.0, 0.5, 0.75, 0.5]
    assert _of(world, Metabolism, "given", range(4)) == [-0.125, 0.25, -0.25, 0.25]


def test_the_newborn_of_all_litters_share_the_room_below_max_count(meadow):
    numbers, siblings = np.zeros(3, int), 0
    for tick in range(60):
        world, born, _ = _couples(meadow, 3, max_count=9, reproduction={"litter": 2, "energy_given": 0.125})
        world.tick = tick
        mate_and_give_birth(shuffle(world, tick))
        each = [sum(m == mother for _, m, _ in born) for mother in (0, 2, 4)]
        assert sum(each) == 3
        assert _of(world, Metabolism, "energy", [0, 2, 4]) == [0.75 - 0.125 * n for n in each]
        numbers += each
        siblings += max(each) == 2
        assert world.tables["deer"].species.refused == 3
    assert np.abs(numbers - 60).max() < 20  # four standard deviations
    assert abs(siblings - 36) < 16  # of six newborn, three: in 3/5 of all ticks two are siblings


def test_who_finds_no_place_is_not_born_and_costs_nothing(meadow):
    for spacing, most in ((0.0, 40), (2.0, 30)):
        world, born, _ = _couples(
            meadow,
            20,
            reproduction={"litter": 2, "energy_given": 0.125, "dispersal": 3.0, "spacing": spacing},
        )
        mate_and_give_birth(world)
        assert 0 < len(born) <= most
        paid = {
            2 * i: round((0.75 - e) / 0.125)
            for i, e in enumerate(_of(world, Metabolism, "energy", range(0, 40, 2)))
            if e < 0.75
        }
        mothers = [m for _, m, _ in born]
        assert paid == {m: mothers.count(m) for m in mothers}
        x, y = (np.array(_of(world, Position, axis, range(40 + len(born)))) for axis in "xy")
        for i in range(40, 40 + len(born)):
            apart = np.hypot(x - x[i], y - y[i])
            assert np.delete(apart, i).min() >= spacing - 1e-4
            assert apart[mothers[i - 40]] <= 3 + 1e-4
            assert apart[:40].min() >= 1 - 1e-4  # no body in another's


def test_the_newborn_may_land_anywhere(meadow):
    world, _, _ = _couples(
        meadow, 200, reproduction={"place": "anywhere", "litter": 2, "energy_given": 0.125}
    )
    mate_and_give_birth(world)
    x, y = (_of(world, Position, axis, range(400, 800)) for axis in "xy")
    assert np.histogram2d(x, y, 3, [(0, 400), (0, 400)])[0].min() > 20


def test_sexes_of_siblings_are_drawn_one_by_one(meadow):
    world, _, _ = _couples(meadow, 200, reproduction={"litter": 2, "energy_given": 0.125, "dispersal": 5.0})
    mate_and_give_birth(world)
    sex = np.array(_of(world, Biology, "sex", range(400, 800))).reshape(200, 2)
    assert abs((sex == FEMALE).mean() - 0.5) < 0.1
    assert abs((sex[:, 0] == sex[:, 1]).mean() - 0.5) < 0.15


def test_a_brood_dies_with_its_mother(meadow):
    world, born, _ = _couples(meadow, 2, reproduction={"gestation": 3.0, "father_rest": 99.0})
    world.run(1)
    deer = world.tables["deer"]
    mother = deer.by_uid()[0]
    assert deer[Gestation].carrying[mother]
    world.kill(int(deer.uid[mother]))
    world.run(6)
    assert [b[1:] for b in born] == [(2, 3)]
    world.spawn("deer")
    world.flush()
    assert not deer[Gestation].carrying[mother]  # and who takes its row is not pregnant
    assert deer.alive[mother]


class FakeHeredity:
    """Writes who the parents were into the loci of the newborn."""

    targets = {}  # its genes code for no size

    def __init__(self):
        self.calls = []

    def offspring(self, world, table, first, second, who, **more):
        self.calls.append((first.tolist(), None if second is None else second.tolist(), who.tolist(), more))
        return {
            (Genome, "loci"): np.full((len(who), 3), 7, np.uint8),
            (Metabolism, "energy"): np.full(len(who), 0.5, np.float32),
        }


def _with_genomes(table):
    table.dims["loci"] = 3
    for component in (Genome, Gestation):
        table.columns.pop(component, None)
        table.defaults.pop(component, None)
        table.add_component(component)
    table[Genome].loci[table.by_uid()] = np.arange(12).reshape(4, 3)
    table.species.heredity = FakeHeredity()
    return table.species.heredity


def test_a_dead_father_passes_on_his_genome(meadow):
    world, born, rows = _couples(
        meadow, 2, reproduction={"gestation": 2.0, "litter": 2, "energy_given": 0.125, "father_share": 0.5}
    )
    deer = world.tables["deer"]
    heredity = _with_genomes(deer)
    old = deer.by_uid()
    mothers, fathers = old[[0, 2]].tolist(), old[[1, 3]].tolist()
    world.run(1)
    world.kill(int(deer.uid[fathers[0]]))
    world.run(2)
    assert born == [(2, 0, 1), (2, 0, 1), (2, 2, 3), (2, 2, 3)]
    first, second, who, more = heredity.calls[0]
    assert first == [mothers[0], mothers[0], mothers[1], mothers[1]]
    assert second == [-1, -1, fathers[1], fathers[1]]
    assert len(set(who)) == 4
    assert who[::2] == deer.uid[mothers].tolist()
    assert more.keys() == {"sperm"}
    assert more["sperm"].tolist() == [[3, 4, 5], [3, 4, 5], [9, 10, 11], [9, 10, 11]]
    assert deer[Genome].loci[rows].tolist() == [[7, 7, 7]] * 4  # what heredity says of a newborn holds
    assert deer[Metabolism].energy[rows].tolist() == [0.5] * 4
    assert deer[Gestation].sperm[mothers].tolist() == [[0] * 3] * 2


def test_the_organisms_own_life_history_replaces_that_of_the_species(meadow):
    world, born, _ = _couples(meadow, 2, reproduction={"father_share": 0.5})
    world.tables["deer"].add_component(LifeHistory, litter=1, energy_min=0.5)
    arrange(world, "deer", energy_given=[0.125, 9, 0.0625, 9], litter=[2, 9, 1, 9])
    mate_and_give_birth(world)
    assert [m for _, m, _ in born] == [0, 0, 2]
    assert _of(world, Metabolism, "energy", range(7)) == [
        0.625,
        0.625,
        0.71875,
        0.71875,
        0.125,
        0.125,
        0.0625,
    ]


def test_a_mother_rests_after_birth_and_a_father_after_mating(meadow):
    world, born, _ = _couples(
        meadow, 1, reproduction={"gestation": 2.0, "rest": 3.0, "energy_given": 0.0, "energy_min": 0.0}
    )
    arrange(world, "deer", energy=1.0)
    for _ in range(13):
        arrange_couple(world)
        world.run(1)
    assert [tick for tick, *_ in born] == [2, 7, 12]  # at 0, 5 and 10 they mate
    world, born, _ = _couples(
        meadow, 1, reproduction={"father_rest": 4.0, "energy_given": 0.0, "energy_min": 0.0}
    )
    for _ in range(9):
        arrange_couple(world)
        world.run(1)
    assert [tick for tick, *_ in born] == [0, 4, 8]


def arrange_couple(world):
    """Let nobody but the first couple be old enough to matter: newborn are far off,
    and the couple is together."""
    deer = world.tables["deer"]
    rows = deer.by_uid()
    deer[Position].x[rows], deer[Position].y[rows] = 50 + 20 * np.arange(rows.size), 200
    deer[Position].x[rows[:2]] = 0, 1
    deer[Metabolism].energy[rows] = 1
    deer.version += 1


def test_nobody_is_born_while_numbers_are_held_constant(meadow):
    world, born, _ = _couples(meadow, 1)
    act(world, Mate)
    world.reproduction = False
    act(world, GiveBirth)
    world.flush()
    assert born == []


@pytest.mark.parametrize("energy", [0.0, 0.2, 0.25, 0.3, 0.75, 3.0])
@pytest.mark.parametrize("given", [0.0, 0.1, 0.25])
def test_what_a_parent_can_afford(energy, given):
    energy, given = np.float32(energy), np.float32(given)
    assert affordable(energy, given, 5) == max(
        [k for k in range(6) if k * given == 0 or energy - np.float32(k) * given > 0]
    )


@pytest.mark.parametrize("seed", [1, 2])
def test_kernels_agree_with_a_plain_loop(meadow, seed):
    world, born, _ = _couples(
        meadow, 60, max_count=210, reproduction={"father_share": 0.5, "rest": 4.0, "dispersal": 6.0}
    )
    world.tick, rng = 20, np.random.Generator(np.random.Philox(seed))
    carrying, stored, energy = rng.integers(0, 5, 120), rng.random(120) / 2, rng.random(120)
    arrange(world, "deer", carrying=carrying, energy=energy, due=rng.integers(18, 23, 120), sex=FEMALE)
    arrange(world, "deer", rest=0)
    deer = world.tables["deer"]
    deer[Gestation].energy[deer.by_uid()] = stored
    due = _of(world, Gestation, "due", range(120))
    act(shuffle(world, seed), GiveBirth)
    world.flush()
    wanted = [
        (i, nth)
        for i in range(120)
        if carrying[i] and due[i] <= 20
        for nth in range(carrying[i])
        if energy[i] - (nth + 1) * max(0.25 - stored[i] / carrying[i], 0) > 0
    ]
    first = int(deer.uid[deer.by_uid()[0]])
    identity = [first + i if nth == 0 else mix(mix(first + i) + nth) for i, nth in wanted]
    lots = [random.bits(world.key, np.uint64(one), random.LOT) for one in identity]
    admitted = [wanted[k][0] for k in np.argsort(lots)[:90]]
    n_born = [sum(m == i for _, m, _ in born) for i in range(120)]
    new = _of(world, Metabolism, "energy", range(120)), _of(world, Metabolism, "given", range(120))
    for i in range(120):
        if not carrying[i] or due[i] > 20:
            expected, n = energy[i], 0
        else:
            part, n = max(0.25 - stored[i] / carrying[i], 0), admitted.count(i)
            after = energy[i] - n * part
            expected = max(after, min(after + stored[i] * (carrying[i] - n) / carrying[i], 1.0))
        assert n_born[i] == n
        assert new[0][i] == pytest.approx(expected, abs=1e-6)
        assert new[1][i] == pytest.approx(energy[i] - expected, abs=1e-6)
    assert (len(wanted) > 90, sum(n_born)) == (True, 90)
    assert _of(world, Gestation, "rest", range(120)) == [
        24 if carrying[i] and due[i] <= 20 else 0 for i in range(120)
    ]
