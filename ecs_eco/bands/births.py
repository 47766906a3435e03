"""Births and deaths when state is divided: all processes assign the same uids, and one process creates each
newborn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Genome, Policy, Position
from ecs_eco.engine.turnover import Turnover
from ecs_eco.engine.uids import matched
from ecs_eco.life.births import Litters, rows_of
from ecs_eco.life.places import Around
from ecs_eco.space.geometry import cells_of

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

Values = dict[tuple[type, str], np.ndarray]


class Parents(dict[type, Any]):
    """Parents of newborns, as a table sorted by uid with the columns that heredity reads."""

    def __init__(self, table: Table, uid: np.ndarray, columns: dict[tuple[type, str], np.ndarray]) -> None:
        super().__init__(
            {component: _Columns(**{field: array}) for (component, field), array in columns.items()}
        )
        self.uid, self.species, self.place, self.defaults = uid, table.species, table.place, table.defaults

    def rows(self, uid: np.ndarray) -> np.ndarray:
        """Return the rows of parents, or −1 for dead parents: i64[n]."""
        at, there = matched(self.uid, uid)
        return np.where(there, at, -1)


class _Columns:
    def __init__(self, **columns: np.ndarray) -> None:
        vars(self).update(columns)


class Births(Turnover):
    """Exchanges births and deaths, and maintains the map of plant sites in every process."""

    def __init__(self, bands: Any, world: SpatialWorld) -> None:
        super().__init__(world)
        self.bands = bands
        self.sites: dict[str, np.ndarray] = {}
        self.cleared: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}  # the sites and uids of dead plants
        for table in bands.tables:  # at this point, every process still holds the whole world
            way = table.species.reproduction
            if way is not None and way.kind == "spread":
                size = self.world.space.size
                nx, ny = (max(1, round(side / way.spacing)) for side in size[:2])
                self.sites[table.name], self.cleared[table.name] = np.full((ny, nx), -1, np.int64), []
                rows = table.by_uid()
                site = self._site(table, *self._xy(table, rows))
                self.sites[table.name].reshape(-1)[site] = table.uid[rows]

    @staticmethod
    def _xy(table: Table, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return table[Position].x[rows], table[Position].y[rows]

    def _site(self, table: Table, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the site number of each position: i64[n]."""
        ny, nx = self.sites[table.name].shape
        inverse = np.array([nx / self.world.space.size[0], ny / self.world.space.size[1]], np.float32)
        return cells_of(y, inverse[1], ny) * nx + cells_of(x, inverse[0], nx)

    def sites_of(self, table: Table, shape: tuple[int, ...]) -> np.ndarray:
        """Return the uid of the plant on each site, or −1 if the site is empty: i64[ny, nx]."""
        sites = self.sites[table.name].reshape(-1)
        gone = self.cleared[table.name]
        none = np.zeros(0, np.int64)
        at, uid = self.bands.everyone(
            np.concatenate([none, *(a for a, _ in gone)]), np.concatenate([none, *(u for _, u in gone)])
        )
        gone.clear()
        sites[at[sites[at] == uid]] = -1
        return self.sites[table.name]

    # --- deaths and births take effect ----------------------------------------------------------------------

    def heard(self) -> bool:
        """Return True, because deaths free plant sites."""
        return True

    def bury(self, table: Table, rows: np.ndarray, ordered: bool = False) -> None:
        """Free the rows of organisms that have a cause of death; deaths of ghosts are not reported."""
        ghosts = self.bands.ghosts[table.name]
        own = rows[self.bands.living(table)[rows]] if ghosts.size else rows
        self.bands.ghosts[table.name] = ghosts[table.cause[ghosts] == 0]
        if not ordered:
            own = own[table.uid[own].argsort()]
        if own.size:
            self.tell_deaths(table, own)
            if table.name in self.sites:
                self.cleared[table.name].append(
                    (self._site(table, *self._xy(table, own)), table.uid[own].astype(np.int64))
                )
        table.vacate(rows)

    def bear(self) -> list[tuple[Table, np.ndarray]]:
        """Assign uids to all newborns, as a single process would, and create the newborns in this band."""
        world, bands = self.world, self.bands
        born = []
        bands.forget()
        for table in world.tables.values():
            requests, table.births = table.births, []
            for parents, second, values in requests:
                uid = world.next_uid + np.arange(parents.size, dtype=np.uint64)
                world.next_uid += parents.size
                self._stand(table, values, uid)
                here = self._here(table, values, parents.size)
                if not here.size:
                    continue
                values = {key: np.asarray(array)[here] for key, array in values.items()}
                rows = table.settle(uid[here], np.full(here.size, world.tick), values)
                mates = np.zeros(here.size, np.uint64) if second is None else second[here]
                for listen in tuple(world.on_birth):
                    listen(table, rows, parents[here], mates)
                born.append((table, rows))
        return born

    def _here(self, table: Table, values: Values, n: int) -> np.ndarray:
        y = values.get((Position, "y"))
        if y is None:
            y = np.full(n, table.defaults[Position]["y"], np.float32)
        return np.flatnonzero(self.bands.edges.owner_of(np.asarray(y, np.float32)) == self.bands.place)

    def _stand(self, table: Table, values: Values, uid: np.ndarray) -> None:
        """Record the sites of newborn plants."""
        if table.name in self.sites and uid.size:
            x, y = (np.asarray(values[Position, axis], np.float32) for axis in "xy")
            self.sites[table.name].reshape(-1)[self._site(table, x, y)] = uid

    # --- heredity -------------------------------------------------------------------------------------------

    def litters(self, mine: Litters, where: Around) -> Litters:
        """Return the litters of all processes and their possible positions, sorted by the parents' uids."""
        n = mine.uid.size
        each = [isinstance(value, np.ndarray) for value in where]
        got = self.bands.everyone(
            mine.uid,
            mine.number,
            mine.given,
            mine.father,
            *(
                value if own else np.full(n, value, np.float32)
                for value, own in zip(where, each, strict=True)
            ),
        )
        order = np.argsort(got[0])
        uid, number, given, father, *places = (array[order] for array in got)
        around = Around(
            *(array if own else value for array, value, own in zip(places, where, each, strict=True))
        )
        return Litters(uid, number, given, father, around, np.searchsorted(uid, mine.uid))

    def inherited(
        self,
        world: SpatialWorld,
        table: Table,
        parents: np.ndarray,
        litters: Litters,
        which: np.ndarray,
        identity: np.ndarray,
        y: np.ndarray,
        second: np.ndarray | None,
        sperm: np.ndarray | None,
    ) -> Values:
        """Return the columns that newborns inherit, with zeros for newborns outside this band (y f32[n] [m])."""
        held = self._parents(table, litters.uid[which], second)
        fathers = None
        if sperm is not None:
            uid, sperms = self.bands.everyone(table.uid[parents], sperm)
            fathers = sperms[np.argsort(uid)][which]
        here = np.flatnonzero(self.bands.edges.owner_of(y) == self.bands.place)
        some = table.species.heredity.offspring(
            world,
            held,
            held.rows(litters.uid[which])[here],
            None if second is None else held.rows(second)[here],
            identity[here],
            **({} if fathers is None else {"sperm": fathers[here]}),
        )
        values = {}
        for key, array in some.items():
            values[key] = np.zeros((which.size, *array.shape[1:]), array.dtype)
            values[key][here] = array
        return values

    def _parents(self, table: Table, first: np.ndarray, second: np.ndarray | None) -> Parents:
        """Return the living parents with these uids from all processes, with the columns that heredity reads."""
        heredity = table.species.heredity
        wanted = np.unique(first if second is None else np.concatenate([first, second]))
        rows = rows_of(table, wanted)
        rows = rows[rows >= 0]
        rows = rows[self.bands.living(table)[rows]]
        columns: Values = {}
        if heredity.layout is not None:
            columns[Genome, "loci"] = table[Genome].loci[rows]
        if heredity.minds is not None and heredity.inherit == "learned":
            columns[Policy, "weights"] = table[Policy].weights[rows]
        uid, *arrays = self.bands.everyone(table.uid[rows], *columns.values())
        order = np.argsort(uid)
        return Parents(
            table, uid[order], {key: array[order] for key, array in zip(columns, arrays, strict=True)}
        )
