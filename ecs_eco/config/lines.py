"""Finds the line of each key in a TOML text, and the characters of its value, which tomllib does not report."""

from __future__ import annotations

import re
from collections.abc import Iterator

Key = tuple[str | int, ...]
TOKEN = re.compile(
    r'(?P<text>"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\')'
    r"|(?P<comment>#[^\n]*)|(?P<line>\n)|(?P<space>[ \t\r]+)"
    r"|(?P<mark>\[\[|\]\]|[\[\]{}=,.])|(?P<bare>[^\s\"'#\[\]{}=,.]+)",
    re.DOTALL,
)


def key_lines(text: str) -> dict[Key, int]:
    """Line (from 1) of every key and list entry in valid TOML, by its full key."""
    return _walked(_Tokens(text))


def value_spans(text: str) -> dict[Key, tuple[int, int]]:
    """First character of the value of every key and entry, and the one after it; of a [header], its ends."""
    tokens = _Tokens(text)
    _walked(tokens)
    return tokens.spans


def _walked(tokens: _Tokens) -> dict[Key, int]:
    line_of: dict[Key, int] = {}
    table: Key = ()
    counts: dict[Key, int] = {}
    while tokens.peek() is not None:
        if tokens.peek() in ("[", "[["):
            double, line, begin = tokens.peek() == "[[", tokens.line, tokens.begin
            tokens.take()
            table = _within(tokens.key(), counts)
            if double:
                counts[table] = counts.get(table, -1) + 1
                line_of.setdefault(table, line)
                table = (*table, counts[table])
            for end in range(1, len(table) + 1):
                line_of.setdefault(table[:end], line)
            tokens.take()
            tokens.spans.setdefault(table, (begin, tokens.end))
        else:
            _pair(tokens, table, line_of)
    return line_of


def _within(key: Key, counts: dict[Key, int]) -> Key:
    """The key of a header with the index of the last entry after each list of tables it passes through."""
    full: Key = ()
    for i, part in enumerate(key):
        full = (*full, part)
        if i < len(key) - 1 and full in counts:
            full = (*full, counts[full])
    return full


def _pair(tokens: _Tokens, table: Key, line_of: dict[Key, int]) -> None:
    line = tokens.skip_lines()
    key = (*table, *tokens.key())
    for end in range(len(table) + 1, len(key) + 1):
        line_of.setdefault(key[:end], line)
    tokens.take()  # =
    _value(tokens, key, line_of)


def _value(tokens: _Tokens, key: Key, line_of: dict[Key, int]) -> None:
    opening = tokens.peek()
    begin = tokens.begin
    if opening in ("[", "[["):  # the scanner may take two opening brackets for one token
        if opening == "[[":
            tokens.split()
        tokens.take()
        index = 0
        while tokens.inside("]"):
            line_of.setdefault((*key, index), tokens.skip_lines())
            _value(tokens, (*key, index), line_of)
            index += 1
            tokens.drop(",")
        tokens.take()
    elif opening == "{":
        tokens.take()
        while tokens.inside("}"):
            _pair(tokens, key, line_of)
            tokens.drop(",")
        tokens.take()
    else:  # a scalar: everything up to the end of the line or the entry
        while tokens.raw() not in (None, "\n", ",", "]", "]]", "}"):
            tokens.step()
    tokens.spans[key] = begin, tokens.end


class _Tokens:
    """The tokens of a text, with the line of the one ahead."""

    def __init__(self, text: str) -> None:
        self._all = list(self._scan(text))
        self._at = 0
        self.spans: dict[Key, tuple[int, int]] = {}

    @staticmethod
    def _scan(text: str) -> Iterator[tuple[str, str, int, int]]:
        line = 1
        for match in TOKEN.finditer(text):
            if match.lastgroup not in ("comment", "space"):
                yield match.lastgroup or "", match.group(), line, match.start()
            line += match.group().count("\n")

    @property
    def line(self) -> int:
        return self._all[self._at][2] if self._at < len(self._all) else 0

    @property
    def begin(self) -> int:
        """The first character of the token ahead."""
        return self._all[self._at][3]

    @property
    def end(self) -> int:
        """The character after the last token taken."""
        _, text, _, begin = self._all[self._at - 1]
        return begin + len(text)

    def raw(self) -> str | None:
        """The token ahead, which may be the end of a line."""
        return self._all[self._at][1] if self._at < len(self._all) else None

    def step(self) -> None:
        self._at += 1

    def skip_lines(self) -> int:
        """Passes ends of lines; the line of the token ahead."""
        while self.raw() == "\n":
            self.step()
        return self.line

    def peek(self) -> str | None:
        self.skip_lines()
        return self.raw()

    def take(self) -> str:
        text = self.peek() or ""
        self.step()
        return text

    def drop(self, mark: str) -> None:
        if self.peek() == mark:
            self.step()

    def split(self) -> None:
        """Takes the double bracket ahead for two single ones."""
        kind, text, line, begin = self._all[self._at]
        self._all[self._at : self._at + 1] = [(kind, text[0], line, begin), (kind, text[1], line, begin + 1)]

    def inside(self, closing: str) -> bool:
        """Whether the list or table goes on."""
        if self.peek() == closing * 2 and closing == "]":
            self.split()
        return self.peek() not in (closing, None)

    def key(self) -> Key:
        """A dotted key."""
        parts = [self._part()]
        while self.peek() == ".":
            self.step()
            parts.append(self._part())
        return tuple(parts)

    def _part(self) -> str:
        text = self.take()
        return text[1:-1] if text[:1] in ("'", '"') else text
