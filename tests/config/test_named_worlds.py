"""Worlds of installed packages have names, and finding one runs none of its code."""

import sys

import pytest

from ecs_eco.config import load
from ecs_eco.config.shipped import named, shipped
from ecs_eco.engine.errors import ConfigError

POND = 'format = 1\nname = "pond"\nspace = { size = [9.0, 9.0] }\n'
POND += "[species.frog]\ncount = 1\nbody = { radius = 0.1 }\n"


@pytest.fixture
def installed(tmp_path, monkeypatch):
    package = tmp_path / "wetlands"
    package.mkdir()
    (package / "__init__.py").write_text("raise SystemExit('imported')\n", encoding="utf-8")
    (package / "small_pond.toml").write_text(POND, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    return package


def test_a_world_of_an_installed_package_is_found_by_name_without_an_import(installed):
    assert named("wetlands:small-pond") == named("wetlands:small_pond") == installed / "small_pond.toml"
    assert load("wetlands:small-pond").species["frog"].count == 1
    assert "wetlands" not in sys.modules


def test_shipped_worlds_come_first_and_paths_are_no_names(installed):
    assert named("predator_prey") == shipped()["predator-prey"]
    for text in (
        "wetlands",
        "wetlands:big",
        "wetlands:../x",
        "no_such:pond",
        "__main__:x",
        "a b:c",
        "./x:y",
        "json:tool",
    ):
        assert named(text) is None


@pytest.mark.parametrize("text", ["wetlands:big-pond", "no_such_package:pond"])
def test_a_name_that_leads_nowhere_is_refused(installed, text):
    with pytest.raises(
        ConfigError, match="no such world, and no such file; expected: a path, package:world of an"
    ):
        load(text)
