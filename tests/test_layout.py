"""The tests mirror the package: whoever looks for the tests of a room finds them under its name.
And files and functions are short everywhere."""

import ast
from pathlib import Path

import pytest

from tools.sizes import FILE_LIMIT, FUNCTION_LIMIT, REASONS, code_lines, functions_of, within

ROOT = Path(__file__).parents[1]
BESIDE = {
    "benchmarks",
    "docs",
    "newcomer",
    "security",
    "studies",
    "tools",
}  # what is tested besides the rooms
CODE = ("benchmarks", "ecs_eco", "examples", "studies", "tests", "tools")


def folders(place):
    return {path.name for path in place.iterdir() if path.is_dir() and not path.name.startswith(("_", "."))}


def test_every_room_of_the_package_has_tests_under_its_name_and_nothing_else_has():
    assert folders(ROOT / "tests") - BESIDE == folders(ROOT / "ecs_eco")


def test_no_folder_of_tests_is_empty_and_no_test_lies_deeper_than_what_it_tests():
    for place in (ROOT / "tests").rglob("test_*.py"):
        room = place.parent.relative_to(ROOT / "tests")
        assert room.parts[:1] in [(), *((name,) for name in BESIDE)] or (ROOT / "ecs_eco" / room).is_dir(), (
            place
        )
    for room in folders(ROOT / "ecs_eco"):
        assert any((ROOT / "tests" / room).rglob("test_*.py")), room


@pytest.mark.parametrize("folder", CODE)
def test_no_file_and_no_function_is_too_long_without_a_reason(folder):
    too_long = []
    for path in sorted((ROOT / folder).rglob("*.py")):
        text, place = path.read_text(encoding="utf-8"), path.relative_to(ROOT).as_posix()
        rows = code_lines(text)
        lengths = {
            f"{place}::{name}": (within(rows, node), FUNCTION_LIMIT)
            for name, node in functions_of(ast.parse(text))
        }
        lengths[place] = len(rows), FILE_LIMIT
        too_long += [
            f"{name}: {lines} lines"
            for name, (lines, limit) in lengths.items()
            if lines > limit and name not in REASONS
        ]
    assert too_long == []
