"""Conversion of a world to and from the contents of a checkpoint: JSON and arrays (file: checkpoint.py)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco._lazy import stored_name
from ecs_eco.compiled import portable
from ecs_eco.config import WorldConfig
from ecs_eco.config.document import present
from ecs_eco.config.extension import model_for
from ecs_eco.config.loading import load as load_world
from ecs_eco.config.models.species import Species
from ecs_eco.config.names import names_in
from ecs_eco.engine.errors import CheckpointError, ConfigError
from ecs_eco.engine.interruption import require_whole, whole
from ecs_eco.engine.versions import versions
from ecs_eco.inputs.code import NONE, Code, CodeError
from ecs_eco.inputs.section import Use, function_name
from ecs_eco.life.matter import stocks
from ecs_eco.record.check_arrays import check_arrays
from ecs_eco.record.code import FOLDER, check_code, noted, sources
from ecs_eco.record.frame import under
from ecs_eco.record.land import take_land
from ecs_eco.record.learning import LearningPages
from ecs_eco.record.plain import Arrays, freeze_plain, has_state, load_plain, of_code, put, stateful
from ecs_eco.worlds.build import build

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

MALFORMED = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError)  # unexpected content
OWN = ("uid", "born", "cause", "killer")  # table columns that belong to no component


def freeze(world: SpatialWorld, recording: bool = True) -> tuple[dict[str, Any], Arrays]:
    """Return everything that determines a world's future: meta for JSON, and arrays by name, including the
    state of its recording if `recording`. Both are empty in processes that do not save. Raises RuntimeError
    if called within a tick."""
    require_whole(world, "save")
    recorder = world.recorder if recording else None
    if recorder is not None:
        recorder.flush()
    if (whole := world.bands.undivided(world)) is None:
        return {}, {}
    meta, arrays = parts_of(whole)
    if recorder is not None:
        meta["recorder"] = recorder.names
        put(arrays, "recorder", recorder.state())
    return meta, arrays


def parts_of(world: SpatialWorld) -> tuple[dict[str, Any], Arrays]:
    """Return the same as `freeze` for this process's part of a world."""
    arrays: Arrays = {}
    meta: dict[str, Any] = {
        "versions": versions(),
        "target": portable.target(),
        "name": world.name,
        "clock": {"tick": world.tick, "seed": world.seed, "dt": world.dt, "next_uid": world.next_uid},
        "config": None if world.config is None else world.config.resolved(),
        "viewer": None if world.config is None else world.config.viewer.model_dump(mode="json"),
        "folder": None if world.config is None else str(world.config.folder.absolute()),
        "options": world.origin,
        "reproduction": world.reproduction,
        "ambient": world.ambient,
        "causes": world.causes,
        "environment": sorted(world.environment),
        "instances": _instances(world),
        "tables": {name: _freeze_table(table, arrays) for name, table in world.tables.items()},
        "substances": world.substances,
        "fields": sorted(world.fields),
        "systems": [type(s).__name__ for s in world.systems],
        "intervened": world.intervened,
    }
    for name, field in world.fields.items():
        arrays[f"field/{name}"] = field.value
        if field.source.any():  # emitted after the fields were updated in this tick
            arrays[f"emitted/{name}"] = field.source
    kept = meta["stateful"] = {}
    for owner, part in stateful(world).items():
        if state := part.state():
            kept[owner] = sorted(state)
            put(arrays, owner, state)
    meta["plain"] = freeze_plain(world, arrays)
    if (land := getattr(world.config, "_land", None)) is not None:
        meta["land"] = land.sha256
    meta["code"] = noted(sources(world.config, (name for _, name in meta["plain"])))
    return meta, arrays


def code_of(meta: Mapping[str, Any], where: str, trust: bool) -> Code:
    """Return a checkpoint's code, from the folder of its run or world file. Raises CheckpointError."""
    places = [
        Path(where).parent.parent / FOLDER,
        *([Path(meta["folder"])] if meta["folder"] is not None else []),
    ]
    return check_code(meta.get("code", []), places, where, trust)


def thaw(
    cls: Any,
    meta: Mapping[str, Any],
    threads: int,
    config: Any,
    systems: Sequence[Any],
    where: str,
    trust: bool = False,
) -> Any:
    """Return a world without organisms, built like the frozen world.

    Raises CheckpointError if an argument is missing, CodeError if its code is not allowed to run here.
    """
    if meta["config"] is None:
        raise CheckpointError(
            f"{where}: contains a world that was built by hand; build it again, then call world.load(path)"
        )
    handed = {function_name(s): s for s in systems}
    if missing := [name for name in meta["instances"] if name not in handed and config is None]:
        raise CheckpointError(
            f"{where}: the system {missing[0]} was passed as an instance; pass it again: "
            "World.restore(path, systems=[…])"
        )
    try:
        if config is None:
            data = present(meta["config"]) | {"viewer": meta.get("viewer") or {}}
            data["systems"] = [
                handed.get(name, name) if isinstance(name, str) else name for name in data["systems"]
            ]
            known = Species.model_fields.keys()
            featured = any(section.keys() - known for section in data["species"].values())
            code = code_of(meta, where, trust) if featured else None
            loaded = (WorldConfig if code is None else model_for(code)).model_validate(data)
            take_land(loaded, meta, where)
            # otherwise all code was passed as objects
            if code is not None or any(isinstance(value, str) for _, value in names_in(loaded)):
                loaded._code = code or code_of(meta, where, trust)
            else:
                loaded = loaded.model_copy(update={"code": []})
        else:
            as_it_is = isinstance(config, WorldConfig) and not systems
            loaded = config if as_it_is else load_world(config, systems=systems)
            if loaded.resolved() != present(meta["config"]):
                raise CheckpointError(f"{where}: was saved with a different configuration")
        options = meta["options"] | {
            "policies": {
                name: "random" if source == "random" else "untrained"
                for name, source in meta["options"]["policies"].items()
            },
            "learn": {
                name: made["learning"] for name, made in meta["tables"].items() if name in loaded.species
            },
        }
        world = build(cls, loaded, seed=meta["clock"]["seed"], threads=threads, populate=False, **options)
    except CodeError as error:
        raise of_code(where, error) from None
    except (ConfigError, ImportError, *MALFORMED) as error:
        if isinstance(error, CheckpointError):
            raise
        raise CheckpointError(f"{where}: its world cannot be built here: {error}") from error
    return world


def load(
    world: SpatialWorld, meta: Mapping[str, Any], arrays: Arrays, where: str, trust: bool = False
) -> None:
    """Load a frozen state into a world; raise CheckpointError before any change if it does not match.

    Raises CodeError if organisms have custom components whose code is not allowed to run here.
    """
    require_whole(world, "load")
    code = code_of(meta, where, trust) if meta["plain"] else NONE
    code.require(where)
    check_arrays(world, meta, arrays, where)
    with whole(world, f"a load of {where}"):
        _load(world, meta, arrays, where, code)


def _load(world: SpatialWorld, meta: Mapping[str, Any], arrays: Arrays, where: str, code: Code) -> None:
    clock = meta["clock"]
    world.seed, world.tick, world.next_uid = int(clock["seed"]), int(clock["tick"]), int(clock["next_uid"])
    world.reproduction, world.ambient = meta["reproduction"], dict(meta["ambient"])
    world.causes[:] = meta["causes"]
    world.codes.clear()
    world.intervened = [tuple(done) for done in meta["intervened"]]
    for name, table in world.tables.items():
        _load_table(table, meta["tables"][name], arrays)
    for name, field in world.fields.items():
        field.value[...] = arrays[f"field/{name}"]
        field.source[...] = arrays.get(f"emitted/{name}", 0)
    for owner, part in stateful(world).items():
        if owner in meta["stateful"]:
            _load_part(part.load, owner, arrays, where)
    if world.matter is not None:
        world.matter.turn(stocks(world, world.matter))
    if world.recorder is not None and "recorder" in meta:
        names, tables, recorder = meta["recorder"], list(meta["tables"]), world.recorder
        _load_part(
            lambda state: recorder.load(reordered(world, names, tables, state)), "recorder", arrays, where
        )
    world._forget_neighbours()
    load_plain(world, meta["plain"], arrays, where, code)


# --- tables -------------------------------------------------------------------------------------------------


def _freeze_table(table: Table, arrays: Arrays) -> dict[str, Any]:
    """Put the columns of living organisms into `arrays`; return the table's description."""
    rows, prefix = table.rows(), f"table/{table.name}"
    arrays[f"{prefix}/row"] = rows
    for name in OWN:
        arrays[f"{prefix}/{name}"] = getattr(table, name)[rows]
    columns: dict[str, dict[str, Any]] = {}
    for component, held in table.columns.items():
        fields = columns[stored_name(component)] = {}
        for field, array in vars(held).items():
            arrays[f"{prefix}/{stored_name(component)}.{field}"] = array[rows]
            fields[field] = [array.dtype.str, list(array.shape[1:])]
    births = []
    for i, (parents, second, values) in enumerate(table.births):
        arrays[f"{prefix}/births/{i}/parent"] = parents
        if second is not None:
            arrays[f"{prefix}/births/{i}/second"] = second
        for (component, field), array in values.items():
            arrays[f"{prefix}/births/{i}/{stored_name(component)}.{field}"] = np.asarray(
                array, table.defaults[component][field].dtype
            )
        births.append({"second": second is not None, "values": [f"{stored_name(c)}.{f}" for c, f in values]})
    nerves = table.species.nerves
    return {
        "columns": columns,
        "capacity": table.capacity,
        "births": births,
        "learning": bool(nerves is not None and nerves.learning),
    }


def _load_table(table: Table, made: Mapping[str, Any], arrays: Arrays) -> None:
    prefix = f"table/{table.name}"
    rows = arrays[f"{prefix}/row"]
    table.reserve(int(made["capacity"]))
    table.alive[:] = False
    for name in OWN:
        column = getattr(table, name)
        column[:] = 0
        column[rows] = arrays[f"{prefix}/{name}"]
    table.alive[rows] = True
    table.n, table.high = rows.size, int(rows[-1]) + 1 if rows.size else 0
    if table.onlooker is not None:
        table.onlooker.empty(table)
    known = {stored_name(c): c for c in table.columns}
    for component, held in table.columns.items():
        for field, array in vars(held).items():
            array[rows] = arrays[f"{prefix}/{stored_name(component)}.{field}"]
    table.births = []
    for i, birth in enumerate(made["births"]):
        values = {}
        for word in birth["values"]:
            component, _, field = word.rpartition(".")
            values[known[component], field] = arrays[f"{prefix}/births/{i}/{word}"]
        second = arrays[f"{prefix}/births/{i}/second"] if birth["second"] else None
        table.births.append((arrays[f"{prefix}/births/{i}/parent"], second, values))


# --- objects with their own state ---------------------------------------------------------------------------


def _load_part(load: Callable[[Arrays], None], owner: str, arrays: Arrays, where: str) -> None:
    """Load the state of a part; raise a CheckpointError that names the part if this fails."""
    try:
        load(under(arrays, f"{owner}/"))
    except MALFORMED as error:
        raise CheckpointError(f"{where}: {owner} cannot load its state: {error}") from error


def _instances(world: SpatialWorld) -> list[str]:
    """Return the names of systems that were passed as instances and have no state()."""
    listed = () if world.config is None else world.config.systems
    return [function_name(s) for s in listed if not isinstance(s, str | type | Use) and not has_state(s)]


# --- recorders whose species or tables are in another order -------------------------------------------------


def reordered(
    world: SpatialWorld, species: Sequence[str], tables: Sequence[str], state: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Return the state of a recorder that has these species and tables, reordered for a world's recorder."""
    out, recorder = dict(state), world.recorder
    same = list(species) == recorder.names and list(tables) == list(world.tables)
    if same or sorted(species) != sorted(recorder.names):
        return out
    former, now = _places(recorder.names, species), _places(species, recorder.names)
    for key, array in state.items():
        if key == "stock" or key.startswith("page/"):
            out[key] = array[former]
        elif key.startswith("series/") and key != "series/species" and array.size:
            out[key] = array.reshape(-1, former.size)[:, former].ravel()  # by tick, then species
        elif key in ("births/species", "deaths/species") or (
            key.startswith("learning/") and key.endswith("/species")
        ):
            out[key] = now[array].astype(array.dtype)
    if (key := "learning/actions/action") in state:
        known = LearningPages(world, species).actions
        out[key] = _places(known, recorder.learning.actions)[state[key]].astype(state[key].dtype)
    return out | ({} if recorder.matter is None else _matter(world, tables, state))


def _matter(
    world: SpatialWorld, tables: Sequence[str], state: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Return the reordered pages of matter; holders are tables in order, then fields."""
    holders: list[Any] = list(world.matter.holders)
    known = sorted(holders, key=lambda h: tables.index(h[1]) if h[0] == "table" else len(tables))
    former, now = _places(holders, known), _places(known, holders)
    out = {key: state[key][former] for key in ("matter/stock", "matter/flows") if key in state}
    if (key := "matter/series/holder") in state:
        out[key] = now[state[key]].astype(state[key].dtype)
    return out


def _places(names: Sequence[Any], among: Sequence[Any]) -> np.ndarray:
    """Return the index in `among` of each name: i64[names]."""
    return np.array([list(among).index(name) for name in names], np.int64)
