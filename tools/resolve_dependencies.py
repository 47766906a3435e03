"""Resolve the version ranges in pyproject.toml for every platform and Python version, using only wheels.

    python tools/resolve_dependencies.py            # queries the package index; needs uv (pip install uv)
    python tools/resolve_dependencies.py --page     # rewrites the page's table from the stored result

Writes tools/resolved.json (all packages for all platforms) and the table in docs/reference/supported.md.
"""

import argparse
import json
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
FOUND, PAGE = ROOT / "tools" / "resolved.json", ROOT / "docs" / "reference" / "supported.md"
PLATFORMS = {
    "Linux, x86-64": "x86_64-manylinux_2_28",
    "Linux, ARM": "aarch64-manylinux_2_28",
    "macOS, Apple silicon": "aarch64-apple-darwin",
    "macOS, Intel": "x86_64-apple-darwin",
    "Windows, x86-64": "x86_64-pc-windows-msvc",
}
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
LOWEST = "3.11, lowest"  # the lowest versions that the ranges allow
SHOWN = ("numpy", "numba", "torch", "pyarrow")
TABLE = re.compile(r"(?<=<!-- resolved -->\n).*?(?=<!-- end of resolved -->)", re.DOTALL)


def resolve(platform: str, python: str) -> dict[str, str]:
    """Return version by package, or {"": uv's message} if no versions fit."""
    how = ["--resolution", "lowest-direct"] if python == LOWEST else []
    command = [
        sys.executable,
        "-m",
        "uv",
        "pip",
        "compile",
        "pyproject.toml",
        "--only-binary",
        ":all:",
        "--no-header",
        "--no-annotate",
        "--quiet",
        "--python-platform",
        platform,
        "--python-version",
        python.partition(",")[0],
        *how,
    ]
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PIP_")}
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=environment, check=False)
    if done.returncode:
        return {"": " ".join(done.stderr.split())[:600]}
    return dict(line.split(" ")[0].split("==") for line in done.stdout.splitlines() if "==" in line)


def table(found: dict[str, Any]) -> str:
    """Return the page's table: the versions of the listed packages for each platform and Python version."""
    head = ["platform", "Python", *SHOWN]
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for platform, pythons in found["platforms"].items():
        for python, versions in pythons.items():
            cells = [versions.get(name, "nothing fits") for name in SHOWN]
            lines.append(f"| {platform} | {python} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Resolve, write and print; or write the table from the last result."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("--page", action="store_true", help="write only the table")
    if not parser.parse_args().page:
        found: dict[str, Any] = {"ranges": ranges(), "platforms": {}}
        for name, platform in PLATFORMS.items():
            with ThreadPoolExecutor(5) as pool:
                resolved = pool.map(partial(resolve, platform), (*PYTHONS, LOWEST))
                found["platforms"][name] = dict(zip((*PYTHONS, LOWEST), resolved, strict=True))
            for python, versions in found["platforms"][name].items():
                print(name, python, versions.get("", f"{len(versions)} packages"), flush=True)
        FOUND.write_text(json.dumps(found, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    resolved = table(json.loads(FOUND.read_text(encoding="utf-8")))
    PAGE.write_text(TABLE.sub(lambda _: resolved, PAGE.read_text(encoding="utf-8")), encoding="utf-8")


def ranges() -> list[str]:
    """Return the dependencies in pyproject.toml."""
    import tomllib

    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]


if __name__ == "__main__":
    main()
