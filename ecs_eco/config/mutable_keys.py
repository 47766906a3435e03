"""Which values of a world file may change while the world lives, and the alternatives for the others."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import MISSING, Problem
from ecs_eco.engine.section import function_name

Key = tuple[str | int, ...]
ANEW = "build a world with it and run it from the start"
NUMBERS = 'an intervention of kind "add" or "cull"'
SHAPE = "weights and columns have their shapes from it: build a world with it"

# the first match counts; "" means that it may change; * is one part of a key, ** any
RULES: tuple[tuple[str, str], ...] = (
    ("systems.*.use", ANEW), ("systems.*.**", ""), ("reporters.*.use", ANEW), ("reporters.*.**", ""),
    ("species.*.sensors.*.function.use", SHAPE), ("species.*.sensors.*.function.**", ""),
    ("species.*.count", NUMBERS), ("objects.*.count", NUMBERS), ("objects.*.at**", NUMBERS),
    ("objects.*.heading**", ANEW), ("objects.*.between**", NUMBERS), ("*.*.body.shape", ANEW),
    ("*.*.body.length", ANEW), ("*.*.body.size**", ANEW),
    ("terrain.slope_cost", ""), ("terrain**", 'an intervention of kind "fence"'),
    ("species.*.reproduction.kind", ANEW), ("species.*.reproduction.eggs", ANEW),
    ("species.*.reproduction", ANEW + '; or an intervention of kind "switch"'), ("*.*.body.radius", ANEW),
    ("*.*.body.compressible", ANEW),
    ("*.*.body.*", ""), ("*.*.color", ""), ("*.*.properties.*", ""), ("*.*.substances.*", ""),
    ("species.*.sensors**", SHAPE), ("species.*.actions**", SHAPE), ("species.*.genome.mate**", ""),
    ("species.*.genome.mutate**", ""), ("species.*.genome.insertion", ""), ("species.*.genome.deletion", ""),
    ("species.*.genome.duplication", ""), ("species.*.genome.loss", ""),
    ("species.*.genome**", SHAPE), ("species.*.policy.kind", SHAPE), ("species.*.policy.hidden**", SHAPE),
    ("species.*.policy.network", SHAPE), ("species.*.policy.function**", SHAPE),
    ("species.*.policy.device", SHAPE),
    ("species.*.policy.file", "World.from_config(…, policies=…)"),
    ("species.*.policy.*", ""), ("species.*.locomotion.**", ""), ("species.*.metabolism.*", ""),
    ("species.*.hatch", SHAPE), ("species.*.hatch.into", SHAPE), ("species.*.hatch.*", ""),
    ("species.*.care", SHAPE), ("species.*.care.*", ""), ("species.*.growth", SHAPE),
    ("species.*.growth.*", ""), ("species.*.breeding", ANEW),
    ("species.*.breeding.**", ""), ("*.*.heat", SHAPE), ("*.*.heat.**", ""),
    ("objects.*.energy", SHAPE), ("objects.*.energy.*", ""), ("objects.*.renewal", ""),
    ("land_use", ANEW), ("land_use.*", ANEW), ("land_use.*.kind", ANEW), ("land_use.*.species", ANEW),
    ("land_use.**", ""),
    ("objects.*.motion", SHAPE), ("objects.*.motion.**", ""), ("objects.*.pushed", ""),
    ("species.*.carries", SHAPE), ("species.*.carries.*.object", SHAPE), ("species.*.carries.*.*", ""),
    ("species.*.builds", ANEW), ("species.*.builds.*.object", ANEW), ("species.*.builds.*.*", ""),
    ("*.*.reactions", SHAPE), ("*.*.reactions.**", ""),
    ("*.*.exchange", SHAPE), ("*.*.exchange.**", ""), ("*.*.decomposition", SHAPE),
    ("*.*.decomposition.*", ""), ("*.*.born_with", SHAPE), ("fields.*.renewal", ""),
    ("*.*.emits.*.consume", SHAPE), ("species.*.defence.*", ""), ("species.*.emits**", ""),
    ("species.*.diet**", ""),
    ("species.*.reflex**", ""), ("species.*.happiness**", ""), ("species.*.ppo.*", ""),
    ("species.*.reproduction.**", ""), ("species.*.lethal**", ""), ("species.*.max_count", ""),
    ("species.*.sex", ""),
    ("species.*.age**", ""),
    ("species.*.fertility", ""), ("fields.*.diffusion", ""), ("fields.*.decay", ""), ("ambient.*", ""),
    ("sun.*", ""), ("year.*", ""), ("water.**", ""), ("*.*.emits**", ""), ("seed", ""), ("ticks", ""),
    ("title", ""), ("description", ""), ("training**", ""), ("interventions**", ""), ("substances.*", ""),
    ("**", ANEW),
)  # fmt: skip
_SIGNS = {".": r"\.", "**": ".*", "*": "[^.]+"}
_RULES = tuple((re.compile(re.sub(r"\*\*|[.*]", lambda m: _SIGNS[m[0]], pattern)), hint)
               for pattern, hint in RULES)


def changes(old: Any, new: Any, key: Key = ()) -> Iterator[tuple[Key, Any, Any]]:
    """Every value that differs between two sections as `model_dump` gives them: its key, what it was,
    and what it is."""
    if _adds_parameters(old, new):
        old = {"use": old}
    if isinstance(old, dict) and isinstance(new, dict):
        for part in dict.fromkeys([*old, *new]):
            yield from changes(old.get(part, MISSING), new.get(part, MISSING), (*key, part))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for i, (a, b) in enumerate(zip(old, new, strict=True)):
            yield from changes(a, b, (*key, i))
    elif old is not new and _plain(old) != _plain(new):
        yield key, old, new


def _adds_parameters(old: Any, new: Any) -> bool:
    """Whether a function without parameters got some: they alone are new."""
    return isinstance(new, dict) and "use" in new and (isinstance(old, str) or callable(old))


def refused(old: WorldConfig, new: WorldConfig) -> list[Problem]:
    """A problem for each value that differs and cannot change in a living world."""
    problems = []
    for key, before, now in changes(old.model_dump(), new.model_dump()):
        hint = _hint(".".join(map(str, key)))
        if not hint and len(key) > 2 and key[2] in ("properties", "substances") and MISSING in (before, now):
            hint = SHAPE  # a column would be added or removed
        if not hint and key[0] == "objects" and key[-1] == "renewal" and before is MISSING:
            hint = ANEW  # there is no system for it
        if not hint and key[0] == "substances" and MISSING in (before, now):
            hint = SHAPE
        if hint:
            problems.append(Problem(key, "cannot change in a living world", now, hint))
    for name, species in new.species.items():
        if name in old.species and not problems:
            problems += _of_genes(("species", name), old.species[name], species, new)
    return problems


def may_change(key: str) -> bool:
    """Whether the value of a dotted key may change in a living world, as far as the key alone tells."""
    return not _hint(key)


def why_not(key: str) -> str:
    """What there is to do instead where the value of a dotted key cannot change; "" where it may."""
    return _hint(key)


def _hint(key: str) -> str:
    return next(hint for pattern, hint in _RULES if pattern.fullmatch(key))


def _of_genes(key: Key, old: Any, new: Any, config: WorldConfig) -> Iterator[Problem]:
    """Problems of genes: their values are individual, and the number of individual columns is fixed."""
    if new.policy.kind == "individual" and old.ppo["horizon"] != new.ppo["horizon"]:
        yield Problem((*key, "ppo", "horizon"), "cannot change in a living world", new.ppo["horizon"], SHAPE)
    if new.genome is None:
        return
    from ecs_eco.config.traits import traits_of

    own = [c for name in new.components if (c := config._code.known(name)) is not None]
    before, now = (traits_of(species, config.dims, own) for species in (old, new))
    genes = {gene.trait: gene.name for gene in new.genome.genes if gene.trait}
    used = {before[name].component for name in genes if name in before}
    for section, component in (("reflex", "Reflexes"), ("happiness", "Desires"), ("lethal", "LifeHistory")):
        names = [[n for n, t in traits.items() if t.component == component] for traits in (before, now)]
        if component in used and names[0] != names[1]:
            yield Problem((*key, section),
                          "cannot change in a living world: its genes code for what is in it", allowed=SHAPE)
    for name, gene in genes.items():
        if name in before and name in now and before[name].default != now[name].default:
            fault = f"the gene {gene} codes for it, so each organism has its own"
            yield Problem((*key, *name.split(".")), fault, now[name].default, "values that no gene codes for")


def _plain(value: Any) -> Any:
    """A value that can be compared: functions and systems by their name."""
    if callable(value) or callable(getattr(value, "process", None)):
        return function_name(value)
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    return [_plain(v) for v in value] if isinstance(value, list) else value
