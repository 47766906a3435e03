"""The model behind a description: kinds, the systems that act on them, and the submodels in use."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple

from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.names import own_features
from ecs_eco.ecosystem import World
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.engine.table import Table
from ecs_eco.inputs.section import Section
from ecs_eco.odd.values import applies, found_at


class Part(NamedTuple):
    """A declared submodel, the system that declares it, if any, and the kinds to which it applies."""

    submodel: Submodel
    system: System | None
    kinds: list[str]


class Model:
    """A world and the model derived from the declarations of its systems and sections."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.config: WorldConfig | None = world.config
        systems = [one for one in world.systems if isinstance(one, System) and one.phase != "record"]
        self.systems = sorted(systems, key=lambda system: -system.priority)
        declared = () if self.config is None else (*self.config.species, *self.config.objects)
        self.sections: dict[str, Species | ObjectType] = {
            name: table.species.section
            for name, table in self.tables.items()
            if table.species.section is not None and name in declared
        }

    @property
    def tables(self) -> dict[str, Table]:
        """The world's tables by kind, organisms first."""
        tables = self.world.tables
        return {name: tables[name] for name in sorted(tables, key=lambda n: (n not in self.organisms, n))}

    @cached_property
    def organisms(self) -> list[str]:
        """The kinds of organisms: the species or, without a world file, all tables."""
        return sorted(self.world.tables if self.config is None else self.config.species)

    def places(self, kind: str | None = None) -> list[Section]:
        """Return the sections in which to look up keys, for one kind or for all."""
        own = [section for name, section in self.sections.items() if kind in (None, name)]
        return [*own, *([] if self.config is None else [self.config])]

    def named(self, system: System) -> list[str]:
        """Return the kinds on which a system acts in this world; empty if it does nothing here."""
        submodel, asked = system.submodel or Submodel(), system.asked_for or (lambda table: True)
        having = [name for name, table in self.tables.items() if asked(table) and table.has(system.needs)]
        return [name for name in having if self.concerns(submodel, name)]

    def concerns(self, submodel: Submodel, kind: str) -> bool:
        """Return whether a submodel applies to a kind."""
        places, table = self.places(kind), self.world.tables[kind]
        return not submodel.where or any(applies(key, places, table) for key in submodel.where)

    @cached_property
    def active(self) -> dict[System, list[str]]:
        """The systems that act in this world, in their order, and the kinds on which they act."""
        acting = {system: self.named(system) for system in self.systems}
        return {system: kinds for system, kinds in acting.items() if kinds}

    @cached_property
    def parts(self) -> dict[str, list[Part]]:
        """The submodels by title: surroundings first, then systems in their order, then other sections."""
        parts: dict[str, list[Part]] = {}
        around = [] if self.config is None else [s for s in map(_submodel, _declared(self.config)) if s.reads]
        for submodel in [one for one in around if not one.where]:
            self._add(parts, submodel, None, list(self.tables))
        for system, kinds in self.active.items():
            self._add(parts, system.submodel or Submodel(title_of(system)), system, kinds)
        for name, kind in self.sections.items():
            for submodel in map(_submodel, _declared(kind)):
                self._add(parts, submodel, None, [name] if self.concerns(submodel, name) else [])
        for submodel in [one for one in around if one.where]:
            self._add(parts, submodel, None, [name for name in self.tables if self.concerns(submodel, name)])
        return parts

    @staticmethod
    def _add(
        parts: dict[str, list[Part]], submodel: Submodel, system: System | None, kinds: list[str]
    ) -> None:
        if not (submodel.title and kinds):
            return
        known = parts.setdefault(submodel.title, [])
        if (same := next((part for part in known if part.submodel is submodel), None)) is not None:
            same.kinds.extend(kinds)
        else:
            known.append(Part(submodel, system, list(kinds)))

    def claimed(self, kind: str) -> set[str]:
        """Return the keys of a kind (of the world for "") whose values are parameters of submodels."""
        return {
            key
            for parts in self.parts.values()
            for part in parts
            if not kind or kind in part.kinds
            for key in self.keys(part)
        }

    def keys(self, part: Part) -> list[str]:
        """Return the keys of a submodel's parameters, including a custom feature's keys for its systems."""
        features = [] if self.config is None else own_features(self.config)
        own = [one for one in features if type(part.system) in one.systems]
        return [*part.submodel.reads, *(key for one in own for key in one.model_fields)]

    def changes(self, kind: str, component: str, field: str, titled: bool = False) -> bool:
        """Return whether any system of this world changes a state variable of a kind; with `titled`, ignore
        systems that only do bookkeeping."""
        wanted = {component, f"{component}.{field}"}
        for system, kinds in self.active.items():
            if titled and system.submodel is not None and not system.submodel.title:
                continue
            for change in self.changed_by(system):
                key, _, what = change.rpartition(": ")
                holders = [self.sections[one] for one in kinds if one in self.sections]
                named = (
                    any(kind in found_at(one, key.split(".")) for one in holders) if key else kind in kinds
                )
                if what in wanted and named:
                    return True
        return False

    @staticmethod
    def changed_by(system: System) -> tuple[str, ...]:
        """Return the fields that a system changes; without a submodel, all components that it needs."""
        if system.submodel is None:
            return tuple(component.__name__ for component in system.needs)
        return system.submodel.changes


def _declared(section: Section) -> Iterator[Section]:
    """Yield the sections within a section that declare a submodel, except for species."""
    for name in type(section).model_fields:
        value = getattr(section, name)
        if isinstance(value, Section):
            if value.submodel is not None:
                yield value
            yield from _declared(value)


def _submodel(section: Section) -> Submodel:
    return section.submodel or Submodel()


def is_built_in(system: System) -> bool:
    """Return whether a system is part of this package."""
    return type(system).__module__.startswith("ecs_eco.systems.")


def title_of(system: System) -> str:
    """Return a system's class name, split into words."""
    name = type(system).__name__
    return "".join(f" {c.lower()}" if c.isupper() and i else c for i, c in enumerate(name))
