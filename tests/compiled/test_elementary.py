"""Whoever decides a world's future calls elementary functions where the portable mode can replace them."""

import ast
import math
from pathlib import Path

import numpy as np

from ecs_eco.compiled import elementary, libm, portable

PACKAGE = Path(elementary.__file__).parents[1]
OF_WORLDS = (
    "engine",
    "components",
    "space",
    "genomes",
    "learning",
    "nervous",
    "lifecycle",
    "systems",
    "worlds",
)
REPLACED = {*libm.ONE, *libm.TWO, "arcsin", "arccos", "arctan", "arctan2", "power"}
ITS_OWN = {"libm.py", "substitutes.py", "elementary.py"}
LEAST = {"hypot of places.py"}  # Python's own code, of three numbers: no library's


def calls(node, path):
    """Names of np's and math's functions that are called outside of kernels."""
    if isinstance(node, ast.FunctionDef) and any("njit" in ast.unparse(d) for d in node.decorator_list):
        return
    if (
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id in ("np", "math")
        and node.attr in REPLACED
    ):
        yield f"{node.attr} of {path.name}", node.lineno
    for part in ast.iter_child_nodes(node):
        yield from calls(part, path)


def test_the_native_mode_has_numpys_and_maths_functions_themselves():
    assert not portable.on()
    assert elementary.arrays is np
    assert elementary.scalars is math
    assert elementary.power(3.0, 2.0) == 9.0


def test_no_code_of_worlds_calls_the_librarys_functions_outside_of_kernels():
    found = [
        (name, line)
        for room in OF_WORLDS
        for path in sorted((PACKAGE / room).rglob("*.py"))
        if path.name not in ITS_OWN
        for name, line in calls(ast.parse(path.read_text("utf-8")), path)
    ]
    assert [where for where in found if where[0] not in LEAST] == []
