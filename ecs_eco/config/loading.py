"""Load a world with overrides, or report all its problems."""

import copy
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

from pydantic import ValidationError

from ecs_eco.config.archipelago import check_islands, seed_of
from ecs_eco.config.checks.world import check
from ecs_eco.config.document import Document, read_document
from ecs_eco.config.explain import problems_of, value_at
from ecs_eco.config.extension import model_for, unknown_keys
from ecs_eco.config.features.feature import Feature
from ecs_eco.config.former import notes_on
from ecs_eco.config.knobs import check_knobs
from ecs_eco.config.measurements import check_measurements
from ecs_eco.config.models.interventions import AnyIntervention
from ecs_eco.config.models.world import Ramp, Training, WorldConfig
from ecs_eco.config.mutable_keys import refused
from ecs_eco.config.names import names_in, own_features
from ecs_eco.config.overrides import Overrides, apply_overrides, fix_ranges
from ecs_eco.config.ranges import check_search, key_of, real_key, take_ranges
from ecs_eco.config.reading import too_deep
from ecs_eco.config.rules import Key, written_at
from ecs_eco.engine.errors import MOST, ConfigError, Problem
from ecs_eco.inputs.code import Code, read

NO_PLAN: dict[str, Any] = {"set": {}, "vary": {}, "ramp": []}  # the training plan of a world in pre-training

WorldSource: TypeAlias = str | Path | Mapping[str, Any] | WorldConfig | Document
"""A world: the name of a shipped world, a TOML file, its content, or a loaded configuration."""


def load(
    world: WorldSource,
    overrides: Overrides = None,
    systems: Iterable[Any] = (),
    *,
    reporters: Mapping[str, Any] = MappingProxyType({}),
    features: Sequence[type[Feature]] = (),
    trust: bool = False,
    places: Sequence[Path] = (),
) -> WorldConfig:
    """Return a checked configuration.

    Parameters
    ----------
    world : str, Path, Mapping or WorldConfig
        Name of a shipped world, path of a TOML file, its contents, or a configuration.
    overrides : Mapping or sequence of str, optional
        Dotted keys with values, or strings such as "species.deer.count=50".
    systems : iterable
        Classes or instances of systems, in addition to those in the file.
    reporters : Mapping of str to str or callable
        Measurements by name, in addition to those in the file.
    features : sequence of type
        Classes derived from `Feature`, in addition to those in the file's code.
    trust : bool, default False
        Whether the code that the file lists in `code` is allowed to run in this process. If not, it is not
        checked either.
    places : sequence of Path
        Folders to search for code files; default: the folder of the file.

    Returns
    -------
    WorldConfig

    Raises
    ------
    ConfigError
        Lists every problem found.

    Examples
    --------
    >>> from ecs_eco.config import load
    >>> load("predator-prey", {"species.deer.count": 50}).species["deer"].count
    50
    >>> load("predator-prey", ["species.deer.cuont=50"])
    Traceback (most recent call last):
        ...
    ecs_eco.engine.errors.ConfigError: ...
    """
    document = read_document(world)
    document.places = document.places or tuple(places)
    document.features = document.features or tuple(features)
    if systems := list(systems):
        document.data["systems"] = [*document.data.get("systems", []), *systems]
    if reporters:
        document.data["reporters"] = {**document.data.get("reporters", {}), **reporters}
    problems = apply_overrides(document, overrides)
    if deep := too_deep(document.data):
        raise document.refused([deep])
    if trust:
        code_listed(document).allow()
    inline, wrong_ranges = take_ranges(document.data)
    fix_ranges(document)
    config, invalid = _validate(document)
    problems += wrong_ranges + [_beside(p, inline) for p in invalid]
    if config is not None:
        problems += check_search(config, inline, document.set)
        if document.original is None:  # in a modified world, values may be outside the ranges of its knobs
            problems += check_knobs(config, document.set)
            if not problems and not document.places:  # not for a recorded world, whose folder contains a copy
                problems += check_measurements(config)
    if config is not None and not problems:
        problems = _check_training(config) or check_islands(config, island_of)
    if config is None or problems:
        raise document.refused(problems)
    return config


def for_training(config: WorldConfig, values: Mapping[str, Any] | None = None) -> WorldConfig:
    """Return the configuration for pre-training: the world with the values in `[training.set]`.

    Parameters
    ----------
    config : WorldConfig
    values : Mapping of str to value, optional
        Additional values by dotted key, for keys that vary between worlds.

    Returns
    -------
    WorldConfig

    Examples
    --------
    >>> from ecs_eco.config import for_training, load
    >>> for_training(load("predator-prey")).species["deer"].count
    350
    """
    # with functions, not their names
    data = config.model_dump() | {"interventions": [], "reporters": {}, "record": []}
    no_network = tuple(f"species.{name}.ppo." for name, s in config.species.items() if not s.policy.thinks)
    planned = {key: value for key, value in data["training"]["set"].items() if not key.startswith(no_network)}
    wanted = planned | dict(values or {})
    data["training"] |= NO_PLAN
    new = _modified(config, data, wanted, set_by="[training] set")
    training = new.training.model_copy(update={"ramp": config.training.ramp})
    return new.model_copy(update={"training": training})


def island_of(config: WorldConfig, name: str) -> WorldConfig:
    """Return the world of one island, with the island's values and seed. Raises ConfigError."""
    plan = config.archipelago
    assert plan is not None
    data = config.model_dump()
    data["archipelago"]["here"], data["seed"] = name, seed_of(config.seed, plan.names.index(name))
    return _modified(config, data, plan.islands[name], set_by=f"[archipelago] islands.{name}")


def changed(config: WorldConfig, values: Overrides, folder: Path | None = None) -> WorldConfig:
    """Return the world with new values, as if they had changed during a run. Raises ConfigError."""
    names = values if isinstance(values, Mapping) else [text.partition("=")[0] for text in values or ()]
    data, touched = config.model_dump(), {name.strip().partition(".")[0] for name in names}
    kept: dict[str, Any] = {}
    if "interventions" not in touched:  # already checked, so not repeated for each change
        data["interventions"], kept["interventions"] = [], config.interventions
    if "training" not in touched:
        data["training"] |= NO_PLAN
        kept["training"] = config.training
    return _modified(config, data, values, folder=folder).model_copy(update=kept)


def intervention(
    config: WorldConfig, request: Mapping[str, Any], before: Iterable[Mapping[str, Any]] = ()
) -> AnyIntervention:
    """Return a checked intervention, which can depend on those in `before`. Raises ConfigError."""
    data = config.model_dump() | {"interventions": [*before, dict(request)]}
    data["ticks"] = max(config.ticks, request["at"] + 1)
    data["training"] |= NO_PLAN
    try:
        new = _modified(config, data, source="intervene").interventions[-1]
        if new.kind == "set":
            _refuse_code(config, new.set)
        return new
    except ConfigError as error:
        problems = [p.moved(key=p.key[2 * (p.key[:1] == ("interventions",)) :]) for p in error.problems]
        raise ConfigError(problems, "this intervention is invalid") from None


def _modified(
    config: WorldConfig,
    data: dict[str, Any],
    values: Overrides = None,
    source: str = "",
    set_by: str = "--set",
    folder: Path | None = None,
) -> WorldConfig:
    """Load the data of a modified world, which uses the original's code."""
    source, folder = source or config._source, folder or config._folder
    return load(Document(data, source, folder, set_by=set_by, code=config._code, original=config), values)


def _refuse_code(config: WorldConfig, values: Mapping[str, Any]) -> None:
    """Raise a ConfigError if an intervention made during a run names code; it may pass a function object."""
    before = {_home(key): value for key, value in names_in(config)}
    for key, value in names_in(changed(config, values)):
        if isinstance(value, str) and before.get(_home(key)) != value:
            fault = "an intervention made during a run cannot name code"
            allowed = "code named in the world file, or a function object passed in Python"
            raise ConfigError([Problem(("set", ".".join(map(str, key))), fault, value, allowed)])


def _home(key: Key) -> Key:
    """Return the key of a value that names code, with or without parameters."""
    return key[:-1] if key[-1] == "use" else key


def _check_training(config: WorldConfig) -> list[Problem]:
    plan, training = config.training, config
    for name, (low, high) in plan.vary.items():
        if not low < high:
            allowed = "[low, high] with low < high"
            return [Problem(("training", "vary", name), "not a range", [low, high], allowed)]
    ends = [{name: span[end] for name, span in plan.vary.items()} for end in (0, 1)]
    for values in ends if plan.vary else [{}] if plan.set else []:
        try:
            training = for_training(config, values)
        except ConfigError as error:
            return [_moved_to_training(p, plan) for p in error.problems]
    return [p for i, ramp in enumerate(plan.ramp) for p in _check_ramp(training, i, ramp)]


def _check_ramp(config: WorldConfig, number: int, ramp: Ramp) -> list[Problem]:
    """Return problems with the two ends of a ramp, in the training world."""
    at = ("training", "ramp", number)
    for end, value in enumerate(ramp.values):
        try:
            now = changed(config, {ramp.key: value})
        except ConfigError as error:
            right = real_key(config.model_dump(), key_of(ramp.key))[2] is None
            key = (*at, "values", end) if right else (*at, "key")
            return [p.moved(key=key, source="", line=None) for p in error.problems]
        if problems := refused(config, now):
            return [p.moved(key=(*at, "key"), value=ramp.key) for p in problems]
    return []


def _moved_to_training(problem: Problem, plan: Training) -> Problem:
    """Return the problem, located at the entry in [training] `set` or `vary` that caused it."""
    path = ".".join(map(str, problem.key))
    part = "vary" if path in plan.vary else "set"
    written = path if path in getattr(plan, part) else None
    return written_at(problem, ("training", part), written, " in training")


def _beside(problem: Problem, inline: Mapping[str, Key]) -> Problem:
    """Return a problem, moved to the number if the range is written next to it."""
    name = problem.key[2] if problem.key[:2] == ("search", "ranges") and len(problem.key) > 2 else None
    return problem.moved(key=(*inline[str(name)], *problem.key[3:])) if name in inline else problem


def document_of(world: object, overrides: Overrides = None) -> Document:
    """Return an unchecked world with its text and the values of `overrides`."""
    document = read_document(world)
    if problems := apply_overrides(document, overrides):
        raise document.refused(problems)
    return document


def _validate(document: Document) -> tuple[WorldConfig | None, list[Problem]]:
    """Return the world and the problems across its sections, or the problems within its sections."""
    try:
        return _checked(document.data, document)
    except ValidationError as error:
        model = _model(document, code_listed(document))
        return None, _with_checks(problems_of(error, document.data, model), document)


def _checked(data: dict[str, Any], document: Document) -> tuple[WorldConfig, list[Problem]]:
    """Return the world built from this data, and the problems across its sections. Raises ValidationError."""
    known = document.original
    if known is not None and "viewer" not in data:
        data = data | {"viewer": known.viewer}
    code, problems = _read_code(document, data.get("code"))
    config = _model(document, code).model_validate(data)
    config._folder, config._source, config._code = document.folder, document.source, code
    config._renamed = tuple(notes_on(document.renamed, config))
    problems += unknown_keys(config)
    if known is not None and (known.terrain, known.space) == (config.terrain, config.space):
        config._land = known._land
    return config, problems + check(config, document.folder, changed)


def _model(document: Document, code: Code) -> type[WorldConfig]:
    """Return the model of a document with this code and its custom features."""
    before = () if document.original is None else own_features(document.original)
    return model_for(code, tuple(dict.fromkeys((*before, *document.features))))


def code_listed(document: Document) -> Code:
    """Return the code that a document lists, as text; its problems are reported when the world is loaded."""
    return _read_code(document, document.data.get("code"))[0]


def _read_code(document: Document, entries: object) -> tuple[Code, list[Problem]]:
    """Return the code that a document lists, as text; a modified world has the original's code."""
    entries = [e for e in entries if isinstance(e, str)] if isinstance(entries, list) else []
    if (code := document.code) is None:
        return read(entries, document.places or [document.folder])
    own = list(dict.fromkeys(s.module if s.of_session else s.entry for s in code.sources))
    if entries == own:
        return code, []
    allowed = f"the world's code, {own}, or a different world file"
    return code, [Problem(("code",), "cannot be overridden", entries, allowed)]


def _with_checks(problems: list[Problem], document: Document) -> list[Problem]:
    """Add problems across sections, after repairing sections with problems as far as possible."""
    if len(problems) > MOST:
        return problems
    data = copy.deepcopy(document.data)
    for p in problems:
        holder = value_at(data, p.key[:-1])
        if p.key[0] in ("space", "dt") or not isinstance(holder, dict):
            return problems  # too many checks depend on this section
        if isinstance(p.value, int | float) and not isinstance(p.value, bool) and p.what != "unknown key":
            holder[p.key[-1]] = 1
        else:
            holder.pop(p.key[-1], None)
    try:
        across = _checked(data, document)[1]
    except ValidationError:
        return problems
    broken = [p.key[:-1] for p in problems]
    return problems + [p for p in across if not any(p.key[: len(b)] == b for b in broken)]
