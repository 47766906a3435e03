"""Eggs: laying, incubation, hatching and being eaten, by hand-counted numbers; what they carry; refusals."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import (
    Body,
    Chemistry,
    Genome,
    Incubation,
    Metabolism,
    Parentage,
    Physical,
    Policy,
    Position,
)
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record.ledger import LEDGER, imbalance
from ecs_eco.systems import Feed, Hatch, Reproduce
from ecs_eco.testing import act, arrange, check_system
from tests.worlds.herd import HERD, gene_for

F = np.float32
EGG = {
    "count": 0,
    "body": {"radius": 0.1, "mass": 0.06, "opaque": False},
    "metabolism": {"energy": 0.2, "energy_max": 1.0},
    "hatch": {"into": "deer", "incubation": 3.0},
}
LAYS = {
    "kind": "asexual",
    "rate": 100.0,
    "energy_min": 0.4,
    "energy_given": 0.125,
    "litter": 2,
    "dispersal": 3.0,
    "eggs": "egg",
}


def nest(meadow, world=None, egg=None, **deer):
    """Two deer that lay two eggs each in the first tick."""
    species = {"egg": EGG | (egg or {})}
    more = {"species": species, "dt": 1.0} | (world or {})
    return meadow(world=more, **{"reproduction": LAYS | {"rate": 1.0}, "body": {"opaque": False}} | deer)


def lay(world):
    while not world.tables["egg"].n:
        act(world, Reproduce)
        world.flush()
        world.tick += 1
    world.tick = 0
    world.table("deer").species.barren = True
    return world


def energies(world, name):
    table = world.tables[name]
    return table[Metabolism].energy[table.by_uid()].tolist()


@pytest.mark.definition("3 eggs")
def test_a_clutch_is_laid_and_paid_for(meadow):
    world = lay(nest(meadow, count=1))
    egg, deer = world.tables["egg"], world.tables["deer"]
    assert (egg.n, deer.n) == (2, 1)
    assert energies(world, "egg") == [0.125, 0.125]
    assert egg[Parentage].mother[egg.by_uid()].tolist() == deer.uid[deer.by_uid()].tolist() * 2
    assert deer[Metabolism].given[deer.by_uid()] == pytest.approx(0.25)
    assert egg[Body].radius[egg.by_uid()] == pytest.approx(0.1)


@pytest.mark.parametrize(("dt", "ticks"), [(1.0, 3), (0.5, 6), (0.7, 5), (3.0, 1)])
def test_it_hatches_after_its_incubation_where_it_lies(meadow, dt, ticks):
    world = nest(meadow, world={"dt": dt}, count=1, reproduction=LAYS | {"rate": 0.09})
    lay(world)
    egg, deer = world.tables["egg"], world.tables["deer"]
    rows, mother = egg.by_uid(), int(deer.uid[deer.by_uid()[0]])
    place = egg[Position].x[rows].tolist()
    uids = set(egg.uid[rows].tolist())
    born = []
    world.on_birth.append(lambda table, rows, first, second: born.append((table.name, first.tolist())))
    world.run(ticks - 1)
    assert (egg.n, deer.n) == (2, 1)
    world.run(1)
    assert (egg.n, deer.n) == (0, 3)
    assert born == [("deer", [mother, mother])]
    young = deer.by_uid()[1:]
    assert deer[Position].x[young].tolist() == place
    assert not uids & set(deer.uid[young].tolist())
    assert deer[Metabolism].energy[young].tolist() == [0.125, 0.125]


def test_eggs_neither_sense_nor_move_nor_decide(meadow):
    world = lay(nest(meadow))
    egg = world.tables["egg"]
    assert egg.species.nerves is None
    place = egg[Position].x[egg.by_uid()].copy()
    world.run(1)
    assert (egg[Position].x[egg.by_uid()] == place).all()


def test_degrees_above_the_threshold_add_up(meadow):
    """At 310 K in 3 s; at 300 K, 20 of 30 degrees above 280 K, in 4.5 s; at 280 K never."""
    way = {"into": "deer", "incubation": 3.0, "temperature": 310.0, "threshold": 280.0}
    for kelvin, second in (310.0, 3.0), (300.0, 4.5), (280.0, None), (340.0, 1.5):
        world = lay(nest(meadow, world={"ambient": {"temperature": kelvin}}, egg={"hatch": way}))
        egg = world.tables["egg"]
        act(world, Hatch)
        rate = 0.0 if second is None else 3.0 / second
        assert egg[Incubation].developed[egg.by_uid()] == pytest.approx(rate)
    kept = nest(meadow, egg={"hatch": way, "properties": {"temperature": 300.0}})
    egg = lay(kept).tables["egg"]
    assert (egg[Physical].temperature[egg.by_uid()] == 300).all()
    act(kept, Hatch)
    assert egg[Incubation].developed[egg.by_uid()] == pytest.approx(2 / 3)


@pytest.mark.definition("3 eggs")
def test_eaten_eggs_do_not_hatch(meadow):
    fox = {
        "count": 1,
        "body": {"radius": 0.3},
        "metabolism": {"energy": 0.25},
        "diet": [{"eats": "egg", "efficiency": 0.5, "reach": 0.5}],
    }
    world = lay(nest(meadow, world={"species": {"fox": fox, "egg": EGG}}))
    egg = arrange(world, "egg", x=[5.0] + [15.0] * (world.tables["egg"].n - 1), y=5.0, developed=2.9)
    deer, many, causes = world.tables["deer"].n, egg.n, []
    world.on_death.append(lambda table, rows: causes.extend(world.causes[c - 1] for c in table.cause[rows]))
    arrange(world, "fox", x=5.1, y=5.0, energy=0.25)
    act(world, Feed)
    assert energies(world, "fox") == [0.3125]  # half of 0.125
    act(world, Hatch)
    world.flush()
    assert sorted(causes) == ["eaten by fox"] + ["hatched"] * (many - 1)
    assert world.tables["deer"].n == deer + many - 1


def test_eggs_count_as_members_that_are_to_come(meadow):
    world = nest(meadow, count=2, max_count=4)
    arrange(world, "deer", energy=1.0)
    for _ in range(10):
        act(world, Reproduce)
        world.tick += 1
        world.flush()
        arrange(world, "deer", energy=1.0)
    assert world.tables["egg"].n == 2
    world = nest(meadow, count=2, egg={"max_count": 1})
    arrange(world, "deer", energy=1.0)
    for _ in range(5):
        act(world, Reproduce)
        world.flush()
    assert world.tables["egg"].n == 1


def test_yolk_is_used_up_and_eggs_die_of_what_is_lethal(meadow):
    cold = {
        "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
        "metabolism": {"energy": 0.2, "energy_max": 1.0, "basal": 0.0625},
    }
    world = lay(nest(meadow, egg=cold))
    world.run(1)
    assert energies(world, "egg") == [0.0625] * world.tables["egg"].n
    world.run(1)
    assert world.tables["egg"].n == 0
    assert world.tables["deer"].n == 2


def test_what_an_egg_holds_is_in_who_hatches(meadow):
    world = lay(
        nest(
            meadow,
            world={"substances": {"water": "H2O"}},
            egg={"substances": {"water": 40.0}},
            substances={"water": 30.0},
            growth={"rate": 0.01, "newborn": 0.064},
        )
    )
    world.run(3)
    deer = world.tables["deer"]
    young = deer.by_uid()[2:]
    assert deer[Body].radius[young] == pytest.approx(0.2)  # 0.5 × 0.4: twice that of an egg
    assert deer[Chemistry].molarity[young, 0] == pytest.approx(5.0)


def test_amounts_stay_where_a_ball_hatches_into_a_capsule(meadow):
    capsule = {"shape": "capsule", "radius": 0.1, "length": 0.6, "opaque": False}
    world = lay(
        nest(
            meadow,
            world={"substances": {"water": "H2O"}},
            egg={"substances": {"water": 40.0}},
            substances={"water": 30.0},
            body=capsule,
        )
    )
    world.run(3)
    deer = world.tables["deer"]  # of π 0.01 (0.4 + 0.4 / 3) m³, an egg of 4/3 π 0.001 m³: 4 times as large
    assert deer[Chemistry].molarity[deer.by_uid()[2:], 0] == pytest.approx(10.0)


def test_eggs_that_nobody_laid_are_founders(meadow):
    genome = {"genes": [gene_for("size", "body.radius", 5, low=0.2, high=0.4)]}
    world = nest(meadow, egg={"count": 12}, genome=genome, reproduction=LAYS | {"rate": 0.0}, count=0)
    world.run(3)
    deer = world.tables["deer"]
    assert deer.n == 12
    assert len(set(deer[Body].radius[deer.rows()])) > 3
    decoded = deer.species.heredity.layout.decode(deer[Genome].loci[deer.rows()], ["size"])["size"]
    assert deer[Body].radius[deer.rows()] == pytest.approx(decoded)


def flock(**changes):
    """Goats with genes for everything, brains of their own and sexual reproduction, that lay eggs."""
    config = {**HERD, "species": {k: dict(v) for k, v in HERD["species"].items()}}
    goat = config["species"]["goat"]
    goat["reproduction"] = goat["reproduction"] | {"eggs": "egg", "litter": 2, "age_min": 1.0, "rest": 8.0}
    goat["components"] = []
    genes = [gene for gene in goat["genome"]["genes"] if gene["name"] != "wool"]
    goat["genome"] = goat["genome"] | {"genes": genes}
    goat["sensors"] = [
        *goat["sensors"],
        {"kind": "nearest", "target": "egg", "range": 5.0, "kin": "offspring"},
    ]
    config["species"]["egg"] = EGG | {"hatch": {"into": "goat", "incubation": 4.0}}
    return config | changes


def test_genomes_and_brains_pass_through_the_egg():
    world = World.from_config(flock(), seed=2)
    goat, egg = world.tables["goat"], world.tables["egg"]
    laid, hatched = {}, []

    def note(table, rows, first, second):
        if table is egg:
            for row, mother, father in zip(rows, first.tolist(), second.tolist(), strict=True):
                key = egg[Position].x[row].item(), mother, father
                laid[key] = egg[Genome].loci[row].copy(), np.array(egg[Policy].weights[row])
        elif table is goat and world.tick:
            for row, mother, father in zip(rows, first.tolist(), second.tolist(), strict=True):
                hatched.append(
                    (
                        goat[Position].x[row].item(),
                        mother,
                        father,
                        goat[Genome].loci[row].copy(),
                        np.array(goat[Policy].weights[row]),
                        goat[Body].radius[row],
                    )
                )

    world.on_birth.append(note)
    world.run(25)
    assert len(hatched) >= 3
    layout = goat.species.heredity.layout
    for x, mother, father, loci, weights, radius in hatched:
        genome, brain = laid[x, mother, father]
        assert (loci == genome).all()
        assert (weights == brain).all()
        assert radius == pytest.approx(layout.decode(loci[None], ["size"])["size"][0])
        assert mother
        assert father


def test_the_ledgers_close_and_births_are_recorded(meadow):
    world = nest(
        meadow,
        count=6,
        reproduction=LAYS | {"rate": 0.05},
        egg={"metabolism": {"energy": 0.2, "energy_max": 1.0, "basal": 0.001}},
    ).run(25)
    series = world.series()
    page = {name: np.array(series[name].to_pylist()) for name in LEDGER}
    assert np.abs(imbalance(page)).max() < 1e-6
    died, born = (np.array(series[name].to_pylist()) for name in ("died: hatched", "births"))
    names = np.array(series["species"].to_pylist())
    assert died.sum() > 0
    assert born[names == "deer"].sum() == died.sum()
    assert born[names == "egg"].sum() == died.sum() + world.tables["egg"].n


def test_eggs_with_genomes_and_brains_are_saved(tmp_path):
    world = World.from_config(flock(), seed=2).run(19)
    assert world.tables["egg"].n
    again = World.restore(world.save(tmp_path / "flock"))
    assert again.run(5).digest() == world.run(5).digest()


def test_the_system_keeps_the_rules(meadow):
    check_system(Hatch, lambda threads: lay(nest(meadow, count=20, options={"threads": threads})))


@pytest.mark.parametrize(
    ("egg", "deer", "place"),
    [
        ({}, {"reproduction": LAYS | {"eggs": "eg"}}, 'reproduction.eggs = "eg"'),
        ({}, {"reproduction": LAYS | {"eggs": "grass"}}, "no deer hatches from it"),
        ({}, {"reproduction": None}, "it does not lay these eggs"),
        ({"hatch": {"into": "der", "incubation": 1.0}}, {}, 'hatch.into = "der"'),
        ({"hatch": EGG["hatch"] | {"temperature": 270.0}}, {}, "not above the threshold"),
        ({}, {"substances": {}, "born_with": "mother"}, "its newborns are eggs"),
        ({"diet": [{"eats": "grass", "gain": 0.1}]}, {}, "an egg has none"),
        ({"metabolism": {"energy": 0.1, "energy_max": 0.1}}, {}, "more than an egg can store"),
    ],
)
def test_wrong_values_are_refused_by_name(meadow, egg, deer, place):
    with pytest.raises(ConfigError) as error:
        nest(meadow, egg=egg, **deer)
    assert place in str(error.value)
