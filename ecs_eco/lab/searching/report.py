"""A whole search and its results: the best worlds, search.json, figures and search.html."""

import os
import shutil
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import Executor
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.figures import survival
from ecs_eco.analysis.page import drawn, interval, number, page, table, verdict, write_text
from ecs_eco.analysis.survival import difference_of_shares, kaplan_meier, wilson
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.edit import as_toml, edited
from ecs_eco.config.loading import WorldSource, document_of
from ecs_eco.config.overrides import Overrides
from ecs_eco.config.ranges import Key, key_of, real_key
from ecs_eco.engine.arguments import called_with
from ecs_eco.engine.errors import ConfigError, in_words, listed, nearest, refusal
from ecs_eco.engine.files import write_json
from ecs_eco.engine.versions import versions
from ecs_eco.lab.executors import LOCAL, engine, prepare, workers_of
from ecs_eco.lab.folder import copy_file, named_files
from ecs_eco.lab.jobs import forget_trained
from ecs_eco.lab.searching import figures
from ecs_eco.lab.searching.course import BEST, Progress, Search
from ecs_eco.lab.searching.optimise import OPTIMISERS, importances, merit, ranks, space_of
from ecs_eco.lab.searching.plan import TRAINED, Plan, plan_of
from ecs_eco.lab.searching.sampler import SAMPLERS, Sampler, write_posterior
from ecs_eco.lab.work import Work, group
from ecs_eco.record.claim import Claim, ours
from ecs_eco.record.code import keep_beside
from ecs_eco.record.container import inside
from ecs_eco.record.folder import git_commit


def search(
    world: WorldSource,
    out: str | Path | Claim,
    overrides: Overrides = None,
    *,
    budget: float | None = None,
    trials: int | None = None,
    cpu: float | None = None,
    workers: int | None = None,
    optimiser: str = "gp",
    progress: Progress | None = None,
    report: bool = True,
    trust: bool = False,
    executor: str | Executor = LOCAL,
) -> dict[str, Any]:
    """Search the ranges in a world's `search` section and write the results to a folder.

    Parameters
    ----------
    world : str, Path or Mapping
        A world with ranges to search.
    out : str or Path
        Results folder: new, empty, or from a search to resume.
    overrides : Mapping or sequence of str, optional
        Changes to values, as in `ecs_eco.config.load`, including keys of `search`.
    budget : float, optional
        Minutes after which the search ends, including earlier calls.
    trials : int, optional
        Number of candidates after which the search ends.
    cpu : float, optional
        CPU time of candidates [s] after which the search ends.
    workers : int, optional
        Number of processes; default: 2, or all CPUs of a Ray cluster.
    optimiser : str, default "gp"
        "gp" (Gaussian process), "tpe" or "random"; to fit measurements, "abc" or "abc-smc".
    progress : callable, optional
        Function called with the search after each candidate.
    report : bool, default True
        Whether to write search.html.
    trust : bool, default False
        Whether code listed in the world file can run in this process and its workers.
    executor : str or Executor, default "local"
        "local", "ray", or your own executor.

    Returns
    -------
    dict
        Contents of search.json: the best values, their importance, and the confirmation on fresh seeds.

    Raises
    ------
    ConfigError
        If the world or the optimizer is invalid.
    FolderInUse
        If another process is searching there.
    ForeignFile
        If the folder contains another search.

    Examples
    --------
    >>> from ecs_eco.lab import search
    >>> energy = {"value": 0.5, "search": [0.1, 1.0]}
    >>> mite = {
    ...     "count": 4,
    ...     "body": {"radius": 0.1},
    ...     "metabolism": {"energy": energy, "energy_max": 1.0, "basal": 0.02},
    ...     "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
    ... }
    >>> world = {"format": 1, "name": "fell", "ticks": 60, "space": {"size": [20.0, 20.0]}}
    >>> plan = {"world_seeds": 1, "finalists": 1, "confirm": {"world_seeds": 1}}
    >>> world |= {"species": {"mite": mite}, "search": plan}
    >>> found = search(world, "found", trials=2, workers=1, report=False)
    >>> "best" in found
    True
    """
    called_with("progress", progress, "the search")
    config = load(world, overrides, trust=trust)
    plan = plan_of(config)
    if optimiser not in (known := (*OPTIMISERS, *SAMPLERS)):
        near = nearest(optimiser, known)
        raise refusal((), "no such optimizer", optimiser, listed(known), near, "--optimiser")
    if optimiser in SAMPLERS:
        if plan.fit is None:
            allowed = 'a world with [data], and [search] objective = "data"'
            fault = "samples values that fit measurements, but the world has none"
            raise refusal((), fault, optimiser, allowed, source="--optimiser")
        plan = plan.sampling()
    if budget is None and trials is None and cpu is None:
        allowed = "a budget in minutes or a number of trials"
        raise refusal((), "no end", allowed=allowed, source="--budget, --trials")
    with ours(out) as claim:
        folder = claim.path if executor == LOCAL else claim.path.absolute()
        running = None
        try:
            with engine(executor, workers) as pool, Work[Any](pool) as work:
                most = workers or workers_of(pool)
                running = Search(plan, folder, work, most, optimiser, budget, trials, cpu, progress)
                prepare(pool, folder, config)
                running.run()
        finally:
            if running is not None:
                running.sweep()
        return write_results(running, world, overrides, report)


def write_page(search: Search, result: dict[str, Any]) -> None:
    """Write search.html and figures/ from the contents of search.json."""
    folder = search.out / "figures"
    course = figures.history(search.journal.of("candidate"), len(search.plan.stages) - 1)
    caption = "The stage that each candidate reached, plus its score there, mapped to 0 to 1."
    sampled = [] if search.sampler is None else posterior_blocks(search.sampler, result["posterior"], folder)
    title = search.plan.config.title or search.plan.config.name
    blocks = [
        f"<h1>Search: {escape(title)}</h1>",
        verdict(_opening(search, result), False),
        *_confirmed(result, folder),
        *sampled,
        "<h2>The best worlds</h2>",
        _best_table(search, result),
        "<h2>Progress of the search</h2>",
        drawn(course, folder / "history.svg", caption),
        "<h2>Importance of the parameters</h2>",
        *_important(search, result, folder),
    ]
    write_text(search.out / "search.html", page(f"Search: {title}", *blocks))


def _opening(search: Search, result: dict[str, Any]) -> list[str]:
    """Return sentences on the posterior or the best world, and the course of the search."""
    best, start = result["confirmation"]["best"], result["confirmation"]["start"]
    spent, whole = f"{result['seconds'] / 60:.1f} minutes", result["by_stage"][-1]
    course = f"{result['candidates']} candidates in {spent} ({result['optimiser']})"
    course += f"; {whole} reached the last stage."
    lines = [] if search.sampler is None else posterior_opening(result["posterior"])
    if not best["runs"]:
        return [*lines, course]
    ticks = f"{result['confirmation']['ticks']:,}"
    share = f"{best['persisted']} of {best['runs']} runs of the best world"
    sentences = [f"On fresh seeds, all species persist for {ticks} ticks in {share}."]
    if start["runs"] and start["candidate"] != best["candidate"]:
        gain = difference_of_shares(best["persisted"], best["runs"], start["persisted"], start["runs"])
        sentences.append(
            f"In the world as written, they do in {start['persisted']} of {start['runs']} runs: a difference of "
            f"{interval(gain)}."
        )
    if search.sampler is None and best["candidate"]:
        values = next(one["values"] for one in result["best"] if one["candidate"] == best["candidate"])
        changed = [
            f"{name} = {number(x)} ({number(search.plan.start[name])} as written)"
            for name, x in values.items()
        ]
        more = f" (and other changed values: {len(changed) - 3}; see best-1.toml)" if len(changed) > 3 else ""
        sentences.append(f"The best world has {', '.join(changed[:3])}{more}.")
    return [*lines, " ".join(sentences), course]


def _confirmed(result: dict[str, Any], folder: Path) -> list[str]:
    both = {"best": result["confirmation"]["best"], "as written": result["confirmation"]["start"]}
    both = {world: c for world, c in both.items() if c["runs"]}
    if not both:
        return []
    curves = {
        world: kaplan_meier([r["lived"] for r in c["lives"]], [r["extinct"] is not None for r in c["lives"]])
        for world, c in both.items()
    }
    lives = survival(
        curves,
        result["confirmation"]["ticks"],
        "all species, on seeds that the search did not use",
        {"best": figures.BEST, "as written": figures.START},
    )
    lost = {world: Counter(filter(None, (r["extinct"] for r in c["lives"]))) for world, c in both.items()}
    rows = [
        [
            world,
            c["runs"],
            c["persisted"],
            number(c["share"]),
            f"{number(c['low'])} to {number(c['high'])}",
            ", ".join(f"{a}/{b}" for a, b in c["by_training_seed"].values()),
            ", ".join(f"{name} {n}" for name, n in lost[world].items()) or "–",
        ]
        for world, c in both.items()
    ]
    caption = "Fraction of runs in which all species are alive (Kaplan–Meier, 95% bands)."
    return [
        "<h2>Confirmation</h2>",
        drawn(lives, folder / "survival.svg", caption),
        table(
            ["world", "runs", "all persist", "share", "95% (Wilson)", "by training seed", "died out first"],
            rows,
        ),
    ]


def _best_table(search: Search, result: dict[str, Any]) -> str:
    plan, best = search.plan, result["best"]
    rows = [
        [
            p.name,
            f"{number(p.low)} to {number(p.high)}",
            number(plan.start[p.name]),
            *(number(b["values"][p.name]) for b in best),
        ]
        for p in plan.parameters
    ]
    for label, score in (("score", "score"), ("score on further seeds", "finals")):
        rows.append([label, "", "", *("–" if b[score] is None else number(b[score]) for b in best)])
    return table(["parameter", "range", "as written", *(f"best-{i}" for i in range(1, len(best) + 1))], rows)


def _important(search: Search, result: dict[str, Any], folder: Path) -> list[str]:
    if result["importance"] is None:
        return ["<p>There are too few candidates for this analysis.</p>"]
    plan, entries = search.plan, search.evaluated()
    found = result["importance"]["numbers"]
    worse, best, start = ranks([merit(e) for e in entries]), search.ranked()[0]["values"], plan.start
    text = (
        f"Based on {len(entries)} candidates. A parameter is important if the distribution of the "
        "best candidates over its range differs from that of all candidates. A bar that does not reach its "
        "line is consistent with chance."
    )
    blocks = [
        f"<p>{text}</p>",
        drawn(
            figures.importance(found),
            folder / "importance.svg",
            "Share of total importance (PED-ANOVA); by chance, bars stay below the line in 19 of 20 cases.",
        ),
        drawn(
            figures.scatter(plan.parameters, entries, worse, start, best),
            folder / "dependence.svg",
            "Rank of each candidate against each of its parameters; the best candidates are at the top.",
        ),
    ]
    if len(plan.parameters) > 1:
        order = np.argsort([-of["share"] for of in found.values()]).tolist()
        blocks.append(
            drawn(
                figures.pairs(plan.parameters, entries, worse, order, best, start),
                folder / "pairs.svg",
                "Pairs of the most important parameters; each dot is a candidate.",
            )
        )
    return blocks


def posterior_opening(result: dict[str, Any]) -> list[str]:
    """Return sentences on the parameters, narrowest first, and the measurements that are not predicted."""
    known = {
        name: (of["high"] - of["low"]) / (of["range"][1] - of["range"][0])
        for name, of in result["numbers"].items()
    }
    told = [
        f"{name} = {number(of['median'])} ({number(of['low'])} to {number(of['high'])})"
        for name in sorted(known, key=known.__getitem__)[:3]
        for of in [result["numbers"][name]]
    ]
    lines = [f"Median and central 90% of the posterior: {', '.join(told)}."] if told else []
    outside = [name for name, of in result["statistics"].items() if _place(of)]
    if outside:
        lines.append(
            f"The posterior does not predict {in_words(outside)}: the measured value is outside the central 90% "
            "of the runs. The world may lack a process that causes it."
        )
    elif told:
        lines.append(f"It predicts {in_words(result['statistics'])}.")
    return lines


def posterior_blocks(sampler: Sampler, result: dict[str, Any], folder: Path) -> list[str]:
    """Return the section on the posterior; its figures are also written to `folder`."""
    kept = sampler.posterior()
    if not result["numbers"]:
        return ["<h2>Posterior</h2>", "<p>No candidate lived long enough to be compared.</p>"]
    told = (
        f"<p>Of {result['candidates']} candidates, {result['compared']} lived long enough to be compared; "
        f"the {result['kept']} nearest form the posterior (posterior.csv), equivalent to "
        f"{number(result['effective'])} candidates of equal weight.</p>"
    )
    numbers = [
        [
            name,
            f"{number(of['range'][0])} to {number(of['range'][1])}",
            number(of["median"]),
            f"{number(of['low'])} to {number(of['high'])}",
        ]
        for name, of in result["numbers"].items()
    ]
    statistics = [
        [
            name,
            number(of["observed"]),
            number(of["median"]),
            f"{number(of['low'])} to {number(of['high'])}",
            _place(of),
        ]
        for name, of in result["statistics"].items()
    ]
    parameters = sampler.plan.parameters
    shown = [
        drawn(
            figures.marginals(parameters, kept, sampler.plan.start),
            folder / "posterior.svg",
            "Posterior density of each parameter on the scale of its range, with "
            "the median and central 90%; the gray line is the prior density.",
        )
    ]
    if len(parameters) > 1:
        caption = "Pairs of parameters; the area of a dot shows the weight of a candidate."
        shown.append(
            drawn(figures.posterior_pairs(parameters, kept), folder / "posterior-pairs.svg", caption)
        )
    return [
        "<h2>Posterior</h2>",
        told,
        table(["parameter", "range", "median", "central 90%"], numbers),
        *shown,
        table(["statistic", "measured", "median of the runs", "central 90%", "measured value"], statistics),
    ]


def _place(of: dict[str, float]) -> str:
    """Return "above" or "below" if the measured value is outside the central 90%, else ""."""
    return "below" if of["observed"] < of["low"] else "above" if of["observed"] > of["high"] else ""


def write_results(search: Search, world: WorldSource, overrides: Overrides, report: bool) -> dict[str, Any]:
    """Write best-1.toml …, search.json and, if `report` is true, the page; return the contents of search.json."""
    result, ranked = summary(search), search.ranked()
    for rank, entry in enumerate(ranked[:BEST], 1):
        number = entry["candidate"]
        kind = search.plan.config.search.policies
        trained = search.out / "policies" / ("start" if kind == "train-once" else f"candidate-{number}")
        note = f"Candidate {number} of a search, number {rank} of {len(ranked)}: {_words(entry, result)}."
        values = entry["values"] if number else {}
        write_world(search.plan, world, overrides, values, trained, search.out / f"best-{rank}.toml", note)
    result["importance"] = _importance(search)
    if search.sampler is not None:
        result["posterior"] = write_posterior(search.sampler, search.out)
    write_json(search.out / "search.json", result)
    if report:
        write_page(search, result)
    return result


def summary(search: Search) -> dict[str, Any]:
    """Return the results of a search as JSON types."""
    plan, ranked = search.plan, search.ranked()
    best = ranked[0]
    confirmed = {
        role: confirmation(search, number) for role, number in (("best", best["candidate"]), ("start", 0))
    }
    finals = {e["candidate"]: e for e in search.journal.of("final")}
    rises: list[list[float]] = []  # [seconds, merit] at each improvement
    for e in sorted(search.journal.of("candidate"), key=lambda e: float(e["at"])):
        if not rises or merit(e) > rises[-1][1]:
            rises.append([e["at"], merit(e)])
    return {
        **plan.header(),
        "optimiser": search.optimiser,
        "workers": search.workers,
        "seconds": search.journal.entries[-1]["at"],
        "cpu_of_candidates": round(search.worked, 1),
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
        "best_so_far": rises,
        "confirmation": {"ticks": plan.confirmation_ticks, "cells": plan.confirmation, **confirmed},
        "versions": versions(),
        "git_commit": git_commit(),
    }


def confirmation(search: Search, candidate: int) -> dict[str, Any]:
    """Return the runs on fresh seeds and the number in which all species survived, with Wilson's interval."""
    entries = [e for e in search.journal.of("confirmation") if e["candidate"] == candidate]
    runs = [
        run
        for e in sorted(entries, key=lambda e: tuple(e["cell"]))  # in seed order, not in order of completion
        for stage in e["stages"]
        for run in stage["runs"]
    ]
    kept = sum(run["extinct"] is None for run in runs)
    share = wilson(kept, len(runs))
    each = group(sorted(runs, key=lambda run: run["training"]), lambda run: run["training"])
    return {
        "candidate": candidate,
        "runs": len(runs),
        "persisted": kept,
        "share": None if not runs else share.value,
        "low": share.low,
        "high": share.high,
        "by_training_seed": {
            str(t): [sum(run["extinct"] is None for run in own), len(own)] for t, own in each.items()
        },
        "lives": [{k: r[k] for k in ("training", "world", "lived", "extinct")} for r in runs],
    }


def _words(entry: dict[str, Any], result: dict[str, Any]) -> str:
    runs = entry["stages"][-1]["runs"] if entry["stages"] else []
    if result["optimiser"] in SAMPLERS:
        return f"similarity to the measurements: {max(0.0, entry['score'] - 1):.3f} of 1"
    words = (
        f"all species survived in {sum(r['extinct'] is None for r in runs)} of {len(runs)} runs of the search"
    )
    best = result["confirmation"]["best"]
    if entry["candidate"] == best["candidate"] and best["runs"]:
        words += f", and in {best['persisted']} of {best['runs']} on fresh seeds"
    return words


def _importance(search: Search) -> dict[str, Any] | None:
    """Return the importance of each parameter, or None if there are too few candidates."""
    entries = search.evaluated()
    if len(entries) < max(12, 2 * len(search.plan.parameters)):
        return None
    parameters = search.plan.parameters
    values = [{p.name: p.tidy(e["values"][p.name]) for p in parameters} for e in entries]
    numbers = importances(space_of(parameters), values, [merit(e) for e in entries])
    return {"candidates": len(entries), "numbers": numbers}


def write_world(
    plan: Plan,
    world: WorldSource,
    overrides: Overrides,
    values: Mapping[str, float],
    trained: Path,
    file: Path,
    note: str,
) -> None:
    """Write one world; `trained` is the folder with the policies trained for it, if any."""
    config = load(plan.config, dict(values))
    files = _policies(config, trained, file.with_suffix(""), plan.config.search.policies in TRAINED)
    keep_beside(config._code.sources, file.parent)
    data = config.resolved()
    moved: dict[Key, Any] = {("species", name, "policy", "file"): path for name, path in files.items()}
    for name in named_files(data):
        if ".." in Path(name).parts:  # measurements: rasters are in the folder of their world
            moved["data", "file"] = os.path.relpath(config.file(name), file.parent)
        elif not os.path.isabs(name) and not (copy := inside(file.parent, file.parent / name)).exists():
            copy_file(config.file(name), copy)
    text = _text(config, world, overrides, values, moved)
    for key, value in moved.items():
        part: Any = data
        for step in key[:-1]:
            part = part[step]
        part[key[-1]] = value
    for candidate in (text, as_toml(data)):
        if candidate is not None:
            write_text(file, "".join(f"# {line}\n" for line in note.splitlines()) + candidate)
            if _same(file, config):
                return
    raise RuntimeError(
        f"{file} could not be written to match the evaluated world; its values are in the journal"
    )


def _text(
    config: WorldConfig,
    world: WorldSource,
    overrides: Overrides,
    values: Mapping[str, float],
    moved: Mapping[Key, Any],
) -> str | None:
    """Return the text of the world file with these values and `moved` ones, or None if there is no text to be
    edited."""
    document = document_of(world, overrides)
    if not document.text:
        return None
    changes: dict[Key, Any] = {
        key: value for key, value in document.changes.items() if key[:1] != ("search",)
    }
    changes |= {real_key(config.model_dump(), key_of(name))[0]: value for name, value in values.items()}
    return edited(document.text, changes | dict(moved))


def _same(file: Path, config: WorldConfig) -> bool:
    """Return whether the file describes this world, ignoring the location of its files."""
    try:
        written = load(file)
    except ConfigError:
        return False
    a, b = written.resolved(), config.resolved()
    for data in (a, b):
        for species in data["species"].values():
            species["policy"]["file"] = None
        if data.get("data"):
            data["data"]["file"] = None
    return a == b


def _policies(config: WorldConfig, trained: Path, beside: Path, training: bool) -> dict[str, str]:
    """Copy the policies next to the world file; return each species' policy file as named in the world file."""
    forget_trained(inside(beside.parent, beside))
    sets = sorted(trained.glob("training-*"), key=lambda p: int(p.name.partition("-")[2])) if training else []
    for folder in sets:
        shutil.copytree(folder, beside / folder.name, dirs_exist_ok=True)
    files = {}
    for name, species in config.species.items():
        if not species.policy.thinks:
            continue
        if sets and (sets[0] / f"{name}.safetensors").is_file():
            files[name] = f"{beside.name}/{sets[0].name}/{name}.safetensors"
        elif not training and species.policy.file:
            copy_file(config.file(species.policy.file), beside / f"{name}.safetensors")
            files[name] = f"{beside.name}/{name}.safetensors"
    return files
