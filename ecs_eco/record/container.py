"""The manifest of a container, a folder of many runs: a sweep, a comparison, a search or an archipelago.

It contains the hash of its plan and the numerical mode. It is sealed like a run's manifest and validated by a
model. File names in it are untrusted: no file outside the folder is written or removed.
"""

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar, Literal

from ecs_eco.compiled import portable
from ecs_eco.engine import files
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.engine.versions import versions
from ecs_eco.inputs.section import Section
from ecs_eco.record import seal
from ecs_eco.record.manifest import Sha

FORMAT = 2
OLD = (
    "was begun by ecs-eco 0.2.0 or an older version, which did not record its plan and numerical mode; continue "
    "it with release 0.2.0, or start again in another folder; its runs can still be read one by one"
)


class Container(Section):
    """The keys common to all manifests of containers; each kind adds its own keys."""

    FILE: ClassVar[str]
    KIND: ClassVar[str]
    COMMAND: ClassVar[str]  # the command that writes it
    OTHER: ClassVar[str]  # message for a folder with another plan
    DECIDES: ClassVar[tuple[str, ...]]  # the keys of the plan
    GROWS: ClassVar[bool] = False  # whether settings may be added later

    kind: str
    format: Literal[2]
    hash: Sha
    mode: Literal["native", "portable"]
    versions: dict[str, str]

    @classmethod
    def settings(cls, content: Mapping[str, Any]) -> dict[str, Any]:
        """Return the settings of a plan by their public names."""
        return {key: content.get(key) for key in cls.DECIDES}


Model = type[Container]


def has(folder: Path, model: Model) -> bool:
    """Return whether a folder has the manifest of a container."""
    return os.path.isfile(folder / model.FILE)


def read(folder: str | Path, model: Model) -> dict[str, Any]:
    """Return the manifest of a container.

    Raises RecordingError if it is missing, damaged or too old; ForeignFile if its kind or plan is different.
    """
    file = Path(folder) / model.FILE
    try:
        content = seal.read_manifest(Path(folder), model.FILE)
    except FileNotFoundError:
        article = "an" if model.KIND[0] in "aeiou" else "a"
        raise RecordingError(
            f"{folder} is not a folder of {article} {model.KIND}: it has no {model.FILE}; "
            f"expected: a folder written by `ecs-eco {model.COMMAND}`"
        ) from None
    if content.get("format") == 1:
        raise RecordingError(f"{file}: {OLD}")
    if isinstance(kind := content.get("kind"), str) and kind != model.KIND:
        raise ForeignFile(f"{file}: is the manifest of another kind of folder: {kind}, not {model.KIND}")
    own = content.pop(seal.WORD, None)
    seal.validate(file, content, model)
    if own is None:
        raise RecordingError(f"{file}: is damaged: its seal is missing")
    if content["hash"] != _hash(content, model):
        raise ForeignFile(f"{file}: hash: does not match the plan in this file")
    return content


def check(folder: Path, model: Model, plan: Mapping[str, Any]) -> dict[str, Any]:
    """Return the manifest of a container after checking that this plan can continue it.

    Raises ForeignFile if it belongs to another plan or was begun in the other numerical mode.
    """
    there = read(folder, model)
    before, now = model.settings(there), model.settings(json.loads(json.dumps(plan)))
    different = [
        key
        for key in {**before, **now}
        if before.get(key) != now.get(key) and not (model.GROWS and before.keys() ^ now.keys() >= {key})
    ]
    if different:
        values = [
            f"{key}: {before.get(key)} then, {now.get(key)} now"
            for key in different
            if not isinstance(before.get(key, now.get(key)), dict | list)
        ]
        shown = f" ({'; '.join(values)})" if values else ""
        raise ForeignFile(
            f"{folder / model.FILE}: {model.OTHER}: {', '.join(different)} "
            f"differ{'s' * (len(different) == 1)}{shown}; name another folder with --out"
        )
    may_continue(folder / model.FILE, {"target": there})
    return there


def may_continue(file: Path, manifest: Mapping[str, Any]) -> None:
    """Raise ForeignFile if a manifest is from the other numerical mode, or a top-level link leads out."""
    if why := portable.other_mode(manifest):
        raise ForeignFile(f"{file}: {why}")
    for path in file.parent.iterdir():
        if path.is_symlink():
            inside(file.parent, path)


def begin(folder: Path, model: Model, content: Mapping[str, Any]) -> dict[str, Any]:
    """Return a container's manifest: write a new one, or read the existing one if it has this plan."""
    if has(folder, model):
        return check(folder, model, content)
    folder.mkdir(parents=True, exist_ok=True)
    head = {"kind": model.KIND, "format": FORMAT, "mode": portable.mode(), "versions": versions()}
    whole = json.loads(json.dumps(head | dict(content)))
    return write(folder, model, whole | {"hash": _hash(whole, model)})


def write(folder: Path, model: Model, manifest: Mapping[str, Any]) -> dict[str, Any]:
    """Write a manifest atomically and return it."""
    seal.write_manifest(folder, manifest, model.FILE)
    return dict(manifest)


def _hash(content: Mapping[str, Any], model: Model) -> str:
    decides = [content["kind"], content["mode"], *(content.get(key) for key in model.DECIDES)]
    return hashlib.sha256(json.dumps(decides, separators=(",", ":"), sort_keys=True).encode()).hexdigest()


def inside(root: Path, path: Path) -> Path:
    """Return a path in a container; raise ForeignFile if it, or a link below it, leads out of the container."""
    home = os.path.realpath(root)
    links = [
        Path(at, name)
        for at, folders, others in os.walk(path)
        for name in (*folders, *others)
        if os.path.islink(os.path.join(at, name))
    ]
    for one in [path, *links]:
        if os.path.commonpath([home, os.path.realpath(one)]) != home:
            raise ForeignFile(f"{one}: is a link that leads out of {root}; no file is written there")
    return path


def remove(folder: Path, patterns: Sequence[str]) -> bool:
    """Remove the files in a folder that match the patterns, then the folder; return False if others remain."""
    if folder.is_symlink():
        return False
    for file in [p for pattern in patterns for p in folder.glob(pattern) if p.is_file() or p.is_symlink()]:
        file.unlink(missing_ok=True)
    for half in [p for p in folder.glob(".*.tmp") if files.written_beside(p) is not None]:
        half.unlink(missing_ok=True)
    with suppress(OSError):
        folder.rmdir()
    return not folder.exists()
