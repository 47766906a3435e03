"""The worlds that come with the package; light, so that listing them loads no models."""

from __future__ import annotations

import tomllib
from pathlib import Path

WORLDS = Path(__file__).parent.parent / "worlds"


def shipped() -> dict[str, Path]:
    """The world files that come with the package, by name."""
    return {path.parent.name.replace("_", "-"): path for path in sorted(WORLDS.glob("*/*.toml"))}


def titles() -> dict[str, str]:
    """The titles of these worlds, by name."""
    found = {}
    for name, path in shipped().items():
        try:
            found[name] = str(tomllib.loads(path.read_text(encoding="utf-8")).get("title", ""))
        except (OSError, ValueError) as error:
            found[name] = f"cannot be read: {error}"
    return found
