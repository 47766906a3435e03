"""The option --trust, which allows the code listed by a world or a recorded run."""

import os
from collections.abc import Sequence
from pathlib import Path

from ecs_eco.cli.terminal import complain
from ecs_eco.config.loading import code_listed, document_of
from ecs_eco.inputs import trust
from ecs_eco.inputs.code import Code, read
from ecs_eco.record.code import FOLDER
from ecs_eco.record.seal import read_manifest


def allow(wanted: bool, world: str | Path | None, changes: Sequence[str] | None = None) -> None:
    """If `wanted`, allow the code that a world or a run's folder lists, and print its files."""
    if not wanted or world is None:
        return

    code = (
        _of_run(Path(world))
        if os.path.isfile(Path(world) / "manifest.json")
        else code_listed(document_of(world, changes))
    )
    if not code.sources:
        complain("--trust has no effect: this world lists no Python code.")
        return
    trust.remember({source.sha256: source.path for source in code.sources})
    complain(f"Allowed to run until it changes (stored in {trust.file()}):")
    for source in code.sources:
        complain(f"  {source}")


def _of_run(folder: Path) -> Code:
    """Return the code currently in a run's folder."""
    entries = [listed["entry"] for listed in read_manifest(folder).get("code", []) if "entry" in listed]
    return read(entries, [folder / FOLDER])[0]
