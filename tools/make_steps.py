"""Write the table in docs/explanation/steps.md from studies/results/steps.json; with --check, only compare.

python tools/make_steps.py [--check]
"""

import json
import sys
from pathlib import Path

from cells import table

ROOT = Path(__file__).parents[1]
PAGE, RESULT = ROOT / "docs" / "explanation" / "steps.md", ROOT / "studies" / "results" / "steps.json"
MARKS = ("<!-- steps: written by tools/make_steps.py -->", "<!-- end of steps -->")


def main() -> int:
    """Write or check the page."""
    measured, page = json.loads(RESULT.read_text(encoding="utf-8"))["table"], PAGE.read_text(encoding="utf-8")
    before, rest = page.split(MARKS[0])
    lines = table(measured["head"], measured["rows"])
    written = f"{before}{MARKS[0]}\n\n{lines}\n\n{MARKS[1]}{rest.split(MARKS[1])[1]}"
    if "--check" not in sys.argv:
        PAGE.write_text(written, encoding="utf-8")
    elif written != page:
        print(f"{PAGE} is out of date: run python tools/make_steps.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
