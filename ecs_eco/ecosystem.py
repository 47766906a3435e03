"""A World: its tables, clock, space and schedule; one esper context of its own."""

import gc
import itertools
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Any, NoReturn

import esper
import numpy as np

from ecs_eco import debug
from ecs_eco.engine import random, turns
from ecs_eco.engine.arguments import positive, seed_number, whole_number
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.engine.interruption import Patience, Underway, require_whole, stopped, whole
from ecs_eco.engine.schema import Handle
from ecs_eco.engine.system import PHASES, System
from ecs_eco.engine.table import Table
from ecs_eco.lifecycle.species import Species
from ecs_eco.space import Index, Space, gate

_serial = itertools.count(1)
PARALLEL_FROM = 3000  # organisms below which a second thread does not pay


class World:
    """Organisms and objects in one space, and the systems that act on them.

    `size` [m] and `edges` describe the space, `dt` [s] the length of a tick, `seed` all chance. `threads` changes the
    speed and no result. Worlds do not mix: each has its own esper context, which `with world:` enters.
    """

    def __init__(self, size: Sequence[float] = (100.0, 100.0), *, edges: str = "torus", dt: float = 1.0, seed: int = 0,
                 cell: float | None = None, threads: int = 1, name: str = "world") -> None:
        self.name, self.dt, self.seed = name, positive("dt", dt, "seconds"), seed_number(seed)
        self.threads = threads = whole_number("threads", threads, 1)
        self.space = Space(size, edges, cell)
        self.tick = 0
        self.tables: dict[str, Table] = {}
        self.systems: list[System] = []
        self.fields: dict[str, Any] = {}
        self.terrain: Any = None
        self.water: Any = None  # a Water that fills a volume
        self.sun: Any = None  # a Sun that rises and sets over it
        self.ambient: dict[str, float] = {"temperature": 285.0, "pressure": 101_325.0, "light": 1.0}
        self.environment: dict[str, Callable[..., np.ndarray]] = {}
        self.substances: list[str] = []
        self.reproduction = True  # switched off while policies are pre-trained
        self.causes: list[str] = ["culled"]
        self.config: Any = None
        self.recorder: Any = None
        self.origin: dict[str, Any] = {}  # how `build` was asked to make it
        self.intervened: list[tuple[int, Any]] = []  # (tick, what) of interventions carried out
        self.next_uid = 1
        self.ticking = False  # whether a tick is under way
        self.underway: Underway | None = None  # what must be done as a whole and is not done yet, or never will be
        self.stopping = False  # whether `run` is to return after this tick
        self.between: Callable[[], Any] | None = None  # called before every tick, when a viewer may look, ask for an intervention, wait
        self.on_death: list[Callable[[Table, np.ndarray], None]] = []
        self.on_birth: list[Callable[[Table, np.ndarray, np.ndarray, np.ndarray], None]] = []
        self._indexes: dict[str, Index] = {}
        self._merged: dict[tuple[str, ...], Any] = {}
        self._outer: list[str] = []
        self.owner: threading.Thread
        self.apart = False  # whether it lives in a thread beside another's world
        turns.enter(self)
        self._context = f"ecs-eco {next(_serial)}"
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None
        self._shared = False  # whether all threads are at work on pieces of `together`
        self.lock = threading.RLock()  # held while something is made that threads share
        self.debug = debug.start(self)  # None unless ECS_ECO_DEBUG is set
        self._enter(_Deaths(self), "die", 999_999)
        self._enter(_Births(self), "reproduce", 999_999)
        weakref.finalize(self, _forget, self._context, self._pool)

    @classmethod
    def from_config(cls, config: Any, *, seed: int | None = None, policies: Any = "trained", threads: int = 1, **options: Any) -> "World":
        """Build a world from a shipped world's name, a TOML file, a dict or a WorldConfig; see `ecs_eco.worlds.build`."""
        from ecs_eco.worlds.build import build

        return build(cls, config, seed=seed, policies=policies, threads=threads, **options)

    def __repr__(self) -> str:
        return f"<World {self.name!r} at tick {self.tick}: {', '.join(f'{t.n} {n}' for n, t in self.tables.items())}>"

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return self.tick * self.dt

    @property
    def key(self) -> np.uint64:
        """The key of this tick's random numbers."""
        return random.tick_key(self.seed, self.tick)

    # --- what there is ---------------------------------------------------------------------------------------------

    def add_table(self, name: str, *components: type[Any], capacity: int = 64, dims: Mapping[str, int] | None = None) -> Table:
        """Declare a kind of entity with these components; `dims` gives the sizes that their shapes name."""
        if name in self.tables:
            raise ValueError(f"table {name!r} exists already; choose another name")
        table = Table(name, components, capacity=capacity, dims=dims, place=len(self.tables))
        table.species = Species()
        self.tables[name] = table
        return table

    def add_system(self, system: System | esper.Processor, phase: str | None = None) -> System:
        """Add a system at the end of its phase; a plain esper.Processor goes to `interact` unless `phase` says otherwise."""
        phase = phase or getattr(system, "phase", "interact")
        if not isinstance(system, esper.Processor):
            raise TypeError(f"system {system!r} is no ecs_eco.System or esper.Processor; hand in an instance, as in Move()")
        if phase not in PHASES:
            raise ValueError(unknown_name(f"system {type(system).__name__}", "phase", phase, PHASES))
        if getattr(system, "world", None) is not None:
            raise ValueError(f"system {type(system).__name__} is in a world already; make another instance for this one")
        system.phase = phase  # type: ignore[attr-defined]
        system.world = weakref.proxy(self)  # type: ignore[attr-defined]  # esper keeps the system: it must not keep the world
        self.systems.append(system)  # type: ignore[arg-type]
        place = 3 * len(self.systems)
        self._enter(system, phase, place)
        if self.debug is not None:
            self.debug.follow(system)
        if isinstance(system, System):
            system.start(self)
        else:  # it looks at the world through esper, and may move what it sees
            self._enter(_Registry(self), phase, place - 1)
            self._enter(_Touched(self), phase, place + 1)
        return system  # type: ignore[return-value]

    def table(self, name: str) -> Table:
        """Return the table of this name; KeyError names the nearest."""
        try:
            return self.tables[name]
        except KeyError:
            raise UnknownName(unknown_name("world", "table", name, self.tables)) from None

    def cause(self, name: str) -> int:
        """Return the code of a cause of death, making it known where it is new."""
        if name not in self.causes:
            if len(self.causes) == 255:
                raise ValueError(f"cause {name!r}: a world knows at most 255 causes of death")
            self.causes.append(name)
        return self.causes.index(name) + 1

    def spawn(self, name: str, *components: Handle, n: int = 1, parent: int = 0) -> None:
        """Ask for `n` newborn of a kind, with these components' values (the table's defaults for the others).

        They come to life at the end of the phase `reproduce`, or at `flush`. A place beyond the edge of a torus is brought back
        around it. Raises ValueError for one outside of a world with walls, and for any value beyond the limits of its field.
        """
        table = self.table(name)
        n = whole_number(f"spawn {name!r}: n", n, 1)
        values = {}
        for handle in components:
            if type(handle) not in table:
                table[type(handle)]  # raises the error that names what there is
            for field, array in vars(handle._columns).items():
                values[type(handle), field] = np.repeat(array, n, axis=0)
        if not 0 <= parent < 2**64:
            raise ValueError(f"spawn {name!r}: parent is {parent}; it must be a uid, or 0 for none")
        table.request(np.full(n, parent, np.uint64), gate.newborn(self, table, values, f"spawn {name!r}"))

    def kill(self, who: int, cause: str = "culled", killer: int = 0) -> None:
        """Let an organism die of a cause at the end of the phase `die`; `who` is a uid. Killing twice changes nothing."""
        table, row = self.locate(who)
        if not table.cause[row]:
            table.cause[row] = self.cause(cause)
            table.killer[row] = killer

    def intervene(self, what: Any) -> None:
        """Carry out an intervention at the start of the next tick: a dict as in a world file, or a model of `config.interventions`.

        Raises ConfigError for one that would be wrong in a file. `intervened` lists those that were carried out.
        """
        from ecs_eco.systems.intervene import Intervene

        system = next((s for s in self.systems if isinstance(s, Intervene)), None)
        if system is None:
            raise RuntimeError("this world has no system that intervenes; begin its schedule with add_system(Intervene())")
        require_whole(self, "intervene", within=True)
        system.ask(what)

    def locate(self, uid: int) -> tuple[Table, int]:
        """Return the table and the row of a living entity; KeyError where there is none."""
        for table in self.tables.values():
            row = np.flatnonzero(table.uid[: table.high] == uid)
            if row.size and uid > 0:
                return table, int(row[0])
        raise KeyError(f"no living entity has the uid {uid}")

    def get(self, uid: int, component: type[Any]) -> Any:
        """Return the handle of one living entity's component."""
        table, row = self.locate(uid)
        return component.attach(table[component] if self.debug is None else debug.Guard(table, component, row, uid), row)

    def each(self, *components: type[Any]) -> Iterator[tuple[Any, ...]]:
        """Yield (uid, handle, …) for all living entities that have these components, in the order of uids."""
        found = [(int(t.uid[r]), t, int(r)) for t in self.tables.values() if t.has(components) for r in t.rows()]
        for uid, table, row in sorted(found, key=lambda f: f[0]):
            yield uid, *(c.attach(table[c] if self.debug is None else debug.Guard(table, c, row, uid), row) for c in components)

    # --- time ------------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Let one tick pass."""
        self.run(1)

    def run(self, ticks: int, progress: Callable[[int, int], None] | None = None) -> "World":
        """Let `ticks` ticks pass; `progress(done, ticks)` is called about ten times a second. Returns the world.

        Returns earlier, after a whole tick, where `stopping` was set meanwhile. `between` is called before every tick.
        Ctrl-C stops after a whole tick, too. An error within a tick, or a second Ctrl-C, leaves a world that may only be looked
        at: what else is asked of it raises UnfinishedTick.
        """
        ticks = whole_number("ticks", ticks)
        self._mine()
        require_whole(self, "run")
        gate.admit(self, refuse=self.debug is None)
        self.touch()
        with turns.lock:
            outside, mark = esper.current_world, Underway("tick")
        with Patience(self) as patience:
            try:
                if self.tick == 0:
                    self.flush()
                shown = time.monotonic()
                for done in range(1, ticks + 1):
                    if self.between is not None:
                        self.between()
                        if self.stopping:
                            break
                    self._pass(mark)
                    patience.over()
                    if progress is not None and (done == ticks or time.monotonic() - shown > 0.1):
                        shown = time.monotonic()
                        progress(done, ticks)
                    if self.stopping:
                        break
            except BaseException as error:
                stopped(self, error)
                raise
            finally:
                mark.running = self.ticking = False
                with turns.lock:
                    if esper.current_world != outside:
                        esper.switch_world(outside if outside in esper.list_worlds() else "default")
        if outside == self._context:
            self.sync()
        return self

    def _pass(self, mark: Underway) -> None:
        """Let one tick pass; the mark stands until it has passed as a whole."""
        self.underway, self.ticking = mark, True
        with turns.lock:
            outside = esper.current_world
            if outside != self._context:
                esper.switch_world(self._context)
            esper.process()
            self.tick += 1
            if self.apart:
                esper.switch_world(outside)
        self.ticking, self.underway = False, None
        if turns.turn.waiting:
            turns.turn.leave()

    def _mine(self) -> None:
        if threading.get_ident() != self.owner.ident:
            raise RuntimeError(f"one thread alone touches a world: the one that made it, {self.owner.name!r}")

    def _enter(self, processor: esper.Processor, phase: str, place: int) -> None:
        """Hand a processor to esper with a priority that follows from its phase and its place in it."""
        with _Inside(self._context):
            esper.add_processor(processor, priority=-(PHASES.index(phase) * 1_000_000 + place))

    def flush(self) -> None:
        """Carry out the deaths, then the births asked for so far."""
        require_whole(self, "flush", within=True)
        with whole(self, f"the flush before tick {self.tick}"):
            self.flush_deaths()
            self.flush_births()

    def flush_deaths(self) -> None:
        """Free the rows of all that have a cause of death; listeners see them, in the order of uids, before."""
        for table in self.tables.values():
            rows = table.doomed()
            if rows.size:
                if self.on_death:
                    rows = rows[table.uid[rows].argsort()]
                for listen in self.on_death:
                    listen(table, rows)
                table.vacate(rows)

    def flush_births(self) -> None:
        """Bring the newborn to life, table by table, in the order in which they were asked for."""
        for table in self.tables.values():
            if not table.births:
                continue
            requests, table.births = table.births, []
            for parents, second, values in requests:
                if parents.size:
                    rows = table.occupy(parents.size, self.next_uid, self.tick, values)
                    self.next_uid += parents.size
                    for listen in self.on_birth:
                        listen(table, rows, parents, np.zeros_like(parents) if second is None else second)

    # --- esper -----------------------------------------------------------------------------------------------------

    def sync(self) -> None:
        """Bring esper's registry up to date: it then has one entity for each living one, with a handle per component.

        Done on `with world:`, within it after `run` and `step`, and before each plain esper.Processor of the schedule: esper
        is never looked at while it lags behind, and births and deaths that nobody looks at cost no handles.
        """
        changed = sum(int((t.entity_uid != t.uid).sum()) for t in self.tables.values())
        if not changed:
            return
        collecting = gc.isenabled()
        gc.disable()  # a collection while 100,000 handles are made would look at all of them, again and again
        with _Inside(self._context):
            for table in self.tables.values():
                for row in np.flatnonzero(table.entity_uid != table.uid):
                    if table.entity_uid[row] and esper.entity_exists(int(table.entity[row])):
                        esper.delete_entity(int(table.entity[row]), immediate=True)
                    if table.uid[row]:
                        columns = table.columns if self.debug is None else debug.guards(table, int(row))
                        table.entity[row] = esper.create_entity(*[c.attach(column, int(row)) for c, column in columns.items()])
                table.entity_uid[:] = table.uid
        if collecting:
            gc.enable()

    def entity(self, uid: int) -> int:
        """Return esper's number of a living entity: local to this process, never saved."""
        table, row = self.locate(uid)
        if table.entity_uid[row] != table.uid[row]:
            self.sync()
        return int(table.entity[row])

    def __enter__(self) -> "World":
        self._mine()
        turns.turn.__enter__()
        self._outer.append(esper.current_world)
        esper.switch_world(self._context)
        self.sync()
        return self

    def __exit__(self, *_: object) -> None:
        esper.switch_world(self._outer.pop())
        turns.turn.__exit__()

    def touch(self) -> None:
        """Let the neighbour indexes be made anew: something may have been moved through handles."""
        for table in self.tables.values():
            table.version += 1

    # --- for systems -----------------------------------------------------------------------------------------------

    def index(self, table: Table) -> Index:
        """Return the neighbour index of a table that has Position, as things stand now; any thread may ask."""
        from ecs_eco.components.position import Position

        if self._pool is not None and not self._shared and self._index_of(table).version != table.version:
            stale = [t for t in self.tables.values() if Position in t and t is not table]
            self.together(*(lambda t=t: self._build(t) for t in [table, *stale]))
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
        from ecs_eco.components.position import Position

        index = self._index_of(table)
        if index.version != table.version:
            with index.lock:
                if index.version != table.version:
                    p, high = table[Position], table.high
                    index.build(table.alive[:high], p.x[:high], p.y[:high], p.z[:high], table.uid[:high])
                    index.version = table.version
        return index

    def surroundings(self, quantity: str, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return light, temperature [K] or pressure [Pa] at places f32[n] [m]: f32[n].

        `environment[quantity]`, a function (world, x, y, z), replaces the constant in `ambient`.
        """
        if quantity in self.environment:
            return gate.one_each(self.environment[quantity](self, x, y, z), x.size, f"environment[{quantity!r}]")
        return np.full(x.size, self.ambient[quantity], np.float32)

    def split(self, kernel: Callable[..., Any], n: int, *arguments: Any, work: int | None = None) -> None:
        """Run `kernel(first, last, *arguments)` over 0…n, in parts on all threads where `work` items are worth it."""
        if self._pool is None or self._shared or (n if work is None else work) < PARALLEL_FROM:
            kernel(0, n, *arguments)
            return
        bounds = [n * i // self.threads for i in range(self.threads + 1)]
        others = [self._pool.submit(kernel, a, b, *arguments) for a, b in zip(bounds[1:], bounds[2:], strict=False)]
        try:
            kernel(0, bounds[1], *arguments)
        finally:
            wait(others)  # whoever looks at the world after an error finds nobody at work on it
        for part in others:
            part.result()

    def together(self, *work: Callable[[], Any]) -> None:
        """Do independent pieces of work, on all threads where the world is large enough; they must not share what they write."""
        if self._pool is None or self._shared or sum(t.n for t in self.tables.values()) < PARALLEL_FROM:
            for piece in work:
                piece()
            return
        self._shared = True  # all threads have their piece: within one nothing is split further
        try:
            others = [self._pool.submit(piece) for piece in work[1:]]
            try:
                if work:
                    work[0]()
            finally:
                wait(others)
            for done in others:
                done.result()
        finally:
            self._shared = False

    def series(self) -> Any:
        """Return the recorded series as a pyarrow.Table: a row per tick and species; see `ecs_eco.record`."""
        if self.recorder is None:
            raise RuntimeError("this world has no recorder; build it with World.from_config, or add one: ecs_eco.record.Recorder(world)")
        return self.recorder.series()

    # --- kept on disk ----------------------------------------------------------------------------------------------

    def save(self, path: Any) -> Any:
        """Write a checkpoint, from which the world goes on to the same bytes; see `ecs_eco.checkpoint.file`."""
        from ecs_eco.checkpoint.file import save

        return save(self, path)

    @classmethod
    def restore(cls, path: Any, *, threads: int = 1, **options: Any) -> "World":
        """Return the world that a checkpoint holds; see `ecs_eco.checkpoint.file.restore`."""
        from ecs_eco.checkpoint.file import restore

        return restore(cls, path, threads=threads, **options)

    def copy(self, **how: Any) -> "World":
        """Return a world of its own that goes on to the same bytes; see `ecs_eco.checkpoint.copying.copy`."""
        from ecs_eco.checkpoint.copying import copy

        return copy(self, **how)

    def fork(self, seed: int, **how: Any) -> "World":
        """Return a copy in which all chance is another from here on; see `ecs_eco.checkpoint.copying.fork`."""
        from ecs_eco.checkpoint.copying import fork

        return fork(self, seed, **how)

    def __copy__(self) -> NoReturn:
        raise TypeError(f"world {self.name!r}: a copy by copy.copy would share its organisms; use world.copy() or world.fork(seed=…)")

    def __deepcopy__(self, memo: Any) -> NoReturn:
        raise TypeError(f"world {self.name!r}: copy.deepcopy cannot copy what esper holds; use world.copy() or world.fork(seed=…)")

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"world {self.name!r} cannot be pickled; use world.save(path) and World.restore(path)")

    def load(self, path: Any, *, trust: bool = False) -> None:
        """Bring this world, built by hand in the same way, to the state that a checkpoint holds."""
        from ecs_eco.checkpoint.file import load

        load(self, path, trust=trust)

    def digest(self) -> str:
        """Return a hash of all that decides this world's future, also of what is asked for and not yet done; see `ecs_eco.digest`.

        Equal runs have equal digests on one target: the same versions and processor, compiled (docs/promises.md). With
        NUMBA_DISABLE_JIT=1, which interprets kernels, digests are others.
        """
        from ecs_eco.digest import digest

        return digest(self)


class _Flush(esper.Processor):
    def __init__(self, world: World) -> None:
        self.world = weakref.proxy(world)


class _Deaths(_Flush):
    def process(self, *_: Any) -> None:
        self.world.flush_deaths()


class _Births(_Flush):
    def process(self, *_: Any) -> None:
        self.world.flush_births()


class _Registry(_Flush):
    def process(self, *_: Any) -> None:
        self.world.sync()


class _Touched(_Flush):
    def process(self, *_: Any) -> None:
        self.world.touch()
        gate.admit(self.world, refuse=self.world.debug is None)


class _Inside:
    """Within one esper context, and back."""

    def __init__(self, context: str) -> None:
        self.context = context

    def __enter__(self) -> None:
        turns.turn.__enter__()
        self.outer = esper.current_world
        if self.outer != self.context:
            esper.switch_world(self.context)

    def __exit__(self, *_: object) -> None:
        if esper.current_world != self.outer:
            esper.switch_world(self.outer if self.outer in esper.list_worlds() else "default")
        turns.turn.__exit__()


def _forget(context: str, pool: ThreadPoolExecutor | None) -> None:
    if pool is not None:
        pool.shutdown(wait=False)
    if context in esper.list_worlds():
        if esper.current_world == context:
            esper.switch_world("default")
        esper.delete_world(context)

