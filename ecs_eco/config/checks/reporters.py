"""Checks of what a world measures: names that are free, and formulas over components that there are."""

import re
from collections.abc import Collection, Iterator
from typing import Any, TypeGuard

from ecs_eco.config.checks.genome import components_of
from ecs_eco.config.formula import FormulaError
from ecs_eco.config.models.reporters import is_reporter
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.reporter_formula import Fields, ReporterFormula, compile_reporter
from ecs_eco.engine.errors import Problem

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
    """The fields of all components, and whether these are all: not where own code may not run yet."""
    from ecs_eco import components

    fields = {name: getattr(components, name).fields for name in components.__all__}
    owns = [components_of(config, species) for species in config.species.values()]
    for own in owns:
        fields |= {component.__name__: component.fields for component in own or ()}
    return fields, None not in owns
