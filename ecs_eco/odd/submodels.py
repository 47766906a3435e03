"""Element 7 of the ODD: each submodel with its equations and its parameter values in this world."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Sequence

from ecs_eco.engine.comments import comments_of
from ecs_eco.engine.system import System
from ecs_eco.inputs.section import NAMED, Section, Use
from ecs_eco.odd.document import Block, Heading, Items, grid
from ecs_eco.odd.model import Model, Part, is_built_in
from ecs_eco.odd.values import Value, applies, first_sentence, lists_of, sentences, shown, values_of

WIDEST = 6  # maximum number of kind columns in a parameter table
FEW = 5  # maximum number of words in a docstring that serves only as a heading


def submodels(model: Model) -> Iterator[Block]:
    """Yield the submodels that this world uses."""
    yield (
        "Each submodel is described by the declarations in its code and this world's values. Values that are not "
        "listed, or marked –, are 0 or absent. Each world defines its own unit of energy."
    )
    described: set[tuple[str, str]] = set()
    for title, parts in model.parts.items():
        yield Heading(3, title)
        yield from (_carried_out(part.system) for part in parts if part.system is not None)
        if rules := tuple(dict.fromkeys(rule for part in parts for rule in _rules(model, part))):
            yield Items(rules)
        wanted = [(kind, key) for part in parts for key in model.keys(part) for kind in ("", *part.kinds)]
        yield from parameters(model, [one for one in dict.fromkeys(wanted) if one not in described])
        described.update(wanted)
        for part in parts:
            if part.system is not None and not is_built_in(part.system):
                yield from _own_values(part.system)


def _carried_out(system: System) -> str:
    """Return a description of a system; for a custom system, its whole docstring."""
    kind = type(system)
    text = sentences(kind, whole=system.submodel is None)
    return f"`{kind.__name__}`: {text or 'its class has no docstring.'}"


def _rules(model: Model, part: Part) -> Iterator[str]:
    for condition, rule in part.submodel.rules.items():
        kinds = [k for k in part.kinds if applies(condition, model.places(k), model.world.tables[k])]
        if kinds:
            some = len(kinds) < len(part.kinds) and bool(condition)
            yield f"{', '.join(kinds)}: {rule}" if some else rule


def parameters(model: Model, wanted: Sequence[tuple[str, str]]) -> Iterator[Block]:
    """Yield tables of the values at pairs (kind, key), single values first; kind "" is the world."""
    holders = {} if model.config is None else {"": model.config}
    held: dict[str, dict[str, Value]] = {}
    entries: dict[type[Section], list[tuple[str, str, Section]]] = {}
    for name, section in (holders | model.sections).items():
        held[name] = {v.key: v for v in values_of(section) if _wanted(name, v.key, wanted)}
        for key, listed in lists_of(section):
            for label, entry in listed if _wanted(name, key, wanted) else ():
                entries.setdefault(type(entry), []).append((name, f"{key}.{label}", entry))
    for world in (True, False):
        yield from _side_by_side({name: v for name, v in held.items() if v and (not name) == world})
    for kind, rows in entries.items():
        yield from _listed(kind, rows)
    values = [value for one in held.values() for value in one.values()]
    values += [value for rows in entries.values() for *_, entry in rows for value in values_of(entry)]
    if named := tuple(dict.fromkeys(_functions(model, values))):
        yield Items(named)


def _functions(model: Model, values: list[Value]) -> Iterator[str]:
    """Yield the functions that values refer to, each with the first sentence of its docstring."""
    for one in [value.value for value in values]:
        if model.config is not None and (isinstance(one, Use) or re.fullmatch(NAMED, str(one))):
            function = model.config.known(one)
            if function is not None and function.__doc__:
                yield f"`{shown(one)}`: {first_sentence(function)}"


def _wanted(kind: str, key: str, wanted: Sequence[tuple[str, str]]) -> bool:
    return any(kind == one and (key == path or key.startswith(f"{path}.")) for one, path in wanted)


def _side_by_side(held: dict[str, dict[str, Value]]) -> Iterator[Block]:
    """Yield tables with a row for each parameter and a column for each kind."""
    names = list(held)
    for first in range(0, len(names), WIDEST):
        some = names[first : first + WIDEST]
        known: dict[str, Value] = {}
        for name in some:
            known |= {key: one for key, one in held[name].items() if key not in known}
        rows, before = [], ""
        for key, one in known.items():
            cells = (_cell(held[name].get(key)) for name in some)
            rows.append((f"`{key}`", one.unit, *cells, "" if one.text == before else one.text))
            before = one.text
        yield from grid(("parameter", "unit", *(name or "value" for name in some), "meaning"), rows)


def _cell(value: Value | None) -> str:
    if value is None:
        return "–"
    text = shown(value.value)
    return f"`{text}`" if isinstance(value.value, str) and not text.isidentifier() else text


def _listed(kind: type[Section], rows: list[tuple[str, str, Section]]) -> Iterator[Block]:
    """Yield a table of all list entries of one model, and the meanings of its columns."""
    if len(sentences(kind).split()) > FEW:
        yield sentences(kind)
    values = [{v.key: v for v in values_of(entry) if v.key not in ("name", "label")} for _, _, entry in rows]
    columns = {key: one for row in values for key, one in row.items()}
    head = (f"{key} [{one.unit}]" if one.unit else key for key, one in columns.items())
    lines = []
    for (name, label, _), row in zip(rows, values, strict=True):
        lines.append((name, f"`{label}`", *(_cell(row[key]) if key in row else "" for key in columns)))
    yield from grid(("kind", "entry", *head), lines)
    if meanings := tuple(f"`{key}`: {one.text}" for key, one in columns.items() if one.text):
        yield Items(meanings)


def _own_values(system: System) -> Iterator[Block]:
    """Yield a custom system's numbers, with their comments: its attributes and the module's constants."""
    kind, module, rows = type(system), inspect.getmodule(type(system)), list[tuple[str, ...]]()
    known = comments_of(module) | comments_of(kind)  # type: ignore[arg-type]
    read = {n for one in vars(kind).values() if inspect.isfunction(one) for n in one.__code__.co_names}
    constants = {name: value for name, value in vars(module).items() if name in read}
    for name, value in {**constants, **vars(kind), **vars(system)}.items():
        if not name.startswith("_") and _is_number(value) and name != "priority":
            unit, text = known.get(name, ("", ""))
            rows.append((f"`{name}`", unit, shown(value), text))
    yield from grid(("parameter", "unit", "value", "meaning"), rows)


def _is_number(value: object) -> bool:
    if isinstance(value, tuple):
        return bool(value) and all(map(_is_number, value))
    return isinstance(value, int | float) and not isinstance(value, bool)
