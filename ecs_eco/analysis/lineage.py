"""Who descends from whom: all births and deaths of a run as arrays, and what can be asked of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from ecs_eco.analysis import phylogeny
from ecs_eco.analysis.carriers import Frequencies, frequencies
from ecs_eco.analysis.runs import parts, read_manifest
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.record import seal
from ecs_eco.record.parquet import open_part, read_part

ALIVE = -1


@dataclass(frozen=True)
class Lineage:
    """All organisms of a run in the order of their uids, an array entry each.

    `uid`, `parent`, `parent2` u64 (0: none); `species` and `cause` str ("" while alive); `born`, `died` i64 [ticks] (died is
    −1 while alive); `genome` str objects ("" without one). Lived ticks are from `born` to `died`, exclusive. `end` is the
    last tick, `dt` [s] its length, `genomes` what the manifest says of genes. Raises ValueError for an organism that is
    there twice, or whose parent is unknown or not older than itself.
    """

    uid: np.ndarray
    parent: np.ndarray
    parent2: np.ndarray
    species: np.ndarray
    born: np.ndarray
    died: np.ndarray
    cause: np.ndarray
    genome: np.ndarray
    end: int = 0
    dt: float = 1.0
    genomes: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not (np.diff(self.uid.astype(np.int64)) > 0).all():
            raise ValueError(f"lineage: the uid {self.uid[1:][np.diff(self.uid.astype(np.int64)) <= 0][0]} is there twice or out of order")
        for parent in (self.parent, self.parent2):
            late = np.flatnonzero(parent >= self.uid)
            if late.size:
                what = f"the organism {self.uid[late[0]]} has the parent {parent[late[0]]}"
                raise ValueError(f"lineage: {what}; allowed are 0 and the uids of those born before it: no loops")
            unknown = np.flatnonzero((parent > 0) & ~np.isin(parent, self.uid))
            if unknown.size:
                what = f"the organism {self.uid[unknown[0]]} has the parent {parent[unknown[0]]}"
                raise ValueError(f"lineage: {what}, of whom no birth is recorded; allowed are 0 and the uids of those recorded")

    def __len__(self) -> int:
        return len(self.uid)

    @classmethod
    def of(cls, world: Any) -> Lineage:
        """The lineage of a world whose recorder keeps events: Recorder(world, keep_events=True)."""
        from ecs_eco.record.folder import genes_of

        recorder = world.recorder
        if recorder is None:
            raise RuntimeError("this world has no recorder; add one that keeps events: Recorder(world, keep_events=True)")
        births, deaths = recorder.events("births"), recorder.events("deaths")
        births["species"] = np.array(recorder.names)[births["species"].astype(int)] if len(births["uid"]) else births["species"].astype(str)
        births["genome"] = births["genome"].astype(str).astype(object)
        deaths["cause"] = np.array(["", *world.causes])[deaths["cause"].astype(int)]
        genomes = {name: found for name in recorder.names if (found := genes_of(world.tables[name]))}
        return cls._joined(births, deaths, end=max(world.tick - 1, 0), dt=world.dt, genomes=genomes)

    @classmethod
    def read(cls, folder: Path | str) -> Lineage:
        """The lineage of a run folder; FileNotFoundError where it holds no run, RecordingError where a file of it is damaged.

        A folder from before genomes were recorded says nothing of its founders: those who died or had offspring are put in.
        """
        manifest = read_manifest(folder)
        sealed = seal.WORD in manifest
        births = _events(folder, "births", {"tick": int, "species": str, "uid": int, "parent": int, "parent2": int, "genome": str}, sealed)
        deaths = _events(folder, "deaths", {"tick": int, "species": str, "uid": int, "cause": str}, sealed)
        files = parts(folder, "births")
        if files and "genome" not in open_part(files[0]).schema_arrow.names:
            births = _with_founders(births, deaths)
        end = max(manifest.get("done", manifest.get("ticks", 0)) - 1, 0)
        return cls._joined(births, deaths, end=end, dt=manifest.get("dt", 1.0), genomes=manifest.get("genomes", {}))

    @classmethod
    def _joined(cls, births: dict[str, np.ndarray], deaths: dict[str, np.ndarray], **more: Any) -> Lineage:
        order = np.argsort(births["uid"], kind="stable")
        uid = births["uid"][order].astype(np.uint64)
        died, cause = np.full(len(uid), ALIVE, np.int64), np.zeros(len(uid), deaths["cause"].dtype)
        at = np.searchsorted(uid, deaths["uid"])
        lost = deaths["uid"] != (uid[np.minimum(at, len(uid) - 1)] if len(uid) else 0)
        if lost.any():
            raise ValueError(f"lineage: {deaths['uid'][lost][0]} died, of whom no birth is recorded")
        died[at], cause[at] = deaths["tick"], deaths["cause"]
        more |= {name: births[name][order] for name in ("parent", "parent2", "species", "genome")}
        return cls(uid=uid, born=births["tick"][order].astype(np.int64), died=died, cause=cause, **more)

    # --- parts of it -------------------------------------------------------------------------------------------------

    def of_species(self, name: str) -> Lineage:
        """The lineage of one species; KeyError names the nearest."""
        known = list(dict.fromkeys(self.species.tolist()))
        if name not in known:
            raise UnknownName(unknown_name("lineage", "species", name, known))
        return self._chosen(self.species == name)

    def living(self) -> Lineage:
        """The living and their ancestors alone."""
        return self._chosen(self._forebears(self.died == ALIVE))

    def _chosen(self, mask: np.ndarray) -> Lineage:
        arrays = {f.name: getattr(self, f.name)[mask] for f in fields(self) if isinstance(getattr(self, f.name), np.ndarray)}
        for name in ("parent", "parent2"):  # a parent of another species is none of this lineage
            arrays[name] = np.where(np.isin(arrays[name], arrays["uid"]), arrays[name], arrays[name].dtype.type(0))
        return replace(self, **arrays)

    @cached_property
    def mother(self) -> np.ndarray:
        """Place of the first parent in the arrays, −1 where there is none: i64."""
        return np.where(self.parent > 0, np.searchsorted(self.uid, self.parent), -1)

    @cached_property
    def father(self) -> np.ndarray:
        """Place of the second parent in the arrays, −1 where there is none: i64."""
        return np.where(self.parent2 > 0, np.searchsorted(self.uid, self.parent2), -1)

    @property
    def founders(self) -> np.ndarray:
        """Whether an organism has no parents: bool."""
        return (self.parent == 0) & (self.parent2 == 0)

    def place(self, uid: int) -> int:
        """Where an organism is in the arrays; KeyError where it is not."""
        at = int(np.searchsorted(self.uid, np.uint64(max(uid, 0))))
        if at == len(self) or self.uid[at] != uid:
            raise KeyError(f"no organism of this lineage has the uid {uid}")
        return at

    def alive(self, tick: int) -> np.ndarray:
        """Whether an organism lives at the end of a tick, as the series count it: bool."""
        return (self.born <= tick) & ((self.died == ALIVE) | (self.died > tick))

    # --- questions ---------------------------------------------------------------------------------------------------

    def ancestors(self, uid: int, generations: int | None = None) -> np.ndarray:
        """The uids of parents, grandparents, … through both parents, ascending; at most so many generations back."""
        found: set[int] = set()
        front, left = {self.place(uid)}, len(self) if generations is None else generations
        while front and left > 0:
            front = {int(line[i]) for i in front for line in (self.mother, self.father) if line[i] >= 0} - found
            found |= front
            left -= 1
        return self.uid[sorted(found)]

    def descendants(self, uid: int) -> np.ndarray:
        """The uids of children, grandchildren, … through both parents, ascending."""
        first = self.place(uid)
        below = [False] * len(self)
        below[first] = True
        mother, father = self.mother.tolist(), self.father.tolist()
        for i in range(first + 1, len(self)):  # parents come before their children
            if (mother[i] >= first and below[mother[i]]) or (father[i] >= first and below[father[i]]):
                below[i] = True
        below[first] = False
        return self.uid[np.array(below, bool)]

    def generation(self) -> np.ndarray:
        """Generation of each organism, f64: founders are 0, others the mean of their parents' plus 1."""
        depth: list[float] = []
        for m, f in zip(self.mother.tolist(), self.father.tolist(), strict=True):
            if m >= 0 and f >= 0:
                depth.append((depth[m] + depth[f]) / 2 + 1)
            else:
                depth.append(depth[max(m, f)] + 1 if m >= 0 or f >= 0 else 0.0)
        return np.array(depth, float)

    def _forebears(self, mask: np.ndarray) -> np.ndarray:
        """Mark the ancestors of the marked, too."""
        marked = mask.tolist()
        mother, father = self.mother.tolist(), self.father.tolist()
        for i in range(len(self) - 1, -1, -1):
            if marked[i]:
                if mother[i] >= 0:
                    marked[mother[i]] = True
                if father[i] >= 0:
                    marked[father[i]] = True
        return np.array(marked, bool)

    def founders_left(self, tick: int | None = None) -> np.ndarray:
        """The uids of the founders that live at the end of a tick (the last one) or have descendants who do."""
        return self.uid[self._forebears(self.alive(self.end if tick is None else tick)) & self.founders]

    def most_recent_common_ancestor(self, uids: Iterable[int]) -> int:
        """The youngest from whom all of these descend along first parents, or who is one of them; 0 where there is none."""
        lines = {self.place(uid) for uid in uids}
        if not lines:
            raise ValueError("lineage: the most recent common ancestor of nobody; hand in at least one uid")
        while len(lines) > 1:
            lines.add(int(self.mother[youngest := max(lines)]))
            lines.remove(youngest)
            if -1 in lines:
                return 0
        return int(self.uid[lines.pop()])

    def samples(self, every: int) -> np.ndarray:
        """The ticks at which something is asked of the whole run: 0, every, 2 every, …"""
        if every < 1:
            raise ValueError(f"lineage: every is {every}; it must be at least 1 tick")
        return np.arange(0, self.end + 1, every)

    def living_sums(self, ticks: np.ndarray, weights: np.ndarray | None = None, mask: np.ndarray | None = None) -> np.ndarray:
        """Sum of weights (1 each) of those that live at the end of each of these ascending ticks, of a mask alone: [ticks]."""
        mask = np.ones(len(self), bool) if mask is None else mask
        change = np.zeros(len(ticks) + 1, np.int64 if weights is None else float)
        for sign, when, who in ((1, self.born, mask), (-1, self.died, mask & (self.died != ALIVE))):
            chosen = None if weights is None else weights[who]
            change += (sign * np.bincount(np.searchsorted(ticks, when[who]), chosen, len(ticks) + 1)).astype(change.dtype)
        return np.cumsum(change[:-1])

    def mean_generation(self, species: str, every: int) -> np.ndarray:
        """Mean generation of the living of a species at each sample: f64, NaN where nobody lives."""
        mask, ticks = self.species == species, self.samples(every)
        n = self.living_sums(ticks, mask=mask)
        return self.living_sums(ticks, self.generation(), mask) / np.where(n, n, np.nan)

    def frequencies(self, species: str, gene: str | Sequence[int], every: int) -> Frequencies:
        """Who carries what of a gene at every so many ticks, exact; see `ecs_eco.analysis.carriers.frequencies`."""
        return frequencies(self, species, gene, every)

    # --- files -------------------------------------------------------------------------------------------------------

    def to_csv(self, path: Path | str) -> Path:
        """Write a phylogeny in the ALife data standards format; see `ecs_eco.analysis.phylogeny.write_csv`."""
        return phylogeny.write_csv(self, Path(path))

    def to_newick(self, path: Path | str | None = None, *, living: bool = False, names: Sequence[str] | None = None) -> str:
        """The tree along first parents in Newick format, written to `path` where given; see `phylogeny.newick`.

        `living` leaves only the living and their ancestors; `names` (uids where absent) has one for each organism.
        """
        if names is not None and len(names) != len(self):
            raise ValueError(f"lineage: {len(names)} names for {len(self)} organisms; one each is needed")
        chosen = self._forebears(self.died == ALIVE) if living else np.ones(len(self), bool)
        text = phylogeny.newick(self._chosen(chosen), names and [n for n, c in zip(names, chosen, strict=True) if c])
        if path is not None:
            phylogeny.write_text(Path(path), text + "\n")
        return text


def _events(folder: Path | str, kind: str, columns: dict[str, type], needed: bool = False) -> dict[str, np.ndarray]:
    """Columns of all parts: strings as str, "" where null; numbers as u64; a column that is not there as 0 or ""."""
    read = [read_part(file, needed=needed) for file in parts(folder, kind)]
    found: dict[str, np.ndarray] = {}
    for name, what in columns.items():
        tables = [t.column(name).cast(pa.string()) if what is str else t.column(name) for t in read if name in t.column_names]
        rows = sum(len(t) for t in read)
        if len(tables) < len(read) or not read:
            found[name] = np.zeros(rows, object if name == "genome" else "U1" if what is str else np.uint64)
            if name == "genome":
                found[name][:] = ""
            continue
        column = pa.chunked_array([chunk for t in tables for chunk in t.chunks], pa.string() if what is str else tables[0].type)
        if name == "genome":
            found[name] = column.fill_null("").to_numpy()
        elif what is str:
            words = column.fill_null("").combine_chunks().dictionary_encode()
            found[name] = np.array(words.dictionary.to_pylist() or [""])[words.indices.to_numpy(zero_copy_only=False)]
        else:
            found[name] = column.to_numpy()
    return found


def _with_founders(births: dict[str, np.ndarray], deaths: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Births with those of whom only a death or a child is recorded: born at tick 0 of nobody."""
    known: dict[int, str] = {}
    told = [(births, "parent"), (births, "parent2"), (deaths, "uid")]
    for uids, species in [(events[column], events["species"]) for events, column in told]:
        missing = (uids > 0) & ~np.isin(uids, births["uid"])
        known |= dict(zip(uids[missing].tolist(), species[missing].tolist(), strict=True))
    k, uid = len(known), np.array(sorted(known), np.uint64)
    more: dict[str, Any] = {"uid": uid, "species": np.array([known[int(u)] for u in uid], "U1" if not k else None),
                            "genome": np.array([""] * k, object)}
    return {name: np.concatenate([more.get(name, np.zeros(k, column.dtype)), column]) for name, column in births.items()}
