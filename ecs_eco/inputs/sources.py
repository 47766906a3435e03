"""The source code that worlds name, read and hashed; none of it runs here."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from ecs_eco.engine.errors import listed
from ecs_eco.engine.files import read_bytes
from ecs_eco.inputs import trust
from ecs_eco.inputs.session import with_what_it_reads

LARGEST_FILE = 10_000_000  # bytes


@dataclass(frozen=True)
class Source:
    """A file or module that a world lists, or "__main__:name" from an interactive session, with its text;
    `text` is None if there is no file."""

    entry: str
    path: str
    text: bytes | None = field(default=None, repr=False)

    @property
    def is_file(self) -> bool:
        """Whether the source is a file next to the world rather than an installed module."""
        return self.entry.endswith(".py")

    @property
    def module(self) -> str:
        """The part before the colon in the names of the source's functions and classes."""
        return self.entry.removesuffix(".py") if self.is_file else self.entry.partition(":")[0]

    @property
    def of_session(self) -> bool:
        """Whether the source is a function or class defined in an interactive session."""
        return ":" in self.entry

    @property
    def allowed(self) -> bool:
        """Whether the source is allowed to run; definitions in an interactive session always are."""
        return self.of_session or trust.allowed(self.sha256)

    @cached_property
    def sha256(self) -> str:
        """The hash of the source's text or, for a module without a file, of its name."""
        return hashlib.sha256(f"module {self.entry}".encode() if self.text is None else self.text).hexdigest()

    def __str__(self) -> str:
        return f"{self.entry} ({self.path or 'no file'}, SHA-256 {self.sha256})"


def of_file(entry: str, places: Sequence[Path], wanted: str | None) -> tuple[Source | None, str]:
    """Return a file's source from the first of `places` that contains it, preferably with the hash `wanted`;
    on failure, return None and the problem."""
    first = None
    for path in (place / entry for place in places if (place / entry).is_file()):
        try:
            source = Source(entry, str(path.absolute()), read_bytes(path, LARGEST_FILE))
        except OSError as error:
            return None, f"cannot be read: {error.strerror or error}"
        if wanted in (None, source.sha256):
            return source, ""
        first = first or source
    return first, "" if first else f"no such file in {listed(str(place) for place in places)}"


def of_session(entry: str) -> tuple[Source | None, str]:
    """Return the source of "__main__:name", or None and the problem."""
    text = with_what_it_reads(entry.partition(":")[2])
    if text is None:
        return (
            None,
            "it was defined in an interactive session, such as a notebook, and is not defined in this one",
        )
    return Source(entry, "", text.encode()), ""


def of_module(entry: str) -> tuple[Source | None, str]:
    """Return the source of an installed module, without importing it, or None and the problem."""
    if entry.partition(".")[0] in sys.stdlib_module_names and entry != "__main__":
        return None, "is part of Python's standard library; write a function in your own file"
    path, text = "", None
    if entry in sys.modules:
        path = getattr(sys.modules[entry], "__file__", None) or ""
    elif (origin := _origin(entry)) is None:
        return None, "no such installed module"
    else:
        path = origin
    if path:
        try:
            text = Path(path).read_bytes()
        except OSError as error:
            return None, f"cannot be read: {error.strerror or error}"
    return Source(entry, path, text), ""


def _origin(module: str) -> str | None:
    """Return the file of an installed module, found without importing the packages that contain it."""
    inside, origin = None, None
    parts = module.split(".")
    for n in range(1, len(parts) + 1):
        name, spec = ".".join(parts[:n]), None
        for finder in sys.meta_path:
            if (spec := finder.find_spec(name, inside)) is not None:
                break
        if spec is None or (spec.submodule_search_locations is None and n < len(parts)):
            return None
        inside, origin = spec.submodule_search_locations, spec.origin
    return origin or ""
