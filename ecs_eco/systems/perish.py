"""Organisms die when a property leaves the range in which they can live."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Biology, LifeHistory, Nervous
from ecs_eco.config.numbers import labels
from ecs_eco.engine.addresses import address_of, column_at
from ecs_eco.engine.noted import Noted
from ecs_eco.engine.schema import Columns
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_values
from ecs_eco.life.causes import register_limits
from ecs_eco.nervous.networks import last_reward
from ecs_eco.nervous.sensors.own import own_column
from ecs_eco.space.world import SpatialWorld

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Perish(System):
    """An organism dies when one of its properties leaves the range in which it can live. Each end of each
    range is a separate cause of death.

    The reward at death is the minimum happiness minus the last happiness value.
    """

    phase = "die"
    divisible = True
    submodel = Submodel(
        "Death",
        where=("lethal",),
        reads=("lethal",),
        rules={
            "": "An individual dies in the tick in which a property is at or below `min`, or at or above "
            "`max`."
        },
    )
    world: SpatialWorld
    _causes: Sequence[str] = ()  # the limits were derived from these
    _known: dict[str, Limits]  # by table

    def start(self, world: SpatialWorld) -> None:
        """Register the causes of death, species by species."""
        for table in world.tables.values():
            register_limits(world, table)
        world.on_death.append(self.mourn)

    def process(self, *_: object) -> None:
        """Mark organisms beyond a limit."""
        if self._causes != self.world.causes:
            self._known = {}
        for table in self.world.tables.values():
            if not table.species.lethal:
                continue
            if table.species.traits or LifeHistory in table or (limits := self._limits(table)) is None:
                self.one_by_one(table)
            else:
                perish_all(table.alive[: table.high], table.cause, *limits)
        self._causes = list(self.world.causes)

    def _limits(self, table: Table) -> tuple[np.ndarray, ...] | None:
        """Return the column addresses, ends and causes of all limits of one species; None if a value is not
        an f32 column."""
        now, lethal = (Noted.changes, Columns.replaced), table.species.lethal
        known = self._known.get(table.name)
        if known is None or known.made_from != now or known.lethal != lethal:
            known = self._known[table.name] = Limits.of(now, table, self.world)
        return known.limits

    def one_by_one(self, table: Table) -> None:
        """Mark organisms of one species beyond a limit, if limits are individual or the limited values are
        derived."""
        codes = self.world.codes
        names = labels(table.species.lethal) if table.species.traits else []
        for i, limit in enumerate(table.species.lethal):
            low, high = limit.min, limit.max
            column = own_column(table, limit.property, self.world.substances)
            if limit.property == "age" and high is not None and LifeHistory in table:
                # the limit is individual
                column, high = table[Biology].age - table[LifeHistory].age_max, 0.0
                low = None
            ends = ends_of(low, high)
            if names:
                ends = own_values(
                    table, {f"lethal.{names[i]}.min": ends[0], f"lethal.{names[i]}.max": ends[1]}
                )
            perish(
                table.alive[: table.high],
                column,
                *ends,
                0 if low is None else codes[limit.cause_below],
                0 if high is None else codes[limit.cause_above],
                table.cause,
            )

    def mourn(self, table: Table, rows: np.ndarray) -> None:
        """Give dying organisms of one species the reward for death, whatever the cause, in addition to this
        tick's reward; rows i64[k] are in uid order."""
        nerves = table.species.nerves
        if nerves is None or nerves.happiness is None:
            return
        n = table[Nervous]
        if table.species.traits:
            last = last_reward(table, rows)
        else:  # the same value without a function call
            last = nerves.minimum - n.happiness[rows]
        n.reward[rows] += last
        if nerves.learning:
            nerves.end(rows, last)


class Limits(NamedTuple):
    """The limits of one species, if all members share them and all values are columns."""

    made_from: tuple[Any, ...]  # valid as long as these are unchanged
    lethal: list[Any]
    columns: list[np.ndarray]  # kept because only their addresses are used
    limits: tuple[np.ndarray, ...] | None

    @classmethod
    def of(cls, made_from: tuple[Any, ...], table: Table, world: SpatialWorld) -> Limits:
        """Return the current limits of a table."""
        lethal = list(table.species.lethal)
        twice = [[own_column(table, limit.property, world.substances) for _ in range(2)] for limit in lethal]
        if not all(
            a is b and type(a) is np.ndarray and a.dtype == np.float32 and a.ndim == 1 for a, b in twice
        ):  # a new array each time, because it is derived from other columns
            return cls(made_from, lethal, [], None)
        columns = [column for column, _ in twice]
        codes = [
            (
                0 if limit.min is None else world.codes[limit.cause_below],
                0 if limit.max is None else world.codes[limit.cause_above],
            )
            for limit in lethal
        ]
        return cls(
            made_from,
            lethal,
            columns,
            (
                np.array([address_of(column) for column in columns], np.uint64),
                np.array([ends_of(limit.min, limit.max) for limit in lethal], np.float32),
                np.array(codes, np.uint8),
            ),
        )


def ends_of(low: float | None, high: float | None) -> tuple[np.float32, np.float32]:
    """Return the ends of an interval; open ends are infinite."""
    return np.float32(-np.inf if low is None else low), np.float32(np.inf if high is None else high)


@lone_njit
def perish(alive, value, low, high, too_low, too_high, cause):
    """Mark living organisms whose value is at or beyond a limit; organisms already dying keep their first
    cause. Branch-free, so that it vectorizes."""
    none, below, above = np.uint8(0), np.uint8(too_low), np.uint8(too_high)
    for k in range(alive.size):
        row = np.uint64(k)
        here, before = value[row], cause[row]
        after = below if here <= of_row(low, row) else (above if here >= of_row(high, row) else none)
        cause[row] = after if alive[row] & (before == none) else before


@njit
def perish_all(alive, cause, columns, ends, codes):
    """Run `perish` for several limits in order, given addresses u64[k] of f32 columns, `ends` f32[k, 2], and
    cause `codes` u8[k, 2]."""
    for k in range(columns.size):
        perish(
            alive,
            column_at(columns[k], np.float32, alive.size),
            ends[k, 0],
            ends[k, 1],
            codes[k, 0],
            codes[k, 1],
            cause,
        )
