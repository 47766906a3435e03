"""`ecs-eco run | resume | train | report | lineage | compare | search | draw | list | check`."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.terminal import exits, say, whole

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # rich is loaded by the commands that draw with it
    help="Ecosystems whose animals sense, learn and evolve.",
)

World = Annotated[str, typer.Argument(metavar="WORLD", help="Name of a shipped world (see `list`), or a TOML file.")]
Ticks = Annotated[
    int | None, typer.Option(parser=whole(1), metavar="N", help="Length [ticks]; the world's own where absent.")
]
Seed = Annotated[
    int | None, typer.Option(parser=whole(0, 2**63 - 1), metavar="N", help="Seed of all chance; else the world's own.")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the world: species.deer.count=500. Repeatable."),
]
Out = Annotated[Path | None, typer.Option(help="Folder for the results: new or empty. Default: in runs/.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]
Threads = Annotated[
    int, typer.Option(parser=whole(1, 1024), metavar="N", help="Threads; they change the speed and no result.")
]

Report = Annotated[bool, typer.Option("--report/--no-report", help="Draw figures at the end.")]


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import PackageNotFoundError, version

        try:
            say(f"ecs-eco {version('ecs-eco')}")
        except PackageNotFoundError:
            say("ecs-eco, not installed: the version is unknown")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_version, help="Say the version and stop.")
    ] = False,
) -> None:
    pass


@app.command()
@exits
def run(
    world: World,
    ticks: Ticks = None,
    seed: Seed = None,
    set_: Set = None,
    out: Out = None,
    quiet: Quiet = False,
    threads: Threads = 1,
    learn: Annotated[
        bool | None, typer.Option("--learn/--no-learn", help="Whether policies learn; else as the world says.")
    ] = None,
    policies: Annotated[
        str, typer.Option(metavar="trained|random|DIR", help="What policies start from: a folder that `train` left.")
    ] = "trained",
    report: Report = True,
    checkpoint_every: Annotated[
        int | None, typer.Option(parser=whole(1), metavar="N", help="Write a checkpoint every so many ticks.")
    ] = None,
    keep: Annotated[int, typer.Option(parser=whole(1), metavar="K", help="How many checkpoints stay.")] = 3,
) -> None:
    """Run a world and record it in a folder; `resume` goes on with it."""
    from ecs_eco.cli.simulate import run_world

    run_world(world, set_ or [], ticks, seed, out, quiet, threads, learn, policies, report, checkpoint_every, keep)


@app.command()
@exits
def resume(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `run` left.")],
    until: Annotated[
        int | None, typer.Option(parser=whole(0), metavar="T", help="Go on to this tick; else to where the run was to end.")
    ] = None,
    from_tick: Annotated[
        int | None, typer.Option(parser=whole(0), metavar="T", help="Fork: go on from this tick, in a folder of its own (--out).")
    ] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Fork: a value that changes from there on. Repeatable.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the fork: new or empty.")] = None,
    quiet: Quiet = False,
    threads: Threads = 1,
    report: Report = True,
) -> None:
    """Go on with a run from its last checkpoint, or fork it with changed values."""
    from ecs_eco.cli.simulate import resume_run

    resume_run(folder, until, from_tick, set_ or [], out, quiet, threads, report)


@app.command()
@exits
def train(
    world: World, ticks: Ticks = None, seed: Seed = None, set_: Set = None, out: Out = None, quiet: Quiet = False
) -> None:
    """Train a world's policies and save them."""
    from ecs_eco.cli.simulate import train_world

    train_world(world, set_ or [], ticks, seed, out, quiet)


@app.command()
@exits
def report(folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `run` left.")]) -> None:
    """Draw the figures of a run."""
    from ecs_eco.cli.simulate import report_run

    report_run(folder)


@app.command()
@exits
def lineage(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `run` left.")],
    csv: Annotated[Path | None, typer.Option(metavar="FILE", help="Write a phylogeny in the ALife standard format.")] = None,
    newick: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the tree along first parents.")] = None,
    species: Annotated[str | None, typer.Option(metavar="NAME", help="One species alone.")] = None,
    living: Annotated[bool, typer.Option("--living", help="Only the living and their ancestors in the files.")] = False,
) -> None:
    """Say and write who descends from whom in a run."""
    from ecs_eco.cli.lineage import tell_lineage

    tell_lineage(folder, csv, newick, species, living)


@app.command()
@exits
def compare(
    world: World,
    control: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME|KEY=VALUE",
            help="A control: random-policy (random-policy:deer for one species), untrained-policy, learning, "
            "frozen-learning, no-reflexes, neutral-drift, shuffled-genome, no-mutation, or a changed value. Repeatable.",
        ),
    ] = None,
    seeds: Annotated[
        int, typer.Option(parser=whole(1, 10_000), metavar="N", help="Runs of each arm, with seeds from 1.")
    ] = 8,
    ticks: Ticks = None,
    set_: Set = None,
    workers: Annotated[
        int, typer.Option(parser=whole(1, 1024), metavar="N", help="Processes, of one thread each.")
    ] = 2,
    out: Out = None,
    quiet: Quiet = False,
) -> None:
    """Compare a world with its controls."""
    from ecs_eco.cli.arms import compare_arms

    compare_arms(world, set_ or [], control or ["random-policy"], seeds, ticks, workers, out, quiet)


@app.command()
@exits
def search(
    world: World,
    range_: Annotated[
        list[str] | None, typer.Option("--range", metavar="KEY=LOW:HIGH", help="A number to vary, besides those of the file. Repeatable.")
    ] = None,
    objective: Annotated[
        str | None, typer.Option(metavar="NAME", help="persistence, cycling, population, or module:function; else as the world says.")
    ] = None,
    budget: Annotated[float | None, typer.Option(min=0.01, metavar="MINUTES", help="Time for all of it. [default: 30]")] = None,
    trials: Annotated[int | None, typer.Option(parser=whole(1), metavar="N", help="Candidates; also instead of --budget.")] = None,
    ticks: Annotated[int | None, typer.Option(parser=whole(1), metavar="N", help="Length of a whole run [ticks].")] = None,
    world_seeds: Annotated[int | None, typer.Option(parser=whole(1, 1000), metavar="N", help="World seeds of a candidate.")] = None,
    training_seeds: Annotated[int | None, typer.Option(parser=whole(1, 1000), metavar="N", help="Training seeds of a candidate.")] = None,
    policies: Annotated[
        str | None, typer.Option(metavar="NAME", help="trained, random, untrained, train (each candidate its own), train-once.")
    ] = None,
    training_ticks: Annotated[int | None, typer.Option(parser=whole(1), metavar="N", help="Length of a training [ticks].")] = None,
    confirm_world_seeds: Annotated[
        int | None, typer.Option(parser=whole(1, 1000), metavar="N", help="World seeds of the confirmation.")
    ] = None,
    confirm_training_seeds: Annotated[
        int | None, typer.Option(parser=whole(1, 1000), metavar="N", help="Training seeds of the confirmation.")
    ] = None,
    confirm_ticks: Annotated[int | None, typer.Option(parser=whole(1), metavar="N", help="Length of its runs [ticks].")] = None,
    optimiser: Annotated[str, typer.Option(metavar="NAME", help="tpe, gp, or random for comparison.")] = "tpe",
    seed: Annotated[int | None, typer.Option(parser=whole(0, 2**63 - 1), metavar="N", help="Seed of the optimiser.")] = None,
    workers: Annotated[int, typer.Option(parser=whole(1, 1024), metavar="N", help="Processes, of one thread each.")] = 2,
    set_: Set = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the results: new, empty, or of a search to go on with.")] = None,
    quiet: Quiet = False,
) -> None:
    """Search for the numbers with which a world lives."""
    from ecs_eco.cli.search import search_world

    options = {
        "objective": objective, "ticks": ticks, "world_seeds": world_seeds, "training_seeds": training_seeds, "policies": policies,
        "training_ticks": training_ticks, "confirm_world_seeds": confirm_world_seeds, "confirm_training_seeds": confirm_training_seeds,
        "confirm_ticks": confirm_ticks, "seed": seed,
    }  # fmt: skip
    search_world(world, set_ or [], range_ or [], options, budget, trials, workers, optimiser, out, quiet)


@app.command()
@exits
def draw(
    world: World,
    species: Annotated[str | None, typer.Option(metavar="NAME", help="A species; else all that have a nervous system.")] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A file ending in .png, .svg or .pdf. Default: WORLD-NAME.png here.")
    ] = None,
    set_: Set = None,
) -> None:
    """Draw the nervous systems of a world's species."""
    from ecs_eco.cli.draw import draw_world

    draw_world(world, set_ or [], species, out)


@app.command("list")
def list_() -> None:
    """List worlds, sensors, components and systems."""
    from ecs_eco.cli.listing import listing

    say(listing())


@app.command()
@exits
def check(
    world: Annotated[
        str | None, typer.Argument(metavar="WORLD", show_default=False, help="Name of a shipped world (see `list`), or a TOML file.")
    ] = None,
    set_: Set = None,
    schema: Annotated[bool, typer.Option("--schema", help="Say the JSON schema of world files instead, for editors.")] = False,
) -> None:
    """Check a world file and say what is in it."""
    from ecs_eco.cli.summary import check_world, tell_schema

    tell_schema() if schema else check_world(world, set_ or [])


def main() -> None:
    """Entry point of the command `ecs-eco`."""
    app(prog_name="ecs-eco")
