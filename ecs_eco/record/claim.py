"""Exclusive claims on folders: a process locks a folder before writing to it.

The lock is an operating-system lock (flock) on the file `.lock`, which names its owner. The system releases
it when the process ends for any reason, so claims never become stale. Files left by a process that was killed
before its run began are recognized and can be replaced.
"""

import errno
import json
import os
import re
import socket
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, nullcontext, suppress
from itertools import count
from pathlib import Path
from typing import Any, Self

from ecs_eco.engine import files
from ecs_eco.engine.errors import FolderInUse

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

LOCK = ".lock"
# files written before the manifest, by folder
BEGUN = {"checkpoints": "tick-*.safetensors", "policies": "*.safetensors", "code": "*.py"}
LAND, DATA = "terrain.npz", "data.csv"  # the land and the outside series, also written before the manifest
# temporary files from older versions of safetensors
OF_SAFETENSORS = re.compile(r"\.tmp[A-Za-z0-9]{6}")
WITHOUT = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)  # file system without locks
AGAIN = 1000  # attempts to lock a file that other processes keep removing


class Claim:
    """The exclusive right to write to a folder, held until `release()` or the end of the process.

    Raises FolderInUse if another process, or another part of this process, has claimed the folder.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._made: list[Path] = []
        self._handle = _locked(self.path)

    def check(self) -> None:
        """Raise FolderInUse if the claimed folder was removed, moved or replaced."""
        if not _same(self._handle, self.path / LOCK):
            raise FolderInUse(f"{self.path}: was removed or replaced while in use; stopped writing")

    def release(self) -> None:
        """Release the folder; remove it if it was created for the claim and is empty."""
        still = _same(self._handle, self.path / LOCK)
        if still:
            with suppress(OSError):
                (self.path / LOCK).unlink()
        os.close(self._handle)
        if still:
            _unmake(self._made)
        self._made = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def claim_new(path: str | Path) -> Claim:
    """Claim a new or empty folder; raise FileExistsError if it has content, FolderInUse if it is in use."""
    path = Path(path)
    if path.exists() and not _is_free(path):
        raise FileExistsError(f"{path} exists and is not an empty folder; name another with --out")
    claim = _claim(path)
    if not _is_free(path):  # another process wrote to it first
        claim.release()
        raise FileExistsError(f"{path} exists and is not an empty folder; name another with --out")
    remove_start(path)
    return claim


def claim_next(path: str | Path) -> Claim:
    """Claim a folder that does not exist yet: `path`, or the first unused name among path-2, path-3, …"""
    path = Path(path)
    above, names = _make(path.parent), numbered(path)
    while True:
        folder = next(names)
        try:
            folder.mkdir()
            claim = Claim(folder)
        except (FileExistsError, FolderInUse):
            continue
        except BaseException:
            _unmake(above)
            raise
        claim._made = [*above, folder]
        return claim


def numbered(path: Path) -> Iterator[Path]:
    """Yield a path, then the same with the suffixes -2, -3, …"""
    yield path
    yield from (path.with_name(f"{path.name}-{number}") for number in count(2))


def claimed(out: str | Path | Claim) -> AbstractContextManager[Claim]:
    """Return a context manager that claims a new folder, or passes through an existing claim."""
    return nullcontext(out) if isinstance(out, Claim) else claim_new(out)


def ours(out: str | Path | Claim) -> AbstractContextManager[Claim]:
    """Return a context manager that claims a folder with any contents, or passes through an existing claim."""
    return nullcontext(out) if isinstance(out, Claim) else _claim(Path(out))


def _claim(path: Path) -> Claim:
    """Create a folder if it is missing, and claim it."""
    made = _make(path)
    try:
        claim = Claim(path)
    except BaseException:
        _unmake(made)
        raise
    claim._made = made
    return claim


def owner_of(folder: str | Path) -> dict[str, Any] | None:
    """Return the owner of a claimed folder: pid, host and start time; None if it is not claimed."""
    owner = files.read_note(Path(folder) / LOCK)
    return owner if _lives(owner) else None


def remove_start(folder: Path) -> None:
    """Remove only the files that a run wrote to a folder before it had a manifest."""
    for name, pattern in BEGUN.items():
        for file in [*(folder / name).glob(pattern), *half_written(folder / name)]:
            file.unlink(missing_ok=True)
        with suppress(OSError):
            (folder / name).rmdir()
    for file in [folder / LAND, folder / DATA, *half_written(folder)]:
        file.unlink(missing_ok=True)


def stopped_early(folder: Path) -> bool:
    """Return whether a run in a folder was killed before it had a manifest."""
    return (folder / LOCK).is_file() and not (folder / "manifest.json").exists()


def half_written(folder: Path) -> list[Path]:
    """Return the half-written files that a killed run left in a folder, recognized by name."""
    return [p for p in folder.glob(".*") if _is_half(p) and p.is_file()]


def _is_half(path: Path) -> bool:
    return files.written_beside(path) is not None or (
        path.parent.name in BEGUN and OF_SAFETENSORS.fullmatch(path.name) is not None
    )


def _is_free(path: Path) -> bool:
    """Return whether a folder is empty or contains only files of a run killed before it had a manifest."""
    if not path.is_dir():
        return False
    entries = [p for p in path.iterdir() if p.name != LOCK]
    return not entries or (stopped_early(path) and all(_of_a_start(p) for p in entries))


def _of_a_start(path: Path) -> bool:
    if path.name in BEGUN and path.is_dir():
        return all(p.match(BEGUN[path.name]) or _is_half(p) for p in path.iterdir())
    return path.name in (LAND, DATA) or _is_half(path)


def _make(path: Path) -> list[Path]:
    """Create a folder and its parents; return the created folders."""
    made: list[Path] = []
    for folder in reversed([path, *path.parents]):
        try:
            if not folder.is_dir():
                folder.mkdir()
                made.append(folder)
        except OSError:
            if not folder.is_dir():  # otherwise another process created it
                _unmake(made)
                raise
    return made


def _unmake(made: list[Path]) -> None:
    for folder in reversed(made):
        with suppress(OSError):
            folder.rmdir()


# --- the lock


def _locked(folder: Path) -> int:
    """Lock a folder and return the lock's handle; raise FolderInUse if the folder is in use."""
    path = folder / LOCK
    for _ in range(AGAIN):
        handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        try:
            if not _lock(handle, path):
                raise FolderInUse(
                    f"{folder}: is in use by {_owner(path)}; wait until it ends, or name another folder"
                )
            if _same(handle, path):
                files.require_regular(path)
                os.ftruncate(handle, 0)
                os.lseek(handle, 0, os.SEEK_SET)
                owner = {
                    "pid": os.getpid(),
                    "started": _started(os.getpid()),
                    "host": socket.gethostname(),
                    "since": time.strftime("%Y-%m-%d %H:%M:%S"),
                }
                os.write(handle, json.dumps(owner).encode())
                return handle
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)  # its owner has removed the lock file
    raise FolderInUse(f"{folder}: other processes keep claiming and releasing it")


def _lock(handle: int, path: Path) -> bool:
    """Try to acquire the lock; return whether this succeeded."""
    if fcntl is not None:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            return False
        except OSError as error:
            if error.errno not in WITHOUT:
                raise
    else:
        import msvcrt

        try:
            os.lseek(handle, 1 << 30, os.SEEK_SET)  # beyond the owner's name, which must stay readable
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
            return True
        except OSError:
            return False
    return not _lives(files.read_note(path))  # without locks, the named owner holds it while it runs


def _same(handle: int, path: Path) -> bool:
    """Return whether an open file is still the one at this path."""
    try:
        return os.path.samestat(os.fstat(handle), os.stat(path))
    except OSError:
        return False


def _owner(path: Path) -> str:
    if not (owner := files.read_note(path)):
        return "another process"
    return f"process {owner.get('pid')} on {owner.get('host')} since {owner.get('since')}"


def _started(pid: int) -> int | None:
    """Return the start time of a process in system clock ticks, or None if unknown."""
    try:
        return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19])
    except (OSError, ValueError, IndexError):
        return None


def _lives(owner: dict[str, Any]) -> bool:
    """Return whether a lock's owner is still running; an owner on another machine is assumed to be."""
    if not isinstance(owner.get("pid"), int):
        return False
    if owner.get("host") != socket.gethostname():
        return True
    try:
        os.kill(owner["pid"], 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return owner.get("started") == _started(owner["pid"])
