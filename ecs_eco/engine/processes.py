"""Python processes that this one starts: they import nothing from the folder that a command runs in."""

from __future__ import annotations

import sys
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
SAFE = "PYTHONSAFEPATH"  # unless it is set, `python -c` and `python -m` look for modules in that folder first


def python(code: str, *arguments: str) -> list[str]:
    """Return the command of a process that runs `code`, with the arguments as sys.argv[1:]; processes that it
    starts in turn are as careful."""
    first = f"import os, sys; os.environ['{SAFE}'] = '1'; sys.path.append({str(PACKAGE.parent)!r})"
    return [sys.executable, "-P", "-c", f"{first}; {code}", *arguments]
