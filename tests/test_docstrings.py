"""The API reference: every public name has an entry, and the examples of docstrings run."""

import doctest
import inspect
import re
from importlib import import_module
from pathlib import Path

import pytest

import ecs_eco
from tools.api_pages import DATA, WHOLE, entries, is_public, pages, thing_of

ROOT = Path(__file__).parents[1]
ENTRIES = list(dict.fromkeys(entries()))
WITHOUT_EXTRAS = [(page, module, name) for page, module, name in ENTRIES if name != "vec_env"]
ELSEWHERE = {"ecs_eco.compiled.portable", "ecs_eco.compiled.elementary"}  # documented by pages of their own
IMPORT = re.compile(r"^\s*(?:>>> )?from (ecs_eco[\w.]*) import ([\w, ]+)$", re.MULTILINE)
TEXTS = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").glob("*.py")]


def public_members(thing: type) -> list[tuple[str, object]]:
    found = [(name, member) for name, member in inspect.getmembers(thing) if not name.startswith("_")]
    return [(name, member) for name, member in found if callable(member) or isinstance(member, property)]


def test_every_public_name_of_the_package_has_an_entry():
    listed = {name for _, _, name in ENTRIES}
    rooms = {name for name in ecs_eco.__all__ if inspect.ismodule(getattr(ecs_eco, name))}
    text = pages()["world"]
    missing = {
        name for name in ecs_eco.__all__ if name not in listed | rooms and f"ecs_eco.{name}\n" not in text
    }
    for room in rooms - {"components"}:  # they have a page of tables
        missing |= set(getattr(getattr(ecs_eco, room), "__all__", ())) - listed
    assert missing == set()


def test_every_name_that_the_docs_import_has_an_entry():
    listed = {id(thing_of(module, name)) for _, module, name in WITHOUT_EXTRAS}
    missing = []
    for path in TEXTS:
        for module, names in IMPORT.findall(path.read_text(encoding="utf-8")):
            for name in names.split(", "):
                thing = getattr(import_module(module), name, None) if name != "vec_env" else None
                known = inspect.ismodule(thing) or module in ELSEWHERE or module.endswith("components")
                if not known and thing is not None and id(thing) not in listed and inspect.isroutine(thing):
                    missing.append(f"{path.name}: {module}.{name}")
    assert missing == []


def test_every_constant_of_the_api_has_a_sentence_and_nothing_else_has():
    data = {
        name
        for _, module, name in WITHOUT_EXTRAS
        if not inspect.isroutine(thing := thing_of(module, name)) and not inspect.isclass(thing)
    }
    assert data == DATA.keys()


def test_world_shows_what_users_call_and_nothing_that_only_the_package_calls():
    shown = {name for name, member in public_members(ecs_eco.World) if is_public(member)}
    assert {"run", "step", "spawn", "kill", "get", "each", "save", "restore", "series", "nearest"} <= shown
    assert {
        "bury",
        "admit",
        "admit_newborn",
        "merged",
        "touch",
        "pass_tick",
        "forget_neighbours",
    } & shown == set()
    hidden = {name for name, _ in public_members(ecs_eco.World)} - shown
    assert hidden == {"report"}, "document them with sections, or begin their names with an underscore"


@pytest.mark.parametrize("page", sorted({page for page, _, _ in ENTRIES}))
def test_every_function_and_method_of_a_page_has_its_parameters_and_an_example(page):
    found = dict(documented([entry for entry in WITHOUT_EXTRAS if entry[0] == page]))
    missing = []
    for label, thing in found.items():
        owner, _, name = label.rpartition(".")
        if inspect.isclass(thing) or name in DATA:
            continue
        text, example = inspect.getdoc(thing) or "", (inspect.getdoc(found.get(owner)) or "")
        if inspect.signature(thing).parameters.keys() - {"self", "_"} and "Parameters\n---" not in text:
            missing.append(f"{label}: Parameters")
        if ">>> " not in text and not re.search(rf"\b{name}\(", example.partition("Examples\n---")[2]):
            missing.append(f"{label}: Examples")
    assert missing == []


def test_every_parameter_that_a_docstring_names_is_one_of_the_function():
    wrong = []
    for label, thing in documented():
        text = inspect.getdoc(thing) or ""
        section = re.search(r"^Parameters\n-+\n(.*?)(?=^\w+\n-{3,}|\Z)", text, re.MULTILINE | re.DOTALL)
        if section is None:
            continue
        named = [
            name.strip(" *")
            for line in re.findall(r"^(\S.*?)(?: : .*)?$", section[1], re.MULTILINE)
            for name in line.split(",")
        ]
        known = set(inspect.signature(thing).parameters)
        wrong += [f"{label}: {name}" for name in named if name not in known]
    assert wrong == []


def documented(entries: list[tuple[str, str, str]] = WITHOUT_EXTRAS) -> list[tuple[str, object]]:
    """Functions, classes and public methods that the pages show, each with a label."""
    found: dict[int, tuple[str, object]] = {}
    for page, module, name in entries:
        thing = thing_of(module, name)
        if not callable(thing):
            continue
        found.setdefault(id(thing), (f"{module}.{name}", thing))
        if inspect.isclass(thing) and page != "systems" and not issubclass(thing, Exception):
            for n, m in public_members(thing):
                if callable(m) and is_public(m) and (n in vars(thing) or name in WHOLE):
                    found.setdefault(id(getattr(m, "__func__", m)), (f"{module}.{name}.{n}", m))
    return list(found.values())


EXAMPLES = [(label, thing) for label, thing in documented() if ">>> " in (inspect.getdoc(thing) or "")]


@pytest.mark.slow
@pytest.mark.parametrize(("label", "thing"), EXAMPLES, ids=[label for label, _ in EXAMPLES])
def test_the_example_of_a_docstring_runs(label, thing, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    test = doctest.DocTestParser().get_doctest(inspect.getdoc(thing) or "", {}, label, None, 0)
    said: list[str] = []
    results = doctest.DocTestRunner(optionflags=flags).run(test, out=said.append)
    assert results.attempted > 0
    assert results.failed == 0, "".join(said)
