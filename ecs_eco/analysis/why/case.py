"""A recorded run prepared for diagnosis: diets, deaths by kind of cause, rates, ages and energies."""

import copy
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from ecs_eco.analysis.runs import DIED, Series, load_series, tables, whole_table
from ecs_eco.config.explain import value_at
from ecs_eco.config.models.reporters import EATEN
from ecs_eco.config.ranges import key_of, real_key

KINDS = ("eaten", "starved", "old", "poisoned", "removed", "surroundings")
"""Kinds of causes of death: eaten, lack of energy, age, deadly food, intervention, other lethal limits."""


@dataclass(frozen=True)
class Food:
    """A diet entry: the gain and loss from eating one item."""

    eater: str
    eats: str
    key: str  # key in the world file, such as "species.deer.diet.0"
    gain: float
    poison: float  # energy that the eater loses
    deadly: bool


@dataclass(frozen=True)
class Case:
    """A run: its series, final configuration, deaths of animals, and snapshots."""

    series: Series
    config: Mapping[str, Any]
    # by species: tick, age [s], cause; tick, x, y, z, energy
    deaths: Mapping[str, Mapping[str, np.ndarray]] = field(default_factory=dict)
    snapshots: Mapping[str, Mapping[str, np.ndarray]] = field(default_factory=dict)

    @classmethod
    def read(cls, run: Path | str) -> Self:
        """Read a run folder; raise FileNotFoundError if there is no run, RecordingError if a file is damaged."""
        folder, series = Path(run), load_series(run)
        config = in_force(series.manifest)
        animals = [s for s, values in config.get("species", {}).items() if values.get("diet")]
        snapshots = whole_table(folder, "snapshots", ["tick", "species", "x", "y", "z", "energy"])
        return cls(series, config, _deaths(folder, animals), _by_species(snapshots))

    @property
    def species(self) -> tuple[str, ...]:
        """All species, in the same order as in the run."""
        return self.series.species

    def of(self, species: str) -> Mapping[str, Any]:
        """Return a species' section in the world file, or {} if the run has none."""
        return self.config.get("species", {}).get(species, {})

    @cached_property
    def foods(self) -> tuple[Food, ...]:
        """All entries of all diets."""
        eaten = []
        for s in self.species:
            for i, line in enumerate(self.of(s).get("diet") or ()):
                poison = (self.of(line["eats"]).get("defence") or {}).get("poison", 0.0)
                poison += max(0.0, -line["gain"])
                key, deadly = f"species.{s}.diet.{i}", bool(line.get("deadly"))
                eaten.append(Food(s, line["eats"], key, self._gain(s, line), poison, deadly))
        return tuple(eaten)

    def _gain(self, eater: str, line: Mapping[str, Any]) -> float:
        """Return the gain from one item of food; if the world file sets it as a share of the eaten organism's
        energy, use the average energy of eaten organisms, if recorded, or of living organisms."""
        share, food = line.get("efficiency") or 0.0, line["eats"]
        if not share or food not in self.species:
            return max(0.0, line["gain"])
        meals = float(self.eaten(food, eater).sum())
        if meals and EATEN + food in self.series.columns:
            return max(0.0, float(self.flow(eater, EATEN + food).sum()) / meals)
        n = self.series.of(food)
        held = float((self.flow(food, "energy_mean") * n).sum() / max(n.sum(), 1.0))
        return max(0.0, line["gain"] + share * held)

    def diet(self, species: str) -> tuple[Food, ...]:
        """Return the diet of a species."""
        return tuple(f for f in self.foods if f.eater == species)

    def eaters(self, species: str) -> tuple[str, ...]:
        """Return the species that eat this species."""
        return tuple(dict.fromkeys(f.eater for f in self.foods if f.eats == species))

    def is_animal(self, species: str) -> bool:
        """Return whether a species eats or moves; a species that does neither is a plant."""
        return bool(self.of(species).get("diet") or self.of(species).get("locomotion"))

    @cached_property
    def _removed(self) -> set[str]:
        orders = [order for _, order in self.series.manifest.get("intervened") or ()]
        return {order.get("cause", "culled") for order in orders if order.get("kind") == "cull"}

    def kind(self, species: str, cause: str) -> str:
        """Return the kind of a cause of death, one of KINDS."""
        for limit in self.of(species).get("lethal") or ():
            for name, end, bound, kind in (
                ("energy", "cause_below", "min", "starved"),
                ("age", "cause_above", "max", "old"),
            ):
                if limit["property"] == name and cause == limit.get(end) and limit.get(bound) is not None:
                    return kind
        if cause.startswith(("eaten by ", "poisoned by ")):
            return cause.partition(" ")[0]
        return "removed" if cause in self._removed else "surroundings"

    def died(self, species: str, kind: str) -> np.ndarray:
        """Return the number of deaths from a kind of cause in each tick, (ticks,)."""
        causes = (c for c in self.series.causes if self.kind(species, c) == kind)
        return self._total(self.series.of(species, DIED + c) for c in causes)

    def eaten(self, prey: str, eater: str) -> np.ndarray:
        """Return the number of `prey` that `eater` ate in each tick, (ticks,), or 0 if it was not recorded."""
        return self.flow(prey, f"{DIED}eaten by {eater}")

    def flow(self, species: str, column: str) -> np.ndarray:
        """Return a species' column of the series, (ticks,), such as an energy flow, or 0 if there is none."""
        known = species in self.species and column in self.series.columns
        return self.series.of(species, column) if known else np.zeros(len(self.series.ticks))

    def toll(self, species: str) -> np.ndarray:
        """Return the energy lost through poisonous or harmful food in each tick, (ticks,)."""
        return self._total(f.poison * self.eaten(f.eats, species) for f in self.diet(species))

    def meals(self, species: str) -> np.ndarray:
        """Return the number of nutritious food items eaten in each tick, (ticks,)."""
        good = {f.eats for f in self.diet(species) if f.gain > 0 and not f.deadly}
        return self._total(self.eaten(f, species) for f in good)

    def _total(self, columns: Iterable[np.ndarray]) -> np.ndarray:
        return np.sum([*columns] or [np.zeros(len(self.series.ticks))], axis=0)

    def coded(self, species: str) -> set[str]:
        """Return the keys of a species whose values genes replace, such as "reproduction.energy_min"."""
        genome = self.of(species).get("genome") or {}
        return {one["trait"] for one in (*genome.get("genes", ()), *genome.get("derived", {}).values())}

    def able(self, species: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the ticks of snapshots, and the fraction of a species that had enough energy to breed."""
        way, rows = self.of(species).get("reproduction") or {}, self.snapshots.get(species)
        if rows is None or "energy_min" not in way:
            return np.zeros(0), np.zeros(0)
        ticks, at = np.unique(rows["tick"], return_inverse=True)
        price = way.get("energy_given", 0.0) * (1.0 - way.get("father_share", 0.0))
        enough = (rows["energy"] >= way["energy_min"]) & ((price == 0) | (rows["energy"] > price))
        return ticks, np.bincount(at, weights=enough) / np.bincount(at)


def in_force(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """Return the configuration of a run after its interventions of kind "set"."""
    config = copy.deepcopy(dict(manifest.get("config") or {}))
    for _, done in manifest.get("intervened") or ():
        for name, value in (done.get("set") or {}).items() if done.get("kind") == "set" else ():
            *section, last = key_of(name)
            key, _, wrong = real_key(config, (*section, last))
            parent, inner, unknown = real_key(config, tuple(section))
            if wrong is None:
                value_at(config, key[:-1])[key[-1]] = value
            elif unknown is None and isinstance(inner, dict):  # a key with its default value may be left out
                value_at(config, parent)[last] = value
    return config


def look_up(config: Mapping[str, Any], key: str) -> Any:
    """Return the value at a dotted key, or None if the key does not exist."""
    return real_key(config, key_of(key))[1]


def _deaths(folder: Path, animals: list[str]) -> dict[str, dict[str, np.ndarray]]:
    """Return the tick, age and cause of each animal's death, streamed because plants die by the million."""
    some = pa.array(animals, pa.string())
    batches = tables(folder, "deaths", ["tick", "species", "cause", "age"], batches=True)
    found = [rows.filter(pc.is_in(rows["species"], some)) for rows in batches]
    return _by_species(pa.concat_tables(found)) if found else {}


def _by_species(rows: pa.Table) -> dict[str, dict[str, np.ndarray]]:
    """Return the other columns of each species' rows."""
    out = {}
    for s in pc.unique(rows["species"]).to_pylist() if len(rows) else ():
        own = rows.filter(pc.equal(rows["species"], s))
        out[s] = {name: own[name].to_numpy() for name in rows.column_names if name != "species"}
    return out
