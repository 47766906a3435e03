"""Checks of reporters, of recorded fields, and (without calling it) of the code that a world names."""

import re
from collections import deque
from collections.abc import Collection, Iterator, Sequence
from fnmatch import fnmatchcase
from typing import Any, TypeGuard

import numpy as np

from ecs_eco import components
from ecs_eco.config.checks.genome import components_of
from ecs_eco.config.formula import Formula, FormulaError, compile_formula
from ecs_eco.config.models.reporters import is_reporter
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.names import Key, is_component, used_in
from ecs_eco.config.reporter_formula import Fields, ReporterFormula, compile_reporter
from ecs_eco.engine.arguments import takes
from ecs_eco.engine.errors import Problem, listed, nearest
from ecs_eco.inputs.code import SHIPPED
from ecs_eco.inputs.parameters import problems_of_parameters
from ecs_eco.inputs.section import Use, function_name

MOST_REPORTERS = 64
SETTLED = re.compile(r"settled\((.+),\s*([1-9]\d{0,8})\s*,\s*(\d*\.?\d+)\s*\)")
NAME = re.compile(r"[^\W\d_][\w \-/%()]{0,39}")


def check_reporters(config: WorldConfig) -> Iterator[Problem]:
    """Yield problems with reporters' names and formulas; functions are checked with all other code."""
    for i, (name, what) in enumerate(config.reporters.items()):
        key = ("reporters", name)
        if fault := fault_of_name(name, [*config.species, *config.objects]):
            yield Problem(key, fault)
        elif i >= MOST_REPORTERS:
            yield Problem(key, "too many reporters", allowed=f"at most {MOST_REPORTERS}")
        elif is_formula(what):
            try:
                formula_of(config, what)
            except FormulaError as error:
                yield Problem(key, error.what, what, error.allowed, error.nearest)


def check_record(config: WorldConfig) -> Iterator[Problem]:
    """Yield problems with the fields of organisms to record."""
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
            what = f'unknown component "{component}"' if field else "not a Component.field"
            yield Problem(key, what, name, listed(fields, 50), nearest(name, known))


def fault_of_name(name: str, kinds: Collection[str]) -> str:
    """Return the problem with a reporter's name and the expected form, or ""."""
    if not NAME.fullmatch(name):
        return (
            "not a name; expected: a letter, then letters, digits, spaces or _ - / % ( ), at most 40 "
            "characters"
        )
    if not is_reporter(name):
        return "every series has a column with this name; expected: another name"
    return "a species or object type has this name; expected: another name" if name in kinds else ""


def is_formula(what: object) -> TypeGuard[str]:
    """Return whether a reporter is a formula rather than a function or the name of a function."""
    return isinstance(what, str) and ":" not in what


def formula_of(config: WorldConfig, text: str) -> ReporterFormula:
    """Return the compiled formula of a reporter. Raises FormulaError."""
    fields, complete = fields_of_components(config)
    return compile_reporter(text, [*config.species, *config.objects], fields, complete)


class Rule:
    """A stop rule: a condition or, with a window [ticks], the convergence of a number's mean."""

    def __init__(self, text: str, formula: Formula, window: int = 0, tolerance: float = 0.0) -> None:
        self.text, self.formula, self.window, self.tolerance = text, formula, window, tolerance
        self.values = deque[float](maxlen=2 * window)  # of the last two windows

    def met(self, value: float, tick: int) -> bool:
        """Return whether the rule ends a run at this tick, given the formula's value."""
        self.values.append(value)
        if not self.window:
            return bool(value)
        if len(self.values) < 2 * self.window or tick % self.window:
            return False
        before, now = np.reshape(self.values, (2, -1)).mean(1)
        return bool(abs(now - before) <= self.tolerance * abs(before))


def rule_of(config: WorldConfig, text: str) -> Rule:
    """Return a compiled stop rule: a condition over `wolf` (the number of wolves), `name` (a reporter of the
    world) and `name.wolf` (a reporter of each species), or `settled(wolf, window, tolerance)`: the mean of a
    number over a window, which ends at a multiple of its length, differs from the mean over the window before
    by at most this share. Raises FormulaError."""
    settled = SETTLED.fullmatch(text.strip())
    if settled is None and text.strip().startswith("settled("):
        raise FormulaError("not a rule of convergence", 1, "settled(NUMBER, TICKS, SHARE)")
    names = [*config.species, *(() if settled else config.objects)]  # a series has no numbers of objects
    for name, what in config.reporters.items():
        each = formula_of(config, what).each if is_formula(what) else None  # a function may return either
        names += [] if each else [name]
        names += [] if each is False else [f"{name}_{species}" for species in config.species]
    if settled is None:
        return Rule(text, compile_formula(text, names))
    number, window, tolerance = settled.groups()
    return Rule(text, compile_formula(number, names), int(window), float(tolerance))


def problems_of_rules(config: WorldConfig, rules: Sequence[str]) -> Iterator[Problem]:
    """Yield problems with the conditions that end a run."""
    for i, text in enumerate(rules):
        try:
            rule_of(config, text)
        except FormulaError as error:
            yield Problem(("until", i), error.what, text, error.allowed, error.nearest)


def fields_of_components(config: WorldConfig) -> tuple[Fields, bool]:
    """Return the fields of all known components, and whether all custom components are known."""
    fields = {name: getattr(components, name).fields for name in components.__all__}
    owns = [components_of(config, species) for species in config.species.values()]
    for own in owns:
        fields |= {component.__name__: component.fields for component in own or ()}
    return fields, None not in owns


ARGUMENTS = {  # number of arguments of a function, by key; None: checked elsewhere, or not called
    "systems.*": 0,
    "species.*.components.*": None,
    "species.*.sensors.*.function": 5,
    "species.*.reflex.function": 1,
    "species.*.happiness.function": 1,
    "water.current_function": 4,
    "search.objective": 1,
    "search.objective.*.of": 1,
    "reporters.*": 1,
    "species.*.policy.network": None,
    "species.*.policy.function": 2,
    "species.*.genome.mate.operator": None,
    "species.*.genome.mutate.operator": None,
}


def check_code(config: WorldConfig) -> Iterator[Problem]:
    """Yield problems with the functions, systems and components that a world names, and their parameters."""
    used = list(used_in(config))
    names = [entry.use if isinstance(entry, Use) else entry for _, entry in used]
    if any(isinstance(name, str) and name not in SHIPPED for name in names):
        yield from config._code.faults()
    for place, entry in used:
        key, value = ((*place, "use"), entry.use) if isinstance(entry, Use) else (place, entry)
        pattern = next((p for p in ARGUMENTS if fnmatchcase(".".join(map(str, place)), p)), "")
        made = (
            not isinstance(value, str)
            and callable(getattr(value, "process", None))
            and not isinstance(value, type)
        )
        if not made and (problem := config._code.problem(key, value)) is not None:
            yield problem
        elif (thing := config._code.known(value)) is None:
            continue
        elif pattern == "systems.*" and not callable(getattr(thing, "process", None)):
            fault = "not a system: it has no `process` method"
            yield Problem(key, fault, function_name(value), "a class derived from ecs_eco.System")
        elif pattern == "species.*.components.*" and not is_component(thing):
            yield Problem(
                key, "not a component", function_name(value), "a class declared with @ecs_eco.component"
            )
        elif not made and (n := ARGUMENTS.get(pattern)) is not None:
            yield from _check_call(place, entry, thing, n)


def _check_call(place: Key, entry: object, thing: Any, n: int) -> Iterator[Problem]:
    """Yield problems with a function called with n arguments, and with its parameters."""
    given = entry.parameters if isinstance(entry, Use) else {}
    problems = problems_of_parameters(thing, given, n, place) if isinstance(entry, Use) else []
    yield from problems
    if not problems and (fault := takes(thing, n, given)):
        key = (*place, "use") if isinstance(entry, Use) else place
        yield Problem(key, fault, function_name(entry), "a function as in docs/how-to/extending.md")
