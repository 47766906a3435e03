"""A release has one number: in the package, in pyproject.toml,
in the digests and at the top of the changelog."""

import json
import re
import tomllib
from pathlib import Path

from ecs_eco import __version__
from ecs_eco.testing.self_test import DIGESTS
from tools.resolve_dependencies import PYTHONS, table

ROOT = Path(__file__).parents[1]
HEADINGS = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)


def test_the_number_of_the_release_is_the_same_everywhere():
    assert (
        tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
        == __version__
    )
    assert json.loads(DIGESTS.read_text(encoding="utf-8"))["release"] == __version__
    assert HEADINGS[1].split(" – ")[0] == __version__


def test_the_changelog_begins_with_what_is_not_released_and_dates_what_is():
    assert HEADINGS[0] == "Unreleased"
    assert all(re.fullmatch(r"\d+\.\d+\.\d+ – \d{4}-\d\d-\d\d", heading) for heading in HEADINGS[1:])


def test_what_cites_the_release_has_its_number_and_its_date():
    number, date = HEADINGS[1].split(" – ")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {number}\n" in citation
    assert f'\ndate-released: "{date}"\n' in citation
    meta = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))
    assert (meta["version"], meta["datePublished"]) == (number, date)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert meta["softwareRequirements"] == [re.split("[<>=]", name)[0] for name in project["dependencies"]]
    assert set(meta["keywords"]) == set(project["keywords"])
    assert f"## {number}, " in (ROOT / "docs" / "releases.md").read_text(encoding="utf-8")


def test_the_notices_of_the_code_of_others_are_those_in_the_bundle_and_go_into_the_wheel():
    notices = (ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8")
    bundle = (ROOT / "ecs_eco" / "view" / "static" / "vendor.js").read_text(encoding="utf-8")
    banner = bundle[bundle.index("/*!") : bundle.index("*/")]
    packages = json.loads((ROOT / "view-page" / "package.json").read_text(encoding="utf-8"))
    for name in ("three", "uplot"):
        assert f"## {name} {packages['devDependencies'][name]}\n" in notices
    for paragraph in banner.split("\n\n")[1:]:
        assert paragraph.strip() in notices or paragraph.strip() == "----", paragraph
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["license-files"] == ["LICENSE", "THIRD_PARTY.md"]


def test_the_dependencies_were_resolved_as_they_are_now():
    found = json.loads((ROOT / "tools" / "resolved.json").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert found["ranges"] == project["dependencies"], "run python tools/resolve_dependencies.py"
    page = (ROOT / "docs" / "reference" / "supported.md").read_text(encoding="utf-8")
    assert table(found) in page
    for python in PYTHONS:
        assert f"Programming Language :: Python :: {python}" in project["classifiers"]
        assert "" not in found["platforms"]["Linux, x86-64"][python]
