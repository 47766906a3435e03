"""What README and docs name is there: files, links, modules, classes and functions, attributes of a world."""

import pytest

from tools.doc_names import PAGES, problems


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_names_only_what_is_there(page):
    assert problems(page) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[a page](nowhere.md#part)", "no file nowhere.md"),
        ("`ecs_eco/engine/wordl.py`", "`ecs_eco/engine/wordl.py`: no file ecs_eco/engine/wordl.py"),
        ("`tests/engine/test_*.pyx`", "`tests/engine/test_*.pyx`: no file tests/engine/test_*.pyx"),
        ("`view/peek.py`", "`view/peek.py`: no file view/peek.py"),
        ("`peek.py`", "`peek.py`: no file peek.py"),
        (
            "`python tools/make_coffee.py --check`",
            "`python tools/make_coffee.py --check`: no file tools/make_coffee.py",
        ),
        ("`python -m studies.coffee`", "`python -m studies.coffee`: no module studies.coffee"),
        ("`ecs_eco.engine.tabel`", "`ecs_eco.engine.tabel`: ecs_eco.engine.tabel does not exist"),
        (
            "`from ecs_eco.engine.table.Tabel`",
            "`from ecs_eco.engine.table.Tabel`: ecs_eco.engine.table.Tabel does not exist",
        ),
        ("`world.between`", "`world.between`: world has no between"),
        ("`World.from_confg(…)`", "`World.from_confg(…)`: World has no from_confg"),
        ("`table.traits`", "`table.traits`: table has no traits"),
        ("`Reckon`", "`Reckon`: nothing is called Reckon"),
    ],
)
def test_what_is_not_there_is_named(text, problem, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(f"Before {text} and after.\n", encoding="utf-8")
    assert problems(page) == [problem]


@pytest.mark.parametrize(
    "text",
    [
        "`my-run/report.html`",
        "`flock.py`",
        "`energy`",
        "`ecs_eco/systems/<verb>.py`",
        "`world.environment.sun.day`",
        "`ecs_eco.World.from_config`",
        "`systems/feed.py`",
        "`runs/`",
        "`Feed`",
        "`None`",
    ],
)
def test_what_is_there_or_the_readers_own_is_no_problem(text, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    assert problems(page) == []
