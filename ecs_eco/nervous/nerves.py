"""The nervous system of a species: what its members sense, and the three networks over it (the paper's Definition 3)."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Nervous
from ecs_eco.config.base import named_function
from ecs_eco.nervous.senses import Sense

if TYPE_CHECKING:
    from ecs_eco.learning.brain import Brain
    from ecs_eco.learning.ppo import Learner

Network = Callable[[np.ndarray], np.ndarray]
"""network(x f32[n, channels]) -> f32[n] (happiness) or [n, actions] (reflex); each may be a plain function."""


class Nerves:
    """Senses, actions and networks of one species, and this tick's readings of all its members.

    `groups` maps a group to its actions; their order in `actions` is that of y, z and the decision. `rows` i64[n] and
    `x` f32[n, channels] are who sensed, in canonical order, and what. Networks may be missing: no reflex is y = 0, no
    policy is z = 0, no happiness is 0 always.
    """

    def __init__(self, channels: Sequence[str], senses: Sequence[tuple[Sense, int]], groups: dict[str, list[str]],
                 neutral: dict[str, str], automatic: Sequence[str], readings: dict[str, tuple[int, ...]]) -> None:
        self.channels, self.senses, self.groups, self.readings = tuple(channels), list(senses), dict(groups), dict(readings)
        self.actions = [(g, a) for g, actions in groups.items() for a in actions]
        self.columns = {g: (sum(len(v) for v in list(groups.values())[:i]), len(a)) for i, (g, a) in enumerate(groups.items())}
        self.neutral = {g: (actions.index(neutral[g]) if g in neutral else -1) for g, actions in groups.items()}
        self.automatic = np.array([a in automatic or f"{g}.{a}" in automatic for g, a in self.actions], np.bool_)
        self.reflex: Network | None = None
        self.happiness: Network | None = None
        self.minimum = np.float32(0.0)
        self.brain: Brain | None = None
        self.learner: Learner | None = None
        self.policy = False  # whether there is a policy network; one without a brain draws every action with equal chance
        self.learning = False
        self.heads()
        self.rows = np.zeros(0, np.int64)
        self._x = np.zeros((0, len(self.channels)), np.float32)
        self.x = self._x
        self.reports: list[dict[str, float]] = []

    def heads(self) -> None:
        """Lay out the policy's choices: one per group that is not automatic; a lone action gets "not" as alternative."""
        sizes, targets = [], []
        for start, n in self.columns.values():
            if self.automatic[start : start + n].all():
                continue
            targets += [-1, start] if n == 1 else list(range(start, start + n))
            sizes.append(max(n, 2))
        self.choices = tuple(sizes)
        self.offsets = np.cumsum([0, *sizes]).astype(np.int64)
        self.targets = np.array(targets, np.int64)  # the action that a head's option stands for; −1: none

    def readout(self, n: int) -> np.ndarray:
        """Return the observation matrix f32[n, channels] to be filled."""
        if len(self._x) < n:
            self._x = np.zeros((n + n // 4, len(self.channels)), np.float32)
        self.x = self._x[:n]
        return self.x

    def column(self, action: str) -> int:
        """Return the column of an action, "run" or "speed.run", in the decision."""
        found = [i for i, (g, a) in enumerate(self.actions) if action in (a, f"{g}.{a}")]
        if len(found) != 1:
            from ecs_eco.errors import UnknownName, unknown_name

            raise UnknownName(unknown_name("nerves", "or ambiguous action", action, [f"{g}.{a}" for g, a in self.actions]))
        return found[0]

    def doing(self, table: Any, action: str) -> np.ndarray:
        """Return who does an action, "graze" or "speed.run": bool[capacity], in the order of rows.

        Of a group one action is done: the first that is on, in declared order; the neutral one where none is.
        """
        group = self.actions[column := self.column(action)][0]
        start, n = self.columns[group]
        on, place = table[Nervous].decision[:, start : start + n] > 0, column - start
        does = on[:, place] & ~on[:, :place].any(axis=1)
        if place == self.neutral[group]:
            does |= ~on.any(axis=1)
        return does & table.alive

    def reading(self, name: str, x: np.ndarray) -> np.ndarray:
        """Return what a name of a formula stands for: a channel, or the mean over several: f32[n]."""
        rows = self.readings[name]
        return x[:, rows[0]] if len(rows) == 1 else x[:, list(rows)].mean(axis=1, dtype=np.float32)

    def state(self) -> dict[str, np.ndarray]:
        """Return all that a run changes: the weights and, where it learns, optimiser state and rollout."""
        out: dict[str, np.ndarray] = {}
        if self.brain is not None:
            out |= {f"brain.{k}": v for k, v in self.brain.state().items()}
        if self.learner is not None:
            out |= {f"learner.{k}": v for k, v in self.learner.state().items()}
        return out

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Take a `state()`."""
        for part in ("brain", "learner"):
            inner = {k.removeprefix(f"{part}."): v for k, v in state.items() if k.startswith(f"{part}.")}
            if inner:
                getattr(self, part).load(inner)


def reflex_of(config: Any, nerves: Nerves, action_rows: dict[str, int]) -> Network:
    """Build a reflex network from connections, formulas and a function: y = sign of their sum, i8[n, actions]."""
    from ecs_eco.config import compile_formula

    formulas = {action_rows[a]: compile_formula(text, nerves.readings) for a, text in config.formulas.items()}
    function = named_function(config.function) if config.function else None
    n_actions = len(nerves.actions)

    def reflex(x: np.ndarray) -> np.ndarray:
        total = np.zeros((len(x), n_actions), np.float32)
        for c in config.connections:
            value = nerves.reading(c.sensor, x)
            fires = value > np.float32(c.above) if c.above is not None else value < np.float32(c.below)
            total[:, action_rows[c.action]] += np.float32(c.weight) * fires
        for column, formula in formulas.items():
            total[:, column] += formula({n: nerves.reading(n, x) for n in formula.names})
        if function is not None:
            total += function(x)
        return np.sign(total).astype(np.int8)

    return reflex


def happiness_of(config: Any, nerves: Nerves) -> Network:
    """Build a happiness network from weights, a formula or a function; never less than the declared minimum."""
    from ecs_eco.config import compile_formula

    least = np.float32(config.minimum)
    if config.function:
        inner = named_function(config.function)
    else:
        text = config.formula or " + ".join(f"({w}) * {n}" for n, w in config.weights.items())
        formula = compile_formula(text, nerves.readings)

        def inner(x: np.ndarray) -> np.ndarray:
            return np.broadcast_to(formula({n: nerves.reading(n, x) for n in formula.names}), len(x))

    def happiness(x: np.ndarray) -> np.ndarray:
        return np.maximum(inner(x).astype(np.float32), least)

    return happiness
