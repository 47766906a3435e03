"""Self-contained HTML pages: the frame, tables and embedded figures that reports share."""

import re
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from string import Template

from ecs_eco.analysis.style import Figure, save_svg
from ecs_eco.analysis.svg import embedded, legible
from ecs_eco.engine import files
from ecs_eco.record.container import inside

_WORDS = re.compile(r"[^\W\d_]{3}")  # cells that begin with three letters contain text


def page(title: str, *blocks: str) -> str:
    """Return a whole page; blocks are HTML, and the title is plain text."""
    frame = Template(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))
    return frame.substitute(title=legible(escape(title)), body=legible("\n".join(blocks)))


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table; cells that are `Markup` are HTML, and all other cells are plain text."""
    held = [list(row) for row in rows]
    mark = [
        " class='words'" if any(row[i:] and _WORDS.match(str(row[i])) for row in held) else ""
        for i in range(max(map(len, [head, *held])))
    ]
    top = "".join(f"<th{m}>{_cell(x)}</th>" if x else "<td></td>" for m, x in zip(mark, head, strict=False))
    body = "\n".join(
        "<tr>" + "".join(f"<td{m}>{_cell(x)}</td>" for m, x in zip(mark, row, strict=False)) + "</tr>"
        for row in held
    )
    return f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>\n{body}\n</tbody></table></div>'


class Markup(str):
    """Text that is already HTML."""


def _cell(x: object) -> str:
    return str(x) if isinstance(x, Markup) else escape(str(x))


def drawn(figure: Figure, file: Path, caption: str) -> str:
    """Write a figure to a file and return it as HTML; it scrolls if it is wider than the screen."""
    inside(file.parent.parent, file.parent)
    svg = embedded(save_svg(figure, file).read_text(encoding="utf-8"), caption)
    return (
        f'<figure><div class="wide" tabindex="0">{svg}</div>'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def bullets(lines: Iterable[str]) -> str:
    """Return a bulleted list of plain texts."""
    return f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"


def verdict(lines: Iterable[str], lost: bool) -> str:
    """Return the opening sentences of a page; `lost` is true if a species died out."""
    text = "".join(f"<p>{escape(line)}</p>" for line in lines)
    return f"<div class='verdict{' lost' if lost else ''}'>{text}</div>"


def interval(x: Sequence[float | None] | None) -> str:
    """Return an estimate with its interval, or an en dash if it is missing."""
    if x is None or x[0] is None:
        return "–"
    return f"{number(x[0])} ({number(x[1])} to {number(x[2])})"


def number(x: float | None, digits: int = 3) -> str:
    """Format a number with significant digits and thousands separators; an en dash stands for a missing one."""
    if x is None or x != x:
        return "–"
    if x in (float("inf"), float("-inf")):
        return "∞" if x > 0 else "−∞"
    if x == 0:
        return "0"
    if float(x).is_integer() or abs(x) >= 10**digits:
        return f"{round(x):,}".replace("-", "−")
    return (f"{x:.{digits - 1}e}" if abs(x) < 1e-4 else f"{x:.{digits}g}").replace("-", "−")


def write_text(path: Path, text: str) -> Path:
    """Write a file, completely or not at all, and create its folders."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return files.write(path, text)
