"""The modules of the viewer's pages."""

from __future__ import annotations

import re
from collections.abc import Mapping
from graphlib import TopologicalSorter
from pathlib import Path

STATIC = Path(__file__).parent / "static"
IMPORT = re.compile(r'^(?:import|export)\b[^;"]*?\bfrom "\./(\w+\.js)"', re.MULTILINE)


def modules(first: str, replaced: Mapping[str, str] | None = None, folder: Path = STATIC) -> dict[str, str]:
    """Return the sources of a module and of those it imports, directly or not, each after its own imports.

    `replaced` maps a module to the file whose source takes its place. Raises graphlib.CycleError.
    """
    sources: dict[str, str] = {}
    imports: dict[str, list[str]] = {}
    waiting = [first]
    while waiting:
        if (name := waiting.pop()) not in sources:
            sources[name] = (folder / (replaced or {}).get(name, name)).read_text(encoding="utf-8")
            waiting += imports.setdefault(name, IMPORT.findall(sources[name]))
    return {name: sources[name] for name in TopologicalSorter(imports).static_order()}
