"""Python child processes that import nothing from the current folder."""

from __future__ import annotations

import sys
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
SAFE = "PYTHONSAFEPATH"  # otherwise, `python -c` and `python -m` look for modules in that folder first


def python(code: str, *arguments: str) -> list[str]:
    """Return the command for a process that runs `code` with `arguments` as sys.argv[1:]. Its child processes
    are protected in the same way."""
    first = f"import os, sys; os.environ['{SAFE}'] = '1'; sys.path.append({str(PACKAGE.parent)!r})"
    return [sys.executable, "-P", "-c", f"{first}; {code}", *arguments]
