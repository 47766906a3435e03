"""Panels defined by users: functions whose number, figure or SVG the page shows next to the scene."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Mapping
from numbers import Real
from typing import TYPE_CHECKING, Any

from ecs_eco.analysis.style import svg_of
from ecs_eco.view.source import Message, is_whole, short, text

if TYPE_CHECKING:
    from ecs_eco.view.shown import View

EVERY = 1.0  # [s] minimum time between calls of a function
SHARE = 0.1  # maximum share of the time spent in each function
LARGEST = 2_000_000  # [characters] maximum size of an SVG
Function = Callable[[Any], object]


class Panels:
    """Calls the functions of the panels that pages show, one at a time, between ticks. Each receives a `World`,
    or the `Replay` of a recorded run, and must not change it. Raises TypeError for anything but
    names and functions."""

    def __init__(self, source: object, functions: Mapping[str, Function] | None) -> None:
        self.functions = dict(functions or {})
        for name, function in self.functions.items():
            if not isinstance(name, str) or not name.strip() or not callable(function):
                raise TypeError(
                    f"panels: {name!r} = {function!r}; expected a name and a function of the world"
                )
        first = getattr(source, "first", source)
        self.subject: object = getattr(first, "world", first)
        self.made: dict[str, Message] = {}  # the last message of each panel
        self._due = dict.fromkeys(self.functions, -math.inf)

    def ask(self, view: View, request: Message) -> None:
        """Choose the panels that a page shows, by number."""
        chosen, known = request.get("shown"), list(self.functions)
        if not isinstance(chosen, list) or not all(is_whole(one, 0, len(known)) for one in chosen):
            raise ValueError(f"panels: shown = {short(chosen)}; expected numbers less than {len(known)}")
        view.panels = {known[one]: view.panels.get(known[one]) for one in chosen}

    def add(self, view: View, tick: int, out: list[str | bytes]) -> None:
        """Add the panels that a page lacks, and make them again if they are due."""
        for name, sent in view.panels.items():
            begin = time.perf_counter()
            if self.made.get(name, {}).get("tick") != tick and begin >= self._due[name]:
                self.made[name] = {"kind": "panel", "name": name, "tick": tick, **self._call(name)}
                end = time.perf_counter()
                self._due[name] = end + max(EVERY, (end - begin) / SHARE)
            if name in self.made and self.made[name] is not sent:
                view.panels[name] = self.made[name]
                out.append(text(self.made[name]))

    def _call(self, name: str) -> Message:
        try:
            return _shown(self.functions[name](self.subject))
        except Exception as error:  # an error in a user's function must not end the run
            return {"error": f"{type(error).__name__}: {error}"}


def _shown(value: object) -> Message:
    if isinstance(value, Real):
        number = float(value)
        return {"number": number if math.isfinite(number) else None}
    if hasattr(value, "savefig"):
        svg = svg_of(value)  # type: ignore[arg-type]
        if "matplotlib.pyplot" in sys.modules:
            sys.modules["matplotlib.pyplot"].close(value)  # otherwise pyplot would keep every figure
    elif isinstance(value, str) and value.lstrip().startswith(("<svg", "<?xml")):
        svg = value
    else:
        words = f"the function returned {str(value)[:60]!r} ({type(value).__name__})"
        raise TypeError(f"{words}; expected a number, a matplotlib figure or an SVG text")
    if len(svg) > LARGEST:
        raise ValueError(f"the picture has {len(svg):,} characters; expected at most {LARGEST:,}")
    return {"svg": svg}
