"""`ecs-eco run | watch | resume | repeat | train | report | why | lineage | compare | search | draw | picture | video | list | …`."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.terminal import exits, path_of, say, whole
from ecs_eco.cli.trust import allow

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
Out = Annotated[Path | None, typer.Option(parser=path_of, metavar="PATH", help="Folder for the results: new or empty. Default: in runs/.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]
Threads = Annotated[
    int, typer.Option(parser=whole(1, 1024), metavar="N", help="Threads; they change the speed and no result.")
]

Learn = Annotated[
    bool | None, typer.Option("--learn/--no-learn", help="Whether policies learn; else as the world says.")
]
Policies = Annotated[
    str, typer.Option(metavar="trained|random|DIR", help="What policies start from: a folder that `train` left.")
]
Watch = Annotated[
    bool, typer.Option("--watch", help="Show it in the browser meanwhile; what is done there is recorded.")
]
Port = Annotated[
    int, typer.Option(parser=whole(0, 65535), metavar="N", help="Port of the viewer on this machine; 0: any free one.")
]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Only say the viewer's address.")]
Trust = Annotated[
    bool, typer.Option("--trust", help="Allow the code of its own that it names to run here, until that changes; read it first.")
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
    learn: Learn = None,
    policies: Policies = "trained",
    report: Report = True,
    checkpoint_every: Annotated[
        int | None, typer.Option(parser=whole(1), metavar="N", help="Write a checkpoint every so many ticks.")
    ] = None,
    keep: Annotated[int, typer.Option(parser=whole(1), metavar="K", help="How many checkpoints stay.")] = 3,
    record: Annotated[
        str | None, typer.Option(metavar="focal=N|full", help="Record every tick of N organisms of each species, or of all.")
    ] = None,
    watch: Watch = False,
    port: Port = 0,
    no_browser: NoBrowser = False,
    trust: Trust = False,
) -> None:
    """Run a world and record it in a folder; `resume` goes on with it."""
    allow(trust, world, set_)
    from ecs_eco.cli.simulate import run_world

    shown = (port, not no_browser) if watch else None
    run_world(world, set_ or [], ticks, seed, out, quiet, threads, learn, policies, report, checkpoint_every, keep, shown, record)


@app.command()
@exits
def watch(
    world: Annotated[str, typer.Argument(metavar="WORLD|DIR", help="A shipped world, a TOML file, or a folder that `run` left.")],
    ticks: Annotated[
        int | None, typer.Option(parser=whole(1), metavar="N", help="It ends at this tick; absent: it lives on.")
    ] = None,
    seed: Seed = None,
    set_: Set = None,
    threads: Threads = 1,
    learn: Learn = None,
    policies: Policies = "trained",
    port: Port = 0,
    no_browser: NoBrowser = False,
    trust: Trust = False,
) -> None:
    """Watch a living world, or a recorded run, in the browser."""
    allow(trust, world, set_)
    from ecs_eco.cli.watch import watch_it

    watch_it(world, set_ or [], ticks, seed, threads, learn, policies, port, not no_browser)


@app.command()
@exits
def repeat(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `run` left.")],
    out: Annotated[Path | None, typer.Option(
        parser=path_of, metavar="PATH", help="Folder for the repetition: new or empty. Default: it is not recorded."
    )] = None,
    quiet: Quiet = False,
    threads: Threads = 1,
    trust: Trust = False,
) -> None:
    """Run a recorded run again, with all that was done to it, and say whether it comes to the same end."""
    allow(trust, folder)
    from ecs_eco.cli.simulate import repeat_run

    repeat_run(folder, out, quiet, threads)


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
    out: Annotated[Path | None, typer.Option(parser=path_of, metavar="PATH", help="Folder of the fork: new or empty.")] = None,
    quiet: Quiet = False,
    threads: Threads = 1,
    report: Report = True,
    watch: Watch = False,
    port: Port = 0,
    no_browser: NoBrowser = False,
    trust: Trust = False,
) -> None:
    """Go on with a run from its last checkpoint, or fork it with changed values."""
    allow(trust, folder)
    from ecs_eco.cli.simulate import resume_run

    shown = (port, not no_browser) if watch else None
    resume_run(folder, until, from_tick, set_ or [], out, quiet, threads, report, shown)


@app.command()
@exits
def train(
    world: World, ticks: Ticks = None, seed: Seed = None, set_: Set = None, out: Out = None, quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Train a world's policies and save them."""
    allow(trust, world, set_)
    from ecs_eco.cli.simulate import train_world

    train_world(world, set_ or [], ticks, seed, out, quiet)


@app.command()
@exits
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `run` left.")],
    out: Annotated[
        Path | None, typer.Option(parser=path_of, metavar="PATH", help="Folder for report.html and the figures. Default: DIR.")
    ] = None,
) -> None:
    """Draw the figures of a run."""
    from ecs_eco.cli.simulate import report_run

    report_run(folder, out)


@app.command()
@exits
def why(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `run` left, or that one is being recorded in.")],
    out: Annotated[
        Path | None, typer.Option(parser=path_of, metavar="PATH", help="Folder for why.html, why.json and the figure. Default: DIR.")
    ] = None,
    json_: Annotated[bool, typer.Option("--json", help="Say why.json instead of sentences.")] = False,
) -> None:
    """Say what happened to whom in a run, why, and which values act on it."""
    from ecs_eco.cli.why import tell_why

    tell_why(folder, out, json_)


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
            help="A treatment: random-policy (random-policy:deer for one species), untrained-policy, learning, "
            "frozen-learning, no-reflexes, neutral-drift, shuffled-genome, no-mutation, constant-light, inverted-light, no-smell, "
            "no-SPECIES, energy-only, energy-and-light, or a changed value. Repeatable.",
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
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path_of, metavar="PATH", help="Folder for the results: new, empty, or begun by this command. Default: in runs/."
        ),
    ] = None,
    quiet: Quiet = False,
    training_seeds: Annotated[
        int | None,
        typer.Option(parser=whole(1, 10_000), metavar="N", help="Train policies from seeds 1 to N, and run each with every seed."),
    ] = None,
    retrain: Annotated[
        bool,
        typer.Option("--retrain", help="Train anew for a treatment that changes values, under them; else it runs with the same policies."),
    ] = False,
    trust: Trust = False,
) -> None:
    """Compare a world with itself under treatments; the same command with --out DIR goes on with what was stopped."""
    allow(trust, world, set_)
    from ecs_eco.cli.compare import compare_world

    compare_world(world, set_ or [], control or ["random-policy"], seeds, ticks, workers, out, quiet, training_seeds, retrain)


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
    optimiser: Annotated[str, typer.Option(metavar="NAME", help="gp, tpe, or random for comparison.")] = "gp",
    seed: Annotated[int | None, typer.Option(parser=whole(0, 2**63 - 1), metavar="N", help="Seed of the optimiser.")] = None,
    workers: Annotated[int, typer.Option(parser=whole(1, 1024), metavar="N", help="Processes, of one thread each.")] = 2,
    set_: Set = None,
    out: Annotated[
        Path | None,
        typer.Option(parser=path_of, metavar="PATH", help="Folder for the results: new, empty, or of a search to go on with."),
    ] = None,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Search for the numbers with which a world lives."""
    allow(trust, world, set_)
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


Run = Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `run` left.")]
Size = Annotated[str, typer.Option(metavar="WIDTHxHEIGHT", help="In pixels.")]


@app.command()
@exits
def picture(
    folder: Run,
    out: Annotated[Path | None, typer.Argument(metavar="FILE", help="A PNG. Default: WORLD-TICK.png here.")] = None,
    tick: Annotated[
        int | None, typer.Option(parser=whole(0), metavar="T", help="The tick; the last one where absent.")
    ] = None,
    organism: Annotated[
        int | None, typer.Option(parser=whole(1, 2**63 - 1), metavar="UID", help="Draw the nervous system of this organism at that tick.")
    ] = None,
    size: Size = "1280x720",
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Draw a tick of a recorded run."""
    allow(trust, folder)
    from ecs_eco.cli.picture import picture_run

    picture_run(folder, out, tick, organism, size, quiet)


@app.command()
@exits
def video(
    folder: Run,
    out: Annotated[
        Path | None,
        typer.Argument(metavar="FILE", help="Ends in .mp4, .mkv, .mov or .webm, which need ffmpeg, or in .gif. Default: WORLD.mp4 here."),
    ] = None,
    fps: Annotated[float, typer.Option(metavar="N", help="Frames a second.")] = 30.0,
    from_: Annotated[int | None, typer.Option("--from", parser=whole(0), metavar="T", help="First tick.")] = None,
    to: Annotated[int | None, typer.Option(parser=whole(0), metavar="T", help="Last tick.")] = None,
    step: Annotated[
        int | None, typer.Option(parser=whole(1), metavar="N", help="Ticks from frame to frame; else a film of a minute at most.")
    ] = None,
    size: Size = "1280x720",
    quiet: Quiet = False,
) -> None:
    """Make a film of a recorded run."""
    from ecs_eco.cli.picture import video_run

    video_run(folder, out, fps, from_, to, step, size, quiet)


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
    trust: Trust = False,
) -> None:
    """Check a world file and say what is in it."""
    allow(trust, world, set_)
    from ecs_eco.cli.summary import check_world, tell_schema

    tell_schema() if schema else check_world(world, set_ or [])


@app.command()
@exits
def doctor(
    test: Annotated[bool, typer.Option("--test/--no-test", help="Run the self-test, of up to a minute.")] = True,
    quiet: Quiet = False,
) -> None:
    """Say what results depend on here, and whether they are those of the release: exit code 1 where they are not."""
    from ecs_eco.cli.doctor import examine_machine

    examine_machine(test, quiet)


def main() -> None:
    """Entry point of the command `ecs-eco`."""
    app(prog_name="ecs-eco")
