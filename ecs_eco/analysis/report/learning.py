"""The part of a report on what policies learnt, and on what organisms do."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ecs_eco.analysis import figures, learning
from ecs_eco.analysis.page import number, picture, table
from ecs_eco.analysis.runs import Series

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOTE = (
    "<p class='under'>Means over the first and the last tenth. Reward is the change of happiness after a "
    "decision; entropy says how undecided the policy is, and falls as it learns; the KL divergence says how "
    "far an update moved it; explained variance is the share of the returns' variance that the value "
    "foresaw: 1 all, 0 none, below 0 worse than their mean. Of individuals with networks of their own, means "
    "over those that learnt.</p>"
)


def blocks(run: Path, series: Series, place: Path) -> list[str]:
    """Diagnostics of learning and frequencies of actions; nothing where neither was recorded.

    Figures are written below `place`.
    """
    updates, acts = learning.read(run, "learning"), learning.read(run, "actions")
    hue = figures.colors(series.species, series.manifest.get("colors"))
    out = []
    if updates is not None and len(updates):
        out += learnt(learning.updates_of(updates), learning.happiness_of(series), hue, place)
    if acts is not None and len(acts):
        out.append("<h2>What they do</h2>")
        for s, of in learning.acts_of(acts).items():
            name = f"actions-{series.index(s)}" if s in series.species else "actions"
            out.append(
                drawn(
                    place,
                    name,
                    learning.actions(of, s),
                    f"Share of {s} that do each action, of each group one.",
                )
            )
    return out


def learnt(
    updates: Mapping[str, learning.Updates],
    happiness: Mapping[str, tuple[object, object]],
    hue: Mapping[str, str],
    place: Path,
) -> list[str]:
    """The heading, the figure and the table of what learners said."""
    figure = learning.diagnostics(updates, happiness, hue)  # type: ignore[arg-type]
    words = ("reward", "happiness", "entropy", "approx_kl", "explained_variance")
    rows = []
    for s, of in updates.items():
        told = learning.summary(of, happiness.get(s))  # type: ignore[arg-type]
        rows.append(
            [
                s,
                f"{told['updates']:,}",
                f"{told['transitions']:,}",
                *(" → ".join(number(x) for x in told[w]) if w in told else "–" for w in words),
            ]
        )
    head = [
        "species",
        "updates",
        "transitions",
        "reward",
        "happiness",
        "entropy [nat]",
        "KL [nat]",
        "explained variance",
    ]
    caption = "What policies say of each update, and mean happiness, by species."
    return ["<h2>Learning</h2>", drawn(place, "learning", figure, caption), table(head, rows), NOTE]


def drawn(place: Path, name: str, figure: Figure, caption: str) -> str:
    """A figure, written below `place`, as HTML."""
    return picture(figures.save_svg(figure, place / "figures" / f"{name}.svg"), caption)
