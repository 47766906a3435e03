"""Find the line of each key in TOML text and the position of its value, which tomllib does not report."""

import re

from ecs_eco.config.rules import Key

TOKEN = re.compile(
    r'(?P<text>"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\')'
    r"|(?P<comment>#[^\n]*)|(?P<line>\n)|(?P<space>[ \t\r]+)"
    r"|(?P<mark>[\[\]{}=,.])|(?P<bare>[^\s\"'#\[\]{}=,.]+)",
    re.DOTALL,
)


def key_lines(text: str) -> dict[Key, int]:
    """Return the line (from 1) of every key and list entry in valid TOML, by full key."""
    return _Reader(text).lines


def value_spans(text: str) -> dict[Key, tuple[int, int]]:
    """Return the start and end of every value, as character positions, by key."""
    return _Reader(text).spans


class _Reader:
    """Read a text once, token by token, and record the lines and spans of its keys."""

    def __init__(self, text: str) -> None:
        self.lines: dict[Key, int] = {}
        self.spans: dict[Key, tuple[int, int]] = {}
        self._tokens: list[
            tuple[str, int, int, int]
        ] = []  # text, line, first character, character after the last
        self._at, line = 0, 1
        for match in TOKEN.finditer(text):
            if match.lastgroup not in ("comment", "space"):
                self._tokens.append((match.group(), line, match.start(), match.end()))
            line += match.group().count("\n")
        table: Key = ()
        counts: dict[Key, int] = {}  # index of the last entry in each list of tables
        while (ahead := self._ahead()) is not None:
            if ahead == "[":
                table = self._header(counts)
            else:
                self._pair(table)

    def _ahead(self) -> str | None:
        """Return the next token, skipping line ends."""
        while self._at < len(self._tokens) and self._tokens[self._at][0] == "\n":
            self._at += 1
        return self._tokens[self._at][0] if self._at < len(self._tokens) else None

    def _header(self, counts: dict[Key, int]) -> Key:
        _, line, begin, _ = self._tokens[self._at]
        double = self._tokens[self._at + 1][0] == "["
        self._at += 1 + double
        table: Key = ()
        parts = self._key()
        for i, part in enumerate(parts):
            table = (*table, part)
            if i < len(parts) - 1 and table in counts:
                table = (*table, counts[table])
        if double:
            counts[table] = counts.get(table, -1) + 1
            self.lines.setdefault(table, line)
            table = (*table, counts[table])
        for end in range(1, len(table) + 1):
            self.lines.setdefault(table[:end], line)
        self._at += 1 + double
        self.spans.setdefault(table, (begin, self._tokens[self._at - 1][3]))
        return table

    def _pair(self, table: Key) -> None:
        line = self._tokens[self._at][1]
        key = (*table, *self._key())
        for end in range(len(table) + 1, len(key) + 1):
            self.lines.setdefault(key[:end], line)
        self._at += 1  # =
        self._value(key)

    def _value(self, key: Key) -> None:
        opening, begin, index = self._ahead(), self._tokens[self._at][2], 0
        if opening in ("[", "{"):
            self._at += 1
            while self._ahead() not in ("]", "}", None):
                if opening == "{":
                    self._pair(key)
                else:
                    self.lines.setdefault((*key, index), self._tokens[self._at][1])
                    self._value((*key, index))
                index += 1
                self._at += self._ahead() == ","
            self._at += 1
        else:  # a scalar: everything up to the end of the line or entry
            while self._at < len(self._tokens) and self._tokens[self._at][0] not in ("\n", ",", "]", "}"):
                self._at += 1
        self.spans[key] = begin, self._tokens[self._at - 1][3]

    def _key(self) -> tuple[str, ...]:
        """Read a dotted key."""
        text = self._ahead() or ""
        self._at += 1
        part = text[1:-1] if text[:1] in ("'", '"') else text
        if self._ahead() != ".":
            return (part,)
        self._at += 1
        return (part, *self._key())
