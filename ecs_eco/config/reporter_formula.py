"""Formulas of reporters: numbers computed from the fields of components over all living organisms.

`mean(Metabolism.energy)` gives a number per species, `mean(wolf.Metabolism.energy)` one for the world. Within
the parentheses, the language is the same as in formula.py, with fields instead of sensors. All numbers are
float64, and organisms are sorted by uid, so results do not depend on row order.
"""

import ast
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

import numpy as np

from ecs_eco.config.formula import FUNCTIONS, Compiler, FormulaError, Node, compiled
from ecs_eco.engine.errors import listed, nearest

NONE = float("nan")  # result if there are no values


def _of_some(function: Callable[..., Any]) -> Callable[..., Any]:
    return lambda x, *more: function(x, *more) if x.size else NONE


AGGREGATES: dict[str, Callable[..., Any]] = {
    "mean": _of_some(np.mean),
    "sum": np.sum,
    "min": _of_some(np.min),
    "max": _of_some(np.max),
    "median": _of_some(np.median),
    "std": _of_some(np.std),
    "quantile": _of_some(np.quantile),
    "count": np.count_nonzero,
}
ALLOWED = (
    f"{', '.join(AGGREGATES)} of Component.field or species.Component.field, count() and "
    "count(species); numbers, + - * / **, comparisons, and, or, not, a if b else c, "
    f"{', '.join(f for f in FUNCTIONS if f not in AGGREGATES)}"
)
USUAL = ("Metabolism", "Body", "Biology", "Nervous", "Position")  # searched first for a bare field name
Field = tuple[str | None, str, str]  # species, or None for every species; component; field
Fields = Mapping[str, Mapping[str, Any]]  # component: its fields, as in `component.fields`


class Living:
    """The living organisms of one table, sorted by uid, for formulas to read."""

    def __init__(self, table: Any) -> None:
        self._rows, self._columns = table.by_uid(), {c.__name__: v for c, v in table.columns.items()}
        self.n = self._rows.size

    def has(self, component: str, field: str) -> bool:
        """Return whether these organisms have the field."""
        return hasattr(self._columns.get(component), field)

    def __getitem__(self, name: tuple[str, str]) -> np.ndarray:
        component, field = name
        return np.asarray(getattr(self._columns[component], field)[self._rows], np.float64)


class Scope:
    """The organisms that names in a formula refer to; None is the species that the number describes."""

    def __init__(self, tables: Mapping[str, Any]) -> None:
        self.own: str | None = None
        self._tables, self._living = tables, dict[str, Living]()

    def __getitem__(self, name: str | None) -> Living:
        kind = self.own if name is None else name
        assert kind is not None
        if kind not in self._living:
            self._living[kind] = Living(self._tables[kind])
        return self._living[kind]


class ReporterFormula:
    """A compiled formula, called with the living organisms and the species that its number can describe.

    `fields` are the fields that the formula reads. It returns one number or, if `each`, one for each species
    that has all the fields.
    """

    def __init__(self, text: str, run: Node, fields: frozenset[Field], each: bool) -> None:
        self.text, self.fields, self.each, self._run = text, fields, each, run

    def __call__(self, scope: Scope, species: Iterable[str]) -> float | dict[str, float]:
        """Return the number for the world, or a number for each species that has the fields."""
        if not self.each:
            return self._number(scope)
        out = {}
        for scope.own in species:
            if all(scope[None].has(component, field) for of, component, field in self.fields if of is None):
                out[scope.own] = self._number(scope)
        return out

    def _number(self, scope: Scope) -> float:
        with np.errstate(all="ignore"):
            return float(self._run(scope))


def compile_reporter(
    text: str, kinds: Collection[str], fields: Fields, complete: bool = True
) -> ReporterFormula:
    """Compile the text of a reporter in a world with these species and object types.

    `fields` are the fields of all components; unless they are `complete`, the text can name other fields.
    Raises FormulaError if a name is unknown or anything else is not allowed.
    """
    run, compiler = compiled(text, lambda line, lead: _Compiler(line, lead, kinds, fields, complete))
    if not compiler.aggregates:
        raise FormulaError("no aggregate function", 1, "at least one of " + listed(AGGREGATES))
    return ReporterFormula(text, run, frozenset(compiler.fields), compiler.each)


class _Compiler(Compiler):
    """Convert a syntax tree into functions of a Scope and, within an aggregate, of Living organisms."""

    dtype = np.float64
    allowed = ALLOWED

    def __init__(self, line: str, lead: int, kinds: Collection[str], known: Fields, complete: bool) -> None:
        super().__init__(line, lead, ())
        self.kinds, self.known, self.complete = kinds, known, complete
        self.fields, self.aggregates, self.each = set[Field](), 0, False
        self.within: set[str | None] | None = None  # within an aggregate, the species whose fields are read

    def _call(self, tree: ast.Call) -> Node:
        name = tree.func.id if isinstance(tree.func, ast.Name) else ""
        one = len(tree.args) == 1 and not tree.keywords
        if name not in AGGREGATES or (name in FUNCTIONS and not one):
            if name not in FUNCTIONS:
                known = [*AGGREGATES, *FUNCTIONS]
                raise self._error(f'unknown function "{name}"', tree, listed(known, 20), nearest(name, known))
            return super()._call(tree)
        if self.within is not None:
            raise self._error(
                f"{name} within another aggregate", tree, "separate aggregates, as in mean(x) / max(x)"
            )
        self.aggregates += 1
        whole = not tree.keywords and (not tree.args or (one and isinstance(tree.args[0], ast.Name)))
        return self._count(tree) if name == "count" and whole else self._aggregate(tree, name)

    def _count(self, tree: ast.Call) -> Node:
        """Return a function that counts the species that the number describes, or a named kind."""
        of = tree.args[0].id if tree.args else None  # type: ignore[attr-defined]
        if of is not None and of not in self.kinds:
            fault = f'no species or object type named "{of}"'
            allowed = f"{listed(self.kinds, 30)}; or a condition, as in count(Metabolism.energy > 1)"
            raise self._error(fault, tree.args[0], allowed, nearest(of, self.kinds))
        self.each |= of is None
        return lambda scope: scope[of].n

    def _aggregate(self, tree: ast.Call, name: str) -> Node:
        function = AGGREGATES[name]
        wanted = 2 if name == "quantile" else 1
        if tree.keywords or len(tree.args) != wanted:
            fault = f"{len(tree.args)} arguments for {name}"
            raise self._error(fault, tree, "quantile(values, share)" if wanted == 2 else f"{name}(values)")
        more = [self._share(share) for share in tree.args[1:]]
        self.within = set()
        values, of = self.node(tree.args[0]), self.within
        self.within = None
        if len(of) != 1:
            fault = "fields of more than one species in one aggregate" if of else "no field inside"
            raise self._error(
                f"{name}: {fault}", tree, "Component.field, or species.Component.field of a single species"
            )
        (owner,) = of
        self.each |= owner is None

        return lambda scope: function(np.broadcast_to(values(scope[owner]), scope[owner].n), *more)

    def _share(self, tree: ast.AST) -> float:
        value = tree.value if isinstance(tree, ast.Constant) else None
        if not isinstance(value, int | float) or not 0 <= value <= 1:
            raise self._error(
                "quantile needs a proportion", tree, "a number from 0 to 1, as in quantile(x, 0.9)"
            )
        return float(value)

    def _name(self, tree: ast.Name) -> Node:
        if tree.id in self.known:
            fields = self._numbers_of(tree.id)
            fault, allowed = f"{tree.id} is a component", f"one of its fields: {listed(fields)}"
            raise self._error(fault, tree, allowed, f"{tree.id}.{fields[0]}" if fields else "")
        named = [f"{c}.{f}" for c in (*USUAL, *self.known) for f in self.known.get(c, ())]
        exact = [name for name in named if name.endswith(f".{tree.id}")]
        fault, allowed = f'unknown name "{tree.id}"', "Component.field, or species.Component.field"
        raise self._error(fault, tree, allowed, exact[0] if exact else nearest(tree.id, named))

    def _attribute(self, tree: ast.Attribute) -> Node:
        parts = _parts(tree)
        if not 2 <= len(parts) <= 3:
            fault = f'"{ast.unparse(tree):.60}" is not a field'
            raise self._error(fault, tree, "Component.field, or species.Component.field")
        owner, (component, field) = parts[0] if len(parts) == 3 else None, parts[-2:]
        if owner is not None and owner not in self.kinds:
            fault = f'no species or object type named "{owner}"'
            raise self._error(fault, tree, listed(self.kinds, 30), nearest(owner, self.kinds))
        self._check_field(tree, component, field)
        if self.within is None:
            text = ".".join(parts)
            allowed = f"mean({text}), sum({text}), …"
            raise self._error(f"{text} has a value for each organism", tree, allowed)
        self.within.add(owner)
        self.fields.add((owner, component, field))
        return lambda living: living[component, field]

    def _check_field(self, tree: ast.AST, component: str, field: str) -> None:
        if component not in self.known:
            if self.complete:
                close = nearest(component, self.known)
                raise self._error(f'unknown component "{component}"', tree, listed(self.known, 50), close)
        elif field not in self.known[component]:
            fields = self._numbers_of(component)
            raise self._error(
                f'{component} has no field "{field}"', tree, listed(fields, 30), nearest(field, fields)
            )
        elif field not in self._numbers_of(component):
            allowed = f"fields with one number: {listed(self._numbers_of(component), 30)}"
            raise self._error(f"{component}.{field} has more than one number", tree, allowed)

    def _numbers_of(self, component: str) -> list[str]:
        return [name for name, (kind, _) in self.known[component].items() if not kind.shape]


def _parts(tree: ast.AST) -> tuple[str, ...]:
    if isinstance(tree, ast.Attribute):
        return (*_parts(tree.value), tree.attr)
    return (tree.id,) if isinstance(tree, ast.Name) else ("",) * 4
