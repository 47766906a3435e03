"""Causes of death as numbers, for use in columns."""

from __future__ import annotations

MOST = 255  # codes that fit into a u8, in which 0 means alive


class Codes(dict[str, int]):
    """Cause of death → code. A new cause is appended to the list `causes`, whose first entry has code 1.
    Clear this dict after replacing that list."""

    def __init__(self, causes: list[str]) -> None:
        super().__init__()
        self._causes = causes

    def __missing__(self, name: str) -> int:
        if name not in self._causes:
            if len(self._causes) == MOST:
                raise ValueError(f"cause {name!r}: a world has at most {MOST} causes of death")
            self._causes.append(name)
        self[name] = self._causes.index(name) + 1
        return self[name]
