"""The commands on archipelagos: run, resume and report; and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.record.archipelago import read
from tests.lab.newts import written


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    written(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def invoke(*words: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, list(words), terminal_width=160)
    assert done.exit_code == code, done.output
    return " ".join(done.output.split())


@pytest.mark.slow
def test_a_run_stops_at_a_tick_is_resumed_and_reported(here: Path) -> None:
    out = invoke("run", "islands.toml", "--ticks", "8", "--seed", "3", "--out", "run", "--quiet")
    assert "8 ticks of newts on 3 islands, seed 3" in out
    assert read(here / "run")["digest"][:16] in out
    assert (here / "run" / "islands" / "east" / "report.html").is_file()
    page = (here / "run" / "report.html").read_text()
    assert "3 islands, graph ring, 8 ticks with a barrier every 4" in page
    assert 'href="islands/east/report.html"' in page
    assert "species.newt.count = 40" in page
    assert (here / "run" / "figures" / "map.svg").stat().st_size > 1000
    assert "12 ticks" in invoke("resume", "run", "--until", "12", "--quiet")
    invoke("report", "run", "--out", "elsewhere")
    assert "12 ticks" in (here / "elsewhere" / "report.html").read_text()


@pytest.mark.slow
def test_a_run_in_two_parts_ends_as_one_in_one(here: Path) -> None:
    words = ("--seed", "3", "--quiet", "--no-report", "--out")
    invoke("run", "islands.toml", "--ticks", "12", *words, "whole")
    invoke("run", "islands.toml", "--ticks", "8", *words, "parts")
    invoke("resume", "parts", "--until", "12", "--quiet", "--no-report")
    assert read(here / "parts")["digest"] == read(here / "whole")["digest"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "islands.toml", "--watch"), "neither --watch"),
        (("run", "islands.toml", "--checkpoint-every", "2"), "checkpoints at barriers"),
        (("run", "islands.toml", "--on", "moon"), "no such engine"),
        (("run", "predator-prey", "--workers", "2"), "has no [archipelago]"),
    ],
)
def test_options_of_the_other_kind_are_refused(here: Path, words: tuple[str, ...], said: str) -> None:
    assert said in invoke(*words, code=2)


@pytest.mark.slow
def test_an_archipelago_is_no_run(here: Path) -> None:
    invoke("run", "islands.toml", "--ticks", "4", "--quiet", "--no-report", "--out", "run")
    out = invoke("why", "run", code=2)
    assert "is an archipelago; name one of its islands" in out
    assert "run/islands/north" in out
