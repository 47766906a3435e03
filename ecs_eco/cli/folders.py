"""Results folders, which are checked before any file is written."""

import tempfile
from pathlib import Path

from ecs_eco.cli.terminal import refuse
from ecs_eco.record.claim import Claim, claim_new, claim_next, numbered


def results(out: Path | None, default: str, begun: bool = False) -> Claim:
    """Claim `out`, or an unused folder in runs/, for results; raise ConfigError if it cannot be written or is
    not empty, unless the same command has `begun` it.

    Raises FolderInUse if another process is writing there. A claim that is never used leaves no files.
    """
    try:
        if out is None:
            return claim_next(out := Path("runs") / default)
        if begun:
            return Claim(out)
        if out.exists() and not out.is_dir():
            refuse("--out", "is a file", str(out), "a new or empty folder")
        if any(parent.is_file() for parent in out.parents):
            refuse(
                "--out",
                "cannot be written: a folder above it is a file",
                str(out),
                "a folder that can be created",
            )
        if out.is_symlink() and not out.exists():
            refuse("--out", "is a broken link", str(out), "a folder that can be created")
        return claim_new(out)
    except FileExistsError:
        named = [] if out is None or not out.name else numbered(out)  # "." and "/" have no name
        near = next((str(path) for path in named if not path.exists()), "")
        refuse("--out", "is not empty", str(out), "a new or empty folder", near)
    except OSError as error:
        refuse(
            "--out", f"cannot be written: {error.strerror or error}", str(out), "a folder that can be created"
        )


def pages(out: Path | None, folder: Path) -> None:
    """Raise ConfigError if pages cannot be written to `out` (default: the run's folder); create nothing."""
    source, path = ("DIR", folder) if out is None else ("--out", out)
    allowed = "a writable folder; choose one with --out" if out is None else "a new or existing folder"
    try:
        if path.exists() and not path.is_dir():
            refuse(source, "is not a folder", str(path), allowed)
        _try_out(path)
        if (path / "figures").exists():
            _try_out(path / "figures")
    except OSError as error:
        refuse(source, f"cannot be written: {error.strerror or error}", str(path), allowed)


def _try_out(folder: Path) -> None:
    """Create the folder and a file in it, then remove both; raise OSError if that fails."""
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
