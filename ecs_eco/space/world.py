"""A world with positions: its space, its surroundings and its neighbor indexes, which sensors and systems
read."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ecs_eco._html import grid
from ecs_eco.components import Body, Position
from ecs_eco.engine.addresses import Addresses
from ecs_eco.engine.table import Table
from ecs_eco.esper_bridge.world import World
from ecs_eco.space import gate, pairs as near
from ecs_eco.space.environment import Environment
from ecs_eco.space.field import Field
from ecs_eco.space.geometry import Space
from ecs_eco.space.index import Index
from ecs_eco.space.nearest import nearest
from ecs_eco.space.one_band import OneBand
from ecs_eco.space.pairs import Pairs
from ecs_eco.space.terrain import Terrain

T = TypeVar("T")


class SpatialWorld(World):
    """Entities in one space, and the systems that act on them.

    `size` [m] and `edges` describe the space, and `cell` [m] is the cell side of the neighbor index.
    Everything else works as in `ecs_eco.esper_bridge.world.World`. Attributes that higher packages set, such as
    the configuration and the recorder, are declared here because systems use them.
    """

    def __init__(
        self,
        size: Sequence[float] = (100.0, 100.0),
        *,
        edges: str = "torus",
        dt: float = 1.0,
        seed: int = 0,
        cell: float | None = None,
        threads: int = 1,
        name: str = "world",
    ) -> None:
        self.space = Space(size, edges, cell)
        self.bands = OneBand()  # for several processes, see ecs_eco.bands
        self.environment = Environment()
        self.fields: dict[str, Field] = {}
        self.terrain: Terrain | None = None
        self.substances: list[str] = []
        self.bodiless: set[str] = set()  # causes of death other than being eaten that leave no body
        self.reproduction = True  # switched off during pre-training
        self.config: Any = None  # the WorldConfig from which the world was built
        self.recorder: Any = None
        self.own_systems: list[Any] = []  # systems that the configuration lists, in the order listed
        self.reporters: dict[str, Any] = {}  # values measured in every tick, by name
        self.matter: Any = None  # the Books for its substances (ecs_eco.life.matter)
        self.origin: dict[str, Any] = {}  # the arguments of `build`
        self.start: dict[str, Any] | None = None  # for a run that begins like this world; None: no run does
        self.awaited: Any = None  # ecs_eco.nervous.external.Awaited, if choices come from outside
        self.intervened: list[tuple[int, Any]] = []  # interventions carried out, as (tick, intervention)
        self.lock = threading.RLock()  # held while an object that threads share is created
        self._looked: gate.Looked | None = None
        self._indexes: dict[str, Index] = {}
        self._kept_merged: dict[tuple[str, tuple[str, ...]], tuple[tuple[int, ...], Any]] = {}
        super().__init__(dt=dt, seed=seed, threads=threads, name=name)
        tables = self.tables  # `self` would create a reference cycle
        # addresses of the columns alive, uid, x, y and z in each table, for kernels
        self.whereabouts = Addresses(lambda: [_whereabouts(table) for table in tables.values()])

    def _repr_html_(self) -> str:
        size = " × ".join(f"{side:g}" for side in self.space.size)
        rows = [
            (name, table.n, ", ".join(kind.__name__ for kind in table.columns))
            for name, table in self.tables.items()
        ]
        caption = f"World {self.name!r} at tick {self.tick:,}, seed {self.seed}, {size} m"
        return grid(("table", "alive", "components"), rows, caption)

    def stop(self) -> None:
        """Make `run` return after the current tick or, between ticks, before the next one; `stopped` is then
        true.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World()
        >>> world.before_tick.append(lambda: world.stop() if world.tick == 3 else None)
        >>> world.run(10).tick, world.stopped
        (3, True)
        """
        self.stopping = self.bands.stops()

    def species_names(self) -> list[str]:
        """Return the names of the species, excluding object types, in world-file order.

        Returns
        -------
        list of str
            `tables` lists them in alphabetical order, on which results depend.

        Examples
        --------
        >>> from ecs_eco import World
        >>> World.from_config("predator-prey").species_names()
        ['grass', 'deer', 'wolf']
        """
        known = [] if self.config is None else list(self.config.species)
        return sorted(
            (name for name, table in self.tables.items() if not table.species.is_object),
            key=lambda name: known.index(name) if name in known else len(known),
        )

    @property
    def ambient(self) -> dict[str, float]:
        """Light, temperature [K] and pressure [Pa], unless a function of the environment replaces them."""
        return self.environment.ambient

    @ambient.setter
    def ambient(self, values: dict[str, float]) -> None:
        self.environment.ambient = values

    def _admit(self, refuse: bool = True) -> None:
        """Wrap or reject the values written between ticks; see `ecs_eco.space.gate`."""
        self._looked = gate.admit(self, refuse, self._looked)

    def _admit_newborn(
        self, table: Table, values: dict[tuple[type, str], Any], label: str
    ) -> dict[tuple[type, str], Any]:
        """Return the values of newborns with their positions wrapped into the space. Raises a ValueError for
        values beyond their limits."""
        return gate.newborn(self, table, values, label)

    # --- neighbors -------------------------------------------------------------------------------------------

    def index(self, table: Table) -> Index:
        """Return the up-to-date neighbor index of a table that has `Position`.

        Parameters
        ----------
        table : Table

        Returns
        -------
        Index

        See Also
        --------
        World.pairs, World.within, World.nearest : ready-made queries.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1)
        >>> world.index(world.table("deer")).n
        700
        """
        index = self._indexes.get(table.name)
        if index is not None and index.version == table.version and index.space is self.space:
            return index
        many = self.workers.parallel and not self.workers.all_busy
        if many and self._index_of(table).version != table.version:
            placed = [t for t in self.tables.values() if Position in t]
            stale = [t for t in placed if self._index_of(t).version != t.version]
            stale.sort(key=lambda t: -t.n)  # start the longest jobs first
            self.together(*(lambda t=t: self._build(t) for t in stale))
        return self._build(table)

    def _index_of(self, table: Table) -> Index:
        index = self._indexes.get(table.name)
        if index is None or index.space is not self.space:
            with self.lock:
                index = self._indexes.get(table.name)
                if index is None or index.space is not self.space:
                    index = self._indexes[table.name] = Index(self.space)
        return index

    def _build(self, table: Table) -> Index:
        """Update an index; if several threads need it, one updates it and the other threads wait."""
        index = self._indexes.get(table.name)
        if index is None or index.space is not self.space:
            index = self._index_of(table)
        if index.version != table.version:
            with index.lock:
                if index.version != table.version:
                    p = table[Position]
                    index.build(table.alive[: table.high], p.x, p.y, p.z, table.uid)
                    index.version = table.version
        return index

    def pairs(self, table: Table | str, other: Table | str, radius: ArrayLike) -> Pairs:
        """Return all pairs of entities from two tables that are closer to each other than a radius.

        Parameters
        ----------
        table, other : Table or str
            The two can be the same table: an organism is never paired with itself, and two neighbors form two
            pairs.
        radius : float or array of float, shape (rows,)
            Distance [m] between centers, the shorter way around on a torus: a number, or one per row of
            `table`.

        Returns
        -------
        Pairs
            Rows of both tables, and distances f32[k] [m], in an order that does not depend on rows.

        Raises
        ------
        UnknownName
            If the table is unknown.
        ValueError
            If the radius is negative or is an array of the wrong size.

        Notes
        -----
        Current positions are used. A system that has moved bodies in this tick must first run
        `table.version += 1`.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Position
        >>> world = World((10.0, 10.0))
        >>> hares = world.add_table("hare", Position)
        >>> for x in (1.0, 2.0, 9.5):
        ...     world.spawn("hare", Position(x=x, y=5.0))
        >>> world.flush()
        >>> rows, others, distances = world.pairs("hare", "hare", 1.2)
        >>> len(rows), distances.tolist()
        (2, [1.0, 1.0])
        """
        seekers, targets = self._two(table, other)
        own = near.radii(radius, seekers.n, seekers.rows)
        return near.pairs(
            (seekers.x, seekers.y, seekers.z), seekers.rows, own, targets, seekers is targets, self.split
        )

    def within(self, table: Table | str, places: ArrayLike, radius: ArrayLike) -> Pairs:
        """Return all entities of a table within a radius of given positions.

        Parameters
        ----------
        table : Table or str
        places : array of float, shape (n, axes)
            Coordinates [m].
        radius : float or array of float, shape (n,)
            Distance [m]: a number, or one per position.

        Returns
        -------
        Pairs
            Indices of positions, rows of the table, and distances f32[k] [m], ordered by position.

        Raises
        ------
        UnknownName
            If the table is unknown.
        ValueError
            If a radius or position is invalid.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Position
        >>> world = World((10.0, 10.0))
        >>> hares = world.add_table("hare", Position)
        >>> world.spawn("hare", Position(x=1.0, y=5.0))
        >>> world.flush()
        >>> world.within("hare", [[1.0, 6.0], [8.0, 8.0]], 2.0)[2].tolist()
        [1.0]
        """
        targets = self._two(table, table)[0]
        xyz = near.places_in(self.space, places)
        n = len(xyz[0])
        return near.pairs(xyz, np.arange(n), near.radii(radius, n), targets, False, self.split)

    def nearest(self, table: Table | str, other: Table | str, radius: float | None = None) -> Pairs:
        """Return, for each entity of a table, the nearest entity of another table.

        Parameters
        ----------
        table, other : Table or str
            The two can be the same table: an organism is never its own neighbor.
        radius : float, optional
            Search distance [m]; default: the whole world.

        Returns
        -------
        Pairs
            Rows of both tables, and distances f32[k] [m]. Entities with no neighbor in reach are left out; ties
            are broken by an order that does not depend on rows.

        Raises
        ------
        UnknownName
            If the table is unknown.
        ValueError
            If the radius is invalid.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1)
        >>> wolves, deer, distances = world.nearest("wolf", "deer")
        >>> len(wolves)
        250
        """
        seekers, targets = self._two(table, other)
        widest = math.dist([0.0] * 3, self.space.lengths)
        reach = float(near.radii(widest if radius is None else radius, 1)[0])
        target, distance2 = np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32)
        nearest(seekers, targets, reach, target, distance2, self.split)
        some = target >= 0
        return Pairs(seekers.rows[some], targets.rows[target[some]], np.sqrt(distance2[some]))

    def _two(self, *tables: Table | str) -> list[Index]:
        return [self.index(self.table(table) if isinstance(table, str) else table) for table in tables]

    def _merged(self, names: tuple[str, ...], build: Callable[[], T], kind: str = "spheres") -> T:
        """Return the current bodies of several tables in one index of a given kind: the last result of
        `build()` if it is still valid, otherwise a new one."""
        with self.lock:  # several threads may need it at once
            version: tuple[int, ...] = ()
            for name in names:
                version = *version, self.tables[name].version
            kept = self._kept_merged.get((kind, names))
            if kept is None or kept[0] != version:
                kept = self._kept_merged[kind, names] = (version, build())
            return kept[1]

    def _forget_neighbours(self) -> None:
        """Force all indexes to be rebuilt, because the cells or all positions have changed."""
        self._indexes.clear()
        self._kept_merged.clear()
        self._touch()

    def surroundings(self, quantity: str, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return light, temperature or pressure at given positions.

        Parameters
        ----------
        quantity : {"light", "temperature", "pressure"}
            Light is 1 in full daylight; temperature is in [K] and pressure in [Pa].
        x, y, z : array of float32, shape (n,)
            Coordinates [m].

        Returns
        -------
        array of float32, shape (n,)

        Notes
        -----
        A `world.environment[quantity]` function, called with (world, x, y, z), replaces the constant in
        `world.ambient`.

        Examples
        --------
        >>> import numpy as np
        >>> from ecs_eco import World
        >>> world = World((10.0, 10.0))
        >>> place = np.zeros(1, np.float32)
        >>> world.surroundings("temperature", place, place, place).tolist()
        [285.0]
        """
        function = self.environment.get(quantity)
        if function is None:
            return np.full(x.size, self.environment.ambient[quantity], np.float32)
        return gate.one_each(function(self, x, y, z), x.size, f"environment[{quantity!r}]")


def _whereabouts(table: Table) -> tuple[np.ndarray | None, ...]:
    p: Any = table.columns.get(Position)
    body: Any = table.columns.get(Body)
    return (
        table.alive,
        table.uid,
        *((None,) * 3 if p is None else (p.x, p.y, p.z)),
        None if body is None else body.radius,
    )
