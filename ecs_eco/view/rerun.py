"""Rerun stretches of a recorded run in a separate thread, and list the stretches with details."""

import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.components import Biology
from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError
from ecs_eco.engine.table import Table
from ecs_eco.esper_bridge.turns import turn
from ecs_eco.record.details import KIND
from ecs_eco.record.recorder import Recorder
from ecs_eco.runs.requests import repeat_requests
from ecs_eco.runs.run import near
from ecs_eco.view.interpolate import STATE
from ecs_eco.view.parts import Columns, Kept
from ecs_eco.view.recording import Recording

ROWS = 2_000_000  # maximum number of organisms times ticks in a stretch
BEFORE, AFTER = 20, 60  # ticks before and after the requested tick


class Stretch:
    """The ticks from `first` to `last`: details by species, states of all organisms, and sexes by uid. `wrong`
    is the first tick at which the series differs from the recording, or None if it never does."""

    def __init__(
        self,
        first: int,
        last: int,
        blocks: dict[str, list[Columns]],
        sexes: dict[int, int],
        wrong: int | None,
    ) -> None:
        self.first, self.last, self.sexes, self.wrong = first, last, sexes, wrong
        self.states = _kept(blocks.get("snapshots", ()))
        self.details = {k.removeprefix(KIND): _kept(rows) for k, rows in blocks.items() if k.startswith(KIND)}

    def at(self, tick: int, species: int) -> Columns:
        """Return the uids and states of all organisms of a species (by number) at a tick."""
        columns = self.states.between(tick, tick, ("species", "uid", *STATE))
        return {name: column[columns["species"] == species] for name, column in columns.items()}


def _kept(blocks: Sequence[Columns]) -> Kept:
    out = Kept(0, 2**62)
    for columns in blocks:
        out.add(columns)
    return out


def compute(
    path: Path,
    manifest: dict[str, Any],
    tick: int,
    end: int,
    recorded: Callable[[int], dict[str, np.ndarray]],
    progress: Callable[[int, int], None] = lambda done, total: None,
    halt: Callable[[], bool] = lambda: False,
) -> Stretch:
    """Rerun a recorded run around a tick and record all details. `end` is its last tick; `recorded(tick)`
    returns its series. Raises CheckpointError, RecordingError or ConfigError for a run that cannot be repeated
    here, and InterruptedError once `halt()` returns true."""
    with turn:
        world = near(path, manifest, tick)
    at = world.tick
    room = max(10, ROWS // max(1, sum(recorded(tick)["n"].tolist())))
    first, last = max(at, tick - min(BEFORE, room // 4)), min(end, tick + min(AFTER, room // 2))

    def look() -> None:
        if halt():
            world.stop()
        repeat_requests(world, manifest)

    world.before_tick.append(look)
    world.run(first - at, lambda done, _: progress(done, last + 1 - at))
    blocks: dict[str, list[Columns]] = {}
    recorder = Recorder(
        world,
        lambda kind, columns: blocks.setdefault(kind, []).append(columns),
        snapshot_every=1,
        record="full",
    )
    sexes: dict[int, int] = {}
    world.on_death.append(lambda table, rows: _note_sexes(table, rows, sexes))
    while world.tick <= last and not halt():
        world.run(1)
        progress(world.tick - at, last + 1 - at)
    for table in world.tables.values():
        _note_sexes(table, table.rows(), sexes)
    if halt():
        raise InterruptedError
    recorder.flush()
    return Stretch(first, last, blocks, sexes, _differs(blocks["series"], recorded))


def _note_sexes(table: Table, rows: np.ndarray, sexes: dict[int, int]) -> None:
    if Biology in table and not table.species.is_object:
        sexes.update(zip(table.uid[rows].tolist(), table[Biology].sex[rows].tolist(), strict=True))


def _differs(blocks: list[Columns], recorded: Callable[[int], dict[str, np.ndarray]]) -> int | None:
    """Return the first tick whose series differs from the recording, or None if none does."""
    for block in blocks:
        for tick in np.unique(block["tick"]).tolist():
            was, here = recorded(tick), block["tick"] == tick
            if any(not np.array_equal(block[name][here], column) for name, column in was.items()):
                return int(tick)
    return None


class Rerun:
    """Reruns one stretch at a time in a thread that owns its world. The caller polls `answer`."""

    def __init__(self, path: Path, manifest: dict[str, Any], end: int) -> None:
        self.path, self.manifest, self.end = path, manifest, end
        self.share = 0.0  # fraction completed
        self.uid = 0  # the requested organism
        self._thread: threading.Thread | None = None
        self._result: Stretch | str | None = None
        self._halted = False

    @property
    def busy(self) -> bool:
        """Whether a stretch is being rerun."""
        return self._thread is not None

    def begin(self, uid: int, tick: int, recorded: Callable[[int], dict[str, np.ndarray]]) -> None:
        """Start rerunning the stretch around a tick."""
        self.uid, self.share, self._result, self._halted = uid, 0.0, None, False
        self._thread = threading.Thread(target=self._work, args=(tick, recorded), name="ecs-eco-again")
        self._thread.start()

    def answer(self) -> Stretch | str | None:
        """Return the stretch once it is ready, the reason if it failed, or None until then."""
        if self._thread is None or self._thread.is_alive():
            return None
        self._thread.join()
        self._thread, result, self._result = None, self._result, None
        return result

    def halt(self, patience: float = 10.0) -> None:
        """Stop the rerun."""
        self._halted = True
        if self._thread is not None:
            self._thread.join(patience)

    def _work(self, tick: int, recorded: Callable[[int], dict[str, np.ndarray]]) -> None:
        def progress(done: int, total: int) -> None:
            self.share = done / max(1, total)

        try:
            self._result = compute(
                self.path,
                self.manifest,
                tick,
                self.end,
                recorded,
                progress,
                # Python waits for this thread at exit, and nothing else can stop it
                lambda: self._halted or not threading.main_thread().is_alive(),
            )
        except InterruptedError:
            self._result = "canceled"
        except (
            CheckpointError,
            RecordingError,
            ConfigError,
            ImportError,
            OSError,
            ValueError,
            FloatingPointError,
        ) as error:
            self._result = str(error)
        except MemoryError:
            self._result = "not enough memory for the rerun"


def stretches(recording: Recording, again: Sequence[Stretch]) -> list[dict[str, Any]]:
    """Return the stretches for `marks`: kind ("full", "focal" or "filled"), first and last tick, species,
    number of focal organisms, and the first tick at which a filled stretch differs from the record."""
    kind, _, most = str(recording.manifest.get("record") or "").partition("=")
    known: dict[tuple[int, int], list[str]] = {}
    for name in recording.species:
        for span in spans(recording, name):
            known.setdefault(span, []).append(name)
    n = int(most) if most.isdecimal() else None
    told: list[tuple[Any, ...]] = [
        ("full" if kind == "full" else "focal", *span, species, n, None) for span, species in known.items()
    ]
    told += [("filled", s.first, s.last, sorted(s.details), None, s.wrong) for s in again]
    return [dict(zip(("kind", "first", "last", "species", "n", "wrong"), one, strict=True)) for one in told]


def spans(recording: Recording, species: str) -> list[tuple[int, int]]:
    """Return the first and last tick of each stretch in which details of a species were recorded."""
    out: list[tuple[int, int]] = []
    for first, last in sorted(group.ticks for group in recording.details[species].groups if group.rows):
        first, last = max(first, recording.first), min(last, recording.last)
        if out and first <= out[-1][1] + 1:
            out[-1] = out[-1][0], max(last, out[-1][1])
        elif first <= last:
            out.append((first, last))
    return out


def note(recording: Recording) -> str:
    """Return a note about which data are exact and which are interpolated."""
    r = recording
    detailed = [name for name in r.species if r.details[name].rows]
    text = "Recorded in every tick."
    if r.every > 1:
        text = (
            f"Recorded every {r.every} ticks; in between, "
            "births and deaths are exact, and positions are interpolated linearly."
        )
    return text + (f" Details of {', '.join(detailed)}: {r.manifest.get('record')}." if detailed else "")
