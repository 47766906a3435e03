"""The sign of a reading's effect in a formula: +1, −1, 0 if there is no effect, None if the sign varies."""

import ast
import re
from collections.abc import Collection, Iterable
from functools import partial

Sign = int | None
FIELD = re.compile(r"\b([A-Za-z_]\w*)\.([A-Za-z_]\w*)")
RISING = ("exp", "log", "sqrt", "tanh")


def directions(text: str, positive: Collection[str]) -> dict[str, Sign]:
    """Return whether a formula rises (+1) or falls (−1) with each name; those in `positive` are never negative."""
    tree = _parsed(text)
    return {name: _direction(tree, name, positive) for name in _names(tree)}


def pushes(text: str, positive: Collection[str]) -> dict[str, Sign]:
    """Return, for each name in a reflex formula, the sign of the summands that contain it: +1 if a summand is
    never negative, such as `energy < 0.3`, otherwise the sign of its slope."""
    tree = _parsed(text)
    terms = _terms(tree, 1)
    return {
        name: _sum(
            _times(_value(term, positive) or _direction(term, name, positive), sign)
            for sign, term in terms
            if name in _names(term)
        )
        for name in _names(tree)
    }


def _parsed(text: str) -> ast.AST:
    """Parse a formula, replacing each Component.field with the name of its channel."""
    return ast.parse(FIELD.sub(r"\1_\2", " ".join(text.split())), mode="eval").body


def _names(tree: ast.AST) -> list[str]:
    """Return the distinct readings in an expression, in order of appearance."""
    called = {id(n.func) for n in ast.walk(tree) if isinstance(n, ast.Call)}
    nodes = [n for n in ast.walk(tree) if isinstance(n, ast.Name) and id(n) not in called]
    return list(dict.fromkeys(n.id for n in sorted(nodes, key=lambda n: n.col_offset)))


def _terms(tree: ast.AST, sign: int) -> list[tuple[int, ast.AST]]:
    """Return the terms of a sum with their signs."""
    if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.Add | ast.Sub):
        return _terms(tree.left, sign) + _terms(tree.right, sign * _of_sign(tree.op))
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
        return _terms(tree.operand, -sign)
    return [(sign, tree)]


def _sum(signs: Iterable[Sign]) -> Sign:
    """Return the sign of a sum, or None if its terms disagree."""
    distinct = set(signs) - {0}
    return 0 if not distinct else distinct.pop() if len(distinct) == 1 else None


def _times(a: Sign, b: Sign) -> Sign:
    """Return the sign of a product."""
    return 0 if a == 0 or b == 0 else None if a is None or b is None else a * b


def _value(tree: ast.AST, positive: Collection[str]) -> Sign:
    """Return the sign of an expression: +1 if it is never negative, −1 if never positive, 0 if always 0."""
    value = partial(_value, positive=positive)
    match tree:
        case ast.Constant(value=number):
            return (number > 0) - (number < 0)  # type: ignore[operator]
        case ast.Name(id=name):
            return 1 if name in positive else None
        case ast.UnaryOp(op=ast.USub() | ast.UAdd() as op, operand=inner):
            return _times(_of_sign(op), value(inner))
        case ast.UnaryOp() | ast.Compare() | ast.BoolOp():
            return 1
        case ast.BinOp(left=a, op=ast.Add() | ast.Sub() as op, right=b):
            return _sum((value(a), _times(_of_sign(op), value(b))))
        case ast.BinOp(left=a, op=ast.Mult() | ast.Div(), right=b):
            return _times(value(a), value(b))
        case ast.BinOp(left=a, op=ast.Pow(), right=b):
            even = isinstance(b, ast.Constant) and b.value % 2 == 0  # type: ignore[operator]
            return 1 if even or value(a) == 1 else None
        case ast.IfExp(body=a, orelse=b):
            return _sum((value(a), value(b)))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return _value_of_call(name, [value(a) for a in arguments])
    return None


def _of_sign(op: ast.operator | ast.unaryop) -> int:
    """Return the factor that a plus or minus sign stands for."""
    return 1 if isinstance(op, ast.Add | ast.UAdd) else -1


def _value_of_call(name: str, signs: list[Sign]) -> Sign:
    if name in ("abs", "exp", "sqrt"):
        return 1
    if name == "tanh":
        return signs[0]
    if (name == "max" and 1 in signs) or (name == "min" and -1 in signs):
        return 1 if name == "max" else -1
    if name == "clip":  # min(max(x, low), high)
        x, low, high = signs
        return -1 if high in (-1, 0) else 1 if high == 1 and (x == 1 or low in (0, 1)) else None
    return _sum(signs) if name in ("min", "max") else None


def _direction(tree: ast.AST, name: str, positive: Collection[str]) -> Sign:
    """Return +1 if an expression never falls as the name rises, −1 if it never rises, 0 if it lacks the name."""
    value, way = partial(_value, positive=positive), partial(_direction, name=name, positive=positive)
    if name not in _names(tree):
        return 0
    match tree:
        case ast.Name():
            return 1
        case ast.UnaryOp(op=op, operand=inner):
            sure = not isinstance(op, ast.Not) or value(inner) == 1
            return _times(_of_sign(op), way(inner)) if sure else None
        case ast.BinOp(left=a, op=ast.Add() | ast.Sub() as op, right=b):
            return _sum((way(a), _times(_of_sign(op), way(b))))
        case ast.BinOp(left=a, op=ast.Mult(), right=b):
            return _sum((_times(way(a), value(b)), _times(way(b), value(a))))
        case ast.BinOp(left=a, op=ast.Div(), right=b):
            falls = _times(_times(-1, way(b)), _times(value(a), abs(value(b) or 0) or None))
            return _sum((_times(way(a), value(b)), falls))
        case ast.BinOp(left=a, op=ast.Pow(), right=ast.Constant(value=power)):
            odd = power > 0 and (power % 2 == 1 or value(a) == 1)  # type: ignore[operator]
            return way(a) if odd else None
        case ast.Compare(left=a, ops=ops, comparators=others):
            pairs = zip(ops, [a, *others], others, strict=False)
            return _sum(_way_of_comparison(op, way(x), way(y)) for op, x, y in pairs)
        case ast.BoolOp(values=parts):
            return _sum(way(p) if value(p) == 1 else _times(None, way(p)) for p in parts)
        case ast.IfExp(test=test, body=a, orelse=b):
            if way(test) == 0:
                return _sum((way(a), way(b)))
            x, y = _number(a), _number(b)
            return (
                None if x is None or y is None or value(test) != 1 else _times(way(test), (x > y) - (x < y))
            )
        case ast.Call(func=ast.Name(id=function), args=arguments):
            if function == "abs":
                return _times(way(arguments[0]), value(arguments[0]))
            return _sum(way(a) for a in arguments) if function in (*RISING, "min", "max", "clip") else None
    return None


def _number(tree: ast.AST) -> float | None:
    """Return the value of a number with its sign, or None for any other expression."""
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
        inner = _number(tree.operand)
        return None if inner is None else -inner
    return float(tree.value) if isinstance(tree, ast.Constant) else None  # type: ignore[arg-type]


def _way_of_comparison(op: ast.cmpop, left: Sign, right: Sign) -> Sign:
    if isinstance(op, ast.Gt | ast.GtE):
        return _sum((left, _times(-1, right)))
    if isinstance(op, ast.Lt | ast.LtE):
        return _sum((_times(-1, left), right))
    return None if (left, right) != (0, 0) else 0
