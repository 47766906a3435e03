"""Bounded reading of files that may be untrusted, and atomic writing: a temporary file in the same folder is
written, synced and renamed, then the folder is synced."""

from __future__ import annotations

import errno
import json
import os
import re
import secrets
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ecs_eco.engine.errors import RecordingError

if TYPE_CHECKING:
    import numpy as np

MOST_BYTES = 2_000_000_000  # maximum per file, unless its reader sets another
_BESIDE = re.compile(r"\.(?P<name>.+)\.ecs-eco-\d+-[0-9a-f]{8}\.tmp")


def write(path: str | Path, content: bytes | str) -> Path:
    """Atomically write a file (text as UTF-8); return its path. Raises an OSError that names the file."""
    with writing(path) as beside, open(beside, "wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)
    return Path(path)


@contextmanager
def writing(path: str | Path) -> Iterator[Path]:
    """Yield the name of an empty file in the same folder, which replaces `path` at the end or is removed
    after an exception.

    The file's mode follows the user's umask. Raises an OSError that names `path`.
    """
    path = Path(path)
    beside = path.with_name(f".{path.name}.ecs-eco-{os.getpid()}-{secrets.token_hex(4)}.tmp")
    try:
        handle = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        mode = os.fstat(handle).st_mode & 0o777
        os.close(handle)
        try:
            yield beside
            _sync(beside, mode)
            os.replace(beside, path)
        except BaseException:
            with suppress(OSError):
                beside.unlink(missing_ok=True)
            raise
        sync_folder(path.parent)
    except OSError as error:
        # keep an error that concerns another file
        if error.errno is None or error.filename not in (None, str(beside)):
            raise
        raise OSError(error.errno, error.strerror or os.strerror(error.errno), str(path)) from error


def write_tensors(
    path: str | Path, arrays: Mapping[str, np.ndarray], metadata: Mapping[str, str] | None = None
) -> Path:
    """Atomically write numpy arrays as a safetensors file; identical arrays give identical bytes.

    The safetensors library would use a temporary file with an unknown name, which remains if the process is
    killed, and would store texts in random order. Raises an OSError that names the file.
    """
    import numpy as np

    head: dict[str, Any] = {"__metadata__": dict(sorted(metadata.items()))} if metadata else {}
    end, parts = 0, []
    for name in sorted(arrays, key=lambda name: (-arrays[name].itemsize, name)):  # keeps all arrays aligned
        array = arrays[name]
        kind = "BOOL" if array.dtype.kind == "b" else f"{array.dtype.kind.upper()}{8 * array.itemsize}"
        parts.append(np.ascontiguousarray(array, array.dtype.newbyteorder("<")))
        head[name] = {"dtype": kind, "shape": array.shape, "data_offsets": [end, end := end + array.nbytes]}
    text = json.dumps(head, ensure_ascii=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    with writing(path) as beside, open(beside, "wb") as file:
        file.write(len(text).to_bytes(8, "little") + text)
        for part in parts:
            file.write(part.reshape(-1).view(np.uint8).data)
    return Path(path)


def read_bytes(path: str | Path, most: int = MOST_BYTES) -> bytes:
    """Return the contents of a regular file with at most `most` bytes; otherwise raise an OSError."""
    require_regular(path)
    # a pipe that replaced the file must not block, and files in /proc claim to have 0 bytes
    with open(path, "rb", opener=lambda name, how: os.open(name, how | getattr(os, "O_NONBLOCK", 0))) as file:
        content = file.read(min(os.fstat(file.fileno()).st_size or most, most) + 1)
    if len(content) > most:
        raise OSError(errno.EFBIG, f"is longer than {most:,} bytes", str(path))
    return content


def read_json(path: str | Path) -> Any:
    """Return the contents of a JSON file; raise RecordingError if it is missing or damaged."""
    try:
        return json.loads(read_bytes(path))
    except (OSError, ValueError, RecursionError) as error:
        raise RecordingError(f"{path}: is damaged: {getattr(error, 'strerror', None) or error}") from None


def read_note(path: Path) -> dict[str, Any]:
    """Return the contents of a JSON file, or {} if it is missing or damaged."""
    with suppress(RecordingError):
        if isinstance(note := read_json(path), dict):
            return note
    return {}


def require_regular(path: str | Path) -> None:
    """Raise OSError unless a path is a regular file: not a folder, a device, or a pipe, which would block."""
    mode = os.stat(path).st_mode
    if not stat.S_ISREG(mode):
        raise OSError(
            errno.EINVAL, "is a folder" if stat.S_ISDIR(mode) else "is not a regular file", str(path)
        )


def written_beside(path: Path) -> str | None:
    """Return the intended name of a half-written file; None for any other file."""
    match = _BESIDE.fullmatch(path.name)
    return None if match is None else match["name"]


def sync_folder(folder: Path) -> None:
    """Sync a folder's entries to disk, if the system supports this."""
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _sync(beside: Path, mode: int) -> None:
    handle = os.open(beside, os.O_RDWR)
    try:
        if os.name == "posix" and os.fstat(handle).st_mode & 0o777 != mode:
            os.fchmod(handle, mode)
        os.fsync(handle)
    finally:
        os.close(handle)


def write_json(path: Path, content: object) -> None:
    """Atomically write a JSON file."""
    write(path, json.dumps(content, indent=1, allow_nan=False))
