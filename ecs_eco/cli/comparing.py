"""Commands for many runs: compare, search."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.options import On, Policies, Quiet, Set, Ticks, Trust, Workers, World
from ecs_eco.cli.terminal import exits, path_of, whole
from ecs_eco.cli.trust import allow


@exits
def compare(
    world: World,
    control: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME|KEY=VALUE",
            help="A treatment: random-policy (random-policy:deer for one species), untrained-policy, "
            "learning, frozen-learning, no-reflexes, neutral-drift, shuffled-genome, no-mutation, "
            "constant-light, inverted-light, no-smell, "
            "no-SPECIES, energy-only, energy-and-light, or a changed value. Repeatable.",
        ),
    ] = None,
    seeds: Annotated[
        int,
        typer.Option(
            parser=whole(1, 10_000), metavar="N", help="Number of runs of each arm, with seeds from 1."
        ),
    ] = 8,
    ticks: Ticks = None,
    set_: Set = None,
    workers: Workers = None,
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path_of,
            metavar="PATH",
            help="Folder for the results: new, empty, or begun by this command. Default: in runs/.",
        ),
    ] = None,
    quiet: Quiet = False,
    training_seeds: Annotated[
        int | None,
        typer.Option(
            parser=whole(1, 10_000),
            metavar="N",
            help="Train policies from seeds 1 to N, and run each with every seed.",
        ),
    ] = None,
    retrain: Annotated[
        bool,
        typer.Option(
            "--retrain",
            help="Train again under each treatment that changes values; else it runs with the same policies.",
        ),
    ] = False,
    policies: Policies = "trained",
    on: On = "local",
    trust: Trust = False,
) -> None:
    """Compare a world with itself under treatments; the same command with --out DIR resumes a stopped
    comparison."""
    allow(trust, world, set_)
    from ecs_eco.cli.compare import compare_world

    compare_world(
        world,
        set_ or [],
        control or ["random-policy"],
        seeds,
        ticks,
        workers,
        out,
        quiet,
        training_seeds,
        retrain,
        policies,
        on,
    )


@exits
def search(
    world: World,
    range_: Annotated[
        list[str] | None,
        typer.Option(
            "--range",
            metavar="KEY=LOW:HIGH",
            help="A number to vary, in addition to those of the file. Repeatable.",
        ),
    ] = None,
    objective: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="persistence, cycling, population, data, or module:function. Default: as in the world.",
        ),
    ] = None,
    budget: Annotated[
        float | None,
        typer.Option(min=0.01, metavar="MINUTES", help="Time for the whole search. [default: 30]"),
    ] = None,
    trials: Annotated[
        int | None,
        typer.Option(parser=whole(1), metavar="N", help="Number of candidates; also instead of --budget."),
    ] = None,
    ticks: Annotated[
        int | None, typer.Option(parser=whole(1), metavar="N", help="Length of a whole run [ticks].")
    ] = None,
    world_seeds: Annotated[
        int | None,
        typer.Option(parser=whole(1, 1000), metavar="N", help="Number of world seeds of a candidate."),
    ] = None,
    training_seeds: Annotated[
        int | None,
        typer.Option(parser=whole(1, 1000), metavar="N", help="Number of training seeds of a candidate."),
    ] = None,
    policies: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="trained, random, untrained, train (each candidate its own), train-once."
        ),
    ] = None,
    training_ticks: Annotated[
        int | None, typer.Option(parser=whole(1), metavar="N", help="Length of a training [ticks].")
    ] = None,
    confirm_world_seeds: Annotated[
        int | None,
        typer.Option(parser=whole(1, 1000), metavar="N", help="Number of world seeds of the confirmation."),
    ] = None,
    confirm_training_seeds: Annotated[
        int | None,
        typer.Option(
            parser=whole(1, 1000), metavar="N", help="Number of training seeds of the confirmation."
        ),
    ] = None,
    confirm_ticks: Annotated[
        int | None, typer.Option(parser=whole(1), metavar="N", help="Length of its runs [ticks].")
    ] = None,
    optimiser: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="gp, tpe, random (as a baseline); abc, abc-smc: sample numbers that fit [data].",
        ),
    ] = "gp",
    seed: Annotated[
        int | None, typer.Option(parser=whole(0, 2**63 - 1), metavar="N", help="Seed of the optimiser.")
    ] = None,
    workers: Workers = None,
    on: On = "local",
    set_: Set = None,
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path_of,
            metavar="PATH",
            help="Folder for the results: new, empty, or of a search to continue.",
        ),
    ] = None,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Search for values with which a world persists."""
    allow(trust, world, set_)
    from ecs_eco.cli.search import search_world

    options = {
        "objective": objective,
        "ticks": ticks,
        "world_seeds": world_seeds,
        "training_seeds": training_seeds,
        "policies": policies,
        "training_ticks": training_ticks,
        "confirm_world_seeds": confirm_world_seeds,
        "confirm_training_seeds": confirm_training_seeds,
        "confirm_ticks": confirm_ticks,
        "seed": seed,
    }
    search_world(world, set_ or [], range_ or [], options, budget, trials, workers, optimiser, out, quiet, on)
