"""Combined records: each process counts its own organisms, and process 0 writes the records."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.learning.individual import summary
from ecs_eco.record.events import EVENTS
from ecs_eco.record.learning import UPDATE
from ecs_eco.record.parts import forget, page_end, renew_means, stocks, sums
from ecs_eco.record.recorder import Recorder

if TYPE_CHECKING:
    from mpi4py.MPI import Comm

    from ecs_eco.ecosystem import World
Groups = dict[str, list[tuple[np.ndarray, ...]]]


def share_recording(world: World, comm: Comm) -> list[tuple[np.ndarray, ...]]:
    """Make all processes record as process 0 does; return the events recorded so far."""
    if (recorder := world.recorder) is not None:
        recorder.flush()  # so that all processes start a page in the same tick
    how = comm.bcast(None if recorder is None else (recorder.block, recorder.snapshot_every, recorder.keeps))
    if comm.Get_rank() == 0 or how is None:
        return [] if recorder is None else [group for groups in recorder._events.values() for group in groups]
    if recorder is None:
        block, every, keeps = how
        recorder = Recorder(world, lambda kind, columns: None, block=block, snapshot_every=every)
        recorder.keeps = keeps
    forget(recorder)
    return []


def collect(bands: Any, recorder: Recorder) -> None:
    """In process 0, merge all records made since the last collection, as if a single process had made them.

    Counts are exact. Energies are summed band by band, not row by row, so their last digits may differ.
    """
    pages, at = recorder.learning.rows, page_end(recorder)
    if bands.place:
        recorder._counts["refused"] = 0  # every process has the same count; keep one
    mine = {
        "sums": [array[:at] for array in sums(recorder)],
        "stocks": stocks(recorder),
        "events": recorder._events,
        "actions": pages["actions"],
        "lessons": bands.lessons,
    }
    parts = bands.wire.comm.gather(mine if bands.place else None)
    if parts is None:
        forget(recorder)
    else:
        parts[0] = mine
        for i, array in enumerate(sums(recorder)):
            array[:at] = sum(part["sums"][i] for part in parts)
        for i, array in enumerate(stocks(recorder)):
            array[...] = sum(part["stocks"][i] for part in parts)
        renew_means(recorder, at)
        turn = np.array([list(bands.world.tables).index(name) for name in recorder.names])
        recorder._events = _merged([part["events"] for part in parts], recorder._last, bands.early, turn)
        pages["actions"] = _counted([row for part in parts for row in part["actions"]])
        pages["learning"] = _learnt(
            bands.world,
            recorder.place,
            pages["learning"],
            [lesson for part in parts for lesson in part["lessons"]],
        )
    bands.lessons.clear()


def _merged(
    parts: list[Groups], last: int, early: Sequence[tuple[np.ndarray, ...]], turn: np.ndarray
) -> Groups:
    """Return the events of all processes sorted by tick, table and uid, as a single process would have
    recorded them. Events recorded before the division (`early`) come first, then events up to tick `last`.
    `turn` i64[species] is the order of the tables."""
    out: Groups = {kind: [] for kind in EVENTS}
    for kind in EVENTS:
        groups = [group for part in parts for group in part[kind]]
        new = [not any(group[0] is one[0] for one in early) for group in groups]
        out[kind] += [group for group, is_new in zip(groups, new, strict=True) if not is_new]
        groups = [group for group, is_new in zip(groups, new, strict=True) if is_new]
        if groups:
            columns = [np.concatenate(column) for column in zip(*groups, strict=True)]
            order = np.lexsort((columns[2], turn[columns[1]], columns[0]))
            over = columns[0][order] <= last
            out[kind] += [
                tuple(column[some] for column in columns) for some in (order[over], order[~over]) if some.size
            ]
    return out


def _counted(rows: list[tuple[Any, ...]]) -> list[tuple[Any, ...]]:
    """Return the number of organisms that performed each action, summed over all processes."""
    sums: dict[tuple[Any, ...], np.ndarray] = {}
    for tick, species, action, n, of in rows:
        key = tick, species, action
        sums[key] = sums.get(key, np.zeros(2, np.int64)) + (n, of)
    return [(*key, *both.tolist()) for key, both in sorted(sums.items(), key=lambda one: one[0][:2])]


def _learnt(
    world: World,
    place: dict[str, int],
    rows: list[tuple[Any, ...]],
    lessons: list[tuple[int, str, tuple[np.ndarray, ...]]],
) -> list[tuple[Any, ...]]:
    """Return the learning statistics: unchanged for shared policies, which are the same in all processes, and
    merged over all processes for individual policies."""
    alone = {
        s
        for name, s in place.items()
        if (nerves := world.tables[name].species.nerves) is not None and nerves.individuals is not None
    }
    out = [row for row in rows if row[1] not in alone]
    together: dict[tuple[int, int], list[tuple[np.ndarray, ...]]] = {}
    for tick, name, arrays in lessons:
        together.setdefault((tick, place[name]), []).append(arrays)
    for (tick, s), each in together.items():
        told = summary(*(np.concatenate(arrays) for arrays in zip(*each, strict=True)))
        if told["n_transitions"]:
            out.append((tick, s, told["n_transitions"], told["n_animals"], *(told[word] for word in UPDATE)))
    return sorted(out, key=lambda row: row[:2])
