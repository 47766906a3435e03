"""The folder of compiled kernels, which no other user can write to.

The files are pickles with machine code, so anyone who can write one can run code here.
"""

from __future__ import annotations

import hashlib
import os
import stat
import warnings
from contextlib import suppress
from functools import cache
from pathlib import Path

import numba

from ecs_eco.compiled import portable
from ecs_eco.compiled.numba_version import plain

_SWITCHES = (
    "BOUNDSCHECK",
    "OPT",
    "LOOP_VECTORIZE",
    "SLP_VECTORIZE",
    "DEBUGINFO_DEFAULT",
    "DISABLE_INTEL_SVML",
    "FULL_TRACEBACKS",
)
CLAIM = ".claim"  # suffix of a file that marks a kernel as being compiled
_HERE = Path(__file__).parent


def _sources_hash() -> str:
    """Return a hash of the sources of all kernels and of the compiler, because numba does not notice changes
    to functions in other files."""
    digest = hashlib.sha256(
        f"{numba.__version__} {[getattr(numba.config, name, None) for name in _SWITCHES]}"
        f"{portable.CPU if portable.on() else ''}".encode()
    )
    for path in sorted(_HERE.parent.rglob("*.py")):
        source = path.read_bytes()
        if path.parent == _HERE or b"njit" in source or b"numba.extending" in source:
            digest.update(path.name.encode() + source)
    return digest.hexdigest()[:12]


@cache
def cache_folder() -> Path:
    """Return the folder of compiled kernels; `ECS_ECO_CACHE` overrides its parent."""
    parent = os.environ.get("ECS_ECO_CACHE") or os.environ.get("NUMBA_CACHE_DIR")
    if not parent:
        parent = os.path.join(
            os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache"), "ecs-eco"
        )
    return (
        Path(parent).absolute()
        / f"kernels-{'portable-' * portable.on()}{'plain-' * plain()}{_sources_hash()}"
    )


def why_not_private(folder: Path) -> str:
    """Return the reason why another user could add files to a folder or replace it, or "" if no other user
    can."""
    for part in reversed(folder.parents):
        if why := _why_not_safe(part):
            return why
    status, me = os.lstat(folder), os.geteuid()
    if not stat.S_ISDIR(status.st_mode):
        return f"{folder} is {'a link' if stat.S_ISLNK(status.st_mode) else 'not a folder'}"
    if status.st_uid != me:
        return f"{folder} belongs to user {status.st_uid}, not to {me}"
    return _open_to_others(folder, status) if _others_may_write(status) else ""


def _why_not_safe(part: Path) -> str:
    """Return the reason why another user could replace entries of a folder; in a sticky folder, such as /tmp,
    only their owners can."""
    status = os.lstat(part)
    if status.st_uid not in (0, os.geteuid()):
        return f"{part} belongs to user {status.st_uid}, not to {os.geteuid()}"
    if stat.S_ISLNK(status.st_mode):
        real = Path(os.path.realpath(part))
        return next(filter(None, map(_why_not_safe, (*reversed(real.parents), real))), "")
    return (
        _open_to_others(part, status)
        if _others_may_write(status) and not status.st_mode & stat.S_ISVTX
        else ""
    )


def _open_to_others(part: Path, status: os.stat_result) -> str:
    return f"others can write to {part} (mode {stat.S_IMODE(status.st_mode):04o})"


def _others_may_write(status: os.stat_result) -> bool:
    return bool(status.st_mode & stat.S_IWOTH) or (
        bool(status.st_mode & stat.S_IWGRP) and not _is_own_group(status.st_gid)
    )


def _is_own_group(gid: int) -> bool:
    """Return whether a group has the user's name and no other member; many systems create such a group for
    each user."""
    import grp
    import pwd

    try:
        group, name = grp.getgrgid(gid), pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return False
    return group.gr_name == name and set(group.gr_mem) <= {name}


class Folder:
    """The folder of the cache, created and checked when first needed.

    If it is unsafe or full, kernels are compiled in every process.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._usable, self._full = path, None if os.name == "posix" else True, False
        self.shared = False  # whether two processes share the compilation: one compiles and the other waits
        self.compiled = 0  # kernels that this process has compiled

    def usable(self) -> bool:
        """Return whether files in the folder can be read."""
        if self._usable is None:
            try:
                self._make()
                why = why_not_private(self.path)
            except OSError as error:
                why = f"{error.filename or self.path}: {error.strerror or error}"
            self._usable = not why
            if why:
                self._complain(why)
        return self._usable

    def writable(self) -> bool:
        """Return whether files can be written to the folder."""
        return self.usable() and not self._full

    def stop_writing(self, error: OSError) -> None:
        """Stop writing to the folder in this process, and warn."""
        self._full = True
        self._complain(f"{self.path}: {error.strerror or error}")

    def _complain(self, why: str) -> None:
        text = (
            f"compiled kernels are not cached, so they are compiled at every start: {why}. "
            "Set ECS_ECO_CACHE to use another folder."
        )
        warnings.warn(text, RuntimeWarning, stacklevel=3)

    def _make(self) -> None:
        for part in (*reversed(self.path.parents), self.path):
            if not os.path.lexists(part):
                with suppress(FileExistsError):
                    os.mkdir(part, 0o700)
        status = os.lstat(self.path)
        if stat.S_ISDIR(status.st_mode) and status.st_uid == os.geteuid() and not _others_may_write(status):
            os.chmod(self.path, 0o700)  # earlier versions left it readable by other users
