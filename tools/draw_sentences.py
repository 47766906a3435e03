"""Draw random sentences from all texts that people read, for an editor to judge one by one.

    python -m tools.draw_sentences [--seed 1] [--count 150]

Pages, docstrings, comments and program texts (errors, help, labels) are drawn in proportion to their number
of sentences. Generated pages and stored results are omitted, because their sentences come from the sources.
`sentences_read.json` is an independent reading (seed 2811, "foreign": verdicts of two editors). It was blind: 100
sentences from numpy, scipy, matplotlib, pandas and other packages were mixed in, because editors differ in
strictness. Asked which sentences sound foreign, one editor marked 1 of 150 sentences here and 4 of the other 100,
and the second editor 0 and 5. `sentences_read_strictly.json` (seed 2911) is the reading of a third editor, asked to
mark every sentence that is foreign or unnatural, and to mark it when in doubt: 24 of 150 here, 12 of the other 100.
"""

from __future__ import annotations

import argparse
import json
import random
import re
from collections.abc import Iterator

from tools.plain_words import PLACES, ROOT, files, texts

END = re.compile(r"(?<=[.!?:])\s+(?=[A-Z`*\"])|\n\s*\n|\n\s*(?=[-*|#>]|\d+\. )")


def sentences() -> Iterator[tuple[str, str, str]]:
    """Yield the location, kind and words of each sentence with at least four words."""
    for path in files([ROOT / place for place in PLACES]):
        for line, kind, text in texts(path):
            if (kind == "page" and "<!-- Written by tools/" in text) or text.startswith("type: ignore"):
                continue
            prose = re.sub(r"^```.*?^```$", "\n\n", text, flags=re.M | re.S)
            for part in END.split(prose):
                words = " ".join(part.split())
                if (
                    len(re.findall(r"[A-Za-z]{2,}", words)) >= 4
                    and not words.startswith("@")
                    and words.count("|") < 2
                ):
                    yield f"{path.relative_to(ROOT)}:{line}", kind, words


def main() -> None:
    """Print the drawn sentences as JSON lines: number, location, kind and sentence."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=150)
    asked = parser.parse_args()
    drawn = random.Random(asked.seed).sample(list(sentences()), asked.count)
    for number, (place, kind, words) in enumerate(drawn, 1):
        print(json.dumps({"n": number, "place": place, "kind": kind, "sentence": words}, ensure_ascii=False))


if __name__ == "__main__":
    main()
