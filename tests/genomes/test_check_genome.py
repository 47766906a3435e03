"""What is wrong with a species' genome is said before the first tick, with its key."""

import copy

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.config.checks.genome import check_genome
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.traits import traits_of
from ecs_eco.engine.errors import ConfigError
from ecs_eco.genomes import Gene, Layout, layout_of, operators_of
from ecs_eco.genomes.codes import Range
from ecs_eco.testing import check_genome as check_layout

GOAT = {
    "count": 10,
    "body": {"radius": 0.4},
    "locomotion": {"speed": {"sit": 0.0, "hop": 1.0}, "turn": 0.8},
    "diet": [{"eats": "goat", "gain": 0.1}],
    "sensors": [
        {"kind": "own", "property": "energy"},
        {"kind": "nearest", "name": "eye", "target": "goat", "range": 5.0},
    ],
    "actions": {"speed": ["sit", "hop"], "eat": ["eat"]},
    "reflex": {
        "connections": [{"name": "red", "sensor": "eye_near", "action": "eat", "weight": -1, "above": 0.5}]
    },
    "reproduction": {
        "kind": "asexual",
        "rate": 0.01,
        "energy_min": 0.6,
        "energy_given": 0.3,
        "dispersal": 2.0,
    },
    "genome": {
        "mate": {"operator": "cxUniform", "chance": 0.9, "indpb": 0.5},
        "mutate": {"operator": "mutUniformInt", "indpb": 0.005},
        "genes": [
            {"name": "red", "trait": "reflex.red.weight", "letters": 1, "values": [0, 0, 0, -1]},
            {"name": "size", "trait": "body.radius", "letters": 4, "low": 0.2, "high": 0.6, "code": "gray"},
        ],
    },
}


def world(change=lambda goat: None) -> WorldConfig:
    goat = copy.deepcopy(GOAT)
    change(goat)
    return WorldConfig.model_validate(
        {"format": 1, "name": "w", "space": {"size": [50.0, 40.0]}, "species": {"goat": goat}}
    )


def gene(number: int, **values):
    return lambda goat: goat["genome"]["genes"][number].update(values)


def test_a_right_genome_has_no_problems_and_makes_a_layout() -> None:
    config = world()
    assert list(check_genome(config, "goat")) == []
    goat = config.species["goat"]
    layout = layout_of(goat.genome, traits_of(goat, 2))
    check_layout(layout)
    births = operators_of(goat.genome, layout)
    assert births.chance == 0.9
    assert births.toolbox.mate.keywords == {"indpb": 0.5}
    assert layout["red"].trait.component == "Reflexes"
    assert layout.decode(layout.own())["size"] == pytest.approx(0.4, abs=layout["size"].resolution)


def test_a_section_says_the_same_after_it_is_written_out() -> None:
    config = world()
    again = WorldConfig.model_validate(config.resolved())
    assert again.config_hash == config.config_hash
    assert again.species["goat"].genome.mate.arguments == {"indpb": 0.5}


def test_a_species_without_genome_is_fine() -> None:
    assert list(check_genome(world(lambda goat: goat.pop("genome")), "goat")) == []


def operator(word: str, **values):
    return lambda goat: goat["genome"].update({word: values})


def two_of_a_name(goat: dict) -> None:
    goat["reflex"]["connections"] *= 2


def larger_than_own(goat: dict) -> None:
    goat["genome"]["founders"] = "own"
    gene(1, low=0.45)(goat)


def inherit(how: str):
    def change(goat: dict) -> None:
        goat |= {
            "policy": {"kind": "individual", "inherit": how},
            "happiness": {"weights": {"energy": 1.0}, "minimum": 0.0},
        }
        if how == "learned":
            brain = {"name": "brain", "trait": "policy.weights", "letters": 2, "low": -2.0, "high": 2.0}
            goat["genome"]["genes"].append(brain | {"form": "cosine", "coefficients": 5})

    return change


WRONG = [
    (gene(0, trait="reflex.rad.weight"), "genome.genes.0.trait", "reflex.red.weight"),
    (gene(0, values=[0, -1]), "genome.genes.0.values", "has 4; expected: 4 numbers"),
    (gene(1, low=0.7), "genome.genes.1.low", "less than 0.6"),
    (gene(1, at=0), "genome.genes.1.at", "overlaps the gene red"),
    (gene(1, high=30.0), "genome.genes.1.high", "at most 20 m"),
    (
        gene(1, trait="sensors.eye.range", high=21.0),
        "genome.genes.1.high",
        "larger than half the width of the torus",
    ),
    (gene(1, trait="reproduction.energy_min", high=2.0), "genome.genes.1.high", "at most 1"),
    (lambda goat: goat["genome"].update(loci=4), "genome.loci", "at least 5"),
    (larger_than_own, "genome.genes.1.trait", "cannot code for the species' value, 0.4"),
    (operator("mate", operator="cxBlend"), "genome.mate.operator", "numbers between letters"),
    (operator("mate", operator="cxTwoPont"), "genome.mate.operator", "cxTwoPoint"),
    (operator("mutate", operator="mutUniformInt"), "genome.mutate.operator", "indpb"),
    (operator("mutate", operator="mutFlipBit", indpb=0.1), "genome.mutate.operator", "4 letters"),
    (two_of_a_name, "reflex.connections.1.name", "a unique name"),
    (inherit("birth"), "policy.inherit", "no gene codes for policy.weights"),
    (inherit("learned"), "policy.inherit", "also codes for policy.weights"),
]


@pytest.mark.parametrize(("change", "key", "words"), WRONG, ids=[f"{k} {w[:20]}" for _, k, w in WRONG])
def test_what_is_wrong_is_said_with_its_key(change, key: str, words: str) -> None:
    problems = list(check_genome(world(change), "goat"))
    assert [p.path for p in problems] == [f"species.goat.{key}"]
    assert words in str(problems[0])


ASEXUAL = {"kind": "asexual", "rate": 0.5, "energy_min": 0.1, "energy_given": 0.05}


@pytest.mark.parametrize(
    ("reproduction", "mate"),
    [
        (ASEXUAL, {}),
        (ASEXUAL | {"kind": "asexual", "place": "anywhere"}, {}),
        (None, {"operator": "cxOnePoint"}),
        ({"kind": "sexual", "energy_min": 0.1, "energy_given": 0.05, "reach": 1.0}, {"chance": 0.0}),
    ],
)
def test_an_operator_that_crosses_nothing_need_not_fit_the_genome(reproduction, mate) -> None:
    genome = {"genes": [{"name": "one", "letters": 1, "low": 0.0, "high": 1.0}], "mate": mate}
    moss = {
        "count": 9,
        "body": {"radius": 0.2},
        "metabolism": {"energy": 0.5, "energy_max": 1.0},
        "reproduction": reproduction,
        "genome": genome,
    }
    data = {"format": 1, "name": "moss", "space": {"size": [20.0, 20.0]}, "species": {"moss": moss}}
    assert World.from_config(data).run(2).table("moss").n
    genome["mate"] = mate | {"operator": "cxTwoPont"}
    with pytest.raises(ConfigError, match="cxTwoPoint"):
        load(data)


def test_a_brain_in_the_genome_has_as_many_codons_as_the_form_says() -> None:
    config = world(inherit("learned"))
    goat = config.species["goat"]
    from ecs_eco.config.shapes import policy_shapes

    layout = layout_of(goat.genome, traits_of(goat, 2), policy_shapes(goat, 2))
    assert (layout["brain"].codons.n, layout["brain"].width) == (
        6 * 5,
        ((4 * 64 + 64) + (64 * 64 + 64) + (64 * 5 + 5),),
    )


def test_a_gene_is_refused_whose_values_a_feature_refuses() -> None:
    def fat(goat: dict) -> None:
        goat["growth"] = {"rate": 0.01, "cost": 0.1, "reserve": 0.5}
        reserve = {"name": "thrift", "trait": "growth.reserve", "letters": 3, "low": 0.0, "high": 3.0}
        goat["genome"]["genes"].append(reserve)

    (problem,) = check_genome(world(fat), "goat")
    assert problem.key == ("species", "goat", "genome", "genes", 2, "high")
    assert "growth.reserve: at least energy_max" in problem.what


@pytest.mark.parametrize("letters", ["A", "AA", "ACGTA"])
def test_an_alphabet_has_at_least_two_letters_each_once(letters: str) -> None:
    with pytest.raises(ValueError, match="alphabet"):
        world(lambda goat: goat["genome"].update(alphabet=letters))


def test_the_conformance_check_finds_a_code_that_forgets(monkeypatch: pytest.MonkeyPatch) -> None:
    layout = Layout([Gene(name="g", letters=3, low=0, high=1)])
    check_layout(layout)
    right = Range.numbers
    monkeypatch.setattr(Range, "numbers", lambda self, values, clip: right(self, values, clip) // 2)
    with pytest.raises(AssertionError, match=r"gene 'g': encoding and decoding changes .* to"):
        check_layout(layout)


def test_the_conformance_check_finds_values_beyond_the_range_and_rows_that_mix(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    layout = Layout([Gene(name="g", letters=3, low=0, high=1)])
    right = Range.values
    monkeypatch.setattr(Range, "values", lambda self, numbers: right(self, numbers) + 1)
    with pytest.raises(AssertionError, match="beyond 0 to 1"):
        check_layout(layout)
    monkeypatch.setattr(Range, "values", lambda self, numbers: right(self, np.sort(numbers, axis=0)))
    with pytest.raises(AssertionError, match="depend on the other genomes"):
        check_layout(layout)


@pytest.mark.parametrize(
    ("trait", "reason"),
    [
        ("max_count", "it counts organisms"),
        ("body.density", "it determines the mass"),
        ("reproduction.immigration", "organisms without parents"),
    ],
)
def test_what_no_gene_can_code_for_is_refused_with_the_reason(trait, reason) -> None:
    (problem,) = check_genome(world(gene(1, trait=trait)), "goat")
    assert problem.path == "species.goat.genome.genes.1.trait"
    assert problem.what.startswith("no gene can code for it: ")
    assert reason in problem.what
    assert problem.value == trait
    assert problem.nearest == ""


def test_a_misspelt_trait_has_the_nearest_right_name() -> None:
    (problem,) = check_genome(world(gene(1, trait="body.radios")), "goat")
    assert (problem.what, problem.nearest) == ("the species has no such trait", "body.radius")
