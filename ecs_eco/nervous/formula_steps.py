"""A formula as a list of steps that one kernel executes for all organisms. The results are bit-identical to
numpy's in `ecs_eco.config.formula`, without an array for each operation."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.jit import lone_njit

BLOCK = 256  # organisms processed together in each step
NUMBER, READ, ADD, SUBTRACT, MULTIPLY, DIVIDE, LEAST, MOST = range(8)
OPERATIONS: dict[type[ast.AST], int] = {ast.Add: ADD, ast.Sub: SUBTRACT, ast.Mult: MULTIPLY, ast.Div: DIVIDE}
FUNCTIONS = {"min": LEAST, "max": MOST}
FEW = 8  # readings; numpy sums more of them in a different order

Step = tuple[int, float]


class Steps(NamedTuple):
    """Steps in the order of execution; each pushes a number onto a stack or replaces the top two with one."""

    operation: np.ndarray  # i64[steps]
    operand: np.ndarray  # f32[steps]: a number, or the index of the channel to read
    height: int  # maximum height of the stack


AS_READ = Steps(np.array([READ], np.int64), np.zeros(1, np.float32), 1)
"""The steps that return channel 0."""


class _Unknown(Exception):
    """A part of the formula has no step."""


def steps_of(text: str, readings: Mapping[str, tuple[int, ...]]) -> Steps | None:
    """Return the steps of a formula that `compile_formula` has accepted. Return None if a part has no step,
    such as a C library function, which a kernel would not reproduce bit for bit."""
    try:
        steps = list(_steps(ast.parse(" ".join(text.split("\n")).strip(), mode="eval").body, readings))
    except (_Unknown, RecursionError):
        return None
    heights = np.cumsum([1 if operation in (NUMBER, READ) else -1 for operation, _ in steps])
    return Steps(
        np.array([operation for operation, _ in steps], np.int64),
        np.array([operand for _, operand in steps], np.float32),
        int(heights.max()),
    )


def _steps(tree: ast.AST, readings: Mapping[str, tuple[int, ...]]) -> Iterator[Step]:
    """Yield the steps of one part of a formula."""
    if isinstance(tree, ast.Constant):
        yield NUMBER, float(tree.value)  # type: ignore[arg-type]
    elif isinstance(tree, ast.Name):
        yield from _read(readings[tree.id])
    elif isinstance(tree, ast.Attribute) and isinstance(tree.value, ast.Name):
        yield from _read(readings[f"{tree.value.id}_{tree.attr}"])
    elif isinstance(tree, ast.BinOp) and type(tree.op) in OPERATIONS:
        yield from _folded(OPERATIONS[type(tree.op)], [tree.left, tree.right], readings)
    elif isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
        yield from _folded(MULTIPLY, [ast.Constant(-1), tree.operand], readings)
    elif isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id in FUNCTIONS:
        yield from _folded(FUNCTIONS[tree.func.id], tree.args, readings)
    elif isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id == "clip":
        value, low, high = tree.args
        yield from _folded(MOST, [value, low], readings)
        yield from _steps(high, readings)
        yield LEAST, 0.0
    else:
        raise _Unknown


def _folded(
    operation: int, operands: list[ast.expr], readings: Mapping[str, tuple[int, ...]]
) -> Iterator[Step]:
    """Yield an operation applied from left to right."""
    for place, operand in enumerate(operands):
        yield from _steps(operand, readings)
        if place:
            yield operation, 0.0


def _read(channels: tuple[int, ...]) -> Iterator[Step]:
    """Read one channel, or the mean of several as in `mean_of`."""
    if len(channels) >= FEW:
        raise _Unknown
    if len(channels) > 1:
        yield NUMBER, 0.0
    for channel in channels:
        yield READ, channel
        if len(channels) > 1:
            yield ADD, 0.0
    if len(channels) > 1:
        yield NUMBER, len(channels)
        yield DIVIDE, 0.0


@lone_njit
def take_steps(x, start, size, operation, operand, pile):
    """Execute the steps for organisms start … start + size − 1 in x f32[channels, n]; the result is pile[0],
    f32[height + 1, BLOCK]."""
    top = -1
    for s in range(operation.size):
        kind, number = operation[s], operand[s]
        top += 1 if kind <= READ else -1
        if kind == READ:
            channel = np.int64(number)
            for i in range(size):
                pile[top, i] = x[channel, start + i]
        else:
            _combine(kind, number, pile[top], pile[top + 1], size)


@lone_njit
def _combine(kind, number, first, second, size):
    """Replace the top two numbers with the result of an operation, following numpy's rules for equal numbers
    (0 and −0: the second) and NaN."""
    for i in range(size):
        a, b = first[i], second[i]
        if kind == NUMBER:
            first[i] = number
        elif kind == ADD:
            first[i] = a + b
        elif kind == SUBTRACT:
            first[i] = a - b
        elif kind == MULTIPLY:
            first[i] = a * b
        elif kind == DIVIDE:
            first[i] = a / b
        elif kind == LEAST:
            first[i] = a if (a < b) | (a != a) else b
        else:
            first[i] = a if (a > b) | (a != a) else b
