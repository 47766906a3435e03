"""The manifest of an archipelago: one file that names the checkpoints of all its islands at one barrier."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ecs_eco.engine.errors import RecordingError
from ecs_eco.record import seal

FILE = "archipelago.json"
ISLANDS = "islands"  # the folder of the islands' run folders
FORMAT = 1


def is_archipelago(folder: Path | str) -> bool:
    """Return whether a folder holds the run of an archipelago."""
    return (Path(folder) / FILE).is_file()


def read(folder: Path) -> dict[str, Any]:
    """Return the manifest; RecordingError where there is none, or it is damaged."""
    try:
        manifest = seal.read_manifest(folder, FILE)
    except FileNotFoundError as error:
        raise RecordingError(str(error)) from None
    if manifest.get("format") != FORMAT or seal.WORD not in manifest:
        raise RecordingError(f"{folder / FILE}: is no manifest of an archipelago, or of another version of "
                             "ecs-eco")
    return {key: value for key, value in manifest.items() if key != seal.WORD}


def write(folder: Path, manifest: Mapping[str, Any]) -> None:
    """Write the manifest, completely, or leave the one before."""
    seal.write_manifest(folder, manifest, FILE)


def digest_of(islands: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the digest of an archipelago: a hash of those of its islands, in their order."""
    sha = hashlib.sha256()
    for name, island in islands.items():
        sha.update(f"{name} {island['digest']}\n".encode())
    return sha.hexdigest()
