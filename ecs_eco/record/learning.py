"""Records of learning and actions: every policy update, and how often each action is taken."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Nervous
from ecs_eco.record.frame import as_table, joined, under

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

EVERY = 10  # ticks between two counts of actions
UPDATE = (
    "reward",
    "entropy",
    "approx_kl",
    "explained_variance",
    "policy_loss",
    "value_loss",
    "clip_fraction",
    "gradient_norm",
    "learning_rate",
)
"""Statistics of an update: f32, NaN if undefined; named as in `Learner.update`."""
LEARNING = {
    "tick": np.int64,
    "species": np.int8,
    "n_transitions": np.int32,
    "n_learners": np.int32,
    **dict.fromkeys(UPDATE, np.float32),
}
ACTIONS = {"tick": np.int64, "species": np.int8, "action": np.int16, "n": np.int32, "of": np.int32}


@njit
def count_actions(rows, alive, born, tick, decision, start, size, neutral, done):
    """In done i64[actions], count the actions of organisms that decided in this tick; return the number of
    these organisms. In each group, the first active action is counted or, if none is active, the default
    action."""
    n = 0
    for row in rows:
        if not alive[row] or born[row] >= tick:
            continue
        n += 1
        for g in range(len(start)):
            place = neutral[g]
            for k in range(size[g] - 1, -1, -1):  # without branches, because actions are unpredictable
                place = k if decision[row, start[g] + k] > 0 else place
            if place >= 0:
                done[start[g] + place] += 1
    return n


class LearningPages:
    """Rows that have not yet been written: one per policy update (for individual learners, one row of means per
    tick with updates), and one per action, every `EVERY` ticks.

    Continuous actions are not counted, because they belong to no group.
    """

    def __init__(self, world: SpatialWorld, names: Sequence[str]) -> None:
        self.names = list(names)
        self.thinking = {
            name: s for s, name in enumerate(names) if world.tables[name].species.nerves is not None
        }
        self.actions = list(dict.fromkeys(a for name in self.thinking for a in named(world.tables[name])))
        # blocks that stay in memory
        self.blocks: dict[str, list[dict[str, np.ndarray]]] = {"learning": [], "actions": []}
        self.rows: dict[str, list[tuple[Any, ...]]] = {"learning": [], "actions": []}

    def turn(self, world: SpatialWorld) -> None:
        """Record this tick's updates and actions."""
        for name, s in self.thinking.items():
            table = world.tables[name]
            reports = table.species.nerves.reports
            if reports and reports[-1]["tick"] == world.tick and (last := reports[-1])["n_transitions"]:
                self.rows["learning"].append(
                    (
                        world.tick,
                        s,
                        last["n_transitions"],
                        last.get("n_animals", 1),
                        *(last[word] for word in UPDATE),
                    )
                )
            if world.tick % EVERY == 0:
                n, done = counted(table, world.tick)
                for action, k in done.items() if n else ():
                    self.rows["actions"].append((world.tick, s, self.actions.index(action), k, n))

    def columns(self, kind: str) -> dict[str, np.ndarray]:
        """Return the rows of a kind as columns."""
        types = LEARNING if kind == "learning" else ACTIONS
        turned = zip(*self.rows[kind], strict=True) if self.rows[kind] else ([] for _ in types)
        return {
            name: np.array(column, dtype) for (name, dtype), column in zip(types.items(), turned, strict=True)
        }

    @property
    def words(self) -> dict[str, list[str]]:
        """Return the strings that numbers in columns stand for: column → strings."""
        return {"species": self.names, "action": self.actions}

    def flush(self, sink: Callable[[str, dict[str, np.ndarray]], None] | None) -> None:
        """Pass the rows to the sink, or keep them as blocks."""
        for kind in self.rows:
            if self.rows[kind]:
                if sink is not None:
                    sink(kind, self.columns(kind))
                else:
                    self.blocks[kind].append(self.columns(kind))
                self.rows[kind] = []

    def series(self, kind: str) -> Any:
        """Return all rows of a kind ("learning" or "actions") still in memory, as a pyarrow.Table."""
        return as_table([*self.blocks[kind], self.columns(kind)], self.words)

    def state(self) -> dict[str, np.ndarray]:
        """Return the blocks in memory, after `flush`."""
        parts = (joined(blocks, f"{kind}/") for kind, blocks in self.blocks.items())
        return {name: column for part in parts for name, column in part.items()}

    def load(self, state: Mapping[str, np.ndarray]) -> None:
        """Continue from a `state()`."""
        for kind in self.rows:
            block = under(state, f"{kind}/")
            self.rows[kind], self.blocks[kind] = [], [block] if block else []


def named(table: Table) -> list[str]:
    """Return the discrete actions of a table, such as "speed.run"."""
    nerves = table.species.nerves
    return [f"{group}.{action}" for group, action in nerves.actions if group not in nerves.ranges.groups]


def counted(table: Table, tick: int) -> tuple[int, dict[str, int]]:
    """Return how many living organisms decided in this tick, and how many of them took each action."""
    nerves = table.species.nerves
    groups = [g for g in nerves.columns if g not in nerves.ranges.groups]
    start, size = (np.array([nerves.columns[g][i] for g in groups], np.int64) for i in range(2))
    neutral = np.array([nerves.neutral[g] for g in groups], np.int64)
    done = np.zeros(len(nerves.actions), np.int64)
    n = count_actions(
        nerves.rows, table.alive, table.born, tick, table[Nervous].decision, start, size, neutral, done
    )
    return int(n), {
        f"{group}.{action}": k
        for (group, action), k in zip(nerves.actions, done.tolist(), strict=True)
        if group not in nerves.ranges.groups
    }
