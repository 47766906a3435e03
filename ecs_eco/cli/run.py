"""The commands run, resume and repeat. Islands, bands, the viewer and figures of measures are imported only
when needed."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecs_eco.analysis.extinction import opening
from ecs_eco.analysis.runs import load_series
from ecs_eco.cli.folders import results
from ecs_eco.cli.options import (
    Bands,
    Divided,
    How,
    Learn,
    NoBrowser,
    On,
    Out,
    Policies,
    Port,
    Quiet,
    Report,
    Run,
    Seed,
    Set,
    Threads,
    Ticks,
    Trust,
    Watch,
    Workers,
    World,
    new_folder,
    number,
    words,
)
from ecs_eco.cli.terminal import (
    FAILED,
    INTERRUPTED,
    complain,
    exits,
    numbers,
    progress,
    recorded,
    refuse,
    say,
    stopped,
)
from ecs_eco.cli.trust import allow
from ecs_eco.compiled import portable
from ecs_eco.config import WorldConfig, load
from ecs_eco.ecosystem import World as Ecosystem
from ecs_eco.lab.executors import LOCAL, check_engine
from ecs_eco.lab.treatments import check_policies
from ecs_eco.record.archipelago import is_archipelago
from ecs_eco.record.details import how_many
from ecs_eco.runs.repeat import repeat as repeat_run
from ecs_eco.runs.run import KEEP, fork, read_manifest, resume as resume_run, run_to_folder, world_at
from ecs_eco.worlds.first_start import known_to_list, two_processes

if TYPE_CHECKING:
    from ecs_eco.lab.archipelago import Archipelago

Prepare = Callable[[Ecosystem], None]  # called with a world before its first tick


@exits
def run(
    world: World,
    ticks: Ticks = None,
    seed: Seed = None,
    set_: Set = None,
    out: Out = None,
    quiet: Quiet = False,
    threads: Threads = 1,
    learn: Learn = None,
    policies: Policies = "trained",
    report: Report = True,
    checkpoint_every: Annotated[
        int | None, number("Ticks between checkpoints. Default: checkpoints only at the start and end.")
    ] = None,
    keep: Annotated[int, number("Number of checkpoints to keep, with --checkpoint-every.", metavar="K")] = 3,
    record: Annotated[
        str | None,
        typer.Option(
            metavar="focal=N|full",
            help="Record N organisms of each species, or all organisms, in every tick.",
        ),
    ] = None,
    until: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CONDITION", help='End the run when a condition such as "wolf == 0" is true. Repeatable.'
        ),
    ] = None,
    watch: Watch = False,
    port: Port = 0,
    no_browser: NoBrowser = False,
    trust: Trust = False,
    workers: Workers = None,
    on: On = LOCAL,
    bands: Bands = False,
    divided: Divided = False,
) -> None:
    """Run a world and record it in a folder; `resume` continues it."""
    allow(trust, world, set_)
    changes = set_ or []
    how = How(quiet, threads, report, (port, not no_browser) if watch else None, workers, on)
    if until and (bands or divided):
        refuse("--until", "is not possible with --bands", until[0], "only one of these options")
    lead = partial(
        _run, world, changes, ticks, seed, out, learn, policies, checkpoint_every, keep, record, until or []
    )
    if not (bands or divided):
        return lead(how)

    def build() -> Ecosystem:
        return Ecosystem.from_config(
            load(world, changes), seed=seed, policies=policies, threads=threads, learn=learn, record=False
        )

    _in_bands(lead, how, build, ticks, divided)


@exits
def repeat(
    folder: Run,
    out: Annotated[
        Path | None, new_folder("Results folder: new or empty. Default: the repetition is not recorded.")
    ] = None,
    quiet: Quiet = False,
    threads: Threads = 1,
    trust: Trust = False,
) -> None:
    """Repeat a recorded run with all its interventions, and check that the result is the same."""
    recorded(folder)
    allow(trust, folder)
    with (
        nullcontext() if out is None else results(out, folder.name) as claim,
        progress(folder.name, quiet) as bar,
    ):
        result = repeat_run(folder, claim, bar, threads=threads)
    done = (
        f"repeated {result['ticks']} ticks of {result['world']} with {result['interventions']} interventions"
    )
    if result["same"]:
        return say(f"{done}: the same result, {result['digest'][:16]}")
    complain(
        f"{done}: DIFFERENT result, {result['digest'][:16]} instead of {result['recorded'][:16]}{result['why']}"
    )
    raise typer.Exit(FAILED)


@exits
def resume(
    folder: Run,
    until: Annotated[
        int | None, number("Last tick. Default: the planned end of the run.", least=0, metavar="T")
    ] = None,
    from_tick: Annotated[
        int | None, number("Fork: continue from this tick in a new folder (--out).", least=0, metavar="T")
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Fork: change a value from that tick on. Repeatable."
        ),
    ] = None,
    out: Annotated[Path | None, new_folder("Folder for the fork: new or empty.")] = None,
    quiet: Quiet = False,
    threads: Threads = 1,
    report: Report = True,
    watch: Watch = False,
    port: Port = 0,
    no_browser: NoBrowser = False,
    trust: Trust = False,
    workers: Workers = None,
    on: On = LOCAL,
    bands: Bands = False,
    divided: Divided = False,
) -> None:
    """Resume a run from its last checkpoint, or fork it with changed values."""
    if not is_archipelago(folder):
        recorded(folder)
    allow(trust, folder)
    changes = set_ or []
    how = How(quiet, threads, report, (port, not no_browser) if watch else None, workers, on)
    lead = partial(_resume, folder, until, from_tick, changes, out)
    if not (bands or divided):
        return lead(how)
    if from_tick is not None or changes or out is not None:
        refuse(
            "--bands",
            "can only resume a run; a fork must start in one process",
            "",
            "resume without --from-tick, --set and --out",
        )
    manifest = read_manifest(folder)

    def build() -> Ecosystem:
        return world_at(folder, manifest, None, threads, lambda text: None, trust=False)

    _in_bands(lead, how, build, manifest["ticks"] if until is None else until, divided)


def _in_bands(
    lead: Callable[..., None], how: How, build: Callable[[], Ecosystem], ticks: int | None, divided: bool
) -> None:
    """Run a world in all processes started by mpiexec. Process 0 leads, records, and prints exchange
    statistics; the others build the same world. With `divided`, each process stores only part of it."""
    from ecs_eco.bands.run import together

    if how.shown is not None:
        fault = "is not possible with --bands: the page's actions would reach only one process"
        refuse("--watch", fault, "", "only one of these options; you can watch the folder afterward")
    led = together(partial(lead, replace(how, workers=None, on=LOCAL)), build, ticks, state=divided)
    if led is None:
        return
    bands = led[1]
    many, held = (bands.processes, "each with its own part of") if divided else (bands.size, "each with")
    say(
        f"  {many} processes, {held} the {'' if divided else 'whole '}world; process 0 received "
        f"{bands.traffic.received / 1e6:.1f} MB, and spent {bands.traffic.seconds:.1f} s exchanging and "
        "waiting"
    )


def _run(
    world: str,
    changes: list[str],
    ticks: int | None,
    seed: int | None,
    out: Path | None,
    learn: bool | None,
    policies: str,
    checkpoint_every: int | None,
    keep: int,
    record: str | None,
    until: list[str],
    how: How,
    prepare: Prepare | None = None,
) -> None:
    """Run a world and record it in a folder."""
    config = load(world, changes)
    for note in config._renamed:
        complain(f"Note: {note}")
    islands = _has_islands(config, world, how, checkpoint_every)
    if until and islands:
        refuse("--until", "is not possible in a world with islands", until[0], "leave out --until")
    if islands:
        check_engine(how.on)
    seed, ticks = config.seed if seed is None else seed, ticks or config.ticks
    if policies:
        check_policies(policies, config)
    command = command_of(world, config, seed, ticks, policies, changes, learn, record, until)
    if islands:
        from ecs_eco.lab.archipelago import Archipelago

        with results(out, f"{config.name}-{seed}") as claim:
            made = Archipelago.from_config(
                config, seed, ticks, claim, policies, learn, record=record, command=command
            )
            return _run_islands(made, config.name, how, claim=claim)
    how_many(record)
    with (
        nullcontext() if prepare else two_processes(known_to_list(config.name)) as kernels,
        results(out, f"{config.name}-{seed}") as claim,
        progress(config.name, how.quiet) as bar,
        _viewer(config.title or config.name, ticks, how) as viewer,
    ):
        out = claim.path
        try:
            result = run_to_folder(
                config,
                seed,
                ticks,
                claim,
                policies,
                learn,
                bar,
                threads=how.threads,
                report=how.report,
                command=command,
                checkpoint_every=checkpoint_every,
                keep=keep if checkpoint_every else KEEP,
                record=record,
                until=until,
                prepare=prepare if viewer is None else viewer.open,
            )
        except KeyboardInterrupt:
            stopped(bar.done, ticks, out)
    ended = f" (ended by {result['ended']['by']})" if result.get("ended") else ""
    say(
        f"{result['done']} ticks of {config.name}{ended}, seed {seed}, in {out}{numbers(result)}{kernels or ''}"
        f"{_populations(out)}"
    )


def _run_islands(made: Archipelago, name: str, how: How, **more: Any) -> None:
    """Run islands from the start or from their last barrier, and print how many organisms are alive."""
    try:
        with progress(name, how.quiet, "ticks of islands") as bar:
            manifest = made.run(
                workers=how.workers, on=how.on, progress=bar, threads=how.threads, report=how.report, **more
            )
    except KeyboardInterrupt:
        complain(
            f"Stopped with all islands at tick {made.tick} of {made.manifest['ticks']}; resume with: "
            f"ecs-eco resume {made.folder}."
        )
        raise typer.Exit(INTERRUPTED) from None
    lines = [
        f"{manifest['tick']} ticks of {manifest['world']} on {len(made.islands)} islands, seed "
        f"{manifest['seed']}, in {made.folder}",
        f"  digest {manifest['digest'][:16]}",
        *(
            f"  {name}: " + ", ".join(f"{n} {species}" for species, n in state["n"].items())
            for name, state in manifest["islands"].items()
        ),
    ]
    say("\n".join(lines))


def _resume(
    folder: Path,
    until: int | None,
    from_tick: int | None,
    changes: list[str],
    out: Path | None,
    how: How,
    prepare: Prepare | None = None,
) -> None:
    """Resume a run in its folder, or fork it into another folder."""
    forks = from_tick is not None or bool(changes) or out is not None
    if is_archipelago(folder):
        from ecs_eco.lab.archipelago import Archipelago

        if forks:
            refuse(
                "DIR",
                "is an archipelago; only a single island can be forked",
                str(folder),
                "DIR/islands/NAME, which then runs on its own",
            )
        return _run_islands(Archipelago(folder), folder.name, how, until=until)
    if forks and out is None:
        fault = "is missing: a fork is recorded in a new folder"
        refuse("--out", fault, "", "a new or empty folder")
    manifest, where = read_manifest(folder), out or folder
    title = manifest["config"].get("title") or folder.name
    with (
        nullcontext() if out is None else results(out, folder.name) as claim,
        _viewer(title, manifest["ticks"] if until is None else until, how) as viewer,
        progress(folder.name, how.quiet) as bar,
    ):
        more: dict[str, Any] = {
            "threads": how.threads,
            "report": how.report,
            "complain": complain,
            "prepare": prepare if viewer is None else viewer.open,
        }
        try:
            if claim is not None:
                code = bool(manifest["config"].get("code"))
                end = manifest["ticks"] if until is None else until
                options = words(out="DIR", trust=code, from_tick=from_tick, until=end, set=changes)
                command = f"ecs-eco{portable.option()} {shlex.join(['resume', str(folder), *options])}"
                result = fork(folder, claim, from_tick, changes, until, bar, command=command, **more)
            else:
                result = resume_run(folder, until, bar, **more)
        except KeyboardInterrupt:
            stopped(bar.done, bar.total, where)
    say(
        f"{result['done']} ticks of {result['world']}, seed {result['seed']}, "
        f"in {where}{numbers(result)}{_populations(where)}"
    )


def command_of(
    world: str,
    config: WorldConfig,
    seed: int,
    ticks: int,
    policies: str,
    changes: list[str],
    learn: bool | None,
    record: str | None,
    until: list[str] | None = None,
) -> str:
    """Return the command that repeats a run, to be stored in its manifest."""
    options = words(
        seed=seed,
        ticks=ticks,
        policies=policies,
        trust=bool(config.code),
        set=changes,
        learn=learn,
        no_learn=learn is False,
        out="DIR",
        record=record,
        until=until,
    )
    return f"ecs-eco{portable.option()} {shlex.join(['run', world, *options])}"


def _has_islands(config: WorldConfig, world: str, how: How, checkpoint_every: int | None) -> bool:
    """Return whether a world runs as an archipelago; reject options that do not apply."""
    islands = config.archipelago is not None and config.archipelago.here is None
    if islands and (how.shown is not None or checkpoint_every is not None):
        refuse(
            "WORLD",
            "has islands, which write checkpoints at barriers and can be watched only after the run",
            world,
            "neither --watch nor --checkpoint-every",
        )
    if not islands and (how.workers is not None or how.on != LOCAL):
        source, value = ("--on", how.on) if how.workers is None else ("--workers", how.workers)
        refuse(
            source,
            "applies only to islands, but this world has no [archipelago]",
            value,
            f"leave out {source}",
        )
    return islands


def _viewer(title: str, ticks: int, how: How) -> AbstractContextManager[Any]:
    """Return the run's viewer, or a null context."""
    if how.shown is None:
        return nullcontext()
    from ecs_eco.cli.watch import window

    return window(ticks, title, *how.shown)


def _populations(out: Path) -> str:
    """Return lines that report the species' persistence, final numbers and measured values."""
    series = load_series(out)
    lines = [
        *opening(series),
        "at the end: "
        + ", ".join(f"{n:.0f} {name}" for name, n in zip(series.species, series.n[-1], strict=True)),
    ]
    if series.reporters:
        from ecs_eco.analysis import measures

        lines += measures.lines(series)
    return "".join(f"\n  {line}" for line in lines)
