"""Write a new world or package to a folder."""

from __future__ import annotations

import importlib.util
import keyword
import re
from pathlib import Path

from ecs_eco.config import load
from ecs_eco.config.shipped import WORLDS
from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest
from ecs_eco.engine.files import write
from ecs_eco.worlds.policies import name_weights

HERE = Path(__file__).parent
ORIGINS = ("meadow", "blank", "predator-prey")
OWN_CODE = """
code = ["lightning.py"]           # code files next to this file; --trust allows them to run
systems = ["lightning:Lightning"] # custom systems, which run in every tick
"""
OF_PACKAGE = """
code = ["my_ecology.components", "my_ecology.systems"]  # installed modules; --trust allows them to run
systems = ["my_ecology.systems:GrowFur"]                # custom systems, which run in every tick
"""


def new_world(folder: str | Path, origin: str = "meadow") -> list[Path]:
    """Write a world, a custom system with a test, and a README to a new folder; return the files.

    `origin` is "meadow" (grass and rabbits), "blank" (moss) or "predator-prey" (the shipped world, with its
    trained policies). Raises ConfigError if the name is invalid or the folder is not empty.
    """
    folder = Path(folder)
    if origin not in ORIGINS:
        raise _refused("--from", "unknown starter world", origin, listed(ORIGINS), nearest(origin, ORIGINS))
    name = _name(folder)
    texts = _texts(HERE / "world", {"my-world": name})
    worlds = {path: texts.pop(f"{path}.toml") for path in ("meadow", "blank")}
    files: dict[str, str | bytes] = {**texts}
    if origin == "predator-prey":
        shipped = WORLDS / "predator_prey"
        text = (shipped / "predator_prey.toml").read_text(encoding="utf-8")
        files |= {path.name: path.read_bytes() for path in sorted(shipped.glob("*.safetensors"))}
        worlds[origin] = text.replace('name = "predator-prey"', f'name = "{name}"').replace(
            "\n[space]\n", f"{OWN_CODE}\n[space]\n", 1
        )
    written = _written(folder, {f"{name}.toml": worlds[origin], **files})
    if origin == "predator-prey":
        config = load(origin)
        for species, kind in config.species.items():
            if kind.policy.file:
                name_weights(folder / kind.policy.file, config, species)
    return written


def new_package(folder: str | Path) -> list[Path]:
    """Write a Python package with a component, a system, a world and their tests to a new folder; return the
    files.

    The package is named after the folder, with _ in place of -. Raises ConfigError if the name is invalid or
    taken by another module, or if the folder is not empty.
    """
    folder = Path(folder)
    name = _name(folder)
    module = name.replace("-", "_").lower()
    if keyword.iskeyword(module) or importlib.util.find_spec(module) is not None:
        raise _refused("NAME", "is the name of an existing module or a keyword", name, "an unused name")
    files = _texts(HERE / "package", {"my_ecology": module, "my-ecology": name})
    meadow = (HERE / "world" / "meadow.toml").read_text(encoding="utf-8")
    head, _, rest = meadow.partition("\ncode = ")
    fur = '[species.rabbit]\ncomponents = ["my_ecology.components:Fur"]\n'
    rest = rest.partition("\n\n")[2].replace("[species.rabbit]\n", fur, 1)
    world = f"{head}{OF_PACKAGE}\n{rest}".replace("my-world", "meadow")
    files[f"src/{module}/meadow.toml"] = world.replace("my_ecology", module)
    return _written(folder, dict(sorted(files.items())))


def _name(folder: Path) -> str:
    """Return the name of a new folder, which is also the name of its world or package."""
    name = folder.absolute().name
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,39}", name) or not name[-1].isalnum():
        raise _refused(
            "NAME",
            "not a valid name",
            name,
            "a letter, then letters, digits, - or _ (at most 40), ending in a letter or a digit",
        )
    if folder.is_symlink() or (folder.exists() and (not folder.is_dir() or any(folder.iterdir()))):
        raise _refused("NAME", "the folder is not empty", str(folder), "a new or empty folder")
    return name


def _texts(folder: Path, names: dict[str, str]) -> dict[str, str]:
    """Return the texts in a folder of templates by their new paths; names are replaced in both."""
    texts = {}
    for path in sorted(p for p in folder.rglob("*") if p.is_file() and p.suffix != ".pyc"):
        place = path.relative_to(folder).as_posix().removesuffix(".template")
        text = path.read_text(encoding="utf-8")
        for old, new in names.items():
            place, text = place.replace(old, new), text.replace(old, new)
        texts[place] = text
    return texts


def _written(folder: Path, files: dict[str, str | bytes]) -> list[Path]:
    for place in files:
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
    return [write(folder / place, content) for place, content in files.items()]


def _refused(source: str, fault: str, value: str, allowed: str, near: str = "") -> ConfigError:
    return ConfigError([Problem((), fault, value, allowed, near, source)])
