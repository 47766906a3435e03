"""Genes that hold the weights of networks, and genes that say which organs and units there are."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Genome, Instincts, Metabolism, Nervous, Policy, Traits
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.genomes.fit import Fitted
from tests.worlds.herd import HERD, F, gene_for, goats, herd

CHANNELS, ACTIONS = 5, ["still", "walk", "left", "none", "right", "eat", "mate"]  # of the herd's goats
FEW = {"species.goat.count": 12, "species.green.count": 50, "species.red.count": 5, "species.yellow.count": 5}


def genome(*genes, **more):
    """A genome of some genes alone."""
    return {
        "mate": {"operator": "cxUniform", "indpb": 0.5},
        "mutate": {"operator": "mutUniformInt", "indpb": 0.01},
        "genes": list(genes),
    } | more


def linear(kind, weights, biases):
    """A network without hidden units, of matrix f32[channels, units] and biases f32[units]."""
    matrix = np.asarray(weights, F).reshape(CHANNELS, -1)
    return Fitted(
        kind, (CHANNELS, matrix.shape[1]), np.concatenate([matrix.ravel(), np.asarray(biases, F)]), 0.0
    )


@pytest.mark.definition("3 genome encodes")
def test_without_a_sensor_its_channels_read_0_and_without_an_action_it_is_never_taken():
    world = World.from_config(
        herd(
            genome=genome(
                gene_for("gut", "sensors.energy.present", 1, values=[0, 0, 1, 1]),
                gene_for("eye", "sensors.grass.present", 1, values=[0, 1, 1, 1]),
                gene_for("mouth", "actions.eat.eat.present", 1, values=[0, 0, 1, 1]),
            )
        )
    ).run(1)
    table, _ = goats(world)
    nerves = table.species.nerves
    rows, own = nerves.rows, table[Traits].value[nerves.rows]
    gut, eye, mouth = (
        own[:, table.species.traits[key]] > 0
        for key in ("sensors.energy.present", "sensors.grass.present", "actions.eat.eat.present")
    )
    assert 10 < gut.sum() < 50
    assert (nerves.x[~gut, 0] == 0).all()
    assert (nerves.x[gut, 0] > 0.3).all()
    assert (nerves.x[~eye, 1:4] == 0).all()
    assert (nerves.x[eye, 1:4] != 0).any()
    assert (nerves.x[:, 4] > 0).any()  # the nose is nobody's gene
    ate = table[Nervous].decision[rows, nerves.column("eat")]
    assert not ate[~mouth].any()
    assert ate[mouth].mean() > 0.2


@pytest.mark.definition("3 genome encodes")
def test_a_gene_says_how_many_hidden_units_a_brain_has_and_learning_adds_none():
    gene = gene_for("units", "policy.hidden.0", 1, values=[1, 2, 4, 6])
    world = World.from_config(herd(genome=genome(gene, founders="random"))).run(40)
    table, rows = goats(world)
    into, bias, out = table.species.nerves.individuals.views(table[Policy].weights[rows])[:3]
    units = (into.any(axis=1) | (bias != 0) | out.any(axis=2)).sum(axis=1)
    assert np.array_equal(units, table[Traits].value[rows, 0].astype(int))
    assert set(units) == {1, 2, 4, 6}
    assert table[Policy].updates[rows].max() >= 3
    assert (table.born[rows] > 0).any()


def test_a_pruned_network_thinks_as_a_smaller_one():
    from ecs_eco.learning import PPO
    from ecs_eco.learning.individual import Individuals

    large, small = (Individuals(3, (2,), (hidden,), PPO(), 1) for hidden in (5, 2))
    weights = large.draw(np.arange(4, dtype=np.uint64), 7)
    fresh = weights.copy()
    large.prune(weights, np.full(4, 2), 0)
    into, bias, out, last = (part.copy() for part in large.views(weights))
    shrunk = np.concatenate([into[:, :, :2].reshape(4, -1), bias[:, :2], out[:, :2].reshape(4, -1), last], 1)
    world = World(seed=1)
    x = np.random.default_rng(2).normal(size=(4, 3)).astype(F)
    seen = []
    for name, minds, each in (("large", large, weights), ("small", small, shrunk)):
        table = world.add_table(name, Policy, dims={"weights": minds.size})
        rows = table.occupy(4, 1, 0, {(Policy, "weights"): each})
        seen.append(minds.forward(table[Policy], rows, x, world.split))
    for one, other in zip(*seen, strict=True):
        assert one == pytest.approx(other, abs=1e-6)
    large.complete(weights, fresh)
    assert np.array_equal(weights, fresh)


@pytest.mark.definition("3 genome encodes", "3 hand-coded")
def test_a_fitted_happiness_is_in_the_letters_of_founders_and_is_what_they_feel():
    wants = linear("happiness", [2.0, 0.0, 0.0, 0.0, 0.0], [0.5])  # 2 × energy + 0.5
    gene = gene_for("wants", "happiness.weights", 2, low=-3.5, high=4.0, form="direct")  # in steps of 0.5
    config = herd(happiness={"function": wants, "minimum": -9.0}, genome=genome(gene, founders="own"))
    world = World.from_config(config).run(1)
    table, _ = goats(world)
    rows, x = table.species.nerves.rows, table.species.nerves.x
    assert (table[Instincts].happiness[rows] == wants.weights).all()
    assert table[Nervous].happiness[rows] == pytest.approx(2 * x[:, 0] + 0.5)
    drawn = World.from_config(herd(happiness={"function": wants, "minimum": -99.0}, genome=genome(gene))).run(
        1
    )  # founders = "random"
    table, _ = goats(drawn)
    rows, x, own = (
        table.species.nerves.rows,
        table.species.nerves.x,
        table[Instincts].happiness[table.species.nerves.rows],
    )
    assert len(np.unique(own, axis=0)) > 50
    assert table[Nervous].happiness[rows] == pytest.approx((x * own[:, :5]).sum(axis=1) + own[:, 5], abs=1e-5)


@pytest.mark.definition("3 genome encodes", "3 hand-coded")
def test_a_fitted_reflex_is_in_the_letters_and_what_mutates_reacts_otherwise():
    biases = np.zeros((len(ACTIONS), 3), F)
    biases[ACTIONS.index("eat"), 0] = 1.0  # −1: never eat
    biases[ACTIONS.index("mate"), 2] = 1.0  # 1: always mate
    reacts = linear("reflex", np.zeros((CHANNELS, 21)), biases.ravel())
    gene = gene_for("reacts", "reflex.weights", 1, low=-1.0, high=2.0, form="direct")
    world = World.from_config(herd(reflex={"function": reacts}, genome=genome(gene, founders="own"))).run(1)
    table, rows = goats(world)
    nerves, decision = table.species.nerves, table[Nervous].decision
    assert not decision[rows, nerves.column("eat")].any()
    assert decision[rows, nerves.column("mate")].all()
    mutant = rows[0]
    weights = table[Instincts].reflex[rows[:1]]
    weights[0, CHANNELS * 21 + ACTIONS.index("eat") * 3 + 2] = 2.0  # now: always eat
    table[Instincts].reflex[rows[:1]] = weights
    world.run(1)
    assert decision[mutant, nerves.column("eat")] == 1
    assert not decision[rows[1:], nerves.column("eat")].any()


def test_a_function_that_is_no_network_has_no_weights_for_genes():
    gene = gene_for("wants", "happiness.weights", 2, low=-1.0, high=1.0, form="direct")
    with pytest.raises(ConfigError, match="not a network, but a gene codes for its weights"):
        World.from_config(
            herd(happiness={"function": lambda x: x[:, 0], "minimum": -1.0}, genome=genome(gene))
        )


def test_a_trained_policy_becomes_the_letters_of_founders():
    teacher = World.from_config(load("innate", FEW), seed=2, record=False)
    table = teacher.tables["goat"]
    module = teacher.policy("goat", int(table.uid[table.by_uid()[0]]))
    alike = load("innate", FEW | {"species.goat.genome.founders": "own"})
    world = World.from_config(alike, policies={"goat": module}, record=False)
    pupils, rows = goats(world)
    first = table[Policy].weights[table.by_uid()[:1]]
    assert np.array_equal(pupils[Policy].weights[rows], np.repeat(first, rows.size, axis=0))
    for p in module.parameters():
        p.data[...] = 5.0
    with pytest.raises(ConfigError, match="it cannot code for the weights of founders"):
        World.from_config(alike, policies={"goat": module}, record=False)


def test_genes_hold_the_weights_of_a_torch_module():
    torch = pytest.importorskip("torch")

    class Net(torch.nn.Module):
        def __init__(self, n_observations, groups):
            super().__init__()
            self.policy = torch.nn.Linear(n_observations, sum(groups))
            self.value = torch.nn.Linear(n_observations, 1)

        def forward(self, x):
            return self.policy(x), self.value(x)[:, 0]

    policy = {"kind": "individual", "network": Net, "learn": True, "inherit": "birth"}
    gene = gene_for("brain", "policy.weights", 2, low=-1.0, high=1.0, form="direct")
    world = World.from_config(herd(policy=policy, count=20, genome=genome(gene)))
    table, rows = goats(world)
    heredity = table.species.heredity
    assert heredity.layout["brain"].width == ((5 + 1) * (2 + 3 + 2 + 2) + 6,)
    loci = table[Genome].loci[rows]
    assert np.array_equal(table[Policy].weights[rows], heredity.layout.decode(loci)["brain"])
    world.run(12)
    assert (table[Policy].weights[table.rows()] != 0).any()


def test_a_gene_that_reaches_a_value_that_would_be_refused_is_refused():
    gene = gene_for("gut", "metabolism.energy_max", low=0.1, high=2.0)  # they begin with 0.6
    with pytest.raises(ConfigError, match=r"metabolism.energy: more than energy_max"):
        World.from_config(herd(genome=genome(gene)))
    fast = gene_for("legs", "locomotion.speed.walk", low=0.5, high=99.0)  # in a world of 30 m
    with pytest.raises(ConfigError, match="more than half the world's width"):
        World.from_config(herd(genome=genome(fast)))


def test_worlds_with_values_of_their_own_resume_with_equal_bytes(tmp_path):
    genes = (
        gene_for("basal", "metabolism.basal", low=0.002, high=0.008),
        gene_for("gain", "diet.grass.gain", low=0.1, high=0.3),
        gene_for("gut", "sensors.energy.present", 1, values=[0, 1, 1, 1]),
        gene_for("units", "policy.hidden.0", 1, values=[1, 2, 4, 6]),
    )
    world = World.from_config(herd(genome=genome(*genes))).run(25)
    table, _ = goats(world)
    assert table[Traits].value.shape[1] == 4
    path = world.save(tmp_path / "checkpoint")
    other = World.restore(path, record=False, trust=True)
    fork = world.fork(seed=9)
    assert other.run(20).digest() == world.run(20).digest()
    assert fork.run(20).digest() != world.digest()
    with pytest.raises(ConfigError, match="the gene basal codes for it"):
        world.reconfigure(
            herd(genome=genome(*genes), metabolism=HERD["species"]["goat"]["metabolism"] | {"basal": 0.005})
        )
    world.reconfigure(
        herd(genome=genome(*genes), metabolism=HERD["species"]["goat"]["metabolism"] | {"handling_time": 2.0})
    )
    world.run(5)
    assert (table[Metabolism].digesting[table.rows()] > 0).any()
