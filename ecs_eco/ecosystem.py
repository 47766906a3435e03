"""The public World class, which can be built from a configuration, saved, copied, changed and recorded.

A thin facade: `ecs_eco.engine.world` implements the tick, and `ecs_eco.space.world` positions and
surroundings.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any, NoReturn, Self

from ecs_eco import debug
from ecs_eco._lazy import Later
from ecs_eco.config.loading import WorldSource
from ecs_eco.config.names import code_of
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.engine.interruption import require_whole
from ecs_eco.engine.table import Table
from ecs_eco.life.kind import Kind
from ecs_eco.life.reconfigure import reconfigure
from ecs_eco.nervous.external import External
from ecs_eco.record import checkpoint
from ecs_eco.record.digest import digest
from ecs_eco.record.frame import SeriesTable
from ecs_eco.record.recorder import Recorder
from ecs_eco.record.reports import add_reporter, said_by
from ecs_eco.space.world import SpatialWorld
from ecs_eco.systems.intervene import Intervene
from ecs_eco.worlds.build import build
from ecs_eco.worlds.policies import Learn, Policies, policy

# higher-level or slow packages, imported by the methods that use them
_events, _lineage = Later("ecs_eco.explain.events"), Later("ecs_eco.analysis.lineage")
_figures, _watch = Later("ecs_eco.analysis.figures"), Later("ecs_eco.view.watch")
_written = Later("ecs_eco.runs.written")


class World(SpatialWorld):
    """A space with organisms and objects, and the systems that act on them.

    `World.from_config` builds a world from a file. The constructor creates an empty world, to which you add
    tables and systems yourself.

    Parameters
    ----------
    size : sequence of float, default (100, 100)
        Extent along each axis [m]: two numbers for a plane, three for a volume.
    edges : {"torus", "walls"}, default "torus"
        Whether an organism that leaves on one side re-enters on the other, rather than stopping at the edge.
    dt : float, default 1.0
        Length of a tick [s].
    seed : int, default 0
        Fixes every random draw.
    cell : float, optional
        Cell size of the neighbor index [m], which affects speed, never results; default: chosen automatically.
    threads : int, default 1
        Number of threads; affects speed, never results.
    name : str, default "world"
        Name used in messages and figures.

    Attributes
    ----------
    tick : int
        Number of completed ticks.
    tables : dict of str to Table
        One table for each species and each object type.
    systems : list of System
        In the order in which they were added.
    before_tick : list of callable
        Hooks called before each tick of `run`, without arguments.
    on_birth : list of callable
        Hooks that take (table, rows, first parents, second parents); parents are uids u64[k], 0 for none.
    on_death : list of callable
        Hooks that take (table, rows), before the rows are freed.
    on_departure : list of callable
        Hooks that take (table, rows, numbers of the destination islands).
    on_arrival : list of callable
        Hooks that take (table, rows, numbers of the origin islands).

    Notes
    -----
    Hooks are not saved in checkpoints. Worlds stay separate: each has its own esper context, which `with
    world:` enters.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.components import Position
    >>> world = World((20.0, 20.0), seed=1)
    >>> snails = world.add_table("snail", Position)
    >>> world.spawn("snail", Position(x=3.0, y=4.0), n=2)
    >>> world.run(10)
    <World 'world' at tick 10: 2 snail>
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
        """Return a new world built from a world file.

        Parameters
        ----------
        config : str, Path, Mapping or WorldConfig
            Name of a shipped world such as "predator-prey", path of a TOML file, its contents as a dict, or a
            configuration returned by `ecs_eco.config.load`.
        seed : int, optional
            Fixes every random draw; default: the world file's `seed`.
        policies : str, Path or Mapping, default "trained"
            Source of the policies: "trained" (the weights named in the file, or fresh networks if it names
            none), "random" (every action with equal probability), "untrained" (fresh networks), a folder of
            `<species>.safetensors`, or a mapping from species to one of these or to a torch module.
        threads : int, default 1
            Number of threads; affects speed, never results.
        learn : bool or Mapping of str to bool, optional
            Which species learn during the run: all of them, none, or those selected by name; default: as in
            the world file.
        training : bool, default False
            Whether to build the world as in pre-training: with the values in `[training.set]`, respawning and
            no births.
        record : bool, default True
            Whether to record series in memory; see `series`.
        populate : bool, default True
            Whether to create organisms at the start.
        systems : sequence of System
            Custom systems, in addition to the file's systems.
        features : sequence of type
            Classes derived from `ecs_eco.config.Feature`, in addition to the features of the file's code.
        reporters : Mapping of str to str or callable
            Measurements by name, in addition to the file's reporters; see `add_reporter`.
        controls : sequence of str
            Treatments that remove something, such as "random-policy"; `ecs-eco compare --help` lists them.
        trust : bool, default False
            Whether the code listed in the file's `code` is allowed to run in this process.

        Returns
        -------
        World
            The world at tick 0.

        Raises
        ------
        ConfigError
            If values are invalid (it lists every problem found), or if code is not allowed to run.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1)
        >>> sorted(world.tables)
        ['deer', 'grass', 'wolf']
        >>> world.run(5).tick
        5

        A world can also be a dict:

        >>> duckweed = {
        ...     "count": 50,
        ...     "body": {"radius": 0.1},
        ...     "reproduction": {"kind": "spread", "rate": 0.2, "spacing": 0.5},
        ... }
        >>> pond = {"format": 1, "name": "pond", "space": {"size": [20.0, 20.0]}}
        >>> pond["species"] = {"duckweed": duckweed}
        >>> World.from_config(pond).table("duckweed").n
        50
        """
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
        """Declare a kind of entity with these components, and return its table.

        Parameters
        ----------
        name : str
            Name of the species or object type.
        *components : type
            Classes decorated with `component`.
        capacity : int, default 64
            Number of rows to allocate; the table grows when they are used up.
        dims : Mapping of str to int, optional
            Sizes named in the shapes of fields, such as {"genes": 12} for `f32["genes"]`.

        Returns
        -------
        Table
            The empty table.

        Raises
        ------
        ValueError
            If a table with this name already exists.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Metabolism, Position
        >>> world = World((10.0, 10.0))
        >>> world.add_table("hare", Position, Metabolism)
        <Table 'hare': 0 alive, Position, Metabolism>
        """
        table = super().add_table(name, *components, capacity=capacity, dims=dims)
        table.species = Kind()
        return table

    def intervene(self, what: Any) -> None:
        """Request an intervention for the start of the next tick.

        Parameters
        ----------
        what : Mapping or model
            An intervention as in `[[interventions]]` of a world file, without `at`, or a model from
            `ecs_eco.config.models.interventions`.

        Raises
        ------
        ConfigError
            If the intervention would be invalid in a file.
        RuntimeError
            If the schedule has no system `Intervene`, or the world is divided between processes.

        See Also
        --------
        World.intervened : a (tick, intervention) pair for each intervention carried out.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1)
        >>> world.intervene({"kind": "cull", "species": "wolf", "share": 0.5, "cause": "shot"})
        >>> world.run(1).table("wolf").n
        125
        """
        system = next((s for s in self.systems if isinstance(s, Intervene)), None)
        if system is None:
            raise RuntimeError("this world has no system Intervene; call add_system(Intervene()) first")
        require_whole(self, "intervene", within=True)
        self._undivided("intervene")
        system.ask(what)

    def reconfigure(self, config: WorldSource, learners: Iterable[str] = ()) -> None:
        """Give this live world a new configuration, effective from the next tick.

        Living organisms keep their current state (energy, mass, sex, fertility, properties,
        substances); newborns get the new values.

        Parameters
        ----------
        config : str, Path, Mapping or WorldConfig
            The new configuration, as in `from_config`.
        learners : iterable of str
            Species whose `policy.learn` follows the new configuration even if the world was built with a
            different value.

        Raises
        ------
        ConfigError
            If values cannot change in a live world. It lists all of them and is raised before anything
            changes.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.config import load
        >>> world = World.from_config("predator-prey", seed=1)
        >>> world.reconfigure(load("predator-prey", {"species.deer.metabolism.basal": 0.005}))
        >>> world.table("deer").species.metabolism.basal
        0.005
        """
        self._undivided("reconfigure")
        reconfigure(self, config, learners)

    def _undivided(self, what: str) -> None:
        if self.bands.divided:
            raise RuntimeError(
                f"world {self.name!r}: it cannot {what} while its state is divided between processes"
            )

    def add_reporter(self, name: str, what: Any) -> None:
        """Measure a quantity at the end of every tick, and record it as a column of the series.

        Parameters
        ----------
        name : str
            Name of the column.
        what : str or callable
            A formula over components, such as "mean(Metabolism.energy)" (`ecs_eco.config.reporter_formula`),
            or a function of the world that returns a number or a mapping from species to numbers; None means
            a missing value. The function must not change the world.

        Raises
        ------
        ValueError
            If the name is already taken.
        ConfigError
            If the formula is invalid.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1)
        >>> world.add_reporter("animals", lambda world: world.table("deer").n + world.table("wolf").n)
        >>> world.measure("animals")
        950.0
        """
        add_reporter(self, name, what)

    def report(self, name: str) -> Any:
        """Return `measure(name)`; this name is deprecated."""
        warnings.warn("World.report is deprecated; use World.measure", DeprecationWarning, stacklevel=2)
        return self.measure(name)

    def measure(self, name: str) -> Any:
        """Return the current value of a reporter.

        Parameters
        ----------
        name : str
            Name of a reporter from the world file or from `add_reporter`.

        Returns
        -------
        float or dict of str to float
            A number, or a number for each species.

        Raises
        ------
        UnknownName
            If there is no such reporter: a KeyError that suggests the nearest name.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", reporters={"energy": "sum(Metabolism.energy)"})
        >>> sorted(world.measure("energy"))
        ['deer', 'grass', 'wolf']
        """

        if name not in self.reporters:
            raise UnknownName(unknown_name(f"world {self.name!r}", "reporter", name, self.reporters))
        species = {n: i for i, (n, t) in enumerate(self.tables.items()) if not t.species.is_object}
        return said_by(self, name, self.reporters[name], species)

    def series(self) -> Any:
        """Return the series recorded so far, with one row for each tick and species.

        Returns
        -------
        SeriesTable
            A pyarrow.Table with the methods `to_pandas`, `to_polars` and `wide`.

        Raises
        ------
        RuntimeError
            If the world has no recorder.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1).run(3)
        >>> world.series().column_names[:4]
        ['tick', 'species', 'n', 'births']
        >>> world.series().wide()["deer"].to_pylist()[0]
        699
        """
        if self.recorder is None:
            raise RuntimeError(
                "this world has no recorder; build it with World.from_config, or add one: "
                "ecs_eco.record.Recorder(world)"
            )
        if self.bands.divided:
            self.recorder.flush()  # collects the records of other processes
        return SeriesTable(self.recorder.series())

    def plot(self, column: str = "n", species: Sequence[str] | None = None) -> Any:
        """Plot a column of the series over time, with one line per species.

        Parameters
        ----------
        column : str, default "n"
            Column of `series`; "n" is the number of organisms.
        species : sequence of str, optional
            Species to draw, in this order; default: all.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        RuntimeError
            If nothing is recorded.
        KeyError
            For an unknown column or species.

        Examples
        --------
        >>> from ecs_eco import World
        >>> figure = World.from_config("predator-prey", seed=1).run(3).plot(species=["deer", "wolf"])
        >>> figure.savefig("animals.png")
        """
        return _figures.plot(self, column, species)

    def explain(self, species: str | None = None, *, fdr: float = 0.01) -> Any:
        """Return the sweeps since this world's recorder was added: alleles that rose by more than drift allows.

        To see their effects, record the run in a folder and use `ecs-eco explain`, which takes them out in forks.

        Parameters
        ----------
        species : str, optional
            Default: every species that reproduces.
        fdr : float, default 0.01
            Largest expected proportion of false positives among the alleles that pass the test.

        Returns
        -------
        list of ecs_eco.explain.Sweep

        Raises
        ------
        RuntimeError
            If the world has no recorder that keeps events.
        ValueError
            If no organism was born to recorded parents, or the run is too short.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.record import Recorder
        >>> goats = World.from_config("reflexes", seed=1, record=False)
        >>> recorder = Recorder(goats, keep_events=True)
        >>> goats.run(300).explain("goat")[0].lead.name
        'green = 0'
        """
        return _events.rises(_lineage.Lineage.of(self), species, fdr=fdr)

    def view(self, ticks: int | None = None, **how: Any) -> Any:
        """Show this live world in a notebook's output cell or, outside a notebook, in the browser until Ctrl-C.

        Parameters
        ----------
        ticks : int, optional
            Number of ticks to run; default: no limit.
        **how
            `speed` [ticks/s], None for as fast as possible, `playing`, False to wait until a page plays it,
            `port`, and `panels`, your own panels: functions of the world by name, which return a number, a
            matplotlib figure or an SVG text; in a notebook, also `height` [px].

        Returns
        -------
        Panel or None
            The panel that shows the page, in a notebook.

        Notes
        -----
        The page is served from 127.0.0.1, so a notebook must run on your machine.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1)
        >>> panels = {"Deer per wolf": lambda world: world.table("deer").n / world.table("wolf").n}
        >>> world.view(ticks=500, speed=20, panels=panels)  # doctest: +SKIP
        """
        return _watch.view(self, ticks, **how)

    def to_folder(self, out: str | Path) -> dict[str, Any]:
        """Write this world and its recording in memory to a folder, as a run that ended at this tick.

        The commands and functions for runs then apply to it: `report`, `why`, `picture`, `lineage`, `replay`,
        `resume` and others. This world can continue to run.

        Parameters
        ----------
        out : str or Path
            New or empty folder.

        Returns
        -------
        dict
            The manifest.

        Raises
        ------
        RecordingError
            If the world was not built by `from_config`, was restored or copied, was not recorded in memory from
            tick 0 by one recorder that keeps events, or has an intervention waiting.
        ConfigError
            If a file of its initial policies is missing, or a species waits for external decisions.
        FileExistsError
            If `out` is not empty.
        OSError
            If writing fails; nothing is left in the folder.

        Notes
        -----
        `repeat` repeats interventions, but not changes that your program made between ticks, such as
        `reconfigure`, or policies passed as modules. `resume` continues from the saved state, which includes both.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.record import Recorder
        >>> from ecs_eco.analysis.report import write_report
        >>> world = World.from_config("predator-prey", seed=1, record=False)
        >>> recorder = Recorder(world, keep_events=True, snapshot_every=10)
        >>> world.run(20).to_folder("living")["done"]
        20
        >>> write_report("living").name
        'report.html'
        """
        return _written.to_folder(self, out)

    def policy(self, species: str, uid: int | None = None) -> Any:
        """Return a copy of a policy as a torch module in evaluation mode.

        Parameters
        ----------
        species : str
            Species with a policy network.
        uid : int, optional
            An organism's uid, required if each organism has its own network.

        Returns
        -------
        torch.nn.Module

        Raises
        ------
        UnknownName
            For an unknown species.
        ConfigError
            If there is no network, or if there are several and `uid` is missing.

        Examples
        --------
        >>> from ecs_eco import World
        >>> network = World.from_config("predator-prey", seed=1).policy("deer")
        >>> sum(parameter.numel() for parameter in network.parameters()) > 1000
        True
        """
        return policy(self, species, uid)

    def external(self, species: str, partial: bool = False) -> External:
        """Return an interface through which your program decides for a species, tick by tick.

        Parameters
        ----------
        species : str
            Species with actions whose own policy does not learn.
        partial : bool, default False
            Whether your program decides only for some organisms. The species' own policy decides for the
            rest; a species without a network draws actions at random.

        Returns
        -------
        External
            The interface, with the methods `observe` and `act`.

        Raises
        ------
        UnknownName
            For an unknown species.
        ConfigError
            If this species cannot be controlled externally.

        Examples
        --------
        >>> import numpy as np
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1, learn=False)
        >>> deer = world.external("deer")
        >>> sensed = deer.observe()
        >>> deer.act(np.zeros((len(sensed.uid), len(deer.options)), int))
        >>> world.tick
        1
        """
        return External(self, species, partial)

    # --- saving and copying --------------------------------------------------------------------------------

    def save(self, path: str | Path) -> Path:
        """Write a checkpoint, from which the world can continue bit for bit.

        Parameters
        ----------
        path : str or Path
            The file to write. It is written completely or not at all.

        Returns
        -------
        Path
            The path.

        Raises
        ------
        RuntimeError
            If called during a tick.
        CheckpointError
            If the world contains something that could not be restored.
        OSError
            If the file cannot be written.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1).run(3)
        >>> path = world.save("meadow.ckpt")
        >>> World.restore(path).digest() == world.digest()
        True
        """
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
        """Return the world saved in a checkpoint.

        Parameters
        ----------
        path : str or Path
            A checkpoint written by `save`.
        threads : int, default 1
            Number of threads; affects speed, never results.
        config : str, Path, Mapping or WorldConfig, optional
            Required if the world was built from a configuration with functions that no module defines.
        systems : sequence of System
            New instances of the systems that were passed as instances.
        prepare : callable, optional
            Called with the world before the state is loaded, to add everything that you added in Python.
        record : bool, default True
            Whether to continue recording.
        trust : bool, default False
            Whether the code named in the checkpoint is allowed to run in this process.

        Returns
        -------
        World
            The world at the tick of the checkpoint.

        Raises
        ------
        CheckpointError
            If the file is damaged or does not match.
        ConfigError
            If code is not allowed to run.

        Warns
        -----
        RuntimeWarning
            If the checkpoint was written in the other numerical mode (`ecs-eco --portable`).

        Examples
        --------
        >>> from ecs_eco import World
        >>> path = World.from_config("predator-prey", seed=1).run(3).save("meadow.ckpt")
        >>> World.restore(path).run(2).tick
        5
        """
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
        """Load the state of a checkpoint into this world, which must have been built in the same way.

        Parameters
        ----------
        path : str or Path
            A checkpoint written by `save`.
        trust : bool, default False
            Whether the code named in the checkpoint is allowed to run in this process.

        Raises
        ------
        CheckpointError
            If the file is damaged or belongs to a world with different tables.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Position
        >>> def pond():
        ...     world = World((10.0, 10.0), seed=1)
        ...     world.add_table("snail", Position)
        ...     return world
        >>> world = pond()
        >>> world.spawn("snail", n=3)
        >>> path = world.run(2).save("pond.ckpt")
        >>> other = pond()
        >>> other.load(path)
        >>> other
        <World 'world' at tick 2: 3 snail>
        """
        checkpoint.load(self, path, trust=trust)

    def copy(
        self,
        *,
        threads: int | None = None,
        systems: Sequence[Any] = (),
        prepare: Callable[[Any], None] | None = None,
    ) -> Self:
        """Return an independent copy with the same digest and the same future.

        Parameters
        ----------
        threads : int, optional
            Number of threads; default: as in this world.
        systems : sequence of System
            New instances of the systems that were passed as instances.
        prepare : callable, optional
            Called with the copy before the state is loaded, to add everything that you added in Python:
            systems, tables, environment functions.

        Returns
        -------
        World
            A world with its own organisms, policies and clock. Hooks are not copied; a copied recorder
            records in memory.

        Raises
        ------
        CheckpointError
            If the world was built by hand, or contains systems that were passed as instances.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1)
        >>> world.copy().run(3).digest() == world.run(3).digest()
        True
        """
        return checkpoint.copy(self, threads=threads, systems=systems, prepare=prepare)

    def fork(
        self,
        seed: int,
        *,
        threads: int | None = None,
        systems: Sequence[Any] = (),
        prepare: Callable[[Any], None] | None = None,
    ) -> Self:
        """Return a copy with different random draws from the next tick on.

        Parameters
        ----------
        seed : int
            Seed for the copy.
        threads, systems, prepare
            As in `copy`.

        Returns
        -------
        World
            A world with the same organisms.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1).run(3)
        >>> futures = [world.fork(seed=seed).run(3) for seed in (1, 2)]
        >>> futures[0].digest() == futures[1].digest()
        False
        """
        return checkpoint.fork(self, seed, threads=threads, systems=systems, prepare=prepare)

    def digest(self) -> str:
        """Return a hash of everything that determines this world's future, including pending requests.

        Returns
        -------
        str
            64 hexadecimal digits (SHA-256).

        Notes
        -----
        Identical runs have identical digests with the same versions on the same kind of processor
        (docs/reference/promises.md). With NUMBA_DISABLE_JIT=1, which interprets kernels, digests differ.

        Examples
        --------
        >>> from ecs_eco import World
        >>> one, two = (World.from_config("predator-prey", seed=7, record=False).run(2) for _ in range(2))
        >>> one.digest() == two.digest()
        True
        """
        return digest(self)

    def _needs_turns(self) -> bool:
        """Return whether a tick may run code from outside this package, which may use esper, or use torch or
        Python's random number generator, whose state all threads share."""
        nerves = [n for t in self.tables.values() if (n := t.species.nerves) is not None]
        brains = [brain for n in nerves for brain in (n.brain, n.individuals) if brain is not None]
        hooks = self.before_tick, self.on_death, self.on_birth, self.on_departure, self.on_arrival
        parts = *self.schedule, *chain(*hooks), *self.reporters.values(), *self.environment.values()
        networks = [network for n in nerves for network in (n.reflex, n.happiness) if network is not None]
        operators = [h.operators for t in self.tables.values() if (h := t.species.heredity) is not None]
        return (
            self.config is None
            or self.debug is not None
            or bool(code_of(self.config))
            or not all(brain.by_row for brain in brains)
            or any(o.uses_random for o in operators if o is not None)
            or not all(
                (getattr(part, "__module__", None) or "").startswith("ecs_eco.")
                for part in (*parts, *networks)
            )
        )

    def __copy__(self) -> NoReturn:
        raise TypeError(
            f"world {self.name!r}: copy.copy would share its organisms; "
            "use world.copy() or world.fork(seed=…)"
        )

    def __deepcopy__(self, memo: object) -> NoReturn:
        raise TypeError(
            f"world {self.name!r}: copy.deepcopy cannot copy esper entities; use world.copy() or world.fork(seed=…)"
        )

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            f"world {self.name!r} cannot be pickled; use world.save(path) and World.restore(path)"
        )
