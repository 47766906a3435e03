"""The part of a report on learning and actions, and the page of a training."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis import learning
from ecs_eco.analysis.page import drawn, interval, number, page, table, write_text
from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.style import colors, colors_of

NOTE = (
    "<p class='under'>Means over the first and the last tenth. Reward is the change of happiness "
    "after a decision. Entropy measures how undecided the policy is, and falls as it learns. The KL "
    "divergence measures how far an update moved the policy. Explained variance is the fraction of "
    "the returns' variance that the value function predicted: 1 all, 0 none, negative worse than "
    "their mean. If individuals have their own networks, these are means over the individuals that "
    "learned.</p>"
)


WORDS = {
    "happiness": "mean happiness",
    "intake": "intake per animal and second",
    "deaths": "deaths per animal and second",
}


def blocks(run: Path, series: Series, place: Path) -> list[str]:
    """Return diagnostics of learning and frequencies of actions, if recorded, with figures below `place`."""
    updates, acts = learning.read(run, "learning"), learning.read(run, "actions")
    out = []
    if updates is not None and len(updates):
        out += learnt(learning.updates_of(updates), learning.happiness_of(series), colors_of(series), place)
    if acts is not None and len(acts):
        out.append("<h2>Actions</h2>")
        for s, of in learning.acts_of(acts).items():
            number_of = f"-{series.index(s)}" if s in series.species else ""
            out.append(done(of, s, place / "figures" / f"actions{number_of}.svg"))
    return out


def learnt(
    updates: Mapping[str, learning.Updates],
    happiness: Mapping[str, tuple[np.ndarray, np.ndarray]],
    hue: Mapping[str, str],
    place: Path,
) -> list[str]:
    """Return the heading, the figure and the table of learning diagnostics."""
    figure = learning.diagnostics(updates, happiness, hue)
    words = ("reward", "happiness", "entropy", "approx_kl", "explained_variance")
    rows = []
    for s, of in updates.items():
        told = learning.summary(of, happiness.get(s))
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
    caption = "Diagnostics of policy updates, and mean happiness, by species."
    return [
        "<h2>Learning</h2>",
        drawn(figure, place / "figures" / "learning.svg", caption),
        table(head, rows),
        NOTE,
    ]


def done(acts: learning.Acts, species: str, file: Path) -> str:
    """Return the figure of a species' actions."""
    caption = f"Fraction of {species} that do each action, by group of actions."
    return drawn(learning.actions(acts, species), file, caption)


def write_training(result: Mapping[str, Any], out: Path, chosen: Mapping[str, str] | None = None) -> Path:
    """Write training.html and figures of a result of `pretrain`, including `against_random` if present."""
    hue = colors(list(result["curves"]), chosen)
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
        blocks += ["<h2>Actions</h2>"] * (k == 0)
        blocks.append(done(acts, s, out / "figures" / f"actions-{k}.svg"))
    return write_text(out / "training.html", page(f"Training of {result['world']}", *blocks))


def against(found: Mapping[str, Any]) -> list[str]:
    """Return the table that compares trained with random policies."""
    rows = [
        [s, WORDS[word], *(_ends(of[arm]) for arm in ("trained", "random", "difference"))]
        for s, by_word in found.items()
        for word, of in by_word.items()
    ]
    note = (
        "<p class='under'>Neither policy learns here. The worlds are those of the training, with "
        "constant numbers. Means over runs with the same seeds, with 95% intervals.</p>"
    )
    return [
        "<h2>Comparison with random policies</h2>",
        table(["species", "measure", "trained", "random", "difference"], rows),
        note,
    ]


def _ends(x: Sequence[float | None]) -> str:
    return number(x[0]) if x[1] is None else interval(x)


def _arrays(of: Mapping[str, Any]) -> dict[str, np.ndarray]:
    return {word: np.array(values, float) for word, values in of.items() if word != "tick"}
