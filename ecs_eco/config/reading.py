"""Reads what strangers wrote: regular files of bounded size, TOML of bounded depth. Whatever else there is, is said in words."""

from __future__ import annotations

import os
import re
import stat
import tomllib
from pathlib import Path
from typing import Any

from ecs_eco.engine.errors import ConfigError, Problem

MOST_BYTES = 500_000  # of a world file: tomllib takes seconds for more; the longest that is shipped has 20,000
DEEPEST = 32  # tables and lists within each other; the shipped worlds have 7
LONG_KEY = re.compile(r"""(?:^|[{,\[])[ \t]*(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){32}""", re.MULTILINE)
NESTED = re.compile(r"(?:[\[{][^\[\]{}\n]{0,80}){32}")
DIGITS = re.compile(r"\d[\d_]{4000}")


def read_bytes(path: Path, most: int) -> bytes:
    """The content of a regular file; OSError where it is a folder, a device or a pipe, or longer than `most` bytes."""
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)  # opening a pipe must not wait
    handle = os.open(path, flags)
    try:
        check_regular(os.fstat(handle), most)
    except OSError:
        os.close(handle)
        raise
    with open(handle, "rb") as file:
        content = file.read(most + 1)
    if len(content) > most:  # what says of itself that it has 0 bytes, as in /proc
        raise OSError(f"is longer than {most:,} bytes")
    return content


def check_regular(found: os.stat_result, most: int) -> None:
    """OSError for what is no regular file, or is longer than `most` bytes."""
    if not stat.S_ISREG(found.st_mode):
        raise OSError("is a folder" if stat.S_ISDIR(found.st_mode) else "is no regular file")
    if found.st_size > most:
        raise OSError(f"is longer than {most:,} bytes")


def read_toml(path: Path) -> tuple[str, dict[str, Any]]:
    """Text and content of a TOML file; ConfigError that says where it is wrong."""
    allowed = "a TOML file in UTF-8"
    try:
        text = read_bytes(path, MOST_BYTES).decode("utf-8-sig")  # some editors begin a file with a mark
    except (OSError, ValueError) as error:  # ValueError: no UTF-8, or a name that no file can have
        why = getattr(error, "strerror", None) or error
        raise ConfigError([Problem((), f"cannot be read: {why}", str(path), allowed, source="WORLD")]) from None
    text = text.replace("\r\n", "\n")
    try:
        return text, parse_toml(text)
    except ValueError as error:
        raise _syntax(path, text, str(error)) from None


def parse_toml(text: str) -> dict[str, Any]:
    """The content of a TOML text; ValueError where it is none, or has numbers or tables that Python cannot read."""
    if found := LONG_KEY.search(text):  # tomllib takes a time that grows with the square of their parts
        raise _at(text, found, f"a dotted key of more than {DEEPEST} parts")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise _at(text, NESTED.search(text), "tables or lists are nested too deeply") from None
    except ValueError:  # of int(): more than some thousand digits
        raise _at(text, DIGITS.search(text), "a whole number has too many digits") from None


def too_deep(data: Any) -> Problem | None:
    """The problem of the first table or list that lies deeper than DEEPEST within others, if any."""
    level: list[tuple[tuple[str | int, ...], Any]] = [((), data)]
    for _ in range(DEEPEST):
        inner: list[tuple[tuple[str | int, ...], Any]] = []
        for key, node in level:
            parts = node.items() if isinstance(node, dict) else enumerate(node)
            inner += [((*key, name), part) for name, part in parts if isinstance(part, dict | list)]
        level = inner
    if not level:
        return None
    return Problem(level[0][0][:3], "is nested too deeply", allowed=f"at most {DEEPEST} tables or lists within each other")


def _at(text: str, found: re.Match[str] | None, what: str) -> ValueError:
    """The error at a place of the text, in the words of tomllib."""
    if found is None:
        return ValueError(f"{what} (at end of document)")
    before = text[: found.start()]
    return ValueError(f"{what} (at line {before.count(chr(10)) + 1}, column {found.start() - before.rfind(chr(10))})")


def _syntax(path: Path, text: str, said: str) -> ConfigError:
    found = re.search(r"^(.*) \(at line (\d+), column (\d+)\)$", said, re.DOTALL)
    lines = text.rstrip("\n").split("\n")  # where the error is at the end of the document
    what, line, column = (found[1], int(found[2]), int(found[3])) if found else (said, len(lines), len(lines[-1]) + 1)
    problem = Problem((), f"not TOML: {what:.200}", allowed="TOML 1.0", source=path.name, line=line, column=column)
    return ConfigError([problem], f"{path.name}: 1 problem")
