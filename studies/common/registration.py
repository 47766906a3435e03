"""A study's registration, written before the study runs: studies/registered/NAME.toml.

    name = "fleeing"
    claim = "Deer that can run from wolves do so where it pays."
    ticks = 20000
    seeds = { training = [601, 602], world = [6001, 6002] }   # not used for tuning or selection
    explored = "what was seen before this file was written, and with which seeds"

    [arms.shipped]          # each arm's changes to its world; {} for none
    "species.deer.ppo.entropy_coef" = 0.01

    [hypotheses.runs]
    statement = "deer run more often near a wolf than elsewhere"
    statistic = "studies.fleeing:run_share"    # the function that computes it, as module:name
    replicate = "training seed"
    goal = "above 0"
    margin = 0.05           # if the goal has one

Commit the file before you compute the first result. Its hash is part of the study's configuration, so
changing the file makes all results stale. Verdicts on its hypotheses are registered; all others are
exploratory.
"""

from __future__ import annotations

import hashlib
import subprocess
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parents[1] / "registered"
REQUIRED = ("name", "claim", "ticks", "seeds", "arms", "hypotheses")
OF_A_HYPOTHESIS = ("statement", "statistic", "replicate", "goal")


@dataclass(frozen=True)
class Registration:
    """A study's registration: the file, its content and its hash."""

    path: Path
    content: dict[str, Any]
    sha256: str

    @property
    def hypotheses(self) -> dict[str, dict[str, Any]]:
        """The hypotheses to test, by name."""
        return dict(self.content["hypotheses"])

    @property
    def arms(self) -> dict[str, dict[str, Any]]:
        """Each arm's changes to its world, by arm name."""
        return dict(self.content["arms"])

    def verdict(self, name: str, value: Any, met: bool) -> dict[str, Any]:
        """Return the line with the verdict on a hypothesis. Raises a ValueError for an unregistered
        hypothesis."""
        if name not in self.hypotheses:
            near = get_close_matches(name, self.hypotheses, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise ValueError(
                f"{self.path}: no hypothesis {name!r}; registered are {', '.join(self.hypotheses)}{hint}"
            )
        of = self.hypotheses[name]
        return {
            "statement": of["statement"],
            "value": value,
            "goal": of["goal"],
            "met": bool(met),
            "registered": name,
        }

    def note(self) -> dict[str, str]:
        """Return the entry stored with a result: the file, its hash and its commit.

        Raises a RuntimeError if the file has uncommitted changes.
        """
        commit = self._git("log", "-1", "--format=%H", "--", self.path.name)
        if not commit or self._git("status", "--porcelain", "--", self.path.name):
            raise RuntimeError(f"{self.path} has uncommitted changes; commit it before you run the study")
        return {"file": f"studies/registered/{self.path.name}", "sha256": self.sha256, "commit": commit}

    def _git(self, *words: str) -> str:
        return subprocess.run(
            ["git", *words], cwd=self.path.parent, capture_output=True, text=True, timeout=30, check=False
        ).stdout.strip()


def registration(name: str, folder: Path = FOLDER) -> Registration:
    """Return a study's registration. Raises a ValueError that names the missing entries."""
    path = folder / f"{name}.toml"
    if not path.is_file():
        near = get_close_matches(name, [p.stem for p in folder.glob("*.toml")], 1)
        raise ValueError(f"{path}: no such file" + (f"; did you mean {near[0]!r}?" if near else ""))
    data = path.read_bytes()
    try:
        content = tomllib.loads(data.decode())
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: {error}") from None
    _need(path, content, REQUIRED, "")
    if content["name"] != name:
        raise ValueError(f"{path}: name is {content['name']!r}; expected {name!r}")
    if not content["hypotheses"]:
        raise ValueError(f"{path}: no hypotheses; register at least one")
    for key, of in content["hypotheses"].items():
        _need(path, of, OF_A_HYPOTHESIS, f"hypotheses.{key}.")
        if ":" not in of["statistic"]:
            raise ValueError(
                f"{path}: hypotheses.{key}.statistic is {of['statistic']!r}; expected module:function"
            )
    return Registration(path, content, hashlib.sha256(data).hexdigest())


def _need(path: Path, given: Mapping[str, Any], keys: tuple[str, ...], where: str) -> None:
    if lacking := [key for key in keys if key not in given]:
        verb = "is" if len(lacking) == 1 else "are"
        raise ValueError(f"{path}: {', '.join(where + key for key in lacking)} {verb} missing")
