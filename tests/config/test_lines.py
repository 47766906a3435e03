"""Where keys stand: every key of an awkward file is found on its line."""

from __future__ import annotations

import tomllib
from typing import Any

from ecs_eco.config.lines import key_lines

AWKWARD = '''\
a = 1 # [b]
b.c = "x = 1"
list = [
  { kind = "one", at = [[1, 2], [3.5, 4]] }, # }
  { kind = 'two ]', "quoted.key" = 1 },
]

text = """
[not a table]
x = 1
"""
[table]   # comment
"key with = sign" = 1979-05-27
[table.inner]
empty = {}
[[many]]
x = [[1], [2]]
[[many]]
x = 2
[many.sub]
y = 3
'''


def test_every_key_is_found_on_its_line() -> None:
    lines, line_of = AWKWARD.splitlines(), key_lines(AWKWARD)

    def walk(node: Any, key: tuple[Any, ...]) -> None:
        if key:
            assert key in line_of, key
            if isinstance(key[-1], str):
                assert key[-1] in lines[line_of[key] - 1]
        if isinstance(node, dict):
            for name, value in node.items():
                walk(value, (*key, name))
        if isinstance(node, list):
            for i, value in enumerate(node):
                walk(value, (*key, i))

    walk(tomllib.loads(AWKWARD), ())
    assert line_of["list", 1, "kind"] == 5
    assert line_of["many", 1, "x"] == 19
    assert line_of["many", 1, "sub", "y"] == 21
    assert line_of["text",] == 8
