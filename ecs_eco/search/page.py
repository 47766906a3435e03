"""The page of a search: search.html and its figures."""

from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.figures import survival
from ecs_eco.analysis.page import drawn, number, page, table, write_text
from ecs_eco.analysis.survival import kaplan_meier
from ecs_eco.record.container import inside
from ecs_eco.search import figures
from ecs_eco.search.importance import Importance, ranks
from ecs_eco.search.optimise import merit
from ecs_eco.search.outcome import Outcome, Runs
from ecs_eco.search.posterior import posterior_blocks


def write_page(search: Outcome, result: dict[str, Any]) -> None:
    """Write search.html and figures/ from the content of search.json."""
    folder = inside(search.out, search.out / "figures")
    course = figures.history(search.journal.of("candidate"), len(search.plan.stages) - 1)
    caption = "Each candidate: the stage that it reached, and its score there squeezed into one unit."
    sampled = [] if search.sampler is None else posterior_blocks(search.sampler, result["posterior"], folder)
    title = search.plan.config.title or search.plan.config.name
    blocks = [
        f"<h1>Search: {escape(title)}</h1>",
        f"<p>{escape(_opening(result))}</p>",
        *_confirmed(result, folder),
        *sampled,
        "<h2>The best worlds</h2>",
        _best_table(search, result),
        "<h2>How the search went</h2>",
        drawn(course, folder / "history.svg", caption),
        "<h2>Which numbers were important</h2>",
        *_important(search, result, folder),
    ]
    write_text(search.out / "search.html", page(f"Search: {title}", *blocks))


def _opening(result: dict[str, Any]) -> str:
    best, start = result["confirmation"]["best"], result["confirmation"]["start"]
    spent, whole = f"{result['seconds'] / 60:.1f} minutes", result["by_stage"][-1]
    course = f"{result['candidates']} candidates in {spent} ({result['optimiser']}); {whole} met all runs."
    if not best["runs"]:
        return course
    ticks = f"{result['confirmation']['ticks']:,}"
    share = f"{best['persisted']} of {best['runs']} runs of the best world"
    sentences = [f"On fresh seeds all species persist for {ticks} ticks in {share}."]
    if start["runs"] and start["candidate"] != best["candidate"]:
        sentences.append(f"The world as written: {start['persisted']} of {start['runs']}.")
    return " ".join([*sentences, course])


def _confirmed(result: dict[str, Any], folder: Path) -> list[str]:
    """The part of the page on fresh seeds."""
    both = {"best": result["confirmation"]["best"], "as written": result["confirmation"]["start"]}
    both = {world: c for world, c in both.items() if c["runs"]}
    if not both:
        return []
    curves = {
        world: kaplan_meier([r["lived"] for r in c["lives"]], [r["extinct"] is not None for r in c["lives"]])
        for world, c in both.items()
    }
    lives = survival(
        curves, result["confirmation"]["ticks"], "all species, on seeds that the search did not use"
    )
    rows = [
        [
            world,
            c["runs"],
            c["persisted"],
            number(c["share"]),
            f"{number(c['low'])} … {number(c['high'])}",
            ", ".join(f"{a}/{b}" for a, b in c["by_training_seed"].values()),
            _lost(c["lives"]),
        ]
        for world, c in both.items()
    ]
    caption = "Share of runs in which all species still live, with 95 % bands (Kaplan–Meier)."
    return [
        "<h2>Confirmation</h2>",
        drawn(lives, folder / "survival.svg", caption),
        table(
            ["world", "runs", "all persist", "share", "95 % (Wilson)", "by training seed", "died out first"],
            rows,
        ),
    ]


def _lost(lives: Runs) -> str:
    """Which species died out first, and in how many runs."""
    extinct = [r["extinct"] for r in lives if r["extinct"] is not None]
    return ", ".join(f"{name} {extinct.count(name)}" for name in dict.fromkeys(extinct)) or "–"


def _best_table(search: Outcome, result: dict[str, Any]) -> str:
    plan, best = search.plan, result["best"]
    rows = [
        [
            p.name,
            f"{number(p.low)} … {number(p.high)}",
            number(plan.start[p.name]),
            *(number(b["values"][p.name]) for b in best),
        ]
        for p in plan.parameters
    ]
    rows.append(["score", "", "", *(number(b["score"]) for b in best)])
    rows.append(
        [
            "score on further seeds",
            "",
            "",
            *("–" if b["finals"] is None else number(b["finals"]) for b in best),
        ]
    )
    return table(["number", "range", "as written", *(f"best-{i}" for i in range(1, len(best) + 1))], rows)


def _important(search: Outcome, result: dict[str, Any], folder: Path) -> list[str]:
    if result["importance"] is None:
        return ["<p>There are too few candidates to tell.</p>"]
    plan, entries = search.plan, search.evaluated()
    shares = [Importance(name, **numbers) for name, numbers in result["importance"]["numbers"].items()]
    worse, best, start = ranks([merit(e) for e in entries]), search.ranked[0]["values"], plan.start
    text = (
        f"Read from {len(entries)} candidates: a number is important if the best of them are distributed "
        "over its range "
        "differently from all. A bar that does not pass its line may be chance."
    )
    blocks = [
        f"<p>{text}</p>",
        drawn(
            figures.importance(shares),
            folder / "importance.svg",
            "Share of all importance (PED-ANOVA); chance stays below the line in 19 of 20 cases.",
        ),
        drawn(
            figures.scatter(plan.parameters, entries, worse, start, best),
            folder / "dependence.svg",
            "Each candidate over each of its numbers: the higher, the more of the others are worse.",
        ),
    ]
    if len(plan.parameters) > 1:
        order = np.argsort([-i.share for i in shares]).tolist()
        pairs = figures.pairs(plan.parameters, entries, worse, order, best, start)
        blocks.append(
            drawn(
                pairs, folder / "pairs.svg", "Pairs of the most important numbers; each dot is a candidate."
            )
        )
    return blocks
