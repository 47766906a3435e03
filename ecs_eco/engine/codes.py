"""Causes of death as numbers, which columns hold."""

from __future__ import annotations

MOST = 255  # that a u8 holds beside 0, of the living


class Codes(dict[str, int]):
    """Name → code of each cause of death that has been asked for; a new one becomes known at the end of the
    list of `causes`, whose first one has the code 1. Whoever writes another list clears this."""

    def __init__(self, causes: list[str]) -> None:
        super().__init__()
        self._causes = causes

    def __missing__(self, name: str) -> int:
        if name not in self._causes:
            if len(self._causes) == MOST:
                raise ValueError(f"cause {name!r}: a world knows at most {MOST} causes of death")
            self._causes.append(name)
        self[name] = self._causes.index(name) + 1
        return self[name]
