"""The page of a training: how policies learnt, and how they do beside random ones."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis import figures, learning
from ecs_eco.analysis.page import number, page, table, write_text
from ecs_eco.analysis.report.learning import drawn, learnt

WORDS = {
    "happiness": "mean happiness",
    "intake": "intake per animal and second",
    "deaths": "deaths per animal and second",
}


def write_training(result: Mapping[str, Any], out: Path, colors: Mapping[str, str] | None = None) -> Path:
    """Write training.html and figures of what `pretrain` returned into a folder; `against_random` in it where
    it was measured."""
    hue = figures.colors(list(result["curves"]), colors)
    happiness = {
        s: (np.array(c["tick"], float), np.array(c["happiness"], float)) for s, c in result["curves"].items()
    }
    updates = {s: learning.Updates(np.array(of["tick"]), _arrays(of)) for s, of in result["learning"].items()}
    blocks = [
        f"<h1>Training of {escape(result['world'])}</h1>",
        f"<p class='under'>{result['ticks']:,} ticks, seed {result['seed']}.</p>",
    ]
    if "against_random" in result:
        blocks += against(result["against_random"])
    if updates:
        blocks += learnt(updates, happiness, hue, out)
    for k, (s, of) in enumerate(result["actions"].items()):
        names = [name for name in of if name != "tick"]
        acts = learning.Acts(np.array(of["tick"]), tuple(names), np.stack(list(_arrays(of).values()), 1))
        blocks += ["<h2>What they do</h2>"] * (k == 0)
        blocks.append(
            drawn(
                out,
                f"actions-{k}",
                learning.actions(acts, s),
                f"Share of {s} that do each action, of each group one.",
            )
        )
    return write_text(out / "training.html", page(f"Training of {result['world']}", *blocks))


def against(found: Mapping[str, Any]) -> list[str]:
    """The table of trained policies beside random ones."""
    rows = [
        [s, WORDS[word], *(_interval(of[arm]) for arm in ("trained", "random", "difference"))]
        for s, by_word in found.items()
        for word, of in by_word.items()
    ]
    note = (
        "<p class='under'>Neither learns, in worlds of the training with numbers held constant; means "
        "over runs with the same seeds, with 95 % intervals.</p>"
    )
    return [
        "<h2>Beside random policies</h2>",
        table(["species", "measure", "trained", "random", "difference"], rows),
        note,
    ]


def _interval(x: Any) -> str:
    return number(x[0]) if x[1] is None else f"{number(x[0])} ({number(x[1])} … {number(x[2])})"


def _arrays(of: Mapping[str, Any]) -> dict[str, np.ndarray]:
    return {word: np.array(values, float) for word, values in of.items() if word != "tick"}
