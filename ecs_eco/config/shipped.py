"""The worlds included in the package; listing them imports no models."""

import importlib.util
import re
import tomllib
from pathlib import Path

WORLDS = Path(__file__).parent.parent / "worlds"


def shipped() -> dict[str, Path]:
    """Return the world files included in the package, by name."""
    return {path.parent.name.replace("_", "-"): path for path in sorted(WORLDS.glob("*/*.toml"))}


def named(world: object) -> Path | None:
    """Return the file of a world by name: a shipped world, or "package:world" for an installed package whose
    folder contains world.toml; return None for any other text. The package is not imported."""
    worlds, text = shipped(), str(world)
    if (path := worlds.get(text.replace("_", "-"))) is not None:
        return path
    package, _, name = text.partition(":")
    if not (package.isidentifier() and re.fullmatch(r"[A-Za-z][\w-]*", name)):
        return None
    try:
        found = importlib.util.find_spec(package)
    except ValueError:  # a module without a location
        return None
    for folder in (found.submodule_search_locations or []) if found is not None else []:
        if (path := Path(folder) / f"{name.replace('-', '_')}.toml").is_file():
            return path
    return None


def titles() -> dict[str, str]:
    """Return the titles of the shipped worlds, by name."""
    found = {}
    for name, path in shipped().items():
        try:
            found[name] = str(tomllib.loads(path.read_text(encoding="utf-8")).get("title", ""))
        except (OSError, ValueError) as error:
            found[name] = f"cannot be read: {error}"
    return found
