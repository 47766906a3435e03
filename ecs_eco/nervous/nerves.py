"""The nervous system of a species: its senses, and three networks (the paper's Definition 3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Experience, LearningRates, Memory, Motor, Nervous, Policy, Traits
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.learning.continuous import CONTINUOUS
from ecs_eco.nervous.decision import all_finite
from ecs_eco.nervous.networks import HappinessNetwork, Network, ReflexNetwork, mean_of
from ecs_eco.nervous.ranges import Ranges
from ecs_eco.nervous.sensors.sense import NOTHING_SENSED, Sense
from ecs_eco.nervous.thoughts import Thoughts

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.learning.individual import Individuals
    from ecs_eco.learning.learner import RolloutLearner
    from ecs_eco.learning.policy_network import PolicyNetwork
    from ecs_eco.space.world import SpatialWorld


class Nerves:
    """Senses, actions and networks of one species, and this tick's observations of all its members.

    `groups` maps a group to its actions; `actions` lists them in the order of y, z and the decision. `rows`
    i64[n] and `x` f32[n, channels] are the organisms that sensed, in canonical order, and their observations;
    `sensed` gives observers of the world the same observations by uid; it is empty during sensing. Each
    network is optional: without a reflex network, y is 0; without a policy, z is 0; without a happiness
    network, the reward is 0. The policy is one `brain` for all members, trained by `learner`, or one brain
    per individual (`individuals`), stored in the columns of Policy and Experience. `ranges` are the limits of
    the continuous groups, each of which has a single action with the group's name.
    """

    def __init__(
        self,
        channels: Sequence[str],
        senses: Sequence[tuple[Sense, int]],
        groups: dict[str, list[str]],
        neutral: dict[str, Any],
        automatic: Sequence[str],
        readings: dict[str, tuple[int, ...]],
        ranges: dict[str, tuple[float, float]] | None = None,
    ) -> None:
        self.channels, self.senses, self.groups, self.readings = (
            tuple(channels),
            list(senses),
            dict(groups),
            dict(readings),
        )
        self.actions = [(g, a) for g, actions in groups.items() for a in actions]
        self.columns = {
            g: (sum(len(v) for v in list(groups.values())[:i]), len(a))
            for i, (g, a) in enumerate(groups.items())
        }
        self.ranges = Ranges(
            {
                group: ((ranges or {})[group], start, neutral.get(group))
                for group, (start, _) in self.columns.items()
                if group in (ranges or {})
            }
        )
        self.neutral = {
            g: (actions.index(neutral[g]) if g in neutral and g not in self.ranges.groups else -1)
            for g, actions in groups.items()
        }
        self.eats = next((i for i, (_, action) in enumerate(self.actions) if action == "eat"), -1)  # −1: none
        self.automatic = np.array(
            [a in automatic or f"{g}.{a}" in automatic for g, a in self.actions], np.bool_
        )
        self.always = self.automatic.copy()  # active unless a reflex blocks it
        self.always[self.ranges.columns] = True
        self.reflex: Network | None = None
        self.happiness: Network | None = None
        self.minimum = np.float32(0.0)
        self.brain: PolicyNetwork | None = None
        self.learner: RolloutLearner | None = None
        self.individuals: Individuals | None = None
        # whether there is a policy; without a brain, it draws every action with equal probability
        self.policy = False
        self.outside: Any = None  # `nervous.outside.Outside`, which replaces a network
        self.learning = False
        self.heads()
        self.shift: np.ndarray | None = None  # f32[n, continuous]: added by the reflex in this tick
        self.rows = np.zeros(0, np.int64)
        self.sensed = NOTHING_SENSED
        self._later = np.zeros((0, 0), np.float32)  # the memories after the current observations
        self._x = np.zeros(0, np.float32)
        self._rows = (self.readout(0), self._x)  # x, and a copy that is contiguous by row
        self.thoughts: Thoughts | None = None  # from the last tick, for observers
        self.reports: list[dict[str, float]] = []

    def heads(self) -> None:
        """Lay out the policy's choices: one for each group that is not automatic, continuous groups last; a
        single action gets the alternative "not"."""
        sizes, targets = [], []
        for group, (start, n) in self.columns.items():
            if self.automatic[start : start + n].all() or group in self.ranges.groups:
                continue
            targets += [-1, start] if n == 1 else list(range(start, start + n))
            sizes.append(max(n, 2))
        self.choices = (*sizes, *(CONTINUOUS for _ in self.ranges.groups))
        self.offsets = np.cumsum([0, *sizes]).astype(np.int64)
        self.targets = np.array(targets, np.int64)  # the action of a head's option; −1: none

    def readout(self, n: int) -> np.ndarray:
        """Return the empty observation matrix f32[n, channels]; each channel is contiguous."""
        channels = len(self.channels)
        if len(self._x) < n * channels:
            self._x = np.zeros((n + n // 4) * channels, np.float32)
        self.x = self._x[: n * channels].reshape(channels, n).T
        return self.x

    @property
    def x_by_row(self) -> np.ndarray:
        """The observation matrix of this tick, contiguous by organism."""
        if self._rows[0] is not self.x:
            self._rows = self.x, np.ascontiguousarray(self.x)
        return self._rows[1]

    def column(self, action: str) -> int:
        """Return the column of an action, "run" or "speed.run", in the decision."""
        columns = [i for i, (g, a) in enumerate(self.actions) if action in (a, f"{g}.{a}")]
        if len(columns) != 1:
            raise UnknownName(
                unknown_name("nerves", "or ambiguous action", action, [f"{g}.{a}" for g, a in self.actions])
            )
        return columns[0]

    def doing(self, table: Table, action: str) -> np.ndarray:
        """Return which organisms execute an action, such as "graze" or "speed.run": bool[capacity], in row
        order.

        One action per group is executed: the first active one in declared order, or the default if none is
        active.
        """
        group = self.actions[column := self.column(action)][0]
        start, n = self.columns[group]
        on, place = table[Nervous].decision[:, start : start + n] > 0, column - start
        does = on[:, place] & ~on[:, :place].any(axis=1)
        if place == self.neutral[group]:
            does |= ~on.any(axis=1)
        return does & table.alive

    def amount(self, table: Table, group: str) -> np.ndarray:
        """Return the executed numbers of a continuous action, in its unit: f32[capacity]. Raises UnknownName
        for any other group.
        """
        if group not in self.ranges.groups:
            raise UnknownName(
                unknown_name(
                    f"nervous system of {table.name!r}", "continuous action", group, self.ranges.groups
                )
            )
        amounts: np.ndarray = table[Motor].command[:, self.ranges.groups.index(group)]
        return amounts

    def reading(self, name: str, x: np.ndarray) -> np.ndarray:
        """Return the value of a name in a formula, a channel or the mean of several channels: f32[n]."""
        return mean_of(x, self.readings[name])

    # --- inference and learning, shared or individual --------------------------------------------------------

    def think(self, table: Table, world: SpatialWorld) -> tuple[np.ndarray, np.ndarray]:
        """Return the policy's logits f32[n, options] and values f32[n] for the current observations; zeros if
        there is no network.

        Raises a FloatingPointError that names the species, tick and organism if a number is not finite.
        """
        if self.individuals is not None:
            thought = self._ask_each(table, world, self.rows, self.x_by_row)
        elif self.brain is not None:
            thought = self._ask(self.brain, table, world)
        else:
            return (
                np.zeros((len(self.rows), sum(self.choices)), np.float32),
                np.zeros(len(self.rows), np.float32),
            )
        if not all_finite(thought[0].reshape(-1), thought[1].reshape(-1)):
            self._complain(table, world, thought)
        return thought

    def _ask(self, brain: PolicyNetwork, table: Table, world: SpatialWorld) -> tuple[np.ndarray, np.ndarray]:
        """Run the shared brain, with a separate memory for each organism if the brain has one."""
        if not brain.memory:
            if world.bands.size == 1:
                return brain.forward(self.x, world.split)
            return _divided(world, brain, len(self.x), lambda h: brain.forward(self.x[h], world.split))
        logits, values, self._later = brain.recall(self.x_by_row, table[Memory].state[self.rows], world.split)
        return logits, values

    def _ask_each(
        self, table: Table, world: SpatialWorld, rows: np.ndarray, x: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Run the individual networks of these rows on x, with a separate memory for each organism."""
        minds = self.individuals
        assert minds is not None
        if not minds.memory:
            return _divided(
                world,
                minds,
                len(rows),
                lambda here: minds.forward(table[Policy], rows[here], x[here], world.split),
            )
        recall: Any = minds.recall  # type: ignore[attr-defined]
        logits, values, self._later = recall(table[Policy], rows, x, table[Memory].state[rows])
        return logits, values

    def keep(self, table: Table) -> None:
        """Store the memories after this tick."""
        table[Memory].state[self.rows] = self._later

    def _complain(self, table: Table, world: SpatialWorld, thought: tuple[np.ndarray, np.ndarray]) -> None:
        logits, values = thought
        mad = np.flatnonzero(~(np.isfinite(logits).all(axis=1) & np.isfinite(values)))
        if mad.size:
            i, blind = int(mad[0]), np.flatnonzero(~np.isfinite(self.x[mad[0]]))
            why = "its observations are finite, but its weights are not"
            if blind.size:
                why = f"its observations are {self.channels[blind[0]]} = {self.x[i, blind[0]]}"
            raise FloatingPointError(
                f"{table.name}, tick {world.tick}: the policy of organism "
                f"{table.uid[self.rows[i]]} gives {[float(v) for v in logits[i]]} "
                f"({mad.size} of {len(self.rows)} organisms are affected); {why}"
            )

    def react(self, table: Table) -> np.ndarray | None:
        """Return the reflex network's y for the current observations, i8[n, actions]; None without such a
        network.

        Afterward, `shift` contains the numbers that the network adds to continuous actions, whose y is 0.
        """
        if self.reflex is None:
            self.shift = None
            return None
        shape = len(self.rows), len(self.actions)
        if not self.ranges.groups:
            return self._read(self.reflex, table, "reflex", shape)
        total = self._read(getattr(self.reflex, "total", self.reflex), table, "reflex", shape)
        self.shift = np.nan_to_num(total[:, self.ranges.columns].astype(np.float32))
        y: np.ndarray = np.sign(total).astype(np.int8)
        y[:, self.ranges.columns] = 0
        return y

    def feel(self, table: Table) -> np.ndarray | None:
        """Return the happiness for the current observations, f32[n]; None without a happiness network."""
        return (
            None
            if self.happiness is None
            else self._read(self.happiness, table, "happiness", (len(self.rows),))
        )

    def remember(
        self,
        table: Table,
        choice: np.ndarray,
        numbers: np.ndarray,
        log_probability: np.ndarray,
        values: np.ndarray,
    ) -> None:
        """Store observations and choices for learning: i16[n, choices], f32[n, continuous], f32[n],
        f32[n]."""
        if self.individuals is not None:
            if Memory in table:
                begins = self.rows[table[Experience].length[self.rows] == 0]
                table[Memory].began[begins] = table[Memory].state[begins]
            if numbers.shape[1]:
                drawn = table[Motor].drawn[self.rows]
                drawn[np.arange(len(drawn)), table[Experience].length[self.rows]] = numbers
                table[Motor].drawn[self.rows] = drawn
            self.individuals.store(
                table[Experience], self.rows, self.x_by_row, choice, log_probability, values
            )
        elif self.learner is not None:
            memory = table[Memory].state[self.rows] if self.learner.rollout.memory.shape[1] else None
            self.learner.rollout.store(self.rows, self.x, choice, log_probability, values, memory, numbers)

    def credit(self, table: Table, reward: np.ndarray) -> None:
        """Assign reward f32[n] to the last decisions of the organisms that sense now."""
        if self.individuals is not None:
            self.individuals.credit(table[Experience], self.rows, reward)
        elif self.learner is not None:
            self.learner.rollout.credit(self.rows, reward)

    def end(self, rows: np.ndarray, reward: np.ndarray) -> None:
        """Assign reward f32[k] to the last decisions of the dying rows i64[k]; the experience of individual
        learners dies with them."""
        if self.individuals is None and self.learner is not None:
            self.learner.rollout.end(rows, reward)

    def leave(self, rows: np.ndarray) -> None:
        """Close the records of rows i64[k] that emigrate: experience stays behind if the learner is shared,
        and leaves with the emigrants if each has its own."""
        if self.individuals is None and self.learner is not None:
            self.learner.rollout.leave(rows)

    def learn(self, table: Table, world: SpatialWorld) -> None:
        """Update the shared brain if its rollout is full, or the brains of individuals whose rollouts are full."""
        try:
            self._learn(table, world)
        except FloatingPointError as error:
            raise FloatingPointError(f"{table.name}, tick {world.tick}: {error}") from error

    def _learn(self, table: Table, world: SpatialWorld) -> None:
        if self.individuals is not None:
            due = self.individuals.due(
                table[Experience], self.rows, table.uid[self.rows], table.born[self.rows], world.tick
            )
            if due.any():
                self._learn_alone(table, world, np.flatnonzero(due))
        elif self.learner is not None and self.learner.full:
            _, values = self.think(table, world)
            self.learner.bands = world.bands.common
            if (report := self.learner.update(self.rows, values)) is not None:
                self.reports.append({"tick": world.tick, **report})

    def _learn_alone(self, table: Table, world: SpatialWorld, due: np.ndarray) -> None:
        """Train some of the organisms that sense now, each on its own experience; `due` i64[k] are their
        positions among all organisms that sense."""
        minds = self.individuals
        assert minds is not None
        rows = self.rows[due]
        _, values = self._ask_each(table, world, rows, self.x_by_row[due])
        settings = None
        if LearningRates in table:
            own = table[LearningRates]
            settings = own.learning_rate[rows], own.discount[rows], own.entropy[rows]
        began: dict[str, Any] = {"memory": table[Memory].began[rows]} if Memory in table else {}
        if self.ranges.groups:
            began["numbers"] = table[Motor].drawn[rows]
        coded = [key for key in table.species.traits if key.startswith("ppo.")]
        if coded:
            began["own"] = {
                key.removeprefix("ppo."): table[Traits].value[rows, table.species.traits[key]]
                for key in coded
            }
        minds.bands = world.bands
        report = minds.learn(
            table[Policy], table[Experience], rows, table.uid[rows], values, settings, world.split, **began
        )
        self.reports[:] = [
            {"tick": world.tick, **report}
        ]  # only the latest report, because some species learn in nearly every tick

    def _read(self, network: Network, table: Table, name: str, shape: tuple[int, ...]) -> np.ndarray:
        owner = getattr(network, "__self__", network)  # the object, if the network is a method
        x = self.x if isinstance(owner, ReflexNetwork | HappinessNetwork) else self.x_by_row
        out = network(x, table, self.rows) if getattr(owner, "individual", False) else network(x)
        if not isinstance(out, np.ndarray) or out.shape != shape:
            raise ValueError(
                f"{table.name}: the {name} network gives {type(out).__name__} {np.shape(out)}; "
                f"expected: an array {shape}"
            )
        return out

    def by_uid(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Return a `state()` that identifies organisms by uid instead of row; `rows` i64[n] are the living
        rows in uid order."""
        if self.learner is None:
            return self.state()
        return {f"learner.{k}": v for k, v in self.learner.by_uid(rows).items()}

    def reorder(self, order: np.ndarray) -> None:
        """Follow organisms that have moved to other rows: the organism from row `order[i]`, i64[capacity], is
        now in row i."""
        if self.learner is not None:
            self.learner.rollout.reorder(order)
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        self.rows = place[self.rows]

    def state(self) -> dict[str, np.ndarray]:
        """Return everything that a run can change: the weights and, if the species learns, the optimizer
        state and the rollout."""
        out: dict[str, np.ndarray] = {}
        if self.brain is not None:
            out |= {f"brain.{k}": v for k, v in self.brain.state().items()}
        if self.learner is not None:
            out |= {f"learner.{k}": v for k, v in self.learner.state().items()}
        return out

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Load a `state()`."""
        for part in ("brain", "learner"):
            inner = {k.removeprefix(f"{part}."): v for k, v in state.items() if k.startswith(f"{part}.")}
            if inner:
                getattr(self, part).load(inner)


def _divided(
    world: SpatialWorld,
    network: PolicyNetwork | Individuals,
    n: int,
    forward: Callable[[slice], tuple[np.ndarray, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray]:
    """Return the logits and values of n organisms, of which each process computes only its part if rows are
    independent."""
    if world.bands.size == 1 or not network.by_row:
        return forward(slice(None))
    logits, values = forward(slice(*world.bands.part(n)))
    return world.bands.gathered(n, logits), world.bands.gathered(n, values)
