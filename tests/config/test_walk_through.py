"""The walk-through of docs/explanation/architecture.md touches what a shipped feature touches, and no more."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
SLOWS_DOWN = re.compile(r"\b(ectothermy|Ectothermy|SlowDown|slow_down)\b")


def test_the_files_that_the_walk_through_names_are_those_that_name_the_feature():
    page = (ROOT / "docs" / "explanation" / "architecture.md").read_text(encoding="utf-8")
    steps = page.partition("## Add a feature")[2].partition("\n## ")[0]
    named = set(re.findall(r"\.\./\.\./([\w/]+\.py)", steps))
    files = [*(ROOT / "ecs_eco").rglob("*.py"), *(ROOT / "tests").rglob("*.py")]
    touched = {
        file.relative_to(ROOT).as_posix()
        for file in files
        if file != Path(__file__) and SLOWS_DOWN.search(file.read_text(encoding="utf-8"))
    }
    assert named == touched
    assert len(touched) <= 7  # 6 without numbers that a gene codes for
    assert sum(len((ROOT / file).read_text("utf-8").splitlines()) for file in touched if "slow" in file) < 120
