"""Whether a formula rises or falls with what it reads."""

from __future__ import annotations

import numpy as np
import pytest

from ecs_eco.analysis.formula_signs import directions, pushes
from ecs_eco.config import compile_formula


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("energy - 0.3 * smell", {"energy": 1, "smell": -1}),
        ("-tanh(2 * x)", {"x": -1}),
        ("x * smell", {"x": 1, "smell": None}),
        ("1 / (1 + smell)", {"smell": -1}),
        ("x ** 2", {"x": None}),
        ("smell ** 2", {"smell": 1}),
        ("x ** 3", {"x": 1}),
        ("abs(x)", {"x": None}),
        ("x > 0.5", {"x": 1}),
        ("0.1 < x < 0.5", {"x": None}),
        ("x == 1", {"x": None}),
        ("not (x > 0.5)", {"x": -1}),
        ("not x", {"x": None}),
        ("-1 if x < 0.5 else 0", {"x": 1}),
        ("x - x", {"x": None}),
        ("min(x, 3) - max(smell, 0.5)", {"x": 1, "smell": -1}),
    ],
)
def test_a_formula_rises_or_falls_with_a_reading(text: str, wanted: dict[str, int | None]) -> None:
    assert directions(text, {"smell", "energy"}) == wanted


FORMULAS = (
    "a * b - c",
    "clip(c, -1, b)",
    "b / (a + 1) + c * c",
    "-a ** 2 * (c > 0)",
    "(a > 0.4) * (b < 0.6) - abs(a)",
    "max(a, c) - exp(-b)",
    "c if a > 0.5 else b",
    "sqrt(a) * -b",
    "1 if c < 0 else -2",
    "a / c",
    "(a - c) * (b - 2)",
    "a and c > 0",
    "not a",
    "not c",
    "2 * (not c < b)",
)


@pytest.mark.parametrize("text", FORMULAS)
def test_what_is_said_of_a_formula_is_true_of_its_numbers(text: str) -> None:
    """a and b are never below 0, c may be; a sign that is told must hold between any two values of a grid."""
    grid = {"a": np.linspace(0, 1, 9), "b": np.linspace(0, 1, 9), "c": np.linspace(-1, 1, 9)}
    formula = compile_formula(text, grid)
    a, b, c = np.meshgrid(*grid.values(), indexing="ij")
    value = formula({"a": a, "b": b, "c": c})
    for name, sign in directions(text, {"a", "b"}).items():
        if sign is not None:
            steps = np.diff(value, axis="abc".index(name))
            assert (sign * steps[np.isfinite(steps)] >= -1e-6).all(), name


def test_in_a_reflex_a_term_pushes_the_way_that_it_counts() -> None:
    signs = pushes("(energy < 0.3) - 2 * (wolf > 0.5) + x * wolf", {"wolf", "energy"})
    assert signs == {"energy": 1, "wolf": None, "x": 1}
    assert pushes("-1 if lips > 0.3 and energy < 0.5 else 0", set()) == {"lips": -1, "energy": -1}
