"""The last states of watched organisms that die in a living world: body and nervous system."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World
    from ecs_eco.engine.table import Table
    from ecs_eco.view.pedigree import PedigreeLog

KEPT = 64  # organisms
OF_NOW = ("born", "died", "parents", "children", "generation")  # what is known of a life goes on


class LastStates:
    """Notes the state of each that dies while it is in `watched` (uids), before its row is free."""

    def __init__(self, world: World, pedigree: PedigreeLog, watched: Collection[int]) -> None:
        self.world, self.pedigree, self.watched = world, pedigree, watched
        self._states: dict[int, dict[str, Any]] = {}  # by uid, the last that died last
        world.on_death.append(self._has_died)

    def state_of(self, uid: int) -> dict[str, Any]:
        """Return the message "organism" of the living or the dead; KeyError for one that never was.

        Of a dead one that was watched: its last state, `as_of` the last tick that it lived in.
        """
        from ecs_eco.view.inspect import state_of

        state = state_of(self.world, uid, lives=self.pedigree)
        last = self._states.get(uid)
        if state["alive"] or state["died"] is None or last is None:
            return state
        note = f"As it was in its last tick, {last['as_of']:,}."
        return last | {name: state[name] for name in OF_NOW} | {"alive": False, "note": note}

    def _has_died(self, table: Table, rows: np.ndarray) -> None:
        if not self.watched:
            return
        from ecs_eco.view.inspect import state_of

        for uid in table.uid[rows].tolist():
            if uid in self.watched:
                state, nerves = state_of(self.world, uid), table.species.nerves
                felt = nerves is not None and nerves.thoughts is not None and state["nerves"] is not None
                self._states.pop(uid, None)
                self._states[uid] = state | {"as_of": nerves.thoughts.tick if felt else self.world.tick}
                while len(self._states) > KEPT:
                    self._states.pop(next(iter(self._states)))
