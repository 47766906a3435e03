"""A document with headings, paragraphs, lists and tables, rendered as Markdown or HTML."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple

from ecs_eco.analysis import page

_CODE = re.compile(r"(`[^`]+`)")


class Heading(NamedTuple):
    """A heading with its level, 1 for the title."""

    level: int
    text: str


class Items(NamedTuple):
    """A bulleted list."""

    texts: tuple[str, ...]


class Grid(NamedTuple):
    """A table; empty cells are marked as empty."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


Block = Heading | Items | Grid | str
"""A part of a document; a string is a paragraph, with `code` between backticks."""


class Document(list[Block]):
    """Blocks in order."""

    def markdown(self) -> str:
        """Return the document as Markdown."""
        return "\n\n".join(map(_markdown, self)) + "\n"

    def html(self) -> str:
        """Return the document as one self-contained HTML page."""
        title = next((block.text for block in self if isinstance(block, Heading)), "ODD")
        return page.page(title, *map(_html, self))

    def _repr_html_(self) -> str:
        return "\n".join(map(_html, self))


def grid(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[Block]:
    """Yield a table, omitting columns whose cells are all empty; yield nothing if there are no rows."""
    held = [tuple(row) for row in rows]
    kept = [i for i in range(len(head)) if any(row[i] for row in held)]
    if not kept:
        return []
    return [Grid(tuple(head[i] for i in kept), tuple(tuple(row[i] for i in kept) for row in held))]


def _markdown(block: Block) -> str:
    if isinstance(block, Heading):
        return f"{'#' * block.level} {_plain(block.text)}"
    if isinstance(block, Items):
        return "\n".join(f"- {_plain(text)}" for text in block.texts)
    if isinstance(block, Grid):
        rows = [block.head, ("---",) * len(block.head), *block.rows]
        return "\n".join(
            f"| {' | '.join(_plain(c).replace('|', chr(92) + '|') for c in row)} |" for row in rows
        )
    return _plain(block)


def _plain(text: str) -> str:
    """Escape Markdown syntax in text, except in code."""
    parts = _CODE.split(" ".join(text.split()))
    return "".join(
        p if i % 2 else re.sub(r"[*<]|\[(?=[^]]*\]\()|(?<!\w)_", r"\\\g<0>", p) for i, p in enumerate(parts)
    )


def _html(block: Block) -> str:
    if isinstance(block, Heading):
        return f"<h{block.level}>{_inline(block.text)}</h{block.level}>"
    if isinstance(block, Items):
        return f"<ul>{''.join(f'<li>{_inline(text)}</li>' for text in block.texts)}</ul>"
    if isinstance(block, Grid):
        table = page.table(block.head, [[page.Markup(_inline(cell)) for cell in row] for row in block.rows])
        return re.sub(r"<t([dh])>", r"<t\1 class='words'>", table)  # all columns are aligned left
    return f"<p>{_inline(block)}</p>"


def _inline(text: str) -> str:
    parts = _CODE.split(" ".join(text.split()))
    return "".join(f"<code>{escape(p[1:-1])}</code>" if i % 2 else escape(p) for i, p in enumerate(parts))
