"""What features that change the substances of bodies check alike."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ecs_eco.config.features.feature import Key, WorldSections
from ecs_eco.engine.errors import Problem, unknown

CHANGING = ("reactions", "exchange", "decomposition", "born_with")  # keys that change them


def substances_of(config: WorldSections, name: str | int) -> set[str]:
    """Return the substances that bodies of a kind are declared to hold, of remains those of the dead too."""
    kind = config.species.get(str(name)) or config.objects[str(name)]
    dead = [s.substances for s in config.species.values() if s.remains == name]
    return {substance for held in (kind.substances, *dead) for substance in held}


def check_held(kind: Any, config: WorldSections, key: Key, changing: str) -> Iterator[Problem]:
    """Yield that bodies hold no substances, at the first of the keys that change them."""
    used = (name for name in CHANGING if getattr(kind, name, None) not in (None, [], "declared"))
    if next(used, None) == changing and not substances_of(config, key[1]):
        fault = f"is missing, and {changing} changes them"
        allowed = "concentrations at the start [mol/L], 0 for those that it begins without"
        yield Problem((*key, "substances"), fault, allowed=allowed)


def check_action(kind: Any, at: Key, action: str | None) -> Iterator[Problem]:
    """Yield what is wrong with an action by which a species changes its substances."""
    if action is None:
        return
    if at[0] == "objects":
        yield Problem(at, "objects do not act", action, "no action")
    elif action not in (rows := kind.action_rows()):
        yield unknown(at, "action of the species", action, rows)
    elif kind.action_list()[rows[action]][0] in kind.ranges():
        yield Problem(at, "is continuous", action, "an action that is done or not")
