"""Newborn are made of what their mothers, or the soil, held: nothing comes from nowhere."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Chemistry, Matter, Position
from ecs_eco.engine.errors import ConfigError
from ecs_eco.life.matter import Bodies, litres, stocks
from ecs_eco.record.matter import LEDGER, imbalance
from ecs_eco.systems import Spread
from ecs_eco.systems.provide import divide
from ecs_eco.testing import act

DIVIDES = {"kind": "asexual", "rate": 1.0, "energy_min": 0.1, "energy_given": 0.05, "dispersal": 5.0}


@pytest.fixture
def herd(meadow):
    return meadow(
        world={"substances": {"sugar": "", "salt": ""}},
        substances={"sugar": 0.5, "salt": 0.2},
        born_with="mother",
        reproduction=DIVIDES,
        lethal=[],
    )


def ledger(world):
    table = world.recorder.matter_series().to_pydict()
    return {name: np.reshape(table[name], (-1, *world.matter.stock.shape)) for name in LEDGER}


@pytest.mark.definition("3 chemical rules")
def test_mother_and_young_share_what_she_held(herd):
    mother = int(herd.tables["deer"].uid[0])
    herd.spawn("deer", Body(radius=0.25), n=2, parent=mother)
    before = stocks(herd, herd.matter)
    herd.flush()
    table = herd.tables["deer"]
    share = 8 / 10  # she has eight times the volume of each of the two
    assert table[Chemistry].molarity[:4, 0] == pytest.approx([0.5 * share, 0.5, 0.5 * share, 0.5 * share])
    assert stocks(herd, herd.matter) == pytest.approx(before, rel=1e-12)


def test_a_herd_that_breeds_makes_no_matter(herd):
    before = stocks(herd, herd.matter)
    herd.run(6)
    assert herd.tables["deer"].n > 3
    assert stocks(herd, herd.matter) == pytest.approx(before, rel=1e-12)
    page = ledger(herd)
    assert np.abs(page["endowed"]).max() < 1e-9
    assert np.abs(imbalance(page)).max() < 1e-9


def test_who_has_no_mother_is_endowed(herd):
    herd.spawn("deer", n=2)
    herd.run(1)
    page = ledger(herd)
    assert page["endowed"][0, 0, 0] == pytest.approx(2 * 0.5 * litres(0.5))
    assert np.abs(imbalance(page)).max() < 1e-9


def test_the_kernel_is_its_slow_twin():
    rng = np.random.default_rng(2)
    molarity, residue = rng.random((7, 2)).astype(np.float32), np.zeros((7, 2), np.float32)
    volume, before = rng.uniform(1, 2, 7), molarity.astype(float)
    young, mothers, given = np.array([5, 2, 6]), np.array([0, 3, 0]), np.zeros(2)
    divide(young, mothers, Bodies(volume, molarity, residue), given)
    wanted = before.copy()
    for mother, litter in ((0, [5, 6]), (3, [2])):
        wanted[[mother, *litter]] = before[mother] * volume[mother] / volume[[mother, *litter]].sum()
    assert molarity + residue.astype(float) == pytest.approx(wanted, rel=1e-12)
    assert given == pytest.approx((volume[young, None] * wanted[young]).sum(0), rel=1e-9)


# --- plants and soil ----------------------------------------------------------------------------------------

SITE = {"kind": "spread", "rate": 0.0, "seed_rain": 50.0, "spacing": 1.0}
RADIUS = (3 / 4000 / np.pi) ** (1 / 3)  # [m] of a body of one litre


def heath(nitrogen, world=None, **plant):
    """A world of 5 × 5 sites without plants, on soil with so many moles of nitrogen in the 1000 L of each."""
    return World.from_config(
        {
            "format": 1,
            "name": "heath",
            "space": {"size": [5.0, 5.0]},
            "substances": {"nitrogen": "", "wood": ""},
            "fields": {"soil": {"cell": 1.0, "substance": "nitrogen", "initial": nitrogen / 1000}},
            "species": {
                "heather": {
                    "count": 0,
                    "body": {"radius": RADIUS},
                    "substances": {"nitrogen": 2.0},
                    "born_with": "soil",
                    "reproduction": SITE,
                }
                | plant
            },
        }
        | (world or {})
    )


@pytest.mark.definition("3 chemical rules")
def test_a_seed_takes_what_it_is_made_of_from_the_soil():
    world = heath(nitrogen=5.0).run(1)
    assert world.tables["heather"].n == 25
    assert world.fields["soil"].value == pytest.approx(np.full((1, 5, 5), 0.003), rel=1e-6)
    assert world.tables["heather"][Matter].volume[:25] == pytest.approx(np.ones(25))
    page = ledger(world)
    assert page["taken_up"][0].ravel() == pytest.approx([50, 0, -50, 0])
    assert np.abs(page["endowed"]).max() < 1e-9
    assert np.abs(imbalance(page)).max() < 1e-9


def test_no_seed_sprouts_where_the_soil_lacks_what_it_needs():
    world = heath(nitrogen=1.9)
    world.fields["soil"].value[0, 2, 3] = 0.0021
    world.run(3)
    assert world.tables["heather"].n == 1


def test_the_soil_nourishes_any_of_the_seeds_that_want_it_of_whatever_species():
    """Nine seeds of heather fall for each seed of sorrel, so nine of ten plants are heather."""
    both = {
        name: {
            "count": 0,
            "body": {"radius": RADIUS},
            "substances": {"nitrogen": 2.0},
            "born_with": "soil",
            "reproduction": SITE | {"seed_rain": -np.log(1 - share)},  # on this share of free sites
        }
        for name, share in (("heather", 0.9), ("sorrel", 0.1))
    }
    fields = {"soil": {"cell": 5.0, "substance": "nitrogen", "initial": 1e-9}}
    wide = {"space": {"size": [10.0, 10.0]}, "fields": fields, "species": both}
    world, names, y = heath(nitrogen=0.0, world=wide), [], []
    for world.tick in range(80):
        world.fields["soil"].value[...] = [[[2.5 / 25_000, 0], [0, 0]]]  # for one seed
        act(world, Spread)
        for table in world.tables.values():
            for _, _, values in table.births:
                names += [table.name] * values[Position, "y"].size
                y += values[Position, "y"].tolist()
            table.births = []
    assert len(y) == 80
    assert abs(names.count("heather") - 72) < 11  # four standard deviations
    assert abs(np.mean(y) - 2.5) < 4 * 5 / np.sqrt(12 * 80)  # the middle of the world


def test_soil_that_lasts_for_two_gives_rise_to_two():
    """One cell for all sites: two seeds get what there is."""
    fields = {"soil": {"cell": 2.5, "substance": "nitrogen", "initial": 1e-9}}
    world = heath(nitrogen=0.0001, world={"fields": fields})
    world.fields["soil"].value[...] = [[[4.5 / 6250, 0], [0, 0]]]
    world.run(2)
    assert world.tables["heather"].n == 2
    assert world.fields["soil"].value.sum() * 6250 == pytest.approx(0.5, rel=1e-5)


def test_plants_that_die_and_sprout_again_keep_all_matter_in_the_world():
    world = heath(
        nitrogen=5.0,
        count=10,
        remains="litter",
        lethal=[{"property": "age", "max": 4.0}],
        world={"objects": {"litter": {"body": {"radius": 0.1}, "decomposition": {"rate": 0.5}}}},
    )
    before = stocks(world, world.matter).sum(0)
    born = []
    world.on_birth.append(lambda table, rows, *_: born.extend([table.name] * rows.size))
    world.run(40)
    assert born.count("heather") > 40
    assert stocks(world, world.matter).sum(0) == pytest.approx(before, rel=1e-9)
    assert np.abs(imbalance(ledger(world))).max() < 1e-9


def test_what_newborn_need_must_be_in_some_field():
    with pytest.raises(ConfigError, match="no field contains it"):
        heath(nitrogen=5.0, substances={"nitrogen": 1.0, "wood": 1.0})
