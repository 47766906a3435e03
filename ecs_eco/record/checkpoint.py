"""Checkpoints: one file with everything that determines a world's future, so that it resumes bit for bit.

A checkpoint is a safetensors file. Its tensors are the columns of living organisms, fields, weights,
optimizers, rollouts and the state of every other object with `state()`. Its metadata contains `meta` (JSON:
format, versions, configuration, clock, tables), `parts` (JSON: the CRC-32, type and shape of every tensor)
and `seal` (SHA-256 of both). A checkpoint cannot run code.
"""

from __future__ import annotations

import hashlib
import json
import warnings
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from safetensors import SafetensorError, safe_open

from ecs_eco.compiled import portable
from ecs_eco.engine import files
from ecs_eco.engine.arguments import seed_number
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.inputs.section import Use, function_name
from ecs_eco.life.births import ticks
from ecs_eco.life.reconfigure import reseed
from ecs_eco.record import freeze as frozen
from ecs_eco.record.recorder import Recorder

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld

FORMAT = 3
SUFFIX = ".safetensors"
UNREADABLE = (SafetensorError, OSError, MemoryError, *frozen.MALFORMED)
Arrays = dict[str, np.ndarray]
# systems renamed since format 1
RENAMED = {"Bear": "GiveBirth", "Leave": "LeaveRemains", "Reckon": "ResetFlows"}


def _from_1(meta: dict[str, Any], arrays: Arrays) -> tuple[dict[str, Any], Arrays]:
    """Upgrade from format 1, in which some systems had different names and `Age` computed initial ages."""
    meta["systems"] = [RENAMED.get(name, name) for name in meta["systems"]]
    for owner in [owner for owner in meta["stateful"] if owner.startswith("system/")]:
        place, _, name = owner.rpartition("/")
        if name in RENAMED:
            meta["stateful"][f"{place}/{RENAMED[name]}"] = meta["stateful"].pop(owner)
            for key in [key for key in arrays if key.startswith(f"{owner}/")]:
                arrays[f"{place}/{RENAMED[name]}{key.removeprefix(owner)}"] = arrays.pop(key)
    for name, made in meta["tables"].items():
        if "Biology" in made["columns"]:
            made["columns"]["Biology"]["head_start"] = ["<f8", []]
            arrays[f"table/{name}/Biology.head_start"] = np.zeros(len(arrays[f"table/{name}/row"]))
    return meta | {"format": 2}, arrays


def _from_2(meta: dict[str, Any], arrays: Arrays) -> tuple[dict[str, Any], Arrays]:
    """Upgrade from format 2, which stored the remaining digestion time in seconds."""
    for name, made in meta["tables"].items():
        if "Metabolism" in made["columns"]:
            made["columns"]["Metabolism"]["digesting"] = ["<i4", []]
            key = f"table/{name}/Metabolism.digesting"
            arrays[key] = ticks(arrays[key].astype(float), meta["clock"]["dt"]).astype(np.int32)
    return meta | {"format": 3}, arrays


MIGRATIONS: dict[int, Callable[..., tuple[dict[str, Any], Arrays]]] = {1: _from_1, 2: _from_2}
"""Upgrades from each older format to the next; other formats are rejected."""


def save(world: SpatialWorld, path: str | Path) -> Path:
    """Atomically write a checkpoint of a world between two ticks, and return its path.

    The errors are the same as for `ecs_eco.World.save`. If the world's state is divided between processes
    (`ecs_eco.bands`), process 0 writes all of it.
    """
    path = Path(path)
    meta, arrays = frozen.freeze(world)
    if meta:
        write(path, meta, arrays)
    return path


def restore(
    cls: Any,
    path: str | Path,
    *,
    threads: int = 1,
    config: Any = None,
    systems: Sequence[Any] = (),
    prepare: Callable[[Any], None] | None = None,
    record: bool = True,
    trust: bool = False,
) -> Any:
    """Return the world in a checkpoint; arguments and errors are the same as for `ecs_eco.World.restore`."""
    meta, arrays = _read_here(path)
    return _rebuilt(cls, meta, arrays, str(path), threads, config, systems, prepare, record, trust)


def _rebuilt(
    cls: Any,
    meta: Mapping[str, Any],
    arrays: Arrays,
    where: str,
    threads: int,
    config: Any,
    systems: Sequence[Any],
    prepare: Callable[[Any], None] | None,
    record: bool,
    trust: bool = False,
) -> Any:
    """Return a world built from a frozen state."""
    world = frozen.thaw(cls, meta, threads, config, systems, where, trust)
    if prepare is not None:
        prepare(world)
    if record and "recorder" in meta:
        Recorder(world)
    frozen.load(world, meta, arrays, where, trust)
    return world


def load(world: SpatialWorld, path: str | Path, *, trust: bool = False) -> None:
    """Load a checkpoint into a world that was built in the same way; see `ecs_eco.World.load`."""
    meta, arrays = _read_here(path)
    frozen.load(world, meta, arrays, str(path), trust)


def copy(
    world: SpatialWorld,
    *,
    threads: int | None = None,
    systems: Sequence[Any] = (),
    prepare: Callable[[Any], None] | None = None,
) -> Any:
    """Return a world with the same digest and the same future; see `ecs_eco.World.copy`."""
    where = f"copy of the world {world.name!r}"
    meta, arrays = frozen.freeze(world)
    arrays = {name: array.copy() for name, array in arrays.items()}
    meta = json.loads(json.dumps(meta))
    if meta["config"] is None:
        raise CheckpointError(
            f"{where}: it was built by hand; build another in the same way, then call world.save(path) and "
            "other.load(path)"
        )
    handed = [s for s in world.config.systems if not isinstance(s, str | type | Use)]
    if handed and not systems:
        raise CheckpointError(
            f"{where}: the system {function_name(handed[0])} was passed as an instance, which belongs to "
            "one world; pass another: world.copy(systems=[…])"
        )
    config = None if handed else world.config
    threads = world.threads if threads is None else threads

    def prepared(made: Any) -> None:
        made.reporters = {**world.reporters, **made.reporters}  # including tables that were added in Python
        if prepare is not None:
            prepare(made)

    return _rebuilt(type(world), meta, arrays, where, threads, config, systems, prepared, record=True)


def fork(world: SpatialWorld, seed: int, **how: Any) -> Any:
    """Return a copy with a different seed; arguments and errors are the same as for `ecs_eco.World.fork`."""
    seed = seed_number(seed)
    made = copy(world, **how)
    reseed(made, seed)
    return made


def _read_here(path: str | Path) -> tuple[dict[str, Any], Arrays]:
    """Return a checkpoint's meta and arrays; warn if it was written in the other numerical mode."""
    meta, arrays = read(path)
    if why := portable.other_mode(meta):
        warnings.warn(f"{path}: {why}", RuntimeWarning, stacklevel=4)
    return meta, arrays


def write(path: Path, meta: Mapping[str, Any], arrays: Arrays) -> None:
    """Write meta and arrays atomically. Raises an OSError that names the file."""
    arrays = {name: np.ascontiguousarray(array).reshape(np.shape(array)) for name, array in arrays.items()}
    # keys are not sorted, because the order of species and tables matters
    text = json.dumps({"format": FORMAT, **meta}, allow_nan=False)
    parts = json.dumps({name: _sum(array) for name, array in arrays.items()})
    path.parent.mkdir(parents=True, exist_ok=True)
    files.write_tensors(path, arrays, {"meta": text, "parts": parts, "seal": _seal(text, parts)})


def read(path: str | Path) -> tuple[dict[str, Any], Arrays]:
    """Return a checkpoint's meta and arrays; raise CheckpointError if it is unreadable or damaged."""
    meta, parts, arrays = _open(Path(path))
    for name, wanted in parts.items():
        if name not in arrays:
            raise CheckpointError(f"{path}: the part {name!r} is missing")
        if _sum(arrays[name]) != wanted:
            raise CheckpointError(
                f"{path}: the part {name!r} is damaged: "
                f"its checksum is {_sum(arrays[name])[0]}, not {wanted[0]}"
            )
    if more := sorted(set(arrays) - set(parts)):
        raise CheckpointError(f"{path}: contains the unexpected part {more[0]!r}")
    arrays = {name: arrays[name] for name in parts}  # in their original order
    while (number := meta.get("format")) != FORMAT:
        if number not in MIGRATIONS:
            raise CheckpointError(
                f"{path}: has format {number}; this version of ecs-eco reads format {FORMAT}"
            )
        meta, arrays = MIGRATIONS[number](meta, arrays)
    return meta, arrays


def describe(path: str | Path) -> dict[str, Any]:
    """Return a checkpoint's meta without reading its parts; raise CheckpointError if it is unreadable."""
    try:
        files.require_regular(path)
        with safe_open(str(path), framework="numpy") as file:
            return _meta(Path(path), file.metadata())[0]
    except (SafetensorError, OSError) as error:
        raise CheckpointError(f"{path}: is not a checkpoint: {error}") from None


def latest(
    folder: Path,
    before: int | None = None,
    complain: Callable[[str], None] | None = None,
    check: Callable[[Path, dict[str, Any]], object] | None = None,
) -> Path | None:
    """Return the newest intact checkpoint in a folder at or before a tick; report damaged ones to `complain`.

    `check(path, meta)` raises an error if an intact checkpoint must not be used.
    """
    for path in sorted(folder.glob(f"tick-*{SUFFIX}"), reverse=True):
        try:
            if before is None or tick_of(path) <= before:
                meta, _ = read(path)
                if check is not None:
                    check(path, meta)
                return path
        except CheckpointError as error:
            if complain is not None:
                complain(f"{error}; trying the previous checkpoint")
    return None


def name_of(tick: int) -> str:
    """Return the file name of a tick's checkpoint."""
    return f"tick-{tick:012d}{SUFFIX}"


def tick_of(path: Path) -> int:
    """Return the tick in a file name; raise CheckpointError if there is none."""
    word = path.name.removeprefix("tick-").removesuffix(SUFFIX)
    if not word.isdecimal():
        raise CheckpointError(f"{path}: is not named like a checkpoint, such as {name_of(1000)}")
    return int(word)


def _open(path: Path) -> tuple[dict[str, Any], dict[str, list[Any]], Arrays]:
    try:
        files.require_regular(path)
        with safe_open(str(path), framework="numpy") as file:
            meta, parts = _meta(path, file.metadata())
            return meta, parts, {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except FileNotFoundError:
        raise CheckpointError(f"{path}: no such file") from None
    except CheckpointError:
        raise
    except UNREADABLE as error:
        raise CheckpointError(f"{path}: is not a complete checkpoint: {error}") from None


def _meta(path: Path, metadata: Mapping[str, str] | None) -> tuple[dict[str, Any], dict[str, list[Any]]]:
    """Return meta and the list of parts from a file's metadata after checking the seal."""
    content = dict(metadata or {})
    if set(content) != {"meta", "parts", "seal"}:
        raise CheckpointError(f"{path}: is not an ecs-eco checkpoint, or its header is damaged")
    if _seal(content["meta"], content["parts"]) != content["seal"]:
        raise CheckpointError(f"{path}: its header is damaged: the seal does not match")
    return json.loads(content["meta"]), json.loads(content["parts"])


def _sum(array: np.ndarray) -> list[Any]:
    data: Any = np.ascontiguousarray(array).reshape(-1).view(np.uint8)
    return [zlib.crc32(data), array.dtype.str, list(array.shape)]


def _seal(text: str, parts: str) -> str:
    return hashlib.sha256(f"{len(text)} {text}{parts}".encode()).hexdigest()
