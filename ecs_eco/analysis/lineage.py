"""The lineage of a run: all births and deaths, and phylogenies in standard formats (CSV and Newick)."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import pyarrow as pa

from ecs_eco.analysis import breeding as breeder, carriers, genes
from ecs_eco.analysis.page import write_text
from ecs_eco.analysis.pedigree import ALIVE, Pedigree, among
from ecs_eco.analysis.runs import read_manifest, tables, whole_table
from ecs_eco.engine.uids import island_of, matched
from ecs_eco.record.archipelago import ISLANDS, is_archipelago, read
from ecs_eco.record.frame import SeriesTable
from ecs_eco.record.genomes import genes_of
from ecs_eco.record.parquet import to_codes

PLAIN = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-")


def write_csv(lineage: Pedigree, path: Path) -> Path:
    """Write a row for each organism, sorted by uid, in the phylogeny format of Lalejini et al. (2019, "Data
    Standards for Artificial Life Software", Proceedings of ALIFE). Founders have the ancestors "[none]", living
    organisms the destruction_time "inf"; recorded fields are empty if missing."""
    parents = zip(lineage.parent.tolist(), lineage.parent2.tolist(), strict=True)
    columns = {
        "id": lineage.uid.tolist(),
        "ancestor_list": [
            f"[{','.join(str(p) for p in dict.fromkeys(pair) if p) or 'none'}]" for pair in parents
        ],
        "origin_time": lineage.born.tolist(),
        "destruction_time": ["inf" if died < 0 else died for died in lineage.died.tolist()],
        "taxon_label": lineage.species.tolist(),
        "genome": lineage.genome.tolist(),
    }
    for name, values in lineage.recorded.items():
        columns[name] = ["" if np.isnan(x) else x for x in values]
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([columns, *zip(*columns.values(), strict=True)])
    return write_text(path, out.getvalue())


def newick(lineage: Pedigree, names: Sequence[str] | None = None) -> str:
    """Return the tree along first parents. Every organism is a node named by its uid; children are sorted by
    uid. The length of a branch is the time from the parent's birth to the child's [ticks]. Several founders
    share an unnamed root at the first founder's time of birth. If there are no organisms, the tree is ";"."""
    n = len(lineage)
    if not n:
        return ";"
    label = [quoted(str(name)) for name in (lineage.uid.tolist() if names is None else names)]
    born, mother = lineage.born.tolist(), lineage.mother.tolist()
    roots = [i for i in range(n) if mother[i] < 0]
    first = min(born[i] for i in roots)
    order = np.argsort(lineage.mother, kind="stable")
    # the children of i are order[begin[i] : begin[i + 1]]
    begin = np.searchsorted(lineage.mother[order], np.arange(n + 1)).tolist()
    order = order.tolist()
    alone, words = len(roots) == 1, list[str]()
    left: list[int | str] = [*roots] if alone else _within(roots, ")")
    while left:
        i = left.pop()
        if isinstance(i, str):
            words.append(i)
            continue
        since = born[mother[i]] if mother[i] >= 0 else first
        name = label[i] if alone and mother[i] < 0 else f"{label[i]}:{born[i] - since}"
        children = order[begin[i] : begin[i + 1]]
        left += _within(children, f"){name}") if children else [name]
    return "".join([*words, ";"])


def _within(nodes: list[int], end: str) -> list[int | str]:
    """Return nodes in parentheses, separated by commas, the last first."""
    apart = [part for node in reversed(nodes) for part in (node, ",")]
    return [end, *apart[:-1], "("]


def quoted(name: str) -> str:
    """Return a name in Newick syntax, quoted unless it has only letters, digits, dots and hyphens."""
    return name if name and PLAIN.issuperset(name) else "'" + name.replace("'", "''") + "'"


__all__ = ["ALIVE", "Lineage"]
COLUMNS = ("uid", "species", "parent", "parent2", "born", "died", "cause", "genome")  # of `to_pandas`
BIRTHS = {"tick": int, "species": str, "uid": int, "parent": int, "parent2": int, "genome": str}
DEATHS = {"tick": int, "species": str, "uid": int, "cause": str}
ARROW = {int: pa.uint64(), float: pa.float64(), str: pa.string()}  # types of columns that a record lacks


@dataclass(frozen=True)
class Lineage(Pedigree):
    """The pedigree of a run: parents, births, deaths, species and genomes of all organisms.

    Arrays have one entry per organism, sorted by uid or, for several islands, by birth. An organism lives from
    `born` to `died`, exclusive.

    Attributes
    ----------
    uid, parent, parent2 : array of uint64
        Identities; a parent is 0 if there is none.
    species, cause : array of str
        Species and cause of death, "" while alive.
    born, died : array of int64
        [ticks]; `died` is −1 while alive.
    genome : array of str
        "" without one.
    end : int
        Last tick.
    dt : float
        Length of a tick [s].
    genomes : dict
        The manifest's data on genes.
    recorded : dict of str to array of float64
        Fields that the world's `record` key lists, such as "birth: Strain.virulence", NaN if missing.

    Raises
    ------
    ValueError
        If an organism is duplicated, or a parent is unknown or not older than its child.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.analysis.lineage import Lineage
    >>> from ecs_eco.config import load
    >>> from ecs_eco.record import Recorder
    >>> red = {"name": "red", "trait": "reflex.red.weight", "letters": 1, "values": [0, 0, 0, -1]}
    >>> changes = {"species.goat.genome.genes": [red], "species.goat.reproduction.age_min": 1.0}
    >>> herd = World.from_config(load("reflexes", changes), record=False)
    >>> recorder = Recorder(herd, keep_events=True)
    >>> goats = Lineage.of(herd.run(30)).of_species("goat")
    >>> kid, mother = int(goats.uid[-1]), int(goats.parent[-1])
    >>> goats.place(kid) == len(goats) - 1, bool(goats.alive(30)[-1]), float(goats.generation()[-1])
    (True, True, 1.0)
    >>> mother in goats.ancestors(kid), kid in goats.descendants(mother)
    (True, True)
    >>> goats.most_recent_common_ancestor([kid, mother]) == mother
    True
    >>> len(goats) > len(goats.living()) > len(goats.founders_left())
    True
    >>> goats.frequencies("goat", "red", every=10).share.shape, goats.values("red").shape == goats.uid.shape
    ((3, 2), True)
    >>> bool(goats.course("goat", "red", every=10).mean[0] < 0), goats.generation_time("goat") > 1
    (True, True)
    >>> goats.selection("goat", "red", "-1").samples
    30
    >>> goats.to_csv("goats.csv").name, goats.to_newick(living=True)[-1]
    ('goats.csv', ';')
    """

    @classmethod
    def of(cls, world: Any) -> Self:
        """Return the lineage of a live world.

        Parameters
        ----------
        world : World
            A world with a recorder that keeps events, `Recorder(world, keep_events=True)`.

        Returns
        -------
        Lineage

        Raises
        ------
        RuntimeError
            If the world has no such recorder.
        """
        recorder = world.recorder
        if recorder is None:
            hint = "add one that keeps events: Recorder(world, keep_events=True)"
            raise RuntimeError(f"this world has no recorder; {hint}")
        births, deaths = recorder.events("births"), recorder.events("deaths")
        born, named = births["species"], np.array(recorder.names or [""])
        births["species"] = named[born.astype(int)] if len(births["uid"]) else born.astype(str)
        births["genome"] = births["genome"].astype(str).astype(object)
        deaths["cause"] = np.array(["", *world.causes])[deaths["cause"].astype(int)]
        genomes = {name: kept for name in recorder.names if (kept := genes_of(world.tables[name]))}
        for events, species in ((births, born), (deaths, deaths["species"])):
            for name, missing in recorder.fields.missing(species.astype(int)).items():
                events[name] = np.where(missing, np.nan, events[name])
        return cls._joined(births, deaths, end=max(world.tick - 1, 0), dt=world.dt, genomes=genomes)

    @classmethod
    def read(cls, folder: Path | str) -> Self:
        """Return the lineage of a run folder.

        Parameters
        ----------
        folder : str or Path
            Folder of a run, an archipelago or one of its islands. The lineage of an archipelago covers all
            islands; in the lineage of one island, immigrants appear when they arrive, and emigrants leave
            with the cause "emigrated".

        Returns
        -------
        Lineage

        Raises
        ------
        FileNotFoundError
            If the folder contains no run.
        RecordingError
            If a file is damaged.

        Examples
        --------
        >>> from ecs_eco.analysis.lineage import Lineage
        >>> from ecs_eco.runs.run import run_to_folder
        >>> manifest = run_to_folder("predator-prey", seed=1, ticks=20, out="my-run", report=False)
        >>> len(Lineage.read("my-run").of_species("wolf")) >= 250
        True
        """
        if is_archipelago(folder):
            return cls._of_islands(Path(folder))
        manifest = read_manifest(folder)
        recorded = _recorded(folder)
        births = _events(folder, "births", BIRTHS | recorded)
        deaths = _events(folder, "deaths", DEATHS | recorded)
        if "genome" not in next((t.column_names for t in tables(folder, "births")), ["genome"]):
            births = _with_founders(births, deaths)
        if "island" in manifest:
            births, deaths = _present(folder, births, deaths)
        return cls._of_run(births, deaths, manifest)

    @classmethod
    def _of_islands(cls, root: Path) -> Self:
        """Return the lineage of all islands, in which each migrant has one birth and at most one death."""
        folders = [root / ISLANDS / name for name in read(root)["islands"]]
        recorded = _recorded(folders[0])
        births, deaths = (
            {name: np.concatenate([part[name] for part in parts]) for name in columns}
            for kind, columns in (("births", BIRTHS | recorded), ("deaths", DEATHS | recorded))
            for parts in [[_events(folder, kind, columns) for folder in folders]]
        )
        return cls._of_run(births, deaths, read_manifest(folders[0]))

    @classmethod
    def _of_run(
        cls, births: dict[str, np.ndarray], deaths: dict[str, np.ndarray], run: dict[str, Any]
    ) -> Self:
        """Return the lineage of a run with this manifest."""
        end, dt = max(run.get("done", run.get("ticks", 0)) - 1, 0), run.get("dt", 1.0)
        return cls._joined(births, deaths, end=end, dt=dt, genomes=run.get("genomes", {}))

    @classmethod
    def _joined(cls, births: dict[str, np.ndarray], deaths: dict[str, np.ndarray], **more: Any) -> Self:
        uid = births["uid"].astype(np.uint64)
        # parents come first: sorted by uid on one island, by birth on several
        one = not len(uid) or island_of(uid.min()) == island_of(uid.max())
        first = births.get("order", births["tick"])
        order = np.argsort(uid, kind="stable") if one else np.lexsort((uid, first))
        uid = uid[order]
        died, cause = np.full(len(uid), ALIVE, np.int64), np.zeros(len(uid), deaths["cause"].dtype)
        by_uid = np.argsort(uid, kind="stable")
        at, there = matched(uid[by_uid], deaths["uid"])
        if not there.all():
            raise ValueError(f"lineage: {deaths['uid'][~there][0]} died, but its birth was not recorded")
        at = by_uid[at]
        died[at], cause[at] = deaths["tick"], deaths["cause"]
        more["recorded"] = recorded = {}
        for name in (name for name in births if "." in name):  # fields of components
            recorded[f"birth: {name}"] = births[name][order].astype(float)
            recorded[f"death: {name}"] = np.full(len(uid), np.nan)
            recorded[f"death: {name}"][at] = deaths[name]
        more |= {name: births[name][order] for name in ("parent", "parent2", "species", "genome")}
        return cls(uid=uid, born=births["tick"][order].astype(np.int64), died=died, cause=cause, **more)

    frequencies = carriers.frequencies
    values = carriers.values_of
    course = genes.course
    generation_time = genes.generation_time
    selection = genes.selection
    breeding = breeder.breeding
    gradients = breeder.gradients

    def to_pandas(self) -> Any:
        """Return a pandas.DataFrame with a row for each organism: uid, species, parents (0: none), born and
        died [ticks], cause, genome and recorded fields; died and cause are missing for living organisms."""
        columns: dict[str, Any] = {name: getattr(self, name) for name in COLUMNS} | self.recorded
        columns |= {name: pa.array(columns[name], mask=self.died == ALIVE) for name in ("died", "cause")}
        return SeriesTable(pa.table(columns)).to_pandas()

    def genes_to_pandas(self, species: str) -> Any:
        """Return a pandas.DataFrame of gene `values`, with a row for each uid and a column for each gene."""
        own = self.of_species(species)
        genes = [g for g in carriers.genes_in(self.genomes.get(species, {})) if "weights" not in g]
        values = {gene["name"]: own.values(gene["name"], species) for gene in genes}
        return SeriesTable(pa.table({"uid": own.uid} | values)).to_pandas().set_index("uid")

    def to_csv(self, path: Path | str) -> Path:
        """Write a phylogeny in the ALife data standards format (Lalejini et al. 2019).

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Path
        """
        return write_csv(self, Path(path))

    def to_newick(
        self, path: Path | str | None = None, *, living: bool = False, names: Sequence[str] | None = None
    ) -> str:
        """Return the tree along first parents in Newick format.

        Parameters
        ----------
        path : str or Path, optional
            File to write.
        living : bool, default False
            Keep only living organisms and their ancestors.
        names : sequence of str, optional
            A name for each organism; default: its uid.

        Returns
        -------
        str
        """
        if names is not None and len(names) != len(self):
            raise ValueError(f"lineage: {len(names)} names for {len(self)} organisms; expected one name each")
        chosen = self._forebears(self.died == ALIVE, fathers=False) if living else np.ones(len(self), bool)
        text = newick(self._chosen(chosen), names and [n for n, c in zip(names, chosen, strict=True) if c])
        if path is not None:
            write_text(Path(path), text + "\n")
        return text


def _events(folder: Path | str, kind: str, columns: dict[str, type]) -> dict[str, np.ndarray]:
    """Return columns of all files as str, integers, or f64 for recorded fields; null becomes "", 0 or NaN."""
    rows = whole_table(folder, kind)
    return {name: _column(rows, name, dtype) for name, dtype in columns.items()}


def _recorded(folder: Path | str) -> dict[str, type]:
    """Return the columns of the fields listed in the `record` key of a run's world."""
    first = next(tables(folder, "births"), None)
    return {name: float for name in (() if first is None else first.column_names) if "." in name}


def _present(
    folder: Path | str, births: dict[str, np.ndarray], deaths: dict[str, np.ndarray]
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return an island's births, including immigrants, and its deaths, including permanent emigrants."""
    columns = {"born": int, **BIRTHS, **{name: float for name in births if "." in name}}
    came, left = (_events(folder, kind, columns) for kind in ("arrivals", "departures"))
    last = dict(zip(came["uid"].tolist(), came["tick"].tolist(), strict=True))  # uid → last arrival
    away = dict(zip(left["uid"].tolist(), range(len(left["uid"])), strict=True))
    gone = np.array([i for uid, i in away.items() if left["tick"][i] > last.get(uid, -1)], np.int64)
    _, first = np.unique(came["uid"], return_index=True)
    new = first[~np.isin(came["uid"][first], births["uid"])]
    births = {
        name: np.concatenate([column, came["born" if name == "order" else name][new]])
        for name, column in (births | {"order": births["tick"]}).items()
    }
    for parent in ("parent", "parent2"):
        births[parent] = among(births[parent], births["uid"])
    more = {name: column[gone] for name, column in left.items()}
    more["cause"] = np.full(gone.size, "emigrated")
    return births, {name: np.concatenate([column, more[name]]) for name, column in deaths.items()}


def _column(rows: pa.Table, name: str, dtype: type) -> np.ndarray:
    missing = pa.chunked_array([pa.nulls(len(rows), ARROW[dtype])])
    column = rows[name] if name in rows.column_names else missing
    if dtype is not str:
        return column.to_numpy().astype(float) if dtype is float else column.fill_null(0).to_numpy()
    column = column.cast(pa.string()).fill_null("")
    if name == "genome":
        return column.to_numpy()
    words, code = to_codes(column)
    return np.array(words or [""])[code]


def _with_founders(births: dict[str, np.ndarray], deaths: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return births, adding organisms known only from a death or a child as founders at tick 0."""
    known: dict[int, str] = {}
    for events, column in ((births, "parent"), (births, "parent2"), (deaths, "uid")):
        uids, species = events[column], events["species"]
        missing = (uids > 0) & ~np.isin(uids, births["uid"])
        known |= dict(zip(uids[missing].tolist(), species[missing].tolist(), strict=True))
    k, uid = len(known), np.array(sorted(known), np.uint64)
    names = np.array([known[int(u)] for u in uid], "U1" if not k else None)
    more: dict[str, np.ndarray] = {"uid": uid, "species": names, "genome": np.full(k, "", object)}
    none = {name: np.zeros(k, column.dtype) for name, column in births.items()}
    return {name: np.concatenate([more.get(name, none[name]), births[name]]) for name in births}
