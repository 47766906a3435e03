"""What a search leaves for people and programs: the best worlds, search.json, figures and search.html."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.analysis.survival import kaplan_meier, wilson
from ecs_eco.record.folder import git_commit, versions, write_json
from ecs_eco.search.optimise import merit
from ecs_eco.search.write import write_world

if TYPE_CHECKING:
    from ecs_eco.search.run import Search

Runs = list[dict[str, Any]]


def write_results(search: Search, world: Any, overrides: Any, report: bool) -> dict[str, Any]:
    """Write best-1.toml …, search.json, and with `report` the page; return what search.json holds."""
    from ecs_eco.search.run import BEST

    ranked = search.ranked()
    result = summary(search, ranked)
    for rank, entry in enumerate(ranked[:BEST], 1):
        number = entry["candidate"]
        kind = search.plan.config.search.policies
        trained = search.out / "policies" / ("start" if kind == "train-once" else f"candidate-{number}")
        note = f"Candidate {number} of a search, number {rank} of {len(ranked)}: {_words(entry, result)}."
        values = entry["values"] if number else {}
        write_world(search.plan, world, overrides, values, trained, search.out / f"best-{rank}.toml", note)
    result["matters"] = _matters(search, ranked)
    write_json(search.out / "search.json", result)
    if report:
        _page(search, ranked, result)
    return result


def summary(search: Search, ranked: Runs) -> dict[str, Any]:
    """What a search found, as JSON holds it."""
    plan, best = search.plan, ranked[0]
    confirmed = {who: confirmation(search, number) for who, number in (("best", best["candidate"]), ("start", 0))}
    finals = {e["candidate"]: e for e in search.journal.of("final")}
    return {
        **plan.header(), "optimiser": search.kind, "workers": search.pool.workers, "seconds": search.journal.entries[-1]["at"],
        "seconds_of_candidates": max(e["at"] for e in search.journal.of("candidate")),
        "candidates": len(ranked), "by_stage": [sum(e["stage"] >= s for e in ranked) for s in range(len(plan.stages))],
        "stages": plan.stages, "cells": plan.cells, "start": plan.start,
        "best": [{"candidate": e["candidate"], "values": e["values"], "stage": e["stage"], "score": e["score"],
                  "finals": finals[e["candidate"]]["score"] if e["candidate"] in finals else None} for e in ranked[:5]],
        "best_so_far": _best_so_far(search.journal.of("candidate")),
        "confirmation": {"ticks": plan.confirmation_ticks, "cells": plan.confirmation, **confirmed},
        "versions": versions(), "git_commit": git_commit(),
    }  # fmt: skip


def _best_so_far(entries: Runs) -> list[list[float]]:
    """[seconds, merit] whenever it rose."""
    found: list[list[float]] = []
    for e in sorted(entries, key=lambda e: e["at"]):
        if not found or merit(e) > found[-1][1]:
            found.append([e["at"], merit(e)])
    return found


def confirmation(search: Search, candidate: int) -> dict[str, Any]:
    """Runs on fresh seeds: how many there were, in how many all lived, Wilson's 95 % interval, and each run."""
    entries = [e for e in search.journal.of("confirmation") if e["candidate"] == candidate]
    runs = [run for e in entries for stage in e["stages"] for run in stage["runs"]]
    kept = sum(run["extinct"] is None for run in runs)
    share = wilson(kept, len(runs))
    trainings = sorted({run["training"] for run in runs})
    each = {t: [r["extinct"] is None for r in runs if r["training"] == t] for t in trainings}
    return {"candidate": candidate, "runs": len(runs), "persisted": kept, "share": None if not runs else share.value,
            "low": share.low, "high": share.high, "by_training_seed": {str(t): [sum(x), len(x)] for t, x in each.items()},
            "lives": [{k: r[k] for k in ("training", "world", "lived", "extinct")} for r in runs]}  # fmt: skip


def _words(entry: dict[str, Any], result: dict[str, Any]) -> str:
    """How well a candidate did, in words."""
    runs = entry["stages"][-1]["runs"] if entry["stages"] else []
    told = f"all lived to the end in {sum(r['extinct'] is None for r in runs)} of {len(runs)} runs of the search"
    best = result["confirmation"]["best"]
    if entry["candidate"] == best["candidate"] and best["runs"]:
        told += f", and in {best['persisted']} of {best['runs']} on fresh seeds"
    return told


def _matters(search: Search, ranked: Runs) -> dict[str, Any] | None:
    """What mattered; None where there are too few candidates to say."""
    from ecs_eco.search.matters import matters, process, ranks, unit

    entries = [e for e in search.journal.of("candidate") if "refused" not in e]
    if len(entries) < max(12, 2 * len(search.plan.parameters)):
        return None
    fit = process(unit(search.plan.parameters, [e["values"] for e in entries]), ranks([merit(e) for e in entries]))
    found = matters(fit, [p.name for p in search.plan.parameters])
    return {"candidates": len(entries), "explained": fit.explained,
            "numbers": {m.name: {"alone": m.first, "with_others": m.total} for m in found}}  # fmt: skip


def _page(search: Search, ranked: Runs, result: dict[str, Any]) -> None:
    from ecs_eco.analysis.figures import save
    from ecs_eco.analysis.page import page, picture, write_text
    from ecs_eco.search import figures

    folder = search.out / "figures"
    shutil.rmtree(folder, ignore_errors=True)
    path = save(figures.history(search.journal.of("candidate"), len(search.plan.stages) - 1), folder / "history.png")
    caption = "Each candidate: the stage that it reached, and its score there squeezed into one unit."
    blocks = [f"<p>{_opening(result)}</p>", *_confirmed(result, folder), "<h2>The best worlds</h2>", _best_table(search, result),
              "<h2>How the search went</h2>", picture(path, caption), *_map(search, ranked, result, folder)]  # fmt: skip
    write_text(search.out / "search.html", page(f"Search: {search.plan.config.title or search.plan.config.name}", *blocks))


def _opening(result: dict[str, Any]) -> str:
    best, start = result["confirmation"]["best"], result["confirmation"]["start"]
    spent, whole = f"{result['seconds'] / 60:.1f} minutes", result["by_stage"][-1]
    told = f"{result['candidates']} candidates in {spent} ({result['optimiser']}); {whole} met all runs."
    if not best["runs"]:
        return told
    written = start["runs"] and start["candidate"] != best["candidate"]
    told = (f" The world as written: {start['persisted']} of {start['runs']}. " if written else " ") + told
    ticks = f"{result['confirmation']['ticks']:,}"
    return f"On fresh seeds all species persist for {ticks} ticks in {best['persisted']} of {best['runs']} runs of the best world.{told}"


def _confirmed(result: dict[str, Any], folder: Path) -> list[str]:
    """The part of the page on fresh seeds."""
    from ecs_eco.analysis import figures
    from ecs_eco.analysis.page import number, picture, table

    both = {"best": result["confirmation"]["best"], "as written": result["confirmation"]["start"]}
    both = {word: found for word, found in both.items() if found["runs"]}
    if not both:
        return []
    lives = {word: ([r["lived"] for r in c["lives"]], [r["extinct"] is not None for r in c["lives"]]) for word, c in both.items()}
    curves = {word: kaplan_meier(*found) for word, found in lives.items()}
    drawn = figures.survival(curves, result["confirmation"]["ticks"], "all species, on seeds that the search never saw")
    path = figures.save(drawn, folder / "survival.png")
    rows = [[word, c["runs"], c["persisted"], number(c["share"]), f"{number(c['low'])} … {number(c['high'])}",
             ", ".join(f"{a}/{b}" for a, b in c["by_training_seed"].values()), _lost(c["lives"])] for word, c in both.items()]  # fmt: skip
    caption = "Share of runs in which all species still live, with 95 % bands (Kaplan–Meier)."
    return ["<h2>Confirmation</h2>", picture(path, caption),
            table(["world", "runs", "all persist", "share", "95 % (Wilson)", "by training seed", "died out first"], rows)]  # fmt: skip


def _lost(lives: Runs) -> str:
    """Which species died out first, and in how many runs."""
    who = [r["extinct"] for r in lives if r["extinct"] is not None]
    return ", ".join(f"{name} {who.count(name)}" for name in dict.fromkeys(who)) or "–"


def _best_table(search: Search, result: dict[str, Any]) -> str:
    from ecs_eco.analysis.page import number, table

    plan, best = search.plan, result["best"]
    rows = [[p.name, f"{number(p.low)} … {number(p.high)}", number(plan.start[p.name]), *(number(b["values"][p.name]) for b in best)]
            for p in plan.parameters]  # fmt: skip
    rows.append(["score", "", "", *(number(b["score"]) for b in best)])
    rows.append(["score on further seeds", "", "", *("–" if b["finals"] is None else number(b["finals"]) for b in best)])
    return table(["number", "range", "as written", *(f"best-{i}" for i in range(1, len(best) + 1))], rows)


def _map(search: Search, ranked: Runs, result: dict[str, Any], folder: Path) -> list[str]:
    """The part of the page on what mattered."""
    from ecs_eco.analysis.figures import save
    from ecs_eco.analysis.page import picture
    from ecs_eco.search import figures
    from ecs_eco.search.matters import Matter, process, ranks, unit

    if result["matters"] is None:
        return ["<h2>What mattered</h2>", "<p>Too few candidates to say.</p>"]
    plan, entries = search.plan, [e for e in search.journal.of("candidate") if "refused" not in e]
    worth = ranks([merit(e) for e in entries])
    fit = process(unit(plan.parameters, [e["values"] for e in entries]), worth)
    found = [Matter(name, m["alone"], m["with_others"]) for name, m in result["matters"]["numbers"].items()]
    best, start = ranked[0]["values"], plan.start
    order: Sequence[int] = np.argsort([-m.total[0] for m in found]).tolist()
    paths = [save(figures.importance(found), folder / "importance.png"),
             save(figures.curves(fit, plan.parameters, start, best), folder / "dependence.png")]  # fmt: skip
    captions = ("Share of the variance between candidates that each number explains; lines are 90 % intervals.",
                "Each number alone, averaged over the others (partial dependence), with one standard deviation.")  # fmt: skip
    told = [picture(path, caption) for path, caption in zip(paths, captions, strict=True)]
    if len(plan.parameters) > 1:
        path = save(figures.pairs(fit, plan.parameters, entries, worth, order, best, start), folder / "pairs.png")
        caption = "Pairs of the numbers that matter most, all others as in the best world; dots are candidates."
        told.append(picture(path, caption))
    text = (f"A Gaussian process through {len(entries)} candidates foretells {max(0.0, fit.explained):.0%} of the variance of those "
            "left out one by one. Where that is little, so is what the figures below say.")  # fmt: skip
    return ["<h2>What mattered</h2>", f"<p>{text}</p>", *told]
