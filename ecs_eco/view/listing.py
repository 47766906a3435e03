"""Organisms as a sorted and filtered table, and as points whose coordinates are two of their values."""

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ecs_eco.engine.errors import nearest
from ecs_eco.view.source import Message, is_whole, short

STATES = ("energy", "happiness", "age")
ROWS, POINTS = 100, 500  # maximum number of rows in a table, and of points per species
TERM = re.compile(r"\s*([\w:.#]+)\s*(<=|>=|!=|=|<|>)\s*([-+]?[\d.]+(?:e[-+]?\d+)?)\s*", re.IGNORECASE)
HOLDS: dict[str, Callable[[Any, float], np.ndarray]] = {
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "=": np.equal,
    "!=": np.not_equal,
}
Columns = dict[str, np.ndarray]


def table(of: Callable[[str], Columns], species: Sequence[str], request: Message) -> Message:
    """Return the message "table": sorted rows that match `where`; ValueError for an unknown column or bad term."""
    name = one_of("species", request.get("species"), species)
    columns = of(name)
    sort = one_of("sort", request.get("sort", "uid"), list(columns))
    rows = kept(columns, request.get("where") or "")
    order = rows[np.argsort(columns[sort][rows], kind="stable")]  # unknown values are last
    known = order.size - np.count_nonzero(np.isnan(columns[sort][rows].astype(np.float64)))
    if request.get("down"):
        order[:known] = order[:known][::-1].copy()
    first = request.get("from", 0)
    if not is_whole(first):
        raise ValueError(f"table: from = {short(first)}; expected a whole number, 0 or more")
    shown = order[first : first + ROWS]
    return {
        "kind": "table",
        "species": name,
        "sort": sort,
        "down": bool(request.get("down")),
        "from": first,
        "n": int(columns["uid"].size),
        "found": int(order.size),
        "where": request.get("where") or "",
        "columns": {key: _plain(column[shown]) for key, column in columns.items()},
    }


def scatter(of: Callable[[str], Columns], species: Sequence[str], request: Message) -> Message:
    """Return the message "scatter": two values of up to POINTS organisms of each species that has both."""
    points: dict[str, Any] = {}
    names: dict[str, None] = {}
    for name in species:
        columns = of(name)
        names |= dict.fromkeys(columns)
        x, y = (columns.get(str(request.get(axis))) for axis in "xy")
        if x is None or y is None:
            continue
        there = np.flatnonzero(np.isfinite(x.astype(np.float64)) & np.isfinite(y.astype(np.float64)))
        there = there[:: max(1, -(-there.size // POINTS))]
        if there.size:
            points[name] = {
                key: _plain(column[there]) for key, column in {"x": x, "y": y, "uid": columns["uid"]}.items()
            }
    for axis in "xy":
        one_of(axis, request.get(axis), list(names))
    return {
        "kind": "scatter",
        "x": request["x"],
        "y": request["y"],
        "points": points,
        "names": [name for name in names if name != "uid"],
    }


def one_of(field: str, value: object, known: Sequence[str]) -> str:
    """Return a value if it is one of `known`; otherwise raise ValueError."""
    if value not in known:
        raise ValueError(
            f"{field} = {short(value)}; expected {', '.join(known)}; did you mean {nearest(value, known)!r}?"
        )
    return str(value)


def kept(columns: Columns, where: object) -> np.ndarray:
    """Return the rows i64[k] that satisfy all comparisons: "energy < 0.3, age > 100"."""
    keep = np.ones(columns["uid"].size, np.bool_)
    for term in re.split(r",|\band\b|&", where) if isinstance(where, str) and where.strip() else []:
        match = TERM.fullmatch(term)
        if match is None:
            raise ValueError(
                f"where = {short(term.strip())}; expected comparisons such as energy < 0.3, age > 100"
            )
        column = columns[one_of("where", match[1], list(columns))]
        try:
            value = float(match[3])
        except ValueError:
            raise ValueError(f"where = {short(term.strip())}: {match[3]!r} is not a number") from None
        keep &= HOLDS[match[2]](column, value)
    return np.flatnonzero(keep)


def _plain(column: np.ndarray) -> list[float | int | None]:
    """Return a column for JSON: integers unchanged, floats with five digits, None for unknown values."""
    if column.dtype.kind in "iu":
        return [int(value) for value in column]
    return [float(f"{value:.5g}") if np.isfinite(value) else None for value in column.tolist()]
