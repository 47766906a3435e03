"""The `happiness` world: it lives, and its genes are the weights of its voles' happiness."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Defence, Genome, Growth, HappinessWeights, Nervous, Policy
from ecs_eco.config import load
from ecs_eco.config.shipped import shipped

SMALL = {
    "space.size": [60.0, 60.0],
    "species.vole.count": 150,
    "species.berry.count": 320,
    "species.nightshade.count": 30,
}
READINGS = ("energy", "berry_near", "nightshade_near", "vole_near")


@pytest.fixture(scope="module")
def world():
    return World.from_config(load("happiness", SMALL), seed=1).run(300)


def test_the_world_is_shipped_and_lives_300_ticks(world):
    assert "happiness" in shipped()
    series = world.series().to_pydict()
    voles = [i for i, s in enumerate(series["species"]) if s == "vole"]
    total = {k: sum(series[k][i] for i in voles) for k in series if k == "births" or k.startswith("died: ")}
    assert min(series["n"][i] for i in voles) > 20
    assert total["births"] > 200
    assert all(total[f"died: {cause}"] > 0 for cause in ("starved", "poisoned by nightshade", "too old"))


def test_the_weights_of_happiness_are_what_the_genes_say(world):
    vole = world.tables["vole"]
    rows = vole.rows()[vole.born[vole.rows()] > 0]
    decoded = vole.species.heredity.layout.decode(vole[Genome].loci[rows])
    assert rows.size > 20
    for i, gene in enumerate(("energy", "berry", "nightshade", "vole")):
        assert np.array_equal(vole[HappinessWeights].weight[rows, i], decoded[gene])
        assert -1 <= decoded[gene].min() < decoded[gene].max() <= 1


def test_voles_are_happy_about_what_they_sense_as_their_own_weights_say(world):
    vole = world.tables["vole"]
    nerves, weight = vole.species.nerves, vole[HappinessWeights].weight
    # not who was born since, in the row of a dead
    rows = nerves.rows[vole.alive[nerves.rows] & vole[Nervous].awake[nerves.rows]]
    x = {int(row): i for i, row in enumerate(nerves.rows)}
    at = [x[int(row)] for row in rows]
    wanted = sum(weight[rows, i] * nerves.reading(name, nerves.x)[at] for i, name in enumerate(READINGS))
    assert np.allclose(vole[Nervous].happiness[rows], np.maximum(wanted, -4), atol=1e-6)


def test_what_a_vole_learned_dies_with_it():
    world, alike = World.from_config(load("happiness", SMALL), seed=2), []
    vole = world.tables["vole"]

    def born(table, rows, first, second):
        if table is vole:
            assert not table[Policy].updates[rows].any()
            parents = [np.flatnonzero(table.uid[: table.high] == uid) for uid in first]
            alike.extend(
                (table[Policy].weights[int(row)] == table[Policy].weights[int(p[0])]).mean()
                for row, p in zip(rows, parents, strict=True)
                if p.size
            )

    world.on_birth.append(born)
    world.run(120)
    assert vole[Policy].updates[vole.rows()].max() >= 7  # 120 ticks, 16 in a rollout
    assert len(alike) > 20
    assert max(alike) < 0.1


def test_what_berries_are_is_what_their_genes_say(world):
    berry = world.tables["berry"]
    rows = berry.rows()
    decoded = berry.species.heredity.layout.decode(berry[Genome].loci[rows])
    for gene, column in (
        ("tough", berry[Defence].toughness),
        ("poison", berry[Defence].poison),
        ("spread", berry[Growth].spread),
    ):
        assert np.array_equal(column[rows], decoded[gene])
        assert len(np.unique(decoded[gene])) > 8


def test_where_genes_say_nothing_voles_have_the_declared_weights():
    vole = (
        World.from_config(load("happiness", SMALL), seed=1, controls=("neutral-drift",))
        .run(60)
        .tables["vole"]
    )
    assert np.array_equal(np.unique(vole[HappinessWeights].weight[vole.rows()], axis=0), [[0.5, 0, 0, 0]])
