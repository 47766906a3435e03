"""Read the comment after each field in a component's source: "# [unit] meaning"."""

from __future__ import annotations

import inspect
import re
import textwrap
from functools import cache

from ecs_eco.engine.schema import Handle

FIELD = re.compile(r"^    (\w+)\s*:[^#\n]*# *(?:\[([^\]]*)\] *)?(.*)$", re.MULTILINE)


@cache
def comments_of(component: type[Handle]) -> dict[str, tuple[str, str]]:
    """Return the unit and meaning of each commented field of a component; empty if its source is unavailable."""
    try:
        source = textwrap.dedent(inspect.getsource(component))
    except (OSError, TypeError):
        return {}
    return {name: (unit, text) for name, unit, text in FIELD.findall(source) if name in component.fields}
