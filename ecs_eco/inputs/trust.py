"""Code that the user has allowed to run: hashes of source texts, for this process or permanently."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable, Mapping
from pathlib import Path

from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.engine.files import write_json

_here: set[str] = set()  # allowed in this process


def allowed(sha256: str) -> bool:
    """Return whether a text with this hash is allowed to run."""
    return sha256 in _here or sha256 in remembered()


def allowed_here(sha256: str) -> bool:
    """Return whether a text with this hash was allowed in this process."""
    return sha256 in _here


def allow(hashes: Iterable[str]) -> None:
    """Allow texts with these hashes in this process."""
    _here.update(hashes)


def file() -> Path:
    """Return the file that lists the code that this user allowed."""
    home = os.environ.get("XDG_CONFIG_HOME") or os.path.join(os.path.expanduser("~"), ".config")
    return Path(home) / "ecs-eco" / "trusted.json"


def remembered() -> dict[str, str]:
    """Return the texts that this user has allowed permanently: their paths by hash.

    The result is empty if the file belongs to another user, or if other users can write to it.
    """
    path = file()
    try:
        for place in (path, path.parent):
            status = place.stat()
            if os.name == "posix" and (status.st_uid != os.geteuid() or status.st_mode & 0o022):
                return {}
        data = json.loads(path.read_bytes())
        return {str(sha256): str(entry["path"]) for sha256, entry in data["code"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}


def remember(texts: Mapping[str, str]) -> None:
    """Allow texts, given by hash and path, permanently. Raises ConfigError if the file cannot be written."""
    allow(texts)
    since = time.strftime("%Y-%m-%d %H:%M:%S")
    known = {sha256: {"path": path, "since": since} for sha256, path in {**remembered(), **texts}.items()}
    path = file()
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        path.parent.chmod(0o700)
        write_json(path, {"format": 1, "code": known})
        path.chmod(0o600)
    except OSError as error:
        fault = f"cannot be written: {error.strerror or error}"
        raise ConfigError(
            [Problem((), fault, str(path), "your own folder as XDG_CONFIG_HOME", source="--trust")]
        ) from None
