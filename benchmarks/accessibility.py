"""Check accessibility with axe, in light and dark: each page of the documentation site, and each page that a
command writes (a run's report, its causes of death, a comparison, a sweep, a search, what evolved).

    python benchmarks/accessibility.py [--site ecs_eco/_site] [--only site|written]

Needs the site (python tools/build_site.py), playwright, axe-playwright-python and Chromium (Debian: apt-get
install chromium). What axe finds on a page of the site is kept in build/accessibility.jsonl, so that an interrupted
check resumes; a page that has changed since is checked again. Exits with code 1 if axe finds anything.
"""

import argparse
import contextlib
import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(Path(__file__).parent), str(ROOT)]
import _bench
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.testing.browser import launched
from tests.view.pages import violations

KEPT, SHADES = ROOT / "build" / "accessibility.jsonl", ("light", "dark")
PLAN = """
world = "predator-prey"
ticks = 20
world_seeds = 2
[grid]
species.wolf.count = [100, 250]
"""
COMMANDS = (
    "run predator-prey --seed 1 --ticks 100 --policies untrained --out run",
    "why run",
    "compare predator-prey --treatment no-wolf --seeds 2 --ticks 20 --workers 1 --out compare",
    "sweep plan.toml --workers 1 --out sweep",
    "sweep collect sweep",
    "search predator-prey --range species.wolf.count=150:300 --trials 3 --ticks 20 --policies untrained"
    " --world-seeds 1 --training-seeds 1 --confirm-world-seeds 1 --confirm-training-seeds 1 --confirm-ticks 20"
    " --workers 1 --out search",
    "run reflexes --seed 1 --ticks 320 --policies untrained --set species.goat.policy.learn=false --out goats",
    "explain goats --species goat --forks 2 --ticks 8 --workers 1",
)
WRITTEN = ("run/report", "run/why", "compare/compare", "sweep/sweep", "search/search", "goats/explain")


def site(folder: Path) -> list[Path]:
    """Return the pages of the site, except source files and recorded runs."""
    pages = [p for p in folder.rglob("*.html") if not {"source", "_static"} & {*p.relative_to(folder).parts}]
    if not pages:
        raise SystemExit(f"{folder}: no pages; build the site: python tools/build_site.py")
    return sorted(pages)


def found(pages: list[Path], kept: Path | None = None) -> Iterator[tuple[str, Path, list[Any]]]:
    """Yield the theme, page and violations of each page; skip axe if `kept` has them for this state of it."""
    known = {}
    if kept and kept.is_file():
        known = {tuple(key): broken for *key, broken in map(json.loads, kept.read_text().splitlines())}
    with launched() as browser:
        for shade in SHADES:
            tab = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme=shade)
            tab.set_default_timeout(600_000)
            for path in pages:
                key = shade, str(path), path.stat().st_mtime_ns
                if key not in known:
                    tab.goto(path.as_uri())
                    known[key] = violations(tab)
                    if kept:
                        with kept.open("a") as file:
                            file.write(json.dumps([*key, known[key]]) + "\n")
                yield shade, path, known[key]
            tab.close()


def rows(what: str, pages: list[Path], kept: Path | None = None) -> list[dict[str, Any]]:
    """Check pages; print what axe finds, and return one row per theme."""
    counts = {shade: {"pages": what, "theme": shade, "checked": 0, "violations": 0} for shade in SHADES}
    for shade, path, broken in found(pages, kept):
        counts[shade]["checked"] += 1  # type: ignore[operator]
        counts[shade]["violations"] += len(broken)  # type: ignore[operator]
        for rule, nodes in broken:
            print(f"{path} ({shade}): {rule}: {nodes}")
    return [{**row, "goal": 0} for row in counts.values()]


def written(folder: Path) -> list[Path]:
    """Run short versions of all commands that write a page; return the pages."""
    (folder / "plan.toml").write_text(PLAN)
    with contextlib.chdir(folder):
        for line in COMMANDS:
            done = CliRunner().invoke(app, line.split(), catch_exceptions=False)
            if done.exit_code:
                raise SystemExit(f"ecs-eco {line}: {done.output}")
    return [folder / f"{name}.html" for name in WRITTEN]


def main() -> int:
    """Check the pages and store the counts."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--site", type=Path, default=ROOT / "ecs_eco" / "_site")
    parser.add_argument("--only", choices=("site", "written"))
    asked = parser.parse_args()
    broken = 0
    if asked.only in (None, "site"):
        KEPT.parent.mkdir(exist_ok=True)
        checked = rows("documentation site", site(asked.site.resolve()), KEPT)
        _bench.save("accessibility", "Rules of axe broken by the documentation site", checked)
        broken += sum(row["violations"] for row in checked)
    if asked.only in (None, "written"):
        with tempfile.TemporaryDirectory() as folder:
            checked = rows("pages that commands write", written(Path(folder)))
        notes = {"pages": ", ".join(f"{name}.html" for name in WRITTEN)}
        _bench.save("accessibility_written", "Rules of axe broken by reports", checked, notes)
        broken += sum(row["violations"] for row in checked)
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main())
