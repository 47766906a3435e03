"""Fertility with age and season: hand-counted courses, the kernel against plain numpy, genes, refusals."""

import math

import numpy as np
import pytest

from ecs_eco.components import Biology, Breeding
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Mature, Reproduce
from ecs_eco.systems.mature import Fertility, by_age, ripen
from ecs_eco.testing import act, arrange, check_system

F = np.float32
AGES = [0.0, 9.9, 10.0, 20.0, 40.0, 55.0, 99.0, 100.0, 500.0]
DEER = {"count": len(AGES), "breeding": {"maturity": 10.0, "end": 100.0}}
YEAR = {"year": {"length": 100.0}}


def fertile(world):
    deer = world.tables["deer"]
    act(world, Mature)
    return deer[Biology].fertility[deer.by_uid()]


@pytest.mark.definition("1 fertility", "3 biological rules")
def test_fertility_rises_at_maturity_is_full_in_the_prime_and_ends(meadow):
    """Brass: 27/4 u (1 − u)²; at 20 u = 1/9, at 40 1/3, at 55 1/2."""
    world = meadow(**DEER)
    arrange(world, "deer", age=AGES)
    brass = [27 / 4 * u * (1 - u) ** 2 for u in (1 / 9, 1 / 3, 1 / 2, 89 / 90)]
    assert brass[:3] == pytest.approx([16 / 27, 1.0, 0.84375])
    assert fertile(world) == pytest.approx([0, 0, 0, *brass, 0, 0], abs=1e-6)


def test_the_prime_may_be_anywhere_between(meadow):
    """A prime halfway: (4 u (1 − u))^1.5."""
    world = meadow(**DEER | {"fertility": 0.5, "breeding": {"maturity": 10.0, "prime": 55.0, "end": 100.0}})
    arrange(world, "deer", age=AGES)
    u = (np.array([20.0, 40.0, 55.0, 99.0]) - 10) / 90
    assert fertile(world) == pytest.approx([0, 0, 0, *(0.5 * (4 * u * (1 - u)) ** 1.5), 0, 0], abs=1e-6)


def test_without_an_end_it_rises_to_the_prime_and_stays(meadow):
    world = meadow(**DEER | {"breeding": {"maturity": 10.0, "prime": 40.0}})
    arrange(world, "deer", age=AGES)
    assert fertile(world) == pytest.approx([0, 0, 0, 1 / 3, 1, 1, 1, 1, 1])
    world = meadow(**DEER | {"breeding": {"maturity": 10.0}})
    arrange(world, "deer", age=AGES)
    assert fertile(world).tolist() == [0, 0, 1, 1, 1, 1, 1, 1, 1]


@pytest.mark.parametrize(
    ("trait", "value", "breeding"),
    [
        ("maturity", 20.0, {"maturity": 60.0}),
        ("maturity", 20.0, {"maturity": 60.0, "end": 100.0}),
        ("end", 100.0, {"maturity": 10.0, "end": 300.0}),
        ("end", 100.0, {"maturity": 10.0}),
    ],
)
def test_the_prime_follows_genes_for_maturity_and_end(meadow, trait, value, breeding):
    gene = {"name": "g", "trait": f"breeding.{trait}", "letters": 1, "values": [value] * 2}
    coded = meadow(**DEER | {"breeding": breeding, "genome": {"alphabet": "01", "genes": [gene]}})
    written = meadow(**DEER | {"breeding": breeding | {trait: value}})
    for world in (coded, written):
        arrange(world, "deer", age=AGES)
    assert fertile(coded) == pytest.approx(fertile(written), rel=1e-5)


@pytest.mark.parametrize(("tick", "away"), [(0, 0.25), (25, 0.0), (75, 0.5), (125, 0.0), (35, 0.1)])
def test_the_season_comes_back_every_year(meadow, tick, away):
    """κ = 1/(2π 0.1)² = 2.533; a tenth of a year from its height fertility is exp(−0.484) = 0.6164 of it."""
    world = meadow(world=YEAR, breeding={"season": 0.25, "width": 0.1})
    world.tick = tick
    kappa = 1 / (2 * math.pi * 0.1) ** 2
    assert fertile(world) == pytest.approx(
        [math.exp(kappa * (math.cos(2 * math.pi * away) - 1))] * 2, rel=1e-6
    )
    if away == 0.1:
        assert fertile(world)[0] == pytest.approx(0.6164, abs=1e-4)


def test_the_year_may_be_that_of_the_sun_and_begin_in_autumn(meadow):
    summer = meadow(world={"sun": {"year": 100.0}}, breeding={"season": 0.5})
    autumn = meadow(world={"year": {"length": 100.0, "start": 0.5}}, breeding={"season": 0.5})
    assert fertile(autumn)[0] == 1.0
    assert fertile(summer)[0] < 0.01
    summer.tick = 50
    assert fertile(summer)[0] == 1.0


def test_nobody_is_born_outside_of_the_season(meadow):
    way = {"kind": "asexual", "rate": 100.0, "energy_min": 0.1, "energy_given": 0.05, "dispersal": 5.0}
    world = meadow(
        count=50, world=YEAR | {"dt": 0.01}, reproduction=way, breeding={"season": 0.0, "width": 0.02}
    )
    arrange(world, "deer", energy=0.9)
    world.tick = 5000
    act(world, Mature)
    act(world, Reproduce)
    world.flush()
    assert world.tables["deer"].n == 50
    world.tick = 10000
    act(world, Mature)
    act(world, Reproduce)
    world.flush()
    assert world.tables["deer"].n > 60


def test_newborn_are_as_fertile_as_their_age_allows(meadow):
    for breeding, newborn in ({"maturity": 1.0}, 0.0), ({}, 0.75), (None, 0.75):
        world = meadow(fertility=0.75, breeding=breeding)
        assert world.tables["deer"][Biology].fertility[:2].tolist() == [newborn] * 2


def gene(name, trait, low, high):
    return {"name": name, "trait": trait, "letters": 4, "low": low, "high": high}


def test_height_and_season_may_be_genes(meadow):
    genome = {"genes": [gene("height", "fertility", 0.5, 1.0), gene("time", "breeding.season", 0.0, 0.9)]}
    world = meadow(count=40, world=YEAR, breeding={"season": 0.25, "width": 0.1}, genome=genome)
    b = world.tables["deer"][Breeding]
    assert len(set(b.season[:40])) > 10
    assert 0.5 <= b.peak[:40].min() < b.peak[:40].max() <= 1.0
    assert (b.width[:40] == F(0.1)).all()
    assert (b.maturity[:40] == 0).all()
    world.tick = 30
    kappa = 1 / (2 * math.pi * float(F(0.1))) ** 2
    wanted = b.peak[:40] * np.exp(kappa * (np.cos(2 * np.pi * (0.3 - b.season[:40].astype(float))) - 1))
    assert fertile(world) == pytest.approx(wanted, rel=1e-5)


def test_without_breeding_a_gene_writes_fertility_itself(meadow):
    way = {"kind": "asexual", "rate": 0.0, "energy_min": 0.1, "energy_given": 0.05}
    world = meadow(count=40, reproduction=way, genome={"genes": [gene("height", "fertility", 0.5, 1.0)]})
    fertility = world.tables["deer"][Biology].fertility[:40]
    assert 0.5 <= fertility.min() < fertility.max() <= 1.0
    world.run(3)
    assert (world.tables["deer"][Biology].fertility[:40] == fertility).all()
    assert not any(isinstance(s, Mature) for s in world.systems)


def test_a_year_warms_and_cools_bodies_and_light_follows_it(meadow):
    world = meadow(
        world={
            "year": {"length": 100.0, "temperature": 10.0, "warmest": 0.25},
            "sun": {"kind": "constant", "latitude": 60.0, "declination": 23.4},
        }
    )
    place = np.zeros(1, F)
    seen = []
    for tick in (0, 25, 75):
        world.tick = tick
        seen.append(
            (
                float(world.surroundings("temperature", place, place, place)[0]),
                float(world.surroundings("light", place, place, place)[0]),
            )
        )
    assert [t for t, _ in seen] == pytest.approx([285, 295, 275], abs=1e-3)
    assert seen[1][1] > seen[0][1] > seen[2][1]


def plain(age, peak, maturity, prime, end, season, width, share):
    if age < maturity or age >= end:
        return 0.0
    u, m = (age - maturity) / (end - maturity), (prime - maturity) / (end - maturity)
    value = peak * (u / m) ** (3 * m) * ((1 - u) / (1 - m)) ** (3 * (1 - m))
    return value * math.exp((math.cos(2 * math.pi * (share - season)) - 1) / (2 * math.pi * width) ** 2)


def test_the_kernel_does_what_plain_python_does():
    generator = np.random.Generator(np.random.Philox(7))
    n = 200
    alive = generator.random(n) < 0.8
    age, peak = generator.uniform(0, 120, n).astype(F), generator.random(n).astype(F)
    maturity, end = generator.uniform(0, 20, n).astype(F), generator.uniform(60, 110, n).astype(F)
    prime = generator.uniform(25, 55, n).astype(F)
    season, width = generator.random(n).astype(F), generator.uniform(0.05, 0.5, n).astype(F)
    fertility = np.full(n, 7, F)
    ripen(0, n, alive, age, Fertility(peak, maturity, prime, end, season, width), True, 0.4, True, fertility)
    each = zip(*(a.astype(float) for a in (age, peak, maturity, prime, end, season, width)), strict=True)
    wanted = [plain(*values, 0.4) if lives else 7 for values, lives in zip(each, alive, strict=True)]
    assert fertility == pytest.approx(wanted, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize(("prime", "end"), [(5.0, 100.0), (200.0, 100.0), (10.0, 10.0), (5.0, 3.0)])
def test_odd_genes_give_numbers_from_0_to_1(prime, end):
    values = [by_age(age, 10.0, prime, end) for age in np.linspace(0, 300, 601)]
    assert all(0 <= v <= 1 for v in values)


def test_the_system_keeps_the_rules(meadow):
    genome = {"genes": [gene("time", "breeding.season", 0.0, 0.9)]}
    check_system(
        Mature,
        lambda threads: meadow(
            count=30,
            world=YEAR,
            breeding={"maturity": 1.0, "end": 50.0, "season": 0.1},
            genome=genome,
            options={"threads": threads},
        ),
    )


@pytest.mark.parametrize(
    ("breeding", "world", "place"),
    [
        ({"maturity": 5.0, "end": 5.0}, {}, "breeding.end = 5.0"),
        ({"maturity": 5.0, "prime": 4.0}, {}, "breeding.prime = 4.0"),
        ({"prime": 8.0, "end": 8.0}, {}, "breeding.prime = 8.0"),
        ({"season": 0.3}, {}, "breeding.season = 0.3"),
        ({"season": 0.3}, {"sun": {}}, "breeding.season = 0.3"),
        ({}, {"year": {"length": 5.0}, "sun": {"year": 6.0}}, "sun.year = 6.0"),
    ],
)
def test_wrong_values_are_refused_by_name(meadow, breeding, world, place):
    with pytest.raises(ConfigError) as error:
        meadow(world=world, breeding=breeding)
    assert place in str(error.value)


def test_breeding_may_change_while_they_live_but_not_come_or_go(meadow):
    world = meadow(breeding={"maturity": 5.0})
    world.intervene({"kind": "set", "set": {"species.deer.breeding.maturity": 0.0}})
    world.run(1)
    assert (world.tables["deer"][Biology].fertility[:2] == 1).all()
    with pytest.raises(ConfigError, match="cannot change during a run"):
        meadow().intervene({"kind": "set", "set": {"species.deer.breeding": {"maturity": 0.0}}})
