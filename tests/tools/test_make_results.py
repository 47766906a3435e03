"""The pages of evidence: each finding is complete, and no link to a claim or study is lost."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import claims
import make_results

LINK = re.compile(r"\]\(([^)#\s]*evidence/[^)#\s]*\.md|[^)#\s]*results\.md)(#[\w-]+)?\)")
EVIDENCE = ROOT / "docs" / "evidence"
LINE = {"statement": "deer: share", "value": [0.5, 0.25, 0.75], "goal": "above .2", "met": True}
RECORD = {
    "name": "deer",
    "claim": "Deer graze.",
    "command": "python -m studies.deer",
    "verdicts": [LINE, LINE | {"statement": "wolves | lag -0.5", "met": False}],
    "table": {"head": ["arm", "lag"], "rows": [["a", "0.2 (0.1 … 0.3)"]]},
    "cases": [{"case": {"seed": s}, "result": {}} for s in (1, 2, 3, 5)],
    "seeds": [1, 2, 3, 5],
    "seconds": 1234.5,
    "commits": ["0123456789abcdef"],
    "dirty": False,
    "config_hash": "f" * 64,
    "versions": {"python": "3.11"},
}


def anchors(page: str) -> set[str]:
    """Return the anchors of headings, as GitHub and MyST form them."""
    headings = re.findall(r"^#+ (.+)$", page, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_a_page_shows_outcomes_intervals_and_where_the_numbers_come_from():
    page = make_results.page(RECORD, [])
    assert "| passed | deer: share | 0.5 (0.25 to 0.75) | above 0.2 |" in page
    assert "| **failed** | wolves \\| lag −0.5 |" in page
    assert "| a | 0.2 (0.1 to 0.3) |" in page
    assert "1 of 2 goals passed." in page
    assert "| seeds | 1–3, 5 |" in page
    assert "`0123456789ab`" in page


def test_registered_words_stay_as_they_are():
    line = LINE | {"registered": "share"}
    page = make_results.page(RECORD | {"verdicts": [line]}, [])
    assert "| passed, registered | deer: share | 0.5 (0.25 to 0.75) | above .2 |" in page


def test_the_index_lists_all_studies_and_calls_registered_only_what_is():
    noted = {"file": "studies/registered/deer.toml", "sha256": "a" * 64, "commit": "b" * 40}
    for record, word in ((RECORD, "*Exploratory*"), (RECORD | {"registration": noted}, "*Registered*")):
        index = make_results.index({"deer": record}, "{origin: deer}\n\n{studies}")
        assert index.startswith(word)
        assert "[deer](deer.md) 1/2" in index
        assert "`python -m studies.deer --fresh`" in index


def test_each_finding_has_a_question_a_figure_a_limitation_and_a_command():
    findings = (EVIDENCE / "index.md").read_text(encoding="utf-8").split("\n## ")[1:-1]
    assert 8 <= len(findings) <= 16
    for finding in findings:
        assert finding.partition("\n")[0].endswith("?")
        (image,) = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", finding)
        assert (EVIDENCE / image).is_file()
        assert re.search(r"\d \(−?[\d.%]+ to −?[\d.%]+\)|\d in 0", finding), "an effect with its interval"
        assert "**Limitation.**" in finding
        assert "`python -m studies." in finding
        assert ("*Registered*" in finding) != ("*Exploratory*" in finding)


def test_every_claim_can_be_reached_at_its_new_and_its_former_place():
    former = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    for claim in claims.read():
        name, page = f"claim-{claim['id']}", EVIDENCE / f"{claim['study']}.md"
        assert name in anchors(page.read_text(encoding="utf-8"))
        assert f'<a id="{name}"></a>[{claim["id"]}](evidence/{page.name}#{name})' in former


def test_links_to_evidence_lead_to_pages_and_anchors_that_are_there():
    pages = [ROOT / "README.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("ecs_eco/worlds/*/README.md")]
    for page in pages:
        for target, anchor in LINK.findall(page.read_text(encoding="utf-8")):
            aim = (page.parent / target).resolve()
            assert aim.is_file(), f"{page}: {target}"
            known = anchors(aim.read_text(encoding="utf-8"))
            assert not anchor or anchor.removeprefix("#") in known, f"{page}: {target}{anchor}"
