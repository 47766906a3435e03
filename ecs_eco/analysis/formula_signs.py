"""The sign of a reading's effect on a formula: +1, −1, 0 for none, None: it depends.

It is read off the formula's numbers, at readings drawn at random and around every number of its text.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable

import numpy as np

from ecs_eco.config.formula import Compiler

Sign = int | None
DRAWS = 512  # of the other readings, for each value of one
ROUNDING = 1e-5  # of a value: smaller steps are float32's


def directions(text: str, positive: Collection[str]) -> dict[str, Sign]:
    """For each name of a formula whether it rises (+1) or falls (−1) with it;
    `positive` are the names never below 0."""
    tree = _parsed(text)
    return {name: _direction(tree, name, positive) for name in _names(tree)}


def pushes(text: str, positive: Collection[str]) -> dict[str, Sign]:
    """For each name of a reflex formula, the sign of the terms of the sum that it is in.

    A term that is never below 0, such as `energy < 0.3`, has the sign +1;
    other terms have that of their direction.
    """
    tree = _parsed(text)
    return {
        name: _one(
            _push(term, name, positive, sign) for sign, term in _terms(tree, 1) if name in _names(term)
        )
        for name in _names(tree)
    }


def _parsed(text: str) -> ast.expr:
    return _Fields().visit(ast.parse(" ".join(text.split()), mode="eval")).body


class _Fields(ast.NodeTransformer):
    """Puts the name of its channel in the place of Component.field."""

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        if not isinstance(node.value, ast.Name):
            return node
        return ast.copy_location(ast.Name(f"{node.value.id}_{node.attr}"), node)


def _names(tree: ast.AST) -> list[str]:
    """The readings that an expression names, once each, in the order of the text."""
    called = {id(n.func) for n in ast.walk(tree) if isinstance(n, ast.Call)}
    nodes = [n for n in ast.walk(tree) if isinstance(n, ast.Name) and id(n) not in called]
    return list(dict.fromkeys(n.id for n in sorted(nodes, key=lambda n: n.col_offset)))


def _terms(tree: ast.expr, sign: int) -> list[tuple[int, ast.expr]]:
    """The terms of a sum with their signs."""
    if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.Add | ast.Sub):
        return _terms(tree.left, sign) + _terms(tree.right, sign if isinstance(tree.op, ast.Add) else -sign)
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
        return _terms(tree.operand, -sign)
    return [(sign, tree)]


def _one(signs: Iterable[Sign]) -> Sign:
    """The sign that some have in common, besides those of no effect."""
    distinct = set(signs) - {0}
    return 0 if not distinct else distinct.pop() if len(distinct) == 1 else None


def _signs(numbers: np.ndarray) -> list[int]:
    return [int(sign) for sign in np.unique(np.sign(numbers))]


def _push(term: ast.expr, name: str, positive: Collection[str], sign: int) -> Sign:
    """The sign of a term where it has one, else that of its direction, times the one that it counts with."""
    values = _values(term, name, positive)
    push = _one(_signs(values[np.isfinite(values)])) or _direction(term, name, positive)
    return sign * push if push else push


def _direction(tree: ast.expr, name: str, positive: Collection[str]) -> Sign:
    """+1 where an expression never falls as the name rises, −1 where it never rises, else None."""
    values = _values(tree, name, positive)
    with np.errstate(invalid="ignore"):
        steps, size = np.diff(values), np.maximum(np.abs(values[..., 1:]), np.abs(values[..., :-1]))
    kept = np.isfinite(steps) & (np.abs(steps) > ROUNDING * size)
    return _one(_signs(steps[kept]))


def _values(tree: ast.expr, name: str, positive: Collection[str]) -> np.ndarray:
    """The values of an expression: f64[draws of the other readings, ascending values of the name]."""
    numbers = [abs(float(n.value)) for n in ast.walk(tree) if isinstance(n, ast.Constant)]  # type: ignore[arg-type]
    near = np.outer([0.0, *numbers, 0.1, 1.0, 10.0], [0.5, 0.99, 1.0, 1.01, 2.0])
    at, random = np.unique([near, -near]), np.random.default_rng(0)
    given = {}
    for other in _names(tree):
        allowed = at[at >= 0] if other in positive else at
        chosen = allowed if other == name else random.choice(allowed, (DRAWS, 1))
        given[other] = chosen.astype(np.float32)
    with np.errstate(all="ignore"):
        return np.asarray(Compiler("", 0, tuple(given)).node(tree)(given), float)
