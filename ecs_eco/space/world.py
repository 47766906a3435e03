"""A world with places: its space, its surroundings and its neighbour indexes, which sensors and systems read."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ecs_eco._html import grid
from ecs_eco.components.body import Body
from ecs_eco.components.position import Position
from ecs_eco.engine.addresses import Addresses
from ecs_eco.engine.table import Table
from ecs_eco.esper_bridge.world import World
from ecs_eco.space import gate
from ecs_eco.space import pairs as near
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

    `size` [m] and `edges` describe the space, `cell` [m] the side of the cells of the neighbour index. The
    rest is that of `ecs_eco.esper_bridge.world.World`. What is attached to a world from above, its configuration
    and its recorder, has its place here, since systems ask for it.
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
        self.bands = OneBand()  # more than one: ecs_eco.bands
        self.environment = Environment()
        self.fields: dict[str, Field] = {}
        self.terrain: Terrain | None = None
        self.substances: list[str] = []
        self.bodiless: set[str] = set()  # causes of death that leave no body, besides those of being eaten
        self.reproduction = True  # switched off while policies are pre-trained
        self.config: Any = None  # the WorldConfig that it was built from
        self.recorder: Any = None
        self.own_systems: list[Any] = []  # those that the configuration lists, in its order
        self.reporters: dict[str, Any] = {}  # what is measured in every tick, by name
        self.matter: Any = None  # the Books of its substances (ecs_eco.life.matter)
        self.origin: dict[str, Any] = {}  # the arguments of `build`
        self.awaited: Any = None  # ecs_eco.nervous.external.Awaited, where choices come from outside
        self.intervened: list[tuple[int, Any]] = []  # (tick, intervention) carried out
        self.lock = threading.RLock()  # held while something is made that threads share
        self._looked: gate.Looked | None = None
        self._indexes: dict[str, Index] = {}
        self._kept_merged: dict[tuple[str, tuple[str, ...]], tuple[tuple[int, ...], Any]] = {}
        super().__init__(dt=dt, seed=seed, threads=threads, name=name)
        tables = self.tables  # `self` would make a circle
        # addresses of alive, uid, x, y and z of each table, for kernels
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
        """Make `run` return: after this tick, or before the next if no tick is under way. `stopped` is then
        true."""
        self.stopping = self.bands.stops()

    def species_names(self) -> list[str]:
        """Return the names of the species, not of objects, in the order in which the world file has them: for
        all that people read. Tables are in the order of names, for the file's must not matter."""
        known = [] if self.config is None else list(self.config.species)
        return sorted(
            (name for name, table in self.tables.items() if not table.species.is_object),
            key=lambda name: known.index(name) if name in known else len(known),
        )

    @property
    def ambient(self) -> dict[str, float]:
        """Light, temperature [K] and pressure [Pa] where no function of the environment says otherwise."""
        return self.environment.ambient

    @ambient.setter
    def ambient(self, values: dict[str, float]) -> None:
        self.environment.ambient = values

    def _admit(self, refuse: bool = True) -> None:
        """Bring back or refuse what was written between ticks; see `ecs_eco.space.gate`."""
        self._looked = gate.admit(self, refuse, self._looked)

    def _admit_newborn(
        self, table: Table, values: dict[tuple[type, str], Any], label: str
    ) -> dict[tuple[type, str], Any]:
        """Return the values of newborn with their places brought into the space;
        ValueError for what is beyond its limits."""
        return gate.newborn(self, table, values, label)

    # --- who is near whom -----------------------------------------------------------------------------------

    def index(self, table: Table) -> Index:
        """Return the neighbour index of a table that has Position, as things stand now; any thread may ask."""
        index = self._indexes.get(table.name)
        if index is not None and index.version == table.version and index.space is self.space:
            return index
        many = self.workers.parallel and not self.workers.all_busy
        if many and self._index_of(table).version != table.version:
            placed = [t for t in self.tables.values() if Position in t]
            stale = [t for t in placed if self._index_of(t).version != t.version]
            stale.sort(key=lambda t: -t.n)  # the longest work begins first
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
        """Bring an index up to date; of several threads that want it, one does, and the others wait."""
        index = self._indexes.get(table.name)
        if index is None or index.space is not self.space:
            index = self._index_of(table)
        if index.version != table.version:
            with index.lock:
                if index.version != table.version:
                    p, (first, last) = table[Position], table.steady
                    if last != table.version or index.version < first or not index.renew(table, p):
                        index.build(table.alive[: table.high], p.x, p.y, p.z, table.uid)
                # of fewer than there are cells, sorting all is faster than to go over the cells
                index.version, table.followed = table.version, index.n >= self.space.n_cells
        return index

    def pairs(self, table: Table | str, other: Table | str, radius: ArrayLike) -> Pairs:
        """Return all pairs of one of `table` and one of `other` that are closer than `radius` [m]: rows of
        both, and distances.

        Both may be the same: nobody is paired with itself, and two that are near each other are two pairs,
        one of each. Tables are given by themselves or by name; `radius` is a number, or an array with one for
        each row of `table`. Pairs come in canonical order, whatever the rows. Distances are from centre to
        centre, the shorter way around a torus, at places as they are now: a system that has moved bodies says
        so first (`table.version += 1`). Raises KeyError for an unknown table, ValueError for a radius that
        cannot be.
        """
        seekers, targets = self._two(table, other)
        own = near.radii(radius, seekers.n, seekers.rows)
        return near.pairs(
            (seekers.x, seekers.y, seekers.z), seekers.rows, own, targets, seekers is targets, self.split
        )

    def within(self, table: Table | str, places: ArrayLike, radius: ArrayLike) -> Pairs:
        """Return all of `table` that are closer than `radius` [m] to places [n, axes] [m]: numbers of places,
        rows, distances.

        They come in the order of the places, and for each in canonical order; `radius` is a number, or an
        array with one for each place. See `pairs`; raises ValueError also for places that cannot be.
        """
        targets = self._two(table, table)[0]
        xyz = near.places_in(self.space, places)
        n = len(xyz[0])
        return near.pairs(xyz, np.arange(n), near.radii(radius, n), targets, False, self.split)

    def nearest(self, table: Table | str, other: Table | str, radius: float | None = None) -> Pairs:
        """Return, for each of `table` that has one of `other` closer than `radius` [m], the nearest one: rows
        of both, and distances.

        Without a radius it is sought in the whole world. Who has none in reach is left out; of two that are
        equally near one is taken by the canonical order. Nobody is its own neighbour. See `pairs`.
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
        """Return the bodies of several tables in one index of a kind, as things stand now:
        those that `build()` returned, or does now."""
        with self.lock:  # several threads may want it at once
            version: tuple[int, ...] = ()
            for name in names:
                version = *version, self.tables[name].version
            kept = self._kept_merged.get((kind, names))
            if kept is None or kept[0] != version:
                kept = self._kept_merged[kind, names] = (version, build())
            return kept[1]

    def _forget_neighbours(self) -> None:
        """Let all indexes be made anew: the cells, or all places, are others."""
        self._indexes.clear()
        self._kept_merged.clear()
        self._touch()

    def surroundings(self, quantity: str, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return light, temperature [K] or pressure [Pa] at places f32[n] [m]: f32[n].

        `environment[quantity]`, a function (world, x, y, z), replaces the constant in `ambient`.
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
