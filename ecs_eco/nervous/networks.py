"""The reflex and happiness networks that a species declares; weights can differ between individuals."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import HappinessWeights, Instincts, Nervous, Reflexes
from ecs_eco.config.formula import compile_formula
from ecs_eco.genomes.own_values import own_value
from ecs_eco.inputs.code import handed_over
from ecs_eco.nervous.formula_steps import steps_of

if TYPE_CHECKING:
    from ecs_eco.config.models.nerves import Happiness, Reflex
    from ecs_eco.engine.table import Table

Network = Callable[..., np.ndarray]
"""network(x f32[n, channels]) -> f32[n] (happiness) or [n, actions] (reflex); each may be a plain function.

A network whose attribute `individual` is true is called as network(x, table, rows) and reads the weights of
rows i64[n].
"""


class ReflexNetwork:
    """y, the sign of the sum of connections, formulas and a function: i8[n, actions] of −1, 0, 1.

    For continuous actions, the sum itself is added, and a connection contributes the action's whole range.
    """

    def __init__(
        self,
        config: Reflex,
        nerves: Any,
        action_rows: dict[str, int],
        individual: bool = False,
        find: Callable[[Any], Any] = handed_over,
    ) -> None:
        self.individual, self.nerves = individual, nerves
        self.formulas = {
            action_rows[a]: compile_formula(text, nerves.readings) for a, text in config.formulas.items()
        }
        self.function = find(config.function) if config.function else None
        connections = config.connections
        self.channels, self.starts = _readings([nerves.readings[c.sensor] for c in connections])
        self.actions = np.array([action_rows[c.action] for c in connections], np.int64)
        self.above = np.array([c.above is not None for c in connections], np.bool_)
        self.weight = np.array([[c.weight for c in connections]], np.int8).reshape(1, -1)
        self.threshold = np.array(
            [[c.above if c.above is not None else c.below for c in connections]], np.float32
        ).reshape(1, -1)

    def __call__(
        self, x: np.ndarray, table: Table | None = None, rows: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the reaction to x f32[n, channels]; individual weights and thresholds come from `rows`
        i64[n] of a table."""
        return np.sign(self.total(x, table, rows)).astype(np.int8)

    def total(self, x: np.ndarray, table: Table | None = None, rows: np.ndarray | None = None) -> np.ndarray:
        """Return the sum whose sign is y: f32[n, actions]."""
        nerves = self.nerves
        total = np.zeros((len(x), len(nerves.actions)), np.float32)
        if self.actions.size:
            weight, threshold, which = self.weight, self.threshold, np.zeros(len(x), np.int64)
            if self.individual and table is not None and Reflexes in table:
                weight, threshold = table[Reflexes].weight, table[Reflexes].threshold
                which = which if rows is None else rows
            connect(
                x.T, self.channels, self.starts, self.actions, self.above, weight, threshold, which, total
            )
            if nerves.ranges.groups:
                ends = nerves.ranges if table is None or rows is None else nerves.ranges.of(table, rows)
                total[:, nerves.ranges.columns] *= ends.high - ends.low
        for column, formula in self.formulas.items():
            total[:, column] += formula({n: nerves.reading(n, x) for n in formula.names})
        if self.function is not None:
            total += _asked(self.function, "reflex", x, table if self.individual else None, rows)
        return total


class HappinessNetwork:
    """Happiness f32[n] from weights, a formula or a function, never below the declared minimum."""

    def __init__(
        self,
        config: Happiness,
        nerves: Any,
        individual: bool = False,
        find: Callable[[Any], Any] = handed_over,
    ) -> None:
        self.individual, self.nerves, self.least = individual, nerves, np.float32(config.minimum)
        self.function = find(config.function) if config.function else None
        self.formula = compile_formula(config.formula, nerves.readings) if config.formula else None
        self.steps = (
            steps_of(config.formula, nerves.readings) if config.formula and self.function is None else None
        )
        self.channels, self.starts = _readings([nerves.readings[n] for n in config.weights])
        self.weight = np.array([list(config.weights.values())], np.float32).reshape(1, -1)

    def __call__(
        self, x: np.ndarray, table: Table | None = None, rows: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the happiness for x f32[n, channels]; individual weights come from `rows` i64[n] of a table."""
        if self.function is not None:
            felt = _asked(self.function, "happiness", x, table if self.individual else None, rows)
        elif self.formula is not None:
            values, nerves = {}, self.nerves
            for name in self.formula.names:  # most names represent one channel
                channels = nerves.readings[name]
                values[name] = x[:, channels[0]] if len(channels) == 1 else mean_of(x, channels)
            felt = self.formula(values)
            if felt.shape != (len(x),):
                felt = np.broadcast_to(felt, len(x))
        else:
            own = (
                table[HappinessWeights].weight
                if self.individual and table is not None and HappinessWeights in table
                else None
            )
            felt = np.empty(len(x), np.float32)
            which = np.zeros(len(x), np.int64) if own is None or rows is None else rows
            weigh(x.T, self.channels, self.starts, self.weight if own is None else own, which, felt)
        least = self.least if table is None else own_value(table, "happiness.minimum", self.least)
        if isinstance(least, np.ndarray):
            least = least[rows]
        return np.maximum(felt.astype(np.float32, copy=False), least)


def last_reward(table: Table, rows: np.ndarray) -> np.ndarray:
    """Return the reward for dying f32[k]: the minimum happiness minus the last happiness of the dying rows
    i64[k]; 0 if there is no happiness network."""
    nerves = table.species.nerves
    if nerves.happiness is None:
        return np.zeros(rows.size, np.float32)
    least = own_value(table, "happiness.minimum", nerves.minimum)
    felt: np.ndarray = table[Nervous].happiness[rows]
    return (least[rows] if isinstance(least, np.ndarray) else least) - felt


def mean_of(x: np.ndarray, channels: tuple[int, ...]) -> np.ndarray:
    """Return one channel of x f32[n, channels] or the mean of several: f32[n]."""
    if len(channels) == 1:
        return x[:, channels[0]]
    if len(channels) < 8:
        some: np.ndarray = np.float32(0) + x[:, channels[0]]
        for channel in channels[1:]:
            some += x[:, channel]
        some /= np.float32(len(channels))
        return some
    total = np.add.reduce(x[:, list(channels)], axis=1, dtype=np.float32)
    mean: np.ndarray = np.true_divide(total, len(channels), out=total, casting="unsafe")
    return mean


def _asked(
    function: Any, word: str, x: np.ndarray, table: Table | None, rows: np.ndarray | None
) -> np.ndarray:
    """Return the output of a function for x f32[n, channels]; a network with heritable weights uses each
    organism's weights."""
    x = np.ascontiguousarray(x)  # the order in which libraries sum depends on the layout
    if table is None or Instincts not in table or not (own := getattr(table[Instincts], word)).shape[1]:
        return np.asarray(function(x))
    return np.asarray(function.each(x, own[rows]))


def _readings(rows: list[tuple[int, ...]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the concatenated channels of several readings, and where each reading begins: i64[…],
    i64[readings + 1]."""
    flat = [channel for reading in rows for channel in reading]
    return np.array(flat, np.int64), np.cumsum([0, *(len(reading) for reading in rows)]).astype(np.int64)


@njit
def read(x, i, channels, first, last):
    """Return the mean of some channels of organism i in x f32[channels, n]."""
    total = np.float32(0.0)
    for k in range(first, last):
        total += x[channels[k], i]
    return total / np.float32(last - first)


@njit
def connect(x, channels, starts, actions, above, weight, threshold, rows, total):
    """Add the weight of each active connection to its action: total f32[n, actions]."""
    for i in range(rows.size):
        row = rows[i]
        for c in range(actions.size):
            w = weight[row, c]
            if w != 0:
                value, edge = read(x, i, channels, starts[c], starts[c + 1]), threshold[row, c]
                if (value > edge) if above[c] else (value < edge):
                    total[i, actions[c]] += w


@njit
def weigh(x, channels, starts, weight, rows, felt):
    """Write the weighted sum of each organism's readings to felt f32[n]."""
    for i in range(rows.size):
        total = np.float32(0.0)
        for c in range(starts.size - 1):
            total += weight[rows[i], c] * read(x, i, channels, starts[c], starts[c + 1])
        felt[i] = total
