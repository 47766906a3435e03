"""The World that users know: built from a configuration, saved, restored, copied, intervened in, recorded.

A thin face: the tick belongs to `ecs_eco.engine.world`, places and surroundings to `ecs_eco.space.world`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NoReturn, Self

from ecs_eco import debug
from ecs_eco._lazy import lazy
from ecs_eco.config.loading import WorldSource
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.engine.interruption import require_whole
from ecs_eco.engine.table import Table
from ecs_eco.life.kind import Kind
from ecs_eco.life.reconfigure import reconfigure
from ecs_eco.nervous.external import External
from ecs_eco.record import checkpoint, copying
from ecs_eco.record.digest import digest
from ecs_eco.record.frame import SeriesTable
from ecs_eco.record.recorder import Recorder
from ecs_eco.record.reports import add_reporter, said_by
from ecs_eco.space.world import SpatialWorld
from ecs_eco.systems.intervene import Intervene
from ecs_eco.worlds.build import build
from ecs_eco.worlds.policies import Learn, Policies, policy

# of rooms that are higher, or load much, for methods that lead there
_above = lazy(__name__, {"plot": "ecs_eco.analysis.plot", "view": "ecs_eco.view.watch"})


class World(SpatialWorld):
    """Organisms and objects in one space, and the systems that act on them.

    `size` [m] and `edges` describe the space, `dt` [s] the length of a tick, `seed` all chance. `threads`
    changes the speed and no result. Worlds do not mix: each has its own esper context, which `with world:`
    enters. The tick is implemented in `ecs_eco.engine.world`; places and surroundings in
    `ecs_eco.space.world`.
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
        super().__init__(size, edges=edges, dt=dt, seed=seed, cell=cell, threads=threads, name=name)
        self.debug = debug.start(self)  # None unless ECS_ECO_DEBUG is set

    @classmethod
    def from_config(
        cls,
        config: WorldSource,
        *,
        seed: int | None = None,
        policies: Policies = "trained",
        threads: int = 1,
        learn: Learn = None,
        training: bool = False,
        record: bool = True,
        populate: bool = True,
        systems: Sequence[Any] = (),
        features: Sequence[Any] = (),
        reporters: Mapping[str, Any] = MappingProxyType({}),
        controls: Sequence[str] = (),
        trust: bool = False,
    ) -> Self:
        """Build a world from a shipped world's name, a TOML file, a dict or a WorldConfig;
        see `ecs_eco.worlds.build`."""
        world = build(
            cls,
            config,
            seed=seed,
            policies=policies,
            threads=threads,
            learn=learn,
            training=training,
            populate=populate,
            systems=systems,
            features=features,
            reporters=reporters,
            controls=controls,
            trust=trust,
        )
        if record:
            Recorder(world)
        return world

    def add_table(
        self, name: str, *components: type[Any], capacity: int = 64, dims: Mapping[str, int] | None = None
    ) -> Table:
        """Declare a kind of entity with these components; `dims` gives the sizes that their shapes name."""
        table = super().add_table(name, *components, capacity=capacity, dims=dims)
        table.species = Kind()
        return table

    def intervene(self, what: Any) -> None:
        """Carry out an intervention at the start of the next tick: a dict as in a world file,
        or a model of `config.interventions`.

        Raises ConfigError for one that would be wrong in a file. `intervened` lists those
        that were carried out.
        """
        system = next((s for s in self.systems if isinstance(s, Intervene)), None)
        if system is None:
            raise RuntimeError(
                "this world has no system that intervenes; begin its schedule with add_system(Intervene())"
            )
        require_whole(self, "intervene", within=True)
        self._undivided("intervene")
        system.ask(what)

    def reconfigure(self, config: WorldSource, learners: Iterable[str] = ()) -> None:
        """Give this living world another configuration; see `ecs_eco.life.reconfigure`."""
        self._undivided("reconfigure")
        reconfigure(self, config, learners)

    def _undivided(self, what: str) -> None:
        if self.bands.divided:
            raise RuntimeError(
                f"world {self.name!r}: it cannot {what} while its state is divided between processes"
            )

    def add_reporter(self, name: str, what: Any) -> None:
        """Measure something in every tick from now on: a column `name` of the series.

        `what` is a formula over components, "mean(Metabolism.energy)" (`ecs_eco.config.reporter_formula`), or
        a function of the world that returns a number, or a dict species → number; None for none. It is called
        at the end of each recorded tick, and changes nothing. Raises ValueError for a name that is taken, and
        ConfigError for a formula that is wrong.
        """
        add_reporter(self, name, what)

    def report(self, name: str) -> Any:
        """Return `measure(name)`, by its former name."""
        warnings.warn("World.report is World.measure now", DeprecationWarning, stacklevel=2)
        return self.measure(name)

    def measure(self, name: str) -> Any:
        """Return a reporter's present value: a number, or a dict species → number. KeyError for an unknown
        one."""

        if name not in self.reporters:
            raise UnknownName(unknown_name(f"world {self.name!r}", "reporter", name, self.reporters))
        species = {n: i for i, (n, t) in enumerate(self.tables.items()) if not t.species.is_object}
        return said_by(self, name, self.reporters[name], species)

    def series(self) -> Any:
        """Return the recorded series: a row per tick and species; see `ecs_eco.record.frame.SeriesTable`.

        It is a pyarrow.Table in all that it does, and has `to_pandas()`, `to_polars()` and `wide()`.
        """
        if self.recorder is None:
            raise RuntimeError(
                "this world has no recorder; build it with World.from_config, or add one: "
                "ecs_eco.record.Recorder(world)"
            )
        if self.bands.divided:
            self.recorder.flush()  # what the other processes have
        return SeriesTable(self.recorder.series())

    def plot(self, column: str = "n", species: Sequence[str] | None = None) -> Any:
        """Return a column of the series over time as a matplotlib Figure; see `ecs_eco.analysis.plot`."""
        return _above("plot")(self, column, species)

    def view(self, ticks: int | None = None, **how: Any) -> Any:
        """Show this world alive: in an output cell of a notebook, else in the browser until Ctrl-C;
        see `ecs_eco.view.watch.view`."""
        return _above("view")(self, ticks, **how)

    def policy(self, species: str, uid: int | None = None) -> Any:
        """Return a copy of a species' policy as a torch module, or of one organism's; see
        `ecs_eco.worlds.policies.policy`."""
        return policy(self, species, uid)

    def external(self, species: str, partial: bool = False) -> External:
        """Return the door through which a program beside the world decides for a species, tick by tick;
        see `ecs_eco.nervous.external`.

        `partial`: it decides for some only, and the species' own policy for the others; by chance where it
        has no network. Raises UnknownName, ConfigError.
        """
        return External(self, species, partial)

    # --- kept on disk, copied -------------------------------------------------------------------------------

    def save(self, path: str | Path) -> Path:
        """Write a checkpoint, from which the world continues bit for bit; see `ecs_eco.record.checkpoint`."""
        return checkpoint.save(self, path)

    @classmethod
    def restore(
        cls,
        path: str | Path,
        *,
        threads: int = 1,
        config: WorldSource | None = None,
        systems: Sequence[Any] = (),
        prepare: Callable[[Any], None] | None = None,
        record: bool = True,
        trust: bool = False,
    ) -> Self:
        """Return the world that a checkpoint holds; see `ecs_eco.record.checkpoint.restore`."""
        return checkpoint.restore(
            cls,
            path,
            threads=threads,
            config=config,
            systems=systems,
            prepare=prepare,
            record=record,
            trust=trust,
        )

    def load(self, path: str | Path, *, trust: bool = False) -> None:
        """Bring this world, built by hand in the same way, to the state that a checkpoint holds."""
        checkpoint.load(self, path, trust=trust)

    def copy(
        self,
        *,
        threads: int | None = None,
        systems: Sequence[Any] = (),
        prepare: Callable[[Any], None] | None = None,
    ) -> Self:
        """Return an independent copy with the same future, to the bit; see `ecs_eco.record.copying.copy`."""
        return copying.copy(self, threads=threads, systems=systems, prepare=prepare)

    def fork(
        self,
        seed: int,
        *,
        threads: int | None = None,
        systems: Sequence[Any] = (),
        prepare: Callable[[Any], None] | None = None,
    ) -> Self:
        """Return a copy with other random numbers from here on; see `ecs_eco.record.copying.fork`."""
        return copying.fork(self, seed, threads=threads, systems=systems, prepare=prepare)

    def digest(self) -> str:
        """Return a hash of all that decides this world's future, pending requests included;
        see `ecs_eco.record.digest`.

        Equal runs have equal digests on one target: the same versions and processor, compiled
        (docs/reference/promises.md). With NUMBA_DISABLE_JIT=1, which interprets kernels, digests are others.
        """
        return digest(self)

    def __copy__(self) -> NoReturn:
        raise TypeError(
            f"world {self.name!r}: a copy by copy.copy would share its organisms; "
            "use world.copy() or world.fork(seed=…)"
        )

    def __deepcopy__(self, memo: object) -> NoReturn:
        raise TypeError(
            f"world {self.name!r}: copy.deepcopy cannot copy what esper holds; "
            "use world.copy() or world.fork(seed=…)"
        )

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            f"world {self.name!r} cannot be pickled; use world.save(path) and World.restore(path)"
        )
