"""Measure the package's size: lines, files that a feature touches, kernel arguments, and calls in a build.

    python tools/budget.py [--write]

Prints each number next to its limit in tests/budget.toml, which tests/test_budget.py enforces. --write saves
the current numbers as limits: you may always lower a limit, but raise it only with a line in CHANGELOG.md
that gives the reason.
"""

import argparse
import ast
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tools.sizes import PACKAGE, annotations_of, code_lines, functions_of  # noqa: E402

LIMITS = ROOT / "tests" / "budget.toml"
NAMES = {  # words that belong to a feature: its keys, classes and modules
    "eggs": {"eggs", "hatch", "hatching", "incubation", "Eggs", "Hatch", "Hatching", "Incubation"},
    "building": {"builds", "building", "Build", "Building"},
    # not "carry" or "carrying": mothers carry young, and currents carry bodies
    "carrying": {"carries", "Carry", "Carrying", "Carrier", "Load"},
    "heat": {"heat", "Heat", "BodyHeat", "Warmth", "HeatExchange", "ExchangeHeat", "Coat", "exchange_heat"},
    "ectothermy": {"ectothermy", "Ectothermy", "SlowDown", "slow_down"},
}
KERNEL = {"njit", "lone_njit", "jit", "vectorize", "guvectorize"}


def sources() -> dict[str, str]:
    """Return the package's source files as text, by path."""
    files = sorted((ROOT / PACKAGE).rglob("*.py"))
    return {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in files}


def measure() -> dict[str, dict[str, int]]:
    """Return all numbers, by table and name."""
    texts = sources()
    trees = {path: ast.parse(text) for path, text in texts.items()}
    named = [named_in(tree) for tree in trees.values()]
    return {
        "lines": lines(texts),
        "files that name": {
            feature: sum(bool(names & of_file) for of_file in named) for feature, names in NAMES.items()
        },
        "kernels": kernels(trees),
        "configuration": configuration(trees),
        "code": {
            "parameters that are Any": sum(map(anys, trees.values())),
            "imports within functions": sum(map(late_imports, trees.values())),
        },
        "build": build(),
    }


def named_in(tree: ast.Module) -> set[str]:
    """Return all names in a file: variables, attributes, classes, fields, modules, and strings that are a
    single name. Keyword arguments do not count, because they belong to other functions (such as `hatch` in
    matplotlib)."""
    found = set()
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.ClassDef(name=name):
                found.add(name)
            case ast.Constant(value=str(text)):
                found |= set(text.split("."))
            case ast.ImportFrom(module=str(module), names=names):
                found |= {*module.split("."), *(alias.name for alias in names)}
    return found


def lines(texts: dict[str, str]) -> dict[str, int]:
    """Return the number of lines of code in each folder and in the package."""
    rooms: Counter[str] = Counter()
    for path, text in texts.items():
        _, *parts = path.split("/")
        rooms[parts[0] if len(parts) > 1 else "files at the top"] += len(code_lines(text))
    return {"all": rooms.total(), **dict(sorted(rooms.items()))}


def kernels(trees: dict[str, ast.Module]) -> dict[str, int]:
    """Return the numbers of kernels and of kernel arguments."""
    sizes = [
        len(node.args.args) for tree in trees.values() for _, node in functions_of(tree) if compiled(node)
    ]
    return {
        "kernels": len(sizes),
        "arguments": sum(sizes),
        "with 15 or more": sum(n >= 15 for n in sizes),
        "most arguments": max(sizes),
    }


def compiled(node: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Return whether numba compiles a function."""
    names = {n.id for d in node.decorator_list for n in ast.walk(d) if isinstance(n, ast.Name)}
    return bool(names & KERNEL)


def configuration(trees: dict[str, ast.Module]) -> dict[str, int]:
    """Return how many functions take a world's configuration as `config`, in how many files, and how many
    calls pass it on."""
    functions, files, calls = 0, set(), 0
    for path, tree in trees.items():
        for _, node in functions_of(tree):
            if "config" in (arg.arg for arg in (*node.args.args, *node.args.kwonlyargs)):
                functions, files = functions + 1, files | {path}
                calls += sum(passes(call) for call in ast.walk(node) if isinstance(call, ast.Call))
    return {"functions that take it": functions, "files": len(files), "calls that pass it on": calls}


def passes(call: ast.Call) -> bool:
    """Return whether a call passes `config` on unchanged."""
    given = [*call.args, *(keyword.value for keyword in call.keywords)]
    return any(isinstance(value, ast.Name) and value.id == "config" for value in given)


def anys(tree: ast.Module) -> int:
    """Return how many function parameters are annotated only as Any."""
    found = 0
    for _, node in functions_of(tree):
        results = [] if node.returns is None else [node.returns]
        notes = [note for note in annotations_of(node) if note not in results]
        found += sum(isinstance(note, ast.Name) and note.id == "Any" for note in notes)
    return found


def late_imports(tree: ast.Module) -> int:
    """Return the number of imports inside functions."""
    inner = {node for _, function in functions_of(tree) for node in ast.walk(function)}
    return sum(isinstance(node, ast.Import | ast.ImportFrom) for node in inner)


def build() -> dict[str, int]:
    """Return the number of calls to the package's functions in one build of predator-prey, after an earlier
    build, and the number of files involved."""
    from ecs_eco import World

    World.from_config("predator-prey", policies="untrained", seed=1, learn=False)
    found: Counter[str] = Counter()

    def note(frame: object, event: str, _: object) -> None:
        if event == "call":
            found[frame.f_code.co_filename] += 1  # type: ignore[attr-defined]

    sys.setprofile(note)
    try:
        World.from_config("predator-prey", policies="untrained", seed=1, learn=False)
    finally:
        sys.setprofile(None)
    ours = {file: calls for file, calls in found.items() if file.startswith(str(ROOT / PACKAGE))}
    return {"calls": sum(ours.values()), "files": len(ours)}


def limits() -> dict[str, dict[str, int]]:
    """Return the stored limits."""
    return tomllib.loads(LIMITS.read_text(encoding="utf-8"))


def rows() -> Iterator[tuple[str, str, int, int | None]]:
    """Yield each number's table, name, current value and limit."""
    kept = limits() if LIMITS.is_file() else {}
    for table, numbers in measure().items():
        for name, number in numbers.items():
            yield table, name, number, kept.get(table, {}).get(name)


def main() -> int:
    """Print all numbers, and write them if requested."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--write", action="store_true")
    write = parser.parse_args().write
    found = list(rows())
    for table, name, number, limit in found:
        print(f"{table + ': ' + name:42} {number:>8,} {'' if limit is None else f'(at most {limit:,})'}")
    if write:
        text = (
            "# Upper limits on what tools/budget.py counts. To raise one, give the reason in CHANGELOG.md.\n"
        )
        for table in dict.fromkeys(row[0] for row in found):
            text += f'\n["{table}"]\n' + "".join(f'"{n}" = {k}\n' for t, n, k, _ in found if t == table)
        LIMITS.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
