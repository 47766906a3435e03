"""Writes a folder with a new world, or with a new package."""

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
code = ["lightning.py"]           # files beside this one whose code the world may use, once allowed: --trust
systems = ["lightning:Lightning"] # what happens in every tick besides living: your own systems
"""
OF_PACKAGE = """
code = ["my_ecology.components", "my_ecology.systems"]  # installed modules; their code runs once you allow it
systems = ["my_ecology.systems:GrowFur"]                # what happens in every tick besides living
"""


def new_world(folder: str | Path, origin: str = "meadow") -> list[Path]:
    """Write a world, a system of its own with a test, and a README into a new folder; return the files.

    `origin` is "meadow" (grass and rabbits), "blank" (moss) or "predator-prey" (the shipped world, with its
    trained policies). Raises ConfigError for a name that no world can have and for a folder that is not
    empty.
    """
    folder = Path(folder)
    if origin not in ORIGINS:
        raise _refused(
            "--from", "no such world to begin with", origin, listed(ORIGINS), nearest(origin, ORIGINS)
        )
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
    """Write a Python package with a component, a system, a world and their tests into a new folder; return
    the files.

    The package has the folder's name, with _ for -. Raises ConfigError for a name that no package can have,
    or that another module has, and for a folder that is not empty.
    """
    folder = Path(folder)
    name = _name(folder)
    module = name.replace("-", "_").lower()
    if keyword.iskeyword(module) or importlib.util.find_spec(module) is not None:
        raise _refused("NAME", "there is a module of that name", name, "a name of its own")
    files = _texts(HERE / "package", {"my_ecology": module, "my-ecology": name})
    meadow = (HERE / "world" / "meadow.toml").read_text(encoding="utf-8")
    head, _, rest = meadow.partition("\ncode = ")
    fur = '[species.rabbit]\ncomponents = ["my_ecology.components:Fur"]\n'
    rest = rest.partition("\n\n")[2].replace("[species.rabbit]\n", fur, 1)
    world = f"{head}{OF_PACKAGE}\n{rest}".replace("my-world", "meadow")
    files[f"src/{module}/meadow.toml"] = world.replace("my_ecology", module)
    return _written(folder, dict(sorted(files.items())))


def _name(folder: Path) -> str:
    """The name of a new folder, which is that of what is in it."""
    name = folder.absolute().name
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,39}", name) or not name[-1].isalnum():
        raise _refused(
            "NAME",
            "not a name",
            name,
            "a letter, then letters, digits, - or _ (at most 40), at the end a letter or a digit",
        )
    if folder.is_symlink() or (folder.exists() and (not folder.is_dir() or any(folder.iterdir()))):
        raise _refused("NAME", "there is something already", str(folder), "a new folder, or an empty one")
    return name


def _texts(folder: Path, names: dict[str, str]) -> dict[str, str]:
    """The texts of a folder of templates by the paths that they get, with other names in both."""
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
