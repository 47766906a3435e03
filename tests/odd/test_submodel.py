"""Declarations of submodels: their keys exist, and what a system changes is what it declares."""

from __future__ import annotations

import typing
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import ecs_eco.components
from ecs_eco import World
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.submodel import Submodel
from ecs_eco.inputs.section import Section
from ecs_eco.odd.model import Model
from ecs_eco.systems.schedule import RESPAWNING, SCHEDULE


def models_in(kind: Any) -> Iterator[type[Section]]:
    """Yield the sections that a type may hold."""
    if isinstance(kind, type) and issubclass(kind, Section):
        yield kind
    for part in typing.get_args(kind):
        yield from models_in(part)


def knows(model: type[Section], path: list[str]) -> bool:
    """Whether a section has a dotted key; names within tables of plain values are free."""
    info = model.model_fields.get(path[0])
    if info is None:
        return model.model_config.get("extra") == "allow" or path[0] == "from"
    inner = [*models_in(info.annotation)]
    return len(path) == 1 or not inner or any(knows(one, path[1:]) for one in inner)


def submodels() -> dict[str, Submodel]:
    systems = {s for phases in (SCHEDULE, RESPAWNING) for some in phases.values() for s in some}
    found = {s.__name__: s.submodel for s in systems}
    waiting, seen = [WorldConfig], set()
    while waiting:
        model = waiting.pop()
        seen.add(model)
        found |= {model.__name__: model.submodel} if model.submodel is not None else {}
        inner = [one for info in model.model_fields.values() for one in models_in(info.annotation)]
        waiting += [one for one in inner if one not in seen]
    return found  # type: ignore[return-value]


DECLARED = submodels()


@pytest.mark.parametrize("name", sorted(DECLARED))
def test_every_shipped_system_declares_a_submodel_whose_keys_exist(name: str) -> None:
    submodel = DECLARED[name]
    assert submodel is not None
    conditions = [one.strip() for key in (*submodel.where, *submodel.rules) for one in key.split("&")]
    changed = [change.partition(": ")[0] for change in submodel.changes if ": " in change]
    for condition in (*filter(None, conditions), *submodel.reads, *changed):
        if condition[0].isupper():
            assert hasattr(ecs_eco.components, condition)
        else:
            path = condition.partition("=")[0].split(".")
            assert any(knows(model, path) for model in (WorldConfig, Species, ObjectType)), condition


@pytest.mark.parametrize("name", sorted(DECLARED))
def test_what_a_submodel_changes_are_components_and_their_fields(name: str) -> None:
    for change in DECLARED[name].changes:
        component, _, field = change.rpartition(": ")[2].partition(".")
        assert not field or field in getattr(ecs_eco.components, component).fields


@pytest.mark.slow
@pytest.mark.parametrize("name", ["predator-prey", "lamb", "island", "diel-migration"])
def test_a_state_variable_that_changes_in_life_is_described_as_dynamic(name: str) -> None:
    world = World.from_config(name, record=False)
    model = Model(world)
    world.run(1)
    before = {(t, c, f): table.field(c, f)[table.alive].copy() for t, c, f, table in columns(world)}
    uids = {t: table.uid[table.alive] for t, table in world.tables.items()}
    world.run(3)
    for (t, component, field), old in before.items():
        table = world.tables[t]
        now = {int(uid): row for row, uid in enumerate(table.uid) if table.alive[row]}
        kept = [(i, now[int(uid)]) for i, uid in enumerate(uids[t]) if int(uid) in now]
        new = table.field(component, field)[[row for _, row in kept]]
        if not np.array_equal(old[[i for i, _ in kept]], new, equal_nan=old.dtype.kind == "f"):
            assert model.changes(t, component.__name__, field), f"{t}: {component.__name__}.{field}"


def columns(world: World) -> Iterator[tuple[str, type[Any], str, Any]]:
    for name, table in world.tables.items():
        for component in table:
            if component not in table.derived:
                for field, (kind, _) in component.fields.items():
                    if not kind.blocked:
                        yield name, component, field, table
