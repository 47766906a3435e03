"""Reads a world: a shipped one by name, a file or a dict, with values set from outside; or says all that is wrong."""

from __future__ import annotations

import copy
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ecs_eco.config.checks.world import check
from ecs_eco.config.explain import problems_of, value_at
from ecs_eco.config.lines import key_lines
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.names import names_in
from ecs_eco.config.ranges import check_search, key_of, real_key, take_ranges
from ecs_eco.config.reading import parse_toml, read_toml, too_deep
from ecs_eco.config.shipped import shipped
from ecs_eco.engine.code import Code, read
from ecs_eco.engine.errors import MISSING, MOST, ConfigError, Problem, how_many, listed, nearest, shortened

Key = tuple[str | int, ...]
Overrides = Mapping[str, Any] | Iterable[str] | None
NAMED = ("species", "fields", "objects", "substances")  # tables whose keys are names that the world gives
ALIASES: dict[str, Key] = {"birth_rate": ("reproduction", "rate")}  # short for keys of a species, in --set only


@dataclass
class _Document:
    """A world before it is checked, and where each part of it comes from."""

    data: dict[str, Any]
    source: str
    folder: Path
    text: str = ""
    set_by: str = "--set"
    code: Code | None = None  # of the world that this one is a change of: it names no other
    places: Sequence[Path] = field(default_factory=tuple)  # where its code is looked for; none: its folder

    @cached_property
    def lines(self) -> dict[Key, int]:
        """The line of every key of the text; none where there is no text."""
        return key_lines(self.text) if self.text else {}

    def __post_init__(self) -> None:
        self.set: dict[Key, Key] = {}  # key, and the key as it was written

    @property
    def changes(self) -> dict[Key, Any]:
        """What was set from outside, by key."""
        return {key: value_at(self.data, key) for key in self.set}


def load(
    world: str | Path | Mapping[str, Any] | WorldConfig, overrides: Overrides = None, systems: Iterable[Any] = (), *,
    trust: bool = False, places: Sequence[Path] = (),
) -> WorldConfig:
    """The checked world; `overrides` are dotted keys with values, or texts like "species.deer.count=50".

    `systems` (classes or instances) are added to those that the world names. `trust` allows the code that it lists in `code` to
    run in this process; without it, or an earlier --trust, what stands in that code is not looked at. Its files are looked for in
    `places`, else in the world's folder. Raises ConfigError with every problem found.
    """
    document = _read(world)
    document.places = document.places or tuple(places)
    if systems := list(systems):
        document.data["systems"] = [*document.data.get("systems", []), *systems]
    problems = _apply(document, overrides)
    if deep := too_deep(document.data):
        raise ConfigError([_placed(deep, document)], _title(document, 1))
    if trust:
        _read_code(document)[0].allow()
    inline, found = take_ranges(document.data)
    _fix(document)
    problems += found
    config, found = _validate(document)
    problems += [_beside(p, inline) for p in found]
    if config is not None:
        problems += check_search(config, inline, document.set)
    if config is None or problems:
        raise ConfigError([_placed(p, document) for p in problems], _title(document, len(problems)))
    problems = _check_training(config)
    if problems:
        raise ConfigError([_placed(p, document) for p in problems], _title(document, len(problems)))
    return config


def for_training(config: WorldConfig, values: Mapping[str, Any] | None = None) -> WorldConfig:
    """The world with what [training] sets, and with `values` (of keys that vary from world to world)."""
    data = config.model_dump()  # with functions, not their names
    wanted, data["training"]["set"] = {**data["training"]["set"], **(values or {})}, {}
    ramp, data["training"]["ramp"], data["training"]["vary"] = data["training"]["ramp"], [], {}
    data["interventions"] = []  # what happens in a run
    new = load(_Document(data, config._source, config._folder, set_by="[training] set", code=config._code), wanted)  # type: ignore[arg-type]
    if not ramp:
        return new
    return new.model_copy(update={"training": new.training.model_copy(update={"ramp": config.training.ramp})})


def changed(config: WorldConfig, values: Overrides, folder: Path | None = None) -> WorldConfig:
    """The world with values that somebody sets while it lives; raises ConfigError."""
    names = values if isinstance(values, Mapping) else [text.partition("=")[0].strip() for text in values or ()]
    kept: dict[str, Any] = {}
    data, touched = config.model_dump(), {name.partition(".")[0] for name in names}
    if "interventions" not in touched:  # right already: no need to look at them again each time
        data["interventions"], kept["interventions"] = [], config.interventions
    if "training" not in touched:
        data["training"]["set"], data["training"]["vary"], data["training"]["ramp"], kept["training"] = {}, {}, [], config.training
    new = load(_Document(data, config._source, folder or config._folder, code=config._code), values)  # type: ignore[arg-type]
    return new.model_copy(update=kept)


def intervention(config: WorldConfig, what: Mapping[str, Any], before: Iterable[Mapping[str, Any]] = ()) -> Any:
    """An intervention for a living world, checked as one in its file; `before` are those that it may depend on. Raises ConfigError."""
    listed_ = [*before, dict(what)]
    data = config.model_dump() | {"interventions": listed_, "ticks": max(config.ticks, what["at"] + 1)}
    data["training"]["set"], data["training"]["vary"], data["training"]["ramp"] = {}, {}, []
    try:
        new = load(_Document(data, "intervene", config._folder, code=config._code))  # type: ignore[arg-type]
        _refuse_code(config, new.interventions[-1])
        return new.interventions[-1]
    except ConfigError as error:
        problems = [p.moved(key=p.key[2:] if p.key[:1] == ("interventions",) else p.key) for p in error.problems]
        raise ConfigError(problems, "this intervention is refused") from None


def _refuse_code(config: WorldConfig, what: Any) -> None:
    """Raise ConfigError where an intervention from outside names code: only functions themselves are taken."""
    if what.kind != "set":
        return
    before = dict(names_in(config))
    for key, value in names_in(changed(config, what.set)):
        if isinstance(value, str) and before.get(key) != value:
            allowed = "a world file may name code, and Python may hand the function itself over"
            raise ConfigError([Problem(("set", ".".join(map(str, key))), "an intervention from outside names no code", value, allowed)])


def _check_training(config: WorldConfig) -> list[Problem]:
    plan, problems = config.training, []
    for name, (low, high) in plan.vary.items():
        if not low < high:
            problems.append(Problem(("training", "vary", name), "is no range", [low, high], "[low, high] with low < high"))
    ends = (0, 1) if plan.vary else (None,) if plan.set else ()
    training = config
    for end in ends:
        values = {} if end is None else {k: v[end] for k, v in plan.vary.items()}
        try:
            if not problems:
                training = for_training(config, values)
        except ConfigError as error:
            problems = [_moved_to_training(p, plan) for p in error.problems]
    return problems or [p for i, ramp in enumerate(plan.ramp) for p in _check_ramp(training, i, ramp)]


def _check_ramp(config: WorldConfig, number: int, ramp: Any) -> list[Problem]:
    """What is wrong with the two ends of a ramp, in the world that is trained in."""
    from ecs_eco.config.mutable_keys import refused

    at = ("training", "ramp", number)
    for end, value in enumerate(ramp.values):
        try:
            now = changed(config, {ramp.key: value})
        except ConfigError as error:
            right = value_at(config.model_dump(), tuple(int(k) if is_index(k) else k for k in ramp.key.split("."))) is not MISSING
            key = (*at, "values", end) if right else (*at, "key")
            return [p.moved(key=key, source="", line=None) for p in error.problems]
        if found := refused(config, now):
            return [p.moved(key=(*at, "key"), value=ramp.key) for p in found]
    return []


def _moved_to_training(problem: Problem, plan: Any) -> Problem:
    """The problem at the entry of [training] set or vary that it comes from."""
    path = ".".join(map(str, problem.key))
    part, written = next(((part, k) for part in ("vary", "set") for k in getattr(plan, part) if k == path), ("set", None))
    key = ("training", part) if written is None else ("training", part, written)
    what = problem.what if written is not None else f"{problem.what}, at {problem.path} while training"
    return problem.moved(key=key, what=what, source="", line=None)


def _title(document: _Document, n: int) -> str:
    return f"{document.source}: {how_many(n)}"


def _beside(problem: Problem, inline: Mapping[str, Key]) -> Problem:
    """A problem of a range at the number that it stands beside."""
    name = problem.key[2] if problem.key[:2] == ("search", "ranges") and len(problem.key) > 2 else None
    return problem.moved(key=(*inline[str(name)], *problem.key[3:])) if name in inline else problem


def document_of(world: Any, overrides: Overrides = None) -> _Document:
    """A world before it is checked, with its text as it is written; its `changes` are what `overrides` set."""
    document = _read(world)
    if problems := _apply(document, overrides):
        raise ConfigError([_placed(p, document) for p in problems], _title(document, len(problems)))
    return document


# reading


def _read(world: Any) -> _Document:
    if isinstance(world, _Document):
        return world
    if isinstance(world, WorldConfig):
        known = world._code if world._code.sources or not world.code else None
        return _Document(world.model_dump() | {"search": world.search.model_dump()}, world._source, world._folder, code=known)
    if isinstance(world, Mapping):
        if deep := too_deep(world):
            raise ConfigError([deep.moved(source="dict")], "dict: 1 problem")
        home = shipped().get(str(world.get("name")))  # a shipped world's files lie beside it, wherever its dict has been
        return _Document(copy.deepcopy(dict(world)), "dict", home.parent if home else Path())
    path = _path(world)
    text, data = read_toml(path)
    return _Document(data, path.name, path.parent, text)


def _path(world: str | Path) -> Path:
    """The file of a world: the name of a shipped one, a file, or a folder with one world file."""
    worlds = shipped()
    if str(world).replace("_", "-") in worlds:
        return worlds[str(world).replace("_", "-")]
    path = Path(world)
    if os.path.isdir(path) and len(found := sorted(path.glob("*.toml"))) == 1:
        return found[0]
    if os.path.isfile(path):
        return path
    what = "no world file in this folder" if os.path.isdir(path) else "no such world, and no such file"
    allowed = f"a path, or one of {listed(worlds)}"
    problem = Problem((), what, str(world), allowed, nearest(world, worlds), "WORLD")
    raise ConfigError([problem], "cannot load the world")


# values set from outside


def _apply(document: _Document, overrides: Overrides) -> list[Problem]:
    problems: list[Problem] = []
    pairs = overrides.items() if isinstance(overrides, Mapping) else [parse(text) for text in overrides or ()]
    for name, value in pairs:
        if isinstance(value, Problem):
            problems.append(value)
            continue
        written = key = key_of(name)
        if re.search(r"(^|\.)(\.|$)", re.sub(r'"[^"]+"', "x", str(name))):  # a part of it is empty
            problems.append(Problem(("",), "an empty key", str(name), "for example species.deer.count", source=document.set_by))
            continue
        if len(key) == 3 and key[0] == "species" and key[2] in ALIASES:
            key = (*key[:2], *ALIASES[str(key[2])])
        problem = _put(document, key, written, value)
        if problem:
            problems.append(problem.moved(key=written, value=value, source=document.set_by))
    return problems


def parse(text: str) -> tuple[str, Any]:
    """Key and value of "a.b=c"; the value is TOML, and a bare word is a text."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name.strip(". "):
        return name, Problem((), "not of the form key=value", text, "for example species.deer.count=50", source="--set")
    try:
        parsed = parse_toml(f"v = {value}")
        if parsed.keys() == {"v"}:
            return name, parsed["v"]
    except ValueError:
        if re.fullmatch(r"[A-Za-z_#][\w-]*", value):
            return name, value
    example = 'for example 0.5, true, "text", [1, 2]'
    return name, Problem((name,), "the value is not TOML", value, example, source="--set")


def is_index(part: str) -> bool:
    """Whether a part of a key is a place in a list: a number of few digits."""
    return part.isdecimal() and len(part) < 10


def _put(document: _Document, key: Key, written: Key, value: Any) -> Problem | None:
    """Sets one value in the data, or says why not."""
    node: Any = document.data
    real: list[str | int] = []
    for depth, part in enumerate(key):
        last = depth == len(key) - 1
        if isinstance(node, list):
            if not is_index(str(part)) or int(part) >= len(node):
                allowed = f"0 to {len(node) - 1}" if node else "none, the list is empty"
                return Problem(key, f"no entry {shortened(str(part))}", allowed=allowed)
            part = int(part)
        elif not isinstance(node, dict):
            return Problem(key, f"{'.'.join(map(str, real))} has no parts", allowed="the key of a table or list")
        elif not last and depth == 1 and key[0] in NAMED and part not in node:
            return Problem(key, f'no {key[0]} named "{part}"', allowed=listed(node), nearest=nearest(part, node))
        real.append(part)
        if last:
            node[part] = copy.deepcopy(value)
        else:
            if isinstance(node, dict) and node.get(part) is None:
                node[part] = {}
            node = node[part]
    document.set[tuple(real)] = written
    return None


def _fix(document: _Document) -> None:
    """A value that is set is looked for no more, unless its range is set too."""
    search = document.data.get("search")
    ranges = search.get("ranges") if isinstance(search, dict) else None
    for name in list(ranges) if isinstance(ranges, dict) else ():
        key, _, wrong = real_key(document.data, key_of(name))
        if wrong is None and key in document.set and ("search", "ranges", name) not in document.set:
            del document.data["search"]["ranges"][name]


# checking


def _validate(document: _Document) -> tuple[WorldConfig | None, list[Problem]]:
    """The world and the problems across its sections, or no world and the problems within its sections."""
    try:
        return _checked(document.data, document)
    except ValidationError as error:
        return None, _with_checks(problems_of(error, document.data), document)


def _checked(data: dict[str, Any], document: _Document) -> tuple[WorldConfig, list[Problem]]:
    """The world of this data with what belongs to the document, and the problems across its sections; raises ValidationError."""
    config = WorldConfig.model_validate(data)
    config._folder, config._source = document.folder, document.source
    config._code, problems = _read_code(document, config.code)
    return config, problems + check(config, document.folder, changed)


def code_listed(document: _Document) -> Code:
    """The code that a document lists, as texts; what is wrong with it comes when the world is loaded."""
    return _read_code(document)[0]


def _read_code(document: _Document, entries: Any = None) -> tuple[Code, list[Problem]]:
    """The code that a document lists, as texts; that of the world that it is a change of is the only one."""
    entries = document.data.get("code") if entries is None else entries
    entries = [e for e in entries if isinstance(e, str)] if isinstance(entries, list) else []
    if document.code is None:
        return read(entries, document.places or [document.folder])
    if entries != (own := [s.entry for s in document.code.sources]):
        what = "cannot be set from here"
        return document.code, [Problem(("code",), what, entries, f"the world's own, {own}, or another world file")]
    return document.code, []


def _with_checks(problems: list[Problem], document: _Document) -> list[Problem]:
    """Also what the checks across sections find, once the tables with problems are mended as well as can be."""
    if len(problems) > MOST:
        return problems
    data = copy.deepcopy(document.data)
    for p in problems:
        holder = value_at(data, p.key[:-1])
        if p.key[0] in ("space", "dt") or not isinstance(holder, dict):
            return problems  # too much depends on it
        if isinstance(p.value, int | float) and not isinstance(p.value, bool) and p.what != "unknown key":
            holder[p.key[-1]] = 1
        else:
            holder.pop(p.key[-1], None)
    try:
        found = _checked(data, document)[1]
    except ValidationError:
        return problems
    broken = [p.key[:-1] for p in problems]
    return problems + [f for f in found if not any(f.key[: len(b)] == b for b in broken)]


def _placed(problem: Problem, document: _Document) -> Problem:
    """The problem with its source and line, and the value where it lacks one."""
    if problem.source:
        return problem
    value = problem.value
    if value is MISSING and problem.what != "is missing":
        value = value_at(document.data, problem.key)
    written = [k for k in document.set if problem.key[: len(k)] == k or k[: len(problem.key)] == problem.key]
    if written:
        return problem.moved(source=document.set_by, value=value, key=document.set.get(problem.key, problem.key))
    lines = document.lines
    line = next((lines[problem.key[:n]] for n in range(len(problem.key), 0, -1) if problem.key[:n] in lines), None)
    return problem.moved(source=document.source, value=value, line=line)
