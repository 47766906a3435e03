"""Checks of the code that a world names: listed and, once it may run, of the right kind. It is not called."""

from collections.abc import Iterator
from fnmatch import fnmatchcase
from typing import Any

from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.names import Key, is_component, used_in
from ecs_eco.engine.arguments import takes
from ecs_eco.engine.code import SHIPPED
from ecs_eco.engine.errors import Problem
from ecs_eco.engine.parameters import problems_of_parameters
from ecs_eco.engine.section import Use, function_name

ARGUMENTS = {  # by key, the number of arguments of a function; None: it is checked elsewhere, or not called
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
    """All problems of the functions, systems and components that a world names, and of their parameters."""
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
            yield Problem(
                key,
                "no system: it has no method process",
                function_name(value),
                "a class derived from ecs_eco.System",
            )
        elif pattern == "species.*.components.*" and not is_component(thing):
            yield Problem(
                key, "no component", function_name(value), "a class declared with @ecs_eco.component"
            )
        elif not made and (n := ARGUMENTS.get(pattern)) is not None:
            yield from _check_call(place, entry, thing, n)


def _check_call(place: Key, entry: Any, thing: Any, n: int) -> Iterator[Problem]:
    """Problems of a function that is called with n arguments, and of its parameters."""
    given = entry.parameters if isinstance(entry, Use) else {}
    problems = problems_of_parameters(thing, given, n, place) if isinstance(entry, Use) else []
    yield from problems
    if not problems and (fault := takes(thing, n, given)):
        key = (*place, "use") if isinstance(entry, Use) else place
        yield Problem(key, fault, function_name(entry), "a function as docs/how-to/extending.md shows it")
