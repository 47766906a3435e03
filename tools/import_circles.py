"""Count circular imports in the package, including imports inside functions and under TYPE_CHECKING.

    python tools/import_circles.py

Prints the circles among files and among packages (the folders of ecs_eco, and its files outside any folder);
exits with 1 if there are any.
"""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import networkx

ROOT = Path(__file__).parents[1]
PACKAGE = "ecs_eco"


def modules() -> dict[str, Path]:
    """Return the package's files by module name."""
    paths = {}
    for path in sorted((ROOT / PACKAGE).rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        paths[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return paths


def imported(module: str, path: Path, known: dict[str, Path]) -> Iterator[str]:
    """Yield the package's modules that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module is not None and not node.level:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            while name and name not in known:
                name = name.rpartition(".")[0]
            if name and name != module:
                yield name


def room(module: str, path: Path) -> str:
    """Return a module's folder, or the module itself if it is not in one."""
    return module if path.parent == ROOT / PACKAGE else ".".join(module.split(".")[:2])


def circles(edges: set[tuple[str, str]]) -> list[list[str]]:
    """Return the sets of nodes that import each other, sorted."""
    parts = networkx.strongly_connected_components(networkx.DiGraph(edges))
    return sorted(sorted(part) for part in parts if len(part) > 1)


def main() -> int:
    """Print the circles; return 1 if there are any."""
    known = modules()
    files = {(module, other) for module, path in known.items() for other in imported(module, path, known)}
    rooms = {(room(a, known[a]), room(b, known[b])) for a, b in files}
    cycles = {"files": circles(files), "rooms": circles({(a, b) for a, b in rooms if a != b})}
    for kind, parts in cycles.items():
        print(
            f"{len(parts)} circles of {kind} "
            f"({len(known) if kind == 'files' else len({r for edge in rooms for r in edge})} in all)"
        )
        for part in parts:
            print("   ", ", ".join(part))
    return int(any(cycles.values()))


if __name__ == "__main__":
    sys.exit(main())
