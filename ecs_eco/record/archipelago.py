"""The manifest of an archipelago: one file that lists the checkpoints of all its islands at one barrier."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from ecs_eco.config.models.archipelago import Archipelago
from ecs_eco.engine.errors import ForeignFile
from ecs_eco.inputs.section import Name, Section
from ecs_eco.record import container
from ecs_eco.record.manifest import Config, Seed, Sha, Tick

FILE = "archipelago.json"
ISLANDS = "islands"  # contains the islands' run folders


class Islands(Config):
    """The configuration of a world with islands."""

    archipelago: Archipelago


class Barrier(Section):
    """The progress of an island at a barrier."""

    tick: Tick
    digest: Sha
    sent: dict[str, dict[Name, int]]
    n: dict[str, int]
    seconds: float


class Manifest(container.Container):
    """The manifest of an archipelago; as in a run, `versions` are part of its identity."""

    FILE: ClassVar = FILE
    KIND: ClassVar = "archipelago"
    COMMAND: ClassVar = "run"
    OTHER: ClassVar = "belongs to another archipelago"
    DECIDES: ClassVar = ("config", "seed", "policies", "learn", "snapshot_every", "record", "versions")

    kind: Literal["archipelago"]
    world: str
    title: str
    config: Islands
    config_hash: Sha
    folder: str
    code: list[dict[str, str]]
    seed: Seed
    ticks: Annotated[Tick, Field(ge=1)]
    policies: str | dict[str, str]
    learn: bool | dict[str, bool] | None
    snapshot_every: Annotated[Tick, Field(ge=1)] | None
    record: str | None
    command: str | None
    git_commit: str | None
    tick: Tick
    islands: dict[Name, Barrier]
    digest: Sha | None
    finished: bool
    wall_seconds: float


def is_archipelago(folder: Path | str) -> bool:
    """Return whether a folder contains an archipelago's run."""
    return container.has(Path(folder), Manifest)


def read(folder: Path) -> dict[str, Any]:
    """Return the manifest; raise RecordingError if it is missing or damaged."""
    return container.read(folder, Manifest)


def check_island(path: Path, manifest: Mapping[str, Any], archipelago: str, name: str) -> None:
    """Raise ForeignFile if a run does not belong to this island of the archipelago with this hash."""
    if (manifest.get("archipelago"), manifest.get("island")) != (archipelago, name):
        raise ForeignFile(
            f"{path / 'manifest.json'}: does not belong to the island {name} of this archipelago"
        )


def digest_of(islands: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the digest of an archipelago: a hash of the islands' digests in order."""
    sha = hashlib.sha256()
    for name, island in islands.items():
        sha.update(f"{name} {island['digest']}\n".encode())
    return sha.hexdigest()
