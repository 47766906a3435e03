"""A result's provenance: package versions and the code's commit."""

from __future__ import annotations

import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = ("ecs-eco", "esper", "numpy", "numba", "torch", "deap", "scipy")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that affect results."""
    versions_of = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            versions_of[name] = version(name)
        except PackageNotFoundError:
            continue
    return versions_of


def commit() -> dict[str, Any]:
    """Return the current git commit, and whether tracked files other than results and docs differ from it."""

    def git(*words: str) -> str | None:
        try:
            done = subprocess.run(
                ["git", *words],
                cwd=Path(__file__).parent,
                capture_output=True,
                text=True,
                timeout=30,
                check=True,
            )
        except (OSError, subprocess.SubprocessError):
            return None
        return done.stdout.strip()

    changed = git(
        "status",
        "--porcelain",
        "--untracked-files=no",
        "--",
        ":/",
        ":(exclude,top)studies/results",
        ":(exclude,top)docs",
    )
    return {"commit": git("rev-parse", "HEAD"), "dirty": changed is None or bool(changed)}
