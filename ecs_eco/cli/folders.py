"""Folders for results, refused before anything is made in them, and folders of policies."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from ecs_eco.cli.terminal import refuse
from ecs_eco.config import WorldConfig
from ecs_eco.engine.errors import nearest

POLICIES = ("trained", "random", "untrained")


def results(out: Path | None, default: str) -> Path:
    """The folder for results: `out`, or a free one in runs/; ConfigError where it cannot be written or has content.

    Makes nothing: what is made to find out is removed again.
    """
    if out is None:
        out = _free(Path("runs") / default)
    try:
        if out.exists() and not out.is_dir():
            refuse("--out", "is a file", str(out), "a folder, new or empty")
        if out.is_dir() and any(out.iterdir()):
            refuse("--out", "is not empty", str(out), "a folder, new or empty", str(_free(out)))
        _try_out(out)
    except OSError as error:
        refuse("--out", f"cannot be written: {error.strerror or error}", str(out), "a folder that can be made")
    return out


def _free(folder: Path) -> Path:
    """The folder, with the first suffix -2, -3, … that does not exist yet where it does."""
    number, free = 2, folder
    while free.exists():
        free, number = folder.with_name(f"{folder.name}-{number}"), number + 1
    return free


def _try_out(folder: Path) -> None:
    """Makes the folder and a file in it, and removes both; raises OSError."""
    missing = [p for p in (folder, *folder.parents) if not p.exists()]
    made: list[Path] = []
    try:
        for path in reversed(missing):
            path.mkdir()
            made.append(path)
        with tempfile.TemporaryFile(dir=folder):
            pass
    finally:
        for path in reversed(made):
            path.rmdir()


def known_policies(policies: str, config: WorldConfig) -> None:
    """Refuses what is neither a word for policies nor a folder with one for each species that has a policy."""
    allowed = f"{', '.join(POLICIES)}, or a folder that `ecs-eco train` left"
    if policies in POLICIES:
        return
    if not os.path.isdir(policies):
        refuse("--policies", "no such folder", policies, allowed, nearest(policies, POLICIES))
    for name, species in config.species.items():
        if species.policy.kind != "none" and not (Path(policies) / f"{name}.safetensors").is_file():
            refuse("--policies", f"{name}.safetensors is missing in the folder", policies, allowed)
