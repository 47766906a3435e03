"""Seals: each file of a recording contains a SHA-256 hash of its contents, which reveals damage.

In a Parquet part, the seal is an entry in the footer, computed with the entry zeroed; in a manifest it is the
key `seal`, computed without the key. Files without a seal can be read unless their manifest requires one.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from ecs_eco.config.document import present
from ecs_eco.engine.errors import RecordingError
from ecs_eco.engine.files import read_json, write_json
from ecs_eco.record.manifest import WRITTEN, Run

KEY = "ecs-eco.seal"
BLANK = "0" * 64
WORD = "seal"  # in the manifest


def sealed(part: bytes) -> tuple[bytes, str]:
    """Fill in the seal of a Parquet file whose footer has BLANK under KEY; return the file and the seal."""
    at = _place(memoryview(part))
    assert at is not None
    assert part[at : at + 64] == BLANK.encode()
    seal = _digest(memoryview(part), at)
    return part[:at] + seal.encode() + part[at + 64 :], seal


def check(path: Path, part: memoryview, needed: bool) -> None:
    """Raise RecordingError if a part's seal does not match, or is `needed` but missing."""
    at = _place(part)
    if at is None:
        if needed:
            raise RecordingError(f"{path}: is damaged: its seal is missing")
    elif bytes(part[at : at + 64]) != _digest(part, at).encode():
        raise RecordingError(f"{path}: is damaged: its {len(part)} bytes differ from what was written")


def _place(part: memoryview) -> int | None:
    """Return the position of the seal's 64 digits, two bytes after the key."""
    start = max(0, len(part) - (1 << 20))  # the footer is at the end
    at = bytes(part[start:]).rfind(KEY.encode())
    place = start + at + len(KEY) + 2
    return place if at >= 0 and place + 64 <= len(part) else None


def _digest(part: memoryview, at: int) -> str:
    digest = hashlib.sha256(part[:at])
    digest.update(BLANK.encode())
    digest.update(part[at + 64 :])
    return digest.hexdigest()


def write_manifest(folder: Path, manifest: Mapping[str, Any], name: str = "manifest.json") -> None:
    """Atomically write the manifest of a run with its seal."""
    content = {key: value for key, value in manifest.items() if key != WORD}
    write_json(folder / name, content | {WORD: _of(content)})


def read_manifest(folder: Path, name: str = "manifest.json") -> dict[str, Any]:
    """Return the manifest of a run; raise FileNotFoundError if there is none, RecordingError if it is
    damaged or was changed."""
    file = folder / name
    if not file.is_file():
        fault = f"has no {name}" if folder.is_dir() else "no such folder"
        raise FileNotFoundError(
            f"{folder} is not a run folder: {fault}; expected: a folder written by `ecs-eco run`"
        )
    manifest = read_json(file)
    if not isinstance(manifest, dict):
        raise RecordingError(f"{file}: is not the manifest of a run")
    content = {key: value for key, value in manifest.items() if key != WORD}
    # all manifests with seals have this key
    if WORD not in manifest and "snapshot_every" in manifest:
        raise RecordingError(f"{file}: is damaged: its seal is missing")
    if WORD in manifest and manifest[WORD] != _of(content):
        raise RecordingError(f"{file}: is damaged or was changed: its seal does not match")
    if name == "manifest.json":
        validate(file, content, Run)
        if WORD in manifest and (missing := [key for key in WRITTEN if key not in manifest]):
            raise RecordingError(f"{file}: the key {missing[0]} is missing; the file is damaged")
    if isinstance(config := manifest.get("config"), dict) and "species" in config:
        manifest["config"] = present(config)
    return manifest


def read_sealed(folder: Path, name: str, model: type[BaseModel]) -> dict[str, Any]:
    """Return a sealed file's contents, validated by a model; errors are the same as for `read_manifest`."""
    content = read_manifest(folder, name)
    if content.pop(WORD, None) is None:
        raise RecordingError(f"{folder / name}: is damaged: its seal is missing")
    validate(folder / name, content, model)
    return content


def validate(file: Path, content: Mapping[str, Any], model: type[BaseModel]) -> None:
    """Raise a RecordingError that names the file and the first key that does not fit the model."""
    try:
        model.model_validate_json(json.dumps(content))
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        what = first["msg"].removeprefix("Value error, ")
        raise RecordingError(
            f"{file}: {place or 'content'}: {what}; the file is damaged, or from another version of ecs-eco"
        ) from None


def has_seals(folder: Path) -> bool:
    """Return whether the parts of a run must have seals, that is, whether its manifest has a seal."""
    return (folder / "manifest.json").is_file() and WORD in read_manifest(folder)


def _of(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, separators=(",", ":")).encode()).hexdigest()
