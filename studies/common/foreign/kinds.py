"""The kinds of files that do not belong in the folder that contains them, with one function per kind.

Each function modifies the folder it receives, and returns the file name that the refusal must contain and the
readers that must refuse the folder. Each reader must refuse the folder with an error that names the file, and
must not remove any file.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from studies.common.foreign.ground import TICKS, config
from studies.common.foreign.readers import Read, comparing, part, repeating, reporting, resuming

Kind = Callable[[Path], tuple[str, Read]]
KINDS: dict[str, Kind] = {}


def kind(text: str) -> Callable[[Kind], Kind]:
    """Register a function as a kind under this name."""

    def put(function: Kind) -> Kind:
        KINDS[text] = function
        return function

    return put


# --- checkpoints


def _checkpoint(other: str, tick: int = 30) -> Kind:
    def put(place: Path) -> tuple[str, Read]:
        name = f"checkpoints/tick-{tick:012d}.safetensors"
        shutil.copy(place / other / name, place / "a" / name)
        return name, resuming(place / "a")

    return put


kind("a checkpoint from a run with a different seed")(_checkpoint("b"))
kind("a checkpoint from a fork of the run")(_checkpoint("fork"))
kind("an earlier checkpoint from a run with a different seed, at the start of a fork")(
    lambda place: (_checkpoint("b", 20)(place)[0], lambda: _forking(place / "a", place / "new", 22))
)


def _forking(run: Path, out: Path, tick: int) -> Any:
    from ecs_eco.record import fork

    return fork(run, out, from_tick=tick, report=False)


@kind("a checkpoint from the same run with an extra manual request")
def _asked(place: Path) -> tuple[str, Read]:
    _checkpoint("asked")(place)
    return "part-", resuming(place / "a")  # this checkpoint does not follow from the parts


@kind("a world saved outside a run, as a checkpoint")
def _saved(place: Path) -> tuple[str, Read]:
    from ecs_eco import World

    name = f"checkpoints/tick-{TICKS:012d}.safetensors"
    World.from_config(config(), seed=1, record=False).run(TICKS).save(place / "a" / name)
    return name, resuming(place / "a")


# --- parts


def _part(other: str, name: str, into: str | None = None, read: Callable[[Path], Read] = reporting) -> Kind:
    def put(place: Path) -> tuple[str, Read]:
        shutil.copy(place / other / name, place / "a" / (into or name))
        return into or name, read(place / "a")

    return put


def _all_parts(kind_: str) -> Callable[[Path], Read]:
    def reading(run: Path) -> Read:
        from ecs_eco.record.parquet import read_parts

        return lambda: read_parts(run / kind_)

    return reading


for _kind in ("series", "births", "deaths", "snapshots"):
    kind(f"a part of {_kind} from a run with a different seed")(
        _part("b", part(_kind), read=_all_parts(_kind))
    )
kind("a part of the details from a run with a different seed")(
    _part("b", part("details-deer"), read=_all_parts("details-deer"))
)
kind("a part of another species' details")(
    _part("a", part("details-wolf"), part("details-deer"), _all_parts("details-deer"))
)
kind("a part from a run with a different seed, when a run resumes")(
    _part("b", part("series", 1), read=resuming)
)
kind("a part from a fork")(_part("fork", part("series")))
kind("a part from the same run with an extra manual request")(_part("asked", part("series", 1)))
kind("the last part from the same run with an extra manual request")(_part("asked", part("series", 2)))
kind("a part of a different kind")(_part("a", part("births"), part("deaths"), _all_parts("deaths")))
kind("an earlier part in place of a later one")(_part("a", part("series", 0), part("series", 2)))
kind("an extra part from a run with a different seed")(_part("b", part("series", 2), part("series", 3)))
kind("an extra part from the same run")(_part("a", part("series", 2), part("series", 3)))
kind("an extra part from a run with a different seed, when a run resumes")(
    _part("b", part("series", 2), part("series", 3), resuming)
)


@kind("a user's file with a name like a part's, when a run resumes")
def _own(place: Path) -> tuple[str, Read]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"notes": ["mine"]}), place / "a" / "series" / "part-notes.parquet")
    return "part-notes.parquet", resuming(place / "a")


@kind("two swapped parts")
def _swapped(place: Path) -> tuple[str, Read]:
    one, two = (place / "a" / part("series", n) for n in (1, 2))
    one.rename(place / "aside")
    two.rename(one)
    (place / "aside").rename(two)
    return part("series", 1), reporting(place / "a")


@kind("a part that does not identify its run")
def _without(place: Path) -> tuple[str, Read]:
    from ecs_eco.record.parquet import read_part, write_part

    path = place / "a" / part("series", 1)
    write_part(read_part(path).replace_schema_metadata(None), path)
    return part("series", 1), reporting(place / "a")


# --- manifests


def _manifest(other: str, read: Callable[[Path], Read]) -> Kind:
    def put(place: Path) -> tuple[str, Read]:
        shutil.copy(place / other / "manifest.json", place / "a" / "manifest.json")
        return "part-" if read is reporting else "tick-", read(place / "a")

    return put


kind("a manifest from a run with a different seed")(_manifest("b", reporting))
kind("a manifest from a run with a different seed, when a run resumes")(_manifest("b", resuming))
kind("a manifest from a fork")(_manifest("fork", reporting))
kind("a manifest from the same run with an extra manual request")(_manifest("asked", reporting))


@kind("an edited manifest")
def _edited(place: Path) -> tuple[str, Read]:
    path = place / "a" / "manifest.json"
    path.write_text(path.read_text(encoding="utf-8").replace('"seed": 1', '"seed": 2'), encoding="utf-8")
    return "manifest.json", resuming(place / "a")


# --- policies


@kind("another species' policy in a run's folder")
def _policy(place: Path) -> tuple[str, Read]:
    shutil.copy(place / "a" / "policies" / "wolf.safetensors", place / "a" / "policies" / "deer.safetensors")
    return "deer.safetensors", repeating(place / "a")


@kind("a policy from another training run in a run's folder")
def _policy_trained(place: Path) -> tuple[str, Read]:
    shutil.copy(
        place / "trained" / "seed-2" / "deer.safetensors", place / "a" / "policies" / "deer.safetensors"
    )
    return "deer.safetensors", repeating(place / "a")


@kind("a policy with one bit flipped")
def _flipped(place: Path) -> tuple[str, Read]:
    from ecs_eco import World

    path = place / "trained" / "seed-1" / "deer.safetensors"
    data = bytearray(path.read_bytes())
    data[-100] ^= 1
    path.write_bytes(data)
    return "deer.safetensors", lambda: World.from_config(config(), policies=str(path.parent))


# --- comparisons


@kind("a comparison whose seed-2 is a copy of seed-1")
def _copied(place: Path) -> tuple[str, Read]:
    return "manifest.json", comparing(place / "a", 2)


@kind("a comparison whose unfinished seed-2 is a copy of seed-1")
def _half(place: Path) -> tuple[str, Read]:
    return "manifest.json", comparing(place / "half", 2)


@kind("a comparison with a run from another arm")
def _arm(place: Path) -> tuple[str, Read]:
    return "manifest.json", comparing(place / "a", 1, policies="random")


@kind("a comparison with a run whose policies are from another training run")
def _training(place: Path) -> tuple[str, Read]:
    return "manifest.json", comparing(place / "a", 1, policies=str(place / "trained" / "seed-1"))


@kind("a comparison whose training run with seed 2 is a copy of the one with seed 1")
def _trained(place: Path) -> tuple[str, Read]:
    return "training.json", lambda: _trained_already(place / "trained" / "seed-1", 2)


@kind("a policy from another training run in a comparison's training run")
def _trained_policy(place: Path) -> tuple[str, Read]:
    shutil.copy(
        place / "trained" / "seed-2" / "deer.safetensors", place / "trained" / "seed-1" / "deer.safetensors"
    )
    return "deer.safetensors", lambda: _trained_already(place / "trained" / "seed-1", 1)


def _trained_already(folder: Path, seed: int) -> bool:
    from ecs_eco.config import load
    from ecs_eco.lab.jobs import is_trained

    return is_trained(folder, load(config(), {"training.ticks": 3}), seed)


# --- journals


def _journal(change: Callable[[list[str], list[str]], list[str]]) -> Kind:
    def put(place: Path) -> tuple[str, Read]:
        from ecs_eco.lab.searching.journal import NAME, read

        path, other = (place / f"search-{n}" / NAME for n in (1, 2))
        lines = change(*(p.read_text(encoding="utf-8").splitlines() for p in (path, other)))
        path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
        return NAME, lambda: read(path)

    return put


kind("a journal with an edited line")(
    _journal(lambda mine, other: [*mine[:2], json.dumps(json.loads(mine[2]) | {"score": 9.0}), *mine[3:]])
)
kind("a journal with a line from another search")(
    _journal(lambda mine, other: [*mine[:2], other[2], *mine[3:]])
)
kind("a journal with a missing line")(_journal(lambda mine, other: [*mine[:2], *mine[3:]]))
kind("a journal with swapped lines")(_journal(lambda mine, other: [*mine[:2], mine[3], mine[2], *mine[4:]]))
