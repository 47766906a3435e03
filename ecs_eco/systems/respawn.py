"""Numbers held constant, for pre-training."""

from typing import Any

import numpy as np

from ecs_eco import random
from ecs_eco.components import Biology, Metabolism, Nervous, Position
from ecs_eco.system import System


class Respawn(System):
    """Every animal that dies is replaced at once by a newborn at a random place, with the energy of its species' newborn."""

    needs = (Position, Metabolism, Biology, Nervous)
    phase = "reproduce"

    def update(self, table: Any, world: Any) -> None:
        """Bring one species back to its initial number."""
        k = table.traits["species"].count - table.n
        if k <= 0:
            return
        who = np.arange(world.next_uid, world.next_uid + k, dtype=np.uint64)
        values = scatter(table, world, who)
        if (heredity := table.traits.get("heredity")) is not None:
            values |= heredity.founders(world, table, who)
        table.request(np.zeros(k, np.uint64), values)


def scatter(table: Any, world: Any, who: np.ndarray) -> dict[tuple[type, str], np.ndarray]:
    """Return random places on open ground, headings and sexes for newcomers drawn for with the numbers `who` u64[k]."""
    space, key = world.space, world.key
    salt = (table.place + 1) << 20
    place = np.stack([random.draw_many(key, who, random.PLACE + (axis << 8) + salt) * space.lengths[axis] for axis in range(3)], 1)
    for attempt in range(1, 64):
        blocked = np.zeros(len(who), bool) if world.terrain is None else ~world.terrain.free(place[:, 0], place[:, 1])
        if not blocked.any():
            break
        for axis in range(2):
            place[blocked, axis] = random.draw_many(key, who[blocked],
                                                    random.PLACE + (axis << 8) + salt + (attempt << 12)) * space.lengths[axis]
    values: dict[tuple[type, str], np.ndarray] = {(Position, "x"): place[:, 0], (Position, "y"): place[:, 1], (Position, "z"): place[:, 2],
              (Position, "heading"): random.draw_many(key, who, random.SEX + (1 << 8) + salt) * np.float32(6.2831855)}
    if Biology in table and table.traits.get("sex") == "random":
        values[Biology, "sex"] = np.where(random.draw_many(key, who, random.SEX + salt) < 0.5, 1, 2).astype(np.uint8)
    return values
