"""A small language of expressions over named arrays, for happiness and reflexes.

All values are float32; true is 1, false is 0, and any nonzero number counts as true, including NaN. Python
itself never evaluates the text; it is parsed into a tree of the operations listed here.
"""

import ast
import operator
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.engine.errors import listed, nearest

Values = Mapping[str, np.ndarray]
Node = Callable[[Any], np.ndarray]
LONGEST = 1000  # characters

# name: (function, minimum and maximum number of arguments)
FUNCTIONS: dict[str, tuple[Callable[..., np.ndarray], int, int]] = {
    "min": (lambda *x: _fold(np.minimum, x), 2, 20),
    "max": (lambda *x: _fold(np.maximum, x), 2, 20),
    "abs": (np.abs, 1, 1),
    "exp": (arrays.exp, 1, 1),
    "log": (arrays.log, 1, 1),
    "sqrt": (np.sqrt, 1, 1),
    "tanh": (arrays.tanh, 1, 1),
    "clip": (lambda x, low, high: np.minimum(np.maximum(x, low), high), 3, 3),
}
OPERATIONS: dict[type[ast.AST], Callable[..., np.ndarray]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: arrays.power,
    ast.USub: np.negative,
    ast.UAdd: np.positive,
    ast.Not: np.logical_not,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.And: np.logical_and,
    ast.Or: np.logical_or,
}
ALLOWED = f"numbers, names, + - * / **, comparisons, and, or, not, a if b else c, {', '.join(FUNCTIONS)}"


class FormulaError(ValueError):
    """An invalid formula: the problem, its position (in characters, from 1), the expected input and the
    nearest valid name."""

    def __init__(self, fault: str, position: int, allowed: str = ALLOWED, close: str = "") -> None:
        self.what, self.position = f"{fault} at character {position}", position
        self.allowed, self.nearest = allowed, close
        hint = f'; did you mean "{close}"?' if close else ""
        super().__init__(f"{self.what}; expected: {allowed}{hint}")


class Formula:
    """A compiled formula: call it with a mapping from names to arrays.

    Attributes
    ----------
    text : str
    names : frozenset of str
        The names that it uses.

    Examples
    --------
    >>> from ecs_eco.config import compile_formula
    >>> compile_formula("max(0, 1 - age / 100)", ["age", "energy"]).names
    frozenset({'age'})
    """

    def __init__(self, text: str, run: Node, names: frozenset[str]) -> None:
        self.text, self.names, self._run = text, names, run

    def __call__(self, values: Values) -> np.ndarray:
        """Return the values (float32) in the arrays' common shape."""
        given, shapes = {}, set()
        for name, value in values.items():
            shapes.add(value.shape if type(value) is np.ndarray else np.shape(value))
            if name in self.names:
                given[name] = np.asarray(value, np.float32)
        with np.errstate(all="ignore"):
            result = np.asarray(self._run(given), np.float32)
        shape = shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
        return np.ascontiguousarray(result if result.shape == shape else np.broadcast_to(result, shape))


def compile_formula(text: str, names: Iterable[str]) -> Formula:
    """Compile a formula to a function of arrays.

    Parameters
    ----------
    text : str
        An expression of names, numbers, + - * / **, comparisons, `and`, `or`, `not`, `a if b else c`, min, max,
        abs, exp, log, sqrt, tanh and clip.
    names : iterable of str
        Names that the formula can use.

    Returns
    -------
    Formula
        Call it with a mapping from names to arrays; `names` contains the names that the formula uses.

    Raises
    ------
    FormulaError
        If a name is unknown or anything else is not allowed.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.config import compile_formula
    >>> mood = compile_formula("energy - 0.3 * wolf_smell", ["energy", "wolf_smell"])
    >>> mood({"energy": np.array([1.0, 0.5]), "wolf_smell": np.array([0.0, 1.0])}).tolist()
    [1.0, 0.199999...]
    """
    run, compiler = compiled(text, lambda line, lead: Compiler(line, lead, tuple(names)))
    return Formula(text, run, frozenset(compiler.used))


def compiled(text: str, compiler_of: Callable[[str, int], Any]) -> tuple[Any, Any]:
    """Return the function that a text defines, and its compiler, `compiler_of(line, leading spaces)`."""
    line = " ".join(text.split("\n"))
    if len(line) > LONGEST:
        raise FormulaError("too long: it must end", LONGEST, f"at most {LONGEST} characters")
    lead = len(line) - len(line.lstrip())
    compiler = compiler_of(line, lead)
    try:
        return compiler.node(ast.parse(line.strip(), mode="eval").body), compiler
    except FormulaError:
        raise
    except (SyntaxError, ValueError) as error:
        offset = getattr(error, "offset", None) or 0  # 0 or less: at the end of the text
        raise FormulaError(
            "not an expression", lead + (offset if offset > 0 else len(line.strip()) + 1), compiler.allowed
        ) from None
    except (RecursionError, MemoryError):
        raise FormulaError("too deeply nested", 1, compiler.allowed) from None


class Compiler:
    """Convert the syntax tree of one text into nested functions."""

    dtype: type[np.floating] = np.float32
    allowed = ALLOWED

    def __init__(self, line: str, lead: int, names: tuple[str, ...]) -> None:
        self.line, self.lead, self.names, self.used = line, lead, names, set[str]()

    def node(self, tree: ast.AST) -> Node:
        method = getattr(self, "_" + type(tree).__name__.lower(), None)
        if method is None:
            raise self._error(f"{type(tree).__name__.lower()} is not allowed", tree)
        return method(tree)

    def _error(self, fault: str, tree: ast.AST, allowed: str = "", close: str = "") -> FormulaError:
        before = self.line.strip().encode()[: getattr(tree, "col_offset", 0)].decode(errors="ignore")
        return FormulaError(fault, len(before) + 1 + self.lead, allowed or self.allowed, close)

    def _constant(self, tree: ast.Constant) -> Node:
        if isinstance(tree.value, bool) or not isinstance(tree.value, int | float) or abs(tree.value) > 3e38:
            raise self._error(f"{tree.value!r:.40} is not a finite number", tree)
        value = np.asarray(tree.value, self.dtype)
        return lambda values: value

    def _name(self, tree: ast.Name) -> Node:
        name = tree.id
        if name not in self.names:
            raise self._error(
                f'unknown name "{name}"', tree, listed(self.names, 30), nearest(name, self.names)
            )
        self.used.add(name)
        return operator.itemgetter(name)

    def _attribute(self, tree: ast.Attribute) -> Node:
        """Return a function that reads the sensor named by Component.field."""
        owner = tree.value.id if isinstance(tree.value, ast.Name) else "…"
        if owner == "…" or tree.attr.startswith("_"):
            raise self._error(f'attribute "{owner}.{tree.attr:.40}" is not allowed', tree)
        if f"{owner}_{tree.attr}" not in self.names:
            raise self._error(
                f'unknown attribute "{owner}.{tree.attr:.40}"',
                tree,
                listed(self.names, 30),
                tree.attr if tree.attr in self.names else nearest(f"{owner}_{tree.attr}", self.names),
            )
        return self._name(ast.Name(f"{owner}_{tree.attr}"))

    def _call(self, tree: ast.Call) -> Node:
        name = tree.func.id if isinstance(tree.func, ast.Name) else ""
        if name not in FUNCTIONS:
            raise self._error(f'unknown function "{name}"', tree, listed(FUNCTIONS), nearest(name, FUNCTIONS))
        function, fewest, most = FUNCTIONS[name]
        if tree.keywords or not fewest <= len(tree.args) <= most:
            number = str(fewest) if fewest == most else f"{fewest} to {most}"
            raise self._error(f"{len(tree.args)} arguments for {name}", tree, f"{name} with {number}")
        arguments = [self.node(a) for a in tree.args]
        return lambda values: function(*(a(values) for a in arguments))

    def _operation(self, tree: ast.AST, kind: ast.AST) -> Callable[..., np.ndarray]:
        if type(kind) not in OPERATIONS:
            raise self._error(f"{type(kind).__name__.lower()} is not allowed", tree)
        return OPERATIONS[type(kind)]

    def _binop(self, tree: ast.BinOp) -> Node:
        operation, left, right = self._operation(tree, tree.op), self.node(tree.left), self.node(tree.right)
        if isinstance(tree.left, ast.Constant):
            factor = left({})
            return lambda values: operation(factor, right(values))
        if isinstance(tree.right, ast.Constant):
            number = right({})
            return lambda values: operation(left(values), number)
        return lambda values: operation(left(values), right(values))

    def _unaryop(self, tree: ast.UnaryOp) -> Node:
        operation, operand = self._operation(tree, tree.op), self.node(tree.operand)
        return lambda values: np.asarray(operation(operand(values)), self.dtype)

    def _boolop(self, tree: ast.BoolOp) -> Node:
        operation, operands = self._operation(tree, tree.op), [self.node(v) for v in tree.values]
        return lambda values: np.asarray(_fold(operation, [o(values) for o in operands]), self.dtype)

    def _compare(self, tree: ast.Compare) -> Node:
        operations = [self._operation(tree, op) for op in tree.ops]
        operands = [self.node(x) for x in (tree.left, *tree.comparators)]

        def run(values: Values) -> np.ndarray:
            read = [o(values) for o in operands]
            pairs = [op(a, b) for op, a, b in zip(operations, read, read[1:], strict=False)]
            return np.asarray(_fold(np.logical_and, pairs), self.dtype)

        return run

    def _ifexp(self, tree: ast.IfExp) -> Node:
        test, yes, no = self.node(tree.test), self.node(tree.body), self.node(tree.orelse)
        return lambda values: np.where(test(values) != 0, yes(values), no(values))


def _fold(operation: Callable[..., np.ndarray], operands: Iterable[np.ndarray]) -> np.ndarray:
    """Return the operation applied from left to right."""
    first, *rest = operands
    for operand in rest:
        first = operation(first, operand)
    return first
