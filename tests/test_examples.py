"""Every example, every Python snippet and every command of README and docs works as it is printed."""

import os
import re
import runpy
import shutil
import sys
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.config import load, loading
from ecs_eco.config.former import notes_on, rename
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.record import run_to_folder
from ecs_eco.testing import check_system
from tools.sizes import code_lines

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
NEEDS = {
    "plain_ppo.py": ["gymnasium"],
    "learning.md": ["gymnasium"],
    "rl_parallel.py": ["pettingzoo"],
    "rl_slots.py": ["gymnasium", "stable_baselines3"],
    "bring_your_own_learner.md": ["pettingzoo"],
}


def fenced(page: Path, language: str) -> list[str]:
    return re.findall(
        rf"^```{language}\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )


def cells(page: Path) -> list[str]:
    """The code of a page: its Python snippets, or the cells of a notebook."""
    return fenced(page, r"(?:python|\{code-cell\} ipython3)")


def in_folder(path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a file as a program, in a folder; no world that it loads may have a key by its former name."""
    for package in NEEDS.get(path.name, NEEDS.get(path.stem + ".md", [])):
        pytest.importorskip(package)
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", [str(path)])
    noted: list[str] = []
    monkeypatch.setattr(loading, "notes_on", lambda *given: noted.extend(notes_on(*given)) or [])
    runpy.run_path(str(path), run_name="__main__")
    assert noted == []


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_example_runs(
    example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    in_folder(example, tmp_path, monkeypatch)
    assert capsys.readouterr().out.strip(), "it says nothing"


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_example_is_one_idea_on_one_screen(example: Path) -> None:
    text = example.read_text(encoding="utf-8")
    assert len(code_lines(text)) < 80
    assert text.startswith('"""')


@pytest.mark.parametrize(("example", "name"), [("own_component", "GrowWool"), ("own_system", "Strike")])
def test_systems_of_the_examples_keep_the_rules_of_systems(example: str, name: str) -> None:
    config = load(
        "predator-prey", {"species.grass.count": 500, "species.deer.count": 100, "species.wolf.count": 20}
    )
    kind = runpy.run_path(str(ROOT / "examples" / f"{example}.py"))[name]
    arguments = (0.01,) if name == "Strike" else ()
    check_system(
        kind,
        lambda threads: World.from_config(
            config, policies="random", threads=threads, systems=[kind(*arguments)]
        ),
    )


def epidemic(**values: object) -> World:
    config = load(ROOT / "examples" / "epidemic.toml", values, trust=True)
    return World.from_config(config)


@pytest.mark.parametrize("name", ["sir:Walk", "sir:Infect"])
def test_systems_of_the_epidemic_keep_the_rules_of_systems(name: str) -> None:
    world = epidemic()
    check_system(world.config.known(name), lambda threads: World.from_config(world.config, threads=threads))


@pytest.mark.parametrize(("edges", "ill"), [("torus", 1.0), ("walls", 0.5)])
def test_the_epidemic_knows_that_a_torus_has_no_edge(edges: str, ill: float) -> None:
    world = epidemic(
        **{
            "species.people.count": 2,
            "species.people.disease.beta": 1.0,
            "species.people.disease.first": 1,
            "systems.Walk.speed": 0.0,
            "space.edges": edges,
        }
    )
    place = world.table("people")[Position]
    place.x[:2], place.y[:2] = (0.5, 59.5), 30.0
    assert world.run(3).series()["prevalence"].to_pylist()[-1] == ill


@pytest.mark.slow
@pytest.mark.parametrize("page", [p for p in PAGES if cells(p)], ids=lambda p: p.stem)
def test_snippets_of_a_page_run_in_order(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    snippets = cells(page)
    if page.name in ("README.md", "died_out.md"):  # a snippet reads what a command leaves
        run_to_folder("predator-prey", 1, 5, tmp_path / "my-run", "random", report=False)
    shutil.copy(ROOT / "examples" / "meadow.toml", tmp_path)
    file = tmp_path / f"{page.stem}.py"
    file.write_text("\n\n".join(snippets), encoding="utf-8")
    in_folder(file, tmp_path, monkeypatch)


@pytest.mark.parametrize(
    "page", [p for p in PAGES if "ecs-eco " in "".join(fenced(p, "bash"))], ids=lambda p: p.stem
)
def test_commands_of_a_page_exist_with_their_options(page: Path) -> None:
    from ecs_eco.cli.app import app

    for line in re.findall(r"ecs-eco ([a-z].*)", "".join(fenced(page, "bash"))):
        command, *rest = line.partition("#")[0].split()
        shown = CliRunner().invoke(app, [command, "--help"], env={"COLUMNS": "200"})
        assert shown.exit_code == 0, line
        for option in (w.partition("=")[0] for w in rest if w.startswith("--")):
            assert re.search(rf"{option}\b", shown.output), f"{line}: no option {option}"


@pytest.mark.parametrize(
    "page", [*PAGES, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"], ids=lambda p: p.stem
)
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        assert os.path.exists(page.parent / target), target


def test_the_first_world_of_the_page_is_the_file_of_the_examples() -> None:
    page = ROOT / "docs" / "start" / "first_world.md"
    assert fenced(page, "toml") == [(ROOT / "examples" / "meadow.toml").read_text(encoding="utf-8")]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_rabbits_of_the_first_world_live_only_if_they_learn(seed: int) -> None:
    count = runpy.run_path(str(ROOT / "examples" / "rabbits_learn.py"))["rabbits"]
    assert count(seed, learn=True)[-1] > 60
    assert count(seed, learn=False)[-1] < 15


@pytest.mark.parametrize("page", [*PAGES, *sorted((ROOT / "examples").glob("*.toml"))], ids=lambda p: p.name)
def test_no_key_of_a_page_or_example_has_its_former_name(page: Path) -> None:
    blocks = fenced(page, "toml") if page.suffix == ".md" else [page.read_text(encoding="utf-8")]
    assert [found for block in blocks for found in rename(tomllib.loads(block), WorldConfig)] == []


def test_no_example_is_left_out() -> None:
    assert len(EXAMPLES) >= 10
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert [e.name for e in EXAMPLES if e.name not in text] == []


@pytest.mark.parametrize("name", ["jacksboro", "coast"])
def test_worlds_on_real_land_live_on(name: str) -> None:
    world = World.from_config(ROOT / "examples" / f"{name}.toml").run(60)
    assert world.tables["deer"].n > 250
    assert world.tables["grass"].n > 1000
