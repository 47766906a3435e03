"""Learning over time: diagnostics of policy updates, frequencies of actions, and the training page."""

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from ecs_eco.analysis.page import drawn, interval, number, page, table, write_text
from ecs_eco.analysis.palette import AXIS, TIME
from ecs_eco.analysis.runs import Series, whole_table
from ecs_eco.analysis.style import Figure, colors, colors_of, over_ticks, panels, styled
from ecs_eco.record.parquet import to_numpy

POINTS = 150  # maximum number of points per curve
SHOWN = {
    "reward": "reward per decision",
    "happiness": "mean happiness",
    "entropy": "entropy [nat]",
    "approx_kl": "KL divergence [nat]",
    "explained_variance": "explained variance",
    "clip_fraction": "fraction of clipped ratios",
}
"""The curves of the learning figure in order, with their axis labels."""


@dataclass(frozen=True)
class Updates:
    """The policy updates of one species; `columns` f64[updates] are those of `ecs_eco.record.learning.UPDATE`."""

    ticks: np.ndarray
    columns: dict[str, np.ndarray]


@dataclass(frozen=True)
class Acts:
    """The fraction of deciding organisms that took each of a species' actions, f64[samples, actions]."""

    ticks: np.ndarray
    actions: tuple[str, ...]  # names such as "speed.run"
    share: np.ndarray

    @property
    def groups(self) -> dict[str, list[int]]:
        """The columns of each action group, by name."""
        out: dict[str, list[int]] = {}
        for i, action in enumerate(self.actions):
            out.setdefault(action.partition(".")[0], []).append(i)
        return out


def updates_of(table: pa.Table) -> dict[str, Updates]:
    """Return the updates of each species from a table of `Recorder.learning_series`."""
    species = np.array(table["species"].cast(pa.string()).to_pylist(), object)
    columns = {
        name: np.asarray(c.to_numpy() if c.null_count else to_numpy(c), float)
        for name, c in zip(table.column_names, table.columns, strict=True)
        if name not in ("tick", "species")
    }
    ticks = to_numpy(table["tick"])
    return {
        s: Updates(ticks[species == s], {name: v[species == s] for name, v in columns.items()})
        for s in dict.fromkeys(species.tolist())
    }


def acts_of(table: pa.Table) -> dict[str, Acts]:
    """Return the actions of each species from a table of `Recorder.action_series`."""
    species, action = (
        np.array(table[name].cast(pa.string()).to_pylist(), object) for name in ("species", "action")
    )
    ticks, done, of = (to_numpy(table[name]) for name in ("tick", "n", "of"))
    out = {}
    for s in dict.fromkeys(species.tolist()):
        chosen = species == s
        names = tuple(dict.fromkeys(action[chosen].tolist()))
        when, row = np.unique(ticks[chosen], return_inverse=True)
        share = np.full((len(when), len(names)), np.nan)
        share[row, [names.index(a) for a in action[chosen]]] = done[chosen] / of[chosen]
        out[s] = Acts(when, names, share)
    return out


def thinned(ticks: np.ndarray, values: np.ndarray, points: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Return means of ticks and values over at most `points` equal blocks, NaN for blocks without values."""
    edges = np.linspace(0, len(ticks), min(points, len(ticks)) + 1).astype(int)[:-1]
    if not len(edges):
        return ticks.astype(float), values
    known = np.isfinite(values)
    n = np.add.reduceat(known.astype(float), edges)
    total = np.add.reduceat(np.where(known, values, 0.0), edges)
    size = np.diff(np.append(edges, len(ticks)))
    return np.add.reduceat(ticks.astype(float), edges) / size, total / np.where(n, n, np.nan)


@styled
def diagnostics(
    updates: Mapping[str, Updates],
    happiness: Mapping[str, tuple[np.ndarray, np.ndarray]],
    hue: Mapping[str, str],
) -> Figure:
    """Plot reward, happiness and PPO diagnostics over time, with a line for each learning species."""
    figure, axes = panels(3, 2, 9.4, 6.6, sharex=True)
    for ax, (word, label) in zip(axes.flat, SHOWN.items(), strict=True):
        for s, found in updates.items():
            given = happiness.get(s) if word == "happiness" else (found.ticks, found.columns[word])
            if given is not None:
                few = ".-" if len(given[0]) < 20 else "-"
                ax.plot(*thinned(*given), few, color=hue[s], label=s)
        ax.set(ylabel=label)
        ax.margins(x=0.01)
        if word == "explained_variance":
            low = ax.get_ylim()[0]
            ax.set_ylim(max(low, -1.0), 1.02)
            ax.axhline(0, color=AXIS, lw=0.8, ls=":")
        elif word in ("entropy", "approx_kl", "clip_fraction"):
            low, high = ax.dataLim.intervaly if ax.has_data() else (0.0, 1.0)
            ax.set_ylim(min(0.0, low), 1.08 * max(high, 1e-6))
    for ax in axes[-1]:
        ax.set_xlabel("tick")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=6)
    return figure


@styled
def actions(acts: Acts, title: str = "") -> Figure:
    """Plot the frequencies of actions over time, as stacked fractions for each action group."""
    groups = {g: at for g, at in acts.groups.items() if len(at) > 1 or np.ptp(acts.share[:, at[0]]) > 0}
    groups = groups or acts.groups
    figure, axes = over_ticks(len(groups), 1.9, 0.7)
    for ax, (group, at) in zip(axes, groups.items(), strict=True):
        curves = [thinned(acts.ticks, acts.share[:, i]) for i in at]
        ax.stackplot(
            curves[0][0],
            [np.nan_to_num(c[1]) for c in curves],
            lw=0,
            labels=[acts.actions[i].partition(".")[2] for i in at],
            colors=[TIME[(len(TIME) - 1) * k // max(len(at) - 1, 1)] for k in range(len(at))],
        )
        ax.set(ylabel="share", ylim=(0, 1), title=f"{title}: {group}" if title else group)
        ax.margins(x=0)
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def happiness_of(series: Series) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the ticks and the mean happiness of each species, with NaN while it is absent."""
    if "happiness_mean" not in series.columns:
        return {}
    return {
        s: (series.ticks, np.where(series.n[:, i] > 0, series.columns["happiness_mean"][:, i], np.nan))
        for i, s in enumerate(series.species)
    }


def summary(updates: Updates, happiness: tuple[np.ndarray, np.ndarray] | None = None) -> dict[str, Any]:
    """Return the numbers of updates and transitions, and each quantity's first and last tenth (means)."""

    def ends(values: np.ndarray) -> tuple[float, float]:
        tenth = max(1, len(values) // 10)
        first, last = (v[np.isfinite(v)] for v in (values[:tenth], values[-tenth:]))
        return (float(first.mean()) if first.size else np.nan, float(last.mean()) if last.size else np.nan)

    out: dict[str, Any] = {
        "updates": int(updates.columns["n_learners"].sum()),
        "transitions": int(updates.columns["n_transitions"].sum()),
    }
    out |= {word: ends(updates.columns[word]) for word in SHOWN if word != "happiness"}
    return out if happiness is None else out | {"happiness": ends(happiness[1])}


NOTE = (
    "<p class='under'>Means over the first and the last tenth of the updates. Reward is the change in "
    "happiness after a decision. Entropy measures how undecided the policy is, and falls as it learns. The "
    "KL divergence measures how far an update moved the policy. Explained variance is the fraction of the "
    "returns' variance that the value function predicts: 1 is all, 0 is none, and a negative value is worse "
    "than predicting their mean. If individuals have their own networks, values are means over the "
    "individuals that learned.</p>"
)


ARMS = ("trained", "random", "difference")
WORDS = {
    "happiness": "mean happiness",
    "intake": "intake per animal per second",
    "deaths": "deaths per animal per second",
}


def blocks(run: Path, series: Series, place: Path) -> list[str]:
    """Return the sections on learning and on actions, if recorded, and write their figures to `place`."""
    updates, acts = (whole_table(run, kind) for kind in ("learning", "actions"))
    out = []
    if len(updates):
        out += learnt(updates_of(updates), happiness_of(series), colors_of(series), place)
    if len(acts):
        numbers = {s: f"-{i}" for i, s in enumerate(series.species)}
        out += done({s: (of, numbers.get(s, "")) for s, of in acts_of(acts).items()}, place)
    return out


def learnt(
    updates: Mapping[str, Updates],
    happiness: Mapping[str, tuple[np.ndarray, np.ndarray]],
    hue: Mapping[str, str],
    place: Path,
) -> list[str]:
    """Return the section on learning diagnostics: heading, figure and table."""
    figure = diagnostics(updates, happiness, hue)
    words = ("reward", "happiness", "entropy", "approx_kl", "explained_variance")
    rows = []
    for s, of in updates.items():
        told = summary(of, happiness.get(s))
        ends = (" → ".join(map(number, told[w])) if w in told else "–" for w in words)
        rows.append([s, f"{told['updates']:,}", f"{told['transitions']:,}", *ends])
    head = ["species", "updates", "transitions", "reward", "happiness", "entropy [nat]", "KL [nat]"]
    caption = "Diagnostics of policy updates and mean happiness, by species."
    return [
        "<h2>Learning</h2>",
        drawn(figure, place / "figures" / "learning.svg", caption),
        table([*head, "explained variance"], rows),
        NOTE,
    ]


def done(acts: Mapping[str, tuple[Acts, str]], place: Path) -> list[str]:
    """Return the heading and figures of actions; `acts` also contains the file-name suffixes."""
    caption = "Fraction of {} that take each action, by action group."
    files = {s: place / "figures" / f"actions{end}.svg" for s, (_, end) in acts.items()}
    figures = (drawn(actions(of, s), files[s], caption.format(s)) for s, (of, _) in acts.items())
    return ["<h2>Actions</h2>", *figures]


def write_training(result: Mapping[str, Any], out: Path, chosen: Mapping[str, str] | None = None) -> Path:
    """Write training.html and the figures for a result of `pretrain`, including `against_random` if present."""
    hue = colors(list(result["curves"]), chosen)
    happiness = {
        s: (np.array(c["tick"], float), np.array(c["happiness"], float)) for s, c in result["curves"].items()
    }
    updates = {s: Updates(np.array(of["tick"]), _arrays(of)) for s, of in result["learning"].items()}
    blocks = [
        f"<h1>Training of {escape(result['world'])}</h1>",
        f"<p class='under'>{result['ticks']:,} ticks, seed {result['seed']}.</p>",
    ]
    if "against_random" in result:
        blocks += against(result["against_random"])
    if updates:
        blocks += learnt(updates, happiness, hue, out)
    acts = {}
    for k, (s, of) in enumerate(result["actions"].items()):
        shares = _arrays(of)
        acts[s] = Acts(np.array(of["tick"]), tuple(shares), np.stack(list(shares.values()), 1)), f"-{k}"
    blocks += done(acts, out) if acts else []
    return write_text(out / "training.html", page(f"Training of {result['world']}", *blocks))


def against(found: Mapping[str, Any]) -> list[str]:
    """Return the section that compares trained with random policies."""
    rows = [
        [s, WORDS[word], *(number(x[0]) if x[1] is None else interval(x) for x in map(of.get, ARMS))]
        for s, by_word in found.items()
        for word, of in by_word.items()
    ]
    note = (
        "<p class='under'>Neither policy learns here. The worlds are the training worlds, with constant "
        "numbers of organisms. Values are means over runs with the same seeds, with 95% intervals.</p>"
    )
    return ["<h2>Comparison with random policies</h2>", table(["species", "measure", *ARMS], rows), note]


def _arrays(of: Mapping[str, Any]) -> dict[str, np.ndarray]:
    return {word: np.array(values, float) for word, values in of.items() if word != "tick"}
