"""Read untrusted TOML of limited size and depth."""

import re
import tomllib
from pathlib import Path
from typing import Any

from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.engine.files import read_bytes

MOST_BYTES = (
    500_000  # maximum per world file; tomllib takes seconds for more; shipped files have up to 20,000
)
DEEPEST = 32  # maximum nesting of tables and lists; shipped worlds have up to 7 levels
LONG_KEY = re.compile(
    r"""(?:^|[{,\[])[ \t]*(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){32}""", re.MULTILINE
)
NESTED = re.compile(r"(?:[\[{][^\[\]{}\n]{0,80}){32}")
DIGITS = re.compile(r"\d[\d_]{4000}")


def read_toml(path: Path) -> tuple[str, dict[str, Any]]:
    """Return a TOML file as text and as data; raise a ConfigError that gives the line of any error."""
    allowed = "a TOML file in UTF-8"
    try:
        # some editors write a byte order mark
        text = read_bytes(path, MOST_BYTES).decode("utf-8-sig")
    except (OSError, ValueError) as error:  # ValueError: not UTF-8, or an impossible file name
        why = getattr(error, "strerror", None) or error
        raise ConfigError(
            [Problem((), f"cannot be read: {why}", str(path), allowed, source="WORLD")]
        ) from None
    text = text.replace("\r\n", "\n")
    try:
        return text, parse_toml(text)
    except ValueError as error:
        raise _syntax(path, text, str(error)) from None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the data in TOML text; raise a ValueError if Python cannot read it."""
    if match := LONG_KEY.search(text):  # tomllib's time is quadratic in the number of parts
        raise _at(text, match, f"a dotted key has more than {DEEPEST} parts")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise _at(text, NESTED.search(text), "tables or lists are nested too deeply") from None
    except ValueError:  # raised by int() for several thousand digits
        raise _at(text, DIGITS.search(text), "a whole number has too many digits") from None


def too_deep(data: object) -> Problem | None:
    """Return the problem with the first table or list nested more than DEEPEST levels deep, or None."""
    level: list[tuple[tuple[str | int, ...], Any]] = [((), data)]
    for _ in range(DEEPEST):
        level = [
            ((*key, name), part)
            for key, node in level
            for name, part in (node.items() if isinstance(node, dict) else enumerate(node))
            if isinstance(part, dict | list)
        ]
    if not level:
        return None
    return Problem(
        level[0][0][:3], "is nested too deeply", allowed=f"at most {DEEPEST} nested tables or lists"
    )


def _at(text: str, match: re.Match[str] | None, fault: str) -> ValueError:
    """Return the error at a position in the text, in tomllib's wording."""
    if match is None:
        return ValueError(f"{fault} (at end of document)")
    before = text[: match.start()]
    return ValueError(
        f"{fault} (at line {before.count(chr(10)) + 1}, column {match.start() - before.rfind(chr(10))})"
    )


def _syntax(path: Path, text: str, message: str) -> ConfigError:
    match = re.search(r"^(.*) \(at line (\d+), column (\d+)\)$", message, re.DOTALL)
    lines = text.rstrip("\n").split("\n")  # for errors at the end of the document
    fault, line, column = (
        (match[1], int(match[2]), int(match[3])) if match else (message, len(lines), len(lines[-1]) + 1)
    )
    problem = Problem(
        (), f"not TOML: {fault:.200}", allowed="TOML 1.0", source=path.name, line=line, column=column
    )
    return ConfigError([problem], f"{path.name}: 1 problem")
