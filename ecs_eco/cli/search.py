"""The command search: find values that let a world persist, and confirm them."""

import shlex
from concurrent.futures import BrokenExecutor
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from ecs_eco.cli.folders import results
from ecs_eco.cli.options import On, Quiet, Set, Trust, Workers, World, new_folder, number, option
from ecs_eco.cli.terminal import FAILED, INTERRUPTED, complain, exits, refuse, say, shown
from ecs_eco.cli.trust import allow
from ecs_eco.config import load
from ecs_eco.config.notes import notes
from ecs_eco.config.overrides import ALIASES, parse
from ecs_eco.config.ranges import key_of, name_of
from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.lab import search as search_values
from ecs_eco.lab.executors import LOCAL, check_engine
from ecs_eco.lab.ray_executor import WorkerLost
from ecs_eco.lab.searching.course import Search
from ecs_eco.lab.searching.journal import has_search

_seeds = partial(number, most=1000)


@exits
def search(
    world: World,
    range_: Annotated[
        list[str] | None,
        option(
            "Value to vary, in addition to the ranges in the file. Repeatable.",
            "--range",
            metavar="KEY=LOW:HIGH[:log]",
        ),
    ] = None,
    objective: Annotated[
        str | None,
        option("persistence, cycling, population, data or module:function. Default: as in the world file."),
    ] = None,
    budget: Annotated[
        float | None,
        typer.Option(
            min=0.01,
            metavar="MINUTES",
            help="Time limit for the whole search. Default: 30, or none with --trials.",
        ),
    ] = None,
    trials: Annotated[
        int | None, number("Number of candidates, instead of or in addition to --budget.")
    ] = None,
    ticks: Annotated[int | None, number("Ticks of a full run.")] = None,
    world_seeds: Annotated[int | None, _seeds("Number of world seeds per candidate.")] = None,
    training_seeds: Annotated[int | None, _seeds("Number of training seeds per candidate.")] = None,
    policies: Annotated[
        str | None, option("trained, random, untrained, train (for each candidate) or train-once.")
    ] = None,
    training_ticks: Annotated[int | None, number("Ticks of a training run.")] = None,
    confirm_world_seeds: Annotated[int | None, _seeds("Number of world seeds for confirmation.")] = None,
    confirm_training_seeds: Annotated[
        int | None, _seeds("Number of training seeds for confirmation.")
    ] = None,
    confirm_ticks: Annotated[int | None, number("Ticks of a confirmation run.")] = None,
    optimiser: Annotated[
        str, option("gp, tpe or random (a baseline); abc or abc-smc samples values that fit [data].")
    ] = "gp",
    seed: Annotated[int | None, number("Seed of the optimizer.", least=0, most=2**63 - 1)] = None,
    workers: Workers = None,
    on: On = LOCAL,
    set_: Set = None,
    out: Annotated[Path | None, new_folder("Results folder: new, empty, or from a search to resume.")] = None,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Search for values that let a world persist."""
    allow(trust, world, set_)
    section = {
        "objective": objective,
        "ticks": ticks,
        "world_seeds": world_seeds,
        "training_seeds": training_seeds,
        "policies": policies,
        "training_ticks": training_ticks,
        "confirm.world_seeds": confirm_world_seeds,
        "confirm.training_seeds": confirm_training_seeds,
        "confirm.ticks": confirm_ticks,
        "seed": seed,
    }
    check_engine(on)
    overrides = overrides_of(set_ or [], range_ or [], section)
    try:
        config = load(world, overrides)
    except ConfigError as error:
        raise ConfigError([_moved(p) for p in error.problems], error.title) from None
    if budget is None and trials is None:
        budget = 30.0

    for note in notes(config):
        complain(f"note: {note}")
    with results(out, f"{config.name}-search", out is not None and has_search(out)) as claim:
        try:
            with shown(
                config.name,
                quiet,
                lambda search: f"{config.name}: {search.phase}, {search.share:.0%}, {_status(search)}",
                lambda search: {
                    "description": f"{config.name}: {search.phase}",
                    "completed": search.share,
                    "total": 1.0,
                    "text": _status(search),
                },
                ("TaskProgressColumn", "{task.fields[text]}", "TimeElapsedColumn", "TimeRemainingColumn"),
            ) as show:
                result = search_values(
                    world,
                    claim,
                    overrides,
                    budget=budget,
                    trials=trials,
                    workers=workers,
                    optimiser=optimiser,
                    progress=show,
                    executor=on,
                )
        except KeyboardInterrupt:
            raise _ended("Stopped", claim.path, INTERRUPTED) from None
        except (BrokenExecutor, WorkerLost):
            raise _ended("A worker process was killed (out of memory?)", claim.path, FAILED) from None
    report(result, claim.path)


def _ended(why: str, out: Path, code: int) -> typer.Exit:
    """Print why a search ended early and how to continue it; return the exception that ends the command."""
    name = shlex.quote(str(out))
    complain(f"{why}; all finished evaluations are kept. To resume, repeat the command with --out {name}")
    return typer.Exit(code)


def overrides_of(changes: list[str], ranges: list[str], section: dict[str, Any]) -> dict[str, Any]:
    """Return the command line's values and ranges in the form that `load` accepts."""
    overrides: dict[str, Any] = {}
    for text in changes:
        name, value = parse(text)
        if isinstance(value, Problem):
            raise ConfigError([value])
        overrides[name] = value
    for text in ranges:
        name, span = range_of(text)
        overrides[f'search.ranges."{name_of(key_of(name))}"'] = span
    overrides |= {f"search.{key}": value for key, value in section.items() if value is not None}
    return overrides


def range_of(text: str) -> tuple[str, dict[str, Any]]:
    """Return the key and range of KEY=LOW:HIGH or KEY=LOW:HIGH:log."""
    name, _, span = (part.strip() for part in text.partition("="))
    ends = span.split(":")
    scale = ends.pop() if len(ends) == 3 else "linear"
    try:
        low, high = (int(x) if x.strip().lstrip("+-").isdigit() else float(x) for x in ends)
    except ValueError:
        refuse(
            "--range",
            "does not have the form KEY=LOW:HIGH",
            text,
            "a range such as species.deer.reproduction.rate=0.004:0.02, or …:0.02:log",
        )
    if scale not in ("linear", "log"):
        refuse("--range", "unknown scale", scale, "log, or no scale", "log")
    parts = name.split(".")
    if len(parts) == 3 and parts[0] == "species" and parts[2] in ALIASES:
        name = ".".join([*parts[:2], *map(str, ALIASES[parts[2]])])
    return name, {"search": [low, high], "scale": scale}


def _moved(problem: Problem) -> Problem:
    """Return a problem, attributed to --range if it concerns a range from the command line."""
    if problem.source == "--set" and problem.key[:2] == ("search", "ranges"):
        return problem.moved(source="--range", key=problem.key[2:])
    return problem


def _status(search: Search) -> str:
    """Return the number of candidates, their rate, and the score and stage of the best candidate."""
    if not search.done:
        return "no candidate yet"
    rate = 60 * search.done / max(1e-9, *(e["at"] for e in search.journal.of("candidate")))
    best = search.ranked()[0]
    stage = f"stage {best['stage'] + 1} of {len(search.plan.stages)}"
    return f"{search.done} candidates, {rate:.1f}/min, best {best['score']:.3f} at {stage}"


def report(result: dict[str, Any], out: Path) -> None:
    """Print the result of a search."""
    if "posterior" in result:
        return _report_posterior(result["posterior"], out)
    confirmation = result["confirmation"]
    best, start = confirmation["best"], confirmation["start"]
    minutes, whole = result["seconds"] / 60, result["by_stage"][-1]
    say(
        f"all species persist for {confirmation['ticks']} ticks on fresh seeds in {best['persisted']} of "
        f"{best['runs']} runs "
        f"(95% interval {best['low']:.2f} to {best['high']:.2f}); with the values in the file, in "
        f"{start['persisted']} of {start['runs']}"
    )
    say(f"  {result['candidates']} candidates in {minutes:.1f} minutes, {whole} of them with complete runs")
    for name, value in result["best"][0]["values"].items():
        say(f"  {name}: {result['start'][name]:g} → {value:g}")
    say(f"written: {out / 'search.html'}; run the best candidate: ecs-eco run {out / 'best-1.toml'}")


def _report_posterior(posterior: dict[str, Any], out: Path) -> None:
    """Print the result of a search that samples a posterior."""
    say(
        f"{posterior['candidates']} candidates, of which {posterior['compared']} were compared with the "
        f"measurements and the {posterior['kept']} nearest kept"
    )
    for name, of in posterior["numbers"].items():
        low, high = of["range"]
        say(
            f"  {name}: {of['median']:.4g} (90% interval {of['low']:.4g} to {of['high']:.4g}; "
            f"searched {low:g} to {high:g})"
        )
    for name, of in posterior["statistics"].items():
        say(f"  {name}: measured {of['observed']:.3g}, runs {of['low']:.3g} to {of['high']:.3g}")
    say(f"written: {out / 'search.html'}, {out / 'posterior.csv'}")
