"""Read the comment on each field in a class's source: "# [unit] meaning"."""

from __future__ import annotations

import inspect
import re
from functools import cache

_DECLARED = re.compile(
    r"^(?P<space> *)(?:self\.)?(?P<name>\w+)\s*(?::[^=#\n]+)?(?:=[^#\n]*)?,?\s*# (?P<text>.*)$"
)
_UNIT = re.compile(r"^\[([^]]*)\][,;]?\s*")


@cache
def comments_of(thing: object) -> dict[str, tuple[str, str]]:
    """Return the unit and meaning of each value that a class or module declares, from comments on or above."""
    try:
        lines = inspect.getsource(thing).splitlines()  # type: ignore[arg-type]
    except (OSError, TypeError):  # there is no source, as in an interactive session
        return {}
    found: dict[str, tuple[str, str]] = {}
    above = ""
    for line in lines:
        if (bare := line.strip()).startswith("# "):
            above = bare[2:]
            continue
        match = _DECLARED.match(line) or (
            re.match(r" *(?P<name>\w+)(?P<text>)(?::| =) ", line) if above else None
        )
        if match is not None and match["name"] not in found:
            text = match["text"] or above
            unit = _UNIT.match(text)
            found[match["name"]] = (unit[1], text[unit.end() :]) if unit else ("", text)
        above = ""
    return found
