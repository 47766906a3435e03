"""Errors whose messages give the location, the value, the expected values and the nearest valid name."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from itertools import islice
from pathlib import Path

MISSING = type("Missing", (), {"__repr__": lambda self: "missing", "__bool__": lambda self: False})()
SHOWN = 15  # number of problems shown at once
MOST = 200  # maximum number of problems collected; after you fix these, the next ones appear
LONGEST = 200  # maximum length of a name that is compared with other names
# minimum similarity of a suggested name (difflib) for short and for longer words
ALIKE, CLOSE = 0.66, 0.8


def nearest(name: object, known: Iterable[str], cutoff: float = ALIKE) -> str:
    """Return the known name most similar to `name`, or ""; compares up to 1,000 names and skips long ones."""
    text = str(name) if isinstance(name, str | Path) else _written(name)
    if len(text) > LONGEST:
        return ""
    lower = {k.lower(): k for k in islice(known, 1000)}
    matches = get_close_matches(text.lower(), lower, n=1, cutoff=cutoff)
    return lower[matches[0]] if matches else ""


def listed(names: Iterable[str], most: int = 12) -> str:
    """Return names separated by commas, at most `most` of them."""
    names = [shortened(str(n)) for n in names]
    return ", ".join(names[:most]) + (f", … ({len(names)} in all)" if len(names) > most else "") or "none"


def in_words(names: Iterable[str]) -> str:
    """Return names as "a, b and c", for sentences."""
    *first, last = [*names] or [""]
    return f"{', '.join(first)} and {last}" if first else last


def how_many(n: int) -> str:
    """ "3 problems", or "more than 200 problems"."""
    return f"more than {MOST} problems" if n > MOST else f"{n} problem{'s' * (n != 1)}"


@dataclass(frozen=True)
class Problem:
    """One problem in a configuration."""

    key: tuple[str | int, ...]  # location, for example ("species", "deer", "sensors", 1, "target")
    what: str  # what is wrong
    value: object = MISSING  # the value in the file
    allowed: str = ""  # what is expected
    nearest: str = ""  # the valid name most similar to the value
    source: str = ""  # file, "--set", or a word such as "dict"
    line: int | None = None  # in the file, counted from 1
    column: int | None = None  # in the file, counted from 1
    written: str = ""  # the value as written in the file

    def moved(self, **changes: object) -> Problem:
        """Return the same problem with some fields changed."""
        return replace(self, **changes)  # type: ignore[arg-type]

    @property
    def path(self) -> str:
        """Return the key with dots, as in `--set`."""
        return ".".join(f'"{k}"' if isinstance(k, str) and "." in k else str(k) for k in self.key)

    def __str__(self) -> str:
        place = self.source
        if self.line is not None:
            place += f", line {self.line}" + (f", column {self.column}" if self.column is not None else "")
        head = ": ".join(part for part in (place, shortened(self.path, 200)) if part)
        if self.value is not MISSING:
            head += (" = " if self.path else ": ") + (shortened(self.written, 90) or _short(self.value))
        tail = f"  {shortened(self.what, 500)}"
        if self.allowed:
            tail += f"; expected: {self.allowed}"
        if self.nearest:
            tail += f'; did you mean "{self.nearest}"?'
        return f"{head}\n{tail}" if head else tail.strip()


def unknown(key: tuple[str | int, ...], kind: str, value: str, known: Iterable[str]) -> Problem:
    """Return the problem for an unknown name."""
    known = list(known)
    return Problem(key, f"no {kind} with this name", value, listed(known, 30), nearest(value, known))


class ConfigError(ValueError):
    """An invalid configuration; the error contains every problem found."""

    def __init__(self, problems: Iterable[Problem], title: str = "") -> None:
        self.problems = list(islice(problems, MOST + 1))
        self.title = title
        super().__init__(self.render())

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.problems, self.title)

    def render(self, most: int = SHOWN) -> str:
        """Return the problems as text.

        Parameters
        ----------
        most : int
            Number of problems to list; any further problems are only counted.

        Returns
        -------
        str
        """
        n = len(self.problems)
        shown = [str(p) for p in self.problems[:most]]
        rest = [f"… and {'more than ' * (n > MOST)}{min(n, MOST) - most} more"] if n > most else []
        return "\n".join([self.title or how_many(n), *shown, *rest])


def refusal(
    key: tuple[str | int, ...],
    what: str,
    value: object = MISSING,
    allowed: str = "",
    near: str = "",
    source: str = "",
    line: int | None = None,
) -> ConfigError:
    """Return the error for a single problem."""
    return ConfigError([Problem(key, what, value, allowed, near, source, line)])


def shortened(text: str, width: int = 60) -> str:
    """Return the text, truncated to `width` characters."""
    return text if len(text) <= width else text[: width - 1] + "…"


def _short(value: object, width: int = 90) -> str:
    """Return a value in TOML notation, cut to `width` characters: paths at the beginning, other values at the
    end."""
    if (
        isinstance(value, str)
        and len(value) > width
        and value.startswith(("/", "~", "./", "../"))
        and value.isprintable()
    ):
        return f'"…{value[-width:]}"'
    if isinstance(value, str):
        text = '"' + value[:width].replace("\n", "\\n") + ('"' if len(value) <= width else "")
    else:
        text = _written(value)
    return shortened(text, width)


def _written(value: object, levels: int = 8) -> str:
    """Return the first entries of any value in TOML notation; works even for huge numbers and endless lists."""
    if isinstance(value, int) and value.bit_length() > 1000:
        return f"{'-' if value < 0 else ''}a whole number of about {int(value.bit_length() * 0.30103) + 1} digits"
    if isinstance(value, list | tuple | dict) and not levels:
        return "…"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        parts = [f"{k} = {_written(v, levels - 1)}" for k, v in islice(value.items(), 40)]
        return "{ " + ", ".join(parts + ["…"] * (len(value) > 40)) + " }" if parts else "{}"
    if isinstance(value, list):
        return (
            "[" + ", ".join([_written(v, levels - 1) for v in value[:40]] + ["…"] * (len(value) > 40)) + "]"
        )
    if isinstance(value, str):
        return json.dumps(value[:200], ensure_ascii=False)
    return repr(value[:200] if isinstance(value, bytes) else value)


class UnknownName(KeyError):
    """An undeclared name. Unlike a KeyError's, its message is shown without quotes."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


def unknown_name(place: str, kind: str, name: object, known: Iterable[str]) -> str:
    """Return the message for an undeclared name: location, name, known names and the nearest one."""
    known = [str(k) for k in known]
    guess = nearest(name, known)
    hint = f'; did you mean "{guess}"?' if guess else ""
    return f"{place}: unknown {kind} {str(name)!r}; known: {listed(known)}{hint}"


def no_attribute(table: Mapping[type, object], name: str) -> str:
    """Return the message for an attribute that a table lacks; it names components with such a field."""
    if name.startswith("_"):
        return name
    owners = [f"table[{c.__name__}].{name}" for c in table if name in getattr(c, "fields", ())]
    known = f"its components are {listed(c.__name__ for c in table)}"
    hint = f"it is a column: {' or '.join(owners)}" if owners else known
    return f"table {getattr(table, 'name', '')!r} has no attribute {name!r}; {hint}"


class RecordingError(ValueError):
    """A run folder that cannot be read or written."""


class Halted(RecordingError):
    """A run that cannot continue: its disk is full, or its worker was killed."""


class CheckpointError(ValueError):
    """A checkpoint that cannot be read, or a world that cannot be saved or restored."""


class FolderInUse(RecordingError):
    """A folder that another process is writing to."""


class ForeignFile(RecordingError):
    """A file that does not belong to the same run as its folder."""


class UnfinishedTick(RuntimeError):
    """A world that was stopped mid-tick: you can inspect it, but not run, save, copy or record it."""
