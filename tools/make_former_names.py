"""Write docs/reference/former_names.md, the former names that still work; with --check, only compare."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from ecs_eco import _lazy  # noqa: E402
from ecs_eco.config.former import present_names  # noqa: E402
from ecs_eco.config.models.reproduction import Simplified  # noqa: E402
from ecs_eco.lab import treatments  # noqa: E402
from ecs_eco.lab.plan import Plan  # noqa: E402
from ecs_eco.learning import aliases  # noqa: E402
from tools.make_reference import kind_of, parts  # noqa: E402

PAGE = ROOT / "docs" / "reference" / "former_names.md"
HEAD = """# Former names

<!-- Written by tools/make_former_names.py from the declarations: change those, not this page. -->

On this page you can look up the current name of everything whose former name still works. Former names of keys
work in world files, `--set`, interventions, genes and plans; `ecs-eco check` and `run` print the current name.
Former modules, classes and methods give a `DeprecationWarning` with the current name.

| what | former name | current name | where |
|---|---|---|---|
"""
IN_SOURCE = {
    "method": r'"([\w.]+) is deprecated; use ([\w.]+)"',
    "argument": r"(\w+): .*# the former name of (\w+)$",
}


def rows() -> Iterator[tuple[str, str, str, str]]:
    """Yield what has a former name, the former name, the current one, and where it is used."""
    for part in parts():
        for former, now in present_names(part.model).items():
            yield "key", former, now, f"[{part.title}](world/{part.page}.md)"
    for former, now in aliases.FORMER.items():
        yield "key", former, now, "[`species.NAME.ppo`](world/ppo.md)"
    for former, now in present_names(Plan).items():
        yield "key", former, now, "[plan](../how-to/clusters.md)"
    now = f'kind = "asexual", place = "{Simplified.model_fields["place"].default}"'
    yield (
        "kind",
        f'kind = "{kind_of(Simplified)}"',
        now,
        "[`species.NAME.reproduction`](world/reproduction.md)",
    )
    for former, now in treatments.FORMER.items():
        yield "treatment", former, now, "[`--treatment`](../how-to/compare.md)"
    for former, now in _lazy.FORMER.items():
        yield "class" if former.rpartition(".")[2][0].isupper() else "module", former, now, "Python"
    for path in sorted((ROOT / "ecs_eco").rglob("*.py")):
        for what, pattern in IN_SOURCE.items():
            for former, now in re.findall(pattern, path.read_text(encoding="utf-8"), re.MULTILINE):
                yield what, former, now, f"`{path.relative_to(ROOT).as_posix()}`"


def main() -> int:
    """Write the page; with --check, return 1 if it is out of date."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition(";")[0])
    parser.add_argument("--check", action="store_true", help="only compare")
    page = HEAD + "".join(f"| {what} | `{old}` | `{now}` | {where} |\n" for what, old, now, where in rows())
    if not parser.parse_args().check:
        PAGE.write_text(page, encoding="utf-8")
    elif not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != page:
        print("docs/reference/former_names.md is out of date: run python tools/make_former_names.py")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
