"""A value that a gene codes for is what its owner lives by, whatever number of the species' section it is."""

from functools import cache

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Traits
from ecs_eco.config import load
from ecs_eco.config.numbers import with_value
from ecs_eco.config.traits import numbers_of_species, traits_of
from ecs_eco.testing import difference, state
from tests.worlds.own_worlds import ONLY, WORLDS

OWN = {name for name, number in numbers_of_species().items() if number.own is True}
TICKS = 24
MARKER = {"name": "marker", "letters": 1, "values": [0.0, 0.0]}
VALUES = {  # others are halved
    "lethal.temperature.min": 309.0,
    "lethal.temperature.max": 310.125,
    "lethal.energy.min": 0.5,
    "growth.store": 8.0,
    "metabolism.energy_max": 0.75,
    "heat.regulate.set_point": 300.0,
}


def pattern_of(trait):
    """The pattern of OWN that a trait's key has."""
    parts = trait.split(".")
    return next(
        (
            pattern
            for pattern in OWN
            if len(own := pattern.split(".")) == len(parts)
            and all(a in ("*", b) for a, b in zip(own, parts, strict=True))
        ),
        "",
    )


def cases():
    """Every number of these worlds that can be an organism's own: (world, species, key, pattern)."""
    for name, world in WORLDS.items():
        for kind, species in load(world).species.items():
            for trait, known in traits_of(species, 2).items():
                shown = trait.startswith(ONLY[name]) if name in ONLY else trait not in ONLY["desert"]
                if shown and known.default and known.component == "Traits" and (pattern := pattern_of(trait)):
                    yield pytest.param(name, kind, trait, pattern, id=f"{name}-{kind}-{trait}")


CASES = list(cases())


def living(config, kind, gene, value=None, trait=None):
    """A world of this configuration after some ticks; its species has a gene, or another value."""
    genome = {"alphabet": "01", "mate": {"operator": "cxUniform", "indpb": 0.5}, "genes": [gene]}
    species = config["species"] | {kind: config["species"][kind] | {"genome": genome}}
    loaded = load(config | {"species": species})
    if value is not None:
        changed = with_value(loaded.species[kind], tuple(trait.split(".")), value)
        loaded = loaded.model_copy(update={"species": loaded.species | {kind: changed}})
    return World.from_config(loaded, record=False).run(TICKS)


@cache
def usual(name, kind):
    """The world as its file says, with a gene that says nothing."""
    return state(living(WORLDS[name], kind, MARKER))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind", "trait", "pattern"), CASES)
def test_a_gene_that_says_one_value_makes_the_world_that_the_value_makes(name, kind, trait, pattern):
    own = traits_of(load(WORLDS[name]).species[kind], 2)[trait]
    value = VALUES.get(trait, own.default / 2) if kind == "beast" else own.default / 2
    value = int(value) if own.kind == "whole" else value
    by_key = state(living(WORLDS[name], kind, MARKER, value, trait))
    coded = living(WORLDS[name], kind, MARKER | {"trait": trait, "values": [value, value]})
    table = coded.tables[kind]
    assert (table[Traits].value[table.rows()] == np.float32(value)).all()
    assert table[Traits].value.shape[1] == 1
    assert difference(by_key, state(coded)) == ""
    assert difference(by_key, usual(name, kind)) != "", "nothing reads it here"


def test_every_number_that_can_be_an_organisms_own_is_tried():
    tried = {case.values[3] for case in CASES}
    assert sorted(OWN - tried) == []
