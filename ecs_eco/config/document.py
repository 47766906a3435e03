"""An unchecked world: its data, and the file and line of each part."""

import copy
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from ecs_eco.config.explain import value_at
from ecs_eco.config.features.feature import Feature
from ecs_eco.config.former import both_names, rename
from ecs_eco.config.lines import key_lines, value_spans
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.reading import parse_toml, read_toml, too_deep
from ecs_eco.config.rules import Key
from ecs_eco.config.shipped import named, shipped
from ecs_eco.engine.errors import MISSING, ConfigError, Problem, how_many, listed, nearest
from ecs_eco.inputs.code import Code


@dataclass
class Document:
    """An unchecked world, and the origin of each part."""

    data: dict[str, Any]
    source: str
    folder: Path
    text: str = ""
    set_by: str = "--set"
    code: Code | None = None  # code of the world that this one modifies; naming other code is not allowed
    places: Sequence[Path] = field(default_factory=tuple)  # where to find its code; empty: in its folder
    original: WorldConfig | None = None  # the world that this one modifies, whose land is reused
    features: tuple[type[Feature], ...] = ()  # species features passed in Python

    @cached_property
    def lines(self) -> dict[Key, int]:
        """The line of every key in the text; empty if there is no text."""
        lines = key_lines(self.text).items()
        return {both_names(key, self.data, WorldConfig)[0]: line for key, line in lines}

    def quoted(self, key: Key, value: object) -> str:
        """Return a key's value as written in the text if it is on a single line, otherwise ""."""
        begin, end = self._spans.get(key, (0, 0))
        with suppress(ValueError):
            if begin < end and parse_toml(f"v = {self.text[begin:end]}") == {"v": value}:
                return "" if "\n" in self.text[begin:end] else self.text[begin:end]
        return ""

    @cached_property
    def _spans(self) -> dict[Key, tuple[int, int]]:
        return value_spans(self.text)

    def __post_init__(self) -> None:
        self.set: dict[Key, Key] = {}  # key: the key as written
        self.renamed = dict(rename(self.data, WorldConfig))  # key: its former name, as given in the document

    def refused(self, problems: Sequence[Problem]) -> ConfigError:
        """Return the error for these problems, each with its location."""
        return ConfigError([placed(p, self) for p in problems], f"{self.source}: {how_many(len(problems))}")

    @property
    def changes(self) -> dict[Key, Any]:
        """Return the overridden values, by key."""
        return {key: value_at(self.data, key) for key in self.set}


def read_document(world: object) -> Document:
    """Read a shipped world, a file, a dict or a configuration into a document. Raises ConfigError."""
    if isinstance(world, Document):
        return world
    if isinstance(world, WorldConfig):
        known = world._code if world._code.sources or not world.code else None
        return Document(
            world.model_dump() | {"search": world.search.model_dump()},
            world._source,
            world._folder,
            code=known,
            original=world,
        )
    if isinstance(world, Mapping):
        if deep := too_deep(world):
            raise ConfigError([deep.moved(source="dict")], "dict: 1 problem")
        # a shipped world's files are next to its world file, wherever the dict comes from
        home = shipped().get(str(world.get("name")))
        return Document(copy.deepcopy(dict(world)), "dict", home.parent if home else Path())
    path = _path(world)
    text, data = read_toml(path)
    return Document(data, path.name, path.parent, text)


def present(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of a stored configuration with current key names."""
    return Document(copy.deepcopy(dict(data)), "dict", Path()).data


def _path(world: object) -> Path:
    """Return the file of a world given by its name or path, or a folder with one world file. Raises ConfigError."""
    if (known := named(world)) is not None:
        return known
    worlds, path = shipped(), Path(str(world))
    if os.path.isdir(path) and len(files := sorted(path.glob("*.toml"))) == 1:
        return files[0]
    if os.path.isfile(path):
        return path
    fault = "no world file in this folder" if os.path.isdir(path) else "no such world, and no such file"
    allowed = f"a path, package:world of an installed package, or one of: {listed(worlds)}"
    problem = Problem((), fault, str(world), allowed, nearest(world, worlds), "WORLD")
    raise ConfigError([problem], "cannot load the world")


def placed(problem: Problem, document: Document) -> Problem:
    """Return the problem with its source and line and, if it lacks one, its value."""
    if problem.source:
        return problem
    value = problem.value
    if value is MISSING and problem.what != "is missing":
        value = value_at(document.data, problem.key)
    written = [k for k in document.set if problem.key[: len(k)] == k or k[: len(problem.key)] == problem.key]
    if written:
        key = written[0] if len(written) == 1 and len(written[0]) > len(problem.key) else problem.key
        return problem.moved(
            source=document.set_by, value=value_at(document.data, key), key=document.set.get(key, key)
        )
    lines = document.lines
    line = next(
        (lines[problem.key[:n]] for n in range(len(problem.key), 0, -1) if problem.key[:n] in lines), None
    )
    text = document.quoted(problem.key, value)
    return problem.moved(source=document.source, value=value, line=line, written=text)
