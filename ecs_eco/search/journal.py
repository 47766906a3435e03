"""What a search has found so far: a line of JSON for each evaluation, written when it is done. A half line at the end is no line."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ecs_eco.engine.errors import ConfigError, Problem, RecordingError

NAME = "journal.jsonl"
Entry = dict[str, Any]


class Journal:
    """The journal in a folder: what stands in it, and more at its end."""

    def __init__(self, folder: Path, header: Entry) -> None:
        self.path = folder / NAME
        self.entries: list[Entry] = []
        if self.path.is_file():
            lines = read(self.path)
            if lines:
                _same(lines[0], header, self.path)
                self.entries = lines[1:]
        if not self.entries:
            folder.mkdir(parents=True, exist_ok=True)
            self.path.write_text("", encoding="utf-8")
            self._append({"kind": "search", **header})

    def of(self, kind: str) -> list[Entry]:
        """The entries of a kind: candidate, final or confirmation."""
        return [e for e in self.entries if e["kind"] == kind]

    def add(self, kind: str, **what: Any) -> Entry:
        """Keep an evaluation, on the disk too; RecordingError where nothing more can be written."""
        entry = {"kind": kind, **what}
        self._append(entry)
        self.entries.append(entry)
        return entry

    def _append(self, entry: Entry) -> None:
        line = json.dumps(entry, ensure_ascii=False, allow_nan=False) + "\n"
        try:
            with open(self.path, "a", encoding="utf-8") as file:
                file.write(line)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            kept = f"{len(self.entries)} evaluations are kept: make room, then the same command with --out {self.path.parent} goes on"
            raise RecordingError(f"{self.path}: nothing more can be written: {error.strerror or error}; {kept}") from error


def read(path: Path) -> list[Entry]:
    """All whole lines; what follows the last of them, cut off when a search was killed, is removed."""
    data = path.read_bytes()
    whole = data.rfind(b"\n") + 1
    if whole < len(data):
        with open(path, "r+b") as file:
            file.truncate(whole)
    try:
        return [json.loads(line) for line in data[:whole].decode("utf-8").splitlines()]
    except ValueError as error:
        raise ConfigError([Problem((), f"is damaged: {error}", allowed="a journal that a search wrote", source=str(path))]) from None


def _same(old: Entry, new: Entry, path: Path) -> None:
    """Refuse to go on with a search of something else."""
    a, b = ({**e, **{f"search.{k}": v for k, v in e.get("search", {}).items()}} for e in (old, new))
    differ = [k for k in b if k != "search" and a.get(k) != b[k]]
    if differ:
        told = "; ".join(f"{k}: {a.get(k)} then, {b[k]} now" for k in differ)
        allowed = "the same world and settings, or another --out"
        raise ConfigError([Problem((), f"is another search ({told})", str(path.parent), allowed, source="--out")])
