"""The digest of a world: a hash of everything that determines its future, independent of row order, threads
and files.

The checkpoint format is defined in `ecs_eco.record.checkpoint`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco._lazy import stored_name
from ecs_eco.config.models.interventions import coming
from ecs_eco.engine.interruption import require_whole
from ecs_eco.inputs.section import Use, function_name
from ecs_eco.record.plain import plain_components, stateful

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

BEGINNING = (
    "name",
    "title",
    "description",
    "seed",
    "ticks",
    "training",
    "systems",
    "interventions",
    "code",
    "reporters",
    "record",
)
"""Configuration keys that affect only the start, the names or the measurements of a world, not its future."""


def digest(world: SpatialWorld) -> str:
    """Return the SHA-256 hash of a world between two ticks, 64 hexadecimal digits;
    docs/reference/checkpoints.md lists the state that it covers.

    Identical runs have identical digests on one target with the same versions and processor
    (docs/reference/promises.md). Interpreted kernels (NUMBA_DISABLE_JIT=1) compute with different precision,
    so their digests differ.
    """
    require_whole(world, "digest", within=True)
    if world.bands.divided:
        digest_: str = world.bands.ask(digest)
        return digest_
    sha = hashlib.sha256(json.dumps(_facts(world), sort_keys=True, default=str).encode())
    for name, array in _arrays(world):
        array = np.ascontiguousarray(array)
        sha.update(f"{name} {array.dtype.str} {array.shape}".encode() + array.tobytes())
    return sha.hexdigest()


def _facts(world: SpatialWorld) -> dict[str, Any]:
    """Return everything that is not an array."""
    return {
        "clock": [world.seed, world.tick, world.next_uid, world.dt],
        "space": [world.space.size, world.space.edges],
        "ambient": world.ambient,
        "environment": {quantity: _name(f) for quantity, f in world.environment.items()},
        "reproduction": world.reproduction,
        "values": _values(world),
        "controls": world.origin.get("controls", []),
        "systems": [_name(type(s)) for s in world.systems if type(s).__name__ != "Recorder"],
        "tables": {name: _species(table) for name, table in world.tables.items()},
        "fields": {name: [field.diffusion, field.decay] for name, field in world.fields.items()},
        "causes": {
            name: [world.causes[c - 1] for c in table.cause[_doomed(table)]]
            for name, table in world.tables.items()
        },
    }


def _values(world: SpatialWorld) -> Any:
    """Return the current values of the configuration and the pending interventions."""
    if world.config is None:
        return None
    values = {key: value for key, value in world.config.resolved(former=True).items() if key not in BEGINNING}
    for species in values["species"].values():
        species["policy"].pop("file", None)  # the weights matter, not their origin
        species["policy"].pop("learn", None)  # `_species` has the current value of `learning`
        species["diet"].sort(key=lambda food: food["eats"])
    if given := [dict(system.parameters) for system in world.config.systems if isinstance(system, Use)]:
        values["parameters"] = given
    values["interventions"] = [
        what.model_dump(mode="json") for what in coming(world.config.interventions, world.tick)
    ]
    return values


def _species(table: Table) -> dict[str, Any]:
    nerves = table.species.nerves
    return {
        "components": [stored_name(c) for c in table.columns],
        "barren": bool(table.species.barren),
        "learning": bool(nerves is not None and nerves.learning),
        "policy": bool(nerves is not None and nerves.policy),
        "births": [
            [second is not None, [f"{stored_name(c)}.{f}" for c, f in values]]
            for _, second, values in table.births
        ],
    }


def _arrays(world: SpatialWorld) -> Iterator[tuple[str, np.ndarray]]:
    """Yield all arrays by name; columns are sorted by uid, substances by name."""
    by_name = np.argsort(world.substances)

    def ordered(component: Any, field: str, array: np.ndarray) -> np.ndarray:
        return array[:, by_name] if component.fields[field][0].shape == ("substances",) else array

    for table in world.tables.values():
        rows = table.by_uid()
        for name in ("uid", "born", "killer"):
            yield f"{table.name} {name}", getattr(table, name)[rows]
        yield f"{table.name} doomed", table.uid[_doomed(table)]
        for component, columns in table.columns.items():
            for field, array in sorted(vars(columns).items()):
                yield f"{table.name} {stored_name(component)}.{field}", ordered(component, field, array[rows])
        for i, (parents, second, values) in enumerate(table.births):
            yield f"{table.name} birth {i}", parents
            if second is not None:
                yield f"{table.name} birth {i} second", second
            for (component, field), array in values.items():
                kind = table.defaults[component][field].dtype
                array = ordered(component, field, np.asarray(array, kind))
                yield f"{table.name} birth {i} {stored_name(component)}.{field}", array
    for name, smell in sorted(world.fields.items()):
        yield f"field {name}", smell.value
        yield f"emitted {name}", smell.source
    yield from _states(world)


def _states(world: SpatialWorld) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the states of traits, systems, terrain and the user's plain components."""
    for table in world.tables.values():
        for key, part in sorted(table.parts().items()):
            if callable(getattr(part, "by_uid", None)):
                yield from _named(f"{table.name} {key}", part.by_uid(table.by_uid()))
            elif callable(getattr(part, "state", None)) and not isinstance(part, type):
                yield from _named(f"{table.name} {key}", part.state())
    for owner, part in stateful(world).items():
        if not owner.startswith("table/"):
            state = {key: value for key, value in part.state().items() if not key.startswith("ground.")}
            yield from _named(type(part).__name__, state)
    # removing a fence leaves open ground
    if world.terrain is not None and world.terrain.fences:
        yield "ground", world.terrain.ground
        yield from ((f"fence {i}", corners) for i, corners in enumerate(world.terrain.fences))
    if world.terrain is not None and world.terrain.land is not None:
        yield "land", np.frombuffer(bytes.fromhex(world.terrain.land.sha256), np.uint8)
    for i, road in enumerate(() if world.terrain is None else world.terrain.roads):
        yield f"road {i}", np.array([*road.line.ravel(), road.width, road.pace, road.cost])
    for uid, thing in plain_components(world):
        yield f"plain {uid} {_name(type(thing))}", np.zeros(0, np.uint8)
        if callable(getattr(thing, "state", None)):
            yield from _named("plain", thing.state())


def _named(owner: str, state: dict[str, Any]) -> Iterator[tuple[str, np.ndarray]]:
    for key, value in sorted(state.items()):
        yield f"{owner} {key}", np.asarray(value)


def _doomed(table: Table) -> np.ndarray:
    """Return the rows with a cause of death, sorted by uid: i64[k]."""
    rows = table.by_uid()
    return rows[table.cause[rows] != 0]


def _name(what: Any) -> str:
    """Return module:name of a function or class, but only the name for shipped code, which may move."""
    name = function_name(what) if hasattr(what, "__qualname__") else function_name(type(what))
    return name.rpartition(".")[2].rpartition(":")[2] if name.startswith("ecs_eco.") else name
