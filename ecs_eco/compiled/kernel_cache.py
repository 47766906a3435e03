"""Compiled kernels on disk: one sealed file each, in a folder that no other user can write to.

The files are pickles with machine code, so anyone who can write one can run code here. Moreover, numba trusts
what it reads, so a damaged file would crash the process. This cache therefore replaces numba's: a file is
used only if its owner and its checksum are correct, and if anything fails, the kernel is compiled.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ecs_eco.compiled.kernel_folder import CLAIM, Folder
from ecs_eco.compiled.numba_private import NullCache, from_bytes, serialize, to_bytes

if TYPE_CHECKING:
    from numba import types

    from ecs_eco.compiled.numba_private import CompileResult, CPUContext, JITCPUCodegen, Signature

    Types: TypeAlias = str | tuple[types.Type, ...] | Signature

SEAL = 32  # [bytes] length of the SHA-256 hash at the start of a file
PATIENCE = 120.0  # [s] time to wait for another process to compile


class KernelCache(NullCache):
    """The compiled forms of one function, each in a file named after the types, the processor and the source."""

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
        """Return the compiled form for a signature, or None if it is missing or damaged, or its module does
        not exist."""
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
        """Cache a compiled form; forms that cannot be cached are compiled again next time.

        These are forms with constants in their machine code, and forms from a module that other processes
        cannot import, such as a script run by runpy.run_path.
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
        """Return whether a compiled form exists, or another process is compiling it."""
        path = self._path(sig, target_context.codegen())
        return path.exists() or path.with_suffix(CLAIM).exists()

    @contextmanager
    def claimed(self, sig: Types, target_context: CPUContext) -> Iterator[None]:
        """Within this context, hold the exclusive right to compile this function in the folder, after waiting
        until no other process holds it."""
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
    """Create a file that names the compiling process; return False if a running process already has such a
    file."""
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
    """Return the hash of a source file, which can change while a process runs."""
    return hashlib.sha256(Path(path).read_bytes()).digest()


def _read(path: Path) -> bytes:
    """Return the contents of a regular file owned by this user. Raises OSError for anything else."""
    with open(
        os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)), "rb"
    ) as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode) or (os.name == "posix" and status.st_uid != os.geteuid()):
            raise PermissionError(f"{path} is not ours")
        return file.read()


def _write(path: Path, content: bytes) -> None:
    """Atomically write a file; after a power failure, its seal reveals damage."""
    handle, name = tempfile.mkstemp(prefix=f"{path.name}.", suffix=".tmp", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(name, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(name)
        raise
