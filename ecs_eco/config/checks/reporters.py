"""Checks of what a world measures: names that are free, formulas over components that there are, and recorded
fields."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import Any, TypeGuard

from ecs_eco.config.checks.genome import components_of
from ecs_eco.config.formula import FormulaError
from ecs_eco.config.models.reporters import is_reporter
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.reporter_formula import Fields, ReporterFormula, compile_reporter
from ecs_eco.engine.errors import Problem, listed, nearest

MOST_REPORTERS = 64
NAME = re.compile(r"[^\W\d_][\w \-/%()]{0,39}")


def check_reporters(config: WorldConfig) -> Iterator[Problem]:
    """The problems of names and formulas; functions are checked with all other code."""
    for i, (name, what) in enumerate(config.reporters.items()):
        key = ("reporters", name)
        if fault := fault_of_name(name, [*config.species, *config.objects]):
            yield Problem(key, fault)
        elif i >= MOST_REPORTERS:
            yield Problem(key, "one reporter too many", allowed=f"at most {MOST_REPORTERS}")
        elif is_formula(what):
            try:
                formula_of(config, what)
            except FormulaError as error:
                yield Problem(key, error.what, what, error.allowed, error.nearest)


def check_record(config: WorldConfig) -> Iterator[Problem]:
    """The problems of fields that are recorded of single organisms."""
    fields, complete = fields_of_components(config) if config.record else ({}, True)
    known = [f"{component}.{field}" for component, own in fields.items() for field in own]
    for i, name in enumerate(config.record):
        key, (component, _, field) = ("record", i), name.partition(".")
        if name in config.record[:i]:
            yield Problem(key, "recorded twice", name, "each field once")
        elif component in fields and field not in fields[component]:
            own = fields[component]
            near = nearest(field, own)
            what = f'{component} has no field "{field}"' if field else f"{component} is a component"
            near = near and f"{component}.{near}"
            yield Problem(key, what, name, ", ".join(f"{component}.{f}" for f in own), near)
        elif component not in fields and (complete or not field):
            what = f'unknown component "{component}"' if field else "no Component.field"
            yield Problem(key, what, name, listed(fields, 50), nearest(name, known))


def fault_of_name(name: str, kinds: Collection[str]) -> str:
    """What is wrong with the name of a reporter in a world of these kinds, and what is allowed; or ""."""
    if not NAME.fullmatch(name):
        return (
            "not a name; allowed: a letter, then letters, digits, spaces or _ - / % ( ), at most 40 "
            "characters"
        )
    if not is_reporter(name):
        return "every series has a column of this name; allowed: another name"
    return "a species or object type has this name; allowed: another name" if name in kinds else ""


def is_formula(what: Any) -> TypeGuard[str]:
    """Whether a reporter is a formula, not a function or the name of one."""
    return isinstance(what, str) and ":" not in what


def formula_of(config: WorldConfig, text: str) -> ReporterFormula:
    """The compiled formula of a reporter; raises FormulaError."""
    fields, complete = fields_of_components(config)
    return compile_reporter(text, [*config.species, *config.objects], fields, complete)


def fields_of_components(config: WorldConfig) -> tuple[Fields, bool]:
    """The fields of all components, shipped and of the user's own, and whether these are all: not where own
    code may not run yet."""
    from ecs_eco import components

    fields = {name: getattr(components, name).fields for name in components.__all__}
    owns = [components_of(config, species) for species in config.species.values()]
    for own in owns:
        fields |= {component.__name__: component.fields for component in own or ()}
    return fields, None not in owns
