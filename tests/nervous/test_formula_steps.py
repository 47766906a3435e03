import numpy as np
import pytest

from ecs_eco.config import compile_formula
from ecs_eco.nervous.formula_steps import BLOCK, steps_of
from ecs_eco.nervous.networks import mean_of
from ecs_eco.systems.feel import feel

F = np.float32
READINGS = {"a": (0,), "b": (1, 2), "c": (3,), "d": (4, 5, 6), "Body_mass": (7,), "many": tuple(range(8))}
N = BLOCK + 70  # more than a block, and no whole number of them


@pytest.fixture
def x():
    x = np.random.default_rng(0).normal(size=(8, N)).astype(F)
    x[0, ::7], x[1, ::5], x[2, ::11], x[3, ::13], x[3, ::17] = 0, -0.0, np.nan, np.inf, -0.0
    return x


def felt(text, x, least):
    """What the kernel makes of a formula, with its steps."""
    happiness, other = np.zeros(N, F), (np.zeros(N, F), np.zeros(N, np.bool_))
    for first, last in ((0, 100), (100, N)):
        feel(first, last, np.arange(N), x, *steps_of(text, READINGS), F(least), happiness, *other)
    return happiness


@pytest.mark.parametrize(
    "text",
    [
        "a",
        "3",
        "-a",
        "a - 0.3 * b",
        "-a / c",
        "max(a, b, 0) * (5 * d - 7) - .1 * c",
        "min(-a, a, c)",
        "max(0, -a)",
        "1 - 2 * (a - (b - (c - d)))",
        "a / b / c",
        "(1 - 0.1) * a",
        "a / 0",
        "Body.mass - a",
        "1e38 * 10 * a",
        "clip(b, -c, 0.5)",
    ],
)
@pytest.mark.parametrize("least", [-1, 0, -np.inf])
def test_the_steps_of_a_formula_give_its_bits(x, text, least):
    formula = compile_formula(text, READINGS)
    slow = formula({name: mean_of(x.T, READINGS[name]) for name in formula.names} or {"a": x[0]})
    expected = np.maximum(slow, F(least))
    assert felt(text, x, least).tobytes() == expected.tobytes()


@pytest.mark.parametrize(
    "text", ["exp(a)", "a ** 2", "a > b", "a and b", "not a", "a if b else c", "abs(a)", "1 + many"]
)
def test_a_formula_with_what_has_no_step_has_none(text):
    compile_formula(text, READINGS)
    assert steps_of(text, READINGS) is None
