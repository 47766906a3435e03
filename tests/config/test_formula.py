"""The language of formulas: what they are worth, by a scalar twin, and what is refused."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ecs_eco.config import FormulaError, compile_formula

NAMES = ("a", "b", "energy")
BINARY = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
    "and": lambda x, y: x != 0 and y != 0,
    "or": lambda x, y: x != 0 or y != 0,
}


def twin(tree: Any, values: dict[str, float]) -> np.float32:
    """One number at a time, the obvious way: float32 after every operation."""
    if isinstance(tree, float):
        return np.float32(tree)
    if isinstance(tree, str):
        return np.float32(values[tree])
    head, *rest = tree
    read = [twin(part, values) for part in rest]
    if head in BINARY:
        return np.float32(BINARY[head](*read))
    if head == "if":
        return read[1] if read[0] != 0 else read[2]
    if head == "clip":
        return np.float32(min(max(read[0], read[1]), read[2]))
    single = {
        "neg": operator.neg,
        "not": lambda x: x == 0,
        "abs": abs,
        "tanh": np.tanh,
        "min": min,
        "max": max,
    }
    return np.float32(single[head](*read))


def write(tree: Any) -> str:
    if isinstance(tree, float | str):
        return repr(tree) if isinstance(tree, float) else tree
    head, *rest = tree
    parts = [write(part) for part in rest]
    if head in BINARY:
        return f"({parts[0]} {head} {parts[1]})"
    if head == "if":
        return f"({parts[1]} if {parts[0]} else {parts[2]})"
    if head in ("neg", "not"):
        return f"({'-' if head == 'neg' else 'not '}{parts[0]})"
    return f"{head}({', '.join(parts)})"


NUMBERS = st.floats(-8, 8, width=16)
TREES = st.recursive(
    st.sampled_from(NAMES) | st.floats(0, 8, width=16),
    lambda inner: (
        st.tuples(st.sampled_from([*BINARY, "min", "max"]), inner, inner)
        | st.tuples(st.sampled_from(["neg", "not", "abs", "tanh"]), inner)
        | st.tuples(st.sampled_from(["if", "clip"]), inner, inner, inner)
    ),
    max_leaves=12,
)


@given(TREES, st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS), min_size=1, max_size=5))
def test_formulas_agree_with_a_scalar_twin(tree: Any, rows: list[tuple[float, float, float]]) -> None:
    values = {name: np.array([row[i] for row in rows], np.float32) for i, name in enumerate(NAMES)}
    values_of = compile_formula(write(tree), NAMES)(values)
    expected = [twin(tree, dict(zip(NAMES, row, strict=True))) for row in rows]
    assert values_of.dtype == np.float32
    assert values_of.shape == (len(rows),)
    np.testing.assert_allclose(values_of, expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2 ** 3 - 1 / 4", 7.75),
        ("-2 ** 2", -4.0),
        ("1 < 2 < 3", 1.0),
        ("1 < 3 < 2", 0.0),
        ("exp(0) + log(1) + sqrt(9)", 4.0),
        ("2 and 3", 1.0),
        ("min(3, 1, 2) + max(1, 2)", 3.0),
        ("1 if a > 1\n else 0", 1.0),
        ("  a + \n b", 5.0),
        ("1 / 0", math.inf),
    ],
)
def test_formulas_have_the_usual_values(text: str, value: float) -> None:
    values_of = compile_formula(text, ("a", "b"))({"a": np.full(2, 2.0), "b": np.full(2, 3.0)})
    assert values_of.tolist() == [value, value]


def test_a_formula_knows_which_names_it_uses() -> None:
    formula = compile_formula("a + 2 * a", ("a", "b"))
    assert formula.names == {"a"}
    assert formula({"a": np.ones((2, 3))}).shape == (2, 3)


@pytest.mark.parametrize(
    ("text", "position", "word", "near"),
    [
        ("energi + 1", 1, "energi", "energy"),
        ("1 + enrgy", 5, "enrgy", "energy"),
        ("é + 1", 1, "é", ""),
        ("1 + 2 + (a).b", 9, "attribute", "b"),
        ("1 + (2 + a).b", 5, "attribute", ""),
        ("__import__('os')", 1, "__import__", ""),
        ("a[0]", 1, "subscript", ""),
        ("lambda: 1", 1, "lambda", ""),
        ("[a for a in b]", 1, "listcomp", ""),
        ("(a := 1)", 2, "namedexpr", ""),
        ("'text'", 1, "text", ""),
        ("True", 1, "True", ""),
        ("1e99", 1, "1e+99", ""),
        ("1j", 1, "1j", ""),
        ("a // b", 1, "floordiv", ""),
        ("a in b", 1, "in", ""),
        ("abs(a, b)", 1, "2 arguments for abs", ""),
        ("max(a)", 1, "1 arguments for max", ""),
        ("min(a, b, key=a)", 1, "arguments for min", ""),
        ("max(*a)", 1, "arguments for max", ""),
        ("a +", 4, "not an expression", ""),
        ("", 1, "not an expression", ""),
        ("a = 1", 3, "not an expression", ""),
        ("a; b", 2, "not an expression", ""),
        ("a" * 2000, 1000, "too long", ""),
        ("(" * 300 + "a" + ")" * 300, 1, "", ""),
        ("-" * 900 + "a", 1, "", ""),
    ],
)
def test_what_is_no_formula_is_refused_with_its_place(text: str, position: int, word: str, near: str) -> None:
    with pytest.raises(FormulaError) as caught:
        compile_formula(text, NAMES)
    assert word in caught.value.what
    assert caught.value.nearest == near
    if word:
        assert caught.value.position == position
