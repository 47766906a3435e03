"""The best worlds as files that `ecs-eco run` takes: the world's text with other values, and policies."""

from __future__ import annotations

import glob
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ecs_eco.analysis.page import write_text
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.edit import as_toml, edited
from ecs_eco.config.loading import document_of
from ecs_eco.config.ranges import key_of, real_key
from ecs_eco.engine.errors import ConfigError
from ecs_eco.experiments.trained import forget_trained
from ecs_eco.record.code import keep_beside
from ecs_eco.record.container import inside
from ecs_eco.search.plan import TRAINED, Plan

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World

Key = tuple[str | int, ...]


def write_world(
    plan: Plan,
    world: World,
    overrides: Any,
    values: Mapping[str, float],
    trained: Path,
    file: Path,
    note: str,
) -> None:
    """Write one world; `trained` is the folder of the policies trained for it, if any."""
    config = load(plan.config, dict(values))
    files = _policies(config, trained, file.with_suffix(""), plan.config.search.policies in TRAINED)
    text = _text(config, world, overrides, values, files)
    keep_beside(config._code.sources, file.parent)
    _keep_named(config, file.parent)
    for candidate in (text, as_toml(_data(config, files))):
        if candidate is not None:
            write_text(file, "".join(f"# {line}\n" for line in note.splitlines()) + candidate)
            if _same(file, config):
                return
    raise RuntimeError(
        f"{file} could not be written as the world that was evaluated; its values are in the journal"
    )


def _text(
    config: WorldConfig, world: World, overrides: Any, values: Mapping[str, float], files: Mapping[str, str]
) -> str | None:
    """The world's own text with these values; None if there is none, or it cannot be edited."""
    document = document_of(world, overrides)
    if not document.text:
        return None
    changes: dict[Key, Any] = {
        key: value for key, value in document.changes.items() if key[:1] != ("search",)
    }
    changes |= {real_key(config.model_dump(), key_of(name))[0]: value for name, value in values.items()}
    changes |= {("species", name, "policy", "file"): path for name, path in files.items()}
    return edited(document.text, changes)


def _data(config: WorldConfig, files: Mapping[str, str]) -> dict[str, Any]:
    data = config.resolved()
    for name, path in files.items():
        data["species"][name]["policy"]["file"] = path
    return data


def _keep_named(config: WorldConfig, out: Path) -> None:
    """Copy what the world names beside itself, rasters, layers and measurements, to the same names beside the
    new one; files elsewhere stay where they are, and are named as from there only if that leads to them."""
    land = config.terrain
    names = [] if land is None else [land.raster, land.cover, *(layer.file for layer in land.layers)]
    names += [] if config.data is None else [config.data.file]
    for name in filter(None, names):
        path = config.file(name)
        beside = not Path(name).is_absolute() and ".." not in Path(name).parts
        if not beside or not path.is_file() or inside(out, out / name).exists():
            continue
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        for part in [path, *path.parent.glob(f"{glob.escape(path.stem)}.*")]:  # a Shapefile has several
            if part.is_file():
                shutil.copyfile(part, (out / name).with_name(part.name))


def _same(file: Path, config: WorldConfig) -> bool:
    """Whether the file is the world, apart from the place of its policies."""
    try:
        written = load(file)
    except ConfigError:
        return False
    a, b = written.resolved(), config.resolved()
    for data in (a, b):
        for species in data["species"].values():
            species["policy"]["file"] = None
    return a == b


def _policies(config: WorldConfig, trained: Path, beside: Path, training: bool) -> dict[str, str]:
    """Copy the policies beside the world; return the file of each species, as the world names it."""
    forget_trained(inside(beside.parent, beside))
    sets = sorted(trained.glob("training-*"), key=lambda p: int(p.name.partition("-")[2])) if training else []
    for folder in sets:
        shutil.copytree(folder, beside / folder.name, dirs_exist_ok=True)
    files = {}
    for name, species in config.species.items():
        if not species.policy.thinks:
            continue
        if sets and (sets[0] / f"{name}.safetensors").is_file():
            files[name] = f"{beside.name}/{sets[0].name}/{name}.safetensors"
        elif not training and species.policy.file:
            beside.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(config.file(species.policy.file), beside / f"{name}.safetensors")
            files[name] = f"{beside.name}/{name}.safetensors"
    return files
