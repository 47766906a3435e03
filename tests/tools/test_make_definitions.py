"""The page of definitions lists the tests marked with each clause."""

from pathlib import Path

import pytest

from tools import make_definitions as tool


def folder_with(folder: Path, mark: str) -> Path:
    """A folder of tests with one marked test."""
    (folder / "tests").mkdir()
    (folder / "tests" / "test_bodies.py").write_text(f"{mark}\ndef test_bodies_are_warm():\n    pass\n")
    return folder / "tests"


def test_the_file_of_a_marked_test_is_next_to_its_clause_and_clauses_without_a_test_are_listed(tmp_path):
    page = tool.page(folder_with(tmp_path, '@pytest.mark.definition("1 temperature", "1 mass")'))
    rows = {line.split(" | ")[0].removeprefix("| "): line for line in page.splitlines() if line[:1] == "|"}
    for clause in ("1 temperature", "1 mass"):
        assert "[test_bodies.py](../../tests/test_bodies.py): 1" in rows[tool.CLAUSES[clause][0]]
    assert page.count("test_bodies.py](") == 2
    assert page.count("**no test**") == len(tool.CLAUSES) - 2


def test_a_mark_of_an_unknown_clause_is_refused_with_the_nearest(tmp_path):
    with pytest.raises(ValueError, match=r"no clause '1 temprature'; did you mean '1 temperature'\?"):
        tool.page(folder_with(tmp_path, '@pytest.mark.definition("1 temprature")'))


def test_every_clause_belongs_to_a_part_of_the_page():
    assert {clause.split()[0] for clause in tool.CLAUSES} == set(tool.PARTS)
