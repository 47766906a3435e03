"""A living world with other values is the world that was built with them, where nobody has lived yet; and
what cannot change is refused."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Experience, Metabolism
from ecs_eco.config import load
from ecs_eco.config.mutable_keys import changes, why_not
from ecs_eco.engine.errors import ConfigError
from ecs_eco.life.reconfigure import reconfigure

PREDATOR_PREY = {
    "space.size": [60.0, 60.0],
    "species.grass.count": 250,
    "species.deer.count": 60,
    "species.wolf.count": 20,
    "species.deer.reproduction.energy_min": 0.4,
    "species.deer.ppo.horizon": 4,
    "species.deer.policy.file": None,
    "species.deer.policy.learn": False,
    "species.wolf.policy.learn": False,
}
GENES = {
    "alphabet": "ACGT",
    "genes": [
        {"name": "eye", "trait": "sensors.wolf.range", "letters": 4, "low": 3.0, "high": 6.0},
        {"name": "giving", "trait": "reproduction.energy_given", "letters": 4, "low": 0.1, "high": 0.3},
        {"name": "marker", "letters": 8, "low": 0.0, "high": 1.0},
    ],
}
ALONE = {
    "species.deer.policy.kind": "individual",
    "species.deer.policy.learn": True,
    "species.deer.genome": GENES,
    "species.deer.reproduction.energy_given": 0.2,
}


def built(world, changed, **options):
    return World.from_config(load(world, changed), policies="untrained", **options)


def living(world, before, changed, **options):
    w = built(world, before, **options)
    reconfigure(w, load(world, before | changed))
    return w


PLAIN = {
    "what is eaten": {
        "species.deer.diet.0.chance": 0.9,
        "species.wolf.diet.0.gain": 0.2,
        "species.wolf.diet.0.reach": 1.0,
    },
    "another food": {
        "species.wolf.diet": [{"eats": "grass", "gain": 0.1}, {"eats": "deer", "gain": 0.3, "reach": 0.5}]
    },
    "births": {"species.deer.reproduction.rate": 0.2, "species.deer.reproduction.energy_given": 0.1},
    "plants": {
        "species.grass.reproduction.rate": 0.2,
        "species.grass.reproduction.seed_rain": 0.01,
        "species.grass.metabolism.photosynthesis": 0.01,
    },
    "costs": {
        "species.deer.locomotion.cost.walk": 0.05,
        "species.deer.locomotion.turn": 0.2,
        "species.deer.metabolism.basal": 0.02,
    },
    "another gait's name": {"species.deer.locomotion.speed.run": 3.0},
    "what kills": {"species.deer.lethal": [{"property": "energy", "min": 0.45, "cause_below": "famine"}]},
    "smells": {
        "fields.deer_smell.diffusion": 4.0,
        "fields.deer_smell.decay": 0.9,
        "species.deer.emits.deer_smell": 5.0,
    },
    "another smell": {"species.grass.emits.wolf_smell": 0.3},
    "a solid body": {
        "species.deer.body.solid": True,
        "species.wolf.body.solid": True,
        "species.deer.body.opaque": False,
    },
    "happiness": {
        "species.deer.happiness.formula": "-energy",
        "species.deer.happiness.minimum": -2.0,
        "species.deer.policy.learn": True,
    },
    "a reflex": {
        "species.deer.reflex": {
            "connections": [{"sensor": "energy", "action": "run", "weight": 1, "above": 0.5}]
        }
    },
    "learning": {"species.deer.policy.learn": True, "species.wolf.policy.learn": True},
    "how it learns": {
        "species.deer.ppo.discount": 0.5,
        "species.deer.ppo.horizon": 3,
        "species.deer.ppo.learning_rate": 0.1,
        "species.deer.policy.learn": True,
    },
    "most that live": {"species.grass.max_count": 251, "training.set": {}},
}


@pytest.mark.parametrize("name", PLAIN)
def test_a_world_retuned_before_its_first_tick_is_the_one_built_so(name):
    a, b = (
        built("predator-prey", PREDATOR_PREY | PLAIN[name]).run(9),
        living("predator-prey", PREDATOR_PREY, PLAIN[name]).run(9),
    )
    assert a.digest() == b.digest()
    assert a.config.resolved() == b.config.resolved()
    assert set(a.causes) <= set(b.causes)
    assert a.digest() != built("predator-prey", PREDATOR_PREY).run(9).digest(), (
        "the change changes nothing: a loss of it would not be seen"
    )


MENAGERIE = {
    "surroundings": {"ambient.light": 0.2, "ambient.temperature": 300.0, "terrain.slope_cost": 30.0},
    "costs": {"species.ram.locomotion.cost.walk": 0.2, "species.lynx.metabolism.basal": 0.1},
}


@pytest.mark.parametrize("name", MENAGERIE)
def test_also_where_there_is_ground(name, menagerie):
    changes = MENAGERIE[name]
    a, b = built(menagerie(), changes).run(12), living(menagerie(), {}, changes).run(12)
    assert a.digest() == b.digest()
    assert a.digest() != built(menagerie(), {}).run(12).digest()


SNAILS = {
    "format": 1,
    "name": "snails",
    "space": {"size": [20.0, 20.0]},
    "species": {
        "snail": {
            "count": 60,
            "body": {"radius": 0.1, "opaque": False},
            "reproduction": {
                "kind": "sexual",
                "energy_min": 0.2,
                "energy_given": 0.1,
                "reach": 1.0,
                "chance": 0.3,
                "consent": "none",
                "gestation": 2.0,
            },
        }
    },
}


@pytest.mark.parametrize(
    "changed", [{"reach": 3.0}, {"chance": 0.9, "choice": "richest"}, {"gestation": 0.0, "litter": 2}]
)
def test_also_where_two_mate_and_the_cells_of_the_index_change_with_their_reach(changed):
    changed = {f"species.snail.reproduction.{k}": v for k, v in changed.items()}
    a, b, plain = built(SNAILS, changed), living(SNAILS, {}, changed), built(SNAILS, {})
    assert (a.space.cell, a.space.shape) == (b.space.cell, b.space.shape)
    assert (a.space.cell != plain.space.cell) == ("species.snail.reproduction.reach" in changed)
    assert a.run(9).digest() == b.run(9).digest() != plain.run(9).digest()


LONELY = {
    "how it learns": {
        "species.deer.ppo.discount": 0.5,
        "species.deer.ppo.learning_rate": 0.1,
        "species.deer.ppo.clip": 0.05,
        "species.deer.ppo.epochs": 1,
    },
    "what no gene says": {
        "species.deer.reproduction.energy_min": 0.55,
        "species.deer.reproduction.rate": 0.3,
        "species.deer.reproduction.age_min": 2.0,
    },
    "mutation": {
        "species.deer.genome.mutate": {"operator": "mutUniformInt", "indpb": 0.5},
        "species.deer.reproduction.rate": 0.3,
    },
    "inheritance": {
        "species.deer.policy.inherit": "learned",
        "species.deer.policy.mutation_sd": 0.1,
        "species.deer.reproduction.rate": 0.3,
    },
    "no learning": {"species.deer.policy.learn": False},
}


@pytest.mark.parametrize("name", LONELY)
def test_also_with_genes_and_a_brain_for_each(name):
    start = PREDATOR_PREY | ALONE
    a, b = (
        built("predator-prey", start | LONELY[name]).run(9),
        living("predator-prey", start, LONELY[name]).run(9),
    )
    assert a.digest() == b.digest()
    assert a.digest() != built("predator-prey", start).run(9).digest()


def test_individuals_that_begin_to_learn_do_so_as_those_who_always_did():
    start = PREDATOR_PREY | ALONE | {"species.deer.policy.learn": False}
    a, b = (
        built("predator-prey", PREDATOR_PREY | ALONE),
        living("predator-prey", start, {"species.deer.policy.learn": True}),
    )
    assert list(a.tables["deer"].columns) == list(b.tables["deer"].columns)
    assert a.run(9).digest() == b.run(9).digest()
    reconfigure(b, load(b.config, {"species.deer.policy.learn": False}))
    assert Experience not in b.tables["deer"]
    b.run(2)


@pytest.mark.parametrize(
    "what",
    [
        {"species.deer.reproduction.rate": 0.1},
        {"species.deer.happiness.formula": "-energy"},
        {"species.deer.policy.learn": True},
    ],
)
def test_a_value_set_at_a_tick_by_the_file_is_the_same_as_a_retuning_between_two_runs(what):
    planned = built(
        "predator-prey", PREDATOR_PREY | {"interventions": [{"kind": "set", "at": 5, "set": what}]}
    ).run(12)
    by_hand = built("predator-prey", PREDATOR_PREY).run(5)
    reconfigure(by_hand, load(by_hand.config, what))
    assert (
        by_hand.run(7).digest() == planned.digest() != built("predator-prey", PREDATOR_PREY).run(12).digest()
    )


def test_two_values_one_after_the_other_and_back_leave_what_there_was():
    w = built("predator-prey", PREDATOR_PREY).run(3)
    start = w.config
    for changed in (PLAIN["births"], PLAIN["happiness"], PLAIN["a reflex"]):
        reconfigure(w, load(w.config, changed))
    reconfigure(w, start)
    assert w.run(6).digest() == built("predator-prey", PREDATOR_PREY).run(9).digest()


def test_the_living_keep_what_they_were_born_with_and_newborn_have_the_new():
    w = living(
        "predator-prey",
        PREDATOR_PREY | {"species.grass.reproduction.seed_rain": 0.1},
        {"species.grass.metabolism.energy": 0.05},
    )
    first, grass = w.next_uid, w.tables["grass"]
    w.run(3)
    energy, rows = grass[Metabolism].energy, grass.rows()
    old, young = rows[grass.uid[rows] < first], rows[grass.uid[rows] >= first]
    assert set(energy[old].tolist()) == {np.float32(0.18)}
    assert young.size
    assert set(energy[young].tolist()) == {np.float32(0.05)}


def test_another_seed_is_another_future_from_then_on():
    futures = {}
    for seed in (1, 2, 3):
        w = built("predator-prey", PREDATOR_PREY).run(4)
        reconfigure(w, load(w.config, {"seed": seed}))
        futures[seed] = w.run(4).digest()
    assert futures[1] == built("predator-prey", PREDATOR_PREY).run(8).digest()
    assert len(set(futures.values())) == 3


@pytest.mark.parametrize(
    ("key", "value", "hint"),
    [
        ("species.deer.count", 5, '"add" or "cull"'),
        ("space.size", [70.0, 60.0], "build a world with it"),
        ("dt", 0.5, "from the start"),
        ("species.deer.sensors.1.range", 5.0, "shapes"),
        ("species.deer.policy.hidden", [8], "shapes"),
        ("species.deer.body.radius", 0.5, "build"),
        ("species.deer.properties.temperature", 300.0, "shapes"),
        ("fields.deer_smell.cell", 2.0, "build"),
        ("species.deer.reproduction", None, '"switch"'),
        ("terrain", {"cell": 2.0}, '"fence"'),
        ("species.deer.policy.kind", "individual", "shapes"),
    ],
)
def test_what_cannot_change_is_refused_with_what_is_possible_instead_and_nothing_changes(key, value, hint):
    w = built("predator-prey", PREDATOR_PREY)
    before, digest = w.config, w.digest()
    with pytest.raises(ConfigError, match="cannot change during a run") as caught:
        reconfigure(w, load(w.config, {"species.deer.reproduction.rate": 0.5, key: value}))
    text = str(caught.value)
    assert key.split(".")[-1] in text
    assert hint in text
    assert w.config is before
    assert w.digest() == digest


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("species.deer.reproduction.energy_given", 0.25, "the gene giving codes for it"),
        ("species.deer.ppo.horizon", 9, "shapes"),
        ("species.deer.genome.genes.0.high", 5.0, "shapes"),
    ],
)
def test_what_genes_say_and_what_has_columns_does_not_change(key, value, message):
    w = built("predator-prey", PREDATOR_PREY | ALONE)
    with pytest.raises(ConfigError, match=message):
        reconfigure(w, load(w.config, {key: value}))


def test_changes_are_found_with_their_keys_in_lists_and_tables():
    old = {"a": 1, "b": [{"c": 1}, 2], "d": [1], "same": {"x": len}}
    new = {"a": 1, "b": [{"c": 3}, 2], "d": [1, 2], "e": 5, "same": {"x": len}}
    assert [key for key, _, _ in changes(old, new)] == [("b", 0, "c"), ("d",), ("e",)]


@pytest.mark.parametrize(
    ("keys", "instead"),
    [
        (
            "species.deer.growth.rate objects.box.body.mass species.deer.properties.heat water.current.0.depth "
            "species.deer.ppo.clip systems.0.speed species.deer.sensors.0.function.gain fields.air.decay "
            "species.deer.exchange.1.at.0 species.deer.emits.air species.deer.genome.mate.chance land_use.0.rate "
            "species.deer.happiness.function.use terrain.slope_cost substances.iron training.set.x",
            "",
        ),
        (
            "dt space.size.0 species.deer.body.radius species.deer.breeding species.deer.builds.0.object "
            "species.deer.reproduction.kind land_use.0.kind systems.0.use species.deer nonsense",
            "from the start",
        ),
        (
            "species.deer.growth species.deer.sensors.0.range species.deer.policy.function.gain "
            "objects.box.energy "
            "species.deer.genome.genes.0.low species.deer.emits.air.consume species.deer.hatch.into",
            "shapes",
        ),
        ("species.deer.count objects.box.between.0.1", '"add" or "cull"'),
        ("terrain.lakes.0.radius", '"fence"'),
        ("species.deer.reproduction", '"switch"'),
        ("species.deer.policy.file", "policies="),
    ],
)
def test_a_key_has_the_change_of_its_field_its_section_or_the_field_that_holds_it(keys, instead):
    for key in keys.split():
        assert instead in why_not(key), key
        assert bool(why_not(key)) == bool(instead), key
