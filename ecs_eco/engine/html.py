"""Worlds and tables as HTML, for the output cells of notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np

ROWS = 8  # organisms of a table that are shown
COLUMNS = 12  # fields of one number each that are shown


def grid(head: Sequence[Any], rows: Iterable[Sequence[Any]], caption: str, note: str = "") -> str:
    """Return an HTML table, with a line above and one below it; everything in it is escaped."""
    parts = [f"<p><b>{escape(caption)}</b></p><table><thead><tr>"]
    parts += [f"<th>{escape(str(cell))}</th>" for cell in head]
    parts.append("</tr></thead><tbody>")
    parts += [f"<tr>{''.join(f'<td>{escape(shown(cell))}</td>' for cell in row)}</tr>" for row in rows]
    parts.append(f"</tbody></table>{f'<p>{escape(note)}</p>' if note else ''}")
    return "".join(parts)


def shown(value: Any) -> str:
    """Return a value as a cell: six digits of a fraction, thousands of whole numbers apart."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return f"{value:,}"
    if isinstance(value, float | np.floating):
        return f"{value:.6g}"
    return "–" if value is None else str(value)


def of_world(world: Any) -> str:
    """Return a world: its clock, and a row for each table."""
    size = " × ".join(f"{side:g}" for side in getattr(getattr(world, "space", None), "size", ()))
    caption = f"World {world.name!r} at tick {world.tick:,}, seed {world.seed}{f', {size} m' if size else ''}"
    rows = [
        (name, table.n, ", ".join(kind.__name__ for kind in table.columns))
        for name, table in world.tables.items()
    ]
    return grid(("table", "alive", "components"), rows, caption)


def of_table(table: Any) -> str:
    """Return a table: the first of its living, with their fields of one number each."""
    rows = np.flatnonzero(table.alive)[:ROWS]
    fields = [
        (f"{kind.__name__}.{field}", column)
        for kind, columns in table.columns.items()
        for field in kind.fields
        if isinstance(column := getattr(columns, field), np.ndarray) and column.ndim == 1
    ]
    body = [(int(table.uid[row]), *(column[row] for _, column in fields[:COLUMNS])) for row in rows]
    left = [f"{table.n - rows.size:,} more alive"] * (table.n > rows.size)
    left += [f"{len(fields) - COLUMNS} more fields"] * (len(fields) > COLUMNS)
    return grid(
        ("uid", *(name for name, _ in fields[:COLUMNS])),
        body,
        f"Table {table.name!r}: {table.n:,} alive",
        "; ".join(left),
    )
