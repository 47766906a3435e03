"""A release has one number: in the package, in pyproject.toml,
in the digests and at the top of the changelog."""

import json
import re
import tomllib
from pathlib import Path

from ecs_eco import __version__
from ecs_eco.testing.self_test import DIGESTS

ROOT = Path(__file__).parents[1]
HEADINGS = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)


def test_the_number_of_the_release_is_the_same_everywhere():
    assert (tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
            == __version__)
    assert json.loads(DIGESTS.read_text(encoding="utf-8"))["release"] == __version__
    assert HEADINGS[1].split(" – ")[0] == __version__


def test_the_changelog_begins_with_what_is_not_released_and_dates_what_is():
    assert HEADINGS[0] == "Unreleased"
    assert all(re.fullmatch(r"\d+\.\d+\.\d+ – \d{4}-\d\d-\d\d", heading) for heading in HEADINGS[1:])
