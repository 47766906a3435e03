"""Claims: each rests on one line of a result, and pages link to claims that are there."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import claims

RESULT = {
    "verdicts": [
        {"statement": "red: coefficient", "value": [0.1, 0.05, 0.2], "goal": "above 0", "met": True},
        {"statement": "green: coefficient", "value": 1, "goal": "0", "met": False, "registered": "green"},
    ],
    "cases": [{"case": {"arm": "goats", "training": t, "seed": s}} for t in (1, 2) for s in (5, 6, 7)]
    + [{"case": {"arm": "frozen", "seed": 5}}],
}
CLAIM = {"id": "red", "says": "Red spreads.", "study": "goats", "line": "red:", "of": {"arm": "goats"}}


def test_a_claim_shows_its_kind_its_seeds_and_its_outcome():
    text = claims.section(CLAIM, RESULT)
    assert text.startswith("### Claim: red\n\nRed spreads.\n\n| kind |")
    assert text.endswith("| exploratory | 2 × 3 | 0.1 (0.05 to 0.2) | above 0 | passed |")
    green = CLAIM | {"line": "green", "of": {"arm": "frozen"}, "failed": "(Green does not.)"}
    text = claims.section(green, RESULT)
    assert "Red spreads. (Green does not.)" in text
    assert text.endswith("| registered | 1 × 1 | 1 | 0 | **failed** |")
    text = claims.section(green | {"explained": "it was eaten"}, RESULT)
    assert text.endswith("| **failed** |\n\n[One run, explained](explained.md): it was eaten.")


def test_lives_within_a_case_are_replicates():
    lives = [{"training": t, "seed": s} for t in (1, 2, 3) for s in (5, 6)]
    result = RESULT | {"cases": [{"case": {"arm": "goats"}, "result": {"lives": lives}}]}
    assert claims.replicates(CLAIM, result) == "3 × 2"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"line": "rad:"}, "did you mean 'red: coefficient'"),
        ({"line": ""}, "2 lines of goats begin with"),
        ({"of": {"arm": "deer"}}, "no case of goats has"),
    ],
)
def test_a_claim_without_a_line_or_cases_is_refused(change, words):
    with pytest.raises(ValueError, match=words):
        claims.section(CLAIM | change, RESULT)


def test_pages_link_to_claims_that_are_there():
    known = {claim["id"] for claim in claims.read()}
    pages = [ROOT / "README.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("ecs_eco/worlds/*/README.md")]
    texts = {str(page.relative_to(ROOT)): page.read_text(encoding="utf-8") for page in pages}
    linked = {name: set(re.findall(r"#claim-([\w-]+)", text)) for name, text in texts.items()}
    assert not {name: ids - known for name, ids in linked.items() if ids - known}
    assert linked["README.md"] >= {
        "lifelong",
        "lifelong-cycles",
        "red",
        "yellow",
        "yellow-frozen",
        "migration",
        "without-krill",
        "same-bytes",
        "resume",
    }
