"""Sizes are counted as they are shown: hand-counted on two small files."""

from tools.sizes import code_lines, exceptions, measure, rows_of, summary, table

SOURCES = {
    "ecs_eco/room/one.py": '''from typing import Any


class House:
    def door(self, key: Any, *more: "Any") -> None:
        """Open."""

    async def window(self) -> list[Any]:
        def pane(x: int) -> int:
            return x
        return [pane]
''',
    "ecs_eco/two.py": "x = 1\ny = 2\n",
    "tests/test_one.py": "def test_it(a: int):\n    pass\n",
}


def test_lines_functions_and_annotations_are_counted():
    size = measure(SOURCES)
    assert size.files == {"ecs_eco/room/one.py": 8, "ecs_eco/two.py": 2, "tests/test_one.py": 2}
    assert list(size.package) == ["ecs_eco/room/one.py", "ecs_eco/two.py"]
    assert size.functions == {
        "ecs_eco/room/one.py::House.door": 2,
        "ecs_eco/room/one.py::House.window": 4,
        "ecs_eco/room/one.py::House.window.pane": 2,
    }
    assert (size.annotations, size.any_alone, size.any_within) == (6, 2, 1)


def test_how_a_statement_is_wrapped_changes_no_count_and_a_docstring_counts_whole():
    text = 'x = 1\n\n\ndef f(\n    a,\n):\n    """One.\n\n    Two.\n    """\n    # why\n'
    text += "    return [\n        a\n    ]  # so\n"
    assert code_lines(text) == [1, 4, 7, 8, 9, 10, 11, 12]


def test_the_sections_of_a_docstring_are_documentation_and_count_no_lines():
    text = 'def f(a):\n    """One.\n\n    Two.\n\n    Parameters\n    ----------\n    a : int\n    """\n'
    text += "    return a\n"
    assert code_lines(text) == [1, 2, 3, 4, 10]


def test_the_table_has_a_column_for_each_commit_and_a_line_for_each_folder():
    rows = rows_of(measure(SOURCES))
    assert rows["functions: median, 90 %, most lines"] == "2, 2, 4"
    assert rows["lines: ecs_eco/room"] == "8"
    assert rows["lines: ecs_eco, all"] == "10"
    former = measure({"ecs_eco/two.py": "def f():\n    pass\n", "studies/a.py": "\n# a\n"})
    kept = summary({"old": former, "new": measure(SOURCES)})
    lines = table(kept, kept["rows"]).splitlines()
    assert lines[:2] == ["|  | old | new |", "| --- | --- | --- |"]
    assert "| lines: ecs_eco/room | – | 8 |" in lines
    assert "| lines: studies | 1 | – |" in lines


def test_what_is_above_the_limits_at_the_last_commit_is_named_with_its_reason():
    long = {"ecs_eco/two.py": "def f():\n" + "    pass\n" * 50, "ecs_eco/three.py": "x = 1\n" * 301}
    assert summary({"old": measure(long), "new": measure(SOURCES)})["over"] == []
    assert exceptions(summary({"old": measure(SOURCES), "new": measure(long)})) == (
        "Above 300 lines a file, or 50 a function: `ecs_eco/three.py`, 301 (open); `ecs_eco/two.py::f`, "
        "51 (open)."
    )
