"""Commands that run a world: run, repeat, resume, train."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.options import (
    Bands,
    Divided,
    Learn,
    NoBrowser,
    On,
    Out,
    Policies,
    Port,
    Quiet,
    Report,
    Seed,
    Set,
    Threads,
    Ticks,
    Trust,
    Watch,
    Workers,
    World,
)
from ecs_eco.cli.terminal import exits, path_of, whole
from ecs_eco.cli.trust import allow


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
        int | None, typer.Option(parser=whole(1), metavar="N", help="Ticks between checkpoints.")
    ] = None,
    keep: Annotated[
        int, typer.Option(parser=whole(1), metavar="K", help="Number of checkpoints to keep.")
    ] = 3,
    record: Annotated[
        str | None,
        typer.Option(
            metavar="focal=N|full",
            help="Record every tick of N organisms of each species, or of all organisms.",
        ),
    ] = None,
    watch: Watch = False,
    port: Port = 0,
    no_browser: NoBrowser = False,
    trust: Trust = False,
    workers: Workers = None,
    on: On = "local",
    bands: Bands = False,
    divided: Divided = False,
) -> None:
    """Run a world and record it in a folder; `resume` continues it."""
    allow(trust, world, set_)
    from ecs_eco.cli.simulate import run_in_bands, run_world

    shown = (port, not no_browser) if watch else None
    if bands or divided:
        run_in_bands(
            world,
            set_ or [],
            ticks,
            seed,
            out,
            quiet,
            threads,
            learn,
            policies,
            report,
            checkpoint_every,
            keep,
            shown,
            record,
            divided,
        )
        return
    run_world(
        world,
        set_ or [],
        ticks,
        seed,
        out,
        quiet,
        threads,
        learn,
        policies,
        report,
        checkpoint_every,
        keep,
        shown,
        record,
        workers,
        on,
    )


@exits
def repeat(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder written by `run`.")],
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path_of,
            metavar="PATH",
            help="Folder for the repetition: new or empty. Default: none, it is not recorded.",
        ),
    ] = None,
    quiet: Quiet = False,
    threads: Threads = 1,
    trust: Trust = False,
) -> None:
    """Repeat a recorded run, with all interventions, and print whether it ends the same."""
    allow(trust, folder)
    from ecs_eco.cli.simulate import repeat_run

    repeat_run(folder, out, quiet, threads)


@exits
def resume(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder written by `run`.")],
    until: Annotated[
        int | None,
        typer.Option(
            parser=whole(0), metavar="T", help="Continue to this tick. Default: the planned end of the run."
        ),
    ] = None,
    from_tick: Annotated[
        int | None,
        typer.Option(
            parser=whole(0),
            metavar="T",
            help="Fork: continue from this tick, in a folder of its own (--out).",
        ),
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Fork: a value to change from there on. Repeatable."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(parser=path_of, metavar="PATH", help="Folder of the fork: new or empty.")
    ] = None,
    quiet: Quiet = False,
    threads: Threads = 1,
    report: Report = True,
    watch: Watch = False,
    port: Port = 0,
    no_browser: NoBrowser = False,
    trust: Trust = False,
    workers: Workers = None,
    on: On = "local",
    bands: Bands = False,
    divided: Divided = False,
) -> None:
    """Resume a run from its last checkpoint, or fork it with changed values."""
    allow(trust, folder)
    from ecs_eco.cli.simulate import resume_in_bands, resume_run

    shown = (port, not no_browser) if watch else None
    if bands or divided:
        forks = from_tick is not None or bool(set_) or out is not None
        resume_in_bands(folder, until, forks, quiet, threads, report, shown, divided)
        return
    resume_run(folder, until, from_tick, set_ or [], out, quiet, threads, report, shown, workers, on)


@exits
def train(
    world: World,
    ticks: Ticks = None,
    seed: Seed = None,
    set_: Set = None,
    out: Out = None,
    quiet: Quiet = False,
    on: On = "local",
    trust: Trust = False,
) -> None:
    """Train a world's policies and save them."""
    allow(trust, world, set_)
    from ecs_eco.cli.simulate import train_world

    train_world(world, set_ or [], ticks, seed, out, quiet, on)
