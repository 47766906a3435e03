"""One self-contained HTML page: the frame, tables and embedded figures that reports share."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from string import Template

from ecs_eco.engine import files


def page(title: str, *blocks: str) -> str:
    """The whole page; blocks are HTML, the title is plain text."""
    frame = Template(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))
    return frame.substitute(title=escape(title), body="\n".join(blocks))


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table; cells that are `Markup` are HTML, all others plain text."""
    top = "".join(f"<th>{_cell(x)}</th>" for x in head)
    body = "\n".join("<tr>" + "".join(f"<td>{_cell(x)}</td>" for x in row) + "</tr>" for row in rows)
    return f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>\n{body}\n</tbody></table></div>'


class Markup(str):
    """Text that is HTML already."""


def _cell(x: object) -> str:
    return str(x) if isinstance(x, Markup) else escape(str(x))


def picture(png: Path, caption: str) -> str:
    """A figure with the PNG, or SVG, embedded, so that the page needs no other file."""
    code = base64.b64encode(png.read_bytes()).decode("ascii")
    kind = "svg+xml" if png.suffix == ".svg" else "png"
    text = escape(caption)
    return (f'<figure><img alt="{text}" '
            f'src="data:image/{kind};base64,{code}"><figcaption>{text}</figcaption></figure>')


def number(x: float, digits: int = 3) -> str:
    """A number for readers: significant digits, thousands separated, an en dash for a missing one."""
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
    """Write a file completely or not at all; make its folders."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return files.write(path, text)
