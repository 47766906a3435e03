"""Write each shipped world's ODD description to docs/reference/odd, using `ecs_eco.odd`; with --check, only
compare."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ecs_eco.config.shipped import shipped, titles
from ecs_eco.odd import describe

PAGES = Path(__file__).parents[1] / "docs" / "reference" / "odd"
NOTE = "<!-- Written by tools/make_odd.py from world files and declarations: change those, not this page. -->"
INDEX = """# ODD descriptions

{note}

These pages describe the shipped worlds, following the ODD protocol (Grimm et al. 2020).
`ecs-eco describe WORLD` writes such a page for any world ([how to](../../how-to/describe.md)).

| world | |
|---|---|
{rows}

```{{toctree}}
:hidden:

{names}
```
"""


def pages() -> dict[str, str]:
    """Return the pages' text by file name."""
    files = {name: name.replace("-", "_") for name in shipped()}
    texts = {f"{file}.md": describe(name).markdown() for name, file in files.items()}
    texts = {file: text.replace("\n", f"\n\n{NOTE}\n", 1) for file, text in texts.items()}
    rows = "\n".join(f"| [{name}]({files[name]}.md) | {title} |" for name, title in titles().items())
    return texts | {"index.md": INDEX.format(note=NOTE, rows=rows, names="\n".join(files.values()))}


def main() -> int:
    """Write or compare the pages."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition(";")[0])
    parser.add_argument("--check", action="store_true", help="only compare")
    check = parser.parse_args().check
    wanted = pages()
    there = {path.name: path.read_text(encoding="utf-8") for path in PAGES.glob("*.md")}
    if check:
        stale = sorted(name for name in wanted.keys() | there if wanted.get(name) != there.get(name))
        for name in stale:
            print(f"docs/reference/odd/{name} is out of date: run python tools/make_odd.py", file=sys.stderr)
        return bool(stale)
    PAGES.mkdir(exist_ok=True)
    for name in there.keys() - wanted.keys():
        (PAGES / name).unlink()
    for name, text in wanted.items():
        (PAGES / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
