"""Queries on a recorded run: organisms at a tick, curves, gene values, interventions."""

from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from safetensors import SafetensorError, safe_open

from ecs_eco.analysis.land import Land, land_at
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.config.models.interventions import describe
from ecs_eco.ecosystem import World
from ecs_eco.engine import files
from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError
from ecs_eco.engine.uids import matched
from ecs_eco.record import checkpoint, seal
from ecs_eco.record.details import KIND
from ecs_eco.runs.begin import config_of
from ecs_eco.runs.run import read_manifest
from ecs_eco.view.curves import MOST, extremes, stretch
from ecs_eco.view.interpolate import EVENT, STATE, Chapter, Organisms
from ecs_eco.view.parts import Cache, Columns, Parts
from ecs_eco.view.scene import coloured_genes, sky

CHAPTERS = 3  # chapters kept in memory
COMPARED = ("n", "births", "deaths", "energy_mean", "happiness_mean")
LONGEST = 20_000_000  # with more numbers, curves are chosen from every second, third, … tick
BINS = 400  # maximum number of bins for births and deaths on the timeline


class Recording:
    """A folder written by `ecs-eco run`, read lazily: a damaged file raises an error when first read.

    `first` and `last` are the first and last recorded ticks. `scene` is a world built like the recorded one
    but without organisms; it contains everything that does not change. It is None if it cannot be built here,
    and `why` gives the reason. Raises FileNotFoundError for a folder without a run, and RecordingError for a
    run without a recorded tick."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.manifest = read_manifest(self.path)
        self.species: list[str] = self.manifest["species"]
        self.causes: list[str] = self.manifest.get("causes", [])
        self.dt, self.every = (
            float(self.manifest["dt"]),
            int(self.manifest["snapshot_every"] or max(1, self.manifest["done"])),
        )
        self._sealed, self._cache = seal.has_seals(self.path), Cache()
        self.series, self.births, self.deaths, self.snapshots = (
            self.parts(k) for k in ("series", "births", "deaths", "snapshots")
        )
        span = self.series.ticks()
        if span is None:
            raise RecordingError(f"{self.path}: contains no recorded ticks")
        self.first, self.last = span
        self.details = {name: self.parts(KIND + name) for name in self.species}
        space = self.manifest["config"]["space"]
        self.size, self.torus = [float(s) for s in space["size"]], space.get("edges", "torus") == "torus"
        self._chapter = lru_cache(CHAPTERS)(self._read_chapter)
        self.scene, self.why = self._build()
        if self.scene is not None and (
            strange := [name for name in self.species if name not in self.scene.tables]
        ):
            raise RecordingError(
                f"{self.path / 'manifest.json'}: lists the species {strange[0]!r}, "
                "which its world does not have"
            )

    def parts(self, kind: str, cache: Cache | None = None) -> Parts:
        """Return the parts of one kind; each thread needs its own cache."""
        words = {"species": self.species, "cause": self.causes}
        return Parts(self.path, kind, words, self._cache if cache is None else cache, self._sealed)

    def _build(self) -> tuple[Any, str]:
        try:
            config = config_of(self.manifest, path=self.path)
            return World.from_config(
                config, seed=self.manifest["seed"], policies="random", populate=False, record=False
            ), ""
        except (ConfigError, ImportError, AttributeError, ValueError, TypeError, LookupError) as error:
            # a missing file, for example
            return None, str(error)

    def energy_max(self, species: str) -> float:
        """Return a species' maximum energy."""
        section = self.manifest["config"]["species"][species].get("metabolism") or {}
        return float(section.get("energy_max") or 1.0)

    def organisms(self, tick: int, species: str) -> Organisms:
        """Return a species' living organisms at the end of a tick: from details, otherwise interpolated."""
        organisms = self._chapter(tick // self.every).organisms(tick, self.species.index(species))
        return overlaid(organisms, self.details[species].between(tick, tick, ("uid", *STATE)))

    def _read_chapter(self, number: int) -> Chapter:
        """Return the recorded ticks from one snapshot to the next."""
        begin, end = number * self.every, (number + 1) * self.every
        a, b, state = max(self.first, begin), min(end, self.last + 1), ("uid", "species", *STATE)
        before = self.snapshots.between(a, a, state) if a == begin else None
        if before is not None and not before["uid"].size:
            before = None
        after = self.snapshots.between(b, b, state) if b <= self.last else None
        # without a snapshot, all organisms were born here or were present when the recording began
        since = -(2**62) if before is None else a + 1
        births, deaths = (p.between(since, min(b, self.last), EVENT) for p in (self.births, self.deaths))
        return Chapter(a, b, before, after, births, deaths, self.size, self.torus)

    @cached_property
    def objects(self) -> dict[str, np.ndarray]:
        """Position [m], heading [rad], length, width and height [m] of permanent objects by type, f32[n, 7],
        from the earliest remaining checkpoint; sizes are 0 for spheres."""
        config = self.manifest["config"]
        declared = config.get("objects") or {}
        remains = {s.get("remains") for s in config["species"].values()}
        names = [name for name in declared if name not in remains]
        kept = sorted((self.path / "checkpoints").glob(f"tick-*{checkpoint.SUFFIX}"))
        if not names or not kept:
            return {
                n: np.array(
                    [[*[*at, 0.0][:3], 0, 0, 0, 0] for at in declared[n].get("at", [])], np.float32
                ).reshape(-1, 7)
                for n in names
            }
        try:
            files.require_regular(kept[0])
            with safe_open(str(kept[0]), framework="numpy") as file:
                return {n: lying(file, n, declared[n]["body"].get("shape")) for n in names}
        except (SafetensorError, OSError) as error:
            raise CheckpointError(f"{kept[0]}: not a complete checkpoint: {error}") from None

    @cached_property
    def _births_by_uid(self) -> tuple[np.ndarray, np.ndarray]:
        """The lowest uid in each run of uids born in one tick, ascending, and that tick."""
        uid, tick = [np.zeros(0, np.uint64)], [np.zeros(0, np.int64)]
        for columns in self.births.each(("uid", "tick")):
            order = np.argsort(columns["uid"], kind="stable")
            u, t = columns["uid"][order], columns["tick"][order]
            starts = np.flatnonzero(np.diff(t, prepend=-(2**62)))
            uid.append(u[starts])
            tick.append(t[starts])
        return np.concatenate(uid), np.concatenate(tick)

    def born(self, uid: np.ndarray) -> np.ndarray:
        """Return the tick at which each organism was born: i64[n]."""
        starts, ticks = self._births_by_uid
        if not ticks.size:
            return np.zeros(uid.size, np.int64)
        return ticks[np.maximum(np.searchsorted(starts, uid, side="right") - 1, 0)]

    def genomes(self, uid: np.ndarray) -> list[str]:
        """Return the genomes of organisms (uids ascending) as text, or "" if there is none."""
        out = [""] * uid.size
        for group in self.births.groups:
            if (
                group.uids is not None
                and uid.size
                and group.uids[0] <= uid[-1]
                and group.uids[1] >= uid[0]
                and "genome" in group.names
            ):
                columns = self.births.read(group, ("uid", "genome"))
                for i in np.flatnonzero(np.isin(columns["uid"], uid)):
                    out[int(np.searchsorted(uid, columns["uid"][i]))] = columns["genome"][i] or ""
        return out

    def column(self, name: str, step: int = 1, missing: float = 0.0) -> np.ndarray:
        """Return a series column at every `step`-th tick, `missing` where unrecorded: f64[ticks, species]."""
        out = np.full((len(range(self.first, self.last + 1, step)), len(self.species)), missing)
        for c in self.series.each(("tick", "species", name)):
            since = c["tick"] - self.first
            chosen = since % step == 0
            out[since[chosen] // step, c["species"][chosen]] = c[name][chosen]
        return out

    @cached_property
    def curves(self) -> dict[str, Any]:
        """`tick`, `n` and `happiness` by species, and `reports` by reporter, at the points of a live world;
        `births` and `deaths` in at most BINS bins over all ticks."""
        ticks = self.last + 1 - self.first
        width, step = max(1, -(-ticks // BINS)), 1 + ticks * len(self.species) // LONGEST
        tick, n = np.arange(self.first, self.last + 1, step), self.column("n", step).T
        at = np.union1d(0, extremes(tick, n, max(step, stretch(ticks, len(n), MOST))))

        def of_each(name: str, missing: float = 0.0) -> dict[str, np.ndarray]:
            return dict(zip(self.species, self.column(name, step, missing)[at].T, strict=True))

        out: dict[str, Any] = {
            "tick": tick[at],
            "n": of_each("n"),
            "happiness": of_each("happiness_mean"),
            "reports": {
                name: by_species(of_each(name, np.nan))
                for name in self.manifest["config"].get("reporters") or ()
            },
        }
        for kind in ("births", "deaths"):
            bins = np.zeros(-(-ticks // width))
            for c in self.series.each(("tick", kind)):
                bins += np.bincount((c["tick"] - self.first) // width, c[kind], bins.size)
            out[kind] = bins.astype(np.int64)
        return out

    def numbers(self, tick: int) -> dict[str, int]:
        """Return the number of living organisms of each species at the end of a tick."""
        rows = self.series.between(tick, tick, ("species", "n"))
        return dict.fromkeys(self.species, 0) | {
            self.species[s]: int(n) for s, n in zip(rows["species"], rows["n"], strict=True)
        }

    def recorded(self, tick: int) -> Columns:
        """Return the series of a tick, one row per species, for comparison with a rerun."""
        return self.series.between(tick, tick, COMPARED)

    def sky(self, tick: int) -> tuple[float, float]:
        """Return the light at the surface and the sun's elevation at a tick, as `scene.sky` does."""
        self.scene.tick = tick
        return sky(self.scene)

    def interventions(self) -> list[dict[str, Any]]:
        """Return the tick and text of each intervention."""
        return [{"tick": tick, "text": describe(done)} for tick, done in self.manifest.get("intervened", [])]

    def land(self, tick: int) -> Land:
        """Return the fences, roads and areas of land use at the end of a tick."""
        return land_at(
            self.manifest.get("config") or {}, self.manifest.get("intervened", ()), tick, self.path
        )


def by_species(said: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return a report by species, or under "" if it is a single number for the whole world."""
    first, *others = said.values()
    if all(np.array_equal(first, other, equal_nan=True) for other in others):
        said = {"": first}
    return {name: values for name, values in said.items() if np.isfinite(values).any()}


def overlaid(organisms: Organisms, details: Columns) -> Organisms:
    """Overwrite the states of organisms with their details, where these exist; return the organisms."""
    at, there = matched(organisms.uid, details["uid"].astype(np.uint64))
    at = at[there]
    for name in STATE:
        getattr(organisms, name)[at] = details[name][there]
    organisms.exact[at] = True
    return organisms


def lying(file: Any, name: str, shape: str | None) -> np.ndarray:
    """Return the position, heading and size f32[n, 7] of a type's objects in an open checkpoint."""

    def column(field: str) -> np.ndarray:
        return file.get_tensor(f"table/{name}/{field}")

    pose = [column(f"Position.{field}") for field in ("x", "y", "z", "heading")]
    if shape is None:
        return np.stack([*pose, *[np.zeros_like(pose[0])] * 3], axis=1)
    radius, rounding = column("Body.radius"), column("Shape.rounding")
    sides = [2 * radius * (column(f"Shape.half_{side}") + rounding) for side in ("length", "width", "height")]
    return np.stack([*pose, *sides], axis=1)


class GeneValues:
    """The genes that each code for one number (`codes`, by species and name), and their values in organisms."""

    def __init__(self, recording: Recording) -> None:
        self._recording, scene = recording, recording.scene
        codes = (
            {} if scene is None else {name: coloured_genes(scene.tables[name]) for name in recording.species}
        )
        self.codes = {name: genes for name, genes in codes.items() if genes}
        # values by species, for recently requested uids
        self._kept: dict[str, tuple[np.ndarray, dict[str, np.ndarray]]] = {}

    def expressed(self, name: str, uid: np.ndarray, gene: str) -> np.ndarray:
        """Return a gene's values in organisms (uids ascending): f32[n]."""
        if not uid.size:
            return np.zeros(0, np.float32)
        kept, decoded = self._kept.get(name, (np.zeros(0, np.uint64), {}))
        fresh = uid[~np.isin(uid, kept)]
        if fresh.size:
            values, old = self._decoded(name, fresh), np.isin(kept, uid)
            order = np.argsort(np.concatenate([kept[old], fresh]), kind="stable")
            decoded = {
                g: np.concatenate([decoded.get(g, np.zeros(0, np.float32))[old], values[g]])[order]
                for g in values
            }
            kept = np.concatenate([kept[old], fresh])[order]
            self._kept[name] = kept, decoded
        return decoded[gene][np.searchsorted(kept, uid)]

    def _decoded(self, name: str, uid: np.ndarray) -> dict[str, np.ndarray]:
        layout = self._recording.scene.tables[name].species.heredity.layout
        texts = self._recording.genomes(uid)
        known = np.array([bool(text) for text in texts], np.bool_)
        out = {gene: np.full(uid.size, np.nan, np.float32) for gene in self.codes[name]}
        if known.any():
            loci = layout.rows([text for text in texts if text])
            for gene, values in layout.decode(loci, list(self.codes[name])).items():
                out[gene][known] = values
        return out

    def means(self, tick: np.ndarray) -> dict[str, np.ndarray]:
        """Return the mean of each gene over living organisms at these ticks, f64[n] by "species.gene"."""
        lineage = Lineage.read(self._recording.path)
        out: dict[str, np.ndarray] = {}
        for name, genes in self.codes.items():
            mask = (lineage.species == name) & (lineage.genome != "")
            values = self._decoded(name, lineage.uid[mask])
            n = lineage.living_sums(tick, mask=mask)
            for gene in genes:
                weights = np.zeros(len(lineage))
                weights[mask] = values[gene]
                out[f"{name}.{gene}"] = lineage.living_sums(tick, weights, mask) / np.where(n, n, np.nan)
        return out
