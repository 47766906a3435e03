"""Each kernel against DEAP's own function, called as DEAP calls it."""

import random

import numpy as np
import pytest
from deap import tools
from scipy.stats import chi2_contingency

from ecs_eco.genomes import kernels
from ecs_eco.genomes.operators import SAFE
from tests.genomes.births import ALPHA, layout_of, operators

MATINGS = 100_000
# all that run as kernels: the operator's arguments, the alphabet, and what a wrong twin of it gets wrong
TWINS = {
    "cxOnePoint": (
        {},
        "01",
        ("cross_points", lambda a: (a[0][:, :-1], a[1][:, :-1], *a[2:-1], a[-1][:, :-1])),
    ),
    "cxTwoPoint": (
        {},
        "01",
        ("cross_points", lambda a: (a[0][:, :-1], a[1][:, :-1], *a[2:-1], a[-1][:, :-1])),
    ),
    "cxUniform": ({"indpb": 0.3}, "01", ("cross_uniform", lambda a: (*a[:6], np.float32(a[6] + 0.01), a[7]))),
    "mutUniformInt": ({"low": 0, "up": 2, "indpb": 0.3}, "ACG", ("mutate", lambda a: (*a[:6], a[6] - 1))),
    "mutFlipBit": ({"indpb": 0.3}, "01", ("mutate", lambda a: (*a[:4], a[4] + 0.01, *a[5:]))),
    # with itself, too
    "mutShuffleIndexes": ({"indpb": 0.3}, "ACGT", ("mutate", lambda a: (*a[:4], a[4] * 7 / 8, *a[5:]))),
}


def by_the_twin(name: str) -> np.ndarray:
    """Children u8[MATINGS, 8] of the kernel that stands for an operator."""
    arguments, letters, _ = TWINS[name]
    layout, keys = layout_of(8, letters), np.arange(MATINGS, dtype=np.uint64)
    first = np.zeros((MATINGS, 8), np.uint8) + (
        np.arange(8, dtype=np.uint8) % len(letters) if name.startswith("mut") else np.uint8(0)
    )
    given = getattr(tools, name), arguments
    if name.startswith("cx"):
        return operators(layout, given, None).offspring(first, first + 1, keys)
    return operators(layout, None, given).offspring(first, None, keys)


def by_deap(name: str) -> np.ndarray:
    """Children u8[MATINGS, 8] of DEAP's own function; of a crossing the first,
    the parents' order being drawn."""
    arguments, letters, _ = TWINS[name]
    function, children = getattr(tools, name), np.empty((MATINGS, 8), np.uint8)
    state = random.getstate()
    random.seed(1)
    for birth in range(MATINGS):
        if name.startswith("cx"):
            one = random.randrange(2)
            children[birth] = function([one] * 8, [1 - one] * 8, **arguments)[0]
        else:
            children[birth] = function([i % len(letters) for i in range(8)], **arguments)[0]
    random.setstate(state)
    return children


def chance_that_both_are_alike(one: np.ndarray, other: np.ndarray, size: int) -> float:
    """Return p of a chi-square test of all patterns of eight letters,
    those seen fewer than twenty times put together."""
    weights = size ** np.arange(8)
    _, number = np.unique(np.concatenate([one @ weights, other @ weights]), return_inverse=True)
    table = np.array([np.bincount(half, minlength=number.max() + 1) for half in np.split(number, 2)])
    rare = table.sum(axis=0) < 20
    table = np.concatenate([table[:, ~rare], table[:, rare].sum(axis=1, keepdims=True)], axis=1)
    return chi2_contingency(table[:, table.sum(axis=0) > 0]).pvalue


@pytest.mark.parametrize("name", TWINS)
def test_a_twin_makes_what_deaps_own_function_makes_and_a_wrong_twin_is_found_out(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, letters, (kernel, wrong) = TWINS[name]
    deaps = by_deap(name).astype(np.int64)
    assert chance_that_both_are_alike(by_the_twin(name).astype(np.int64), deaps, len(letters)) > 0.001
    right = getattr(kernels, kernel)

    def mistaken(*arguments) -> None:
        if kernel == "cross_points":  # it never cuts before the last letter
            arguments[-1][:, -1] = np.where(arguments[2], arguments[1][:, -1], arguments[0][:, -1])
        right(*wrong(arguments))

    monkeypatch.setattr(kernels, kernel, mistaken)
    assert chance_that_both_are_alike(by_the_twin(name).astype(np.int64), deaps, len(letters)) < ALPHA


def test_every_operator_of_the_closed_list_is_a_twin_or_deaps_own() -> None:
    assert {name for names in SAFE.values() for name in names} - set(TWINS) == {"mutInversion"}
