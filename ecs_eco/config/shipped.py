"""The worlds that come with the package; light, so that listing them loads no models."""

from __future__ import annotations

from pathlib import Path

WORLDS = Path(__file__).parent.parent / "worlds"


def shipped() -> dict[str, Path]:
    """The world files that come with the package, by name."""
    return {path.parent.name.replace("_", "-"): path for path in sorted(WORLDS.glob("*/*.toml"))}
