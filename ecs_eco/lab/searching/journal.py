"""The journal of a search: a line of JSON for each evaluation. Each ends with a seal, a SHA-256 hash of the line
and the previous seal, which reveals changed, removed or inserted lines."""

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from ecs_eco.engine import files
from ecs_eco.engine.errors import ConfigError, ForeignFile, RecordingError, refusal
from ecs_eco.inputs.section import Section
from ecs_eco.record import container, seal
from ecs_eco.record.manifest import Sha, Tick

NAME = "journal.jsonl"
WORD = "seal"
Entry = dict[str, Any]


class Planned(container.Container):
    """The manifest of a search."""

    FILE: ClassVar = "plan.json"
    KIND: ClassVar = "search"
    COMMAND: ClassVar = "search"
    OTHER: ClassVar = "is another search"
    DECIDES: ClassVar = ("world", "config_hash", "search", "data", "optimiser")

    world: str
    config_hash: Sha
    search: dict[str, Any]
    data: Sha | None = None
    optimiser: str

    @classmethod
    def settings(cls, content: Mapping[str, Any]) -> dict[str, Any]:
        """Return the settings of a search, with an entry for each key of the world's [search]."""
        own = {f"search.{key}": value for key, value in content["search"].items()}
        return {key: value for key, value in super().settings(content).items() if key != "search"} | own


class OneRun(Section):
    """One run of a candidate."""

    training: int
    world: int
    lived: Tick
    extinct: str | None
    score: float
    goal: float | None
    seconds: float
    statistics: dict[str, float] | None = None


class Stage(Section):
    """A candidate's result at one stage."""

    ticks: Tick
    score: float
    lost: int
    runs: list[OneRun]


class Evaluation(Section):
    """The parts of a journal entry that are read back."""

    model_config = ConfigDict(extra="allow", strict=True, allow_inf_nan=False)

    kind: Literal["candidate", "final", "confirmation"]
    candidate: Annotated[int, Field(ge=0)]
    values: dict[str, float] | None = None
    cell: Annotated[list[int], Field(min_length=2, max_length=2)] | None = None
    stage: Annotated[int, Field(ge=0)]
    score: float
    stages: list[Stage]
    seconds: float
    cpu: float
    at: float
    failed: str = ""
    refused: str = ""

    @model_validator(mode="after")
    def _says_what_ran(self) -> Self:
        if {"candidate": self.values, "confirmation": self.cell}.get(self.kind, ()) is None:
            raise ValueError(f"values or cell: is missing from this {self.kind}")
        return self


def has_search(folder: Path) -> bool:
    """Return whether a folder contains a search."""
    return (folder / NAME).is_file() or container.has(folder, Planned)


class Journal:
    """The journal in a folder."""

    def __init__(self, folder: Path, header: Entry) -> None:
        self.path = folder / NAME
        self.entries: list[Entry] = []
        self._seal = ""  # seal of the last line
        lines = read(self.path) if self.path.exists() else []
        if lines:
            if different := [key for key, value in header.items() if lines[0].get(key) != value]:
                raise ForeignFile(
                    f"{self.path}: belongs to another search: its {', '.join(different)} differs from the "
                    "folder's"
                )
            self.entries, self._seal = lines[1:], lines[-1][WORD]
        else:
            folder.mkdir(parents=True, exist_ok=True)
            self._append({"kind": "search", **header})

    def of(self, kind: str) -> list[Entry]:
        """Return the entries of one kind: candidate, final or confirmation."""
        return [e for e in self.entries if e["kind"] == kind]

    def add(self, kind: str, **fields: Any) -> Entry:
        """Append an evaluation, in memory and on disk. Raises RecordingError if writing fails."""
        entry = {"kind": kind, **fields}
        self._append(entry)
        self.entries.append(entry)
        return entry

    def _append(self, entry: Entry) -> None:
        text = json.dumps(entry, ensure_ascii=False, allow_nan=False)
        self._seal = _seal_of(text, self._seal)
        try:
            with open(self.path, "a", encoding="utf-8") as file:
                file.write(f'{text[:-1]}, "{WORD}": "{self._seal}"}}\n')
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            kept = (
                f"{len(self.entries)} evaluations are saved; free some disk space, then resume with the same "
                f"command and --out {self.path.parent}"
            )
            raise RecordingError(
                f"{self.path}: cannot be written: {error.strerror or error}; {kept}"
            ) from error


def begin(folder: Path, settings: Entry) -> Journal:
    """Return the journal of the search with these settings in a folder, creating it if necessary. Raises
    ForeignFile if the folder contains another search, RecordingError if it is from an older version."""
    if container.inside(folder, folder / NAME).is_file() and not container.has(folder, Planned):
        raise RecordingError(f"{folder / NAME}: {container.OLD}")
    container.inside(folder, folder / "policies")
    plan = container.begin(folder, Planned, settings)
    journal = Journal(folder, {"plan": plan["hash"]})
    for number, entry in enumerate(journal.entries, 2):
        seal.validate(Path(f"{journal.path}, line {number}"), entry, Evaluation)
    return journal


def read(path: Path) -> list[Entry]:
    """Read all complete lines, and remove an incomplete last line, left by a killed search. Raises a
    ConfigError that names the first changed line."""
    data = files.read_bytes(path)
    whole = data.rfind(b"\n") + 1
    if whole < len(data):
        with open(path, "r+b") as file:
            file.truncate(whole)
    entries: list[Entry] = []
    for number, line in enumerate(data[:whole].split(b"\n")[:-1], 1):
        try:
            entry = json.loads(line.decode("utf-8"))
            own = entry[WORD]
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise _damaged(path, number, f"{type(error).__name__}: {error}") from None
        body = json.dumps({key: value for key, value in entry.items() if key != WORD}, ensure_ascii=False)
        if own != _seal_of(body, entries[-1][WORD] if entries else ""):
            raise _damaged(
                path,
                number,
                "its seal does not match: it was changed, or lines before it were removed or inserted",
            )
        entries.append(entry)
    return entries


def _damaged(path: Path, number: int, fault: str) -> ConfigError:
    allowed = "a journal written by this version, or another --out"
    return refusal((), f"is damaged: {fault}", allowed=allowed, source=str(path), line=number)


def _seal_of(text: str, before: str) -> str:
    return hashlib.sha256(f"{before}\n{text}".encode()).hexdigest()
