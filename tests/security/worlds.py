"""Worlds of tests, written to a file."""

from pathlib import Path
from typing import Any

from ecs_eco.config.edit import as_toml


def written(folder: Path, data: dict[str, Any]) -> Path:
    path = folder / "world.toml"
    path.write_text(as_toml(data), encoding="utf-8")
    return path
