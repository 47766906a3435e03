"""Where compiled kernels are kept: one file each, sealed, in a folder that nobody else may write to.

The files are pickles with machine code in them: who can write one, runs code here. And numba believes what it
reads, so a damaged file would end the process. Hence a cache of our own in the place of numba's: a file is
used where its owner and its checksum are right, and whatever goes wrong means that the kernel is compiled.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numba
from numba.core import config, serialize
from numba.core.caching import NullCache

from ecs_eco.compiled import portable
from ecs_eco.compiled.machine_code import from_bytes, to_bytes

if TYPE_CHECKING:
    from numba import types
    from numba.core.codegen import JITCPUCodegen
    from numba.core.compiler import CompileResult
    from numba.core.cpu import CPUContext
    from numba.core.typing import Signature

    Types: TypeAlias = str | tuple[types.Type, ...] | Signature

SEAL = 32  # [bytes] of SHA-256, at the head of a file
CLAIM, PATIENCE = ".claim", 120.0  # of a process that compiles; how long another waits for it [s]
_SWITCHES = (
    "BOUNDSCHECK",
    "OPT",
    "LOOP_VECTORIZE",
    "SLP_VECTORIZE",
    "DEBUGINFO_DEFAULT",
    "DISABLE_INTEL_SVML",
    "FULL_TRACEBACKS",
)
_FORMAT = ("compiled.py", "elf.py", "inner.py", "views.py")  # what files of the cache look like
_PACKAGE = Path(__file__).parent.parent


def _sources_hash() -> str:
    """Return a hash of all sources with kernels: numba does not notice a change in a function
    that lives in another file."""
    digest = hashlib.sha256(
        f"{numba.__version__} {[getattr(config, name, None) for name in _SWITCHES]}"
        f"{portable.CPU if portable.on() else ''}".encode()
    )
    for path in sorted(_PACKAGE.rglob("*.py")):
        source = path.read_bytes()
        if b"njit" in source or b"CFunc" in source or path.name in _FORMAT:
            digest.update(path.name.encode() + source)
    return digest.hexdigest()[:12]


@cache
def cache_folder() -> Path:
    """The folder that compiled kernels are kept in; `ECS_ECO_CACHE` overrides its parent."""
    parent = os.environ.get("ECS_ECO_CACHE") or os.environ.get("NUMBA_CACHE_DIR")
    if not parent:
        parent = os.path.join(
            os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache"), "ecs-eco"
        )
    return Path(parent).absolute() / f"kernels-{'portable-' * portable.on()}{_sources_hash()}"


def why_not_private(folder: Path) -> str:
    """Return why another user could put files into a folder, or replace it; "" if nobody can."""
    for part in reversed(folder.parents):
        if why := _why_not_safe(part):
            return why
    status, me = os.lstat(folder), os.geteuid()
    if not stat.S_ISDIR(status.st_mode):
        return f"{folder} is {'a link' if stat.S_ISLNK(status.st_mode) else 'no folder'}"
    if status.st_uid != me:
        return f"{folder} belongs to user {status.st_uid}, not to {me}"
    return _open_to_others(folder, status) if _others_may_write(status) else ""


def _why_not_safe(part: Path) -> str:
    """Return why another user could replace entries of a folder; in a sticky one, as /tmp,
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
    return f"others may write to {part} (mode {stat.S_IMODE(status.st_mode):04o})"


def _others_may_write(status: os.stat_result) -> bool:
    return bool(status.st_mode & stat.S_IWOTH) or (
        bool(status.st_mode & stat.S_IWGRP) and not _is_own_group(status.st_gid)
    )


def _is_own_group(gid: int) -> bool:
    """Whether a group holds this user alone, and has the same name: many systems make one for each user."""
    import grp
    import pwd

    try:
        group, name = grp.getgrgid(gid), pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return False
    return group.gr_name == name and set(group.gr_mem) <= {name}


class Folder:
    """The folder of the cache: made and checked on first use.

    If it is refused or full, kernels are compiled each time.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._usable, self._full = path, None if os.name == "posix" else True, False
        self.shared = False  # whether another process compiles for it now: what one does, the other leaves
        self.compiled = 0  # kernels that this process has compiled

    def usable(self) -> bool:
        """Return whether files may be read from it."""
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
        """Return whether files may be written to it."""
        return self.usable() and not self._full

    def stop_writing(self, error: OSError) -> None:
        """Write to it no more in this process, and say so."""
        self._full = True
        self._complain(f"{self.path}: {error.strerror or error}")

    def _complain(self, why: str) -> None:
        text = (
            f"compiled kernels are not kept, so every start compiles them: {why}. "
            "ECS_ECO_CACHE names another folder for them."
        )
        warnings.warn(text, RuntimeWarning, stacklevel=3)

    def _make(self) -> None:
        for part in (*reversed(self.path.parents), self.path):
            if not os.path.lexists(part):
                with suppress(FileExistsError):
                    os.mkdir(part, 0o700)
        status = os.lstat(self.path)
        if stat.S_ISDIR(status.st_mode) and status.st_uid == os.geteuid() and not _others_may_write(status):
            os.chmod(self.path, 0o700)  # earlier versions left it readable to others


class KernelCache(NullCache):
    """The compiled forms of one function, each in a file named after its types, the processor and its source."""

    def __init__(self, function: Callable[..., Any], folder: Folder, options: str = "") -> None:
        self.folder, self.options, code = folder, options, function.__code__
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        self._name = f"{function.__module__.rpartition('.')[2]}.{function.__qualname__}".replace(
            "<", ""
        ).replace(">", "")[:100]
        where = os.stat(code.co_filename)
        source = _content(code.co_filename, where.st_mtime_ns, where.st_size)
        self._source = hashlib.sha256(
            source + code.co_code + repr((code.co_firstlineno, code.co_filename, options)).encode()
        )
        if cells:
            self._source.update(serialize.dumps(cells))

    @property
    def cache_path(self) -> str:
        """The folder."""
        return str(self.folder.path)

    def load_overload(self, sig: Types, target_context: CPUContext) -> CompileResult | None:
        """Return the compiled form for a signature; None if it is missing, damaged, or its module is not there."""
        if not self.folder.usable():
            return None
        path = self._path(sig, target_context.codegen())
        try:
            content = _read(path)
        except OSError:
            return None
        seal, content = content[:SEAL], content[SEAL:]
        if hashlib.sha256(path.name.encode() + content).digest() != seal:
            return None
        try:
            return from_bytes(content, target_context)
        except ModuleNotFoundError:
            return None

    def save_overload(self, sig: Types, data: CompileResult) -> None:
        """Keep a compiled form; what cannot be kept is compiled again next time.

        That is one with constants in its machine code, or of a module that no other process can import, as
        that of a script which runpy.run_path has run.
        """
        self.folder.compiled += 1
        result: Any = data  # a named tuple, whose fields type checkers do not see
        if (
            not self.folder.writable()
            or result.library.has_dynamic_globals
            or result.fndesc.modname not in sys.modules
            or any(not lifted.can_cache for lifted in result.lifted)
        ):
            return
        path = self._path(sig, result.codegen)
        content = to_bytes(data)
        try:
            _write(path, hashlib.sha256(path.name.encode() + content).digest() + content)
        except OSError as error:
            self.folder.stop_writing(error)

    def known(self, sig: Types, target_context: CPUContext) -> bool:
        """Return whether a compiled form is there, or another process makes it."""
        path = self._path(sig, target_context.codegen())
        return path.exists() or path.with_suffix(CLAIM).exists()

    @contextmanager
    def claimed(self, sig: Types, target_context: CPUContext) -> Iterator[None]:
        """Within, no other process that shares the folder compiles this; begins when none does."""
        claim = self._path(sig, target_context.codegen()).with_suffix(CLAIM)
        own = _take(claim)
        began = time.monotonic()
        while not own and claim.exists() and time.monotonic() - began < PATIENCE:
            time.sleep(0.01)
        try:
            yield
        finally:
            if own:
                claim.unlink(missing_ok=True)

    def _path(self, sig: Types, codegen: JITCPUCodegen) -> Path:
        key = self._source.copy()
        key.update(repr((str(sig), codegen.magic_tuple())).encode())
        return self.folder.path / f"{self._name}-{key.hexdigest()[:24]}.nbc"


def _take(claim: Path) -> bool:
    """Make a file that says who compiles; False where a living process has made it."""
    try:
        with suppress(FileNotFoundError, ValueError):
            os.kill(int(claim.read_text() or os.getpid()), 0)
    except ProcessLookupError:
        claim.unlink(missing_ok=True)
    except OSError:
        return False
    try:
        with open(os.open(claim, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(str(os.getpid()))
    except OSError:
        return False
    return True


@cache
def _content(path: str, _mtime: int, _size: int) -> bytes:
    """Return the hash of a source file, which may change while a process runs."""
    return hashlib.sha256(Path(path).read_bytes()).digest()


def _read(path: Path) -> bytes:
    """Return the content of a plain file of our own; OSError where it is something else."""
    with open(
        os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)), "rb"
    ) as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode) or (os.name == "posix" and status.st_uid != os.geteuid()):
            raise PermissionError(f"{path} is not ours")
        return file.read()


def _write(path: Path, content: bytes) -> None:
    """Write a file completely or not at all; after a power failure its seal shows damage."""
    handle, name = tempfile.mkstemp(prefix=f"{path.name}.", suffix=".tmp", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(name, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(name)
        raise
