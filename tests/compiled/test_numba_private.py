"""What is private to numba stays in one file."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import ecs_eco
from ecs_eco.compiled import numba_private

ROOT, HOME = Path(ecs_eco.__file__).parent, Path(numba_private.__file__)
PUBLIC = ("numba", "numba.extending", "numba.types")
"""The modules that numba's documentation tells others to import."""


def private_imports(tree: ast.AST) -> Iterator[str]:
    """The names that a module imports from numba, and that are not of its public interface."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [one.name for one in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{one.name}" for one in node.names]
        elif isinstance(node, ast.Attribute):  # numba.core.config, without an import of its own
            names = [ast.unparse(node)]
        else:
            continue
        for name in names:
            path = name.split(".")
            if path[0] == "numba" and (
                "core" in path
                or any(part.startswith("_") and part != "__version__" for part in path)
                or (len(path) > 2 and ".".join(path[:2]) not in PUBLIC and path[1] != "config")
            ):
                yield name


def private_attributes(tree: ast.AST) -> set[str]:
    """The attributes with a leading underscore that a module looks up in something else than itself."""
    return {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and node.attr.startswith("_")
        and not node.attr.startswith("__")
        and not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls"))
    }


def test_no_other_file_names_what_is_private_to_numba():
    of_numba = private_attributes(ast.parse(HOME.read_text(encoding="utf-8")))
    assert "_reload_init" in of_numba
    for path in sorted(ROOT.rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        if path == HOME or not ("numba" in source or path.parent == HOME.parent):
            continue
        names = [*private_imports(ast.parse(source))]
        if path.parent == HOME.parent:
            names += private_attributes(ast.parse(source)) & of_numba
        assert not names, f"{path}: into {HOME.name} with {', '.join(names)}"


@pytest.mark.parametrize(
    ("line", "private"),
    [
        ("import numba\nnumba.config.DISABLE_JIT\nnumba.types.float64", False),
        ("from numba.extending import intrinsic", False),
        ("from numba import carray, types", False),
        ("import numba\nnumba.__version__", False),
        ("from numba import _dynfunc", True),
        ("from numba.core import config", True),
        ("import numba\nnumba.core.config", True),
        ("from numba.np.arrayobj import make_array", True),
    ],
)
def test_private_names_are_noticed(line, private):
    assert bool(list(private_imports(ast.parse(line)))) is private
