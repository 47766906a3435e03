"""Custom plain components on esper's entities, and the arrays of a world's parts in a checkpoint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import esper
import numpy as np

from ecs_eco.engine.errors import CheckpointError
from ecs_eco.inputs.code import Code, CodeError
from ecs_eco.inputs.section import function_name
from ecs_eco.record.frame import under

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld

Arrays = dict[str, np.ndarray]


def put(arrays: Arrays, owner: str, state: Mapping[str, Any]) -> None:
    """Add the arrays of a part's state; raise CheckpointError for anything but arrays of numbers."""
    for key, value in state.items():
        array = np.asarray(value)
        if array.dtype.kind not in "biuf":
            raise CheckpointError(
                f"{owner}: state() gives {key!r} as {array.dtype}; expected arrays of numbers"
            )
        arrays[f"{owner}/{key}"] = array


def stateful(world: SpatialWorld) -> dict[str, Any]:
    """Return all objects with state() and load(), keyed by names that depend only on how the world is built."""
    kept = {
        f"table/{t.name}/trait/{key}": part
        for t in world.tables.values()
        for key, part in sorted(t.parts().items())
        if has_state(part)
    }
    kept |= {
        f"system/{i}/{type(s).__name__}": s
        for i, s in enumerate(world.systems)
        if has_state(s) and s is not world.recorder
    }
    if has_state(world.terrain):
        kept["terrain"] = world.terrain
    return kept


def has_state(part: Any) -> bool:
    """Return whether a part has its own state, that is, the methods state() and load()."""
    both = all(callable(getattr(part, name, None)) for name in ("state", "load"))
    return both and not isinstance(part, type)


def of_code(where: str, error: CodeError) -> CodeError:
    """Return the code error with the name of the checkpoint that lists the code added to it."""
    title = f"{where}: {error.title or 'lists forbidden code'}"
    return CodeError(error.problems, error.title if where in error.title else title)


def freeze_plain(world: SpatialWorld, arrays: Arrays) -> list[list[Any]]:
    """Put custom plain components into `arrays`; return their owners."""
    out: list[list[Any]] = []
    for uid, thing in plain_components(world):
        if not (callable(getattr(thing, "state", None)) and callable(getattr(type(thing), "restore", None))):
            raise CheckpointError(
                f"organism {uid} has a {type(thing).__name__}, which cannot be saved: give its class "
                "state() → dict of arrays of numbers, and a class method restore(state)"
            )
        put(arrays, f"plain/{len(out)}", thing.state())
        out.append([uid, function_name(type(thing))])
    return out


def plain_components(world: SpatialWorld) -> list[tuple[int, Any]]:
    """Return (uid, component) of all components that are not columns, in order."""
    plain = [
        one for table in world.tables.values() for one in world.context.registry.plain(table, table.rows())
    ]
    return sorted(plain, key=lambda f: (f[0], function_name(type(f[1]))))


def load_plain(
    world: SpatialWorld, listed: Sequence[Sequence[Any]], arrays: Arrays, where: str, code: Code
) -> None:
    """Give organisms the plain components that a checkpoint lists for them."""
    if not listed:
        return
    with world.context.inside():
        for i, (uid, name) in enumerate(listed):
            try:
                kind: Any = code.function(name)
            except CodeError as error:
                raise of_code(where, error) from None
            except (ImportError, AttributeError) as error:
                module = name.partition(":")[0]
                raise CheckpointError(
                    f"{where}: organism {uid} has a component {name}, which is not in {module}: {error}"
                ) from None
            esper.add_component(world.entity(int(uid)), kind.restore(under(arrays, f"plain/{i}/")))
