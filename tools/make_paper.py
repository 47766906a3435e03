"""Write docs/paper.md from tools/paper.md, replacing fields with numbers from the results; see
tools/fields.py.

    python tools/make_paper.py [--check]
"""

import argparse
import sys
from pathlib import Path

from fields import written  # a file in this folder

ROOT = Path(__file__).parents[1]
TEMPLATE, PAGE = Path(__file__).with_name("paper.md"), ROOT / "docs" / "paper.md"


def main() -> int:
    """Write or check the page."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit with 1 if it is out of date"
    )
    asked = parser.parse_args()
    page = written(TEMPLATE.read_text(encoding="utf-8"))
    if not asked.check:
        PAGE.write_text(page, encoding="utf-8")
    elif not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != page:
        print(f"{PAGE} is out of date: run python tools/make_paper.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
