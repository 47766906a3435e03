"""A species whose choices come from outside the world: your program gets the observations of all members as
an array and returns their choices."""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.components import Nervous
from ecs_eco.engine.errors import ConfigError, Problem, listed
from ecs_eco.engine.halves import Halves
from ecs_eco.engine.interruption import require_whole
from ecs_eco.engine.uids import matched
from ecs_eco.nervous.networks import last_reward
from ecs_eco.nervous.outside import Answer, Nobody, Outside, options_of, taken

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import ArrayLike

    from ecs_eco.engine.table import Table
    from ecs_eco.nervous.nerves import Nerves
    from ecs_eco.space.world import SpatialWorld


class Sensed(NamedTuple):
    """The observations of a species' members in one tick, and the outcome of their last choices.

    Attributes
    ----------
    x : array of float32, shape (n, channels)
        Readings of the organisms that sense. The world overwrites this array in the following tick.
    uid : array of uint64, shape (n,)
        uid of the organism in each row.
    reward : array of float32, shape (n,)
        Reward for the last choice; 0 for newborns.
    dead : array of uint64, shape (k,)
        uids of organisms that chose in the last tick and died.
    dead_x : array of float32, shape (k, channels)
        Their last observations.
    dead_reward : array of float32, shape (k,)
        The minimum happiness minus their last happiness value.
    dead_cause : tuple of str, length k
    """

    x: np.ndarray  # f32[n, channels]
    uid: np.ndarray  # u64[n]
    reward: np.ndarray  # f32[n], for the last choice; 0 for newborns
    dead: np.ndarray  # u64[k]
    dead_x: np.ndarray  # f32[k, channels], their last observations
    dead_reward: np.ndarray  # f32[k], for their last choice: the minimum happiness minus their last happiness
    dead_cause: tuple[str, ...]  # [k]


class Pending(Outside):
    """The choices of an external species for this tick, and the deaths among its members."""

    def __init__(self, some: bool) -> None:
        self.some = some  # whether choices for only some of the members suffice
        self.given: Answer | None = None
        self.uid = np.zeros(0, np.uint64)  # organisms that sense in this tick
        self.place = np.zeros(0, np.int64)  # position of each row among them
        self.dead: list[tuple[np.ndarray, np.ndarray, np.ndarray, tuple[str, ...]]] = []

    def require(self, species: str) -> None:
        """Raise a ConfigError, because choices cannot enter a tick that runs as a whole."""
        raise ConfigError(
            [
                Problem(
                    (species,),
                    "its choices come from outside, in the middle of a tick",
                    allowed=f'`observe` and `act` of world.external("{species}"), or `close`',
                    source="run",
                )
            ]
        )

    def answer(self, nerves: Nerves, table: Table, world: SpatialWorld) -> Answer:
        """Return the choices of this tick."""
        answer, self.given = self.given, None
        self.partial = answer is not None and answer.told is not None
        if answer is None:
            self.require(table.name)
        assert answer is not None
        return answer

    def note(self, nerves: Nerves, table: Table) -> None:
        """Record which organisms sense in this tick."""
        self.uid = table.uid[nerves.rows]
        if len(self.place) < len(table.uid):
            self.place = np.zeros(len(table.uid), np.int64)
        self.place[nerves.rows] = np.arange(len(nerves.rows))

    def mourn(self, world: SpatialWorld, table: Table, rows: np.ndarray) -> None:
        """Record the dying rows i64[k] before they are freed."""
        nerves = table.species.nerves
        if nerves is None or nerves.outside is not self or not len(self.uid):
            return
        at = np.minimum(self.place[rows], len(self.uid) - 1)
        sensed = self.uid[at] == table.uid[rows]
        rows, at = rows[sensed], at[sensed]
        if rows.size:
            causes = tuple(world.causes[cause - 1] for cause in table.cause[rows].tolist())
            self.dead.append((table.uid[rows], nerves.x[at].copy(), last_reward(table, rows), causes))


class External:
    """Control of a species by your program, opened with `World.external`: call `observe`, then `act`, once
    per tick. If several species are controlled, the tick continues when the last of them acts. Between
    `observe` and `act` the tick is incomplete, so save or copy the world only after `act`.

    Attributes
    ----------
    channels : tuple of str
        Names of the readings, the columns of `Sensed.x`.
    options : dict of str to tuple of str
        Names of the options in each action group; empty for a continuous group.
    low : array of float32, shape (groups,)
        Smallest valid choice in each group.
    high : array of float32, shape (groups,)
        Largest valid choice in each group.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco import World
    >>> world = World.from_config("predator-prey", seed=1, learn=False)
    >>> deer = world.external("deer")
    >>> deer.options["speed"]
    ('still', 'walk', 'run')
    >>> for tick in range(3):
    ...     sensed = deer.observe()
    ...     deer.act(np.full((len(sensed.uid), len(deer.options)), 1))
    >>> world.tick, deer.save("meadow.ckpt").name
    (3, 'meadow.ckpt')
    >>> deer.close()
    """

    def __init__(self, world: Any, species: str, partial: bool = False) -> None:
        self.world, self.species, self._table = world, species, world.table(species)
        nerves = self._nerves = _nerves_of(world, species)
        self.channels, self.options = nerves.channels, options_of(nerves)
        self.low, self.high = _ends(nerves)
        self._awaited = expect(world)
        require_whole(world, "open external control")
        self._before, self._pending = nerves.outside, Pending(partial)
        nerves.outside = self._pending
        self._mourn = _mourner(world, self._pending)
        world.on_death.append(self._mourn)

    def __repr__(self) -> str:
        return (
            f"<External {self.species!r}: {len(self.channels)} channels, "
            f"{len(self.options)} groups, {self._table.n} living>"
        )

    def observe(self) -> Sensed:
        """Start the tick and return the species' observations; until `act`, further calls return the same
        result.

        Returns
        -------
        Sensed
        """
        self._open()
        self._awaited.begin(self.world)
        nerves, pending = self._nerves, self._pending
        nobody = np.zeros(0, np.uint64), nerves.x[:0].copy(), np.zeros(0, np.float32), ()
        uid, x, reward, causes = zip(*(pending.dead or [nobody]), strict=True)
        return Sensed(
            nerves.x,
            pending.uid,
            self._table[Nervous].reward[nerves.rows],
            np.concatenate(uid),
            np.concatenate(x),
            np.concatenate(reward),
            sum(causes, ()),
        )

    def act(self, actions: ArrayLike, uid: ArrayLike | None = None) -> None:
        """Set the actions of the organisms that sense in this tick, and finish the tick.

        Parameters
        ----------
        actions : array, shape (n, groups)
            For each group, the index of an option or, for a continuous group, a number within its range.
        uid : array of uint64, shape (n,), optional
            uid of the organism in each row; default: the rows of `observe`.

        Raises
        ------
        ConfigError
            If an action is missing, given twice, impossible, or given for an organism that does not sense;
            nothing has been changed.
        """
        self._open()
        if not self._awaited.halves.begun:
            raise RuntimeError(f'world.external("{self.species}"): call `observe` before `act`')
        nerves, pending, table = self._nerves, self._pending, self._table
        source = f"act, tick {self.world.tick}"
        if uid is None:
            pending.given = taken(nerves, table, nerves.rows, actions, source)
        else:
            uids = np.asarray(uid, np.uint64).reshape(-1)
            places = self._places(uids, source)
            answer = taken(nerves, table, nerves.rows[places], actions, source)
            pending.given = _spread(answer, places, len(nerves.rows))
        self._awaited.finish(self.world)

    def save(self, path: str | Path) -> str | Path:
        """Write a checkpoint as soon as the current tick is complete.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        str or Path
            The path.
        """
        if not self._awaited.halves.begun:
            return self.world.save(path)
        self._awaited.saves.append(path)
        return path

    def close(self) -> None:
        """Return control to the species' own policy. This is not allowed between `observe` and `act`.

        Raises
        ------
        RuntimeError
            If a tick is in progress.
        """
        if self._awaited.halves.begun:
            raise RuntimeError(f'world.external("{self.species}"): a tick is in progress; call `act` first')
        if self._nerves.outside is self._pending:
            self._nerves.outside = self._before
        if self._mourn in self.world.on_death:
            self.world.on_death.remove(self._mourn)

    def _open(self) -> None:
        if self._nerves.outside is not self._pending:
            raise RuntimeError(f'world.external("{self.species}"): this control is closed; open another')

    def _places(self, uids: np.ndarray, source: str) -> np.ndarray:
        """Return the positions of uids u64[k] among organisms that sense. Raises a ConfigError for invalid
        uids."""
        mine = self._pending.uid
        order = np.argsort(mine)
        at, there = matched(mine[order], uids)
        problems: list[Problem] = []
        if not there.all():
            problems.append(
                self._problem("does not sense: dead, or of another species", uids[~there], source)
            )
        if len(np.unique(uids)) < len(uids):
            one, count = np.unique(uids, return_counts=True)
            problems.append(self._problem("given twice", one[count > 1], source))
        if not self._pending.some and len(missing := np.setdiff1d(mine, uids)):
            problems.append(self._problem("no action", missing, source))
        if problems:
            raise ConfigError(problems)
        return order[at]

    def _problem(self, fault: str, uids: np.ndarray, source: str) -> Problem:
        every = "at most" * self._pending.some or "exactly"
        return Problem(
            (self.species, "uid"),
            f"{fault} ({len(uids)} in all)",
            listed(map(str, uids.tolist())),
            f"{every} one action for each of the {len(self._pending.uid)} {self.species} that "
            "`observe` returned",
            source=source,
        )


class Awaited:
    """The ticks of a world in which some species wait for external choices."""

    def __init__(self, world: SpatialWorld) -> None:
        self.world = weakref.proxy(world)
        self.halves = Halves("decide")
        self.saves: list[Any] = []  # paths of checkpoints to write at the end of the current tick

    def require(self) -> None:
        """A hook before each tick that raises a ConfigError if the tick would find no choices."""
        for name, nerves in self._waiting(self.world):
            if not (self.halves.beginning and isinstance(nerves.outside, Pending)):
                nerves.outside.require(name)

    def begin(self, world: SpatialWorld) -> None:
        """Run the tick until choices are needed; all species that wait record which organisms sense."""
        if self.halves.begun:
            return
        self.halves.begin(world)
        for name, nerves in self._waiting(world):
            if isinstance(nerves.outside, Pending):
                nerves.outside.note(nerves, world.tables[name])

    def finish(self, world: SpatialWorld) -> None:
        """Continue the tick once no species is waiting."""
        outside = [nerves.outside for _, nerves in self._waiting(world)]
        pending = [one for one in outside if isinstance(one, Pending)]
        if all(one.given is not None for one in pending):
            for one in pending:
                one.dead = []
            self.halves.finish(world)
            saves, self.saves = self.saves, []
            for path in saves:
                world.save(path)  # type: ignore[attr-defined]

    def _waiting(self, world: SpatialWorld) -> list[tuple[str, Any]]:
        return [
            (name, table.species.nerves)
            for name, table in world.tables.items()
            if table.species.nerves is not None and table.species.nerves.outside is not None
        ]


def expect(world: SpatialWorld) -> Awaited:
    """Return the world's record of species that wait for choices; from now on, the world refuses ticks
    without choices."""
    if world.awaited is None:
        world.awaited = Awaited(world)
        world.before_tick.append(world.awaited.require)
    awaited: Awaited = world.awaited
    return awaited


def _mourner(world: SpatialWorld, pending: Pending) -> Any:
    """Return a hook through which `pending` records deaths, without a reference to the world."""
    of = weakref.proxy(world)

    def mourn(table: Table, rows: np.ndarray) -> None:
        pending.mourn(of, table, rows)

    return mourn


def _spread(answer: Answer, places: np.ndarray, n: int) -> Answer:
    """Expand an answer for the organisms at indices `places` i64[k] to one for all n organisms."""
    choice = np.zeros((n, answer.choice.shape[1]), np.int16)
    numbers, told = np.zeros((n, answer.numbers.shape[1]), np.float32), np.zeros(n, np.bool_)
    choice[places], numbers[places], told[places] = answer.choice, answer.numbers, True
    return Answer(choice, numbers, None if told.all() else told)


def _ends(nerves: Nerves) -> tuple[np.ndarray, np.ndarray]:
    """Return the limits of each group's choice: two f32[groups]."""
    sizes = np.diff(nerves.offsets)
    return (
        np.concatenate([np.zeros(len(sizes), np.float32), nerves.ranges.low]),
        np.concatenate([sizes - 1, nerves.ranges.high]).astype(np.float32),
    )


def _nerves_of(world: SpatialWorld, species: str) -> Nerves:
    """Return the nervous system of a species. Raises a ConfigError if the species cannot be controlled."""
    nerves: Nerves | None = world.table(species).species.nerves
    fault = allowed = ""
    if nerves is None or not nerves.policy:
        fault, allowed = "the policy has nothing to choose here", 'policy.kind = "external"'
    elif nerves.learning:
        fault, allowed = "its own policy is learning from its own choices", f'learn={{"{species}": False}}'
    elif nerves.outside is not None and not isinstance(nerves.outside, Nobody):
        fault, allowed = "it is already controlled", "one control at a time; `close` ends it"
    elif world.bands.size > 1:
        fault, allowed = "the world runs in several processes", "one process"
    if fault or nerves is None:
        raise ConfigError([Problem((species,), fault, allowed=allowed, source="external")])
    return nerves
