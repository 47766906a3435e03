"""Worlds in which genomes make bodies, senses, nerves and lives: what newborn are,
and what holds whatever they are."""

import copy

import numpy as np
import pytest

from ecs_eco import World, component, f32
from ecs_eco.components import (
    Biology,
    Body,
    Defence,
    Desires,
    Experience,
    Genome,
    Growth,
    LifeHistory,
    Metabolism,
    Nervous,
    Plasticity,
    Policy,
    Position,
    Reflexes,
    Senses,
    Velocity,
    Vigour,
)
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.testing import all_threads, check_world, difference, shuffle, state

F = np.float32


@component
class Wool:
    """The coat of one animal."""

    length: f32 = 0.01  # [m]


def _gene(name, trait=None, letters=3, **more):
    return {"name": name, "trait": trait, "letters": letters} | (more or {"low": 0.0, "high": 1.0})


HERD = {
    "format": 1,
    "name": "herd",
    "seed": 5,
    "space": {"size": [30.0, 30.0]},
    "fields": {"musk": {"cell": 2.0, "diffusion": 0.5, "decay": 0.1}},
    "species": {
        "grass": {
            "count": 120,
            "body": {"radius": 0.3, "opaque": False},
            "metabolism": {"energy": 0.1, "energy_max": 0.4, "growth": 0.01},
            "defence": {"cost": 0.5},
            "reproduction": {"kind": "spread", "rate": 0.1, "seed_rain": 0.01, "spacing": 2.0},
            "genome": {
                "alphabet": "01", "mutate": {"operator": "mutFlipBit", "indpb": 0.02},
                "genes": [
                    _gene("vigour", "metabolism.growth", low=0.0, high=0.02),
                    _gene("runner", "reproduction.spread", low=0.2, high=1.0),
                    _gene("thorn", "defence.toughness", low=0.0, high=0.7),
                    _gene("venom", "defence.poison", low=0.0, high=0.07),
                ],
            },
        },
        "goat": {
            "count": 60,
            "sex": "random",
            "body": {"radius": 0.4, "mass": 50.0},
            "metabolism": {"energy": 0.6, "basal": 0.004},
            "locomotion": {"speed": {"still": 0.0, "walk": 0.8}, "cost": {"walk": 0.004}, "turn": 0.8},
            "emits": {"musk": 1.0},
            "diet": [{"eats": "grass", "gain": 0.2}],
            "sensors": [
                {"kind": "own", "property": "energy"}, {"kind": "nearest", "target": "grass", "radius": 5.0},
                {"kind": "smell", "field": "musk", "at": [1.0, 0.5]},
            ],
            "actions": {"speed": ["still", "walk"], "turn": ["left", "none", "right"], "eat": ["eat"],
                        "mate": ["mate"]},
            "neutral": {"speed": "still", "turn": "none"},
            "reflex": {"connections": [
                {"name": "green", "sensor": "grass_near", "action": "eat", "weight": 0, "above": 0.8},
                {"sensor": "energy", "action": "walk", "weight": 1, "below": 0.1},
            ]},
            "happiness": {"weights": {"energy": 1.0, "musk": 0.1}, "minimum": -1.0},
            "policy": {"kind": "individual", "hidden": [6], "learn": True, "inherit": "learned",
                       "mutation": 0.02},
            "ppo": {"horizon": 8, "epochs": 2, "learning_rate": 0.01},
            "components": [Wool],
            "genome": {
                "mutate": {"operator": "mutUniformInt", "indpb": 0.01},
                "genes": [
                    _gene("green", "reflex.green.weight", 1, values=[0, 0, 0, -1]),
                    _gene("blue", None, 1, values=[0, 0, 0, 1]),
                    _gene("edge", "reflex.green.threshold", low=0.5, high=0.9),
                    _gene("size", "body.radius", low=0.2, high=0.6),
                    _gene("weight", "body.mass", low=20.0, high=80.0),
                    _gene("legs", "locomotion.pace", low=0.5, high=2.0),
                    _gene("eye", "sensors.grass.radius", low=1.0, high=6.0),
                    _gene("nose", "sensors.musk.left", low=-1.0, high=1.0),
                    _gene("joy", "happiness.energy", low=-1.0, high=2.0),
                    _gene("span", "life.age_max", low=40.0, high=90.0),
                    _gene("rate", "ppo.learning_rate", low=1e-3, high=0.1, scale="log"),
                    _gene("young", "reproduction.litter", 1, values=[1, 1, 2, 3]),
                    _gene("ripe", "reproduction.age_min", low=5.0, high=20.0),
                    _gene("wool", "Wool.length", low=0.0, high=0.1),
                ],
            },
            "reproduction": {"kind": "sexual", "energy_min": 0.5, "energy_given": 0.15, "age_min": 10.0,
                             "reach": 1.5, "consent": "one",
                             "gestation": 4.0, "rest": 3.0, "father_share": 0.25},
            "lethal": [{"property": "energy", "min": 0.0, "low": "starved"},
                       {"property": "age", "max": 70.0, "high": "too old"}],
        },
    },
}  # fmt: skip


def _herd(**goat):
    config = copy.deepcopy(HERD)
    config["species"]["goat"] |= goat
    return config


def _goats(world):
    table = world.tables["goat"]
    return table, table.by_uid()


def test_a_herd_with_genes_for_everything_keeps_its_promises():
    check_world(lambda threads: World.from_config(HERD, threads=threads), ticks=60)


@pytest.mark.parametrize("goat", [
    {"policy": {"kind": "individual", "hidden": [4], "learn": True, "inherit": "none"}, "reproduction": {
        "kind": "asexual", "rate": 0.05, "energy_min": 0.5, "energy_given": 0.2}, "sex": "none", "actions": {
            "speed": ["still", "walk"], "turn": ["left", "none", "right"], "eat": ["eat"]}, "genome": {
                "ploidy": 2, "dominance": "mean",
                "genes": [_gene("size", "body.radius", low=0.2, high=0.6)]}},
    {"policy": {"kind": "individual", "hidden": [4], "learn": True, "inherit": "birth"}, "genome": {
        "mate": {"operator": "cxUniform", "indpb": 0.3},
        "mutate": {"operator": "mutShuffleIndexes", "indpb": 0.02},
        "genes": [_gene("brain", "policy.weights", 3, low=-1.0, high=1.0, form="direct")]}},
], ids=["diploid and asexual", "a brain in the genome"])  # fmt: skip
def test_other_ways_to_inherit_keep_their_promises(goat):
    check_world(lambda threads: World.from_config(_herd(**goat), threads=threads), ticks=40)


def test_learning_alone_is_the_same_in_any_order_of_rows_and_on_two_threads():
    one = World.from_config(_herd(count=150)).run(40)
    table, rows = _goats(one)
    assert table[Policy].updates[rows].max() >= 4
    mixed = shuffle(World.from_config(_herd(count=150)), 3).run(40)
    assert difference(state(one), state(mixed)) == ""
    with all_threads():
        assert World.from_config(_herd(count=150), threads=2).run(40).digest() == one.digest()


def test_a_newborn_is_what_its_genome_says():
    world = World.from_config(HERD).run(60)
    for name in ("goat", "grass"):
        table = world.tables[name]
        rows = table.rows()[table.born[table.rows()] > 0]
        assert rows.size > 10
        heredity = table.species.heredity
        decoded = heredity.layout.decode(table[Genome].loci[rows])
        for gene, (kind, field, index) in heredity.targets.items():
            column = table.field(kind, field)[rows]
            assert np.array_equal(column if index is None else column[:, index],
                                  decoded[gene].astype(column.dtype)), gene
    goat = world.tables["goat"]
    assert (goat[Reflexes].weight[goat.rows(), 1] == 1).all()  # no gene changes the other connection
    assert (goat[Desires].weight[goat.rows(), 1] == F(0.1)).all()
    assert (goat[Senses].radius[goat.rows(), 0] == 0).all()  # the sense of the own energy has no range
    assert goat[Wool].length[goat.rows()].std() > 0.01


def test_genes_cross_and_mutate_and_letters_come_from_the_parents():
    world = World.from_config(_herd(reproduction=HERD["species"]["goat"]["reproduction"]
                                    | {"gestation": 0.0}))
    goat, seen = world.tables["goat"], []

    def born(table, rows, first, second):
        if table is goat:
            for row, a, b in zip(rows, first, second, strict=True):
                mother, father = (table[Genome].loci[np.flatnonzero(table.uid == u)[0]] for u in (a, b))
                child = table[Genome].loci[row]
                seen.append(((child == mother) | (child == father), child != mother, child != father))

    world.on_birth.append(born)
    world.run(60)
    known = np.array([s[0] for s in seen])
    assert len(seen) > 20
    assert 0.985 < known.mean() < 0.999  # 0.01 a locus draws a letter anew; some draws are a parent's
    assert np.array([s[1].any() and s[2].any() for s in seen]).mean() > 0.5


def test_without_mutation_every_letter_is_a_parents():
    world = World.from_config(HERD, controls=("no-mutation",))
    loci = world.tables["goat"][Genome].loci
    start = [set(loci[world.tables["goat"].rows(), j].tolist()) for j in range(loci.shape[1])]
    world.run(60)
    table, rows = _goats(world)
    assert all(set(table[Genome].loci[rows, j].tolist()) <= start[j] for j in range(loci.shape[1]))


def test_in_neutral_drift_genes_say_nothing():
    world = World.from_config(HERD, controls=("neutral-drift",)).run(40)
    table, rows = _goats(world)
    assert (table[Reflexes].weight[rows, 0] == 0).all()
    assert (table[Body].radius[rows] == F(0.4)).all()
    assert (table[LifeHistory].age_max[rows] == 70).all()
    assert len(np.unique(table[Genome].loci[rows], axis=0)) > 20


def test_a_shuffled_genome_is_no_parents():
    def likeness(controls):
        world, alike = World.from_config(HERD, controls=controls), []
        goat = world.tables["goat"]

        def born(table, rows, first, second):
            if table is goat:
                for row, uid in zip(rows, first, strict=True):
                    mother = np.flatnonzero(table.uid == uid)
                    alike.extend((table[Genome].loci[row] == table[Genome].loci[m]).mean() for m in mother)

        world.on_birth.append(born)
        world.run(60)
        return np.mean(alike)

    assert likeness(()) > 0.55
    assert likeness(("shuffled-genome",)) < 0.45


def test_without_reflexes_nobody_has_one():
    world = World.from_config(HERD, controls=("no-reflexes",)).run(2)
    assert world.tables["goat"].species.nerves.reflex is None


def test_an_unknown_control_names_the_nearest():
    with pytest.raises(ConfigError, match='did you mean "no-mutation"'):
        World.from_config(HERD, controls=("no-mutations",))


def test_children_start_from_a_parents_learned_weights():
    world = World.from_config(_herd(policy=HERD["species"]["goat"]["policy"] | {"mutation": 0.0}),
                              learn=False)
    goat, seen = world.tables["goat"], []

    def born(table, rows, first, second):
        if table is goat:
            for row, *parents in zip(rows, first, second, strict=True):
                weights = [table[Policy].weights[int(r)] for u in parents
                           for r in np.flatnonzero(table.uid == u)]
                seen.append([bool((table[Policy].weights[int(row)] == w).all()) for w in weights])

    world.on_birth.append(born)
    world.run(60)
    both = [s for s in seen if len(s) == 2]
    assert len(both) > 15
    assert all(any(s) for s in both)
    assert 0.2 < np.mean([s[0] for s in both]) < 0.8  # the mother's or the father's


def test_inherited_weights_get_noise_of_the_declared_size():
    world = World.from_config(_herd(policy=HERD["species"]["goat"]["policy"] | {"mutation": 0.25}),
                              learn=False)
    table = world.tables["goat"]
    heredity, rows = table.species.heredity, table.rows()
    first = np.full(200, rows[0])
    values = heredity.offspring(world, table, first, None, np.arange(1, 201, dtype=np.uint64))
    noise = values[Policy, "weights"] - table[Policy].weights[int(rows[0])]
    assert noise.mean() == pytest.approx(0, abs=0.01)
    assert noise.std() == pytest.approx(0.25, rel=0.03)
    assert len(np.unique(noise[:, 0])) == 200


def test_a_dead_father_leaves_genes_and_no_brain():
    world = World.from_config(_herd(policy=HERD["species"]["goat"]["policy"] | {"mutation": 0.0}),
                              learn=False)
    table = world.tables["goat"]
    heredity, rows = table.species.heredity, table.rows()
    sperm = np.full((50, table[Genome].loci.shape[1]), 3, np.uint8)
    mothers, dead = np.full(50, rows[0]), np.full(50, -1)
    values = heredity.offspring(world, table, mothers, dead, np.arange(50, dtype=np.uint64), sperm=sperm)
    assert (values[Policy, "weights"] == table[Policy].weights[int(rows[0])]).all()
    assert 0.3 < (values[Genome, "loci"] == 3).mean() < 0.9


def test_founders_may_be_alike_and_say_what_the_species_is():
    section = HERD["species"]["goat"]["genome"] | {"founders": "own"}
    section["genes"] = [g | ({"low": 0.01, "high": 0.64} if g["name"] == "size" else {})
                        for g in section["genes"] if g["name"] in ("size", "green")]  # fmt: skip
    world = World.from_config(_herd(genome=section))
    table, rows = _goats(world)
    coded = table.species.heredity.layout.coded()
    assert len(np.unique(table[Genome].loci[rows][:, coded], axis=0)) == 1
    assert table[Body].radius[rows] == pytest.approx(0.4, abs=0.005)
    assert (table[Reflexes].weight[rows, 0] == 0).all()


def test_a_brain_trained_by_all_is_where_individuals_start():
    from ecs_eco.learning import PPO, Brain
    from ecs_eco.learning.individual import Individuals

    for hidden in ((5,), (6, 4)):
        brain = Brain(3, (2, 4), hidden, seed=4)
        for tensor in brain.named().values():
            tensor[...] += np.random.default_rng(1).normal(size=tensor.shape).astype(F)
        minds = Individuals(3, (2, 4), hidden, PPO(), 1)
        world = World(seed=1)
        table = world.add_table("one", Policy, dims={"weights": minds.size})
        rows = table.occupy(20, 1, 0, {(Policy, "weights"): np.repeat(minds.flat(brain)[None], 20, 0)})
        x = np.random.default_rng(2).normal(size=(20, 3)).astype(F)
        for mine, theirs in zip(minds.forward(table[Policy], rows, x, world.split), brain.forward(x),
                                strict=True):
            assert mine == pytest.approx(theirs, abs=1e-5)


def test_a_row_that_is_reused_has_nothing_of_the_dead():
    world = World.from_config(_herd(count=40)).run(6)
    table, rows = _goats(world)
    dead = rows[:10]
    assert (table[Experience].length[dead] > 0).any()
    moment = table[Policy].moment_2[dead]
    table.cause[dead] = 1
    world.flush_deaths()
    heredity = table.species.heredity
    values = heredity.founders(world, table, np.arange(10, dtype=np.uint64))
    table.request(np.zeros(10, np.uint64), values)
    world.flush_births()
    new = np.flatnonzero(table.alive & (table.born == world.tick))
    assert sorted(new) == sorted(dead)
    assert moment.any()
    for column in (table[Experience].length, table[Experience].observations, table[Policy].moment_1,
                   table[Policy].moment_2, table[Policy].steps, table[Nervous].awake):
        assert not np.asarray(column[new]).any()
    assert np.array_equal(table[Policy].weights[new], values[Policy, "weights"])


def test_plants_differ_in_what_their_genes_say():
    world = World.from_config(HERD)
    grass = world.tables["grass"]
    rows = grass.rows()
    assert len(np.unique(grass[Growth].growth[rows])) == 8
    before = grass[Metabolism].energy[rows].copy()
    from ecs_eco.systems import Grow

    grow = next(s for s in world.systems if isinstance(s, Grow))
    grow.update(grass, world)
    left = 1 - 0.5 * (grass[Defence].toughness[rows] + grass[Defence].poison[rows])
    assert grass[Metabolism].energy[rows] - before == pytest.approx(grass[Growth].growth[rows] * left,
                                                                    abs=1e-6)


def test_who_is_faster_pays_with_the_square():
    gene = _gene("legs", "locomotion.pace", 1, values=[0.5, 1, 1.5, 2])
    config = _herd(reflex={"formulas": {"walk": "1", "still": "-1"}}, genome={"loci": 4, "genes": [gene]})
    world = World.from_config(config, policies="random").run(1)
    table, rows = _goats(world)
    pace = table[Vigour].pace[rows]
    assert set(pace.tolist()) == {0.5, 1, 1.5, 2}
    assert table[Velocity].speed[rows] == pytest.approx(0.8 * pace)
    assert table[Velocity].cost[rows] == pytest.approx(0.004 * pace**2)


def test_large_bodies_burn_more_by_the_three_quarters_power():
    gene = _gene("mass", "body.mass", 1, values=[50, 100, 200, 400])
    config = _herd(policy={"kind": "none"}, ppo={}, genome={"loci": 4, "genes": [gene]})
    world = World.from_config(config).run(1)
    table, rows = _goats(world)
    assert table[Metabolism].burnt[rows] == pytest.approx(0.004 * (table[Body].mass[rows] / 50) ** 0.75,
                                                          rel=1e-5)


def test_each_dies_at_an_age_of_its_own():
    config = _herd(genome={"loci": 4, "genes": [_gene("span", "life.age_max", 1, values=[5, 10, 15, 20])]},
                   reproduction=None, count=40,
                   actions={"speed": ["still", "walk"], "turn": ["left", "none", "right"], "eat": ["eat"]},
                   lethal=[{"property": "age", "max": 10.0, "high": "too old"}])  # fmt: skip
    world, died = World.from_config(config), []
    world.on_death.append(lambda table, rows: died.extend(zip(table[Biology].age[rows],
                                                              table[LifeHistory].age_max[rows], strict=True))
                          if table.name == "goat" else None)  # fmt: skip
    world.run(25)
    assert len(died) == 40
    assert all(age == span for age, span in died)


def test_each_learns_with_hyperparameters_of_its_own():
    gene = _gene("rate", "ppo.learning_rate", 1, values=[0.0, 0.0, 0.05, 0.05])
    world = World.from_config(_herd(genome={"loci": 4, "genes": [gene]}))
    table, rows = _goats(world)
    before, uids = table[Policy].weights[rows], table.uid[rows]
    world.run(12)
    now, still = table.rows(), []
    for row in now[table.born[now] == 0]:
        unchanged = np.array_equal(table[Policy].weights[int(row)],
                                   before[np.flatnonzero(uids == table.uid[row])[0]])
        still.append((table[Plasticity].learning_rate[row] == 0, unchanged))
    assert {s[0] for s in still} == {True, False}
    assert all(frozen == unchanged for frozen, unchanged in still)


def test_happiness_is_what_the_own_weights_make_of_the_senses():
    world = World.from_config(HERD, policies="random").run(1)
    table = world.tables["goat"]
    nerves = table.species.nerves
    energy, musk = nerves.reading("energy", nerves.x), nerves.reading("musk", nerves.x)
    weight = table[Desires].weight[nerves.rows]
    wanted = np.maximum(weight[:, 0] * energy + weight[:, 1] * musk, -1)
    alive = table.alive[nerves.rows]
    assert table[Nervous].happiness[nerves.rows][alive] == pytest.approx(wanted[alive], abs=1e-6)
    assert weight[:, 0].std() > 0.1


def test_each_sees_as_far_as_its_own_eyes():
    config = load(HERD)
    goat = World.from_config(config, policies="random").run(1).tables["goat"]
    nerves, own = goat.species.nerves, goat[Senses].radius
    near = nerves.reading("grass_near", nerves.x)
    # as they stood when they sensed, before anyone moved or was eaten
    before = World.from_config(config, policies="random")
    p, q, plants = (before.tables["goat"][Position], before.tables["grass"][Position],
                    before.tables["grass"].rows())
    for i, row in enumerate(nerves.rows):
        dx, dy = (np.abs(getattr(q, a)[plants] - getattr(p, a)[row]) for a in ("x", "y"))
        distance = np.sqrt(np.minimum(dx, 30 - dx) ** 2 + np.minimum(dy, 30 - dy) ** 2).min()
        assert near[i] == pytest.approx(max(0.0, 1 - distance / own[row, 1]), abs=1e-3)
    assert 0.1 < (near > 0).mean() < 1


@pytest.mark.parametrize("options", [{"policies": "random"}, {"training": True, "learn": True}])
def test_genes_of_a_brain_say_nothing_where_nobody_has_one_of_its_own(options):
    brain = _gene("brain", "policy.weights", 3, low=-1.0, high=1.0, form="cosine", coefficients=3)
    config = _herd(policy={"kind": "individual", "hidden": [6], "inherit": "birth"},
                   genome={"genes": [brain]})
    world = World.from_config(config, **options).run(20)
    goat = world.tables["goat"]
    assert Policy not in goat
    assert goat[Genome].loci.any()
    assert (goat.species.nerves.brain is None) == ("policies" in options)
