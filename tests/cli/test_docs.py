"""`ecs-eco docs` finds pages of the copy in the package, and says what to do where there is none."""

import webbrowser
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import docs
from ecs_eco.cli.app import app


@pytest.fixture
def site(tmp_path, monkeypatch):
    for name in ("index", "how-to/index", "how-to/running", "reference/api/world", "source/index"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / f"{name}.html").write_text("<p>here</p>")
    monkeypatch.setattr(docs, "SITE", tmp_path)
    opened = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setenv("DISPLAY", ":0")
    return tmp_path, opened


@pytest.mark.parametrize(
    ("asked", "file"),
    [
        ([], "index.html"),
        (["how-to"], "how-to/index.html"),
        (["running"], "how-to/running.html"),
        (["how-to/running.md"], "how-to/running.html"),
        (["reference/api/world.html"], "reference/api/world.html"),
    ],
)
def test_a_page_is_found_by_its_path_or_its_name_and_opened(asked, file, site):
    folder, opened = site
    done = CliRunner().invoke(app, ["docs", *asked])
    assert (done.exit_code, done.output.strip()) == (0, (folder / file).as_uri())
    assert opened == [(folder / file).as_uri()]


def test_without_a_browser_the_address_alone_is_printed(site):
    assert CliRunner().invoke(app, ["docs", "--no-browser"]).exit_code == 0
    assert site[1] == []


def test_an_unknown_page_is_refused_with_the_nearest(site):
    done = CliRunner().invoke(app, ["docs", "runing"])
    assert done.exit_code != 0
    assert "how-to/running" in done.output


@pytest.mark.parametrize(
    ("asked", "file"),
    [([], "index.md"), (["running"], "how-to/running.md"), (["start/install.html"], "start/install.md")],
)
def test_a_copy_of_the_sources_shows_its_texts_and_says_how_the_site_is_built(asked, file, site, monkeypatch):
    monkeypatch.setattr(docs, "SITE", site[0] / "nowhere")
    done = CliRunner().invoke(app, ["docs", *asked])
    text = Path(__file__).parents[2] / "docs" / file
    assert (done.exit_code, done.stdout.strip()) == (0, text.as_uri())
    assert "tools/build_site.py" in done.stderr
    assert site[1] == [text.as_uri()]


def test_a_package_without_pages_says_where_they_are(site, monkeypatch):
    monkeypatch.setattr(docs, "SITE", site[0] / "nowhere")
    monkeypatch.setattr(docs, "SOURCES", site[0] / "nowhere")
    done = CliRunner().invoke(app, ["docs"])
    assert done.exit_code != 0
    for words in (
        "built without its documentation",
        "a package with its documentation",
        "tools/build_site.py",
    ):
        assert words in " ".join(done.output.split())
