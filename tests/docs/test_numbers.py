"""Numbers that pages quote from studies are those of the stored results."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
STUDIES = {path.stem: path for path in (ROOT / "studies" / "results").glob("*.json")}
PAGES = [
    ROOT / "README.md",
    ROOT / "tools" / "paper.md",
    ROOT / "tools" / "evidence.md",
    *(
        page for page in ROOT.glob("docs/explanation/*.md") if page.stem != "corrections"
    ),  # results before, too
    *ROOT.glob("docs/how-to/*.md"),
    *ROOT.glob("docs/tutorials/*.md"),
    *ROOT.glob("ecs_eco/worlds/*/README.md"),
]
NUMBER = r"[−-]?\d+(?:,\d{3})*(?:\.\d+)?"
# numbers in paragraphs that quote a study, which come from elsewhere
OTHER = {
    "docs/explanation/learning.md": {"0.38", "0.44", "0.65", "1.4", "2.1", "0.40"},
    "docs/how-to/find_sweeps.md": {"0.01"},
    "docs/how-to/portable.md": {"1.1", "1.6", "2.1"},
    "tools/paper.md": {"0.235"},
}


def numbers(content: Any) -> Iterator[float]:
    """Yield the numbers of a result: values, and numbers in its texts."""
    if isinstance(content, str):
        yield from (float(text.replace("−", "-").replace(",", "")) for text in re.findall(NUMBER, content))
    elif isinstance(content, dict | list):
        for part in content.values() if isinstance(content, dict) else content:
            yield from numbers(part)
    elif content is not None:
        yield float(content)


def quoted(page: Path) -> Iterator[tuple[str, set[str], list[str]]]:
    """Yield each paragraph that names studies, their names, and the paragraph's decimal numbers."""
    for paragraph in re.split(r"\n\s*\n|\n(?=[-*|] )", page.read_text()):
        named = set(re.findall(r"evidence/(\w+)\.md|studies\.(\w+)|\{(\w+) \||`(\w+)`", paragraph))
        if studies := {name for names in named for name in names if name in STUDIES}:
            text = re.sub(r"\{[^}]*\}", "", paragraph)
            yield paragraph, studies, re.findall(r"(?<![\w.])[−-]?\d+(?:,\d{3})*\.\d+(?![\w.]*\d)", text)


def rounds_to(text: str, values: list[float]) -> bool:
    """Return whether a value, its share of 1 or its percentage rounds to a number, apart from its sign."""
    number, places = abs(float(text.replace("−", "-").replace(",", ""))), len(text.partition(".")[2])
    candidates = (x for value in values for x in (abs(value), 100 * abs(value), abs(1 - abs(value))))
    return any(abs(x - number) <= 0.5000001 * 10**-places for x in candidates)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_numbers_quoted_from_a_study_are_in_its_result(page: Path) -> None:
    others = OTHER.get(str(page.relative_to(ROOT)), set())
    for paragraph, studies, found in quoted(page):
        results = [json.loads(STUDIES[name].read_text()) for name in studies]
        keys = ("verdicts", "table", "notes", "config")
        values = [x for result in results for key in keys for x in numbers(result.get(key))]
        wrong = [text for text in found if text not in others and not rounds_to(text, values)]
        assert not wrong, f"{wrong} not in {sorted(studies)}: {paragraph[:200]}"


@pytest.mark.parametrize(
    "world", sorted((ROOT / "ecs_eco" / "worlds").glob("*/README.md")), ids=lambda p: p.parent.name
)
def test_results_of_a_world_give_no_estimates(world: Path) -> None:
    """Pages of worlds tell what was found; estimates and intervals are on the pages of their studies, which
    are made from the results."""
    _, _, results = world.read_text().partition("## Results")
    assert not re.findall(r"\d\.\d\d", results.partition("\n## ")[0])
