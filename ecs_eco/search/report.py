"""The results of a search: the best worlds, search.json, figures and search.html."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ecs_eco.analysis.survival import wilson
from ecs_eco.engine.files import write_json
from ecs_eco.engine.versions import versions
from ecs_eco.record.folder import git_commit
from ecs_eco.search.importance import importances
from ecs_eco.search.optimise import merit, space_of
from ecs_eco.search.outcome import BEST, Outcome, Runs
from ecs_eco.search.page import write_page
from ecs_eco.search.posterior import write_posterior
from ecs_eco.search.sampler import SAMPLERS
from ecs_eco.search.write import write_world

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World


def write_results(search: Outcome, world: World, overrides: Any, report: bool) -> dict[str, Any]:
    """Write best-1.toml …, search.json, and with `report` the page; return the content of search.json."""
    result = summary(search)
    for rank, entry in enumerate(search.ranked[:BEST], 1):
        number = entry["candidate"]
        kind = search.plan.config.search.policies
        trained = search.out / "policies" / ("start" if kind == "train-once" else f"candidate-{number}")
        note = (
            f"Candidate {number} of a search, number {rank} of {len(search.ranked)}: {_words(entry, result)}."
        )
        values = entry["values"] if number else {}
        write_world(search.plan, world, overrides, values, trained, search.out / f"best-{rank}.toml", note)
    result["importance"] = _importance(search)
    if search.sampler is not None:
        result["posterior"] = write_posterior(search.sampler, search.out)
    write_json(search.out / "search.json", result)
    if report:
        write_page(search, result)
    return result


def summary(search: Outcome) -> dict[str, Any]:
    """The result of a search, with JSON types."""
    plan, ranked, best = search.plan, search.ranked, search.ranked[0]
    confirmed = {
        role: confirmation(search, number) for role, number in (("best", best["candidate"]), ("start", 0))
    }
    finals = {e["candidate"]: e for e in search.journal.of("final")}
    return {
        **plan.header(),
        "optimiser": search.optimiser,
        "workers": search.workers,
        "seconds": search.journal.entries[-1]["at"],
        "cpu_of_candidates": round(search.cpu, 1),
        "seconds_of_candidates": max(e["at"] for e in search.journal.of("candidate")),
        "candidates": len(ranked),
        "by_stage": [sum(e["stage"] >= s for e in ranked) for s in range(len(plan.stages))],
        "stages": plan.stages,
        "cells": plan.cells,
        "start": plan.start,
        "best": [
            {
                "candidate": e["candidate"],
                "values": e["values"],
                "stage": e["stage"],
                "score": e["score"],
                "finals": finals[e["candidate"]]["score"] if e["candidate"] in finals else None,
            }
            for e in ranked[:5]
        ],
        "best_so_far": _best_so_far(search.journal.of("candidate")),
        "confirmation": {"ticks": plan.confirmation_ticks, "cells": plan.confirmation, **confirmed},
        "versions": versions(),
        "git_commit": git_commit(),
    }


def _best_so_far(entries: Runs) -> list[list[float]]:
    """[seconds, merit] whenever it rose."""
    rises: list[list[float]] = []
    for e in sorted(entries, key=lambda e: e["at"]):
        if not rises or merit(e) > rises[-1][1]:
            rises.append([e["at"], merit(e)])
    return rises


def confirmation(search: Outcome, candidate: int) -> dict[str, Any]:
    """Runs on fresh seeds: how many there were, in how many all lived, Wilson's 95 % interval, and each run."""
    entries = [e for e in search.journal.of("confirmation") if e["candidate"] == candidate]
    runs = [
        run
        for e in sorted(entries, key=lambda e: tuple(e["cell"]))  # not as workers finished
        for stage in e["stages"]
        for run in stage["runs"]
    ]
    kept = sum(run["extinct"] is None for run in runs)
    share = wilson(kept, len(runs))
    trainings = sorted({run["training"] for run in runs})
    each = {t: [r["extinct"] is None for r in runs if r["training"] == t] for t in trainings}
    return {
        "candidate": candidate,
        "runs": len(runs),
        "persisted": kept,
        "share": None if not runs else share.value,
        "low": share.low,
        "high": share.high,
        "by_training_seed": {str(t): [sum(x), len(x)] for t, x in each.items()},
        "lives": [{k: r[k] for k in ("training", "world", "lived", "extinct")} for r in runs],
    }


def _words(entry: dict[str, Any], result: dict[str, Any]) -> str:
    """The performance of a candidate, in words."""
    runs = entry["stages"][-1]["runs"] if entry["stages"] else []
    if result["optimiser"] in SAMPLERS:
        return f"likeness to the measurements {max(0.0, entry['score'] - 1):.3f}, of 1"
    words = (
        f"all lived to the end in {sum(r['extinct'] is None for r in runs)} of {len(runs)} runs of the search"
    )
    best = result["confirmation"]["best"]
    if entry["candidate"] == best["candidate"] and best["runs"]:
        words += f", and in {best['persisted']} of {best['runs']} on fresh seeds"
    return words


def _importance(search: Outcome) -> dict[str, Any] | None:
    """The importance of each number; None if there are too few candidates."""
    entries = search.evaluated()
    if len(entries) < max(12, 2 * len(search.plan.parameters)):
        return None
    parameters = search.plan.parameters
    values = [{p.name: p.tidy(e["values"][p.name]) for p in parameters} for e in entries]
    shares = importances(space_of(parameters), values, [merit(e) for e in entries])
    numbers = {i.name: {"share": i.share, "by_chance": i.by_chance} for i in shares}
    return {"candidates": len(entries), "numbers": numbers}
