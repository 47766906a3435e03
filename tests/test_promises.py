"""docs/reference/promises.md: the tests that it names are there."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs" / "reference" / "promises.md").read_text()
NAMED = sorted(set(re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", TEXT)))


@pytest.mark.parametrize(("path", "name"), NAMED)
def test_a_promise_is_held_by_a_test_that_exists(path, name):
    assert (ROOT / path).is_file(), f"promises.md names {path}"
    there = [
        node.name
        for node in ast.walk(ast.parse((ROOT / path).read_text()))
        if isinstance(node, ast.FunctionDef)
    ]
    assert name in there, f"promises.md names {name}, which {path} does not hold"


def test_every_promise_names_a_test_and_its_limits():
    for part in TEXT.split("\n## ")[1:]:
        title = part.partition("\n")[0]
        assert "`tests/" in part, f"{title}: no test holds it"
        assert "Limit" in part, f"{title}: without limits?"
    assert len(NAMED) == TEXT.count("::test_")  # each is written so that it is found
    assert len(NAMED) > 25
