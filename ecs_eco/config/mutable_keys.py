"""Values of a world file that can change during a run, and the alternatives for the rest."""

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, get_args, get_origin

from ecs_eco.config.derived import all_genes
from ecs_eco.config.former import is_section, members_of
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key
from ecs_eco.config.traits import traits_of
from ecs_eco.engine.errors import MISSING, Problem
from ecs_eco.inputs.section import ANEW, FREE, SHAPE, Change, Use, function_name


def changes(old: object, new: object, key: Key = ()) -> Iterator[tuple[Key, Any, Any]]:
    """Yield the key, old value and new value of every difference between two sections from `model_dump`."""
    if isinstance(new, dict) and "use" in new and (isinstance(old, str) or callable(old)):
        old = {"use": old}  # only the parameters of this function are new
    if isinstance(old, dict) and isinstance(new, dict):
        for part in dict.fromkeys([*old, *new]):
            yield from changes(old.get(part, MISSING), new.get(part, MISSING), (*key, part))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for i, (a, b) in enumerate(zip(old, new, strict=True)):
            yield from changes(a, b, (*key, i))
    elif old is not new and _plain(old) != _plain(new):
        yield key, old, new


def refused(old: WorldConfig, new: WorldConfig) -> list[Problem]:
    """Return a problem for each value that differs but cannot change during a run."""
    problems = []
    for key, before, now in changes(old.model_dump(), new.model_dump()):
        hint = why_not(".".join(map(str, key)), type(new))
        if not hint and MISSING in (before, now) and {"properties", "substances"} & {key[0], *key[2:3]}:
            hint = SHAPE  # a column would be added or removed
        if not hint and key[0] == "objects" and key[-1] == "renewal" and before is MISSING:
            hint = ANEW  # there is no system to do it
        if hint:
            problems.append(Problem(key, "cannot change during a run", now, hint))
    for name, species in new.species.items():
        if name in old.species and not problems:
            problems += _of_genes(("species", name), old.species[name], species, new)
    return problems


@lru_cache(10_000)  # keys can come from untrusted users
def why_not(key: str, model: type[WorldConfig] = WorldConfig) -> str:
    """Return the alternative if the value of a dotted key cannot change, otherwise ""."""
    return _instead(key.split("."), model, ANEW)


def _instead(key: list[str], kind: Any, held: str) -> str:
    """Return the alternative to changing a key within a type; `held` is the type's alternative."""
    for part in members_of(kind) if key else ():
        if get_origin(part) in (dict, list):
            return _instead(key[1:], get_args(part)[-1], held)
        if part is Use:  # a function's name and parameters
            return held if key[0] == "use" else FREE
        if is_section(part) and (field := part.model_fields.get(key[0])) is not None:
            change = next((mark for mark in field.metadata if isinstance(mark, Change)), Change())
            if len(key) > 1 and change.entries is not None:
                return change.entries
            own = next((x for x in (change.instead, part.marks[0].instead) if x is not None), held)
            return _instead(key[1:], field.annotation, own)
    return held


def _of_genes(key: Key, old: Species, new: Species, config: WorldConfig) -> Iterator[Problem]:
    """Yield problems with values that genes code for; organisms store them in a fixed number of columns."""
    if new.policy.kind == "individual" and old.ppo["horizon"] != new.ppo["horizon"]:
        yield Problem((*key, "ppo", "horizon"), "cannot change during a run", new.ppo["horizon"], SHAPE)
    if new.genome is None:
        return
    own = [c for c in config.own_components(new) if c is not None]
    before, now = (traits_of(species, config.dims, own) for species in (old, new))
    genes = {gene.trait: gene.name for gene in all_genes(new) if gene.trait}
    used = {before[name].component for name in genes if name in before}
    for section, component in (
        ("reflex", "Reflexes"),
        ("happiness", "HappinessWeights"),
        ("lethal", "LifeHistory"),
    ):
        names = [[n for n, t in traits.items() if t.component == component] for traits in (before, now)]
        if component in used and names[0] != names[1]:
            yield Problem(
                (*key, section), "cannot change during a run: genes code for its values", allowed=SHAPE
            )
    for name, gene in genes.items():
        if name in before and name in now and before[name].default != now[name].default:
            fault = f"the gene {gene} codes for it, so each organism has its own value"
            yield Problem((*key, *name.split(".")), fault, now[name].default, "values that no gene codes for")


def _plain(value: object) -> Any:
    """Return a comparable value, with functions and systems replaced by their names."""
    if callable(value) or callable(getattr(value, "process", None)):
        return function_name(value)
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    return [_plain(v) for v in value] if isinstance(value, list) else value
