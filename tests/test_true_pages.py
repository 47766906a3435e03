"""What pages say of installing, of files and of results is so."""

import json
import re
import tomllib
from pathlib import Path

import pytest

from ecs_eco.config import load
from ecs_eco.record import run_to_folder

ROOT = Path(__file__).parents[1]
CODE = [path for folder in ("ecs_eco", "examples", "tools") for path in (ROOT / folder).rglob("*.py")]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
PUBLISHED = r"pip install[^\n`\[]*?[\s\"']ecs-eco\b.*"


def read(page: str) -> str:
    return " ".join((ROOT / "docs" / page).read_text(encoding="utf-8").split())


def result(study: str) -> dict:
    return json.loads((ROOT / "studies" / "results" / f"{study}.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_no_page_installs_ecs_eco_from_an_index_while_it_is_on_none(page):
    assert not re.findall(PUBLISHED, page.read_text(encoding="utf-8"))


def test_no_code_installs_ecs_eco_from_an_index_while_it_is_on_none():
    texts = {path: path.read_text(encoding="utf-8") for path in CODE}
    assert {path: found for path, text in texts.items() if (found := re.findall(PUBLISHED, text))} == {}


def test_the_page_on_installing_lists_the_extras_that_there_are():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    page = (ROOT / "docs/start/install.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"\| `\[(\w+)\]`", page)) == sorted(project["optional-dependencies"])


def test_a_run_leaves_what_the_page_lists(menagerie, tmp_path):
    page = (ROOT / "docs/start/what_you_see.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`.*?`) \|", page.partition("## In the folder")[2], re.MULTILINE)
    listed = {name.strip("/") for row in rows for name in re.findall(r"`(.+?)`", row)}
    run_to_folder(menagerie(), seed=1, ticks=12, out=tmp_path / "run", policies="untrained", report=False)
    assert listed >= {"series", "births", "checkpoints", "data_dictionary.md"}
    assert listed - {"report.html"} <= {path.name for path in (tmp_path / "run").iterdir()}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_link_to_a_module_is_named_as_the_module(page):
    links = re.findall(r"\[([\w/\\.]+\.py)\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    assert [(name, to) for name, to in links if not to.endswith(name.replace("\\", ""))] == []


def test_what_isolation_does_is_told_with_the_numbers_of_its_study():
    end = {row[0]: row for row in result("isolation")["table"]["rows"]}
    page = read("how-to/archipelago.md")
    assert f"heterozygosity of {end['isolated'][1]:.3f} on average, against {end['panmictic'][1]:.3f}" in page
    assert f"a heterozygosity of {end['isolated'][2]:.3f} (" in page


def test_what_random_search_does_is_told_with_the_numbers_of_its_study():
    said = {v["statement"]: v["value"] for v in result("search")["verdicts"]}
    search = said["the search: share of runs on fresh seeds in which all species persist"].partition(" (")[0]
    random = said["the same with random candidates, in the same time"]
    page = read("how-to/searching.md")
    assert f"persisted in {search} runs, and those of two random searches in {random} (" in page


def test_the_readme_is_short_and_light():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    bullets = re.findall(r"^- (.*)", re.sub(r"\[(.*?)\]\(.*?\)|[*`]", r"\1", readme), re.MULTILINE)
    assert len(readme.splitlines()) <= 120
    assert len(bullets) == 5
    assert max(map(len, bullets)) <= 110
    assert (ROOT / "docs/img/predator_prey.gif").stat().st_size <= 3e6
    assert (ROOT / "docs/img/readme.png").stat().st_size <= 400e3


def test_the_numbers_of_the_lesson_come_from_the_world_as_it_is():
    ran = re.search(r"config_hash: (\w+)", read("tutorials/lesson.md"))
    assert load("predator-prey").config_hash.startswith(ran[1])
