"""The test for one kind of foreign file."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

from studies.common.foreign.kinds import KINDS


def refused(name: str, whole: Path, place: Path) -> str:
    """Put a foreign file of this kind into a copy of `whole` at `place` and read it; return a description of
    the fault, or "" if the reader refused the file by name.

    The reader must leave the folder unchanged.
    """
    from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError

    shutil.copytree(whole, place)
    wanted, read = KINDS[name](place)
    before = dict(_content(place))
    try:
        read()
    except (RecordingError, CheckpointError, ConfigError) as error:
        if wanted not in str(error):
            return f"the refusal does not name {wanted}: {error}"
        changed = sorted({*dict(_content(place)).items()} ^ {*before.items()})
        return f"was refused but changed {changed[0][0]}" if changed else ""
    return "was taken"


def _content(place: Path) -> Iterator[tuple[str, bytes]]:
    for path in sorted(place.rglob("*")):
        if path.is_file():
            yield str(path.relative_to(place)), path.read_bytes()
