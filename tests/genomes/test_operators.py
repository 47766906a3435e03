"""Operators of DEAP in a toolbox: which work on genomes, and what is said of those that do not."""

import random
from functools import partial

import numpy as np
import pytest
from deap import tools
from deap.base import Toolbox

from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError, UnknownName
from ecs_eco.genomes import CHOICES, Gene, Layout, Operators, layout_of, operators_of, toolbox_of
from ecs_eco.genomes.choices import RULES
from ecs_eco.genomes.models import GenomeSection
from ecs_eco.genomes.operators import choice_of

LAYOUT = Layout([Gene(name="g", letters=4, low=0, high=1)])
BITS = Layout([Gene(name="g", letters=4, low=0, high=1)], "01")
WELL = {"operator": "mutUniformInt", "indpb": 0.1}


def lengthen(genome: list[int]) -> tuple[list[int]]:
    return ([*genome, 0],)


def forget_the_tuple(genome: list[int]) -> list[int]:
    return genome


def use_numpy(genome: list[int]) -> tuple[list[int]]:
    genome[0] = int(np.random.randint(4))  # noqa: NPY002
    return (genome,)


def need_fitness(genome: list[int]) -> tuple[list[int]]:
    return (genome.fitness,)  # type: ignore[attr-defined]


def reverse(genome: list[int]) -> tuple[list[int]]:
    return (genome[::-1],)


def test_a_toolbox_has_what_the_section_says() -> None:
    toolbox = toolbox_of({"mate": {"operator": "cxUniform", "indpb": 0.3}, "mutate": WELL}, LAYOUT, "richest")
    assert (toolbox.mate.func, toolbox.mate.keywords) == (tools.cxUniform, {"indpb": 0.3})
    assert (toolbox.mutate.func, toolbox.mutate.keywords) == (
        tools.mutUniformInt,
        {"low": 0, "up": 3, "indpb": 0.1},
    )
    assert choice_of(toolbox) == 2


def test_a_section_without_operators_has_two_point_crossover_and_uniform_mutation() -> None:
    section = GenomeSection(genes=[Gene(name="g", letters=4, low=0, high=1)])
    births = operators_of(section, layout_of(section))
    assert births.toolbox.mate.func is tools.cxTwoPoint
    assert births.toolbox.mutate.keywords == {"low": 0, "up": 3, "indpb": 0.005}
    assert (births.chance, births.choice) == (1.0, 0)


REFUSED = [
    ("mate", {"operator": "cxBlend", "alpha": 0.1}, "numbers between letters"),
    ("mate", {"operator": "cxSimulatedBinary", "eta": 1.0}, "numbers between letters"),
    ("mate", {"operator": "cxMessyOnePoint"}, "changes the length"),
    ("mate", {"operator": "cxOrdered"}, "every letter once"),
    ("mate", {"operator": "cxPartialyMatched"}, "every letter once"),
    ("mate", {"operator": "cxESBlend", "alpha": 0.1}, "strategy"),
    ("mate", {"operator": "cxUniform"}, "missing a required argument: 'indpb'"),
    ("mate", {"operator": "cxUniform", "indpd": 0.5}, 'did you mean "indpb"'),
    ("mate", {"operator": "cxUniform", "indpb": 2.0}, "indpb = 2.0; expected 0 to 1"),
    ("mutate", {"operator": "mutGaussian", "mu": 0.0, "sigma": 1.0, "indpb": 0.1}, "numbers between letters"),
    ("mutate", {"operator": "mutPolynomialBounded"}, "numbers between letters"),
    ("mutate", {"operator": "mutESLogNormal", "c": 1.0, "indpb": 0.1}, "strategy"),
    ("mutate", {"operator": "mutFlipBit", "indpb": 0.1}, "'ACGT' has 4 letters; use mutUniformInt"),
    ("mutate", WELL | {"up": 4}, "up = 4; expected 0 to 3"),
    ("mutate", {"operator": "mutUniformInt"}, "missing a required argument: 'indpb'"),
]


@pytest.mark.parametrize(
    ("word", "entry", "reason"), REFUSED, ids=[e["operator"] + str(i) for i, (_, e, _) in enumerate(REFUSED)]
)
def test_an_operator_that_cannot_work_on_letters_is_refused_with_the_reason(
    word: str, entry: dict, reason: str
) -> None:
    with pytest.raises(ValueError, match=reason) as caught:
        toolbox_of({"mutate": WELL, word: entry}, LAYOUT)
    assert str(caught.value).startswith(f"{word}: {entry['operator']}")


def test_every_operator_of_deap_works_or_is_refused() -> None:
    more = {
        "cxUniform": {"indpb": 0.5},
        "mutUniformInt": {"indpb": 0.5},
        "mutFlipBit": {"indpb": 0.5},
        "mutShuffleIndexes": {"indpb": 0.5},
    }
    work, refused = set(), []
    for name in [n for n, f in vars(tools).items() if n.startswith(("cx", "mut")) and callable(f)]:
        word = "mate" if name.startswith("cx") else "mutate"
        try:
            toolbox_of({"mutate": WELL, word: {"operator": name, **more.get(name, {})}}, BITS)
            work.add(name)
        except ValueError as error:
            refused.append(str(error))
    assert [text for text in refused if "does not work on genomes" not in text] == []
    assert work == {
        "cxOnePoint",
        "cxTwoPoint",
        "cxUniform",
        "mutUniformInt",
        "mutFlipBit",
        "mutShuffleIndexes",
        "mutInversion",
    }


def test_an_unknown_operator_is_told_the_nearest() -> None:
    with pytest.raises(UnknownName, match='did you mean "cxTwoPoint"'):
        toolbox_of({"mate": {"operator": "cxTwoPont"}, "mutate": WELL}, LAYOUT)


OWN = [
    (lengthen, "returns a genome of 5 loci; expected 4"),
    (forget_the_tuple, "returns list .* expected a tuple of one genome"),
    (use_numpy, "numpy's global random numbers"),
    (need_fitness, "fails on a list of letter numbers: AttributeError"),
    (lambda genome: ([0.5] * 4,), "puts 0.5, which is not a letter, at position 0"),
    (lambda genome: ([0, -1, 0, 0],), "puts -1, which is not a letter, at position 1"),
]


@pytest.mark.parametrize(("function", "reason"), OWN, ids=[f.__name__ for f, _ in OWN])
def test_a_function_of_ones_own_that_makes_no_genomes_is_refused_before_any_birth(
    function, reason: str
) -> None:
    toolbox = toolbox_of({"mutate": WELL}, LAYOUT)
    toolbox.register("mutate", function)
    state = random.getstate()
    with pytest.raises(ValueError, match=reason):
        Operators(toolbox, LAYOUT)
    assert random.getstate() == state


def test_a_function_of_ones_own_works_handed_over_by_name_and_from_the_toolbox() -> None:
    parent = np.array([[0, 1, 2, 3]], np.uint8)
    toolbox = toolbox_of({"mutate": WELL}, LAYOUT)
    toolbox.register("mutate", reverse)
    assert Operators(toolbox, LAYOUT).offspring(parent, None, np.zeros(1, np.uint64)).tolist() == [
        [3, 2, 1, 0]
    ]
    handed = toolbox_of({"mutate": {"operator": reverse}}, LAYOUT)
    assert Operators(handed, LAYOUT).offspring(parent, None, np.zeros(1, np.uint64)).tolist() == [
        [3, 2, 1, 0]
    ]
    with pytest.raises(ConfigError, match="`code` does not list"):
        toolbox_of({"mutate": {"operator": "mine:reverse"}}, LAYOUT)
    named = toolbox_of(
        {"mutate": {"operator": "mine:reverse"}}, LAYOUT, find={"mine:reverse": reverse}.__getitem__
    )
    assert Operators(named, LAYOUT).offspring(parent, None, np.zeros(1, np.uint64)).tolist() == [[3, 2, 1, 0]]


def section(**operators) -> GenomeSection:
    return GenomeSection(genes=[Gene(name="g", letters=4, low=0, high=1)], **operators)


def turn(genome: list[int], places: int, back: bool = False) -> tuple[list[int]]:
    places = -places if back else places
    return (genome[places:] + genome[:places],)


def test_what_a_toolbox_has_registered_stands_for_the_section_with_its_arguments() -> None:
    toolbox = Toolbox()
    toolbox.register("mate", tools.cxUniform, indpb=0.1)
    toolbox.register("mutate", turn, places=1, back=True)
    given = section(mate=toolbox.mate, mutate=toolbox.mutate)
    assert (given.mate.operator, given.mate.arguments) == ("cxUniform", {"indpb": 0.1}), "as a file says it"
    births = operators_of(given, LAYOUT)
    assert (births.toolbox.mate.func, births.toolbox.mate.keywords) == (tools.cxUniform, {"indpb": 0.1})
    assert births.offspring(np.array([[0, 1, 2, 3]], np.uint8), None, np.zeros(1, np.uint64)).tolist() == [
        [3, 0, 1, 2]
    ]


def test_a_partial_and_a_function_may_stand_there_too_and_arguments_beside_it_add_to_its_own() -> None:
    assert section(mutate=reverse).mutate.operator is reverse
    given = section(
        mate={"operator": tools.cxOnePoint, "chance": 0.5},
        mutate={"operator": partial(turn, places=1), "back": True},
    )
    assert (given.mate.operator, given.mate.chance) == ("cxOnePoint", 0.5)
    assert (given.mutate.operator, given.mutate.arguments) == (turn, {"places": 1, "back": True})
    nested = partial(partial(tools.mutUniformInt, low=0, up=3), indpb=0.2)
    assert section(mutate=nested).mutate.arguments == {"low": 0, "up": 3, "indpb": 0.2}


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        (partial(tools.cxUniform, 0.1), r"cxUniform is registered with \(0.1,\); pass its arguments by name"),
        (
            {"operator": partial(tools.cxUniform, indpb=0.1), "indpb": 0.2},
            "indpb = 0.1 in the toolbox, but 0.2 in the section; .* toolbox.mate can",
        ),
    ],
)
def test_a_partial_that_leaves_open_what_it_says_is_refused(given, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        section(mate=given)


def test_a_world_takes_what_a_toolbox_has_registered_and_says_it_as_a_file_does() -> None:
    toolbox = Toolbox()
    toolbox.register("mate", tools.cxUniform, indpb=0.1)
    toolbox.register("mutate", tools.mutGaussian, mu=0, sigma=1, indpb=0.1)
    written = load("reflexes", {"species.goat.genome.mate": {"operator": "cxUniform", "indpb": 0.1}})
    assert load("reflexes", {"species.goat.genome.mate": toolbox.mate}).config_hash == written.config_hash
    with pytest.raises(
        ConfigError, match="mutGaussian does not work on genomes: it produces numbers between letters"
    ):
        load("reflexes", {"species.goat.genome.mutate": toolbox.mutate})


def test_a_decorated_operator_is_called_as_decorated() -> None:
    toolbox = toolbox_of({"mutate": WELL}, LAYOUT)
    toolbox.decorate("mutate", lambda inner: lambda genome, **arguments: ([2] * len(genome),))
    assert Operators(toolbox, LAYOUT).offspring(
        np.zeros((1, 4), np.uint8), None, np.zeros(1, np.uint64)
    ).tolist() == [[2, 2, 2, 2]]


def test_positional_arguments_are_refused() -> None:
    toolbox = toolbox_of({"mutate": WELL}, LAYOUT)
    toolbox.register("mutate", tools.mutUniformInt, 0, 3, 0.5)
    with pytest.raises(ValueError, match="pass its arguments by name"):
        Operators(toolbox, LAYOUT)


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        ({"operator": "mutInversion"}, "has no indpb"),
        ({"operator": "mutShuffleIndexes", "indpb": 0.1}, "moves letters from gene to gene"),
    ],
)
def test_a_gene_has_a_rate_of_its_own_only_where_the_operator_has_rates(entry: dict, reason: str) -> None:
    layout = Layout([Gene(name="g", letters=4, low=0, high=1, mutation=0.5)])
    with pytest.raises(ValueError, match=reason):
        toolbox_of({"mutate": entry}, layout)


def test_one_locus_cannot_be_cut() -> None:
    with pytest.raises(ValueError, match="cxTwoPoint needs at least two loci"):
        toolbox_of({"mutate": WELL}, Layout([Gene(name="g", letters=1, low=0, high=1)]))


@pytest.mark.parametrize(("rule", "best"), [("nearest", {8}), ("richest", {5, 7}), ("oldest", {9})])
def test_a_rule_chooses_and_of_equals_any(rule: str, best: set[int]) -> None:
    candidates, even = [9, 5, 8, 7], [1.0, 1.0, 1.0, 1.0]
    given = [2.0, 3.0, 1.0, 2.0], [0.1, 0.9, 0.2, 0.9], [7.0, 1.0, 2.0, 3.0]
    random.seed(1)
    assert {RULES[rule](1, candidates, *given) for _ in range(50)} == best
    assert {RULES[rule](1, candidates, even, even, even) for _ in range(100)} == set(candidates)


def test_a_random_mate_does_not_depend_on_the_order_of_the_list() -> None:
    drawn = set()
    for seed in range(50):
        pair = []
        for candidates in ([9, 5, 8], [5, 8, 9]):
            random.seed(seed)
            pair.append(RULES["random"](1, candidates, [1, 2, 3], [1, 2, 3], [1, 2, 3]))
        assert pair[0] == pair[1]
        drawn.add(pair[0])
    assert drawn == {5, 8, 9}


def test_rules_have_numbers_and_a_rule_of_ones_own_has_none() -> None:
    assert CHOICES == ("nearest", "random", "richest", "oldest")
    toolbox = toolbox_of({"mutate": WELL}, LAYOUT)
    for number, name in enumerate(CHOICES):
        toolbox.register("select_mate", RULES[name])
        assert choice_of(toolbox) == number
    toolbox.register("select_mate", lambda chooser, candidates, distance, energy, age: candidates[0])
    assert choice_of(toolbox) == -1
