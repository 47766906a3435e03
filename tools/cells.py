"""Values and tables as Markdown, in the pages' typography: 0.5 (0.4 to 0.6), −0.5, 95%."""

import re
from typing import Any

TYPOGRAPHY = (
    (re.compile(r"(?<=[\d.]) … (?=[-−\d])"), " to "),  # bounds of an interval
    (re.compile(r"\[(-?[\d.]+), (-?[\d.]+)\]"), r"(\1 to \2)"),
    (re.compile(r"(?<![\d.\w/])\.(?=\d)"), "0."),
    (re.compile(r"(?<=\d) %"), "%"),
    (re.compile(r"(?<![\w.-])-(?=\d)"), "−"),
    (re.compile(r"\blearnt\b"), "learned"),
    (re.compile(r"≥ "), "at least "),
    (re.compile(r">= "), "at least "),
    (re.compile(r"<= "), "at most "),
    (re.compile(r"≤ "), "at most "),
)


def text(x: Any) -> str:
    """Return a value as a cell of a Markdown table; three numbers are an estimate with its interval."""
    if x is None:
        return "–"
    if isinstance(x, bool):
        return "yes" if x else "no"
    if isinstance(x, float):
        return (f"{x:.3g}" if abs(x) < 1000 else f"{x:,.0f}").replace("-", "−", 1)
    if isinstance(x, list):
        if len(x) == 3 and isinstance(x[0], int | float) and x[1] is None:
            return f"{text(x[0])} (no interval)"
        numbers = all(isinstance(v, int | float) for v in x)
        return (
            f"{text(x[0])} ({text(x[1])} to {text(x[2])})"
            if len(x) == 3 and numbers
            else ", ".join(map(text, x))
        )
    return str(x).replace("|", "\\|").replace("\n", " ")


def typeset(words: str) -> str:
    """Return stored text in the pages' typography."""
    for pattern, by in TYPOGRAPHY:
        words = pattern.sub(by, words)
    return words


def shown(x: Any) -> str:
    """Return a stored value in the pages' typography."""
    return typeset(x if isinstance(x, str) else text(x))


def table(head: list[str], rows: list[list[Any]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(text(x) for x in line) + " |" for line in lines)
