"""What follows from the size of a body is each organism's own where its size is."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Body, Metabolism, Position, Stature
from ecs_eco.life import broods
from ecs_eco.life.matter import volumes
from ecs_eco.life.places import radius_of, range_of
from ecs_eco.odd import describe
from ecs_eco.systems import Reproduce
from ecs_eco.testing import act

BIRTHS = {"kind": "asexual", "place": "anywhere", "rate": 1.0, "energy_min": 0.25, "energy_given": 0.125}


def bugs(body=None, low=0.15, high=0.6, count=40, world=None, **bug):
    """A world of bugs with a gene for their radius."""
    genome = {"genes": [{"name": "size", "trait": "body.radius", "letters": 3, "low": low, "high": high}]}
    species = {
        "count": count,
        "body": {"radius": 0.3, "density": 1000.0} if body is None else body,
        "metabolism": {"energy": 1.0, "basal": 0.01},
        "reproduction": BIRTHS,
        "genome": genome,
    } | bug
    config = {"format": 1, "name": "sizes", "space": {"size": [400.0, 400.0]}, "species": {"bug": species}}
    return World.from_config(config | (world or {}), seed=1)


def spheres(radius):
    return 4 / 3 * np.pi * radius.astype(np.float64) ** 3


def test_the_mass_of_founders_and_newborn_is_the_density_times_their_own_volume():
    world = bugs()
    act(world, Reproduce)
    world.flush()
    table = world.table("bug")
    rows = table.rows()
    radius, mass = table[Body].radius[rows], table[Body].mass[rows]
    assert rows.size > 55
    assert len(set(radius)) > 20
    assert mass == pytest.approx(1000 * spheres(radius), rel=1e-5)


@pytest.mark.parametrize(
    "body",
    [
        {"shape": "capsule", "radius": 0.3, "length": 1.5, "density": 2.0},
        {"shape": "box", "size": [0.6, 0.4, 0.2], "density": 2.0},
    ],
)
def test_capsules_and_boxes_weigh_what_their_own_volume_says(body):
    table = bugs(body).table("bug")
    rows = table.rows()
    assert len(set(table[Body].radius[rows])) > 10
    assert table[Body].mass[rows] == pytest.approx(0.002 * volumes(table)[rows], rel=1e-5)  # [kg/L]


def test_upkeep_follows_the_mass_that_follows_from_a_radius():
    world = bugs().run(1)
    table = world.table("bug")
    rows = table.rows()
    rows = rows[:40]  # newborn have burnt nothing yet
    expected = 0.01 * (table[Body].radius[rows] / 0.3) ** 2.25
    assert table[Metabolism].burnt[rows] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(
    ("trait", "formula", "power"), [("body.radius", "0.3 * s", 2.25), ("body.mass", "5 * s", 0.75)]
)
def test_a_derived_radius_or_mass_counts_like_one_of_a_gene(trait, formula, power):
    gene = {"name": "s", "letters": 3, "low": 0.5, "high": 2.0}
    body = {"radius": 0.3, "density": 1000.0} if trait == "body.radius" else {"radius": 0.3, "mass": 5.0}
    derived = {"size": {"trait": trait, "formula": formula, "from": ["s"]}}
    world = bugs(body, genome={"genes": [gene], "derived": derived}).run(1)
    table = world.table("bug")
    rows = table.rows()
    size = table[Body].radius[rows] / 0.3 if trait == "body.radius" else table[Body].mass[rows] / 5
    assert rows.size > 40  # newborns, too
    assert len(set(size)) > 10
    if trait == "body.radius":
        assert table[Body].mass[rows] == pytest.approx(1000 * spheres(table[Body].radius[rows]), rel=1e-5)
    assert table[Metabolism].burnt[rows[:40]] == pytest.approx(0.01 * size[:40] ** power, rel=1e-4)
    assert "(mass/body.mass)^0.75" in describe(world.config).markdown()


def test_a_mass_that_the_file_gives_stays_whatever_the_radius():
    world = bugs({"radius": 0.3, "mass": 7.0}).run(1)
    table = world.table("bug")
    rows = table.rows()
    assert set(table[Body].mass[rows]) == {7.0}
    assert table[Metabolism].burnt[rows[:40]] == pytest.approx(0.01, rel=1e-5)


def test_a_gene_for_the_mass_says_more_than_the_density():
    genes = [
        {"name": "size", "trait": "body.radius", "letters": 3, "low": 0.15, "high": 0.6},
        {"name": "mass", "trait": "body.mass", "letters": 3, "low": 1.0, "high": 2.0},
    ]
    table = bugs(genome={"genes": genes}).table("bug")
    mass = table[Body].mass[table.rows()]
    assert 1 <= mass.min() < mass.max() <= 2


def test_those_that_grow_approach_the_mass_of_their_own_adult_size():
    world = bugs(growth={"rate": 1.0, "newborn": 0.125})
    act(world, Reproduce)
    world.flush()
    table = world.table("bug")
    rows = table.rows()
    young = rows[40:]
    assert table[Stature].mass[rows] == pytest.approx(1000 * spheres(table[Stature].radius[rows]), rel=1e-5)
    assert table[Body].radius[young] == pytest.approx(table[Stature].radius[young] / 2, rel=1e-6)
    assert table[Body].mass[young] == pytest.approx(1000 * spheres(table[Body].radius[young]), rel=1e-5)


def test_newborn_after_a_change_of_density_have_the_new_one():
    world = bugs()
    world.intervene({"kind": "set", "set": {"species.bug.body.density": 500.0}})
    world.run(1)
    table = world.table("bug")
    rows = table.rows()
    density = table[Body].mass[rows] / spheres(table[Body].radius[rows])
    assert density == pytest.approx(np.where(np.arange(rows.size) < 40, 1000, 500), rel=1e-5)
    assert table.species.standard_mass == pytest.approx(500 * 4 / 3 * np.pi * 0.027)


def test_a_gene_whose_mass_no_number_holds_is_refused():
    with pytest.raises(ValueError, match="density × volume"):
        bugs({"radius": 0.3, "density": 1e25}, high=199.0)


@pytest.mark.parametrize("most", [1 << 16, -1])
def test_small_bodies_leave_room_for_newborn_where_large_ones_would_not(most, monkeypatch):
    monkeypatch.setattr(broods, "MOST_PAIRS", most)
    born = {}
    for radius in (0.2, 4.0):
        world = bugs(
            {"radius": 0.2, "mass": 1.0},
            low=0.2,
            high=4.0,
            count=300,
            world={"space": {"size": [60.0, 60.0]}},
        )
        table = world.table("bug")
        table[Body].radius[:] = radius
        table.version += 1
        old = table.rows()
        act(world, Reproduce)
        world.flush()
        new = table.rows()[old.size :]
        born[radius] = new.size
        p = table[Position]
        d = np.stack([p.x[old] - p.x[new][:, None], p.y[old] - p.y[new][:, None]])
        d -= 60 * np.round(d / 60)
        if new.size:
            assert np.hypot(*d).min() >= 0.2 + radius - 1e-4
    assert born[0.2] > 5 * born[4.0] > 0


def test_young_that_are_born_small_need_less_room():
    table = bugs(growth={"rate": 1.0, "newborn": 0.125}).table("bug")
    assert radius_of(table) == pytest.approx(0.15)


def test_four_radii_of_the_body_are_those_of_the_mother():
    way = {"kind": "sexual", "energy_min": 0.5, "energy_given": 0.1, "gestation": 1.0}
    table = bugs(sex="random", reproduction=way).table("bug")
    near, spacing = range_of(table, table.species.reproduction)
    assert near[table.rows()] == pytest.approx(4 * table[Body].radius[table.rows()])
    assert spacing.shape == near.shape


def test_neutral_drift_gives_newborns_the_size_of_the_species(meadow):
    gene = {"name": "n", "trait": "growth.newborn", "letters": 1, "values": [0.1, 0.4]}
    way = {"kind": "asexual", "rate": 0.5, "energy_min": 0.1, "energy_given": 0.05, "place": "anywhere"}
    world = meadow(
        count=20,
        growth={"rate": 1e-9, "newborn": 0.2},
        reproduction=way,
        genome={"alphabet": "01", "genes": [gene]},
    ).config
    world = World.from_config(world, seed=1, controls=["neutral-drift"]).run(3)
    deer = world.tables["deer"]
    born = deer[Biology].age[deer.rows()] < 3
    assert born.sum() > 3
    shares = deer[Body].mass[deer.rows()][born] / deer[Stature].mass[deer.rows()][born]
    assert shares == pytest.approx(0.2, rel=1e-3)
