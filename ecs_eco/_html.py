"""HTML tables for the output cells of notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

ROWS = 8  # maximum number of organisms shown per table
COLUMNS = 12  # maximum number of scalar fields shown


def grid(head: Sequence[object], rows: Iterable[Sequence[object]], caption: str, note: str = "") -> str:
    """Return an HTML table with a caption above and a note below; all text is escaped."""
    parts = [f"<p><b>{escape(caption)}</b></p><table><thead><tr>"]
    parts += [f"<th>{escape(str(cell))}</th>" for cell in head]
    parts.append("</tr></thead><tbody>")
    parts += [f"<tr>{''.join(f'<td>{escape(shown(cell))}</td>' for cell in row)}</tr>" for row in rows]
    parts.append(f"</tbody></table>{f'<p>{escape(note)}</p>' if note else ''}")
    return "".join(parts)


def shown(value: object) -> str:
    """Return a value as cell text: floats with six digits, integers with thousands separators."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return f"{value:,}"
    if isinstance(value, float | np.floating):
        return f"{value:.6g}"
    return "–" if value is None else str(value)


def of_entities(name: str, uid: np.ndarray, living: np.ndarray, columns: Mapping[type[Any], object]) -> str:
    """Return the first few `living` rows i64[n] of a table and their scalar fields as HTML."""
    rows = living[:ROWS]
    fields = [
        (f"{kind.__name__}.{field}", column)
        for kind, held in columns.items()
        for field in kind.fields
        if isinstance(column := getattr(held, field), np.ndarray) and column.ndim == 1
    ]
    body = [(int(uid[row]), *(column[row] for _, column in fields[:COLUMNS])) for row in rows]
    left = [f"{living.size - rows.size:,} more alive"] * (living.size > rows.size)
    left += [f"{len(fields) - COLUMNS} more fields"] * (len(fields) > COLUMNS)
    return grid(
        ("uid", *(name for name, _ in fields[:COLUMNS])),
        body,
        f"Table {name!r}: {living.size:,} alive",
        "; ".join(left),
    )
